//! Samples on the border: their first places.
//!
//! In: a triangulation of the domain's corners. Out: the same with samples along each rail, their distances even in the
//! metric. They slide along their rail when the samples are relaxed.

use super::{
    domain::Ground,
    metric::{ScaledMetric, dot},
    random::Random,
    triangulation::{Place, Side, Triangulation, Vertex},
};
use crate::error::PatternError;
use bevy::math::DVec2;

/// By how much the first place of a sample is shifted at random, in distances.
const JITTER: f64 = 0.15;
/// Look-ups per rail that measure its length, at most and at least; shared out by the rails' lengths.
const LOOKUPS: (f64, f64) = (4.0, 512.0);

/// The metric length along the rails, in equal steps of each.
pub(super) struct Lengths {
    rails: Vec<[DVec2; 2]>,
    /// Length from the rail's start to each step.
    sums: Vec<Vec<f64>>,
}

impl Lengths {
    pub(super) fn new(rails: Vec<[DVec2; 2]>, metric: &ScaledMetric) -> Result<Self, PatternError> {
        let perimeter: f64 = rails.iter().map(|[a, b]| a.distance(*b)).sum();
        let mut sums = Vec::with_capacity(rails.len());
        for (index, &[a, b]) in rails.iter().enumerate() {
            let steps = (4.0 * LOOKUPS.1 * a.distance(b) / perimeter)
                .clamp(LOOKUPS.0, LOOKUPS.1)
                .ceil();
            let edge = (b - a) / steps;
            let mut along = vec![0.0];
            let mut sum = 0.0;
            for i in 0..steps as u32 {
                let m = metric.at(a + (f64::from(i) + 0.5) * edge, index)?;
                sum += dot(&m, edge, edge).sqrt();
                along.push(sum);
            }
            sums.push(along);
        }
        Ok(Self { rails, sums })
    }

    /// Number of parts that each rail is cut into, where samples are `spacing` apart.
    pub(super) fn parts(&self, spacing: f64) -> Vec<u32> {
        let length = |sums: &Vec<f64>| sums[sums.len() - 1];
        self.sums
            .iter()
            .map(|sums| (length(sums) / spacing).round().clamp(1.0, 1e7) as u32)
            .collect()
    }

    /// The point of rail `r` at the metric length `part` of its whole, 0..=1.
    fn point(&self, r: usize, part: f64) -> DVec2 {
        let sums = &self.sums[r];
        let steps = sums.len() - 1;
        let target = part * sums[steps];
        let i = sums.partition_point(|&sum| sum <= target).clamp(1, steps) - 1;
        let s = (i as f64 + (target - sums[i]) / (sums[i + 1] - sums[i])) / steps as f64;
        on_rail(self.rails[r], s)
    }

    /// Cuts every rail into its number of parts.
    pub(super) fn insert(
        &self,
        mesh: &mut Triangulation,
        ground: &Ground,
        parts: &[u32],
        metric: &ScaledMetric,
        random: &mut Random,
    ) -> Result<(), PatternError> {
        for corners in &ground.loops {
            let start = mesh.border(corners.start, corners.start + 1);
            let Some(mut side) = start else {
                return Err(PatternError::Domain("its border is not closed"));
            };
            for r in corners.clone() {
                let count = parts[r as usize];
                for i in 1..count {
                    let part = (f64::from(i) + JITTER * random.triple()[0]) / f64::from(count);
                    let p = self.point(r as usize, part);
                    let m = metric.at(p, mesh.vertices.len())?;
                    side = insert_on_border(mesh, side, Vertex { p, m }, r);
                }
                side = mesh.next_border(side);
            }
        }
        Ok(())
    }
}

/// Inserts a vertex on a border side of rail `r`; returns the border side that begins at it.
pub(super) fn insert_on_border(mesh: &mut Triangulation, side: Side, vertex: Vertex, r: u32) -> Side {
    let star = mesh.split_border(side, vertex, Place::Rail(r));
    mesh.settle_star(&star, |_, _| ());
    Side::new(star[1], 2)
}

/// The point of a rail at 0..=1 of its length; exact in coordinates that do not change along it.
#[inline]
pub(super) fn on_rail([a, b]: [DVec2; 2], s: f64) -> DVec2 {
    a + (b - a) * s.clamp(0.0, 1.0)
}
