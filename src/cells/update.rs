//! The life of cells in the main world: from an entity's components to the shared buffers.
//!
//! In: sample sets, values and meshes of all entities that draw cells, and what changed in them. Out: uploads, the mesh
//! that is drawn, the entity's tag, and its [`CellState`].

use super::{
    CellState, DrawCells, SampleValues, check_samples,
    layout::CellArena,
    memory::{CellMemory, Unseen},
    planar_mesh,
    upload::{Outbox, UploadStatus},
};
use crate::{
    error::PatternError,
    field::DirectionField,
    sampling::{SampleSet, SamplingState},
    surface::{PatternMesh, SurfaceCache, SurfaceGraph, SurfaceState},
};
use bevy::{
    ecs::{query::QueryData, system::SystemParam},
    mesh::MeshTag,
    prelude::*,
};

/// All that cells depend on.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct Celled {
    entity: Entity,
    set: Ref<'static, SampleSet>,
    values: Option<Ref<'static, SampleValues>>,
    sampling: Option<&'static SamplingState>,
    mesh: Option<&'static Mesh3d>,
    mesh_2d: Option<&'static Mesh2d>,
    tag: Option<&'static MeshTag>,
    meshes: Option<&'static PatternMesh>,
    memory: Option<&'static mut CellMemory>,
    state: &'static mut CellState,
    has_field: Has<DirectionField>,
}

/// What updating cells needs of the world.
#[derive(SystemParam)]
pub(super) struct Tools<'w, 's> {
    commands: Commands<'w, 's>,
    arena: ResMut<'w, CellArena>,
    cache: ResMut<'w, SurfaceCache>,
    graphs: Res<'w, Assets<SurfaceGraph>>,
    meshes: ResMut<'w, Assets<Mesh>>,
}

/// Asks for the surfaces of meshes that are new to their entities, in the frame in which their data are still there.
pub(super) fn request_surfaces(
    changed: Query<
        (&Mesh3d, Option<&PatternMesh>),
        (
            With<DrawCells>,
            With<SampleSet>,
            Or<(Changed<Mesh3d>, Added<SampleSet>, Added<DrawCells>)>,
        ),
    >,
    mut cache: ResMut<SurfaceCache>,
) {
    for (mesh, meshes) in &changed {
        if meshes.is_none_or(|meshes| meshes.drawn != mesh.0) {
            cache.request(mesh.id());
        }
    }
}

/// Every entity with cells has a state.
pub(super) fn give_state(
    new: Query<Entity, (With<DrawCells>, With<SampleSet>, Without<CellState>)>,
    mut commands: Commands,
) {
    for entity in &new {
        commands.entity(entity).try_insert(CellState::default());
    }
}

/// Brings the cells of every entity up to date.
pub(super) fn update_cells(
    mut cells: Query<Celled, With<DrawCells>>,
    mut tools: Tools,
    mut outbox: ResMut<Outbox>,
    status: Res<UploadStatus>,
    mut generation: Local<u32>,
) {
    // What was on an earlier device is gone.
    let lost = *generation != status.generation() && *generation != 0;
    *generation = status.generation();
    for mut item in &mut cells {
        let next = match update(&mut item, &mut tools, lost) {
            Ok(true) => CellState::Ready,
            Ok(false) => CellState::Preparing,
            Err(error) => fail(&mut item, &mut tools, error),
        };
        item.state.set_if_neq(next);
    }
    outbox.take_from(&mut tools.arena);
}

/// Whether the cells are drawn.
fn update(item: &mut CelledItem, tools: &mut Tools, lost: bool) -> Result<bool, PatternError> {
    note_changes(item);
    if item.has_field {
        return Err(PatternError::TwoPatterns);
    }
    if tag_is_taken(item) {
        return Err(PatternError::MeshTagTaken);
    }
    let ground = ground(item, tools)?.filter(|ground| !belongs_elsewhere(item, ground));
    let Some(ground) = ground else {
        if let Some(memory) = &item.memory {
            memory.hide(&mut tools.arena);
        }
        return Ok(false);
    };
    let (unseen, installed) = match &item.memory {
        Some(memory) => {
            let set = memory.unseen.set || memory.drawn != ground.drawn || lost;
            // Values belong to their set.
            let values = memory.unseen.values || set;
            let tagged = item.tag.is_some_and(|tag| tag.0 == memory.tag());
            (
                Unseen { set, values },
                tagged && shown_mesh(item) == Some(&ground.drawn),
            )
        }
        None => (
            Unseen {
                set: true,
                values: true,
            },
            false,
        ),
    };
    if !unseen.values && installed {
        return match &*item.state {
            CellState::Failed(error) => Err(error.clone()),
            _ => Ok(true),
        };
    }
    let (written, new, tag) = match item.memory.take() {
        Some(mut memory) => {
            let written = write(&mut memory, item, unseen, &ground, tools);
            let tag = memory.tag();
            item.memory = Some(memory);
            (written, None, tag)
        }
        None => {
            let mut memory = CellMemory::new(&mut tools.arena)?;
            let written = write(&mut memory, item, unseen, &ground, tools);
            let tag = memory.tag();
            (written, Some(memory), tag)
        }
    };
    if !installed {
        install(item, new, tag, ground, tools);
    }
    written.map(|()| true)
}

/// Remembers changes that come while there is nothing to draw them on.
fn note_changes(item: &mut CelledItem) {
    if let Some(memory) = &mut item.memory {
        memory.unseen.set |= item.set.is_changed();
        memory.unseen.values |= item.values.is_some() != memory.had_values
            || item.values.as_ref().is_some_and(|values| values.is_changed());
    }
}

/// The samples are those of another mesh, and those of this one are being made.
fn belongs_elsewhere(item: &CelledItem, ground: &PatternMesh) -> bool {
    let sampling = item
        .sampling
        .is_some_and(|state| matches!(state, SamplingState::Preparing | SamplingState::Sampling(_)));
    sampling && item.memory.as_ref().is_some_and(|memory| memory.drawn != ground.drawn)
}

/// Checks and uploads what has changed; what cannot be drawn is hidden.
fn write(
    memory: &mut CellMemory,
    item: &CelledItem,
    unseen: Unseen,
    ground: &PatternMesh,
    tools: &mut Tools,
) -> Result<(), PatternError> {
    memory.drawn = ground.drawn.clone();
    memory.unseen = Unseen::default();
    memory.had_values = item.values.is_some();
    memory.stale |= unseen.set;
    if item.set.is_empty() {
        memory.hide(&mut tools.arena);
        return Ok(());
    }
    let written = (|| {
        let set_too = memory.stale;
        if set_too {
            check_samples(&item.set)?;
            check_seeds(item, ground, tools)?;
            memory.write_set(&item.set, &mut tools.arena)?;
            memory.stale = false;
        }
        if set_too || unseen.values {
            memory.write_values(item.values.as_deref(), &mut tools.arena)?;
        }
        memory.write_record(&mut tools.arena);
        Ok(())
    })();
    if written.is_err() {
        memory.hide(&mut tools.arena);
    }
    written
}

/// A set on a surface has seeds for every triangle of it.
fn check_seeds(item: &CelledItem, ground: &PatternMesh, tools: &Tools) -> Result<(), PatternError> {
    if item.mesh.is_none() {
        return Ok(());
    }
    let graph = tools.graphs.get(&ground.graph).ok_or(PatternError::MeshDataTaken)?;
    let (found, expected) = (item.set.seeds.len(), graph.triangles.len());
    if found != expected {
        let what = "seeds of triangles";
        return Err(PatternError::SampleLists { what, found, expected });
    }
    Ok(())
}

/// The tag belongs to the user. That of a cloned entity is nobody's.
fn tag_is_taken(item: &CelledItem) -> bool {
    let cloned = item.meshes.is_some() && item.memory.is_none();
    let own = item.memory.as_ref().map(|memory| memory.tag());
    item.tag.is_some_and(|tag| tag.0 != 0 && own != Some(tag.0)) && !cloned
}

fn shown_mesh<'a>(item: &'a CelledItem) -> Option<&'a Handle<Mesh>> {
    match (item.mesh, item.mesh_2d) {
        (Some(mesh), _) => Some(&mesh.0),
        (None, Some(mesh)) => Some(&mesh.0),
        (None, None) => None,
    }
}

/// The user's mesh, what is drawn of it and its graph; `None` while there is none. A planar set is its own mesh.
fn ground(item: &CelledItem, tools: &mut Tools) -> Result<Option<PatternMesh>, PatternError> {
    let shown = shown_mesh(item).ok_or(PatternError::NoMesh)?;
    let own = item.meshes.filter(|meshes| meshes.drawn == *shown);
    let source = own.map_or(shown, |meshes| &meshes.source).clone();
    if item.mesh.is_none() {
        return Ok(Some(planar_ground(item, source, tools)));
    }
    match tools.cache.request(source.id()) {
        SurfaceState::Ready(surface) => Ok(Some(PatternMesh {
            source,
            drawn: surface.drawn,
            graph: surface.graph,
        })),
        SurfaceState::Preparing => Ok(None),
        SurfaceState::Failed(error) => {
            if own.is_some() {
                // What is drawn must be the user's mesh, not a copy of what it was.
                tools.commands.entity(item.entity).try_insert(Mesh3d(source));
            }
            Err(error)
        }
    }
}

fn planar_ground(item: &CelledItem, source: Handle<Mesh>, tools: &mut Tools) -> PatternMesh {
    let drawn = match &item.memory {
        Some(memory) => {
            if memory.unseen.set && tools.meshes.insert(&memory.drawn, planar_mesh(&item.set)).is_err() {
                error!("the mesh of {}'s samples is gone", item.entity);
            }
            memory.drawn.clone()
        }
        None => tools.meshes.add(planar_mesh(&item.set)),
    };
    let graph = Handle::default();
    PatternMesh { source, drawn, graph }
}

/// Gives the entity its tag and the mesh that is drawn, and its memory if that is new.
fn install(item: &CelledItem, new: Option<CellMemory>, tag: u32, ground: PatternMesh, tools: &mut Tools) {
    let (entity, planar) = (item.entity, item.mesh.is_none());
    tools
        .commands
        .queue(move |world: &mut World| match world.get_entity_mut(entity) {
            Ok(mut entity) if entity.contains::<SampleSet>() => {
                let drawn = ground.drawn.clone();
                entity.insert((MeshTag(tag), ground));
                if planar {
                    entity.insert(Mesh2d(drawn));
                } else {
                    entity.insert(Mesh3d(drawn));
                }
                if let Some(memory) = new {
                    entity.insert(memory);
                }
            }
            _ => {
                if let Some(mut memory) = new {
                    memory.free(&mut world.resource_mut::<CellArena>());
                }
            }
        });
}

/// Says once why cells cannot be drawn, and draws the base material.
fn fail(item: &mut CelledItem, tools: &mut Tools, error: PatternError) -> CellState {
    let failed = CellState::Failed(error.clone());
    if *item.state != failed {
        error!("no cells on {}: {error}", item.entity);
        if let Some(memory) = &item.memory {
            memory.hide(&mut tools.arena);
        }
    }
    if error == PatternError::TwoPatterns && item.memory.is_some() {
        // The wave takes mesh and tag over.
        tools.commands.entity(item.entity).try_remove::<CellMemory>();
    }
    failed
}

/// An entity without samples, or whose material draws no cells, has its own mesh and no tag.
pub(super) fn remove_cells<C: Component>(
    event: On<Remove, C>,
    cells: Query<(&PatternMesh, Has<Mesh3d>), With<CellMemory>>,
    mut commands: Commands,
) {
    let Ok(mut entity) = commands.get_entity(event.entity) else {
        return;
    };
    entity.try_remove::<CellState>();
    if let Ok((meshes, in_space)) = cells.get(event.entity) {
        if in_space {
            entity.try_insert(Mesh3d(meshes.source.clone()));
        } else {
            entity.try_insert(Mesh2d(meshes.source.clone()));
        }
        entity.try_remove::<(CellMemory, MeshTag, PatternMesh)>();
    }
}
