//! The nearest of many points in space.
//!
//! In: points. Out: for any place the point nearest to it, by a balanced k-d tree that is stored as a permutation.

use bevy::prelude::*;

/// A k-d tree: the middle of each range is its root, the two halves are its subtrees.
pub(super) struct PointTree<'a> {
    points: &'a [Vec3],
    order: Vec<u32>,
}

impl<'a> PointTree<'a> {
    pub(super) fn new(points: &'a [Vec3]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        build(points, &mut order, 0);
        Self { points, order }
    }

    /// The index of the nearest point; `None` where there is none.
    pub(super) fn nearest(&self, place: Vec3) -> Option<u32> {
        let mut best = (f32::INFINITY, None);
        self.search(&self.order, 0, place, &mut best);
        best.1.or(self.order.first().copied())
    }

    fn search(&self, order: &[u32], axis: usize, place: Vec3, best: &mut (f32, Option<u32>)) {
        let middle = order.len() / 2;
        let Some(&root) = order.get(middle) else { return };
        let point = self.points[root as usize];
        let square = point.distance_squared(place);
        if square < best.0 {
            *best = (square, Some(root));
        }
        let side = place[axis] - point[axis];
        let (before, after) = (&order[..middle], &order[middle + 1..]);
        let (near, far) = if side < 0.0 { (before, after) } else { (after, before) };
        self.search(near, (axis + 1) % 3, place, best);
        if side * side < best.0 {
            self.search(far, (axis + 1) % 3, place, best);
        }
    }
}

fn build(points: &[Vec3], order: &mut [u32], axis: usize) {
    if order.len() < 2 {
        return;
    }
    let middle = order.len() / 2;
    let key = |&i: &u32| points[i as usize][axis];
    order.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    let (before, after) = order.split_at_mut(middle);
    build(points, before, (axis + 1) % 3);
    build(points, &mut after[1..], (axis + 1) % 3);
}
