//! A domain as a grid of points, each with its nearest sample.
//!
//! In: a domain, samples with metrics. Out: per grid point the sample that is nearest in its own metric, found exactly: the
//! ellipses of the samples are drawn into the grid, nearest on top.

use super::{
    domain::PlanarDomain,
    metric::{dot, half_box},
};
use bevy::math::{DVec2, UVec2};
use glam_matrix_extras::SymmetricDMat2;
use std::ops::Range;

/// By how much the ellipses grow where they leave gaps.
const GROWTH: f64 = 1.6;
/// Distances that may be taken one by one.
const BRUTE_FORCE: usize = 50_000_000;

/// Points in the middle of the cells of a grid over a domain's bounds.
pub(super) struct Raster {
    min: DVec2,
    pub(super) cell: DVec2,
    pub(super) size: UVec2,
    /// Whether each point lies in the domain.
    pub(super) inside: Vec<bool>,
}

/// Which sample each point of a raster is nearest to.
pub(super) struct Nearest {
    /// `u32::MAX` outside of the domain.
    pub(super) label: Vec<u32>,
    /// Squared distance in the sample's metric.
    pub(super) squared: Vec<f32>,
    /// Number of samples nearer than the cover distance, up to 255.
    pub(super) cover: Vec<u8>,
}

impl Raster {
    pub(super) fn new(domain: &PlanarDomain, size: UVec2) -> Self {
        let (min, max) = domain.bounds();
        let mut raster = Self {
            min,
            cell: (max - min) / size.as_dvec2(),
            size,
            inside: vec![false; size.x as usize * size.y as usize],
        };
        for j in 0..size.y as usize {
            for [from, to] in domain.spans(raster.point(0, j).y) {
                let columns = raster.columns(from, to);
                raster.inside[j * size.x as usize..][columns].fill(true);
            }
        }
        raster
    }

    /// The point in column `i` and row `j`.
    #[inline]
    pub(super) fn point(&self, i: usize, j: usize) -> DVec2 {
        self.min + self.cell * DVec2::new(i as f64 + 0.5, j as f64 + 0.5)
    }

    /// The columns of the points from `from` to `to`.
    #[inline]
    fn columns(&self, from: f64, to: f64) -> Range<usize> {
        indices(from, to, self.min.x, self.cell.x, self.size.x)
    }

    /// Index and position of each point in the domain.
    pub(super) fn points(&self) -> impl Iterator<Item = (usize, DVec2)> + '_ {
        let columns = self.size.x as usize;
        let inside = self.inside.iter().enumerate().filter(|(_, inside)| **inside);
        inside.map(move |(k, _)| (k, self.point(k % columns, k / columns)))
    }

    /// The nearest sample of each point in the domain, where most are nearer than `radius`; `cover` is the distance that
    /// counts as covered, at most `radius`.
    pub(super) fn nearest(&self, samples: &[(DVec2, SymmetricDMat2)], radius: f64, cover: f64) -> Nearest {
        let mut nearest = Nearest {
            label: vec![u32::MAX; self.inside.len()],
            squared: vec![f32::INFINITY; self.inside.len()],
            cover: vec![0; self.inside.len()],
        };
        self.draw(samples, radius, |k, sample, squared| {
            if squared < cover * cover {
                nearest.cover[k] = nearest.cover[k].saturating_add(1);
            }
            if (squared as f32) < nearest.squared[k] {
                nearest.squared[k] = squared as f32;
                nearest.label[k] = sample;
            }
        });
        self.fill_gaps(samples, radius, &mut nearest);
        nearest
    }

    /// Finds the samples of the points that no ellipse has reached.
    fn fill_gaps(&self, samples: &[(DVec2, SymmetricDMat2)], mut radius: f64, nearest: &mut Nearest) {
        let mut gaps: Vec<(usize, DVec2)> = self.points().filter(|&(k, _)| nearest.label[k] == u32::MAX).collect();
        while gaps.len() * samples.len() > BRUTE_FORCE && radius.is_finite() {
            radius *= GROWTH;
            let mut is_gap = vec![false; self.inside.len()];
            gaps.iter().for_each(|&(k, _)| is_gap[k] = true);
            self.draw(samples, radius, |k, sample, squared| {
                if is_gap[k] && (squared as f32) < nearest.squared[k] {
                    nearest.squared[k] = squared as f32;
                    nearest.label[k] = sample;
                }
            });
            gaps.retain(|&(k, _)| nearest.label[k] == u32::MAX);
        }
        for (k, x) in gaps {
            for ((p, m), i) in samples.iter().zip(0..) {
                let squared = dot(m, x - p, x - p) as f32;
                if squared < nearest.squared[k] {
                    nearest.squared[k] = squared;
                    nearest.label[k] = i;
                }
            }
        }
    }

    /// Calls `draw` with each point of the domain in each sample's ellipse of the radius, and the squared distance.
    fn draw(&self, samples: &[(DVec2, SymmetricDMat2)], radius: f64, mut draw: impl FnMut(usize, u32, f64)) {
        for ((p, m), sample) in samples.iter().zip(0..) {
            let half = half_box(m, radius);
            let determinant = super::metric::det(m);
            for j in indices(p.y - half.y, p.y + half.y, self.min.y, self.cell.y, self.size.y) {
                let y = self.point(0, j).y - p.y;
                let root = (m.m00 * radius * radius - determinant * y * y).max(0.0).sqrt();
                let from = p.x + (-m.m01 * y - root) / m.m00;
                let to = p.x + (-m.m01 * y + root) / m.m00;
                for i in self.columns(from, to) {
                    let k = j * self.size.x as usize + i;
                    if self.inside[k] {
                        let x = self.point(i, j).x - p.x;
                        draw(k, sample, (m.m00 * x + 2.0 * m.m01 * y) * x + m.m11 * y * y);
                    }
                }
            }
        }
    }
}

/// The indices of the cells whose middle lies from `from` to `to`.
#[inline]
fn indices(from: f64, to: f64, min: f64, cell: f64, size: u32) -> Range<usize> {
    let index = |x: f64| ((x - min) / cell - 0.5).ceil().clamp(0.0, f64::from(size)) as usize;
    index(from)..index(to).max(index(from))
}
