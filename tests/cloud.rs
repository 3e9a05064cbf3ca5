//! Point clouds: their graphs, waves on them, and how they are drawn.

#[path = "common/mod.rs"]
mod common;

use bevy::{
    asset::RenderAssetUsages,
    mesh::{MeshTag, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues, VertexFormat},
    prelude::*,
    render::storage::ShaderBuffer,
};
use bevy_field_patterns::{
    field::{DirectionField, Symmetry, directions, project_tangent},
    prelude::*,
    surface::{CloudOptions, SurfaceGraph, WeldOptions, discs},
    wave::{
        Pattern, carry_wave,
        layout::{GEOMETRY_BUFFER, SURFACE_BUFFER, WAVE_BUFFER},
        quality,
        shade::PatternMemory,
        solver::{hash_turns, solve_cpu},
    },
};
use common::shapes;
use std::{collections::BTreeSet, f32::consts::PI};

fn random(i: u32, k: u32) -> f32 {
    hash_turns(i.wrapping_mul(31).wrapping_add(k).wrapping_mul(0x9e37_79b1))
}

/// Points spread evenly at random over the unit sphere.
fn sphere(n: u32) -> Vec<Vec3> {
    let point = |i| {
        let (z, turn) = (2.0 * random(i, 0) - 1.0, Vec2::from_angle(2.0 * PI * random(i, 1)));
        (turn * (1.0 - z * z).sqrt()).extend(z)
    };
    (0..n).map(point).collect()
}

fn cloud(points: &[Vec3], neighbors: u32) -> SurfaceGraph {
    let options = CloudOptions { neighbors, ..default() };
    SurfaceGraph::from_points(points, None, &WeldOptions::default(), &options).unwrap()
}

/// The edges of a graph in the numbers of its points.
fn edges_of(graph: &SurfaceGraph) -> BTreeSet<(u32, u32)> {
    let point = graph.first_vertices();
    let level = graph.mesh_level();
    (0..graph.len())
        .flat_map(|i| level.edges(i).map(move |k| (i, level.neighbors[k] as usize)))
        .map(|(i, j)| (point[i], point[j]))
        .collect()
}

#[test]
fn neighbors_are_those_of_brute_force() {
    // Unevenly dense, with a sprinkle of equal coordinates.
    let points: Vec<Vec3> = (0..700)
        .map(|i| {
            let spread = random(i, 3).powi(3);
            Vec3::new(
                random(i, 0) * spread,
                (random(i, 1) * 8.0).round() / 8.0,
                random(i, 2) * spread,
            )
        })
        .collect();
    let normals = vec![Vec3::Z; points.len()];
    for k in [3, 6, 11] {
        let options = CloudOptions {
            neighbors: k,
            ..default()
        };
        let exact = WeldOptions {
            tolerance: 0.0,
            rounding: 0.0,
        };
        let graph = SurfaceGraph::from_points(&points, Some(&normals), &exact, &options).unwrap();
        let mut expected = BTreeSet::new();
        for i in 0..points.len() as u32 {
            let distance = |j: &u32| {
                points[i as usize]
                    .as_dvec3()
                    .distance_squared(points[*j as usize].as_dvec3())
            };
            let mut others: Vec<u32> = (0..points.len() as u32).filter(|&j| j != i).collect();
            others.sort_by(|a, b| distance(a).total_cmp(&distance(b)).then(a.cmp(b)));
            expected.extend(others[..k as usize].iter().flat_map(|&j| [(i, j), (j, i)]));
        }
        assert_eq!(edges_of(&graph), expected, "k = {k}");
    }
}

#[test]
fn normals_point_outwards_and_areas_add_up() {
    let torus = shapes::torus(120, 48, 1.0, 0.4, 0.2, 3).positions;
    let middle = |p: Vec3| p.with_z(0.0).normalize();
    let shapes: [(&str, Vec<Vec3>, &dyn Fn(Vec3) -> Vec3, f32); 2] = [
        ("sphere", sphere(4000), &|p| p, 4.0 * PI),
        ("torus", torus, &|p| (p - middle(p)).normalize(), 4.0 * PI * PI * 0.4),
    ];
    for (name, points, outwards, area) in shapes {
        let graph = cloud(&points, 8);
        let cosines = || (0..graph.len()).map(|i| graph.normals[i].dot(outwards(graph.positions[i])));
        assert!(
            cosines().all(|c| c > 0.8),
            "{name}: {:?}",
            cosines().fold(1.0, f32::min)
        );
        assert!(cosines().sum::<f32>() > 0.99 * graph.len() as f32, "{name}");
        let sum: f32 = graph.areas.iter().sum();
        assert!((sum / area - 1.0).abs() < 0.2, "{name}: {sum} of {area}");
        assert_eq!(graph.components(), 1, "{name}");
        assert!(
            graph.mesh_level().colors() <= 10,
            "{name}: {}",
            graph.mesh_level().colors()
        );
    }
}

#[test]
fn sides_of_a_sheet_are_not_joined() {
    // Two layers much closer to each other than points are to their neighbours.
    let layer = |z: f32| (0..900).map(move |i| Vec3::new((i % 30) as f32, (i / 30) as f32, z));
    let points: Vec<Vec3> = layer(0.0).chain(layer(0.2)).collect();
    let normals: Vec<Vec3> = points
        .iter()
        .map(|p| if p.z > 0.1 { Vec3::Z } else { Vec3::NEG_Z })
        .collect();
    let graph = SurfaceGraph::from_points(&points, Some(&normals), &default(), &default()).unwrap();
    assert_eq!(graph.components(), 2);
    // The check can fail: with normals all alike they are.
    let alike = vec![Vec3::Z; points.len()];
    let graph = SurfaceGraph::from_points(&points, Some(&alike), &default(), &default()).unwrap();
    assert_eq!(graph.components(), 1);
}

/// The exact answer for a constant field on a plane is a plane wave, and carrying it to other points keeps it.
#[test]
fn constant_field_on_a_plane_is_exact() {
    let plane = shapes::plane(40, 0.25, 3);
    let graph = cloud(&plane.positions, 8);
    let axis = Vec3::new(0.3, 0.2, 0.9);
    let d: Vec<Vec3> = graph.normals.iter().map(|&n| project_tangent(axis, n)).collect();
    let f = vec![12.0; graph.len()];
    let z = solve_cpu(&graph, &d, &f, Symmetry::Line, &default()).phasors;
    let q = quality(&graph, &d, &f, &z, Symmetry::Line);
    assert!(q.energy < 1e-9, "{q:?}");
    let finer = shapes::plane(90, 0.25, 4);
    let onto = SurfaceGraph::from_triangles(&finer.positions, &finer.triangles, &default()).unwrap();
    let carried = carry_wave(&graph, &d, &f, &z, Symmetry::Line, &onto);
    let q = quality(
        &onto,
        &carried.directions,
        &carried.frequencies,
        &carried.phasors,
        Symmetry::Line,
    );
    assert!(q.energy < 1e-6 && q.branches == 0 && q.spacing_p95 < 0.01, "{q:?}");
}

/// A cloud's wave, judged on the triangles between its points, is about as good as that of the mesh.
#[test]
fn wave_on_points_is_as_good_as_on_their_mesh() {
    let raw = shapes::torus(120, 50, 1.0, 0.4, 0.25, 5);
    let mesh = SurfaceGraph::from_triangles(&raw.positions, &raw.triangles, &default()).unwrap();
    let empty = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    let axis = DirectionField::Axis(Dir3::new(Vec3::new(0.15, 1.0, 0.1)).unwrap());
    let solve = |graph: &SurfaceGraph| {
        let d = directions(&axis, Symmetry::Line, 0.0, graph, &empty).unwrap();
        let f = vec![8.0; graph.len()];
        let z = solve_cpu(graph, &d, &f, Symmetry::Line, &default()).phasors;
        (d, f, z)
    };
    let (d, f, z) = solve(&mesh);
    let on_mesh = quality(&mesh, &d, &f, &z, Symmetry::Line);
    let graph = cloud(&raw.positions, 8);
    let (d, f, z) = solve(&graph);
    let carried = carry_wave(&graph, &d, &f, &z, Symmetry::Line, &mesh);
    let on_points = quality(
        &mesh,
        &carried.directions,
        &carried.frequencies,
        &carried.phasors,
        Symmetry::Line,
    );
    assert!(on_points.energy < 1.4 * on_mesh.energy, "{on_points:?} {on_mesh:?}");
    assert!(
        (on_points.branches as f64) < 1.3 * on_mesh.branches as f64 + 5.0,
        "{on_points:?} {on_mesh:?}"
    );
    // The comparison can fail: phases at random are no wave.
    let noise: Vec<Vec2> = (0..mesh.len() as u32)
        .map(|i| Vec2::from_angle(6.0 * random(i, 0)))
        .collect();
    assert!(quality(&mesh, &carried.directions, &carried.frequencies, &noise, Symmetry::Line).energy > 0.5);
}

#[test]
fn gradient_of_a_linear_scalar_is_exact_on_points() {
    let points = sphere(3000);
    let mut mesh = Mesh::new(PrimitiveTopology::PointList, RenderAssetUsages::default());
    let height = MeshVertexAttribute::new("Height", 7_654_321, VertexFormat::Float32);
    let up = Vec3::new(0.2, -0.4, 1.0);
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, points.clone());
    mesh.insert_attribute(height, points.iter().map(|p| p.dot(up)).collect::<Vec<f32>>());
    let graph = SurfaceGraph::from_mesh(&mesh, &default()).unwrap();
    assert!(graph.is_cloud());
    let field = DirectionField::Gradient {
        attribute: height,
        quarter_turn: false,
    };
    let d = directions(&field, Symmetry::Vector, 0.0, &graph, &mesh).unwrap();
    let close = (0..graph.len()).filter(|&i| d[i].dot(project_tangent(up, graph.normals[i])) > 0.95);
    assert!(close.count() > 95 * graph.len() / 100);
}

#[test]
fn odd_clouds_have_graphs_or_clear_errors() {
    let build = |points: &[Vec3]| SurfaceGraph::from_points(points, None, &default(), &default());
    let two = [Vec3::ZERO, Vec3::X, Vec3::ZERO, Vec3::X];
    for (points, distinct) in [(&two[..], 2), (&two[..1], 1), (&[], 0)] {
        assert_eq!(build(points).unwrap_err(), PatternError::TooFewPoints(distinct));
    }
    let not_finite = [Vec3::ZERO, Vec3::X, Vec3::new(0.0, f32::NAN, 0.0)];
    assert!(matches!(
        build(&not_finite),
        Err(PatternError::NotFinite { index: 2, .. })
    ));
    let three = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let with_normals = |normals: &[Vec3]| SurfaceGraph::from_points(&three, Some(normals), &default(), &default());
    assert!(matches!(
        with_normals(&three[..2]),
        Err(PatternError::WrongLength {
            found: 2,
            expected: 3,
            ..
        })
    ));
    assert!(matches!(
        with_normals(&[Vec3::INFINITY; 3]),
        Err(PatternError::NotFinite { index: 0, .. })
    ));
    assert_eq!(
        with_normals(&[Vec3::ZERO; 3]).unwrap().components(),
        1,
        "fitted where they are missing"
    );

    let line: Vec<Vec3> = (0..50).map(|i| Vec3::X * i as f32).collect();
    let crowd: Vec<Vec3> = (0..300)
        .map(|i| Vec3::ONE * (i / 100) as f32 + 1e-30 * random(i, 0))
        .collect();
    let huge: Vec<Vec3> = sphere(200).iter().map(|p| 2e38 * p).collect();
    let tiny: Vec<Vec3> = sphere(200).iter().map(|p| 1e-37 * p).collect();
    for points in [line, crowd, huge, tiny] {
        let Ok(graph) = build(&points) else { continue };
        assert!(graph.normals.iter().all(|n| n.is_normalized()));
        assert!(graph.areas.iter().all(|a| a.is_finite()));
        let d = vec![Vec3::X; graph.len()];
        let z = solve_cpu(&graph, &d, &vec![1.0; graph.len()], Symmetry::Line, &default()).phasors;
        assert!(z.iter().all(|z| z.is_finite()));
    }
    // The same points give the same graph, and turned round the same up to the turn.
    let points = sphere(500);
    assert_eq!(build(&points), build(&points));
}

#[test]
fn moved_points_keep_their_neighbors_and_get_new_normals() {
    let mut graph = cloud(&sphere(1500), 8);
    let before = graph.clone();
    let turn = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7);
    let moved: Vec<Vec3> = sphere(1500).iter().map(|&p| 3.0 * (turn * p)).collect();
    graph.update_positions(&moved).unwrap();
    assert_eq!(graph.levels, before.levels);
    for i in 0..graph.len() {
        assert!(graph.normals[i].dot(turn * before.normals[i]) > 0.97);
        let larger = graph.discs[i][0].length() / before.discs[i][0].length();
        assert!((larger / 3.0 - 1.0).abs() < 0.2, "{larger}");
    }
    let error = graph.update_points(&moved, Some(&moved[1..])).unwrap_err();
    assert!(matches!(error, PatternError::WrongLength { .. }));
}

fn point_mesh(points: &[Vec3]) -> Mesh {
    Mesh::new(PrimitiveTopology::PointList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, points.to_vec())
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.5, 0.25]; points.len()])
}

/// An entity with a list of points is solved on the device as by the twin, and its shader sees the corners that are drawn.
#[test]
fn points_are_drawn_as_discs() {
    let points: Vec<Vec3> = shapes::torus(60, 30, 1.0, 0.4, 0.25, 5).positions;
    let mut app = common::app();
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(point_mesh(&points));
    let world = Transform::from_scale(Vec3::new(1.0, 2.0, 1.0)).with_rotation(Quat::from_rotation_x(0.4));
    for (space, transform) in [(PatternSpace::Mesh, Transform::IDENTITY), (PatternSpace::World, world)] {
        let pattern = (
            Mesh3d(mesh.clone()),
            DirectionField::Axis(Dir3::Y),
            Symmetry::Line,
            Frequency::Uniform(5.0),
            space,
            transform,
        );
        let entity = app.world_mut().spawn(pattern).id();
        common::settle(&mut app);
        assert_eq!(app.world().get::<PatternState>(entity), Some(&PatternState::Converged));
        let mut graph = common::graph(&app, entity);
        let (d, f, z) = common::wave(&app, entity);
        let linear = transform.compute_affine().matrix3;
        if space == PatternSpace::World {
            graph.positions.iter_mut().for_each(|p| *p = linear * *p);
        }
        let twin = solve_cpu(&graph, &d, &f, Symmetry::Line, &default()).phasors;
        let worst = quality(&graph, &d, &f, &z, Symmetry::Line).energy;
        let expected = quality(&graph, &d, &f, &twin, Symmetry::Line).energy;
        assert!((worst - expected).abs() < 0.1 * expected + 1e-6, "{worst} {expected}");

        let record = *app.world().get::<Pattern>(entity).unwrap().record();
        let tag = app.world().get::<MeshTag>(entity).unwrap().0;
        let words: Vec<u32> = read(&app, &SURFACE_BUFFER);
        let geometry: Vec<Vec4> = read(&app, &GEOMETRY_BUFFER);
        let wave: Vec<Vec2> = read(&app, &WAVE_BUFFER);
        let memory = PatternMemory {
            surface: &words,
            geometry: &geometry,
            wave: &wave,
        };
        assert_eq!(memory.record(tag), record);
        let drawn = &app.world().get::<PatternMesh>(entity).unwrap().drawn;
        let drawn = app.world().resource::<Assets<Mesh>>().get(drawn).unwrap();
        assert_eq!(drawn.count_vertices(), 6 * points.len());
        assert!(drawn.contains_attribute(Mesh::ATTRIBUTE_UV_0) && drawn.contains_attribute(Mesh::ATTRIBUTE_NORMAL));
        let Some(VertexAttributeValues::Float32x3(positions)) = drawn.attribute(Mesh::ATTRIBUTE_POSITION) else {
            panic!("positions");
        };
        let mut phases = BTreeSet::new();
        for triangle in [0, 1, 2, 77, 2 * points.len() as u32 - 1] {
            let corners = memory.corners(&record, triangle, 0).unwrap();
            for m in 0..3 {
                let position = linear * Vec3::from(positions[3 * triangle as usize + m]);
                let difference = position.distance(corners.position[m]);
                assert!(difference < 1e-5, "{space:?}, triangle {triangle}: {difference}");
                phases.insert((100.0 * corners.z[m].to_angle()) as i32);
            }
        }
        assert!(phases.len() > 4, "corners have phases of their own");
        assert!(memory.corners(&record, 2 * points.len() as u32, 0).is_none());
        app.world_mut().despawn(entity);
    }
}

fn read<T: bytemuck::Pod>(app: &App, handle: &Handle<ShaderBuffer>) -> Vec<T> {
    let buffers = app.world().resource::<Assets<ShaderBuffer>>();
    let size = buffers.get(handle).expect("a buffer").buffer_description.size;
    common::gpu::read::<T>(app, handle, 0, size).expect("its contents")
}

#[test]
fn drawn_discs_cover_the_surface() {
    let points = sphere(2000);
    let graph = cloud(&points, 8);
    let copy = discs(&point_mesh(&points), &graph).unwrap();
    assert_eq!(copy.count_vertices(), 6 * points.len());
    // Seen from outside, nearly every place lies under a square.
    let covered = |p: Vec3| {
        (0..graph.len()).any(|i| {
            let [x, y] = graph.discs[i];
            let offset = p - graph.positions[i];
            let side = x.length_squared();
            offset.length() < 1.0 && offset.dot(x).abs() <= side && offset.dot(y).abs() <= side
        })
    };
    let places = sphere(5000);
    let holes = places[2000..].iter().filter(|&&p| !covered(p)).count();
    assert!(holes < 60, "{holes} of 3000 places are bare");
    let other = cloud(&points[1..], 8);
    assert!(matches!(
        discs(&point_mesh(&points), &other),
        Err(PatternError::WrongLength { .. })
    ));
}
