//! The points that are nearest to each point, or to any place.
//!
//! In: points of any distribution. Out: for each of them the k nearest others. A balanced k-d tree: the points are sorted
//! so that the middle one of a range parts it across its longest side, again and again; the tree needs no links.

use crate::parallel;
use bevy::math::{DVec3, Vec3};

/// Ranges of at most this many points are searched one by one.
const LEAF: usize = 8;
/// Searches per task.
const SEARCHES: usize = 512;

/// Points in the order of a balanced tree.
pub(crate) struct KdTree<'a> {
    points: &'a [Vec3],
    /// The root of a range is its middle; what is before it lies below along the root's axis, what is behind it above.
    order: Vec<u32>,
    /// The axis of each root, by its place in `order`.
    axes: Vec<u8>,
}

impl<'a> KdTree<'a> {
    pub(crate) fn new(points: &'a [Vec3]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let mut axes = vec![0; points.len()];
        let mut ranges = vec![(0, points.len())];
        while let Some((start, end)) = ranges.pop() {
            if end - start <= LEAF {
                continue;
            }
            let own = &mut order[start..end];
            let (low, high) = own
                .iter()
                .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &i| {
                    (low.min(points[i as usize]), high.max(points[i as usize]))
                });
            let axis = (high.as_dvec3() - low.as_dvec3()).max_position();
            let half = own.len() / 2;
            own.select_nth_unstable_by(half, |&a, &b| {
                points[a as usize][axis]
                    .total_cmp(&points[b as usize][axis])
                    .then(a.cmp(&b))
            });
            let middle = start + half;
            axes[middle] = axis as u8;
            ranges.extend([(start, middle), (middle + 1, end)]);
        }
        Self { points, order, axes }
    }

    /// For each point the `k` nearest others, nearest first, at equal distance by their index; all others where these are
    /// fewer.
    pub(crate) fn nearest_of_all(&self, k: usize) -> Vec<Vec<u32>> {
        parallel::collect_by(SEARCHES, self.points.len(), |i| self.found(self.points[i], i as u32, k))
    }

    /// The `k` points nearest to a place, in the same order.
    pub(crate) fn nearest_to(&self, place: Vec3, k: usize) -> Vec<u32> {
        self.found(place, u32::MAX, k)
    }

    fn found(&self, place: Vec3, except: u32, k: usize) -> Vec<u32> {
        let mut nearest = Nearest {
            except,
            at: place.as_dvec3(),
            found: Vec::with_capacity(k + 1),
            k,
        };
        self.search(0, self.points.len(), &mut nearest);
        nearest.found.into_iter().map(|(_, point)| point).collect()
    }

    fn search(&self, start: usize, end: usize, nearest: &mut Nearest) {
        let range = &self.order[start..end];
        if range.len() <= LEAF {
            range.iter().for_each(|&i| nearest.consider(i, self.points));
            return;
        }
        let middle = start + range.len() / 2;
        let root = self.order[middle];
        let axis = self.axes[middle] as usize;
        nearest.consider(root, self.points);
        let beyond = nearest.at[axis] - f64::from(self.points[root as usize][axis]);
        let (near, far) = match beyond < 0.0 {
            true => ((start, middle), (middle + 1, end)),
            false => ((middle + 1, end), (start, middle)),
        };
        self.search(near.0, near.1, nearest);
        if beyond * beyond <= nearest.reach() {
            self.search(far.0, far.1, nearest);
        }
    }
}

/// The nearest points found so far.
struct Nearest {
    except: u32,
    at: DVec3,
    /// Squared distance and index, ascending.
    found: Vec<(f64, u32)>,
    k: usize,
}

impl Nearest {
    /// The squared distance up to which a point counts.
    fn reach(&self) -> f64 {
        match self.found.last() {
            Some(&(farthest, _)) if self.found.len() == self.k => farthest,
            _ => f64::INFINITY,
        }
    }

    fn consider(&mut self, i: u32, points: &[Vec3]) {
        let candidate = (self.at.distance_squared(points[i as usize].as_dvec3()), i);
        if i == self.except || candidate.0 > self.reach() {
            return;
        }
        let place = self.found.partition_point(|&found| found < candidate);
        self.found.insert(place, candidate);
        self.found.truncate(self.k);
    }
}
