//! Sharp features.

use crate::meshes::*;
use bevy::{
    math::primitives::{Cuboid, Cylinder, Plane3d, Sphere},
    prelude::*,
};
use bevy_field_patterns::surface::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// Seams are closed.
fn smooth_graph_of(mesh: &Mesh) -> SurfaceGraph {
    SurfaceGraph::from_mesh(mesh, &WeldOptions::default()).expect("a graph")
}

fn count(graph: &SurfaceGraph, degrees: f32, boundary: bool) -> usize {
    graph
        .creases(degrees.to_radians(), boundary)
        .iter()
        .filter(|&&sharp| sharp)
        .count()
}

#[test]
fn edges_of_solids_are_creases_and_their_faces_are_not() {
    let cube = smooth_graph_of(&Cuboid::new(1.0, 2.0, 3.0).mesh().build());
    assert_eq!((cube.len(), count(&cube, 35.0, false)), (8, 8));
    assert_eq!(count(&cube, 89.0, true), 8);
    assert_eq!(count(&cube, 91.0, true), 0, "a closed surface has no border");

    let segments = 40;
    let cylinder = smooth_graph_of(&Cylinder::new(1.0, 2.0).mesh().resolution(segments).segments(5).build());
    let sharp = cylinder.creases(35_f32.to_radians(), false);
    for (p, &sharp) in cylinder.positions.iter().zip(&sharp) {
        let on_rim = p.y.abs() > 0.999 && p.xz().length() > 0.999;
        assert_eq!(sharp, on_rim, "{p}");
    }
    assert_eq!(sharp.iter().filter(|&&sharp| sharp).count(), 2 * segments as usize);
    // The side's own edges are 9° each.
    assert_eq!(count(&cylinder, 8.0, false), cylinder.len());

    let sphere = smooth_graph_of(&Sphere::new(1.0).mesh().ico(20).expect("below the limit"));
    assert_eq!(count(&sphere, 35.0, true), 0);
}

#[test]
fn borders_count_when_asked_for() {
    let plane = smooth_graph_of(&Plane3d::default().mesh().subdivisions(9).build());
    assert_eq!((count(&plane, 35.0, false), count(&plane, 35.0, true)), (0, 40));
}

/// Two triangles that are folded by an angle, in any orientation.
#[test]
fn fold_is_measured_whichever_way_its_triangles_face() {
    for fold in [0.1, 0.6, FRAC_PI_2, 3.0] {
        let (sin, cos) = f32::sin_cos(fold);
        let corners = [Vec3::ZERO, Vec3::Z, Vec3::X, Vec3::new(-cos, sin, 0.0)];
        for triangles in [[[0, 1, 2], [1, 0, 3]], [[0, 1, 2], [0, 1, 3]], [[1, 0, 2], [1, 0, 3]]] {
            let graph = smooth_graph_of(&list_of(&corners, &triangles));
            let sharp = |angle: f32| graph.creases(angle, false).iter().filter(|&&sharp| sharp).count();
            assert_eq!(
                (sharp(fold - 0.01), sharp(fold + 0.01)),
                (2, 0),
                "{fold}, {triangles:?}"
            );
        }
    }
}

#[test]
fn what_is_no_surface_has_creases_where_it_is_not_one() {
    // The spine of a book is shared by many pages; the pages are flat.
    let spine = smooth_graph_of(&book(5));
    assert_eq!(count(&spine, 180.0, false), 2);
    let mut random = random_triangles(7, 30, 80);
    random.insert_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0; 2]; 30]);
    let graph = smooth_graph_of(&random);
    assert_eq!(graph.creases(PI, true).len(), graph.len());
    // Triangles without an area neither make a crease nor take one away.
    let corners = [
        Vec3::ZERO,
        Vec3::X,
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::Y,
        0.5 * Vec3::ONE.with_z(0.0),
    ];
    let with_flat = [[0, 1, 2], [0, 2, 3], [0, 4, 2]];
    let graph = smooth_graph_of(&list_of(&corners, &with_flat));
    assert_eq!(count(&graph, 35.0, false), 0);
}
