//! Directions and frequencies, through the public API.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, MeshVertexAttribute, PrimitiveTopology, VertexFormat},
    prelude::*,
    tasks::{ComputeTaskPool, TaskPoolBuilder},
};
use bevy_field_patterns::{
    error::PatternError,
    field::*,
    surface::{SurfaceGraph, WeldOptions},
};
use std::f32::consts::{FRAC_PI_2, TAU};

const VECTOR: MeshVertexAttribute = MeshVertexAttribute::new("Test_Vector", 8_811_001, VertexFormat::Float32x3);
const SCALAR: MeshVertexAttribute = MeshVertexAttribute::new("Test_Scalar", 8_811_002, VertexFormat::Float32);

fn graph(mesh: &Mesh) -> SurfaceGraph {
    // The two sides of the seams of Bevy's primitives differ by rounding.
    SurfaceGraph::from_mesh(
        mesh,
        &WeldOptions {
            tolerance: 1e-5,
            rounding: 0.0,
        },
    )
    .expect("a good mesh")
}

fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<u32>) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(triangles))
}

/// Two triangles over the unit square in the plane z = 0, each with its own copies of the two vertices on the diagonal:
/// mesh vertices 0 and 3 lie at the origin, 2 and 4 at (1, 1).
fn seam() -> Mesh {
    let (a, b, c, d) = ([0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]);
    mesh(vec![a, b, c, a, c, d], vec![0, 1, 2, 3, 4, 5])
}

/// An n × n grid of squares, each cut along a diagonal, with corners at `at(u, v)`, u and v in 0..=1.
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

fn assert_unit_tangents(directions: &[Vec3], graph: &SurfaceGraph) {
    assert_eq!(directions.len(), graph.len());
    for (d, n) in directions.iter().zip(&graph.normals) {
        assert!(
            (d.length() - 1.0).abs() < 1e-5 && d.dot(*n).abs() < 1e-5,
            "{d} at normal {n}"
        );
    }
}

/// Mean angle between two line fields, in degrees, over the vertices that `counts` picks.
fn mean_angle(
    directions: &[Vec3],
    graph: &SurfaceGraph,
    known: impl Fn(Vec3) -> Vec3,
    counts: impl Fn(Vec3) -> bool,
) -> f32 {
    let angles: Vec<f32> = directions
        .iter()
        .zip(&graph.positions)
        .filter(|(_, p)| counts(**p))
        .map(|(d, p)| d.cross(known(*p)).length().atan2(d.dot(known(*p)).abs()).to_degrees())
        .collect();
    assert!(!angles.is_empty());
    angles.iter().sum::<f32>() / angles.len() as f32
}

fn curvature(direction: Principal, smoothing: u32, graph: &SurfaceGraph, mesh: &Mesh) -> Vec<Vec3> {
    let field = DirectionField::PrincipalCurvature { direction, smoothing };
    let directions = directions(&field, field.default_symmetry(), 0.0, graph, mesh).expect("curvature");
    assert_unit_tangents(&directions, graph);
    directions
}

#[test]
fn axis_is_tangent_everywhere_and_defined_at_the_poles() {
    let mesh = Sphere::new(2.0).mesh().uv(32, 18);
    let graph = graph(&mesh);
    let field = DirectionField::Axis(Dir3::Z);
    assert_eq!(field.default_symmetry(), Symmetry::Vector);
    let directions = directions(&field, Symmetry::Vector, 0.0, &graph, &mesh).expect("axis");
    assert_unit_tangents(&directions, &graph);
    let mut away = 0;
    for (d, p) in directions.iter().zip(&graph.positions) {
        if p.z.abs() < 1.9 {
            assert!(d.z > 0.0);
            assert!(d.dot(p.cross(Vec3::Z)).abs() < 0.15, "along the meridian");
            away += 1;
        }
    }
    assert!(away > 100 && away < graph.len());
}

#[test]
fn turn_by_a_quarter_is_the_normal_times_the_direction() {
    let mesh = Torus::default().mesh().build();
    let graph = graph(&mesh);
    let field = DirectionField::Axis(Dir3::Y);
    let straight = directions(&field, Symmetry::Vector, 0.0, &graph, &mesh).expect("axis");
    let turned = directions(&field, Symmetry::Vector, FRAC_PI_2, &graph, &mesh).expect("axis");
    for ((d, t), n) in straight.iter().zip(&turned).zip(&graph.normals) {
        assert!(t.distance(n.cross(*d)) < 1e-6);
        assert!(turn_tangent(*d, *n, TAU / 8.0).distance((*d + *t).normalize()) < 1e-6);
    }
    assert!(matches!(
        directions(&field, Symmetry::Vector, f32::NAN, &graph, &mesh),
        Err(PatternError::SettingNotFinite(_))
    ));
}

#[test]
fn curvature_of_a_cylinder_runs_around_it_and_along_it() {
    let mesh = Cylinder::new(0.5, 4.0)
        .mesh()
        .resolution(48)
        .segments(40)
        .without_caps()
        .build();
    let graph = graph(&mesh);
    let inside = |p: Vec3| p.y.abs() < 1.8;
    for smoothing in [0, 30] {
        let major = curvature(Principal::Major, smoothing, &graph, &mesh);
        let minor = curvature(Principal::Minor, smoothing, &graph, &mesh);
        assert!(mean_angle(&major, &graph, |p| Vec3::Y.cross(p).normalize(), inside) < 0.5);
        assert!(mean_angle(&minor, &graph, |_| Vec3::Y, inside) < 0.5);
        assert!(
            major.iter().zip(&minor).all(|(a, b)| a.dot(*b).abs() < 1e-4),
            "perpendicular"
        );
    }
}

#[test]
fn curvature_of_a_torus_runs_around_the_tube() {
    let torus = Torus {
        minor_radius: 0.4,
        major_radius: 1.0,
    };
    let mesh = torus.mesh().minor_resolution(40).major_resolution(90).build();
    let graph = graph(&mesh);
    let around_the_axis = |p: Vec3| Vec3::Y.cross(p).normalize();
    for (smoothing, bound) in [(0, 2.0), (30, 3.0)] {
        let minor = curvature(Principal::Minor, smoothing, &graph, &mesh);
        let angle = mean_angle(&minor, &graph, around_the_axis, |_| true);
        assert!(angle < bound, "{angle} degrees after {smoothing} steps");
    }
}

#[test]
fn curvature_does_not_depend_on_the_unit_of_length_and_survives_flat_ground() {
    let bump = |scale: f32| grid(24, move |u, v| scale * Vec3::new(u, v, 0.1 * (6.0 * u).sin()));
    let (small, large) = (bump(1e-3), bump(1e3));
    let (small_graph, large_graph) = (graph(&small), graph(&large));
    let a = curvature(Principal::Major, 5, &small_graph, &small);
    let b = curvature(Principal::Major, 5, &large_graph, &large);
    // The two graphs may store their vertices in another order: compare by the mesh's vertices.
    for (&i, &j) in small_graph.vertex_of.iter().zip(&large_graph.vertex_of) {
        assert!(a[i as usize].dot(b[j as usize]).abs() > 0.999);
    }
    let flat = grid(8, |u, v| Vec3::new(u, v, 3.0));
    let flat_graph = graph(&flat);
    curvature(Principal::Minor, 30, &flat_graph, &flat);
}

#[test]
fn gradient_of_a_linear_function_on_a_plane_is_exact() {
    let slope = Vec3::new(3.0, -4.0, 0.0);
    for scale in [1e-20, 1.0, 1e30] {
        let mut mesh = grid(6, |u, v| Vec3::new(u + 0.1 * v * v, v + 0.05 * u * u, 0.0));
        let values: Vec<f32> = mesh
            .attribute(Mesh::ATTRIBUTE_POSITION)
            .and_then(|p| p.as_float3())
            .expect("positions")
            .iter()
            .map(|&p| scale * slope.dot(Vec3::from(p)))
            .collect();
        mesh.insert_attribute(SCALAR, values);
        let graph = graph(&mesh);
        for quarter_turn in [false, true] {
            let field = DirectionField::Gradient {
                attribute: SCALAR,
                quarter_turn,
            };
            assert_eq!(field.default_symmetry(), Symmetry::Vector);
            let expected = if quarter_turn {
                Vec3::new(0.8, 0.6, 0.0)
            } else {
                Vec3::new(0.6, -0.8, 0.0)
            };
            for d in directions(&field, Symmetry::Vector, 0.0, &graph, &mesh).expect("gradient") {
                assert!(d.distance(expected) < 1e-5, "{d}");
            }
        }
    }
}

#[test]
fn gradient_of_a_constant_and_vanishing_vectors_give_some_tangent() {
    let mut mesh = seam();
    mesh.insert_attribute(SCALAR, vec![7.5_f32; 6]);
    mesh.insert_attribute(
        VECTOR,
        vec![
            [0.0, 0.0, 5.0],
            [0.0; 3],
            [0.0; 3],
            [1e-40, 0.0, 0.0],
            [3e38; 3],
            [0.0; 3],
        ],
    );
    let graph = graph(&mesh);
    for symmetry in [Symmetry::Line, Symmetry::Vector] {
        for field in [
            DirectionField::Gradient {
                attribute: SCALAR,
                quarter_turn: false,
            },
            DirectionField::Attribute(VECTOR),
            DirectionField::default(),
        ] {
            assert_unit_tangents(
                &directions(&field, symmetry, 0.3, &graph, &mesh).expect("tangents"),
                &graph,
            );
        }
    }
}

#[test]
fn copies_at_a_seam_are_averaged_as_lines_or_as_vectors() {
    let mut mesh = seam();
    let x = [1.0, 0.0, 0.0];
    let graph = graph(&mesh);
    let origin = graph.vertex_of[0] as usize;
    assert_eq!(origin, graph.vertex_of[3] as usize);

    // As lines, (1, 1) and -(1, -1) have the x axis between them; as vectors, the y axis.
    let copies = [[1.0, 1.0, 0.0], x, x, [-1.0, 1.0, 0.0], x, x];
    mesh.insert_attribute(VECTOR, copies.to_vec());
    let attribute = DirectionField::Attribute(VECTOR);
    let list = DirectionField::Vertices(copies.map(Vec3::from).into());
    for field in [attribute, list] {
        assert_eq!(field.default_symmetry(), Symmetry::Line);
        let vectors = directions(&field, Symmetry::Vector, 0.0, &graph, &mesh).expect("vectors");
        assert!(vectors[origin].distance(Vec3::Y) < 1e-6);
    }

    let lean = |sign: f32| Vec3::new(sign, 0.2 * sign, 0.0);
    for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        let mut list = copies.map(Vec3::from);
        list[0] = lean(signs[0]);
        list[3] = Vec3::new(signs[1], -0.2 * signs[1], 0.0);
        let field = DirectionField::Vertices(list.into());
        let lines = directions(&field, Symmetry::Line, 0.0, &graph, &mesh).expect("lines");
        assert!(
            lines[origin].distance(signs[0] * Vec3::X) < 1e-6,
            "the sign of the first copy: {}",
            lines[origin]
        );
    }
}

#[test]
fn threads_do_not_change_the_result() {
    let mesh = grid(120, |u, v| Vec3::new(u, v, 0.1 * (7.0 * u * v).sin()));
    let graph = graph(&mesh);
    let fields = || {
        [DirectionField::default(), DirectionField::Axis(Dir3::X)]
            .map(|field| directions(&field, field.default_symmetry(), 0.0, &graph, &mesh).expect("directions"))
    };
    let alone = fields();
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
    assert_eq!(alone, fields());
}

#[test]
fn reflection_keeps_fields_or_says_what_it_lost() {
    let axis = DirectionField::Axis(Dir3::NEG_Y);
    assert_eq!(DirectionField::from_reflect(&*axis.to_dynamic()), Some(axis));
    let list = Frequency::Vertices([1.0, 2.0].into());
    assert_eq!(Frequency::from_reflect(&*list.to_dynamic()), Some(list));

    let attribute = DirectionField::Attribute(VECTOR);
    assert_eq!(
        attribute.reflect_clone().expect("a clone").downcast_ref(),
        Some(&attribute)
    );
    let rebuilt = DirectionField::from_reflect(&*attribute.to_dynamic()).expect("a field");
    let mesh = seam();
    let error = directions(&rebuilt, Symmetry::Line, 0.0, &graph(&mesh), &mesh).expect_err("the attribute is lost");
    assert!(error.to_string().contains("lost in reflection"), "{error}");
}

#[test]
fn lines_take_the_sign_nearest_to_the_previous_ones() {
    let previous = [Vec3::X, Vec3::Y, Vec3::Z];
    let mut directions = [Vec3::new(-0.8, 0.6, 0.0), Vec3::Y, Vec3::X];
    align_to_previous(&mut directions, &previous);
    assert_eq!(directions, [Vec3::new(0.8, -0.6, 0.0), Vec3::Y, Vec3::X]);
}

#[test]
fn frequencies_are_averaged_at_seams() {
    let mut mesh = seam();
    let values = [2.0, 3.0, 4.0, 6.0, 4.0, 5.0];
    mesh.insert_attribute(SCALAR, values.to_vec());
    let graph = graph(&mesh);
    for frequency in [Frequency::Attribute(SCALAR), Frequency::Vertices(values.into())] {
        let found = frequencies(&frequency, &graph, &mesh).expect("frequencies");
        let at = graph.vertex_of.iter().map(|&v| found[v as usize]).collect::<Vec<_>>();
        assert_eq!(at, [4.0, 3.0, 4.0, 4.0, 4.0, 5.0]);
    }
    assert_eq!(frequencies(&Frequency::default(), &graph, &mesh), Ok(vec![10.0; 4]));
}

#[test]
fn bad_values_are_named() {
    let mesh = seam()
        .with_inserted_attribute(SCALAR, vec![1.0, 2.0, f32::NAN, 1.0, 1.0, 1.0])
        .with_inserted_attribute(VECTOR, vec![[0.0, f32::INFINITY, 0.0]; 6]);
    let graph = graph(&mesh);
    let frequency = |frequency: Frequency| frequencies(&frequency, &graph, &mesh).expect_err("bad frequency");
    let direction =
        |field: DirectionField| directions(&field, Symmetry::Line, 0.0, &graph, &mesh).expect_err("bad field");
    let not_finite = |what, index| PatternError::NotFinite { what, index };

    assert_eq!(
        frequency(Frequency::Attribute(SCALAR)),
        not_finite("frequency of vertex", 2)
    );
    assert_eq!(
        frequency(Frequency::Uniform(f32::INFINITY)),
        PatternError::SettingNotFinite("Frequency::Uniform")
    );
    assert_eq!(
        frequency(Frequency::Uniform(-1.0)),
        PatternError::NegativeFrequency(-1.0)
    );
    let negative = [1.0, 1.0, 9.0, 1.0, -3.0, 1.0];
    assert_eq!(
        frequency(Frequency::Vertices(negative.into())),
        PatternError::NegativeFrequency(-3.0)
    );
    let wrong_length = PatternError::WrongLength {
        what: "frequencies",
        found: 4,
        expected: 6,
    };
    assert_eq!(frequency(Frequency::Vertices([1.0; 4].into())), wrong_length);
    let wrong_format = frequency(Frequency::Attribute(VECTOR));
    assert!(matches!(&wrong_format, PatternError::AttributeFormat { found, .. } if found == "Float32x3"));

    let mut vectors = [Vec3::X; 6];
    vectors[4].z = f32::NAN;
    assert_eq!(
        direction(DirectionField::Vertices(vectors.into())),
        not_finite("direction of vertex", 4)
    );
    assert_eq!(
        direction(DirectionField::Attribute(VECTOR)),
        not_finite("direction of vertex", 0)
    );
    let gradient = |attribute| DirectionField::Gradient {
        attribute,
        quarter_turn: false,
    };
    assert_eq!(direction(gradient(SCALAR)), not_finite("scalar of vertex", 2));
    assert!(matches!(
        direction(gradient(VECTOR)),
        PatternError::AttributeFormat {
            expected: "Float32",
            ..
        }
    ));
    assert_eq!(
        direction(DirectionField::Attribute(Mesh::ATTRIBUTE_TANGENT)),
        PatternError::MissingAttribute(Mesh::ATTRIBUTE_TANGENT.name.into())
    );
    let short = DirectionField::Vertices([Vec3::X; 4].into());
    assert_eq!(
        direction(short),
        PatternError::WrongLength {
            what: "directions",
            found: 4,
            expected: 6
        }
    );
}
