//! How even planar samples are.
//!
//! In: a domain, a metric and points. Out: [`SampleQuality`], on a grid of 800 × 800 points. Nothing of the sampler's own
//! state is used, so that any other set can be judged alike.

use super::{
    domain::PlanarDomain,
    metric::{PlanarMetric, ScaledMetric, det, dot, half_box},
    raster::Raster,
};
use crate::{error::PatternError, sampling::SampleQuality};
use bevy::math::{DVec2, UVec2};
use glam_matrix_extras::SymmetricDMat2;

/// Points of the grid along each side of the bounds.
const GRID: u32 = 800;

type Sample = (DVec2, SymmetricDMat2);

/// The quality of samples at `positions`. The metric's unit does not matter. Takes about 0.1 s.
///
/// # Errors
/// As [`sample_plane`](super::sample_plane), and [`Domain`](PatternError::Domain) where there is no sample or no grid point
/// in the domain.
pub fn planar_quality(
    domain: &PlanarDomain,
    metric: &impl PlanarMetric,
    positions: &[DVec2],
) -> Result<SampleQuality, PatternError> {
    domain.ground()?;
    let metric = ScaledMetric { metric, scale: 1.0 };
    let raster = Raster::new(domain, UVec2::splat(GRID));
    let samples = positions.iter().enumerate().map(|(i, &p)| Ok((p, metric.at(p, i)?)));
    let mut samples: Vec<Sample> = samples.collect::<Result<_, PatternError>>()?;
    let mut areas = vec![0.0; raster.inside.len()];
    for (k, x) in raster.points() {
        areas[k] = det(&metric.at(x, k)?).sqrt() * raster.cell.element_product();
    }
    let total: f64 = areas.iter().sum();
    if samples.is_empty() || total.is_nan() || total <= 0.0 {
        return Err(PatternError::Domain("there is no sample or no point to judge"));
    }
    // From here on lengths are in d_hex.
    let d_hex = SampleQuality::hexagonal_distance(total, samples.len());
    samples.iter_mut().for_each(|(_, m)| *m *= 1.0 / (d_hex * d_hex));

    let nearest = raster.nearest(&samples, 1.2, 0.5);
    let mut cells = vec![0.0; samples.len()];
    let mut empty = vec![true; samples.len()];
    let (mut hole, mut covered, mut overlapped) = (0.0_f32, 0.0, 0.0);
    for (k, _) in raster.points() {
        let sample = nearest.label[k] as usize;
        cells[sample] += areas[k];
        empty[sample] = false;
        hole = hole.max(nearest.squared[k].sqrt());
        covered += if nearest.cover[k] >= 1 { areas[k] } else { 0.0 };
        overlapped += if nearest.cover[k] >= 2 { areas[k] } else { 0.0 };
    }
    let is_inner = |(p, m): &Sample| domain.border_distance_squared(*p, m) > 1.2 * 1.2;
    // Cell area and squared density of each sample inside.
    let inner: Vec<[f64; 2]> = samples
        .iter()
        .zip(&cells)
        .filter(|(sample, _)| is_inner(sample))
        .map(|((_, m), &area)| [area, det(m)])
        .collect();
    let mut quality = SampleQuality::default();
    quality.set_distances(nearest_distances(&samples));
    quality.set_areas(inner);
    quality.hole = hole;
    quality.empty_cells = empty.iter().filter(|empty| **empty).count() as u32;
    quality.coverage = (covered / total) as f32;
    quality.overlap = (overlapped / total) as f32;
    Ok(quality)
}

/// For each sample the distance to the nearest other, in the mean of the two metrics.
fn nearest_distances(samples: &[Sample]) -> Vec<f64> {
    let bins = Bins::new(samples);
    samples
        .iter()
        .enumerate()
        .map(|(i, (p, m))| {
            let mut radius = 1.0;
            loop {
                let mut best = f64::INFINITY;
                // Half of M_p is at most the mean: so a box √2 larger holds all that are nearer.
                let half = half_box(m, radius * std::f64::consts::SQRT_2);
                let all = bins.visit(p - half, p + half, |j| {
                    if j != i {
                        let (q, n) = &samples[j];
                        best = best.min(0.5 * dot(&(*m + *n), q - p, q - p));
                    }
                });
                if best <= radius * radius || all {
                    return best.sqrt();
                }
                radius *= 2.0;
            }
        })
        .collect()
}

/// Samples sorted into square bins, about two in each.
struct Bins {
    min: DVec2,
    per_unit: DVec2,
    size: usize,
    offsets: Vec<u32>,
    members: Vec<u32>,
}

impl Bins {
    fn new(samples: &[Sample]) -> Self {
        let min = samples.iter().fold(DVec2::INFINITY, |min, (p, _)| min.min(*p));
        let max = samples.iter().fold(DVec2::NEG_INFINITY, |max, (p, _)| max.max(*p));
        let size = ((samples.len() as f64 / 2.0).sqrt() as usize).max(1);
        let mut bins = Self {
            min,
            per_unit: DVec2::splat(size as f64) / (max - min).max(DVec2::splat(f64::MIN_POSITIVE)),
            size,
            offsets: vec![0; size * size + 1],
            members: vec![0; samples.len()],
        };
        let keys: Vec<usize> = samples
            .iter()
            .map(|(p, _)| bins.bin(*p))
            .map(|(i, j)| j * size + i)
            .collect();
        for &key in &keys {
            bins.offsets[key + 1] += 1;
        }
        for key in 0..size * size {
            bins.offsets[key + 1] += bins.offsets[key];
        }
        let mut end = bins.offsets.clone();
        for (&key, i) in keys.iter().zip(0..) {
            bins.members[end[key] as usize] = i;
            end[key] += 1;
        }
        bins
    }

    fn bin(&self, p: DVec2) -> (usize, usize) {
        let last = self.size - 1;
        let bin = (p - self.min) * self.per_unit;
        ((bin.x.max(0.0) as usize).min(last), (bin.y.max(0.0) as usize).min(last))
    }

    /// Visits the samples in the bins of a box; whether these were all.
    fn visit(&self, min: DVec2, max: DVec2, mut visit: impl FnMut(usize)) -> bool {
        let ((i0, j0), (i1, j1)) = (self.bin(min), self.bin(max));
        for j in j0..=j1 {
            let row = j * self.size;
            for &k in &self.members[self.offsets[row + i0] as usize..self.offsets[row + i1 + 1] as usize] {
                visit(k as usize);
            }
        }
        (i1 - i0 + 1) * (j1 - j0 + 1) == self.size * self.size
    }
}
