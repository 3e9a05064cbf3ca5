//! The life of a pattern: it is made when its mesh and its field are there, made anew when these are others, fails, and
//! goes with its entity or its field.

use super::{
    Changed, Creases, Inputs, Pattern, PatternedItem, Phase, Tools,
    carried::Source,
    creases::update_creases,
    graphs::pack,
    inputs::{self, update_inputs},
    live::{Live, Rigged},
};
use crate::{
    error::PatternError,
    field::{DirectionField, Frequency, PatternSpace, Symmetry},
    surface::{PatternMesh, Surface, SurfaceState},
    wave::{
        arena::{PatternArena, Pool},
        layout::FLAG_READY,
        pack::{Extent, PackedGraph, PatternRanges, RECORD_WORDS},
        pose::{JOINT, MORPH_WEIGHT},
        settings::ColdStart,
        state::{PatternFailed, PatternState, RestartPattern},
        waves::{Coupling, Waves},
    },
};
use bevy::{
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    mesh::MeshTag,
    prelude::*,
};
use std::sync::Arc;

/// In [`PatternError::SettingNotFinite`].
const TRANSFORM: &str = "the entity's GlobalTransform";

impl Pattern {
    fn new(
        graph: Arc<PackedGraph>,
        surface: &Surface,
        inputs: Inputs,
        rigged: Option<Rigged>,
        tools: &mut Tools,
    ) -> Result<Self, PatternError> {
        let extent = Extent {
            waves: inputs.coupling.waves.count() as u32,
            own_geometry: inputs.linear.is_some() || rigged.is_some(),
            local: matches!(tools.settings.cold_start, ColdStart::Local(_)),
        };
        let (mut ranges, mut record, levels) = PatternRanges::new(&graph, &mut tools.arena, extent)?;
        let live = rigged.map(|rigged| Live::new(rigged, &graph, &mut ranges, &mut tools.arena));
        let live = live.transpose().inspect_err(|_| ranges.free(&mut tools.arena))?;
        record.pose_base = live.as_ref().map_or(0, Live::base);
        let pattern = Self {
            ranges,
            record,
            levels,
            graph,
            topology: surface.topology,
            geometry: surface.geometry,
            positions: surface.positions,
            inputs,
            live,
            sources: default(),
            carrying: None,
            creases: Creases::default(),
            behind: false,
            waited: 0,
            seen: false,
            phase: Phase::Waiting,
        };
        pattern.write_record(&mut tools.arena);
        let levels = pattern.ranges.record + RECORD_WORDS;
        tools.arena.write(Pool::Surface, levels, &pattern.levels);
        Ok(pattern)
    }
}

pub(super) fn update_pattern(
    item: &mut PatternedItem,
    carried: Option<&Option<Source>>,
    tools: &mut Tools,
    fresh: bool,
) -> Result<Changed, PatternError> {
    let waves = item.waves.as_ref().map_or_else(Waves::default, |waves| **waves);
    waves.check()?;
    let symmetry = match (waves, &item.symmetry) {
        // Which of its waves a phase belongs to is told apart no better than by a line.
        (Waves::Cross, _) => Symmetry::Line,
        (_, Some(symmetry)) => **symmetry,
        (_, None) => item.field.default_symmetry(),
    };
    let (coupling, source) = match carried {
        None => (Coupling { waves, symmetry }, None),
        Some(Some(source)) => (source.coupling, Some(source)),
        // The surface is made meanwhile.
        Some(None) => (Coupling::default(), None),
    };
    let waves = coupling.waves;
    if let Some(needs) = item.needs {
        needs.check(coupling)?;
    }
    // What a style refused starts anew once the style or the field allows it.
    let refused = matches!(
        &*item.state,
        PatternState::Failed(
            PatternError::NeedsVectorSymmetry(_) | PatternError::NeedsTwoWaves(_) | PatternError::NeedsBothWaves(_)
        )
    );
    let fresh = fresh || refused;
    let touched = item.mesh.is_changed()
        || item.field.is_changed()
        || item.frequency.is_changed()
        || item.symmetry.as_ref().is_some_and(|symmetry| symmetry.is_changed())
        || item.waves.as_ref().is_some_and(|waves| waves.is_changed())
        || item.turn.as_ref().is_some_and(|turn| turn.is_changed())
        || item.crease.as_ref().is_some_and(|crease| crease.is_changed())
        // The other entity may be well again.
        || carried.is_some()
        || item.crease.is_none() && is_crease_error(&item.state)
        || item.space.as_ref().is_some_and(|space| space.is_changed())
        || item.pose.as_ref().is_some_and(|pose| pose.is_changed())
        || item.scalars.as_ref().is_some_and(|scalars| scalars.is_changed())
        || item
            .pattern
            .as_ref()
            .is_some_and(|pattern| item.scalars.is_none() && pattern.sources.has_scalars())
        || inputs::look_around(item)
        || matches!(&*item.state, PatternState::Failed(error) if may_pass(error));
    let own_mesh = item.meshes.is_some_and(|meshes| meshes.drawn == item.mesh.0);
    if !own_mesh && let Some(pattern) = item.pattern.as_mut() {
        // The pattern belongs to the mesh that was there before.
        pattern.phase = Phase::Waiting;
        if pattern.is_drawn() {
            pattern.record.flags &= !FLAG_READY;
            pattern.write_record(&mut tools.arena);
        }
    }
    let source_mesh = match item.meshes {
        Some(meshes) if own_mesh => meshes.source.clone(),
        _ => item.mesh.0.clone(),
    };
    let surface = match tools.cache.request(source_mesh.id()) {
        SurfaceState::Ready(surface) => surface,
        SurfaceState::Preparing => return Ok(Changed::Waiting),
        SurfaceState::Failed(error) => {
            if own_mesh {
                // What is drawn must be the user's mesh, not a copy of what it was.
                tools.commands.entity(item.entity).try_insert(Mesh3d(source_mesh));
            }
            return Err(error);
        }
    };
    if let PatternState::Failed(error) = &*item.state
        && !touched
        && !fresh
        && item
            .pattern
            .as_ref()
            .is_none_or(|pattern| pattern.geometry == surface.geometry)
    {
        return Err(error.clone());
    }
    if matches!(carried, Some(None)) {
        return Ok(Changed::Waiting);
    }
    let graph = pack(&surface, source_mesh.id(), tools)?;
    let in_world = item.space.as_ref().is_some_and(|space| **space == PatternSpace::World);
    let rigged = Rigged::of(item, &surface, source_mesh.id(), in_world, tools)?;
    let linear = match source {
        // In the space of the points.
        Some(source) => source.linear,
        None => item
            .transform
            .filter(|_| in_world)
            .map(|transform| transform.affine().matrix3),
    };
    if linear.is_some_and(|linear| !linear.is_finite()) {
        return Err(PatternError::SettingNotFinite(TRANSFORM));
    }
    let inputs = Inputs {
        coupling,
        turn: item.turn.as_ref().map_or(0.0, |turn| turn.0),
        linear,
    };
    let current = item.pattern.as_ref().is_some_and(|pattern| {
        let same_memory = match (&pattern.live, &rigged) {
            (Some(live), Some(rigged)) => live.fits(rigged),
            (live, rigged) => live.is_none() && rigged.is_none(),
        };
        pattern.topology == surface.topology
            && pattern.carrying.is_some() == carried.is_some()
            && same_memory
            && pattern.inputs.linear.is_some() == linear.is_some()
            && pattern.inputs.coupling.waves.count() == waves.count()
    });
    if !current || fresh || !own_mesh {
        // The tag of a cloned pattern is nobody's.
        let cloned = item.meshes.is_some() && item.pattern.is_none();
        let taken = item.tag.is_some_and(|tag| {
            tag.0 != 0
                && !cloned
                && item
                    .pattern
                    .as_ref()
                    .is_none_or(|pattern| pattern.ranges.record != tag.0)
        });
        if taken {
            return Err(PatternError::MeshTagTaken);
        }
        let mut pattern = Pattern::new(graph, &surface, inputs, rigged.clone(), tools)?;
        pattern.carrying = carried.map(|_| default());
        // Bad input leaves a pattern that waits for a better one.
        let updated = update_creases(&mut pattern, item, &surface, tools).and_then(|_| {
            update_inputs(
                &mut pattern,
                item,
                &surface,
                inputs,
                source_mesh.id(),
                rigged,
                tools,
                true,
            )
        });
        let tag = pattern.ranges.record;
        let meshes = PatternMesh {
            source: source_mesh.clone(),
            drawn: surface.drawn.clone(),
            graph: surface.graph.clone(),
        };
        if let Some(old) = item.pattern.as_mut() {
            old.phase = Phase::Waiting;
            old.record.flags &= !FLAG_READY;
        }
        let (entity, drawn) = (item.entity, Mesh3d(surface.drawn.clone()));
        tools.commands.queue(move |world: &mut World| {
            match world.get_entity_mut(entity) {
                // Insertion replaces the old pattern, whose hook gives back its ranges.
                Ok(mut entity) if entity.contains::<DirectionField>() => {
                    entity.insert((pattern, MeshTag(tag), drawn, meshes));
                }
                _ => pattern.free(&mut world.resource_mut::<PatternArena>()),
            }
        });
        updated?;
        item.state.set_if_neq(PatternState::Preparing);
        return Ok(Changed::Waiting);
    }
    let Some(mut pattern) = item.pattern.take() else {
        return Ok(Changed::Waiting);
    };
    let creased = update_creases(&mut pattern, item, &surface, tools);
    let changed = update_inputs(
        &mut pattern,
        item,
        &surface,
        inputs,
        source_mesh.id(),
        rigged,
        tools,
        false,
    );
    let carrying = source.map_or(Ok(()), |source| pattern.update_carrying(source, &surface, tools));
    item.pattern = Some(pattern);
    carrying?;
    match (changed?, creased?) {
        (Changed::Nothing, true) => Ok(Changed::Inputs),
        (changed, _) => Ok(changed),
    }
}

/// The entity has failed because of a [`CreasePhase`](crate::wave::CreasePhase), which may be gone since.
fn is_crease_error(state: &PatternState) -> bool {
    matches!(state, PatternState::Failed(PatternError::OutOfRange { what, .. }) if what.starts_with("CreasePhase"))
}

/// What may be over without a change that is seen.
fn may_pass(error: &PatternError) -> bool {
    match error {
        PatternError::MeshTagTaken => true,
        PatternError::NotFinite { what, .. } => [JOINT, MORPH_WEIGHT].contains(what),
        PatternError::SettingNotFinite(what) => *what == TRANSFORM,
        _ => false,
    }
}

/// Says once why a pattern cannot be drawn, and draws the base material.
pub(super) fn fail(item: &mut PatternedItem, tools: &mut Tools, error: PatternError) {
    // By what is said: an error about a value that is not a number does not equal itself.
    let text = error.to_string();
    if matches!(&*item.state, PatternState::Failed(known) if known.to_string() == text) {
        return;
    }
    *item.state = PatternState::Failed(error.clone());
    error!("no pattern on {}: {text}", item.entity);
    if let Some(pattern) = item.pattern.as_mut() {
        pattern.record.flags &= !FLAG_READY;
        pattern.phase = Phase::Waiting;
        pattern.write_record(&mut tools.arena);
    }
    tools.commands.trigger(PatternFailed {
        entity: item.entity,
        error,
    });
}

/// Solves a pattern from nothing.
pub(crate) fn restart(event: On<RestartPattern>, mut patterns: Query<&mut Pattern>) {
    if let Ok(mut pattern) = patterns.get_mut(event.entity)
        && pattern.is_solved()
    {
        pattern.phase = Phase::Cold;
    }
}

/// An entity without a field has its own mesh and no pattern.
pub(crate) fn remove_pattern(
    event: On<Remove, DirectionField>,
    patterns: Query<(Option<&PatternMesh>, Has<Pattern>)>,
    mut commands: Commands,
) {
    let (Ok((meshes, has_pattern)), Ok(mut entity)) = (patterns.get(event.entity), commands.get_entity(event.entity))
    else {
        return;
    };
    entity.try_remove::<PatternState>();
    if has_pattern {
        entity.try_remove::<(Pattern, MeshTag)>();
    }
    if let Some(meshes) = meshes {
        entity.try_insert(Mesh3d(meshes.source.clone()));
        entity.try_remove::<PatternMesh>();
    }
}

/// An entity without a mesh has a field, which waits for another mesh, and no pattern.
pub(crate) fn remove_drawn(event: On<Remove, Mesh3d>, states: Query<&PatternState>, mut commands: Commands) {
    if states.contains(event.entity)
        && let Ok(mut entity) = commands.get_entity(event.entity)
    {
        entity.try_remove::<(Pattern, MeshTag, PatternMesh)>();
        entity.try_insert(PatternState::Preparing);
    }
}

/// A field whose frequency is taken away has the default one.
pub(crate) fn restore_frequency(event: On<Remove, Frequency>, mut commands: Commands) {
    let entity = event.entity;
    commands.queue(move |world: &mut World| {
        if let Ok(mut entity) = world.get_entity_mut(entity)
            && entity.contains::<DirectionField>()
        {
            entity.insert_if_new(Frequency::default());
        }
    });
}

pub(super) fn release(mut world: DeferredWorld, context: HookContext) {
    let Some(mut pattern) = world.get_mut::<Pattern>(context.entity) else {
        return;
    };
    let (mut ranges, mut sources, carrying) = (
        std::mem::take(&mut pattern.ranges),
        std::mem::take(&mut pattern.sources),
        pattern.carrying.take(),
    );
    if let Some(mut arena) = world.get_resource_mut::<PatternArena>() {
        ranges.free(&mut arena);
        sources.free(&mut arena);
        if let Some(mut carrying) = carrying {
            carrying.free(&mut arena);
        }
    }
}
