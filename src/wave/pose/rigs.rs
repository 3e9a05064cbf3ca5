//! Rigs in the shared buffers: one per mesh, for all entities that are posed.
//!
//! In: a mesh and its graph. Out: the corners around each vertex, joints, weights and morph targets as words of the surface
//! buffer, which go when no pattern uses them any more.

use super::Rig;
use crate::{
    error::PatternError,
    surface::{Surface, SurfaceGraph},
    wave::arena::{PatternArena, Pool},
};
use bevy::{platform::collections::HashMap, prelude::*};
use std::{ops::Range, sync::Arc};

/// A rig in the surface buffer; names as in `PoseRecord`.
#[derive(Debug)]
pub(crate) struct PackedRig {
    range: Range<u32>,
    pub(crate) corner_offset_base: u32,
    pub(crate) corner_base: u32,
    /// 0 where there is no skin.
    pub(crate) skin_base: u32,
    pub(crate) target_base: u32,
    /// Number of morph targets.
    pub(crate) targets: u32,
}

impl PackedRig {
    fn new(rig: &Rig, graph: &SurfaceGraph, arena: &mut PatternArena) -> Result<Self, PatternError> {
        let corners = corners(graph);
        let moves = moves(rig);
        let range = arena.allocate(Pool::Surface, (corners.len() + moves.len()) as u32)?;
        arena.write(Pool::Surface, range.start, &corners);
        let after = range.start + corners.len() as u32;
        arena.write(Pool::Surface, after, &moves);
        let skin = (SKIN_WORDS * rig.joints.len()) as u32;
        Ok(Self {
            corner_offset_base: range.start,
            corner_base: range.start + graph.len() as u32 + 1,
            skin_base: if skin > 0 { after } else { 0 },
            target_base: after + skin,
            targets: rig.targets(graph.len()) as u32,
            range,
        })
    }

    fn is_like(&self, rig: &Rig, graph: &SurfaceGraph) -> bool {
        (self.skin_base == 0) == rig.joints.is_empty() && self.targets as usize == rig.targets(graph.len())
    }

    fn free(&self, arena: &mut PatternArena) {
        arena.free(Pool::Surface, self.range.clone());
    }
}

const SKIN_WORDS: usize = 6;

/// Joints and weights, six words per vertex, then displacements, three per vertex and target.
fn moves(rig: &Rig) -> Vec<u32> {
    let pair = |a: u16, b: u16| u32::from(a) | u32::from(b) << 16;
    let skin = rig.joints.iter().zip(&rig.weights).flat_map(|(j, w)| {
        let [x, y, z, w] = w.to_array().map(f32::to_bits);
        [pair(j[0], j[1]), pair(j[2], j[3]), x, y, z, w]
    });
    let targets = rig.displacements.iter().flat_map(|d| d.to_array().map(f32::to_bits));
    skin.chain(targets).collect()
}

/// The corners 3 t + c of triangles around each vertex: offsets, one more than there are vertices, then corners.
fn corners(graph: &SurfaceGraph) -> Vec<u32> {
    let corners = graph.triangles.as_flattened();
    let vertices = graph.len();
    let mut words = vec![0; vertices + 1 + corners.len()];
    let (offsets, sorted) = words.split_at_mut(vertices + 1);
    for &v in corners {
        offsets[v as usize + 1] += 1;
    }
    for v in 0..vertices {
        offsets[v + 1] += offsets[v];
    }
    let mut next = offsets[..vertices].to_vec();
    for (&v, corner) in corners.iter().zip(0..) {
        let at = &mut next[v as usize];
        sorted[*at as usize] = corner;
        *at += 1;
    }
    words
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
                let first = entry.rig.corner_base + 3 * graph.triangles.len() as u32;
                arena.write(Pool::Surface, first, &moves(&rig));
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
