//! Normals and areas of vertices.
//!
//! In: positions and triangles. Out: for each vertex the mean of the adjacent triangles' unit normals weighted by their
//! angles, and a third of their areas. Angles, unlike areas, make the normal independent of how a face is triangulated.
//! Cross products are formed in f64, where they neither underflow nor overflow for any f32 positions.

use crate::parallel;
use bevy::{
    math::{DVec3, Vec4},
    prelude::*,
};

/// Where the weighted normals of a vertex cancel to less than this part of their weights, it has no normal.
const CANCELED: f32 = 1e-5;

/// Twice the vector area of a triangle (counter-clockwise, right-handed); `None` where it is zero but for rounding.
pub(crate) fn double_area(corners: [Vec3; 3]) -> Option<DVec3> {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let cross = ab.cross(ac);
    let longest = ab.length_squared().max(ac.length_squared()).max(bc.length_squared());
    (cross.length() > 4.0 * f64::EPSILON * longest).then_some(cross)
}

/// What a triangle contributes to its vertices.
#[derive(Clone, Copy, Default)]
struct Share {
    normal: Vec3,
    /// In radians; 0 where the triangle has no area.
    angles: [f32; 3],
    /// A third of the area.
    area: f64,
}

impl Share {
    fn of(corners: [Vec3; 3]) -> Self {
        let Some(cross) = double_area(corners) else {
            return Self::default();
        };
        let length = cross.length();
        Self {
            normal: (cross / length).as_vec3(),
            angles: angles(corners, length),
            area: length / 6.0,
        }
    }
}

/// Unit normals and areas of all vertices. Triangles without an area count for nothing.
pub(super) fn normals_and_areas(positions: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<Vec3>, Vec<f32>) {
    let share = |t: usize| Share::of(triangles[t].map(|v| positions[v as usize]));
    let shares = parallel::collect(triangles.len(), share);
    let mut normals = vec![Vec4::ZERO; positions.len()];
    let mut areas = vec![0.0_f64; positions.len()];
    for (triangle, share) in triangles.iter().zip(&shares) {
        for (&vertex, angle) in triangle.iter().zip(share.angles) {
            normals[vertex as usize] += angle * share.normal.extend(1.0);
            areas[vertex as usize] += share.area;
        }
    }
    (
        normals.into_iter().map(unit_normal).collect(),
        areas.into_iter().map(to_f32).collect(),
    )
}

/// The three angles of a triangle, in radians; `double_area` is the length of its cross product.
fn angles(corners: [Vec3; 3], double_area: f64) -> [f32; 3] {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    // sin and cos of an angle share the factor of both edges' lengths; dividing keeps them inside f32.
    let angle = |u: DVec3, v: DVec3| {
        let cos = u.dot(v) / double_area;
        (1.0_f32).atan2(cos as f32)
    };
    let (at_a, at_b) = (angle(b - a, c - a), angle(a - b, c - b));
    [at_a, at_b, (std::f32::consts::PI - at_a - at_b).max(0.0)]
}

/// The direction of a sum of weighted unit normals; w is the sum of the weights.
fn unit_normal(sum: Vec4) -> Vec3 {
    let normal = sum.truncate();
    if normal.length() > CANCELED * sum.w {
        normal.normalize()
    } else {
        Vec3::Z
    }
}

/// The nearest f32, at most the largest finite one.
fn to_f32(area: f64) -> f32 {
    area.min(f64::from(f32::MAX)) as f32
}
