//! Rigs in the shared buffers: one per mesh, for all entities that are posed.
//!
//! In: a mesh and its graph. Out: the fans around each vertex in the surface buffer, joints, weights and morph targets in the
//! geometry buffer, which go when no pattern uses them any more.

use super::{Rig, fans::fans};
use crate::{
    error::PatternError,
    surface::{Surface, SurfaceGraph},
    wave::arena::{PatternArena, Pool},
};
use bevy::{platform::collections::HashMap, prelude::*};
use std::{ops::Range, sync::Arc};

/// A rig in the shared buffers; names as in `PoseRecord`.
#[derive(Debug)]
pub(crate) struct PackedRig {
    surface: Range<u32>,
    geometry: Range<u32>,
    pub(crate) fan_offset_base: u32,
    pub(crate) fan_base: u32,
    /// 0 where there is no skin.
    pub(crate) skin_base: u32,
    pub(crate) target_base: u32,
    /// Number of morph targets.
    pub(crate) targets: u32,
}

impl PackedRig {
    fn new(rig: &Rig, graph: &SurfaceGraph, arena: &mut PatternArena) -> Result<Self, PatternError> {
        let fans = fans(graph);
        let moves = moves(rig);
        let surface = arena.allocate(Pool::Surface, fans.len() as u32)?;
        let geometry = match arena.allocate(Pool::Geometry, moves.len() as u32) {
            Ok(range) => range,
            Err(error) => {
                arena.free(Pool::Surface, surface);
                return Err(error);
            }
        };
        arena.write(Pool::Surface, surface.start, &fans);
        arena.write(Pool::Geometry, geometry.start, &moves);
        Ok(Self {
            fan_offset_base: surface.start,
            fan_base: surface.start + graph.len() as u32 + 1,
            skin_base: if rig.joints.is_empty() { 0 } else { geometry.start },
            target_base: geometry.start + 2 * rig.joints.len() as u32,
            targets: rig.targets(graph.len()) as u32,
            surface,
            geometry,
        })
    }

    fn is_like(&self, rig: &Rig, graph: &SurfaceGraph) -> bool {
        (self.skin_base == 0) == rig.joints.is_empty() && self.targets as usize == rig.targets(graph.len())
    }

    fn free(&self, arena: &mut PatternArena) {
        arena.free(Pool::Surface, self.surface.clone());
        arena.free(Pool::Geometry, self.geometry.clone());
    }
}

/// Joints and weights of each vertex, then its displacements, target after target.
fn moves(rig: &Rig) -> Vec<Vec4> {
    let skin = rig.joints.iter().zip(&rig.weights);
    let skin = skin.flat_map(|(joints, &weights)| [Vec4::from(joints.map(f32::from)), weights]);
    skin.chain(rig.displacements.iter().map(|d| d.extend(0.0))).collect()
}

struct Entry {
    rig: Arc<PackedRig>,
    topology: u32,
    geometry: u32,
}

/// Rigs in the shared buffers, by mesh.
#[derive(Resource, Default)]
pub(crate) struct PackedRigs {
    by_mesh: HashMap<AssetId<Mesh>, Entry>,
    /// Rigs that are no mesh's any more, but perhaps still some pattern's.
    retired: Vec<Arc<PackedRig>>,
}

impl PackedRigs {
    /// The rig of `mesh` in the shared buffers, written when it is new or the mesh has changed.
    pub(crate) fn pack(
        &mut self,
        surface: &Surface,
        id: AssetId<Mesh>,
        mesh: Option<&Mesh>,
        graph: &SurfaceGraph,
        arena: &mut PatternArena,
    ) -> Result<Arc<PackedRig>, PatternError> {
        let entry = self.by_mesh.get_mut(&id);
        if let Some(entry) = entry.filter(|entry| entry.topology == surface.topology) {
            if entry.geometry == surface.geometry {
                return Ok(entry.rig.clone());
            }
            let rig = Rig::from_mesh(mesh.ok_or(PatternError::MeshDataTaken)?, graph)?;
            if entry.rig.is_like(&rig, graph) {
                entry.geometry = surface.geometry;
                arena.write(Pool::Geometry, entry.rig.geometry.start, &moves(&rig));
                return Ok(entry.rig.clone());
            }
        }
        let rig = Rig::from_mesh(mesh.ok_or(PatternError::MeshDataTaken)?, graph)?;
        let entry = Entry {
            rig: Arc::new(PackedRig::new(&rig, graph, arena)?),
            topology: surface.topology,
            geometry: surface.geometry,
        };
        let rig = entry.rig.clone();
        self.retired.extend(self.by_mesh.insert(id, entry).map(|old| old.rig));
        Ok(rig)
    }

    /// What the rigs were written to is lost.
    pub(crate) fn retire_all(&mut self) {
        self.retired.extend(self.by_mesh.drain().map(|(_, entry)| entry.rig));
    }

    /// Frees the rigs that no pattern uses.
    pub(crate) fn free_unused(&mut self, arena: &mut PatternArena) {
        let unused = self.by_mesh.extract_if(|_, entry| Arc::strong_count(&entry.rig) == 1);
        self.retired.extend(unused.map(|(_, entry)| entry.rig));
        self.retired.retain(|rig| {
            let used = Arc::strong_count(rig) > 1;
            if !used {
                rig.free(arena);
            }
            used
        });
    }
}
