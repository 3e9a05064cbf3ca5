//! The metric in the plane: what the user gives, and how the sampler sees it.
//!
//! In: a closure or a grid of 2×2 metrics M with d(p, q)² = (q - p)ᵀ M (q - p). Out: M at any point, checked and scaled.

use crate::error::PatternError;
use bevy::math::{DVec2, UVec2};
use glam_matrix_extras::{SymmetricDMat2, SymmetricMat2};

/// A metric for each point of the plane; every closure `Fn(DVec2) -> SymmetricDMat2` is one.
///
/// A sampler looks it up once for each inserted sample and once for each sample and relaxation step. Where this is dear,
/// [`MetricGrid::bake`] it first.
pub trait PlanarMetric: Sync {
    /// The metric at `p`: symmetric, positive definite. Its unit is free where the samples are counted.
    fn at(&self, p: DVec2) -> SymmetricDMat2;
}

impl<F: Fn(DVec2) -> SymmetricDMat2 + Sync> PlanarMetric for F {
    fn at(&self, p: DVec2) -> SymmetricDMat2 {
        self(p)
    }
}

/// A metric at the nodes of a regular grid, bilinear between them (component by component), constant beyond the bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct MetricGrid {
    min: DVec2,
    /// Nodes per unit length.
    density: DVec2,
    size: UVec2,
    /// Row by row from `min`; the x axis runs first.
    values: Vec<SymmetricMat2>,
}

impl MetricGrid {
    /// A grid of `size` nodes per axis (1 or more), the outer ones on the `bounds` (min, max); `values` row by row from
    /// `min`, the x axis first.
    ///
    /// # Errors
    /// [`Domain`](PatternError::Domain) for bounds without an area or no nodes, [`WrongLength`](PatternError::WrongLength),
    /// and [`NotFinite`](PatternError::NotFinite) or [`NotPositive`](PatternError::NotPositive) for the first bad metric.
    pub fn new(bounds: (DVec2, DVec2), size: UVec2, values: Vec<SymmetricMat2>) -> Result<Self, PatternError> {
        let (min, max) = bounds;
        if !(min.is_finite() && max.is_finite() && min.cmplt(max).all()) || size.min_element() == 0 {
            return Err(PatternError::Domain(
                "a metric grid needs bounds with an area and 1 node or more per axis",
            ));
        }
        let expected = size.x as usize * size.y as usize;
        if values.len() != expected {
            return Err(PatternError::WrongLength {
                what: "metrics of a grid",
                found: values.len(),
                expected,
            });
        }
        for (index, m) in values.iter().enumerate() {
            let m = SymmetricDMat2 {
                m00: f64::from(m.m00),
                m01: f64::from(m.m01),
                m11: f64::from(m.m11),
            };
            check(m, "metric of node", index)?;
        }
        let density = (size - 1).as_dvec2() / (max - min);
        Ok(Self {
            min,
            density,
            size,
            values,
        })
    }

    /// Looks `metric` up at every node.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn bake(bounds: (DVec2, DVec2), size: UVec2, metric: &impl PlanarMetric) -> Result<Self, PatternError> {
        let (min, max) = bounds;
        let last = size.saturating_sub(UVec2::ONE).max(UVec2::ONE).as_dvec2();
        let node = |i: u32, j: u32| {
            let m = metric.at(min + (max - min) * DVec2::new(f64::from(i), f64::from(j)) / last);
            SymmetricMat2 {
                m00: m.m00 as f32,
                m01: m.m01 as f32,
                m11: m.m11 as f32,
            }
        };
        let values = (0..size.y).flat_map(|j| (0..size.x).map(move |i| (i, j)));
        Self::new(bounds, size, values.map(|(i, j)| node(i, j)).collect())
    }
}

impl PlanarMetric for MetricGrid {
    fn at(&self, p: DVec2) -> SymmetricDMat2 {
        let last = (self.size - 1).as_dvec2();
        // NaN becomes 0, so that the index below is always in range.
        let x = ((p - self.min) * self.density).max(DVec2::ZERO).min(last);
        let (i, j) = (x.x as usize, x.y as usize);
        let (u, v) = (x.x - i as f64, x.y - j as f64);
        let columns = self.size.x as usize;
        let right = usize::from(i + 1 < columns);
        let up = if j + 1 < self.size.y as usize { columns } else { 0 };
        let k = j * columns + i;
        let corners = [k, k + right, k + up, k + up + right].map(|k| self.values[k]);
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        let mut m = SymmetricDMat2::ZERO;
        for (corner, weight) in corners.iter().zip(weights) {
            m.m00 += weight * f64::from(corner.m00);
            m.m01 += weight * f64::from(corner.m01);
            m.m11 += weight * f64::from(corner.m11);
        }
        m
    }
}

/// The user's metric times a factor, checked at every look-up.
#[derive(Clone, Copy)]
pub(super) struct ScaledMetric<'a> {
    pub(super) metric: &'a dyn PlanarMetric,
    pub(super) scale: f64,
}

impl ScaledMetric<'_> {
    /// The scaled metric at the sample `index` at `p`.
    #[inline]
    pub(super) fn at(&self, p: DVec2, index: usize) -> Result<SymmetricDMat2, PatternError> {
        let m = self.metric.at(p) * self.scale;
        // False for NaN as well.
        if m.m00 > 0.0 && det(&m) > 0.0 && det(&m).is_finite() {
            return Ok(m);
        }
        check(m, "metric at sample", index)?;
        Err(PatternError::NotFinite {
            what: "metric at sample",
            index,
        })
    }
}

/// Whether M is finite and positive definite.
fn check(m: SymmetricDMat2, what: &'static str, index: usize) -> Result<(), PatternError> {
    if !m.is_finite() {
        return Err(PatternError::NotFinite { what, index });
    }
    if m.m00 > 0.0 && det(&m) > 0.0 {
        Ok(())
    } else {
        Err(PatternError::NotPositive { what, index })
    }
}

/// vᵀ M w.
#[inline]
pub(super) fn dot(m: &SymmetricDMat2, v: DVec2, w: DVec2) -> f64 {
    v.x * (m.m00 * w.x + m.m01 * w.y) + v.y * (m.m01 * w.x + m.m11 * w.y)
}

/// det M.
#[inline]
pub(super) fn det(m: &SymmetricDMat2) -> f64 {
    m.m00 * m.m11 - m.m01 * m.m01
}

/// Half the size of the box around the ellipse (x ᵀ M x ≤ radius²).
pub(super) fn half_box(m: &SymmetricDMat2, radius: f64) -> DVec2 {
    DVec2::new(m.m11, m.m00).map(f64::sqrt) * (radius / det(m).sqrt())
}
