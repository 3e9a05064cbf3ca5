//! What is measured of a sample set.
//!
//! All lengths are in `d_hex`, the distance of neighbours in the ideal hexagonal packing with the same count and the same
//! metric area: √(2/√3 · area / N).

/// How even a sample set is; [`planar_quality`](super::planar::planar_quality) fills it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SampleQuality {
    /// Smallest distance from a sample to the nearest other, in the mean of their two metrics, in `d_hex`.
    pub nn_min: f32,
    /// Distance to the nearest other sample that 1 % of the samples fall below.
    pub nn_p1: f32,
    /// Mean distance to the nearest other sample; 1 for a hexagonal packing.
    pub nn_mean: f32,
    /// Standard deviation of that distance, divided by its mean; 0 for a hexagonal packing.
    pub nn_cv: f32,
    /// Standard deviation of the metric areas of the cells, divided by their mean, without the samples that are nearer
    /// than 1.2 `d_hex` to a border. A point belongs to the sample that is nearest in the sample's own metric.
    pub area_cv: f32,
    /// Largest distance from a point of the domain to its sample, in the sample's metric; 0.577 for a hexagonal packing.
    pub hole: f32,
    /// Number of samples without a point.
    pub empty_cells: u32,
    /// Part of the metric area within `d_hex/2` of one sample or more; 0.907 for a hexagonal packing.
    pub coverage: f32,
    /// Part of the metric area within `d_hex/2` of two samples or more; 0 for a hexagonal packing.
    pub overlap: f32,
    /// Mean metric cell area of the quarter of the samples with the largest ellipses, divided by that of the quarter with
    /// the smallest; 1 where sizes are true.
    pub grading: f32,
}

impl SampleQuality {
    /// `d_hex` for so many samples on a metric area.
    pub fn hexagonal_distance(area: f64, count: usize) -> f64 {
        (2.0 / 3.0_f64.sqrt() * area / count as f64).sqrt()
    }

    /// Sets the statistics of the nearest-neighbour distances, given in `d_hex`. A lone sample has none: they stay 0.
    pub(crate) fn set_distances(&mut self, mut distances: Vec<f64>) {
        distances.retain(|d| d.is_finite());
        if distances.is_empty() {
            return;
        }
        distances.sort_by(f64::total_cmp);
        let (mean, cv) = mean_and_cv(distances.iter().copied());
        self.nn_min = distances[0] as f32;
        self.nn_p1 = distances[distances.len() / 100] as f32;
        self.nn_mean = mean as f32;
        self.nn_cv = cv as f32;
    }

    /// Sets the statistics of the cells' areas: each with the determinant of its sample's metric.
    pub(crate) fn set_areas(&mut self, mut cells: Vec<[f64; 2]>) {
        if cells.is_empty() {
            return;
        }
        self.area_cv = mean_and_cv(cells.iter().map(|cell| cell[0])).1 as f32;
        cells.sort_by(|a, b| a[1].total_cmp(&b[1]));
        let quarter = cells.len().div_ceil(4);
        let sum = |cells: &[[f64; 2]]| cells.iter().map(|cell| cell[0]).sum::<f64>();
        self.grading = (sum(&cells[..quarter]) / sum(&cells[cells.len() - quarter..])) as f32;
    }
}

/// Mean, and standard deviation divided by it.
fn mean_and_cv(values: impl ExactSizeIterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let variance = values.map(|x| (x - mean) * (x - mean)).sum::<f64>() / count;
    (mean, variance.sqrt() / mean)
}
