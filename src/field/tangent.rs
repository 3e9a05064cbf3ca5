//! Tangent vectors at a vertex.
//!
//! In: vectors and the unit normal n of the vertex they sit at. Out: unit tangents d with ⟨d, n⟩ = 0, never NaN.
//! A *line* (d and -d are the same) is averaged as the complex number (x + iy)² of its coordinates in a frame of the
//! tangent plane, which does not see the sign.

use bevy::math::{Vec2, Vec3};

/// Below this share of its length a vector's tangential part is rounding noise.
const VANISHING: f32 = 1e-6;

/// A unit tangent at the unit normal `n`: always the same one for the same normal.
pub fn any_tangent(n: Vec3) -> Vec3 {
    n.cross(if n.x.abs() < 0.6 { Vec3::X } else { Vec3::Y }).normalize()
}

/// The unit tangent nearest to the unit vector `v`: v - n ⟨n, v⟩, normalised. [`any_tangent`] where `v` is zero or
/// points along the unit normal `n`.
pub fn project_tangent(v: Vec3, n: Vec3) -> Vec3 {
    let tangent = v - n * n.dot(v);
    let length = tangent.length();
    if length > VANISHING {
        tangent / length
    } else {
        any_tangent(n)
    }
}

/// The direction of `v`, however long it is; zero where it has none.
pub(super) fn unit_or_zero(v: Vec3) -> Vec3 {
    let largest = v.abs().max_element();
    if largest > 0.0 && largest.is_finite() {
        (v / largest).normalize()
    } else {
        Vec3::ZERO
    }
}

/// The tangent `d` turned by `angle` radians in the tangent plane, counter-clockwise seen against the unit normal `n`.
pub fn turn_tangent(d: Vec3, n: Vec3, angle: f32) -> Vec3 {
    let (sin, cos) = angle.sin_cos();
    d * cos + n.cross(d) * sin
}

/// Gives every line of `directions` the sign nearest to its `previous` one, so that a pattern that is solved on keeps
/// its phases. For [`Symmetry::Line`](super::Symmetry) only; a change of sign means z → -conj z otherwise.
pub fn align_to_previous(directions: &mut [Vec3], previous: &[Vec3]) {
    for (d, &before) in directions.iter_mut().zip(previous) {
        if d.dot(before) < 0.0 {
            *d = -*d;
        }
    }
}

/// The complex square: twice the angle.
pub(super) fn squared(c: Vec2) -> Vec2 {
    Vec2::new(c.x * c.x - c.y * c.y, 2.0 * c.x * c.y)
}

/// The tangent at half the angle of `u` in the frame (x, n × x); x where `u` is zero.
pub(super) fn line_of(u: Vec2, x: Vec3, n: Vec3) -> Vec3 {
    let half = Vec2::from_angle(0.5 * u.to_angle());
    (x * half.x + n.cross(x) * half.y).normalize()
}
