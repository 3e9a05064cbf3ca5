//! The hierarchy: ever coarser graphs, down to one node per connected component.
//!
//! In: the coloured graph of the mesh with positions and areas. Out: its levels. The roots of the aggregates are the
//! nodes of colour 0, a maximal independent set; every other node joins the nearest root among its neighbours, so that
//! a root touches all its children. Aggregates are neighbours where an edge leads from one to the other. About every
//! fourth node of a mesh is a root. The hierarchy is one of graphs: coarse nodes have positions here only to decide who
//! is nearest and to be stored along a Morton curve.

use super::{
    adjacency::Adjacency,
    coloring::SolverOrder,
    graph::Level,
    order::{group, inverse, morton_order},
};
use bevy::{math::DVec3, prelude::*};

/// Builds all levels on top of the finest one, whose `parents` and `children` are still empty.
pub(super) fn coarsen(finest: Level, positions: &[Vec3], areas: &[f32]) -> Vec<Level> {
    let mut levels = Vec::new();
    let mut level = finest;
    let mut nodes = Nodes {
        positions: positions.to_vec(),
        areas: areas.iter().map(|&a| f64::from(a)).collect(),
    };
    while !level.neighbors.is_empty() {
        let aggregates = Aggregates::new(&level, &nodes.positions);
        nodes = nodes.joined(&aggregates);
        let adjacency = aggregates.adjacency(&level);
        let SolverOrder { order, classes } = SolverOrder::new(&adjacency, &morton_order(&nodes.positions));
        let coarser = adjacency.into_level(&order, classes);

        aggregates.store(&order, &mut level);
        nodes = nodes.reordered(&order);
        levels.push(std::mem::replace(&mut level, coarser));
    }
    levels.push(level);
    levels
}

/// Where the nodes of a level are and how large.
struct Nodes {
    positions: Vec<Vec3>,
    areas: Vec<f64>,
}

impl Nodes {
    /// The aggregates as nodes: mean position of the members, weighted by area, and total area.
    fn joined(&self, aggregates: &Aggregates) -> Self {
        let (mut positions, mut areas) = (Vec::new(), Vec::new());
        for root in 0..aggregates.len() {
            let members = || aggregates.members(root).iter().map(|&node| node as usize);
            let area: f64 = members().map(|node| self.areas[node]).sum();
            let moment: DVec3 = members()
                .map(|node| self.areas[node] * self.positions[node].as_dvec3())
                .sum();
            positions.push(if area > 0.0 {
                (moment / area).as_vec3()
            } else {
                self.positions[root]
            });
            areas.push(area);
        }
        Self { positions, areas }
    }

    fn reordered(&self, order: &[u32]) -> Self {
        Self {
            positions: order.iter().map(|&node| self.positions[node as usize]).collect(),
            areas: order.iter().map(|&node| self.areas[node as usize]).collect(),
        }
    }
}

/// A partition of a level's nodes, numbered like their roots, which are the nodes of colour 0.
struct Aggregates {
    /// The root of each node; a root's own is itself.
    root_of: Vec<u32>,
    /// `offsets[r]..offsets[r + 1]` are the entries of `members` with root r; ascending, hence the root first.
    offsets: Vec<u32>,
    members: Vec<u32>,
}

impl Aggregates {
    fn new(level: &Level, positions: &[Vec3]) -> Self {
        let roots = level.classes[1];
        let root_of: Vec<u32> = (0..level.len() as u32)
            .map(|node| {
                if node < roots {
                    node
                } else {
                    nearest_root(level, positions, node, roots)
                }
            })
            .collect();
        let (offsets, members) = group(&root_of, roots as usize);
        Self {
            root_of,
            offsets,
            members,
        }
    }

    fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    fn members(&self, root: usize) -> &[u32] {
        &self.members[self.offsets[root] as usize..self.offsets[root + 1] as usize]
    }

    /// Aggregates are neighbours where an edge of `level` joins them.
    fn adjacency(&self, level: &Level) -> Adjacency {
        let mut adjacency = Adjacency {
            offsets: vec![0],
            neighbors: Vec::new(),
        };
        // The aggregate that last took each aggregate as its neighbour.
        let mut taken_by = vec![u32::MAX; self.len()];
        for root in 0..self.len() as u32 {
            taken_by[root as usize] = root;
            for &member in self.members(root as usize) {
                for &neighbor in &level.neighbors[level.edges(member as usize)] {
                    let other = self.root_of[neighbor as usize];
                    if std::mem::replace(&mut taken_by[other as usize], root) != root {
                        adjacency.neighbors.push(other);
                    }
                }
            }
            adjacency.offsets.push(adjacency.neighbors.len() as u32);
        }
        adjacency
    }

    /// Writes the partition into `level`, with the coarser nodes in their final `order`.
    fn store(self, order: &[u32], level: &mut Level) {
        let rank = inverse(order);
        level.parents = self.root_of.iter().map(|&root| rank[root as usize]).collect();
        level.child_offsets = vec![0];
        for &root in order {
            level.children.extend_from_slice(self.members(root as usize));
            level.child_offsets.push(level.children.len() as u32);
        }
    }
}

/// The neighbour of colour 0 that is nearest to `node`, the first of them at equal distance.
fn nearest_root(level: &Level, positions: &[Vec3], node: u32, roots: u32) -> u32 {
    // Neighbours are ascending, so those of colour 0 come first. There is one: colour 0 is maximal.
    let neighbors = &level.neighbors[level.edges(node as usize)];
    let position = positions[node as usize].as_dvec3();
    let mut nearest = (f64::INFINITY, node);
    for &root in neighbors.iter().take_while(|&&neighbor| neighbor < roots) {
        let distance = position.distance_squared(positions[root as usize].as_dvec3());
        if distance < nearest.0 {
            nearest = (distance, root);
        }
    }
    nearest.1
}
