//! Metrics from axes, from tensors, and on a surface.
//!
//! In: lengths and directions of ellipses, symmetric tensors, normals. Out: metrics M, symmetric and positive definite,
//! whose unit ball has the semi-axes rᵢ = 1/√λᵢ: M = Σ rᵢ⁻² eᵢ eᵢᵀ (section 2.1 of Kratz et al. 2013, with M the metric
//! throughout).

use super::eigen::{SymmetricEigen2, SymmetricEigen3};
use crate::field::{any_tangent, project_tangent};
use bevy::{
    math::{DVec2, DVec3, Vec3},
    prelude::*,
};
use glam_matrix_extras::{SymmetricDMat2, SymmetricDMat3, SymmetricMat3};

/// The metric on a surface with unit normal `normal` whose unit ellipse has the semi-axis `long` along the unit tangent
/// `tangent` and `short` across it.
pub fn ellipse(tangent: Vec3, normal: Vec3, long: f32, short: f32) -> SymmetricMat3 {
    let across = normal.cross(tangent);
    SymmetricMat3::from_outer_product(tangent / long)
        + SymmetricMat3::from_outer_product(across / short)
        + SymmetricMat3::from_outer_product(normal) * (1.0 / (long * short))
}

/// The metric of a plane whose unit ellipse has the semi-axis `long` at `angle` radians from x and `short` across.
pub fn planar_ellipse(angle: f64, long: f64, short: f64) -> SymmetricDMat2 {
    let tangent = DVec2::from_angle(angle);
    SymmetricDMat2::from_outer_product(tangent / long) + SymmetricDMat2::from_outer_product(tangent.perp() / short)
}

/// A metric of space, restricted to the tangent plane of a surface (Eq. 4 and 5): for tangents it measures as `metric`
/// does, and its eigenvalue along the unit normal is √(λ₁λ₂) of the other two.
pub fn on_surface(metric: &SymmetricMat3, normal: Vec3) -> SymmetricMat3 {
    let (u, v) = {
        let u = any_tangent(normal).as_dvec3();
        (u, normal.as_dvec3().cross(u))
    };
    let restricted = on_plane(&metric.as_symmetric_dmat3(), u, v);
    let n = normal.as_dvec3();
    let lifted = SymmetricDMat3::from_outer_product(u) * restricted.m00
        + SymmetricDMat3::from_outer_product(v) * restricted.m11
        + cross_term(u, v) * restricted.m01
        + SymmetricDMat3::from_outer_product(n) * restricted.determinant().max(0.0).sqrt();
    lifted.as_symmetric_mat3()
}

/// A metric of space, restricted to the plane that the orthonormal `u` and `v` span, in their coordinates.
pub fn on_plane(metric: &SymmetricDMat3, u: DVec3, v: DVec3) -> SymmetricDMat2 {
    let (image_u, image_v) = (*metric * u, *metric * v);
    SymmetricDMat2::new(u.dot(image_u), u.dot(image_v), v.dot(image_v))
}

/// u vᵀ + v uᵀ.
fn cross_term(u: DVec3, v: DVec3) -> SymmetricDMat3 {
    SymmetricDMat3::new(
        2.0 * u.x * v.x,
        u.x * v.y + v.x * u.y,
        u.x * v.z + v.x * u.z,
        2.0 * u.y * v.y,
        u.y * v.z + v.y * u.z,
        2.0 * u.z * v.z,
    )
}

/// How the eigenvalues of a symmetric tensor become the semi-axes of an ellipse (section 3 of the paper).
///
/// The modulus of an eigenvalue is clamped to [`range`](Self::range), carried linearly to
/// [`lengths`](Self::lengths), and the shorter axis is lengthened where the ratio exceeds
/// [`max_ratio`](Self::max_ratio). Below, the stress under a load at the middle of the upper side.
///
#[doc = include_str!("../../../docs/images/metric_tensors.svg")]
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct EigenvalueMapping {
    /// Moduli of eigenvalues that are told apart, from smallest to largest; finite. Default 0 to 1.
    pub range: Vec2,
    /// The semi-axes that the ends of the range get, above 0. The first may be the longer one, then a large eigenvalue
    /// makes a short axis. Default 0.5 to 1. Only their ratio counts where the number of samples is given.
    pub lengths: Vec2,
    /// The longest axis over the shortest, 1 or more. Default 10.
    pub max_ratio: f32,
}

impl Default for EigenvalueMapping {
    fn default() -> Self {
        Self {
            range: Vec2::new(0.0, 1.0),
            lengths: Vec2::new(0.5, 1.0),
            max_ratio: 10.0,
        }
    }
}

impl EigenvalueMapping {
    /// The semi-axis of an eigenvalue.
    fn length(&self, eigenvalue: f64) -> f64 {
        let (low, high) = (f64::from(self.range.x), f64::from(self.range.y));
        let t = if high > low {
            ((eigenvalue.abs() - low) / (high - low)).clamp(0.0, 1.0)
        } else {
            0.5
        };
        f64::from(self.lengths.x).lerp(f64::from(self.lengths.y), t)
    }

    /// The metric of a symmetric `tensor`, on the surface with unit normal `normal`: the tensor is projected into the
    /// tangent plane (Eq. 4), and its two eigenvalues there are mapped.
    pub fn metric(&self, tensor: &SymmetricMat3, normal: Vec3) -> SymmetricMat3 {
        let u = any_tangent(normal);
        let v = normal.cross(u);
        let projected = on_plane(&tensor.as_symmetric_dmat3(), u.as_dvec3(), v.as_dvec3());
        let eigen = SymmetricEigen2::new(&projected);
        let (r0, r1) = self.limited(self.length(eigen.values.x), self.length(eigen.values.y));
        let e0 = u * eigen.vectors.x_axis.x as f32 + v * eigen.vectors.x_axis.y as f32;
        ellipse(project_tangent(e0, normal), normal, r0 as f32, r1 as f32)
    }

    /// The same in the plane.
    pub fn planar_metric(&self, tensor: &SymmetricDMat2) -> SymmetricDMat2 {
        let eigen = SymmetricEigen2::new(tensor);
        let (r0, r1) = self.limited(self.length(eigen.values.x), self.length(eigen.values.y));
        SymmetricDMat2::from_outer_product(eigen.vectors.x_axis / r0)
            + SymmetricDMat2::from_outer_product(eigen.vectors.y_axis / r1)
    }

    /// Two semi-axes, the shorter one lengthened to the largest ratio.
    fn limited(&self, a: f64, b: f64) -> (f64, f64) {
        let shortest = a.max(b) / f64::from(self.max_ratio).max(1.0);
        (a.max(shortest), b.max(shortest))
    }
}

/// ln M, a symmetric matrix.
pub(super) fn logarithm(m: &SymmetricMat3) -> SymmetricMat3 {
    SymmetricEigen3::new(&m.as_symmetric_dmat3())
        .map(|value| value.max(f64::MIN_POSITIVE).ln())
        .as_symmetric_mat3()
}

/// exp L of a symmetric matrix.
pub(super) fn exponential(l: &SymmetricMat3) -> SymmetricMat3 {
    SymmetricEigen3::new(&l.as_symmetric_dmat3())
        .map(f64::exp)
        .as_symmetric_mat3()
}
