//! Fields and frequencies that depend on more than a mesh, on the CPU: vortices, tensors, snapshots, smooth fields, ramps.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, MeshVertexAttribute, PrimitiveTopology, VertexFormat},
    prelude::*,
};
use bevy_field_patterns::{
    error::PatternError,
    field::*,
    surface::{SurfaceGraph, WeldOptions},
    wave::{Coupling, Waves, frame},
};
use std::{f32::consts::TAU, sync::Arc};

const DIAGONAL: MeshVertexAttribute = MeshVertexAttribute::new("Test_Diagonal", 8_833_001, VertexFormat::Float32x3);
const OFF_DIAGONAL: MeshVertexAttribute = MeshVertexAttribute::new("Test_Off", 8_833_002, VertexFormat::Float32x3);

/// How crosses of two vertices belong together.
const CROSS: Coupling = Coupling {
    waves: Waves::Cross,
    symmetry: Symmetry::Line,
};

fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<u32>) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(triangles))
}

fn graph(mesh: &Mesh) -> SurfaceGraph {
    let options = WeldOptions {
        tolerance: 1e-5,
        rounding: 0.0,
    };
    SurfaceGraph::from_mesh(mesh, &options).expect("a good mesh")
}

/// An n × n grid of squares with corners at `at(u, v)`, u and v in 0..=1.
fn grid(n: u32, at: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let row = n + 1;
    let corner = |i: u32| at((i % row) as f32 / n as f32, (i / row) as f32 / n as f32).to_array();
    let square = |s: u32| {
        let a = s / n * row + s % n;
        [a, a + 1, a + row + 1, a, a + row + 1, a + row]
    };
    mesh(
        (0..row * row).map(corner).collect(),
        (0..n * n).flat_map(square).collect(),
    )
}

fn plane(n: u32) -> Mesh {
    grid(n, |u, v| Vec3::new(2.0 * u - 1.0, 2.0 * v - 1.0, 0.0))
}

fn positions(mesh: &Mesh) -> Vec<Vec3> {
    let values = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|p| p.as_float3());
    values.expect("positions").iter().map(|&p| p.into()).collect()
}

fn core(position: Vec3, strength: f32, falloff: Falloff) -> VortexCore {
    VortexCore {
        position,
        radius: 0.3,
        strength,
        falloff,
    }
}

#[test]
fn a_vortex_turns_in_circles_and_is_fastest_at_its_radius() {
    let graph = graph(&plane(20));
    for falloff in [Falloff::Inverse, Falloff::Gaussian] {
        let centre = Vec3::new(0.13, -0.27, 0.0);
        let ccw = vortex_directions(&[core(centre, 2.0, falloff)], Vec3::ZERO, 0.0, &graph);
        let cw = vortex_directions(&[core(centre, -2.0, falloff)], Vec3::ZERO, 0.0, &graph);
        for ((d, back), p) in ccw.iter().zip(&cw).zip(&graph.positions) {
            assert!(d.distance(Vec3::Z.cross(*p - centre).normalize()) < 1e-4, "{d} at {p}");
            assert!(back.distance(-*d) < 1e-4);
        }
        let speed = |r: f32| {
            core(centre, 2.0, falloff)
                .velocity(centre + r * Vec3::X, Vec3::Z)
                .length()
        };
        assert!((speed(0.3) - 2.0).abs() < 1e-5);
        assert!(speed(0.27) < 2.0 && speed(0.33) < 2.0 && speed(0.0) == 0.0);
    }
    // Far from all cores, there is the base flow alone.
    let far = vortex_directions(
        &[core(9.0 * Vec3::X, 1.0, Falloff::Gaussian)],
        Vec3::Y,
        0.25 * TAU,
        &graph,
    );
    assert!(far.iter().all(|d| d.distance(-Vec3::X) < 1e-5));
}

#[test]
fn eigenvectors_solve_their_equation_for_any_tensor() {
    let mut random = 7_u32;
    let mut next = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let mut tensors: Vec<SymmetricTensor> = (0..3000)
        .map(|n| {
            let scale = 10.0_f32.powi(n % 13 * 3 - 18);
            SymmetricTensor {
                diagonal: scale * Vec3::new(next(), next(), next()),
                off_diagonal: scale * Vec3::new(next(), next(), next()) * if n % 5 == 0 { 1e-5 } else { 1.0 },
            }
        })
        .collect();
    let of = |d: [f32; 3], o: [f32; 3]| SymmetricTensor {
        diagonal: d.into(),
        off_diagonal: o.into(),
    };
    tensors.extend([
        of([0.0; 3], [0.0; 3]),
        of([2.0; 3], [0.0; 3]),
        of([1.0; 3], [1.0; 3]),
        of([1.0, 1.0, -3.0], [0.0; 3]),
        of([-1.0, -2.0, -3.0], [1e-20, 0.0, 1e-20]),
    ]);
    for t in tensors {
        let (values, vectors) = t.eigen();
        let scale = t.diagonal.abs().max_element().max(t.off_diagonal.abs().max_element());
        let (d, o) = (t.diagonal, t.off_diagonal);
        let rows = [
            Vec3::new(d.x, o.x, o.z),
            Vec3::new(o.x, d.y, o.y),
            Vec3::new(o.z, o.y, d.z),
        ];
        assert!(values.x >= values.y && values.y >= values.z, "{t:?}");
        for k in 0..3 {
            let v = vectors[k];
            let image = Vec3::from(rows.map(|row| row.dot(v)));
            assert!(
                image.distance(values[k] * v) <= 5e-6 * scale,
                "{t:?}: {values} {vectors:?}"
            );
            assert!((v.length() - 1.0).abs() < 1e-5);
            assert!(v.dot(vectors[(k + 1) % 3]).abs() < 1e-5);
        }
    }
}

#[test]
fn a_tensor_field_is_projected_and_carried() {
    let mesh = Sphere::new(1.0).mesh().uv(32, 18);
    let count = positions(&mesh).len();
    let mesh = mesh
        .with_inserted_attribute(DIAGONAL, vec![[1.0, 5.0, 2.0]; count])
        .with_inserted_attribute(OFF_DIAGONAL, vec![[0.0; 3]; count]);
    let graph = graph(&mesh);
    for (eigenvector, axis) in [(Eigenvector::Major, Dir3::Y), (Eigenvector::Medium, Dir3::Z)] {
        let field = DirectionField::Tensor(TensorField {
            diagonal: DIAGONAL,
            off_diagonal: OFF_DIAGONAL,
            eigenvector,
        });
        assert_eq!(field.default_symmetry(), Symmetry::Line);
        let d = directions(&field, Symmetry::Line, 0.0, &graph, &mesh).expect("tensors");
        let along = directions(&DirectionField::Axis(axis), Symmetry::Line, 0.0, &graph, &mesh).expect("an axis");
        assert!(d.iter().zip(&along).all(|(d, axis)| d.dot(*axis).abs() > 1.0 - 1e-4));
    }
    let turn = Quat::from_euler(EulerRot::XYZ, 0.4, 1.1, -0.3);
    let tensor = SymmetricTensor {
        diagonal: Vec3::new(1.0, 5.0, 2.0),
        off_diagonal: Vec3::new(0.1, -0.4, 0.7),
    };
    let carried = tensor.carried(Mat3A::from_quat(turn) * 3.0);
    let ((values, vectors), (carried_values, carried_vectors)) = (tensor.eigen(), carried.eigen());
    assert!(values.distance(carried_values) < 1e-5);
    for (v, carried) in vectors.into_iter().zip(carried_vectors) {
        assert!((turn * v).dot(carried).abs() > 1.0 - 1e-5);
    }
}

#[test]
fn snapshots_are_exact_at_their_times_and_blended_between() {
    let mesh = plane(4);
    let graph = graph(&mesh);
    let all = |v: Vec3| -> Arc<[Vec3]> { vec![v; 25].into() };
    let snapshots =
        [(1.0, Vec3::X), (2.0, 3.0 * Vec3::Y), (4.0, -Vec3::X)].map(|(time, v)| Snapshot { time, vectors: all(v) });
    let at = |time, symmetry| snapshot_directions(&snapshots, time, symmetry, 0.0, &graph).expect("snapshots")[7];
    for symmetry in [Symmetry::Vector, Symmetry::Line] {
        for (time, v) in [
            (0.0, Vec3::X),
            (1.0, Vec3::X),
            (2.0, Vec3::Y),
            (4.0, -Vec3::X),
            (9.0, -Vec3::X),
        ] {
            assert!(at(time, symmetry).distance(v) < 1e-5, "{time}");
        }
    }
    // Half of (1, 0) and half of (0, 3).
    assert!(at(1.5, Symmetry::Vector).distance(Vec3::new(1.0, 3.0, 0.0).normalize()) < 1e-5);
    // As lines, 3/4 of the way the longer one wins.
    assert!(at(1.75, Symmetry::Line).dot(Vec3::Y) > 0.99);
    // The sign of a line does not matter.
    let reversed = [(1.0, Vec3::new(1.0, 1.0, 0.0)), (2.0, Vec3::new(-2.0, -1.0, 0.0))]
        .map(|(time, v)| Snapshot { time, vectors: all(v) });
    let d = snapshot_directions(&reversed, 1.5, Symmetry::Line, 0.0, &graph).expect("snapshots")[7];
    assert!(d.dot(Vec3::new(1.6, 1.0, 0.0).normalize()).abs() > 0.99, "{d}");
    let error = |snapshots: &[Snapshot], time| snapshot_directions(snapshots, time, Symmetry::Line, 0.0, &graph);
    assert!(matches!(error(&[], 0.0), Err(PatternError::Snapshots(_))));
    let [a, b, _] = snapshots.clone();
    assert!(matches!(error(&[b, a], 0.0), Err(PatternError::Snapshots(_))));
    assert!(matches!(
        error(&snapshots, f32::NAN),
        Err(PatternError::SettingNotFinite(_))
    ));
    let short = [Snapshot {
        time: 0.0,
        vectors: all(Vec3::X)[..3].into(),
    }];
    assert!(matches!(error(&short, 0.0), Err(PatternError::WrongLength { .. })));
}

fn smooth(field: &SmoothField, mesh: &Mesh) -> (SurfaceGraph, Vec<Vec3>) {
    let graph = graph(mesh);
    let constraints = smooth_constraints(field, &graph, mesh).expect("constraints");
    let d = smooth_directions(field, &constraints, 0.0, &graph);
    for (d, n) in d.iter().zip(&graph.normals) {
        assert!(
            (d.length() - 1.0).abs() < 1e-4 && d.dot(*n).abs() < 1e-4,
            "{d} at normal {n}"
        );
    }
    (graph, d)
}

#[test]
fn one_painted_line_or_cross_rules_a_whole_plane() {
    let mesh = plane(24);
    let mut painted = vec![Vec3::ZERO; positions(&mesh).len()];
    let wanted = Vec3::new(1.0, 0.4, 0.0).normalize();
    painted[100] = 10.0 * wanted;
    for ring in [FieldRing::Two, FieldRing::Four] {
        for smoothing in [Smoothing::Intrinsic, Smoothing::Extrinsic] {
            let field = SmoothField {
                ring,
                smoothing,
                align: Alignment::Painted(Painted::Vertices(painted.clone().into())),
                ..default()
            };
            let (_, d) = smooth(&field, &mesh);
            let fits = |d: &Vec3| match ring {
                FieldRing::Two => d.dot(wanted).abs(),
                FieldRing::Four => d.dot(wanted).abs().max(d.cross(wanted).length()),
            };
            let worst = d.iter().map(fits).fold(1.0, f32::min);
            assert!(worst > 1.0 - 1e-4, "{ring:?} {smoothing:?}: {worst}");
        }
    }
}

#[test]
fn fields_follow_borders_and_creases() {
    // An open cylinder: its two borders are circles.
    let tube = grid(32, |u, v| {
        let (sin, cos) = (TAU * u).sin_cos();
        Vec3::new(cos, 2.0 * v, -sin)
    });
    let around = |p: &Vec3| Vec3::new(-p.z, 0.0, p.x).normalize();
    for (quarter_turn, align) in [
        (false, Alignment::Boundary),
        (true, Alignment::Boundary),
        (false, Alignment::Curvature),
    ] {
        let field = SmoothField {
            align,
            quarter_turn,
            ..default()
        };
        let (graph, d) = smooth(&field, &tube);
        for (d, p) in d.iter().zip(&graph.positions) {
            let expected = if quarter_turn { Vec3::Y } else { around(p) };
            assert!(d.dot(expected).abs() > 0.999, "{field:?}: {d} at {p}");
        }
    }
    // A roof with a ridge along z, which rules all of it.
    let roof = grid(24, |u, v| Vec3::new(u - 0.5, 0.5 - (u - 0.5).abs(), v));
    let creases = SmoothField {
        align: Alignment::Creases(0.6),
        ..default()
    };
    let (graph, d) = smooth(&creases, &roof);
    for (d, p) in d.iter().zip(&graph.positions) {
        assert!(d.z.abs() > 0.99, "{d} at {p}");
    }
    let no_crease = SmoothField {
        align: Alignment::Creases(2.0),
        ..default()
    };
    let constraints = smooth_constraints(&no_crease, &graph, &roof).expect("none");
    assert!(constraints.iter().all(|c| c.w == 0.0));
    for wrong in [f32::NAN, 0.0, 4.0] {
        let field = SmoothField {
            align: Alignment::Creases(wrong),
            ..default()
        };
        assert!(matches!(
            smooth_constraints(&field, &graph, &roof),
            Err(PatternError::OutOfRange { .. })
        ));
    }
}

/// Singular points of a closed surface's field add up to its Euler characteristic, 2: four half ones of a line field,
/// eight quarter ones of a cross field.
#[test]
fn the_smoothest_fields_of_a_sphere_have_hardly_more_singularities_than_they_must() {
    let mesh = Sphere::new(1.0).mesh().ico(20).expect("an icosphere");
    for (ring, least) in [(FieldRing::Two, 4), (FieldRing::Four, 8)] {
        for smoothing in [Smoothing::Intrinsic, Smoothing::Extrinsic] {
            let field = SmoothField {
                ring,
                smoothing,
                align: Alignment::Boundary,
                ..default()
            };
            let (graph, d) = smooth(&field, &mesh);
            let is_singular = |triangle: &&[u32; 3]| {
                let frames = triangle.map(|v| frame(d[v as usize], graph.normals[v as usize]));
                let around = [(0, 1), (1, 2), (2, 0)];
                match ring {
                    FieldRing::Two => {
                        let opposed = around.map(|(a, b)| d[triangle[a] as usize].dot(d[triangle[b] as usize]) < 0.0);
                        opposed.iter().filter(|&&opposed| opposed).count() % 2 == 1
                    }
                    FieldRing::Four => {
                        let turns = around.map(|(a, b)| CROSS.quarter_turns(frames[b], frames[a]));
                        turns.iter().sum::<u32>() % 4 != 0
                    }
                }
            };
            let singular = graph.triangles.iter().filter(is_singular).count();
            assert!(
                (least..=2 * least).contains(&singular),
                "{ring:?} {smoothing:?}: {singular}"
            );
        }
    }
}

#[test]
fn ramps_are_linear_between_their_ends() {
    let ramp = DistanceRamp {
        segment: [Vec3::ZERO, Vec3::X],
        near: 0.5,
        far: 1.5,
        frequencies: [8.0, 2.0],
    };
    let f = |x: f32, y: f32| distance_frequency(Vec3::new(x, y, 0.0), &ramp);
    for (x, y, expected) in [
        (0.5, 0.2, 8.0),
        (0.5, 1.0, 5.0),
        (-1.0, 0.0, 5.0),
        (2.25, 0.0, 3.5),
        (0.0, 9.0, 2.0),
    ] {
        assert!((f(x, y) - expected).abs() < 1e-5, "{x} {y}: {}", f(x, y));
    }
    let ramp = ScalarRamp {
        values: [-1.0, 3.0],
        frequencies: [1.0, 5.0],
    };
    for (s, expected) in [(-2.0, 1.0), (0.0, 2.0), (3.0, 5.0), (4.0, 5.0)] {
        assert!((scalar_frequency(s, &ramp) - expected).abs() < 1e-5);
    }
    let size = PixelSize {
        plane: Vec4::new(0.0, 0.0, -0.01, 0.0),
        least: 0.001,
    };
    assert!((screen_frequency(Vec3::new(3.0, 4.0, -5.0), &size, 10.0) - 2.0).abs() < 1e-5);
    assert!((screen_frequency(Vec3::Z, &size, 10.0) - 100.0).abs() < 1e-3);
}
