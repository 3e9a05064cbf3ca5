//! The life of a pattern in the main world: from the components of an entity to the work of a frame.
//!
//! In: surfaces, fields and frequencies of all entities, and what changed in them. Out: a [`Frame`] for the GPU. A
//! pattern starts cold, follows changes warm, comes to rest, and then costs nothing.

mod budget;
mod carried;
mod creases;
mod graphs;
mod inputs;
mod life;
mod live;
mod schedule;

pub(crate) use budget::{Pace, note_seen};
pub(crate) use graphs::{PackedGraphs, request_surfaces, update_graphs};
pub(crate) use inputs::{BufferWatch, watch_buffers};
pub(crate) use life::{remove_drawn, remove_pattern, restart, restore_frequency};

use super::{
    arena::{PatternArena, Pool},
    carry::CarriesPattern,
    crease::CreasePhase,
    frame::Frame,
    layout::{FLAG_READY, LevelRecord, PatternRecord},
    pack::{PackedGraph, PatternRanges},
    plan::{Member, Sweeps, Work, plan},
    pose::{PackedRigs, PatternPose, Skeletons},
    settings::{ColdStart, ValidSettings},
    state::{PatternReady, PatternState, StyleNeeds},
    status::GpuStatus,
    waves::{Coupling, Waves},
};
use crate::{
    arena::Pool as _,
    diagnostics::QualityReport,
    error::PatternError,
    field::{DirectionField, FieldTime, FieldTurn, Frequency, PatternScalars, PatternSpace, Symmetry},
    surface::{PatternMesh, SurfaceCache, SurfaceGraph},
};
use bevy::{
    diagnostic::DiagnosticsStore,
    ecs::{query::QueryData, system::SystemParam},
    math::Mat3A,
    mesh::{MeshTag, morph::MeshMorphWeights, skinning::SkinnedMesh},
    platform::collections::HashMap,
    prelude::*,
};
use budget::{Budget, in_turn};
use carried::{Carrying, Source};
use creases::Creases;
use graphs::forget_unused;
use inputs::{Sources, Surroundings};
use life::{fail, release, update_pattern};
use live::Live;
use schedule::{claim, serve};
use std::{mem::discriminant, sync::Arc};

/// The work that the render world has not taken yet.
#[derive(Resource, Default)]
pub(crate) struct Outbox(pub(crate) Frame);

/// An entity's pattern in the shared buffers; there while it has one.
#[derive(Component)]
#[component(on_discard = release)]
pub struct Pattern {
    ranges: PatternRanges,
    record: PatternRecord,
    levels: Vec<LevelRecord>,
    graph: Arc<PackedGraph>,
    topology: u32,
    geometry: u32,
    positions: u32,
    inputs: Inputs,
    /// The surface is posed on the GPU.
    live: Option<Live>,
    sources: Sources,
    /// It is another entity's.
    carrying: Option<Carrying>,
    /// What the pins in the shared buffers were made from, where there are any.
    creases: Creases,
    /// Inputs have changed, and the GPU has not brought its own up to date yet.
    behind: bool,
    /// Frames since it was served, while it has something to do.
    waited: u32,
    /// A camera or a light's shadow saw it in the frame before.
    seen: bool,
    phase: Phase,
}

/// Small inputs, compared from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Inputs {
    coupling: Coupling,
    turn: f32,
    /// The entity's linear part, where the pattern lives in the world.
    linear: Option<Mat3A>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// Directions are not there yet.
    Waiting,
    /// Must be solved from nothing.
    Cold,
    /// Follows, for so many frames after the last change.
    Warm(u32),
    /// Has so many sweeps left, and then sleeps.
    Sweeping(Sweeps),
    /// Sleeps.
    Asleep,
    /// Is another entity's.
    Carried,
}

impl Pattern {
    /// Where the pattern lies in the shared buffers, as uploaded last: for reading phasors back, or for an own pass.
    pub fn record(&self) -> &PatternRecord {
        &self.record
    }

    fn member(&self) -> Member {
        Member {
            record: self.ranges.record,
            waves: self.record.waves,
            graph: self.graph.clone(),
        }
    }

    /// Whether there are phasors, which refer to the directions that the GPU has.
    fn is_solved(&self) -> bool {
        matches!(self.phase, Phase::Warm(_) | Phase::Sweeping(_) | Phase::Asleep)
    }

    /// Gives back all memory.
    fn free(&mut self, arena: &mut PatternArena) {
        self.ranges.free(arena);
        self.sources.free(arena);
        if let Some(carrying) = &mut self.carrying {
            carrying.free(arena);
        }
    }

    fn is_drawn(&self) -> bool {
        self.record.flags & FLAG_READY != 0
    }

    fn write_record(&self, arena: &mut PatternArena) {
        arena.write(Pool::Surface, self.ranges.record, &[self.record]);
    }
}

/// All that a pattern depends on.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Patterned {
    entity: Entity,
    mesh: Ref<'static, Mesh3d>,
    field: Ref<'static, DirectionField>,
    frequency: Ref<'static, Frequency>,
    symmetry: Option<Ref<'static, Symmetry>>,
    waves: Option<Ref<'static, Waves>>,
    turn: Option<Ref<'static, FieldTurn>>,
    crease: Option<Ref<'static, CreasePhase>>,
    carries: Option<Ref<'static, CarriesPattern>>,
    space: Option<Ref<'static, PatternSpace>>,
    pose: Option<Ref<'static, PatternPose>>,
    skin: Option<&'static SkinnedMesh>,
    morph: Option<&'static MeshMorphWeights>,
    time: Option<&'static FieldTime>,
    scalars: Option<Ref<'static, PatternScalars>>,
    transform: Option<&'static GlobalTransform>,
    tag: Option<&'static MeshTag>,
    needs: Option<&'static StyleNeeds>,
    meshes: Option<&'static PatternMesh>,
    pattern: Option<&'static mut Pattern>,
    state: &'static mut PatternState,
}

/// What updating a pattern needs of the world.
#[derive(SystemParam)]
pub(crate) struct Tools<'w, 's> {
    commands: Commands<'w, 's>,
    arena: ResMut<'w, PatternArena>,
    cache: ResMut<'w, SurfaceCache>,
    packed: ResMut<'w, PackedGraphs>,
    rigs: ResMut<'w, PackedRigs>,
    skeletons: Skeletons<'w, 's>,
    graphs: Res<'w, Assets<SurfaceGraph>>,
    meshes: Res<'w, Assets<Mesh>>,
    settings: Res<'w, ValidSettings>,
    around: Surroundings<'w, 's>,
}

/// Brings every pattern up to date and collects the work of the frame.
pub(crate) fn update_patterns(
    mut patterns: Query<Patterned>,
    mut tools: Tools,
    mut outbox: ResMut<Outbox>,
    status: Res<GpuStatus>,
    report: Res<QualityReport>,
    mut pace: ResMut<Pace>,
    diagnostics: Option<Res<DiagnosticsStore>>,
    mut generation: Local<u32>,
    mut cold_start: Local<Option<ColdStart>>,
) {
    forget_unused(&mut tools);
    let device = status.generation();
    let lost = *generation != device && *generation != 0;
    *generation = device;
    // Another way to start asks for another memory layout as well.
    let restart = cold_start
        .as_ref()
        .is_some_and(|last| discriminant(last) != discriminant(&tools.settings.cold_start));
    *cold_start = Some(tools.settings.cold_start.clone());
    if lost {
        tools.packed.retire_all();
        tools.rigs.retire_all();
    }
    let mut claims = Vec::new();
    let mut carried: HashMap<Entity, Result<Option<Source>, PatternError>> = HashMap::default();
    for item in &patterns {
        let other = item.carries.as_ref().and_then(|carries| patterns.get(carries.of).ok());
        carried.extend(carried::source(&item, other).map(|source| (item.entity, source)));
    }
    for mut item in &mut patterns {
        if let Some(error) = status.error() {
            fail(&mut item, &mut tools, error);
            continue;
        }
        let fresh = lost || restart;
        let source = carried.get(&item.entity).cloned().transpose();
        let updated = source.and_then(|source| update_pattern(&mut item, source.as_ref(), &mut tools, fresh));
        match updated {
            Ok(_) if item.carries.is_some() => {
                if let Some(Ok(None)) = carried.get(&item.entity) {
                    item.state.set_if_neq(PatternState::Preparing);
                }
            }
            Ok(changed) => claims.extend(claim(&mut item, changed, &status)),
            Err(error) => {
                carried.remove(&item.entity);
                fail(&mut item, &mut tools, error);
            }
        }
    }
    let mut work = Work::default();
    let mut ready = Vec::new();
    let mut budget = Budget::new(&tools.settings, &pace);
    for claim in in_turn(claims) {
        if let Ok(mut item) = patterns.get_mut(claim.entity) {
            serve(&mut item, &mut budget, &mut work, &mut tools, &mut ready);
        }
    }
    for (entity, source) in &carried {
        if let (Ok(Some(source)), Ok(mut item)) = (source, patterns.get_mut(*entity))
            && status.is_ready()
        {
            carried::serve(&mut item, source, &mut work, &mut tools, &mut ready);
        }
    }
    if status.is_ready() {
        if status.reports() && report.0 && !work.is_empty() {
            let drawn = patterns.iter().filter_map(|item| {
                item.pattern
                    .filter(|pattern| pattern.is_drawn() && pattern.carrying.is_none())
            });
            work.reported = drawn.map(Pattern::member).collect();
        }
        plan(&work, &tools.settings, status.item(), &mut outbox.0);
        pace.learn(&outbox.0, &status, diagnostics.as_deref());
    }
    outbox.0.generation = device;
    outbox.0.uploads.extend(tools.arena.take_uploads());
    outbox.0.capacities = Pool::ALL.iter().map(|&pool| tools.arena.capacity(pool)).collect();
    for entity in ready {
        tools.commands.trigger(PatternReady { entity });
    }
}

/// Whether the app has a GPU to solve on.
pub(crate) fn renders(status: Res<GpuStatus>) -> bool {
    !status.is_absent()
}

/// What changed for a pattern in this frame.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Changed {
    /// Something it needs is not there yet.
    Waiting,
    /// Directions, frequencies or positions, written to the GPU.
    Inputs,
    /// Nothing.
    Nothing,
}
