//! From a wave on points to a wave on another surface.
//!
//! In: a graph with a solved wave, a point cloud mostly, and another graph of the same shape. Out: direction, frequency
//! and phasor at each vertex of the other one. The k nearest points predict the phase there as the corners of a triangle
//! do inside it (Eq. 13 and 14 of Lichtenberg et al. 2018), with weights that fall to 0 at the farthest of them.

use super::{
    kite::{aligned_distance, cmul, phasor, reversed},
    solver::normalize_or,
};
use crate::{
    field::{Symmetry, project_tangent},
    parallel,
    surface::{KdTree, SurfaceGraph},
};
use bevy::math::{Vec2, Vec3};

/// A wave at the vertices of a graph, in solver order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CarriedWave {
    /// Unit tangents d.
    pub directions: Vec<Vec3>,
    /// Frequencies f, in stripes per unit length.
    pub frequencies: Vec<f32>,
    /// Unit phasors z; each refers to the sign of d as it is here.
    pub phasors: Vec<Vec2>,
}

/// Points from which a vertex is predicted.
const POINTS: usize = 6;
/// A point on the other side of a sheet does not count.
const SAME_SIDE: f32 = 0.2;

/// Carries a wave from `from` onto the vertices of `onto`. The slices have one entry per vertex of `from`, in solver
/// order: unit `directions`, `frequencies` in stripes per unit length, `phasors` of any modulus.
///
/// # Panics
/// Where a slice is shorter than the graph.
pub fn carry_wave(
    from: &SurfaceGraph,
    directions: &[Vec3],
    frequencies: &[f32],
    phasors: &[Vec2],
    symmetry: Symmetry,
    onto: &SurfaceGraph,
) -> CarriedWave {
    let tree = KdTree::new(&from.positions);
    let at = |i: usize| {
        let (place, normal) = (onto.positions[i], onto.normals[i]);
        let mut near = tree.nearest_to(place, POINTS);
        let reach = near
            .last()
            .map_or(0.0, |&far| from.positions[far as usize].distance(place));
        let aside = |&j: &u32| from.normals[j as usize].dot(normal) > SAME_SIDE;
        if near.iter().any(aside) {
            near.retain(aside);
        }
        let first = near.first().map_or(Vec3::ZERO, |&j| directions[j as usize]);
        // Weight, direction and phasor of each point, turned to point as the nearest one does.
        let turned = |&j: &u32| {
            let (j, t) = (
                j as usize,
                from.positions[j as usize].distance(place) / reach.max(f32::MIN_POSITIVE),
            );
            let opposed = symmetry == Symmetry::Line && directions[j].dot(first) < 0.0;
            let z = normalize_or(phasors[j], Vec2::X);
            let (d, z) = if opposed {
                (-directions[j], reversed(z))
            } else {
                (directions[j], z)
            };
            // The farthest point counts a little, so that there is always one that counts.
            let weight = (1.0 - t * t).powi(2) + 1e-4;
            (j, weight, d, z)
        };
        let points: Vec<_> = near.iter().map(turned).collect();
        let total: f32 = points.iter().map(|&(_, weight, ..)| weight).sum();
        let mean: Vec3 = points.iter().map(|&(_, weight, d, _)| weight * d).sum();
        let direction = project_tangent(mean.normalize_or_zero(), normal);
        let frequency = points
            .iter()
            .map(|&(j, weight, ..)| weight * frequencies[j])
            .sum::<f32>()
            / total.max(1e-4);
        let predicted = |&(j, weight, d, z): &(usize, f32, Vec3, Vec2)| {
            let distance = aligned_distance(place - from.positions[j], d, direction);
            weight * cmul(z, phasor(0.5 * (frequencies[j] + frequency) * distance))
        };
        let sum: Vec2 = points.iter().map(predicted).sum();
        (direction, frequency, normalize_or(sum, Vec2::X))
    };
    let waves = parallel::collect(onto.len(), at);
    CarriedWave {
        directions: waves.iter().map(|wave| wave.0).collect(),
        frequencies: waves.iter().map(|wave| wave.1).collect(),
        phasors: waves.iter().map(|wave| wave.2).collect(),
    }
}
