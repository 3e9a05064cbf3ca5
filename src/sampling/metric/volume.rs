//! A metric in space, looked at on a slice.
//!
//! In: metrics on a grid of voxels. Out: the metric at any point (trilinear), for surfaces and for slices.

use super::{
    structure::{Structure, metric_of_voxels},
    tensor::on_plane,
};
use crate::error::PatternError;
use bevy::{
    math::{DVec2, DVec3},
    prelude::*,
};
use glam_matrix_extras::{SymmetricDMat2, SymmetricDMat3, SymmetricMat3};

/// Metrics on a regular grid, interpolated trilinearly; outside, the nearest ones count.
#[derive(Debug, Clone, PartialEq)]
pub struct MetricVolume {
    min: DVec3,
    max: DVec3,
    size: UVec3,
    metrics: Vec<SymmetricMat3>,
}

impl MetricVolume {
    /// A volume between the corners `min` and `max`, with `size` grid points along x, y and z (the first and the last on
    /// the border) and one metric per grid point, x fastest.
    ///
    /// # Errors
    /// [`WrongLength`](PatternError::WrongLength); [`NotFinite`](PatternError::NotFinite) and
    /// [`NotPositive`](PatternError::NotPositive) of a metric; [`Domain`](PatternError::Domain) where the box is empty.
    pub fn new(min: Vec3, max: Vec3, size: UVec3, metrics: Vec<SymmetricMat3>) -> Result<Self, PatternError> {
        check_box(min, max, size, metrics.len())?;
        super::check_metrics(&metrics)?;
        Ok(Self {
            min: min.as_dvec3(),
            max: max.as_dvec3(),
            size,
            metrics,
        })
    }

    /// The metric of a scalar volume, such as a 3D image: samples are long along its level sets. Below, on a slice through
    /// spherical shells.
    ///
    #[doc = include_str!("../../../docs/images/metric_volume.svg")]
    ///
    /// # Errors
    /// As [`new`](Self::new); [`NotFinite`](PatternError::NotFinite) of a scalar.
    pub fn from_scalars(
        min: Vec3,
        max: Vec3,
        size: UVec3,
        scalars: &[f32],
        structure: &Structure,
    ) -> Result<Self, PatternError> {
        check_box(min, max, size, scalars.len())?;
        if let Some(index) = scalars.iter().position(|s| !s.is_finite()) {
            let what = "scalar of voxel";
            return Err(PatternError::NotFinite { what, index });
        }
        let voxel = (max - min).as_dvec3() / (size.as_dvec3() - 1.0).max(DVec3::ONE);
        // Lengths in voxels become lengths in space: M ← S⁻¹ M S⁻¹.
        let scaled = |m: SymmetricDMat3| {
            let s = voxel.recip();
            SymmetricDMat3::new(
                m.m00 * s.x * s.x,
                m.m01 * s.x * s.y,
                m.m02 * s.x * s.z,
                m.m11 * s.y * s.y,
                m.m12 * s.y * s.z,
                m.m22 * s.z * s.z,
            )
        };
        let metrics = metric_of_voxels(scalars, size, structure)
            .into_iter()
            .map(|m| scaled(m).as_symmetric_mat3())
            .collect();
        Self::new(min, max, size, metrics)
    }

    /// The metric at a point.
    pub fn at(&self, point: DVec3) -> SymmetricDMat3 {
        let last = self.size.as_dvec3() - 1.0;
        let grid = ((point - self.min) / (self.max - self.min) * last).clamp(DVec3::ZERO, last);
        let grid = if grid.is_finite() { grid } else { DVec3::ZERO };
        let low = grid.floor().min((last - 1.0).max(DVec3::ZERO));
        let t = grid - low;
        let low = low.as_uvec3();
        let mut sum = SymmetricDMat3::ZERO;
        for corner in 0..8_u32 {
            let bit = UVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let weight = DVec3::select(bit.cmpeq(UVec3::ONE), t, 1.0 - t).element_product();
            let p = (low + bit).min(self.size - 1);
            let index = (p.z as usize * self.size.y as usize + p.y as usize) * self.size.x as usize + p.x as usize;
            sum += self.metrics[index].as_symmetric_dmat3() * weight;
        }
        sum
    }

    /// The metric on a slice, at the point (x, y) of its coordinates.
    pub fn on_slice(&self, slice: &Slice, point: DVec2) -> SymmetricDMat2 {
        slice.restrict(point, |p| self.at(p))
    }
}

fn check_box(min: Vec3, max: Vec3, size: UVec3, found: usize) -> Result<(), PatternError> {
    if !(min.is_finite() && max.is_finite() && min.cmplt(max).all()) {
        return Err(PatternError::Domain("the volume's box is empty or not finite"));
    }
    let expected = size
        .to_array()
        .iter()
        .try_fold(1_usize, |n, &k| n.checked_mul(k as usize));
    match expected {
        Some(expected) if expected == found && found > 0 => Ok(()),
        _ => Err(PatternError::WrongLength {
            what: "values of the volume",
            found,
            expected: expected.unwrap_or(usize::MAX),
        }),
    }
}

/// A plane through space with coordinates (x, y): origin + x u + y v.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Clone, PartialEq)]
pub struct Slice {
    /// The point (0, 0).
    pub origin: Vec3,
    /// The unit vector of x.
    pub u: Dir3,
    /// The unit vector of y, orthogonal to u.
    pub v: Dir3,
}

impl Slice {
    /// The point of space at (x, y).
    pub fn point(&self, point: DVec2) -> DVec3 {
        self.origin.as_dvec3() + self.u.as_dvec3() * point.x + self.v.as_dvec3() * point.y
    }

    /// A metric of space on the slice, at the point (x, y): Eq. 4 and 5.
    pub fn restrict(&self, point: DVec2, metric: impl Fn(DVec3) -> SymmetricDMat3) -> SymmetricDMat2 {
        on_plane(&metric(self.point(point)), self.u.as_dvec3(), self.v.as_dvec3())
    }
}
