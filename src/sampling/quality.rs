//! How even a sample set is.
//!
//! Lengths are in units of `d_hex = √(2/√3 · total metric area / samples)`, the distance of neighbours in the hexagonal
//! packing of the same count.

use bevy::prelude::*;

/// Figures of evenness. The hexagonal packing has `nn_mean` 1, both `cv` 0, `hole` 0.577, `coverage` 0.907, `overlap` 0.
#[derive(Reflect, Debug, Clone, Copy, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct SampleQuality {
    /// The smallest distance of a sample from its nearest sample, in the mean of their two metrics.
    pub nn_min: f32,
    /// The first percentile of these distances.
    pub nn_p1: f32,
    /// Their mean.
    pub nn_mean: f32,
    /// Their standard deviation, divided by their mean.
    pub nn_cv: f32,
    /// Standard deviation of the cells' metric areas, divided by their mean; cells at a border are left out.
    pub area_cv: f32,
    /// The largest distance of a point of the domain from its sample, in the sample's metric.
    pub hole: f32,
    /// Samples that own no point of the domain.
    pub empty_cells: u32,
    /// The part of the domain's metric area that is within 1/2 of a sample.
    pub coverage: f32,
    /// The part within 1/2 of at least two samples.
    pub overlap: f32,
    /// Mean metric area of the cells of the quarter of samples with the largest ellipses, divided by that of the quarter
    /// with the smallest: 1 where the density follows the metric.
    pub grading: f32,
}
