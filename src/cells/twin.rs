//! What the fragment shader computes, on the CPU: the functions of `cells.wgsl` of the same names.
//!
//! In: a sample set, a triangle and a point in it. Out: the sample whose cell the point is in, and how far it is from the
//! cell's border: the best of three seeds, then descent over the neighbour ring (Kratz et al. 2013, section 6).

use super::layout::Site;
use crate::sampling::SampleSet;
use bevy::prelude::*;

/// Rounds of the descent, each over one neighbour ring; as in `cells.wgsl`.
pub const MAX_ROUNDS: usize = 8;

/// The sample whose cell a point is in: of the triangle's three seeds the nearest in its own metric, then its nearest
/// neighbour, as long as there is a nearer one. `None` for a triangle that is none, or seeds that are no samples.
pub fn label(set: &SampleSet, triangle: usize, point: Vec3) -> Option<usize> {
    let seeds = set.seeds.get(triangle)?;
    let mut best = nearest(set, point, seeds.iter())?;
    for _ in 0..MAX_ROUNDS {
        match nearest(set, point, set.ring(best).iter()) {
            Some(next) if set.distance_squared(next, point) < set.distance_squared(best, point) => best = next,
            _ => break,
        }
    }
    Some(best)
}

fn nearest<'a>(set: &SampleSet, point: Vec3, samples: impl Iterator<Item = &'a u32>) -> Option<usize> {
    let distance = |i: usize| set.distance_squared(i, point);
    samples
        .map(|&i| i as usize)
        .filter(|&i| i < set.len())
        .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
}

/// Distance of a point from the border of a sample's cell to first order, in the set's units: the least, over the sample's
/// ring, of `(d_j² - d_i²) / |∇(d_j² - d_i²)|`, the gradient taken along the surface, whose unit normal is `normal`.
/// Infinite for a cell without neighbours.
pub fn border(set: &SampleSet, sample: usize, point: Vec3, normal: Vec3) -> f32 {
    let site = |i: usize| Site::new(set.positions[i], set.normals[i], set.metrics[i]);
    let seen = |i: usize| {
        let site = site(i);
        let offset = site.metric_offset(point);
        (offset.length_squared(), site.gradient(offset))
    };
    let (own, own_gradient) = seen(sample);
    let towards = |&j: &u32| {
        let (other, gradient) = seen(j as usize);
        let slope = (gradient - own_gradient).reject_from_normalized(normal).length();
        (other - own) / (2.0 * slope).max(1e-30)
    };
    set.ring(sample).iter().map(towards).fold(f32::INFINITY, f32::min)
}
