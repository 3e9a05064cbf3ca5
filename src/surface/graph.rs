//! The graph that all other rooms stand on.
//!
//! In: a mesh, or positions and triangles. Out: a [`SurfaceGraph`]. The steps are those of the table in
//! [`surface`](crate::surface); here they are put together.

use super::{
    adjacency::{Adjacency, triangles_across},
    cloud::CloudOptions,
    coloring::SolverOrder,
    geometry::{double_area, normals_and_areas},
    levels::coarsen,
    order::{inverse, morton_order},
    soup::{check_finite, check_indices, is_points, points, triangle_soup},
    weld::{WeldOptions, weld},
};
use crate::error::PatternError;
use bevy::prelude::*;

/// A triangle mesh, or a point cloud, seen as a graph of welded vertices, with the colours and levels that the solver needs.
///
/// Vertices are stored in **solver order**: colour class by colour class, inside a class valence by
/// valence, and along a Morton curve inside a valence.
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
    /// The triangle across each edge of each triangle, edge c being that from corner c to the next; [`NO_TRIANGLE`] at a
    /// border, and where more than two triangles share the edge.
    pub triangles_across: Vec<[u32; 3]>,
    /// The graph vertex of each vertex of the mesh. Every mesh vertex has one (unused ones are isolated vertices).
    pub vertex_of: Vec<u32>,
    /// The hierarchy, finest first. The last level has one node per connected component.
    pub levels: Vec<Level>,
    /// Of a point cloud: half axes of the square that is drawn for each vertex, tangents that are perpendicular to each
    /// other. Empty for a mesh of triangles.
    pub discs: Vec<[Vec3; 2]>,
}

/// In place of a triangle where there is none.
pub const NO_TRIANGLE: u32 = u32::MAX;

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
    /// The graph of a mesh; [`triangle_soup`] and [`from_triangles`](Self::from_triangles) in one. For a list of points
    /// [`points`] and [`from_points`](Self::from_points), with the default options.
    ///
    /// # Errors
    /// Those of the two.
    pub fn from_mesh(mesh: &Mesh, options: &WeldOptions) -> Result<Self, PatternError> {
        if is_points(mesh) {
            let cloud = points(mesh)?;
            return Self::from_points(
                &cloud.points,
                cloud.normals.as_deref(),
                options,
                &CloudOptions::default(),
            );
        }
        let soup = triangle_soup(mesh)?;
        Self::from_triangles(&soup.positions, &soup.triangles, options)
    }

    /// The graph of a triangle mesh that is given by the `positions` of its vertices and the vertices of its
    /// `triangles`, counter-clockwise. The mesh may have borders, several components and unused vertices, and any number
    /// of triangles may share an edge. The result depends on the input alone, bit by bit.
    ///
    /// Triangles without an area stay in [`triangles`](Self::triangles), but make no edge.
    ///
    /// # Errors
    /// [`NotFinite`](PatternError::NotFinite), [`IndexOutOfRange`](PatternError::IndexOutOfRange), and
    /// [`NoTriangles`](PatternError::NoTriangles) where none has an area after welding.
    pub fn from_triangles(
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        options: &WeldOptions,
    ) -> Result<Self, PatternError> {
        check_finite(positions)?;
        check_indices(triangles, positions.len())?;
        let weld = weld(positions, options);
        let welded: Vec<Vec3> = weld.first.iter().map(|&v| positions[v as usize]).collect();
        let triangles_welded = renamed(triangles, &weld.vertex_of);
        let with_area: Vec<[u32; 3]> = triangles_welded
            .iter()
            .filter(|triangle| double_area(triangle.map(|v| welded[v as usize])).is_some())
            .copied()
            .collect();
        if with_area.is_empty() {
            return Err(PatternError::NoTriangles);
        }
        let adjacency = Adjacency::from_triangles(&with_area, welded.len());
        let SolverOrder { order, classes } = SolverOrder::new(&adjacency, &morton_order(&welded));
        let finest = adjacency.into_level(&order, classes);

        let rank = inverse(&order);
        let positions: Vec<Vec3> = order.iter().map(|&v| welded[v as usize]).collect();
        let triangles = renamed(&triangles_welded, &rank);
        let vertex_of = weld.vertex_of.iter().map(|&v| rank[v as usize]).collect();
        let (normals, areas) = normals_and_areas(&positions, &triangles);
        let triangles_across = triangles_across(&triangles, positions.len());
        let levels = coarsen(finest, &positions, &areas);
        Ok(Self {
            positions,
            normals,
            areas,
            triangles,
            triangles_across,
            vertex_of,
            levels,
            discs: Vec::new(),
        })
    }

    /// Takes new positions of the mesh's own vertices, as many as there were. Positions, normals and areas are computed
    /// anew; the weld, the colours and the levels stay. A welded vertex goes where the first of its mesh vertices goes.
    /// Triangles may lose their area meanwhile. Points keep their neighbours; their normals are fitted anew. Returns whether
    /// any vertex has gone elsewhere.
    ///
    /// # Errors
    /// [`WrongLength`](PatternError::WrongLength) and [`NotFinite`](PatternError::NotFinite); the graph is unchanged then.
    pub fn update_positions(&mut self, positions: &[Vec3]) -> Result<bool, PatternError> {
        let (found, expected) = (positions.len(), self.vertex_of.len());
        if found != expected {
            return Err(PatternError::WrongLength {
                what: "positions",
                found,
                expected,
            });
        }
        check_finite(positions)?;
        let mut welded = self.positions.clone();
        // Backwards, so that the first mesh vertex of each welded vertex has the last word.
        for (&vertex, &position) in self.vertex_of.iter().zip(positions).rev() {
            welded[vertex as usize] = position;
        }
        let moved = welded != self.positions;
        self.positions = welded;
        if !moved {
            return Ok(false);
        }
        if self.is_cloud() {
            self.fit_points();
        } else {
            (self.normals, self.areas) = normals_and_areas(&self.positions, &self.triangles);
        }
        Ok(true)
    }

    /// Number of welded vertices.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether the graph has no vertex.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The first of the mesh's vertices at each graph vertex: an id that does not depend on the solver order.
    pub fn first_vertices(&self) -> Vec<u32> {
        let mut first = vec![0; self.len()];
        for (vertex, &v) in self.vertex_of.iter().enumerate().rev() {
            first[v as usize] = vertex as u32;
        }
        first
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

/// The same triangles with their corners called by new names.
fn renamed(triangles: &[[u32; 3]], names: &[u32]) -> Vec<[u32; 3]> {
    triangles
        .iter()
        .map(|triangle| triangle.map(|v| names[v as usize]))
        .collect()
}
