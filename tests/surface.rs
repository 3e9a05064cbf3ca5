//! The surface room: what holds for the graph of every mesh, and what becomes of unusual meshes.
#![allow(unreachable_pub, reason = "modules of one test")]

#[path = "surface/creases.rs"]
mod creases;
#[path = "surface/meshes.rs"]
mod meshes;
#[path = "surface/theorems.rs"]
mod theorems;

use bevy::{
    asset::RenderAssetUsages,
    math::primitives::{Capsule3d, Cone, Cuboid, Cylinder, Sphere, Torus},
    mesh::{Indices, Mesh, PrimitiveTopology, VertexAttributeValues, morph::MorphAttributes},
    prelude::*,
};
use bevy_field_patterns::{error::PatternError, surface::*};
use meshes::*;
use std::time::Instant;

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

        // Neighbours in memory are neighbours in space: two along the curve are a few edges apart.
        let apart = |pair: &[Vec3]| pair[0].distance(pair[1]);
        let mean = graph.positions.windows(2).map(apart).sum::<f32>() / graph.len() as f32;
        let edge = (4.0 * std::f32::consts::PI / graph.len() as f32).sqrt();
        assert!(mean < 6.0 * edge, "{mean} against {edge}");
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

#[test]
fn seams_are_closed() {
    let welded = weld(&[Vec3::X, Vec3::new(0.0, -0.0, 0.0), Vec3::ZERO, Vec3::X], &EXACT);
    let expected = Weld {
        vertex_of: vec![0, 1, 1, 0],
        first: vec![0, 1],
    };
    assert_eq!(welded, expected);

    // Bevy repeats vertices for UVs and normals, and rounds sin 2π. Euler's formula tells whether all of them met.
    let closed: [(&str, Mesh, i64); 8] = [
        ("torus", Torus::default().mesh().build(), 0),
        (
            "fine torus",
            Torus::new(3.0, 40.0)
                .mesh()
                .major_resolution(300)
                .minor_resolution(80)
                .build(),
            0,
        ),
        ("uv sphere", Sphere::new(3.0).mesh().uv(64, 36), 2),
        (
            "ico sphere",
            Sphere::new(3.0).mesh().ico(10).expect("below the limit"),
            2,
        ),
        ("cylinder", Cylinder::default().mesh().build(), 2),
        ("cone", Cone::default().mesh().build(), 2),
        ("capsule", Capsule3d::default().mesh().build(), 2),
        (
            "far away",
            Cylinder::default()
                .mesh()
                .build()
                .translated_by(Vec3::new(0.0, 1e3, -2e3)),
            2,
        ),
    ];
    for (name, mesh, characteristic) in closed {
        let graph = SurfaceGraph::from_mesh(&mesh, &WeldOptions::default()).expect("a valid mesh");
        let edges = graph.mesh_level().neighbors.len() as i64 / 2;
        let faces = graph
            .triangles
            .iter()
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .count() as i64;
        assert_eq!(graph.len() as i64 - edges + faces, characteristic, "{name}");
        assert_eq!(graph.components(), 1, "{name}");
    }
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
        let welded = weld(&positions, &within(tolerance));
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
    assert_eq!(weld(&pair, &within(0.25)).first.len(), 1);
    assert_eq!(weld(&pair, &within(0.249)).first.len(), 2);
    let across_a_cube = [Vec3::ZERO, Vec3::splat(0.58)];
    assert_eq!(weld(&across_a_cube, &within(1.0)).first.len(), 2);
    for tolerance in [f32::NAN, -1.0] {
        assert_eq!(weld(&pair, &within(tolerance)), weld(&pair, &EXACT));
    }
    let all = SurfaceGraph::from_mesh(&plane(4), &within(f32::INFINITY));
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
    let welded = SurfaceGraph::from_mesh(&torn, &within(1e-3)).expect("a valid mesh");
    assert_eq!((welded.len(), welded.components()), (graph_of(&whole).len(), 1));
    assert!(graph_of(&torn).components() > 1000);
}

#[test]
fn moved_vertices_keep_their_graph() {
    let mesh = merged(moebius(30), &moebius(7).translated_by(Vec3::X * 4.0));
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
