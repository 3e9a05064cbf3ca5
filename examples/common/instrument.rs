//! A biopsy needle.
//!
//! In: a number of vertices around it. Out: a closed surface of revolution; its tip is the origin, its shaft runs along
//! +y, about 2 units long.

use bevy::prelude::*;
use std::f32::consts::TAU;

use super::mesh_file::RawMesh;

/// Radius and height from the tip to the end of the handle.
const PROFILE: [(f32, f32); 15] = [
    (0.0, 0.0),
    (0.012, 0.05),
    (0.018, 0.09),
    (0.018, 0.5),
    (0.018, 1.3),
    (0.022, 1.32),
    (0.06, 1.36),
    (0.075, 1.38),
    (0.075, 1.42),
    (0.055, 1.45),
    (0.05, 1.6),
    (0.058, 1.75),
    (0.052, 1.88),
    (0.03, 1.93),
    (0.0, 1.94),
];

/// The needle, with `around` vertices per ring, 3 or more, and rings that far apart that triangles are near equilateral.
pub fn needle(around: usize) -> RawMesh {
    let mut rings: Vec<(f32, f32)> = Vec::new();
    for &[(r0, h0), (r1, h1)] in PROFILE[1..PROFILE.len() - 1].array_windows() {
        let side = 0.5 * TAU * (r0 + r1) / around as f32;
        let steps = ((r1 - r0).hypot(h1 - h0) / side).ceil().max(1.0);
        rings.extend((0..steps as u16).map(|i| {
            let t = f32::from(i) / steps;
            (r0.lerp(r1, t), h0.lerp(h1, t))
        }));
    }
    rings.push(PROFILE[PROFILE.len() - 2]);
    let ring_point = |radius: f32, height: f32, j: usize| {
        let (sin, cos) = (TAU * j as f32 / around as f32).sin_cos();
        Vec3::new(radius * sin, height, radius * cos)
    };
    let mut positions: Vec<Vec3> = rings
        .iter()
        .flat_map(|&(radius, height)| (0..around).map(move |j| ring_point(radius, height, j)))
        .collect();
    let vertex = |i: usize, j: usize| (i * around + j % around) as u32;
    let (tip, end, last) = (positions.len() as u32, positions.len() as u32 + 1, rings.len() - 1);
    positions.extend([Vec3::ZERO, Vec3::Y * PROFILE[PROFILE.len() - 1].1]);
    let mut triangles = Vec::new();
    for j in 0..around {
        triangles.push([tip, vertex(0, j + 1), vertex(0, j)]);
        triangles.push([end, vertex(last, j), vertex(last, j + 1)]);
        for i in 0..last {
            let [a, b, c, d] = [vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    RawMesh { positions, triangles }
}
