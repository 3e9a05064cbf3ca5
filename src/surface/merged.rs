//! The hierarchy of merged vertices: ever coarser surfaces, each with about half the vertices of the one before.
//!
//! In: a graph. Out: graphs of merged vertices with positions, normals and areas of their own, as W. Jakob et al.,
//! *Instant Field-Aligned Meshes* (2015), make them, and Lichtenberg et al. 2018 use them (section 3.4). Neighbours merge
//! in pairs, first those whose normals agree best and whose areas differ most: `⟨n_i, n_j⟩ max(A_i / A_j, A_j / A_i)`; a
//! vertex without a partner stays as it is.
//!
//! The levels of [`SurfaceGraph::levels`] are better for waves; these are for comparison.

use super::{
    adjacency::Adjacency,
    coloring::SolverOrder,
    graph::SurfaceGraph,
    order::{inverse, morton_order},
};
use bevy::{math::DVec3, prelude::*};

/// A coarser surface.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedSurface {
    /// Its vertices and their neighbours: one level, no triangles, and every vertex as its own mesh vertex.
    pub graph: SurfaceGraph,
    /// `parents[i]` is the vertex that vertex i of the finer surface has become a part of.
    pub parents: Vec<u32>,
}

impl SurfaceGraph {
    /// At most `levels` surfaces of merged vertices, the finest first; fewer where nothing is left to merge.
    pub fn merged(&self, levels: u32) -> Vec<MergedSurface> {
        let mut surfaces: Vec<MergedSurface> = Vec::new();
        for _ in 0..levels {
            let finer = surfaces.last().map_or(self, |surface| &surface.graph);
            let merged = merge(finer);
            if merged.graph.len() == finer.len() {
                break;
            }
            surfaces.push(merged);
        }
        surfaces
    }
}

fn merge(finer: &SurfaceGraph) -> MergedSurface {
    let (group_of, groups) = pairs(finer);
    let mut members = vec![Vec::new(); groups];
    for (i, &group) in group_of.iter().enumerate() {
        members[group as usize].push(i);
    }
    let area = |members: &[usize]| members.iter().map(|&i| f64::from(finer.areas[i])).sum::<f64>();
    // Without areas all count alike.
    let mean = |members: &[usize], value: &dyn Fn(usize) -> DVec3| {
        let total = area(members);
        let weight = |i: usize| {
            if total > 0.0 {
                f64::from(finer.areas[i]) / total
            } else {
                1.0 / members.len() as f64
            }
        };
        members.iter().map(|&i| weight(i) * value(i)).sum::<DVec3>()
    };
    let positions: Vec<Vec3> = members
        .iter()
        .map(|members| mean(members, &|i| finer.positions[i].as_dvec3()).as_vec3())
        .collect();
    let level = finer.mesh_level();
    let edges = (0..level.len()).flat_map(|i| level.edges(i).map(move |k| (i, k)));
    let between = edges
        .map(|(i, k)| [group_of[i], group_of[level.neighbors[k] as usize]])
        .filter(|[a, b]| a < b);
    let adjacency = Adjacency::from_pairs(between, groups);
    let SolverOrder { order, classes } = SolverOrder::new(&adjacency, &morton_order(&positions));
    let rank = inverse(&order);
    let in_order = || order.iter().map(|&group| &members[group as usize][..]);
    let normal = |members: &[usize]| {
        mean(members, &|i| finer.normals[i].as_dvec3())
            .normalize_or(DVec3::Z)
            .as_vec3()
    };
    let graph = SurfaceGraph {
        positions: order.iter().map(|&group| positions[group as usize]).collect(),
        normals: in_order().map(normal).collect(),
        areas: in_order()
            .map(|members| area(members).min(f64::from(f32::MAX)) as f32)
            .collect(),
        vertex_of: (0..order.len() as u32).collect(),
        levels: vec![adjacency.into_level(&order, classes)],
        ..default()
    };
    MergedSurface {
        graph,
        parents: group_of.iter().map(|&group| rank[group as usize]).collect(),
    }
}

/// The group of each vertex, of one or two, and the number of groups.
fn pairs(graph: &SurfaceGraph) -> (Vec<u32>, usize) {
    let level = graph.mesh_level();
    let mut edges = Vec::with_capacity(level.neighbors.len() / 2);
    for i in 0..level.len() {
        for j in level
            .edges(i)
            .map(|k| level.neighbors[k] as usize)
            .take_while(|&j| j < i)
        {
            let areas = [graph.areas[i], graph.areas[j]].map(|area| area.max(f32::MIN_POSITIVE));
            let ratio = (areas[0] / areas[1]).max(areas[1] / areas[0]);
            edges.push((graph.normals[i].dot(graph.normals[j]) * ratio, i, j));
        }
    }
    // Stable: equal ones stay in the order of their vertices.
    edges.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut group_of = vec![u32::MAX; graph.len()];
    let mut groups = 0;
    for (_, i, j) in edges {
        if group_of[i] == u32::MAX && group_of[j] == u32::MAX {
            (group_of[i], group_of[j]) = (groups, groups);
            groups += 1;
        }
    }
    for group in group_of.iter_mut().filter(|group| **group == u32::MAX) {
        *group = groups;
        groups += 1;
    }
    (group_of, groups as usize)
}
