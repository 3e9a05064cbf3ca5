//! From a wave on points to a wave on another surface.
//!
//! In: a graph with a solved wave, a point cloud mostly, and another graph of the same shape. Out: direction, frequency
//! and phasors at each vertex of the other one. The k nearest points predict the phase there as the corners of a triangle
//! do inside it (Eq. 13 and 14 of Lichtenberg et al. 2018), with weights that fall to 0 at the farthest of them.

use super::{
    kite::{aligned_distance, cmul, phasor, reversed},
    layout::NO_VERTEX,
    solver::normalize_or,
    waves::{Coupling, frame, turned},
};
use crate::{
    error::PatternError,
    field::{DirectionField, project_tangent},
    parallel,
    surface::{KdTree, SurfaceGraph},
};
use bevy::prelude::*;

/// Draws the pattern of another entity, a point cloud mostly, on the mesh of this one, and follows it as it changes. It takes
/// the place of the entity's own field, frequency, symmetry, number of waves and space; they are those of the other one. Once it
/// is removed, the entity has its own again.
///
/// Each vertex of the mesh takes what its nearest points predict for it. Points and mesh must lie at the same place in their own
/// spaces; where their entities stand counts for nothing, so both may be seen side by side. What is carried is not solved on the
/// mesh: the mesh may be as fine as it likes.
///
/// The other entity needs a pattern of its own; it need not be seen.
/// [`PatternError::Carried`] and [`PatternError::MissingEntity`] tell where there is none.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq)]
#[reflect(Component)]
#[require(DirectionField)]
pub struct CarriesPattern {
    /// The entity with the pattern.
    #[entities]
    pub of: Entity,
}

impl CarriesPattern {
    /// Whether an entity may carry this, given whether the other one carries a pattern as well.
    pub(super) fn check(self, own: Entity, other_carries: bool) -> Result<(), PatternError> {
        match self.of {
            of if of == own => Err(PatternError::Carried("an entity cannot carry its own pattern")),
            _ if other_carries => Err(PatternError::Carried("the other entity carries a pattern itself")),
            _ => Ok(()),
        }
    }
}

/// A wave at the vertices of a graph, in solver order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CarriedWave {
    /// Unit tangents d.
    pub directions: Vec<Vec3>,
    /// Frequencies f, in stripes per unit length.
    pub frequencies: Vec<f32>,
    /// Unit phasors z, those of all waves of a vertex together; each refers to d as it is here.
    pub phasors: Vec<Vec2>,
}

/// Points from which a vertex is predicted.
pub(super) const POINTS: usize = 6;
/// A point on the other side of a sheet does not count.
const SAME_SIDE: f32 = 0.2;

/// For each vertex of `onto` the nearest of `from`, nearest first; [`NO_VERTEX`] where there are fewer.
pub(super) fn nearest_points(from: &[Vec3], onto: &[Vec3]) -> Vec<[u32; POINTS]> {
    let tree = KdTree::new(from);
    parallel::collect_by(512, onto.len(), |i| {
        let mut points = [NO_VERTEX; POINTS];
        for (point, near) in points.iter_mut().zip(tree.nearest_to(onto[i], POINTS)) {
            *point = near;
        }
        points
    })
}

/// Carries waves from `from` onto the vertices of `onto`. `directions` and `frequencies` have one entry per vertex of
/// `from`, in solver order: unit tangents, and stripes per unit length; `phasors`, of any modulus, one per wave of a vertex.
///
/// # Panics
/// Where a slice is shorter than that.
pub fn carry_wave(
    from: &SurfaceGraph,
    directions: &[Vec3],
    frequencies: &[f32],
    phasors: &[Vec2],
    coupling: impl Into<Coupling>,
    onto: &SurfaceGraph,
) -> CarriedWave {
    let coupling = coupling.into();
    let waves = coupling.waves.count();
    let factors = [1.0, coupling.waves.ratio()];
    let nearest = nearest_points(&from.positions, &onto.positions);
    let at = |i: usize| {
        let (place, normal) = (onto.positions[i], onto.normals[i]);
        let mut near: Vec<usize> = nearest[i]
            .iter()
            .filter(|&&j| j != NO_VERTEX)
            .map(|&j| j as usize)
            .collect();
        let reach = near.last().map_or(0.0, |&far| from.positions[far].distance(place));
        let aside = |&j: &usize| from.normals[j].dot(normal) > SAME_SIDE;
        if near.iter().any(aside) {
            near.retain(aside);
        }
        let frame_of = |j: usize| frame(directions[j], from.normals[j]);
        let first = near.first().map_or([Vec3::ZERO; 2], |&j| frame_of(j));
        // Weight of each point, and the turns after which its frame points as the nearest one's does.
        let weighed = |&j: &usize| {
            let t = from.positions[j].distance(place) / reach.max(f32::MIN_POSITIVE);
            // The farthest point counts a little, so that there is always one that counts.
            let weight = (1.0 - t * t).max(0.0).powi(2) + 1e-4;
            (j, weight, coupling.quarter_turns(frame_of(j), first))
        };
        let points: Vec<_> = near.iter().map(weighed).collect();
        // The direction of wave r of a point after its turns.
        let turned_direction = |j: usize, turns: u32, r: usize| {
            let (m, flip) = turned(turns, r);
            if flip { -frame_of(j)[m] } else { frame_of(j)[m] }
        };
        let total: f32 = points.iter().map(|&(_, weight, _)| weight).sum();
        let mean: Vec3 = points
            .iter()
            .map(|&(j, weight, turns)| weight * turned_direction(j, turns, 0))
            .sum();
        let direction = project_tangent(mean.normalize_or_zero(), normal);
        let sum: f32 = points.iter().map(|&(j, weight, _)| weight * frequencies[j]).sum();
        let frequency = sum / total.max(1e-4);
        let own = frame(direction, normal);
        let z = [0, 1].map(|r| {
            if r >= waves {
                return Vec2::ZERO;
            }
            let predicted = |&(j, weight, turns): &(usize, f32, u32)| {
                let (m, flip) = turned(turns, r);
                let z = normalize_or(phasors[waves * j + m], Vec2::X);
                let z = if flip { reversed(z) } else { z };
                let distance = aligned_distance(place - from.positions[j], turned_direction(j, turns, r), own[r]);
                weight * cmul(z, phasor(factors[r] * 0.5 * (frequencies[j] + frequency) * distance))
            };
            let sum: Vec2 = points.iter().map(predicted).sum();
            normalize_or(sum, Vec2::X)
        });
        (direction, frequency, z)
    };
    let carried = parallel::collect(onto.len(), at);
    CarriedWave {
        directions: carried.iter().map(|wave| wave.0).collect(),
        frequencies: carried.iter().map(|wave| wave.1).collect(),
        phasors: carried.iter().flat_map(|wave| wave.2.into_iter().take(waves)).collect(),
    }
}
