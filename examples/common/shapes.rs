//! Meshes made by formula, welded (each position once), for demos, tests and benchmarks.
//!
//! In: numbers of segments, lengths, a seed. Out: a [`RawMesh`], counter-clockwise seen from outside. The same
//! parameters give the same mesh, bit by bit on one machine.

use std::{collections::HashMap, f32::consts::TAU};

use bevy::prelude::*;

use super::mesh_file::RawMesh;

/// A sphere about the origin from an icosahedron whose triangles are split in four `subdivisions` times:
/// 10·4^subdivisions + 2 vertices, nearly equilateral triangles.
pub fn icosphere(subdivisions: u32, radius: f32) -> RawMesh {
    let golden = (1.0 + 5_f32.sqrt()) / 2.0;
    let mut directions: Vec<Vec3> = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)]
        .into_iter()
        .flat_map(|(a, b)| [Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)])
        .map(Vec3::normalize)
        .collect();
    let mut triangles = icosahedron_faces(&directions);
    for _ in 0..subdivisions {
        let mut midpoints = HashMap::new();
        let mut midpoint = |a: u32, b: u32| {
            *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                directions.push((directions[a as usize] + directions[b as usize]).normalize());
                directions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    RawMesh {
        positions: directions.into_iter().map(|direction| direction * radius).collect(),
        triangles,
    }
}

/// The 20 triples of neighbours among the 12 corners, each turned outwards.
fn icosahedron_faces(corners: &[Vec3]) -> Vec<[u32; 3]> {
    // Neighbours are 63.4° apart, all others 116.6° or more.
    let neighbours = |a: usize, b: usize| corners[a].dot(corners[b]) > 0.0;
    let mut faces = Vec::with_capacity(20);
    for a in 0..corners.len() {
        for b in a + 1..corners.len() {
            for c in b + 1..corners.len() {
                if neighbours(a, b) && neighbours(b, c) && neighbours(c, a) {
                    let outwards = corners[a].dot(corners[b].cross(corners[c])) > 0.0;
                    let [a, b, c] = [a as u32, b as u32, c as u32];
                    faces.push(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    faces
}

/// A torus about the z axis with `along` segments around the hole and `around` segments around the tube, 3 or more each.
///
/// * `major`: radius of the tube's centre line; `minor`: radius of the tube.
/// * `jitter`: each vertex moves on the torus by up to this part of a segment either way; 0 is regular, from 0.25 on
///   triangles may turn over.
pub fn torus(along: usize, around: usize, major: f32, minor: f32, jitter: f32, seed: u64) -> RawMesh {
    let mut random = Random(seed);
    let mut parameter = |i: usize, segments: usize| TAU * (i as f32 + jitter * random.signed()) / segments as f32;
    let mut positions = Vec::with_capacity(along * around);
    for i in 0..along {
        for j in 0..around {
            let (u, v) = (parameter(i, along), parameter(j, around));
            let from_axis = major + minor * v.cos();
            positions.push(Vec3::new(from_axis * u.cos(), from_axis * u.sin(), minor * v.sin()));
        }
    }
    RawMesh {
        positions,
        triangles: closed_grid(along, around),
    }
}

/// The square [-1, 1]² at z = 0, facing +z, of `n`² cells with two triangles each.
///
/// * `jitter`: each inner vertex moves in the plane by up to this part of a cell either way; 0 is regular, from 0.25 on
///   triangles may turn over.
pub fn plane(n: usize, jitter: f32, seed: u64) -> RawMesh {
    let mut random = Random(seed);
    let cell = 2.0 / n as f32;
    let mut coordinate = |i: usize, inner: bool| {
        let moved = if inner { jitter * random.signed() } else { 0.0 };
        (i as f32 + moved) * cell - 1.0
    };
    let mut positions = Vec::with_capacity((n + 1) * (n + 1));
    for i in 0..=n {
        for j in 0..=n {
            let inner = (1..n).contains(&i) && (1..n).contains(&j);
            positions.push(Vec3::new(coordinate(i, inner), coordinate(j, inner), 0.0));
        }
    }
    let vertex = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let triangles = cells
        .flat_map(|(i, j)| split_quad([vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]))
        .collect();
    RawMesh { positions, triangles }
}

/// A trefoil: a smooth closed tube along the (2, 3) torus knot about the z axis, swelling and thinning three times,
/// about 2.4 units wide, with `along` rings of `around` vertices.
///
/// Rings lie at equal arc lengths; a rotation-minimising frame, its small total twist spread evenly, turns them, so that
/// the tube closes without a seam.
pub fn knot(along: usize, around: usize) -> RawMesh {
    let centres = equidistant(trefoil, along);
    let frames = closed_frames(&centres);
    let mut positions = Vec::with_capacity(along * around);
    for (i, (&centre, [normal, binormal])) in centres.iter().zip(frames).enumerate() {
        let radius = 0.21 + 0.045 * (3.0 * TAU * i as f32 / along as f32).cos();
        for j in 0..around {
            let (sin, cos) = (TAU * j as f32 / around as f32).sin_cos();
            positions.push(centre + radius * (cos * normal + sin * binormal));
        }
    }
    RawMesh {
        positions,
        triangles: closed_grid(along, around),
    }
}

/// The knot's centre line, t in [0, 2π].
fn trefoil(t: f32) -> Vec3 {
    let from_axis = 0.7 + 0.32 * (3.0 * t).cos();
    Vec3::new(
        from_axis * (2.0 * t).cos(),
        from_axis * (2.0 * t).sin(),
        0.42 * (3.0 * t).sin(),
    )
}

/// `n` points at equal arc lengths on a closed curve of period 2π.
fn equidistant(curve: impl Fn(f32) -> Vec3, n: usize) -> Vec<Vec3> {
    const SAMPLES_PER_POINT: usize = 16;
    let samples = n * SAMPLES_PER_POINT;
    let parameter = |i: usize| TAU * i as f32 / samples as f32;
    let mut lengths = vec![0.0_f32; samples + 1];
    for i in 0..samples {
        lengths[i + 1] = lengths[i] + curve(parameter(i)).distance(curve(parameter(i + 1)));
    }
    let point = |i: usize| {
        let length = lengths[samples] * i as f32 / n as f32;
        let k = lengths.partition_point(|&l| l <= length).clamp(1, samples);
        let fraction = (length - lengths[k - 1]) / (lengths[k] - lengths[k - 1]);
        curve(parameter(k - 1).lerp(parameter(k), fraction))
    };
    (0..n).map(point).collect()
}

/// Normal and binormal at each point of a closed polygon: carried along by double reflection (Wang et al. 2008), then
/// turned about the tangent so that the last meets the first.
fn closed_frames(points: &[Vec3]) -> Vec<[Vec3; 2]> {
    let n = points.len();
    let tangent = |i: usize| (points[(i + 1) % n] - points[(i + n - 1) % n]).normalize();
    let mut normal = tangent(0).any_orthonormal_vector();
    let mut normals = Vec::with_capacity(n + 1);
    for i in 0..n {
        normals.push(normal);
        let chord = (points[(i + 1) % n] - points[i]).normalize();
        let reflect = |v: Vec3, across: Vec3| v - 2.0 * v.dot(across) * across;
        let bisector = (tangent((i + 1) % n) - reflect(tangent(i), chord)).normalize_or_zero();
        normal = reflect(reflect(normal, chord), bisector);
    }
    let twist = normal.dot(tangent(0).cross(normals[0])).atan2(normal.dot(normals[0]));
    let frame = |(i, normal): (usize, &Vec3)| {
        let tangent = tangent(i);
        let turned =
            Quat::from_axis_angle(tangent, -twist * i as f32 / n as f32) * normal.reject_from_normalized(tangent);
        let normal = turned.normalize();
        [normal, normal.cross(tangent)]
    };
    normals.iter().enumerate().map(frame).collect()
}

/// The triangles of a grid that closes both ways, facing along (first direction) × (second direction).
fn closed_grid(along: usize, around: usize) -> Vec<[u32; 3]> {
    let vertex = |i: usize, j: usize| ((i % along) * around + j % around) as u32;
    let cells = (0..along).flat_map(|i| (0..around).map(move |j| (i, j)));
    cells
        .flat_map(|(i, j)| split_quad([vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]))
        .collect()
}

fn split_quad([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// `SplitMix64`: small, seedable, the same everywhere.
pub struct Random(pub u64);

impl Random {
    /// Uniform in [-1, 1).
    pub fn signed(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        // The upper 24 bits fill the mantissa.
        (z >> 40) as f32 / (1u32 << 23) as f32 - 1.0
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        0.5 + 0.5 * self.signed()
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        let z = self.signed();
        let (sin, cos) = (0.5 * TAU * self.signed()).sin_cos();
        let from_axis = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(from_axis * cos, from_axis * sin, z)
    }

    /// Normally distributed, of mean 0 and variance 1.
    pub fn normal(&mut self) -> f32 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (TAU * self.unit()).cos()
    }
}
