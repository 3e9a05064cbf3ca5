//! Eigenvalues and eigenvectors of symmetric matrices, in closed form.
//!
//! D. Eberly, *A Robust Eigensolver for 3 × 3 Symmetric Matrices* (2014): the eigenvalues from the angle of the
//! characteristic cubic; the eigenvector of the best separated one from a cross product of rows; the other two from the
//! 2 × 2 problem in the plane across it, so that double eigenvalues need no special care.

use bevy::math::{DMat2, DMat3, DVec2, DVec3};
use glam_matrix_extras::{SymmetricDMat2, SymmetricDMat3};
use std::f64::consts::TAU;

/// M = V diag(λ) Vᵀ of a symmetric 3 × 3 matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SymmetricEigen3 {
    /// λ, ascending.
    pub values: DVec3,
    /// V: orthonormal, one column per eigenvalue.
    pub vectors: DMat3,
}

/// M = V diag(λ) Vᵀ of a symmetric 2 × 2 matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SymmetricEigen2 {
    /// λ, ascending.
    pub values: DVec2,
    /// V: orthonormal, one column per eigenvalue.
    pub vectors: DMat2,
}

impl SymmetricEigen3 {
    /// The decomposition of a finite matrix.
    pub fn new(m: &SymmetricDMat3) -> Self {
        let size = [m.m00, m.m01, m.m02, m.m11, m.m12, m.m22]
            .iter()
            .fold(0.0_f64, |size, entry| size.max(entry.abs()));
        // Entries of 1 neither overflow nor underflow in products.
        let scale = 1.0 / size;
        if size == 0.0 || !scale.is_finite() {
            return Self {
                values: DVec3::ZERO,
                vectors: DMat3::IDENTITY,
            };
        }
        let unit = *m * scale;
        let mean = (unit.m00 + unit.m11 + unit.m22) / 3.0;
        let deviator = unit - SymmetricDMat3::from_diagonal(DVec3::splat(mean));
        let off_diagonal = unit.m01 * unit.m01 + unit.m02 * unit.m02 + unit.m12 * unit.m12;
        let spread = ((deviator.diagonal().length_squared() + 2.0 * off_diagonal) / 6.0).sqrt();
        if spread < f64::MIN_POSITIVE.sqrt() {
            return Self {
                values: DVec3::splat(mean * size),
                vectors: DMat3::IDENTITY,
            };
        }
        // cos 3φ; its sign tells which end of the spectrum stands apart.
        let apart = (0.5 * determinant(&(deviator * (1.0 / spread)))).clamp(-1.0, 1.0);
        let phi = apart.acos() / 3.0;
        let single = mean
            + 2.0
                * spread
                * if apart >= 0.0 {
                    phi.cos()
                } else {
                    (phi + TAU / 3.0).cos()
                };
        let axis = null_vector(&(unit - SymmetricDMat3::from_diagonal(DVec3::splat(single))));
        // Rayleigh quotients are exact to the square of the vector's error.
        let single = axis.dot(unit * axis);
        let u = axis.any_orthonormal_vector();
        let v = axis.cross(u);
        let (image_u, image_v) = (unit * u, unit * v);
        let pair = SymmetricEigen2::new(&SymmetricDMat2::new(u.dot(image_u), u.dot(image_v), v.dot(image_v)));
        let [low, high] = [pair.vectors.x_axis, pair.vectors.y_axis].map(|c| u * c.x + v * c.y);
        let (values, vectors) = if apart >= 0.0 {
            (pair.values.extend(single), DMat3::from_cols(low, high, axis))
        } else {
            (
                DVec3::new(single, pair.values.x, pair.values.y),
                DMat3::from_cols(axis, low, high),
            )
        };
        Self {
            values: values * size,
            vectors,
        }
    }

    /// V diag(λ') Vᵀ, where λ' = f(λ).
    pub fn map(&self, f: impl Fn(f64) -> f64) -> SymmetricDMat3 {
        let v = &self.vectors;
        SymmetricDMat3::from_outer_product(v.x_axis) * f(self.values.x)
            + SymmetricDMat3::from_outer_product(v.y_axis) * f(self.values.y)
            + SymmetricDMat3::from_outer_product(v.z_axis) * f(self.values.z)
    }
}

impl SymmetricEigen2 {
    /// The decomposition of a finite matrix.
    pub fn new(m: &SymmetricDMat2) -> Self {
        let (mean, half) = (0.5 * (m.m00 + m.m11), 0.5 * (m.m00 - m.m11));
        let radius = half.hypot(m.m01);
        // (cos, sin) of half the angle of (half, m01), from whichever of the two is the larger.
        let high = if radius == 0.0 {
            DVec2::Y
        } else if half >= 0.0 {
            let cos = (0.5 * (1.0 + half / radius)).sqrt();
            DVec2::new(cos, 0.5 * m.m01 / (radius * cos))
        } else {
            let sin = (0.5 * (1.0 - half / radius)).sqrt();
            DVec2::new(0.5 * m.m01 / (radius * sin), sin)
        };
        Self {
            values: DVec2::new(mean - radius, mean + radius),
            vectors: DMat2::from_cols(-high.perp(), high),
        }
    }

    /// V diag(λ') Vᵀ, where λ' = f(λ).
    pub fn map(&self, f: impl Fn(f64) -> f64) -> SymmetricDMat2 {
        SymmetricDMat2::from_outer_product(self.vectors.x_axis) * f(self.values.x)
            + SymmetricDMat2::from_outer_product(self.vectors.y_axis) * f(self.values.y)
    }
}

/// The determinant. (`SymmetricMat3::determinant` of `glam_matrix_extras` 0.3 confuses two entries.)
pub(super) fn determinant(m: &SymmetricDMat3) -> f64 {
    m.to_mat3().determinant()
}

/// The direction that a singular symmetric matrix of rank 2 takes to zero: the longest cross product of two rows.
fn null_vector(m: &SymmetricDMat3) -> DVec3 {
    let rows = [m.col(0), m.col(1), m.col(2)];
    let crosses = [rows[0].cross(rows[1]), rows[0].cross(rows[2]), rows[1].cross(rows[2])];
    let mut longest = crosses[0];
    for cross in &crosses[1..] {
        if cross.length_squared() > longest.length_squared() {
            longest = *cross;
        }
    }
    longest.try_normalize().unwrap_or(DVec3::X)
}
