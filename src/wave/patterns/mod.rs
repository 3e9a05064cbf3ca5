//! The life of a pattern in the main world: from the components of an entity to the work of a frame.
//!
//! In: surfaces, fields and frequencies of all entities, and what changed in them. Out: a [`Frame`] for the GPU. A
//! pattern starts cold, follows changes warm, comes to rest, and then costs nothing.

mod graphs;
mod inputs;
mod life;
mod live;
mod schedule;

pub(crate) use graphs::{PackedGraphs, request_surfaces, update_graphs};
pub(crate) use life::{remove_pattern, restart};

use super::{
    arena::{PatternArena, Pool},
    frame::Frame,
    layout::{FLAG_READY, LevelRecord, PatternRecord},
    pack::{PackedGraph, PatternRanges},
    plan::{Member, Work, plan},
    pose::{PackedRigs, PatternPose, Skeletons},
    settings::{ColdStart, ValidSettings},
    state::{NeedsVector, PatternReady, PatternState},
    status::GpuStatus,
};
use crate::{
    arena::Pool as _,
    diagnostics::QualityReport,
    error::PatternError,
    field::{DirectionField, FieldTurn, Frequency, PatternSpace, Symmetry},
    surface::{PatternMesh, SurfaceCache, SurfaceGraph},
};
use bevy::{
    ecs::{query::QueryData, system::SystemParam},
    math::Mat3A,
    mesh::{MeshTag, morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
    tasks::Task,
};
use graphs::forget_unused;
use life::{fail, release, update_pattern};
use live::Live;
use schedule::schedule;
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
    inputs: Inputs,
    /// The surface is posed on the GPU.
    live: Option<Live>,
    /// Directions as last uploaded; empty where the GPU makes them.
    directions: Vec<Vec3>,
    /// Directions were uploaded, and the GPU has not taken them yet.
    uploaded: bool,
    task: Option<Task<Result<Directions, PatternError>>>,
    /// The inputs have changed since the task began.
    outdated: bool,
    phase: Phase,
}

/// Directions, and what they mean.
struct Directions {
    vectors: Vec<Vec3>,
    symmetry: Symmetry,
}

/// Small inputs, compared from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Inputs {
    symmetry: Symmetry,
    turn: f32,
    /// The entity's linear part, where the pattern lives in the world and the surface is not posed on the GPU.
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
    /// Sleeps.
    Asleep,
}

impl Pattern {
    /// Where the pattern lies in the shared buffers, as uploaded last: for reading phasors back, or for an own pass.
    pub fn record(&self) -> &PatternRecord {
        &self.record
    }

    fn member(&self) -> Member {
        Member {
            record: self.ranges.record,
            graph: self.graph.clone(),
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
    turn: Option<Ref<'static, FieldTurn>>,
    space: Option<Ref<'static, PatternSpace>>,
    pose: Option<Ref<'static, PatternPose>>,
    skin: Option<&'static SkinnedMesh>,
    morph: Option<&'static MeshMorphWeights>,
    transform: Option<&'static GlobalTransform>,
    tag: Option<&'static MeshTag>,
    needs_vector: Option<&'static NeedsVector>,
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
}

/// Brings every pattern up to date and collects the work of the frame.
pub(crate) fn update_patterns(
    mut patterns: Query<Patterned>,
    mut tools: Tools,
    mut outbox: ResMut<Outbox>,
    status: Res<GpuStatus>,
    report: Res<QualityReport>,
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
    let mut work = Work::default();
    let mut ready = Vec::new();
    for mut item in &mut patterns {
        if let Some(error) = status.error() {
            fail(&mut item, &mut tools, error);
            continue;
        }
        let fresh = lost || restart;
        match update_pattern(&mut item, &mut tools, fresh) {
            Ok(changed) => schedule(&mut item, changed, &status, &mut work, &mut tools, &mut ready),
            Err(error) => fail(&mut item, &mut tools, error),
        }
    }
    if status.is_ready() {
        if status.reports() && report.0 && !work.is_empty() {
            let drawn = patterns
                .iter()
                .filter_map(|item| item.pattern.filter(|pattern| pattern.is_drawn()));
            work.reported = drawn.map(Pattern::member).collect();
        }
        plan(&work, &tools.settings, status.item(), &mut outbox.0);
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
