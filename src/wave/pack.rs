//! A graph as words of the shared buffers, and what an entity needs of them.

use super::{
    arena::{PatternArena, Pool},
    layout::{FLAG_DISCS, LevelRecord, PatternRecord},
};
use crate::{error::PatternError, surface::SurfaceGraph};
use bevy::math::{Vec3, Vec4};
use std::ops::Range;

pub(crate) const RECORD_WORDS: u32 = (size_of::<PatternRecord>() / 4) as u32;
pub(crate) const LEVEL_WORDS: u32 = (size_of::<LevelRecord>() / 4) as u32;
/// As `STATE_WORDS` of `passes.wgsl`.
const STATE_WORDS: u32 = 8;
/// Nodes or triangles of the smallest item of work: the threads of a workgroup.
pub(crate) const ITEM: u32 = 64;

/// A graph in the shared buffers; shared by all entities with the same mesh.
#[derive(Debug, Clone)]
pub(crate) struct PackedGraph {
    pub(crate) surface: Range<u32>,
    pub(crate) geometry: Range<u32>,
    pub(crate) vertices: u32,
    pub(crate) triangles: u32,
    /// Vertices are drawn as discs.
    pub(crate) cloud: bool,
    pub(crate) levels: Vec<PackedLevel>,
}

/// One level of a packed graph: its record without the ranges that entities own, and what dispatches need to know.
#[derive(Debug, Clone)]
pub(crate) struct PackedLevel {
    pub(crate) record: LevelRecord,
    pub(crate) edges: u32,
    pub(crate) classes: Vec<u32>,
}

/// (position, area) and (normal, id) per vertex, then the half axes of discs where the graph has any, with positions,
/// normals and axes that may be elsewhere than the graph's own; the id is the bits of the graph's first mesh vertex there.
pub(crate) fn geometry(graph: &SurfaceGraph, positions: &[Vec3], normals: &[Vec3], discs: &[[Vec3; 2]]) -> Vec<Vec4> {
    let ids = graph.first_vertices();
    let mut elements = Vec::with_capacity(2 * (positions.len() + discs.len()));
    let vertices = positions.iter().zip(&graph.areas).zip(normals).zip(ids);
    for (((p, &area), n), id) in vertices {
        elements.extend([p.extend(area), n.extend(f32::from_bits(id))]);
    }
    elements.extend(discs.iter().flatten().map(|axis| axis.extend(0.0)));
    elements
}

impl PackedGraph {
    /// Writes a graph into the shared buffers.
    pub(crate) fn new(graph: &SurfaceGraph, arena: &mut PatternArena) -> Result<Self, PatternError> {
        let lists = [&graph.triangles, &graph.triangles_across];
        let mut words: Vec<u32> = lists.into_iter().flatten().flatten().copied().collect();
        let mut levels: Vec<PackedLevel> = graph
            .levels
            .iter()
            .map(|level| {
                let mut push = |list: &[u32]| {
                    words.extend_from_slice(list);
                    (words.len() - list.len()) as u32
                };
                PackedLevel {
                    record: LevelRecord {
                        nodes: level.len() as u32,
                        offset_base: push(&level.offsets),
                        neighbor_base: push(&level.neighbors),
                        parent_base: push(&level.parents),
                        child_offset_base: push(&level.child_offsets),
                        child_base: push(&level.children),
                        class_base: push(&level.classes),
                        colors: level.colors() as u32,
                        ..LevelRecord::default()
                    },
                    edges: level.neighbors.len() as u32,
                    classes: level.classes.clone(),
                }
            })
            .collect();
        let surface = arena.allocate(Pool::Surface, words.len() as u32)?;
        let geometry = match arena.allocate(Pool::Geometry, 2 * (graph.len() + graph.discs.len()) as u32) {
            Ok(range) => range,
            Err(error) => {
                arena.free(Pool::Surface, surface);
                return Err(error);
            }
        };
        for level in &mut levels {
            let record = &mut level.record;
            for base in [
                &mut record.offset_base,
                &mut record.neighbor_base,
                &mut record.parent_base,
                &mut record.child_offset_base,
                &mut record.child_base,
                &mut record.class_base,
            ] {
                *base += surface.start;
            }
        }
        arena.write(Pool::Surface, surface.start, &words);
        let packed = Self {
            surface,
            geometry,
            vertices: graph.len() as u32,
            triangles: graph.triangles.len() as u32,
            cloud: graph.is_cloud(),
            levels,
        };
        packed.write_geometry(graph, arena);
        Ok(packed)
    }

    /// Writes positions, areas and normals again.
    pub(crate) fn write_geometry(&self, graph: &SurfaceGraph, arena: &mut PatternArena) {
        arena.write(
            Pool::Geometry,
            self.geometry.start,
            &geometry(graph, &graph.positions, &graph.normals, &graph.discs),
        );
    }

    pub(crate) fn free(&self, arena: &mut PatternArena) {
        arena.free(Pool::Surface, self.surface.clone());
        arena.free(Pool::Geometry, self.geometry.clone());
    }
}

/// What an entity's ranges have room for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extent {
    /// Number of waves.
    pub(crate) waves: u32,
    /// Positions that are not the graph's own.
    pub(crate) own_geometry: bool,
    /// The momentum of the local rule.
    pub(crate) local: bool,
}

/// What one entity owns of the shared buffers.
#[derive(Debug, Clone, Default)]
pub(crate) struct PatternRanges {
    ranges: Vec<(Pool, Range<u32>)>,
    /// Word offset of the record: the entity's `MeshTag`.
    pub(crate) record: u32,
    /// Element of the wave buffer where directions begin.
    pub(crate) field: u32,
    /// Element of the geometry buffer of an entity with positions of its own.
    pub(crate) geometry: Option<u32>,
    /// Word offset of a bit per vertex, once one was needed.
    pins: Option<u32>,
}

impl PatternRanges {
    /// Allocates an entity's ranges and makes its records.
    pub(crate) fn new(
        graph: &PackedGraph,
        arena: &mut PatternArena,
        extent: Extent,
    ) -> Result<(Self, PatternRecord, Vec<LevelRecord>), PatternError> {
        let mut owned = Self::default();
        let made = owned.allocate(graph, arena, extent);
        match made {
            Ok((record, levels)) => Ok((owned, record, levels)),
            Err(error) => {
                owned.free(arena);
                Err(error)
            }
        }
    }

    /// Writes a bit per vertex; where it is.
    pub(crate) fn write_pins(&mut self, arena: &mut PatternArena, bits: &[u32]) -> Result<u32, PatternError> {
        let base = match self.pins {
            Some(base) => base,
            None => self.take(arena, Pool::Surface, bits.len() as u32)?,
        };
        self.pins = Some(base);
        arena.write(Pool::Surface, base, bits);
        Ok(base)
    }

    /// A further range, which goes with the others.
    pub(crate) fn take(&mut self, arena: &mut PatternArena, pool: Pool, len: u32) -> Result<u32, PatternError> {
        let range = arena.allocate(pool, len)?;
        self.ranges.push((pool, range.clone()));
        Ok(range.start)
    }

    fn allocate(
        &mut self,
        graph: &PackedGraph,
        arena: &mut PatternArena,
        extent: Extent,
    ) -> Result<(PatternRecord, Vec<LevelRecord>), PatternError> {
        let Extent {
            waves,
            own_geometry,
            local,
        } = extent;
        let nodes: u32 = graph.levels.iter().map(|level| waves * level.record.nodes).sum();
        let edges: u32 = graph
            .levels
            .iter()
            .enumerate()
            .map(|(n, level)| waves * edge_len(n, level))
            .sum();
        let partials = (2 * graph.vertices.div_ceil(ITEM)).max(graph.triangles.div_ceil(ITEM));
        self.record = self.take(
            arena,
            Pool::Surface,
            RECORD_WORDS + LEVEL_WORDS * graph.levels.len() as u32,
        )?;
        let momentum = if local { waves * graph.vertices } else { 0 };
        self.field = self.take(arena, Pool::Wave, 2 * graph.vertices + nodes + momentum)?;
        // Lines of curvature are laid down here, before there are edge constants.
        let laid_down = graph.levels[0].edges + 2 * graph.vertices + 1;
        let mut edge_base = self.take(arena, Pool::Edges, edges.max(laid_down))?;
        let state_base = self.take(arena, Pool::Balance, STATE_WORDS + partials + nodes)?;
        if own_geometry {
            let len = graph.geometry.end - graph.geometry.start;
            self.geometry = Some(self.take(arena, Pool::Geometry, len)?);
        }
        let mut node_base = self.field + 2 * graph.vertices;
        let mut balance_base = state_base + STATE_WORDS + partials;
        let record = PatternRecord {
            vertices: graph.vertices,
            triangles: graph.triangles,
            flags: if graph.cloud { FLAG_DISCS } else { 0 },
            levels: graph.levels.len() as u32,
            triangle_base: graph.surface.start,
            geometry_base: self.geometry.unwrap_or(graph.geometry.start),
            field_base: self.field,
            phasor_base: node_base,
            class_base: graph.levels[0].record.class_base,
            colors: graph.levels[0].record.colors,
            delta_base: node_base + nodes,
            state_base,
            waves,
            ratio: 1.0,
            ..PatternRecord::default()
        };
        let levels = graph.levels.iter().enumerate().map(|(n, level)| {
            let record = LevelRecord {
                node_base,
                edge_base,
                balance_base,
                waves,
                ..level.record
            };
            node_base += waves * record.nodes;
            balance_base += waves * record.nodes;
            edge_base += waves * edge_len(n, level);
            record
        });
        Ok((record, levels.collect()))
    }

    pub(crate) fn free(&mut self, arena: &mut PatternArena) {
        for (pool, range) in self.ranges.drain(..) {
            arena.free(pool, range);
        }
    }
}

/// Elements of the edge buffer for one wave: one per edge of the mesh, two per coarse edge.
fn edge_len(index: usize, level: &PackedLevel) -> u32 {
    if index == 0 { level.edges } else { 2 * level.edges }
}
