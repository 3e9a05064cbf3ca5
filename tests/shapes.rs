//! The meshes made by formula are what they claim: closed or bordered, facing outwards, of the right genus, even.
#![allow(unreachable_pub, reason = "modules shared with the examples")]

use std::collections::HashMap;

use mesh_file::RawMesh;

#[path = "../examples/common/mesh_file/mod.rs"]
#[allow(dead_code, reason = "only the mesh type is used here")]
mod mesh_file;
#[path = "../examples/common/shapes.rs"]
#[allow(dead_code, reason = "random directions are the other generators'")]
mod shapes;

/// How often each directed edge occurs.
fn edges(mesh: &RawMesh) -> HashMap<(u32, u32), u32> {
    let mut edges = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_insert(0) += 1;
        }
    }
    edges
}

/// Vertices - edges + faces: 2 for a sphere, 0 for a torus.
fn euler(mesh: &RawMesh) -> i64 {
    let edges = edges(mesh);
    assert!(
        edges.values().all(|&uses| uses == 1),
        "each side of an edge belongs to one triangle"
    );
    let undirected = edges
        .keys()
        .filter(|&&(a, b)| a < b || !edges.contains_key(&(b, a)))
        .count();
    mesh.positions.len() as i64 - undirected as i64 + mesh.triangles.len() as i64
}

fn borders(mesh: &RawMesh) -> usize {
    let edges = edges(mesh);
    edges.keys().filter(|&&(a, b)| !edges.contains_key(&(b, a))).count()
}

/// Positive when the triangles face outwards.
fn volume(mesh: &RawMesh) -> f32 {
    let corner = |i: u32| mesh.positions[i as usize];
    mesh.triangles
        .iter()
        .map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0)
        .sum()
}

/// Longest edge by shortest edge.
fn unevenness(mesh: &RawMesh) -> f32 {
    let length = |(a, b): (u32, u32)| mesh.positions[a as usize].distance(mesh.positions[b as usize]);
    let lengths: Vec<f32> = edges(mesh).into_keys().map(length).collect();
    lengths.iter().copied().fold(0.0, f32::max) / lengths.iter().copied().fold(f32::INFINITY, f32::min)
}

#[test]
fn icosphere() {
    for (subdivisions, vertices) in [(0, 12), (1, 42), (4, 2562)] {
        let mesh = shapes::icosphere(subdivisions, 2.0);
        assert_eq!((mesh.positions.len(), euler(&mesh), borders(&mesh)), (vertices, 2, 0));
        assert!(mesh.positions.iter().all(|p| (p.length() - 2.0).abs() < 1e-5));
        assert!(unevenness(&mesh) < 1.4);
    }
    let exact = 4.0 / 3.0 * std::f32::consts::PI * 8.0;
    assert!((volume(&shapes::icosphere(5, 2.0)) / exact - 1.0).abs() < 5e-3);
}

#[test]
fn torus() {
    for jitter in [0.0, 0.24] {
        let mesh = shapes::torus(96, 40, 1.0, 0.3, jitter, 1);
        assert_eq!((mesh.positions.len(), euler(&mesh), borders(&mesh)), (96 * 40, 0, 0));
        let exact = 2.0 * std::f32::consts::PI.powi(2) * 0.09;
        assert!((volume(&mesh) / exact - 1.0).abs() < 2e-2, "{}", volume(&mesh));
    }
    assert_eq!(
        shapes::torus(9, 7, 1.0, 0.3, 0.4, 5),
        shapes::torus(9, 7, 1.0, 0.3, 0.4, 5)
    );
    assert_ne!(
        shapes::torus(9, 7, 1.0, 0.3, 0.4, 5),
        shapes::torus(9, 7, 1.0, 0.3, 0.4, 6)
    );
}

#[test]
fn plane() {
    for jitter in [0.0, 0.24] {
        let mesh = shapes::plane(16, jitter, 3);
        assert_eq!((mesh.positions.len(), euler(&mesh), borders(&mesh)), (17 * 17, 1, 64));
        let corner = |i: u32| mesh.positions[i as usize];
        let area = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a)).z / 2.0;
        assert!(
            mesh.triangles.iter().all(|triangle| area(triangle) > 0.0),
            "no triangle is turned over"
        );
        assert!((mesh.triangles.iter().map(area).sum::<f32>() - 4.0).abs() < 1e-4);
    }
}

#[test]
fn knot_closes_without_a_seam() {
    let mesh = shapes::knot(480, 42);
    assert_eq!((mesh.positions.len(), euler(&mesh), borders(&mesh)), (480 * 42, 0, 0));
    assert!(volume(&mesh) > 0.0);
    // The last ring meets the first as any ring meets the next.
    let ring = |i: usize| &mesh.positions[i % 480 * 42..][..42];
    let step = |i: usize| {
        ring(i)
            .iter()
            .zip(ring(i + 1))
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f32::max)
    };
    let (seam, others) = (step(479), (0..479).map(step).fold(0.0, f32::max));
    assert!(seam <= 1.01 * others, "{seam} at the seam, {others} elsewhere");
    // The tube does not touch itself: points far apart along it are far apart in space.
    for i in (0..480).step_by(8) {
        for j in (i + 60..(i + 420).min(480)).step_by(8) {
            let gap = ring(i)
                .iter()
                .flat_map(|a| ring(j).iter().map(|b| a.distance(*b)))
                .fold(f32::INFINITY, f32::min);
            assert!(gap > 0.1, "rings {i} and {j} are {gap} apart");
        }
    }
    assert!(unevenness(&mesh) < 6.0, "{}", unevenness(&mesh));
}
