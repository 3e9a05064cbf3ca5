//! Meshes to test with: ordinary ones and a zoo of unusual ones.

use bevy::{
    asset::RenderAssetUsages,
    math::primitives::{Cuboid, Plane3d, Sphere, Torus},
    mesh::{Indices, Mesh, PrimitiveTopology},
    prelude::*,
};
use bevy_field_patterns::surface::*;

pub const EXACT: WeldOptions = within(0.0);

/// Welds what is no farther apart than `tolerance`, and nothing else.
pub const fn within(tolerance: f32) -> WeldOptions {
    WeldOptions {
        tolerance,
        rounding: 0.0,
    }
}

pub fn mesh_of(topology: PrimitiveTopology, positions: Vec<Vec3>, indices: Option<Indices>) -> Mesh {
    let mesh = Mesh::new(topology, RenderAssetUsages::default());
    let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    match indices {
        Some(indices) => mesh.with_inserted_indices(indices),
        None => mesh,
    }
}

pub fn list_of(positions: &[Vec3], triangles: &[[u32; 3]]) -> Mesh {
    let indices = Indices::U32(triangles.as_flattened().to_vec());
    mesh_of(PrimitiveTopology::TriangleList, positions.to_vec(), Some(indices))
}

/// A small deterministic generator, so that the tests need no crate for it.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, n: u32) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(n)) as u32
    }

    pub fn unit(&mut self) -> f32 {
        self.below(1 << 24) as f32 / (1 << 24) as f32
    }

    pub fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }
}

/// Any triangles between any vertices: non-manifold in every way, with degenerate and unused parts.
pub fn random_triangles(seed: u64, vertices: u32, triangles: u32) -> Mesh {
    let mut random = Random(seed);
    let positions: Vec<Vec3> = (0..vertices).map(|_| random.point()).collect();
    let triangles: Vec<[u32; 3]> = (0..triangles)
        .map(|_| [(); 3].map(|()| random.below(vertices)))
        .collect();
    list_of(&positions, &triangles)
}

/// A disk of triangles around vertex 0.
pub fn fan(valence: u32) -> Mesh {
    let rim = (0..valence).map(|i| Vec2::from_angle(i as f32 / valence as f32 * std::f32::consts::TAU).extend(0.0));
    let positions: Vec<Vec3> = std::iter::once(Vec3::ZERO).chain(rim).collect();
    let triangles: Vec<[u32; 3]> = (0..valence).map(|i| [0, i + 1, (i + 1) % valence + 1]).collect();
    list_of(&positions, &triangles)
}

/// Triangles that share one edge.
pub fn book(pages: u32) -> Mesh {
    let leaves = (0..pages).map(|i| Vec2::from_angle(i as f32).extend(0.5));
    let positions: Vec<Vec3> = [Vec3::ZERO, Vec3::Z].into_iter().chain(leaves).collect();
    let triangles: Vec<[u32; 3]> = (0..pages).map(|i| [0, 1, i + 2]).collect();
    list_of(&positions, &triangles)
}

/// A band of `n` quads with a half turn.
pub fn moebius(n: u32) -> Mesh {
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

pub fn two_triangles_at_a_point() -> Mesh {
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y];
    list_of(&positions, &[[0, 1, 2], [0, 3, 4]])
}

pub fn scaled(mesh: &Mesh, scale: f32) -> Mesh {
    mesh.clone().scaled_by(Vec3::splat(scale))
}

pub fn merged(mut mesh: Mesh, other: &Mesh) -> Mesh {
    mesh.merge(other).expect("both are lists with the same attributes");
    mesh
}

pub fn plane(subdivisions: u32) -> Mesh {
    Plane3d::default()
        .mesh()
        .size(2.0, 3.0)
        .subdivisions(subdivisions)
        .build()
}

pub fn zoo() -> Vec<(String, Mesh)> {
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

pub fn graph_of(mesh: &Mesh) -> SurfaceGraph {
    SurfaceGraph::from_mesh(mesh, &EXACT).expect("a valid mesh")
}
