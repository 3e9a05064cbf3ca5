//! Graphs in the shared buffers: one per mesh, for all entities with that mesh.
//!
//! In: the surfaces of the cache. Out: their words in the buffers, which go when no pattern uses them any more.

use super::Tools;
use crate::{
    error::PatternError,
    field::DirectionField,
    surface::{PatternMesh, Surface, SurfaceCache, SurfaceState},
    wave::{
        arena::PatternArena,
        pack::PackedGraph,
        state::{PatternFailed, PatternState},
    },
};
use bevy::{platform::collections::HashMap, prelude::*};
use std::sync::Arc;

/// Graphs in the shared buffers, by mesh.
#[derive(Resource, Default)]
pub(crate) struct PackedGraphs {
    by_mesh: HashMap<AssetId<Mesh>, Packed>,
    /// Graphs that are no mesh's any more, but perhaps still some pattern's.
    retired: Vec<Arc<PackedGraph>>,
}

impl PackedGraphs {
    fn retire(&mut self, mesh: AssetId<Mesh>) {
        self.retired
            .extend(self.by_mesh.remove(&mesh).map(|packed| packed.graph));
    }

    /// What the graphs were written to is lost.
    pub(super) fn retire_all(&mut self) {
        self.retired
            .extend(self.by_mesh.drain().map(|(_, packed)| packed.graph));
    }

    /// Frees the graphs that no pattern uses.
    fn free_unused(&mut self, arena: &mut PatternArena) {
        self.retired.extend(
            self.by_mesh
                .extract_if(|_, packed| Arc::strong_count(&packed.graph) == 1)
                .map(|(_, packed)| packed.graph),
        );
        self.retired.retain(|graph| {
            let used = Arc::strong_count(graph) > 1;
            if !used {
                graph.free(arena);
            }
            used
        });
    }
}

struct Packed {
    graph: Arc<PackedGraph>,
    topology: u32,
    positions: u32,
}

/// The graph in the shared buffers, written when it is new or its positions have changed.
pub(super) fn pack(
    surface: &Surface,
    mesh: AssetId<Mesh>,
    tools: &mut Tools,
) -> Result<Arc<PackedGraph>, PatternError> {
    let Some(graph) = tools.graphs.get(&surface.graph) else {
        return Err(PatternError::MeshDataTaken);
    };
    match tools.packed.by_mesh.get_mut(&mesh) {
        Some(packed) if packed.topology == surface.topology => {
            if packed.positions != surface.positions {
                packed.positions = surface.positions;
                packed.graph.write_geometry(graph, &mut tools.arena);
            }
            Ok(packed.graph.clone())
        }
        _ => {
            tools.packed.retire(mesh);
            let packed = Arc::new(PackedGraph::new(graph, &mut tools.arena)?);
            let entry = Packed {
                graph: packed.clone(),
                topology: surface.topology,
                positions: surface.positions,
            };
            tools.packed.by_mesh.insert(mesh, entry);
            Ok(packed)
        }
    }
}

/// Gives back the memory of graphs whose meshes are gone, and of rigs.
pub(super) fn forget_unused(tools: &mut Tools) {
    for mesh in tools.cache.take_removed() {
        tools.packed.retire(mesh);
    }
    tools.packed.free_unused(&mut tools.arena);
    tools.rigs.free_unused(&mut tools.arena);
}

/// Asks for the graphs of meshes that are new to their entities, in the frame in which their data are still there.
pub(crate) fn request_surfaces(
    changed: Query<
        (&Mesh3d, Option<&PatternMesh>),
        (With<DirectionField>, Or<(Changed<Mesh3d>, Added<DirectionField>)>),
    >,
    mut cache: ResMut<SurfaceCache>,
) {
    for (mesh, meshes) in &changed {
        if meshes.is_none_or(|meshes| meshes.drawn != mesh.0) {
            cache.request(mesh.id());
        }
    }
}

/// Makes graphs only, for an app that renders nothing.
pub(crate) fn update_graphs(
    mut patterns: Query<(Entity, &Mesh3d, Option<&PatternMesh>, &mut PatternState), With<DirectionField>>,
    mut cache: ResMut<SurfaceCache>,
    mut commands: Commands,
) {
    cache.take_removed();
    for (entity, mesh, meshes, mut state) in &mut patterns {
        let next = match cache.request(mesh.id()) {
            SurfaceState::Preparing => PatternState::Preparing,
            SurfaceState::Failed(error) => PatternState::Failed(error),
            SurfaceState::Ready(surface) => {
                let ready = PatternMesh {
                    source: mesh.0.clone(),
                    drawn: surface.drawn,
                    graph: surface.graph,
                };
                if meshes != Some(&ready) {
                    commands.entity(entity).try_insert(ready);
                }
                PatternState::NoGpu
            }
        };
        if let PatternState::Failed(error) = &next
            && *state != next
        {
            error!("no pattern on {entity}: {error}");
            commands.trigger(PatternFailed {
                entity,
                error: error.clone(),
            });
        }
        state.set_if_neq(next);
    }
}
