//! Samples are inserted into the triangles that are covered least.
//!
//! In: a triangulation with metrics. Out: the same with more free vertices, and no violated edge around them. The fill
//! rate of a triangle is (π/2)/A, A its metric area (Eq. 6, with 1/√det M for det M): the part of it that the ellipses of
//! its corners cover. A sample goes to the barycentre of a triangle, shifted a little at random.

use super::{
    metric::ScaledMetric,
    random::Random,
    triangulation::{Triangulation, Vertex},
};
use crate::error::PatternError;
use bevy::math::DVec2;
use std::collections::VecDeque;

/// By how much the weights of the corners differ from 1 at most, where a sample is inserted.
const JITTER: f64 = 0.12;
/// Below this part of the first triangles' area a triangle is not divided further: numbers are at their end.
const SMALLEST: f64 = 1e-22;
/// Buckets of the queue: 4 per doubling of the area.
const BUCKETS: usize = 160;

/// In which order triangles are divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Insertion {
    /// The triangle of the largest metric area first, up to 19 %: an even set from the start.
    #[default]
    LargestFirst,
    /// First in, first out, as in the paper: a little faster for many samples, less even.
    Fifo,
}

/// What insertion needs beside the triangulation.
pub(super) struct Inserter<'a> {
    pub(super) metric: ScaledMetric<'a>,
    pub(super) random: Random,
    /// Square of the smallest euclidean area that is still divided.
    smallest: f64,
}

impl<'a> Inserter<'a> {
    pub(super) fn new(metric: ScaledMetric<'a>, random: Random, ground_area: f64) -> Self {
        Self {
            metric,
            random,
            smallest: SMALLEST * ground_area,
        }
    }

    /// Divides triangles whose metric area is above `largest`, the largest first, until there are `count` vertices.
    pub(super) fn largest_first(
        &mut self,
        mesh: &mut Triangulation,
        largest: f64,
        count: usize,
    ) -> Result<(), PatternError> {
        let floor = largest * largest;
        let mut queue = Buckets::new(floor);
        for t in 0..mesh.triangles.len() as u32 {
            queue.push(t, mesh.metric_area_squared(t as usize));
        }
        while mesh.vertices.len() < count {
            let Some((t, bucket)) = queue.pop() else {
                break;
            };
            // The triangle may have changed since.
            let area_squared = mesh.metric_area_squared(t as usize);
            if area_squared <= floor {
                continue;
            }
            if queue.bucket(area_squared) < bucket {
                queue.push(t, area_squared);
                continue;
            }
            self.insert(mesh, t, |t, area_squared| queue.push(t, area_squared))?;
        }
        Ok(())
    }

    /// Divides triangles whose metric area is above `largest` in the order in which they came to be, until there are
    /// `count` vertices.
    pub(super) fn fifo(&mut self, mesh: &mut Triangulation, largest: f64, count: usize) -> Result<(), PatternError> {
        let floor = largest * largest;
        let mut queue: VecDeque<u32> = (0..mesh.triangles.len() as u32).collect();
        while mesh.vertices.len() < count {
            let Some(t) = queue.pop_front() else {
                break;
            };
            if mesh.metric_area_squared(t as usize) <= floor {
                continue;
            }
            self.insert(mesh, t, |t, area_squared| {
                if area_squared > floor {
                    queue.push_back(t);
                }
            })?;
        }
        Ok(())
    }

    /// Inserts the largest first until there are exactly `count` vertices, whatever the metric.
    pub(super) fn exactly(&mut self, mesh: &mut Triangulation, count: usize) -> Result<(), PatternError> {
        let missing = |mesh: &Triangulation| count.saturating_sub(mesh.vertices.len());
        let mut largest = mesh.total_area() / (2 * count + 2) as f64;
        while missing(mesh) > 0 {
            self.largest_first(mesh, largest, count)?;
            if missing(mesh) > 0 && largest == 0.0 {
                return Err(PatternError::Domain(
                    "there are more samples asked for than numbers can tell apart",
                ));
            }
            largest = if largest > 1e-30 { largest / 4.0 } else { 0.0 };
        }
        Ok(())
    }

    /// Inserts a vertex near the barycentre of a triangle. `done` is told each new triangle and its squared metric area.
    #[inline]
    pub(super) fn insert(
        &mut self,
        mesh: &mut Triangulation,
        t: u32,
        done: impl FnMut(u32, f64),
    ) -> Result<(), PatternError> {
        let [a, b, c] = mesh.corners(t as usize);
        let (a, b, c) = (a.p, b.p, c.p);
        if (b - a).perp_dot(c - a) <= self.smallest {
            return Ok(());
        }
        let [wa, wb, wc] = self.random.triple().map(|r| 1.0 + JITTER * r);
        let p: DVec2 = (wa * a + wb * b + wc * c) / (wa + wb + wc);
        let m = self.metric.at(p, mesh.vertices.len())?;
        let star = mesh.split(t, Vertex { p, m });
        mesh.settle_star(&star, done);
        Ok(())
    }
}

/// A queue of triangles by squared area, that forgets those at or below a floor.
struct Buckets {
    buckets: Vec<Vec<u32>>,
    top: usize,
    to_floor: f64,
}

impl Buckets {
    fn new(floor: f64) -> Self {
        Self {
            buckets: vec![Vec::new(); BUCKETS],
            top: 0,
            to_floor: 1.0 / floor,
        }
    }

    /// The exponent and the first bit of the mantissa number the buckets.
    #[inline]
    fn bucket(&self, area_squared: f64) -> usize {
        let ratio = (area_squared * self.to_floor) as f32;
        ((ratio.to_bits() >> 22) as usize)
            .saturating_sub(127 << 1)
            .min(BUCKETS - 1)
    }

    #[inline]
    fn push(&mut self, t: u32, area_squared: f64) {
        if area_squared * self.to_floor > 1.0 {
            let bucket = self.bucket(area_squared);
            self.top = self.top.max(bucket);
            self.buckets[bucket].push(t);
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<(u32, usize)> {
        loop {
            if let Some(t) = self.buckets[self.top].pop() {
                return Some((t, self.top));
            }
            self.top = self.top.checked_sub(1)?;
        }
    }
}
