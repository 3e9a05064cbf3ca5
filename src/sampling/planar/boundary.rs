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
use glam_matrix_extras::SymmetricDMat2;

/// By how much the first place of a sample is shifted at random, in distances.
const JITTER: f64 = 0.15;
/// Look-ups per rail that measure its length, at most and at least; shared out by the rails' lengths.
const LOOKUPS: (f64, f64) = (4.0, 512.0);

/// Distance of two rows of the hexagonal packing, squared, where neighbours are 1 apart.
const ROWS_SQUARED: f64 = 0.75;

/// Cosines of the angles between which a corner becomes sharp: 60 and 30 degrees.
const BLUNT: f64 = 0.5;
const SHARP: f64 = 0.866;

/// A straight part of the border, the domain to its left.
#[derive(Clone, Copy)]
pub(super) struct Rail {
    pub(super) start: DVec2,
    pub(super) end: DVec2,
    /// Where the rail that ends here begins, and where the one that begins at the end ends.
    pub(super) before: DVec2,
    pub(super) after: DVec2,
}

impl Rail {
    /// The point at 0..=1 of the length; exact in coordinates that do not change along it.
    #[inline]
    pub(super) fn point(&self, s: f64) -> DVec2 {
        self.start + (self.end - self.start) * s.clamp(0.0, 1.0)
    }

    /// Which part of the length lies before `p`.
    #[inline]
    pub(super) fn part(&self, p: DVec2) -> f64 {
        (p - self.start).dot(self.end - self.start) / self.start.distance_squared(self.end)
    }

    /// How dense samples `spacing` apart lie on an edge of this rail, with the metric `m`: 1, and less in a sharp corner,
    /// where the other rail is nearer than a row of samples. There the two rails share one zigzag: where they are δ
    /// distances apart, neighbours on one rail are 2√(1 - δ²) apart.
    pub(super) fn density(&self, edge: [DVec2; 2], m: &SymmetricDMat2, spacing: f64) -> f64 {
        let p = edge[0].midpoint(edge[1]);
        let shared = |corner: DVec2, out: DVec2, back: DVec2, other: DVec2| {
            let sharp = sharpness(corner, out, back, m);
            if sharp == 0.0 {
                return 0.0;
            }
            let side = other - corner;
            let foot = corner + side * (dot(m, side, p - corner) / dot(m, side, side)).clamp(0.0, 1.0);
            let squared = dot(m, foot - p, foot - p) / (spacing * spacing);
            sharp * (1.0 - 0.5 / (1.0 - squared.min(ROWS_SQUARED)).sqrt())
        };
        let at_start = shared(self.start, self.end, self.before, self.before);
        1.0 - at_start.max(shared(self.end, self.after, self.start, self.after))
    }

    /// The first distance on this rail, where the others are 1: half in a sharp corner, so that the zigzag begins here and
    /// not on both rails at once. 1 for an edge that does not begin at the corner.
    pub(super) fn first(&self, edge: [DVec2; 2], m: &SymmetricDMat2) -> f64 {
        if edge.contains(&self.start) {
            1.0 - 0.5 * sharpness(self.start, self.end, self.before, m)
        } else {
            1.0
        }
    }
}

/// How sharp a corner of the border is, between the next point of the border and the one before: 0 from 60 degrees (in the
/// metric) on, where samples on the two sides do not crowd each other, 1 up to 30 degrees. 0 where the domain is outside of it.
fn sharpness(corner: DVec2, out: DVec2, back: DVec2, m: &SymmetricDMat2) -> f64 {
    let (u, v) = (out - corner, back - corner);
    if u.perp_dot(v) <= 0.0 {
        return 0.0;
    }
    let cosine = dot(m, u, v) / (dot(m, u, u) * dot(m, v, v)).sqrt();
    ((cosine - BLUNT) / (SHARP - BLUNT)).clamp(0.0, 1.0)
}

/// The metric length along the rails, in equal steps of each; less where two rails share their samples.
pub(super) struct Lengths {
    rails: Vec<Rail>,
    /// Length from the rail's start to each step.
    sums: Vec<Vec<f64>>,
    /// The first distance on each rail, where the others are 1.
    firsts: Vec<f64>,
}

impl Lengths {
    /// For samples `spacing` apart.
    pub(super) fn new(rails: Vec<Rail>, metric: &ScaledMetric, spacing: f64) -> Result<Self, PatternError> {
        let length = |rail: &Rail| rail.start.distance(rail.end);
        let perimeter: f64 = rails.iter().map(length).sum();
        let mut sums = Vec::with_capacity(rails.len());
        let mut firsts = Vec::with_capacity(rails.len());
        for (index, rail) in rails.iter().enumerate() {
            let steps = (4.0 * LOOKUPS.1 * length(rail) / perimeter)
                .clamp(LOOKUPS.0, LOOKUPS.1)
                .ceil();
            let step = (rail.end - rail.start) / steps;
            let mut along = vec![0.0];
            let mut sum = 0.0;
            for i in 0..steps as u32 {
                let p = rail.start + f64::from(i) * step;
                let edge = [p, p + step];
                let m = metric.at(p + 0.5 * step, index)?;
                sum += dot(&m, step, step).sqrt() * rail.density(edge, &m, spacing);
                along.push(sum);
                if i == 0 {
                    firsts.push(rail.first(edge, &m));
                }
            }
            sums.push(along);
        }
        Ok(Self { rails, sums, firsts })
    }

    /// Number of parts that each rail is cut into, where samples are `spacing` apart.
    pub(super) fn parts(&self, spacing: f64) -> Vec<u32> {
        let length = |sums: &Vec<f64>| sums[sums.len() - 1];
        let rails = self.sums.iter().zip(&self.firsts);
        rails
            .map(|(sums, first)| (length(sums) / spacing + 1.0 - first).round().clamp(1.0, 1e7) as u32)
            .collect()
    }

    /// The point of rail `r` after so many of `count` parts.
    fn point(&self, r: usize, parts: f64, count: u32) -> DVec2 {
        let sums = &self.sums[r];
        let steps = sums.len() - 1;
        let skipped = 1.0 - self.firsts[r];
        let target = (parts - skipped) / (f64::from(count) - skipped) * sums[steps];
        let i = sums.partition_point(|&sum| sum <= target).clamp(1, steps) - 1;
        let s = (i as f64 + (target - sums[i]) / (sums[i + 1] - sums[i])) / steps as f64;
        self.rails[r].point(s)
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
                    let p = self.point(r as usize, f64::from(i) + JITTER * random.triple()[0], count);
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
