//! The surface room: what holds for the graph of every mesh, and what becomes of unusual meshes.

use bevy::{
    asset::RenderAssetUsages,
    math::primitives::{Cuboid, Plane3d, Sphere, Torus},
    mesh::{Indices, Mesh, PrimitiveTopology, VertexAttributeValues, morph::MorphAttributes},
    prelude::*,
};
use bevy_field_patterns::{error::PatternError, surface::*};
use std::{collections::BTreeSet, time::Instant};

const EXACT: WeldOptions = WeldOptions { tolerance: 0.0 };

// ---------------------------------------------------------------------------------------------------------------------
// Meshes

fn mesh_of(topology: PrimitiveTopology, positions: Vec<Vec3>, indices: Option<Indices>) -> Mesh {
    let mesh = Mesh::new(topology, RenderAssetUsages::default());
    let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    match indices {
        Some(indices) => mesh.with_inserted_indices(indices),
        None => mesh,
    }
}

fn list_of(positions: &[Vec3], triangles: &[[u32; 3]]) -> Mesh {
    let indices = Indices::U32(triangles.as_flattened().to_vec());
    mesh_of(PrimitiveTopology::TriangleList, positions.to_vec(), Some(indices))
}

/// A small deterministic generator, so that the tests need no crate for it.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(n)) as u32
    }

    fn unit(&mut self) -> f32 {
        self.below(1 << 24) as f32 / (1 << 24) as f32
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }
}

/// Any triangles between any vertices: non-manifold in every way, with degenerate and unused parts.
fn random_triangles(seed: u64, vertices: u32, triangles: u32) -> Mesh {
    let mut random = Random(seed);
    let positions: Vec<Vec3> = (0..vertices).map(|_| random.point()).collect();
    let triangles: Vec<[u32; 3]> = (0..triangles)
        .map(|_| [(); 3].map(|()| random.below(vertices)))
        .collect();
    list_of(&positions, &triangles)
}

/// A disk of triangles around vertex 0.
fn fan(valence: u32) -> Mesh {
    let rim = (0..valence).map(|i| Vec2::from_angle(i as f32 / valence as f32 * std::f32::consts::TAU).extend(0.0));
    let positions: Vec<Vec3> = std::iter::once(Vec3::ZERO).chain(rim).collect();
    let triangles: Vec<[u32; 3]> = (0..valence).map(|i| [0, i + 1, (i + 1) % valence + 1]).collect();
    list_of(&positions, &triangles)
}

/// Triangles that share one edge.
fn book(pages: u32) -> Mesh {
    let leaves = (0..pages).map(|i| Vec2::from_angle(i as f32).extend(0.5));
    let positions: Vec<Vec3> = [Vec3::ZERO, Vec3::Z].into_iter().chain(leaves).collect();
    let triangles: Vec<[u32; 3]> = (0..pages).map(|i| [0, 1, i + 2]).collect();
    list_of(&positions, &triangles)
}

/// A band of `n` quads with a half turn.
fn moebius(n: u32) -> Mesh {
    let point = |i: u32, side: f32| {
        let (turn, half) = (
            i as f32 / n as f32 * std::f32::consts::TAU,
            i as f32 / n as f32 * std::f32::consts::PI,
        );
        let radius = 1.0 + side * half.cos();
        Vec3::new(radius * turn.cos(), radius * turn.sin(), side * half.sin())
    };
    let positions: Vec<Vec3> = (0..n).flat_map(|i| [point(i, -0.3), point(i, 0.3)]).collect();
    let triangles: Vec<[u32; 3]> = (0..n)
        .flat_map(|i| {
            let (a, b) = (2 * i, 2 * i + 1);
            // The last quad meets the first one upside down.
            let (c, d) = if i + 1 == n { (1, 0) } else { (2 * i + 2, 2 * i + 3) };
            [[a, c, b], [b, c, d]]
        })
        .collect();
    list_of(&positions, &triangles)
}

fn two_triangles_at_a_point() -> Mesh {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y];
    list_of(&positions, &[[0, 1, 2], [0, 3, 4]])
}

fn scaled(mesh: &Mesh, scale: f32) -> Mesh {
    mesh.clone().scaled_by(Vec3::splat(scale))
}

fn merged(mut mesh: Mesh, other: &Mesh) -> Mesh {
    mesh.merge(other).expect("both are lists with the same attributes");
    mesh
}

fn plane(subdivisions: u32) -> Mesh {
    Plane3d::default()
        .mesh()
        .size(2.0, 3.0)
        .subdivisions(subdivisions)
        .build()
}

fn zoo() -> Vec<(String, Mesh)> {
    let sphere = Sphere::new(1.0).mesh().ico(12).expect("below the limit");
    let mut zoo = vec![
        ("cuboid".into(), Cuboid::default().mesh().build()),
        ("torus".into(), Torus::default().mesh().build()),
        ("uv sphere".into(), Sphere::new(2.0).mesh().uv(32, 18)),
        ("plane with a border".into(), plane(30)),
        ("tiny sphere".into(), scaled(&sphere, 1e-12)),
        ("huge sphere".into(), scaled(&sphere, 1e12)),
        (
            "two components".into(),
            merged(sphere.clone(), &sphere.clone().translated_by(Vec3::X * 5.0)),
        ),
        ("sphere".into(), sphere),
        (
            "one triangle".into(),
            list_of(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]]),
        ),
        ("three faces on an edge".into(), book(3)),
        ("book".into(), book(2000)),
        ("pinched vertex".into(), two_triangles_at_a_point()),
        ("moebius strip".into(), moebius(24)),
        ("fan".into(), fan(500)),
        (
            "isolated vertex, zero-area and duplicate triangles".into(),
            list_of(
                &[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE, Vec3::X * 0.5, Vec3::X],
                &[[0, 1, 2], [0, 1, 2], [2, 1, 0], [0, 0, 2], [0, 4, 1], [1, 5, 2]],
            ),
        ),
    ];
    zoo.extend((0..20).map(|seed| {
        (
            format!("soup {seed}"),
            random_triangles(seed, 60, 40 + 20 * seed as u32),
        )
    }));
    zoo.extend((20..23).map(|seed| (format!("dense soup {seed}"), random_triangles(seed, 40, 4000))));
    zoo
}

fn graph_of(mesh: &Mesh) -> SurfaceGraph {
    SurfaceGraph::from_mesh(mesh, &EXACT).expect("a valid mesh")
}

// ---------------------------------------------------------------------------------------------------------------------
// Theorems

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

#[test]
fn meshes_need_few_colors_and_levels() {
    for n in [20, 60] {
        let graph = graph_of(&Sphere::new(1.0).mesh().ico(n).expect("below the limit"));
        assert!(
            graph.mesh_level().colors() <= 7,
            "{} colours",
            graph.mesh_level().colors()
        );
        let nodes: usize = graph.levels.iter().map(Level::len).sum();
        assert!(
            nodes < graph.len() * 14 / 10,
            "{nodes} nodes above {} vertices",
            graph.len()
        );
        assert_eq!(graph.components(), 1);
    }
}

#[test]
fn normals_and_areas_are_those_of_the_surface() {
    for scale in [1e-12, 1e-3, 1.0, 1e12] {
        let graph = graph_of(&scaled(
            &Sphere::new(1.0).mesh().ico(20).expect("below the limit"),
            scale,
        ));
        for (position, normal) in graph.positions.iter().zip(&graph.normals) {
            assert!(
                position.normalize_or_zero().dot(*normal) > 0.9999 || scale < 1e-10,
                "{position} {normal}"
            );
            assert!(
                (position / scale).normalize().dot(*normal) > 0.9999,
                "{position} {normal}"
            );
        }
        let area: f32 = graph.areas.iter().map(|a| a / scale / scale).sum();
        assert!((area - 4.0 * std::f32::consts::PI).abs() < 0.05, "area {area}");
    }
    // A cube's corner sees three right angles, however its faces are cut into triangles.
    let cube = graph_of(&Cuboid::default().mesh().build());
    assert_eq!(cube.len(), 8);
    for (position, normal) in cube.positions.iter().zip(&cube.normals) {
        assert!(normal.distance(position.normalize()) < 1e-6);
    }
    // Both sides of a leaf cancel.
    let leaf = graph_of(&list_of(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2], [0, 2, 1]]));
    assert_eq!(leaf.normals, [Vec3::Z; 3]);
    assert!(leaf.areas.iter().all(|a| (a - 1.0 / 3.0).abs() < 1e-6));
}

// ---------------------------------------------------------------------------------------------------------------------
// Meshes of all makes

#[test]
fn index_formats_and_topologies_give_the_same_graph() {
    let positions: Vec<Vec3> = (0..10)
        .map(|i| Vec3::new((i / 2) as f32, (i % 2) as f32, 0.0))
        .collect();
    let triangles: Vec<[u32; 3]> = (0..8)
        .map(|i| {
            if i % 2 == 0 {
                [i, i + 1, i + 2]
            } else {
                [i, i + 2, i + 1]
            }
        })
        .collect();
    let flat = triangles.as_flattened();
    let expected = triangle_soup(&list_of(&positions, &triangles)).expect("a valid mesh");
    assert_eq!(expected.triangles, triangles);

    let list = PrimitiveTopology::TriangleList;
    let strip = PrimitiveTopology::TriangleStrip;
    let u16s = Indices::U16(flat.iter().map(|&i| i as u16).collect());
    let incomplete = Indices::U32(flat.iter().copied().chain([0, 1]).collect());
    for mesh in [
        mesh_of(list, positions.clone(), Some(u16s)),
        mesh_of(list, positions.clone(), Some(incomplete)),
        mesh_of(strip, positions.clone(), None),
        mesh_of(strip, positions.clone(), Some(Indices::U16((0..10).collect()))),
        mesh_of(strip, positions.clone(), Some(Indices::U32((0..10).collect()))),
    ] {
        assert_eq!(triangle_soup(&mesh), Ok(expected.clone()));
        assert!(
            graph_of(&mesh).normals.iter().all(|n| n.z < -0.999_99),
            "all triangles face the same way"
        );
    }
    let corners: Vec<Vec3> = flat.iter().map(|&i| positions[i as usize]).collect();
    let unshared = graph_of(&mesh_of(list, corners, None));
    assert_eq!(
        (unshared.len(), unshared.components()),
        (10, 1),
        "a mesh without indices is welded"
    );
}

#[test]
fn restart_begins_a_new_strip() {
    let positions: Vec<Vec3> = (0..8).map(|i| Vec3::new((i / 2) as f32, (i % 2) as f32, 0.0)).collect();
    let strip = PrimitiveTopology::TriangleStrip;
    let expected = vec![[0, 1, 2], [4, 5, 6], [5, 7, 6]];
    let u16s = vec![0, 1, 2, u16::MAX, 3, u16::MAX, u16::MAX, 4, 5, 6, 7, u16::MAX];
    let u32s = u16s
        .iter()
        .map(|&i| if i == u16::MAX { u32::MAX } else { u32::from(i) })
        .collect();
    for indices in [Indices::U16(u16s), Indices::U32(u32s)] {
        let soup = triangle_soup(&mesh_of(strip, positions.clone(), Some(indices))).expect("a valid mesh");
        assert_eq!(soup.triangles, expected);
    }
}

#[test]
fn errors_name_what_is_wrong() {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let list = PrimitiveTopology::TriangleList;
    let error = |mesh: &Mesh| SurfaceGraph::from_mesh(mesh, &EXACT).expect_err("an invalid mesh");

    assert_eq!(
        error(&Mesh::new(list, RenderAssetUsages::default())),
        PatternError::NoPositions
    );
    assert_eq!(error(&mesh_of(list, Vec::new(), None)), PatternError::NoTriangles);
    assert_eq!(
        error(&mesh_of(list, corners[..2].to_vec(), None)),
        PatternError::NoTriangles
    );
    assert_eq!(
        error(&list_of(&corners, &[[0, 1, 1], [2, 2, 2]])),
        PatternError::NoTriangles
    );
    let line: Vec<Vec3> = [0.0, 0.1, 0.3].map(|x| Vec3::new(x, 2.0 * x, 4.0 * x)).to_vec();
    assert_eq!(error(&mesh_of(list, line, None)), PatternError::NoTriangles);
    let lines = mesh_of(PrimitiveTopology::LineStrip, corners.clone(), None);
    assert_eq!(error(&lines), PatternError::Topology("LineStrip".into()));
    let out = PatternError::IndexOutOfRange { index: 3, vertices: 3 };
    assert_eq!(error(&list_of(&corners, &[[0, 1, 2], [0, 3, 1]])), out);
    // In a list the largest 16-bit index is an index like any other.
    let out = PatternError::IndexOutOfRange {
        index: 65_535,
        vertices: 3,
    };
    assert_eq!(
        error(&mesh_of(
            list,
            corners.clone(),
            Some(Indices::U16(vec![0, 1, u16::MAX]))
        )),
        out
    );
    for bad in [f32::NAN, f32::INFINITY] {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, bad, 0.0)];
        let not_finite = PatternError::NotFinite {
            what: "position of vertex",
            index: 2,
        };
        assert_eq!(error(&mesh_of(list, positions, None)), not_finite);
    }
    let mut taken = mesh_of(list, corners, None);
    let soup = triangle_soup(&taken).expect("a valid mesh");
    taken.take_gpu_data().expect("not yet taken");
    assert_eq!(error(&taken), PatternError::MeshDataTaken);
    assert_eq!(unindexed(&taken, &soup), Err(PatternError::MeshDataTaken));
}

#[test]
fn hubs_and_books_stay_fast() {
    let begin = Instant::now();
    for (mesh, valence) in [(fan(20_000), 20_000), (book(20_000), 20_001)] {
        let graph = graph_of(&mesh);
        let level = graph.mesh_level();
        assert_eq!((0..level.len()).map(|i| level.edges(i).len()).max(), Some(valence));
        assert!(graph.levels.len() < 20, "{} levels", graph.levels.len());
    }
    assert!(begin.elapsed().as_secs_f32() < 5.0, "{:?}", begin.elapsed());
}

// ---------------------------------------------------------------------------------------------------------------------
// Weld

#[test]
fn seams_and_signed_zeros_are_welded() {
    let torus = Torus::default()
        .mesh()
        .major_resolution(24)
        .minor_resolution(12)
        .build();
    let graph = graph_of(&torus);
    assert!(graph.len() < torus.count_vertices());
    assert!(graph.vertex_of.len() == torus.count_vertices());
    let welded = weld(&[Vec3::X, Vec3::new(0.0, -0.0, 0.0), Vec3::ZERO, Vec3::X], &EXACT);
    assert_eq!(
        welded,
        Weld {
            vertex_of: vec![0, 1, 1, 0],
            first: vec![0, 1]
        }
    );
}

/// The definition: the transitive closure of "no farther apart than the tolerance", by comparing all pairs.
fn weld_by_definition(positions: &[Vec3], tolerance: f32) -> Vec<u32> {
    let mut label: Vec<usize> = (0..positions.len()).collect();
    for a in 0..positions.len() {
        for b in 0..a {
            let distance = positions[a].as_dvec3().distance_squared(positions[b].as_dvec3());
            if distance <= f64::from(tolerance).powi(2) {
                let (from, to) = (label[a].max(label[b]), label[a].min(label[b]));
                label.iter_mut().filter(|l| **l == from).for_each(|l| *l = to);
            }
        }
    }
    let mut seen = Vec::new();
    let mut number = |l: usize| {
        seen.iter()
            .position(|&s| s == l)
            .unwrap_or_else(|| (seen.push(l), seen.len() - 1).1)
    };
    label.into_iter().map(|l| number(l) as u32).collect()
}

#[test]
fn tolerance_welds_what_is_close() {
    let mut random = Random(7);
    for round in 0..40 {
        let scale = [1e-6, 1.0, 1e9][round % 3];
        let offset = Vec3::new(0.0, -3.0, 40.0) * (round % 2) as f32;
        let positions: Vec<Vec3> = (0..300).map(|_| (random.point() - 0.5 + offset) * scale).collect();
        let tolerance = [1e-9, 0.01, 0.05, 0.1, 0.3, 1e9][round % 6] * scale;
        let welded = weld(&positions, &WeldOptions { tolerance });
        assert_eq!(
            welded.vertex_of,
            weld_by_definition(&positions, tolerance),
            "tolerance {tolerance}"
        );
        assert!(welded.first.is_sorted_by(|a, b| a < b));
        let firsts: Vec<u32> = welded.first.iter().map(|&v| welded.vertex_of[v as usize]).collect();
        assert!(
            firsts.into_iter().eq(0..welded.first.len() as u32),
            "numbered by first appearance"
        );
    }
    // On the border: exactly the tolerance is close enough.
    let pair = [Vec3::ZERO, Vec3::new(0.25, 0.0, 0.0)];
    assert_eq!(weld(&pair, &WeldOptions { tolerance: 0.25 }).first.len(), 1);
    assert_eq!(weld(&pair, &WeldOptions { tolerance: 0.249 }).first.len(), 2);
    for tolerance in [f32::NAN, -1.0] {
        assert_eq!(weld(&pair, &WeldOptions { tolerance }), weld(&pair, &EXACT));
    }
    let all = SurfaceGraph::from_mesh(
        &plane(4),
        &WeldOptions {
            tolerance: f32::INFINITY,
        },
    );
    assert_eq!(all, Err(PatternError::NoTriangles));

    // A torn sphere becomes whole.
    let whole = Sphere::new(1.0).mesh().ico(8).expect("below the limit");
    let soup = triangle_soup(&whole).expect("a valid mesh");
    let torn: Vec<Vec3> = soup
        .triangles
        .as_flattened()
        .iter()
        .map(|&v| soup.positions[v as usize] + random.point() * 1e-4)
        .collect();
    let torn = mesh_of(PrimitiveTopology::TriangleList, torn, None);
    let welded = SurfaceGraph::from_mesh(&torn, &WeldOptions { tolerance: 1e-3 }).expect("a valid mesh");
    assert_eq!((welded.len(), welded.components()), (graph_of(&whole).len(), 1));
    assert!(graph_of(&torn).components() > 1000);
}

// ---------------------------------------------------------------------------------------------------------------------
// Changes of positions

#[test]
fn moved_vertices_keep_their_graph() {
    let mesh = Torus::default().mesh().build();
    let bent = |p: Vec3| Vec3::new(p.x * 2.0, p.y + p.x * p.x, p.z);
    let soup = triangle_soup(&mesh).expect("a valid mesh");
    let moved: Vec<Vec3> = soup.positions.iter().copied().map(bent).collect();
    let before = graph_of(&mesh);
    let mut graph = before.clone();
    graph.update_positions(&moved).expect("as many as before");
    assert_eq!(
        (&graph.levels, &graph.triangles, &graph.vertex_of),
        (&before.levels, &before.triangles, &before.vertex_of)
    );

    // The same as a new graph of the moved mesh, in another order.
    let fresh = graph_of(&list_of(&moved, &soup.triangles));
    for (&old, &new) in graph.vertex_of.iter().zip(&fresh.vertex_of) {
        let (old, new) = (old as usize, new as usize);
        assert_eq!(
            (graph.positions[old], graph.areas[old]),
            (fresh.positions[new], fresh.areas[new])
        );
        assert_eq!(graph.normals[old], fresh.normals[new]);
    }
    graph.update_positions(&soup.positions).expect("as many as before");
    assert_eq!(graph, before);

    let wrong = PatternError::WrongLength {
        what: "positions",
        found: 1,
        expected: soup.positions.len(),
    };
    assert_eq!(graph.update_positions(&[Vec3::ZERO]), Err(wrong));
    let mut broken = moved;
    broken[5].y = f32::NAN;
    assert!(matches!(
        graph.update_positions(&broken),
        Err(PatternError::NotFinite { index: 5, .. })
    ));
    assert_eq!(graph, before, "an error changes nothing");
}

// ---------------------------------------------------------------------------------------------------------------------
// The copy that is drawn

#[test]
fn unindexed_copy_repeats_attributes_and_morph_targets() {
    let position = |v: u32| Vec3::new(v as f32, (v * v) as f32, 1.0);
    let joints: Vec<[u16; 4]> = (0..6).map(|v| [v, 1, 2, 3]).collect();
    let target = |t: u32, v: u32| MorphAttributes::new(position(v) * t as f32, Vec3::X, Vec3::Y);
    let mut mesh = mesh_of(
        PrimitiveTopology::TriangleStrip,
        (0..6).map(position).collect(),
        Some(Indices::U16(vec![0, 1, 2, 3, u16::MAX, 5, 4, 3])),
    )
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_UV_0,
        (0..6).map(|v| [v as f32, 0.0]).collect::<Vec<_>>(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints))
    .with_morph_targets((0..2).flat_map(|t| (0..6).map(move |v| target(t, v))).collect())
    .with_morph_target_names(vec!["a".into(), "b".into()]);
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;

    let soup = triangle_soup(&mesh).expect("a valid mesh");
    let graph = graph_of(&mesh);
    let mut copy = unindexed(&mesh, &soup).expect("a valid mesh");
    assert_eq!(copy.primitive_topology(), PrimitiveTopology::TriangleList);
    assert_eq!((copy.asset_usage, copy.indices()), (mesh.asset_usage, None));
    let corners = [0, 1, 2, 1, 3, 2, 5, 4, 3];
    assert_eq!(soup.triangles.as_flattened(), corners);
    let expected: Vec<[f32; 3]> = corners.iter().map(|&v| position(v).to_array()).collect();
    assert_eq!(
        copy.attribute(Mesh::ATTRIBUTE_POSITION),
        Some(&VertexAttributeValues::Float32x3(expected))
    );
    let expected = corners.iter().map(|&v| [v as u16, 1, 2, 3]).collect();
    assert_eq!(
        copy.attribute(Mesh::ATTRIBUTE_JOINT_INDEX),
        Some(&VertexAttributeValues::Uint16x4(expected))
    );
    let expected: Vec<MorphAttributes> = (0..2).flat_map(|t| corners.map(|v| target(t, v))).collect();
    assert_eq!(copy.morph_targets(), Some(&expected));
    assert_eq!(copy.morph_target_names(), mesh.morph_target_names());

    assert_eq!(copy.attribute(Mesh::ATTRIBUTE_NORMAL), None);
    insert_missing_normals(&mut copy, &graph).expect("the graph's own copy");
    let normals = |mesh: &Mesh| {
        mesh.attribute(Mesh::ATTRIBUTE_NORMAL)
            .and_then(|n| n.as_float3().map(<[_]>::to_vec))
    };
    let expected: Vec<[f32; 3]> = graph
        .triangles
        .as_flattened()
        .iter()
        .map(|&v| graph.normals[v as usize].to_array())
        .collect();
    assert_eq!(normals(&copy), Some(expected));
    assert_eq!(
        triangle_soup(&copy).expect("a valid mesh").triangles.len(),
        graph.triangles.len()
    );

    // A mesh's own normals stay; a foreign graph or soup is refused.
    let cuboid = Cuboid::default().mesh().build();
    let cuboid_soup = triangle_soup(&cuboid).expect("a valid mesh");
    let mut flat = unindexed(&cuboid, &cuboid_soup).expect("a valid mesh");
    let before = flat.clone();
    insert_missing_normals(&mut flat, &graph).expect("nothing to do");
    assert_eq!(flat, before);
    flat.remove_attribute(Mesh::ATTRIBUTE_NORMAL);
    assert!(matches!(
        insert_missing_normals(&mut flat, &graph),
        Err(PatternError::WrongLength { .. })
    ));
    assert!(matches!(
        unindexed(&mesh, &cuboid_soup),
        Err(PatternError::IndexOutOfRange { .. })
    ));
}
