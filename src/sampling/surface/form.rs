//! Quadratic forms: lengths, products and areas in a metric.
//!
//! In: a metric M and vectors. Out: uᵀMv and what follows from it. Gram determinants measure areas on a surface without a
//! tangent plane: they are those of M restricted to the plane of the two vectors.

use bevy::{math::DVec3, prelude::*};
use glam_matrix_extras::{SymmetricDMat3, SymmetricMat3};

/// vᵀMv.
#[inline(always)]
pub(super) fn square(m: &SymmetricMat3, v: Vec3) -> f32 {
    m.m00 * v.x * v.x
        + m.m11 * v.y * v.y
        + m.m22 * v.z * v.z
        + 2.0 * (m.m01 * v.x * v.y + m.m02 * v.x * v.z + m.m12 * v.y * v.z)
}

/// M v.
#[inline(always)]
pub(super) fn apply(m: &SymmetricMat3, v: Vec3) -> Vec3 {
    Vec3::new(
        m.m00 * v.x + m.m01 * v.y + m.m02 * v.z,
        m.m01 * v.x + m.m11 * v.y + m.m12 * v.z,
        m.m02 * v.x + m.m12 * v.y + m.m22 * v.z,
    )
}

/// The products (uᵀMu, uᵀMv, vᵀMv).
#[inline(always)]
pub(super) fn gram(m: &SymmetricMat3, u: Vec3, v: Vec3) -> (f32, f32, f32) {
    let (mu, mv) = (apply(m, u), apply(m, v));
    (mu.dot(u), mu.dot(v), mv.dot(v))
}

/// The metric area of the parallelogram of u and v.
#[inline(always)]
pub(super) fn double_area(m: &SymmetricMat3, u: Vec3, v: Vec3) -> f32 {
    let (uu, uv, vv) = gram(m, u, v);
    (uu * vv - uv * uv).max(0.0).sqrt()
}

/// The sum of three metrics with weights.
#[inline(always)]
pub(super) fn blend(metrics: [&SymmetricMat3; 3], weights: Vec3) -> SymmetricMat3 {
    let [a, b, c] = metrics;
    let mix = |a: f32, b: f32, c: f32| a * weights.x + b * weights.y + c * weights.z;
    SymmetricMat3 {
        m00: mix(a.m00, b.m00, c.m00),
        m01: mix(a.m01, b.m01, c.m01),
        m02: mix(a.m02, b.m02, c.m02),
        m11: mix(a.m11, b.m11, c.m11),
        m12: mix(a.m12, b.m12, c.m12),
        m22: mix(a.m22, b.m22, c.m22),
    }
}

/// The mean of three metrics.
#[inline(always)]
pub(super) fn mean(metrics: [&SymmetricMat3; 3]) -> SymmetricMat3 {
    blend(metrics, Vec3::splat(1.0 / 3.0))
}

/// The mean of two metrics.
#[inline(always)]
pub(super) fn middle(a: &SymmetricMat3, b: &SymmetricMat3) -> SymmetricMat3 {
    blend([a, b, b], Vec3::new(0.5, 0.5, 0.0))
}

/// The determinant (that of `glam_matrix_extras` 0.3 has two terms exchanged).
pub(super) fn determinant(m: &SymmetricDMat3) -> f64 {
    m.m00 * (m.m11 * m.m22 - m.m12 * m.m12) - m.m01 * (m.m01 * m.m22 - m.m12 * m.m02)
        + m.m02 * (m.m01 * m.m12 - m.m11 * m.m02)
}

/// x with M x = v, or `None` where M is singular.
pub(super) fn solve(m: &SymmetricMat3, v: Vec3) -> Option<Vec3> {
    let (m, v) = (wide(m), v.as_dvec3());
    let x = DVec3::new(
        m.m11 * m.m22 - m.m12 * m.m12,
        m.m02 * m.m12 - m.m01 * m.m22,
        m.m01 * m.m12 - m.m02 * m.m11,
    );
    let y = DVec3::new(x.y, m.m00 * m.m22 - m.m02 * m.m02, m.m01 * m.m02 - m.m00 * m.m12);
    let z = DVec3::new(x.z, y.z, m.m00 * m.m11 - m.m01 * m.m01);
    let solution = (DVec3::new(x.dot(v), y.dot(v), z.dot(v)) / determinant(&m)).as_vec3();
    solution.is_finite().then_some(solution)
}

/// The metric in f64.
pub(super) fn wide(m: &SymmetricMat3) -> SymmetricDMat3 {
    let [m00, m01, m02, m11, m12, m22] = [m.m00, m.m01, m.m02, m.m11, m.m12, m.m22].map(f64::from);
    SymmetricDMat3::new(m00, m01, m02, m11, m12, m22)
}
