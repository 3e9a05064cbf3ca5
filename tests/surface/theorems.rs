//! What holds for the graph of every mesh.

use crate::meshes::*;
use bevy::prelude::*;
use bevy_field_patterns::surface::*;
use std::collections::BTreeSet;

/// Every vertex of another colour joins the nearest of its neighbours of colour 0.
fn assert_nearest_roots(name: &str, graph: &SurfaceGraph) {
    let level = graph.mesh_level();
    if level.parents.is_empty() {
        return;
    }
    let root_of = |i: usize| level.children[level.child_offsets[level.parents[i] as usize] as usize];
    for i in level.classes[1] as usize..level.len() {
        let distance = |v: u32| {
            graph.positions[i]
                .as_dvec3()
                .distance(graph.positions[v as usize].as_dvec3())
        };
        let neighbors = level.edges(i).map(|k| level.neighbors[k]);
        let nearest = neighbors
            .filter(|&v| v < level.classes[1])
            .map(distance)
            .fold(f64::INFINITY, f64::min);
        assert_eq!(
            distance(root_of(i)),
            nearest,
            "{name}: vertex {i} joins the nearest root"
        );
    }
}

/// Number of connected components, by union-find over the triangles that have an area in exact arithmetic.
fn components(nodes: usize, edges: impl Iterator<Item = (u32, u32)>) -> usize {
    fn find(parent: &[u32], mut a: u32) -> u32 {
        while parent[a as usize] != a {
            a = parent[a as usize];
        }
        a
    }
    let mut parent: Vec<u32> = (0..nodes as u32).collect();
    for (a, b) in edges {
        let (a, b) = (find(&parent, a), find(&parent, b));
        parent[a as usize] = b;
    }
    (0..nodes).filter(|&i| parent[i] == i as u32).count()
}

fn area_of(corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    (b - a).cross(c - a).length() / 2.0
}

/// The directed edges that a mesh should have, from its definition.
fn expected_edges(graph: &SurfaceGraph) -> BTreeSet<(u32, u32)> {
    let has_area = |t: &&[u32; 3]| area_of(t.map(|v| graph.positions[v as usize])) > 0.0;
    let sides = |&[a, b, c]: &[u32; 3]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)];
    graph.triangles.iter().filter(has_area).flat_map(sides).collect()
}

fn directed_edges(level: &Level) -> Vec<(u32, u32)> {
    (0..level.len())
        .flat_map(|i| level.edges(i).map(move |k| (i as u32, level.neighbors[k])))
        .collect()
}

fn assert_graph_and_colors(name: &str, level: &Level) {
    let edges = directed_edges(level);
    assert!(
        edges.is_sorted_by(|a, b| a < b),
        "{name}: neighbours are ascending and unique"
    );
    let set: BTreeSet<_> = edges.iter().copied().collect();
    assert!(
        edges.iter().all(|&(a, b)| a != b && set.contains(&(b, a))),
        "{name}: symmetric, without loops"
    );

    assert_eq!(level.classes.first(), Some(&0), "{name}");
    assert_eq!(
        level.classes.last(),
        Some(&(level.len() as u32)),
        "{name}: every node has a colour"
    );
    assert!(level.classes.is_sorted_by(|a, b| a < b), "{name}: no class is empty");
    let color = |node: u32| level.classes.partition_point(|&begin| begin <= node) - 1;
    assert!(
        edges.iter().all(|&(a, b)| color(a) != color(b)),
        "{name}: neighbours differ in colour"
    );
    for node in level.classes[1]..level.len() as u32 {
        let colors: BTreeSet<usize> = level
            .edges(node as usize)
            .map(|k| color(level.neighbors[k]))
            .filter(|&c| c < color(node))
            .collect();
        assert_eq!(colors.len(), color(node), "{name}: first fit, so colour 0 is maximal");
    }
}

fn assert_aggregates(name: &str, fine: &Level, coarse: &Level) {
    assert!(coarse.len() < fine.len(), "{name}: each level is smaller");
    assert_eq!(fine.parents.len(), fine.len(), "{name}");
    assert_eq!(fine.child_offsets.len(), coarse.len() + 1, "{name}");
    let mut children = fine.children.clone();
    children.sort_unstable();
    assert!(
        children.iter().copied().eq(0..fine.len() as u32),
        "{name}: every node is a child once"
    );
    for parent in 0..coarse.len() {
        let range = fine.child_offsets[parent] as usize..fine.child_offsets[parent + 1] as usize;
        let [root, others @ ..] = &fine.children[range] else {
            panic!("{name}: no parent is childless")
        };
        assert!(*root < fine.classes[1], "{name}: roots have colour 0");
        assert_eq!(fine.parents[*root as usize], parent as u32, "{name}");
        for &child in others {
            assert_eq!(fine.parents[child as usize], parent as u32, "{name}");
            let neighbors = &fine.neighbors[fine.edges(child as usize)];
            assert!(
                neighbors.binary_search(root).is_ok(),
                "{name}: a root touches all its children"
            );
        }
    }
    let parent = |node: u32| fine.parents[node as usize];
    let lifted: BTreeSet<_> = directed_edges(fine)
        .into_iter()
        .map(|(a, b)| (parent(a), parent(b)))
        .filter(|(a, b)| a != b)
        .collect();
    assert!(
        directed_edges(coarse).into_iter().eq(lifted),
        "{name}: coarse edges are the fine ones between aggregates"
    );
}

#[test]
fn every_graph_keeps_its_invariants() {
    for (name, mesh) in zoo() {
        let soup = triangle_soup(&mesh).expect("a valid mesh");
        let graph = graph_of(&mesh);
        assert_eq!(graph, graph_of(&mesh), "{name}: deterministic, bit by bit");

        assert_eq!(graph.triangles.len(), soup.triangles.len(), "{name}");
        for (corner, vertex) in graph.triangles.as_flattened().iter().zip(soup.triangles.as_flattened()) {
            assert_eq!(
                *corner, graph.vertex_of[*vertex as usize],
                "{name}: triangles keep their drawing order"
            );
        }
        for (vertex, position) in graph.vertex_of.iter().zip(&soup.positions) {
            assert_eq!(graph.positions[*vertex as usize], *position, "{name}");
        }
        let distinct: BTreeSet<_> = graph.positions.iter().map(|p| p.to_array().map(f32::to_bits)).collect();
        assert_eq!(
            distinct.len(),
            graph.len(),
            "{name}: welded vertices have different positions"
        );

        let edges = expected_edges(&graph);
        assert!(
            directed_edges(graph.mesh_level()).into_iter().eq(edges.iter().copied()),
            "{name}: edges"
        );
        for (i, level) in graph.levels.iter().enumerate() {
            assert_graph_and_colors(&format!("{name}, level {i}"), level);
        }
        for (i, pair) in graph.levels.windows(2).enumerate() {
            assert_aggregates(&format!("{name}, level {i}"), &pair[0], &pair[1]);
        }
        assert_nearest_roots(&name, &graph);
        assert_eq!(
            graph.components(),
            components(graph.len(), edges.into_iter()),
            "{name}: components"
        );
        assert!(
            graph
                .levels
                .last()
                .is_some_and(|top| top.neighbors.is_empty() && top.parents.is_empty()),
            "{name}"
        );
        assert!(graph.levels.len() <= 24, "{name}: {} levels", graph.levels.len());

        let area: f64 = graph.areas.iter().copied().map(f64::from).sum();
        let corners = |t: &[u32; 3]| t.map(|v| graph.positions[v as usize]);
        let expected: f64 = graph.triangles.iter().map(corners).map(area_of).sum();
        assert!(
            (area - expected).abs() <= 1e-5 * expected,
            "{name}: area {area} instead of {expected}"
        );
        assert!(graph.normals.iter().all(|n| n.is_normalized()), "{name}: unit normals");
    }
}
