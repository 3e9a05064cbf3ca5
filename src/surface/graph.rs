//! The graph that all other rooms stand on.

use bevy::prelude::*;

/// A triangle mesh seen as a graph of welded vertices, with the colours and levels that the solver needs.
///
/// Vertices are stored in **solver order**: colour class by colour class, along a Morton curve inside a class.
/// Every per-vertex array of a pattern (directions, frequencies, phasors) is in this order; [`vertex_of`](Self::vertex_of)
/// leads from the mesh's own vertices to it.
#[derive(Asset, TypePath, Debug, Clone, Default, PartialEq)]
pub struct SurfaceGraph {
    /// Position of each vertex, in the mesh's units.
    pub positions: Vec<Vec3>,
    /// Unit normal of each vertex, weighted by the angles of its triangles; `Vec3::Z` where they cancel.
    pub normals: Vec<Vec3>,
    /// A third of the area of the adjacent triangles, per vertex.
    pub areas: Vec<f32>,
    /// The three graph vertices of each drawn triangle, in drawing order, degenerate ones included.
    pub triangles: Vec<[u32; 3]>,
    /// The graph vertex of each vertex of the mesh. Every mesh vertex has one (unused ones are isolated vertices).
    pub vertex_of: Vec<u32>,
    /// The hierarchy, finest first. The last level has one node per connected component.
    pub levels: Vec<Level>,
}

/// One level of the hierarchy: a graph in CSR form, its colours, and how it aggregates into the next coarser level.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Level {
    /// `offsets[i]..offsets[i + 1]` are the directed edges into node `i`; `len = nodes + 1`.
    pub offsets: Vec<u32>,
    /// Source node of each directed edge; ascending inside a node, without the node itself, without duplicates.
    /// The graph is symmetric.
    pub neighbors: Vec<u32>,
    /// `classes[c]..classes[c + 1]` are the nodes of colour `c`; no two of them are neighbours. Colour 0 is a maximal
    /// independent set: every other node has a neighbour in it.
    pub classes: Vec<u32>,
    /// The coarser node that each node belongs to; empty on the last level.
    pub parents: Vec<u32>,
    /// `child_offsets[p]..child_offsets[p + 1]` are the entries of [`children`](Self::children) of the *next* level's
    /// node `p`; empty on the last level.
    pub child_offsets: Vec<u32>,
    /// Nodes of this level, grouped by parent, the root (a node of colour 0, neighbour of all its siblings) first.
    pub children: Vec<u32>,
}

impl Level {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether the level has no node.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of colours.
    pub fn colors(&self) -> usize {
        self.classes.len().saturating_sub(1)
    }

    /// The directed edges into node `i`, as a range of [`neighbors`](Self::neighbors).
    pub fn edges(&self, i: usize) -> std::ops::Range<usize> {
        self.offsets[i] as usize..self.offsets[i + 1] as usize
    }
}

impl SurfaceGraph {
    /// Number of welded vertices.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether the graph has no vertex.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The finest level: the surface's own edges.
    pub fn mesh_level(&self) -> &Level {
        &self.levels[0]
    }

    /// Number of connected components, isolated vertices included.
    pub fn components(&self) -> usize {
        self.levels.last().map_or(0, Level::len)
    }
}
