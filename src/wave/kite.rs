//! The aligned distance between two vertices: how far the phase advances along an edge.
//!
//! Two directions d_j, d_i in a plane meet the circle through v_j and v_i around their common centre C at a right angle;
//! the difference of the two radii is the distance that a wave front travels from v_j to v_i (Eq. 2 of Lichtenberg et
//! al. 2018). In closed form it is the kite ⟨e, d_j + d_i⟩ / (1 + ⟨d_i, d_j⟩), which needs neither C nor an angle, and is
//! exact for parallel and for radial fields.

use crate::field::Symmetry;
use bevy::math::{Vec2, Vec3};

/// Aligned distance from a source j to a target i over the edge `e = v_i - v_j`, for directions that are oriented alike
/// (⟨d_i, d_j⟩ ≥ 0); Eq. 2. In units of `e`; at most √2 |e|.
pub fn aligned_distance(e: Vec3, d_j: Vec3, d_i: Vec3) -> f32 {
    e.dot(d_j + d_i) / (1.0 + d_i.dot(d_j).max(0.0))
}

/// A directed edge from a source j to a target i, as the solver sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgePhase {
    /// Aligned distance, in units of the edge.
    pub distance: f32,
    /// Weight |⟨d_i, d_j⟩| (line) or max(0, ⟨d_i, d_j⟩) (vector), in 0..=1.
    pub weight: f32,
    /// d_i and d_j point against each other on a line field, so that the phase of j is seen as π - Φ_j.
    pub flip: bool,
}

/// The aligned distance, weight and flip of an edge (Eq. 2 and 7; the flip is the sign of ⟨d_i, d_j⟩).
pub fn edge_phase(e: Vec3, d_j: Vec3, d_i: Vec3, symmetry: Symmetry) -> EdgePhase {
    let c = d_i.dot(d_j);
    let flip = symmetry == Symmetry::Line && c < 0.0;
    let (s, weight) = if flip { (-1.0, -c) } else { (1.0, c.max(0.0)) };
    EdgePhase {
        distance: aligned_distance(e, d_j, s * d_i),
        weight,
        flip,
    }
}

/// cis(2π·turns): the phasor of a phase given in periods. Whole periods are taken off first, which keeps the precision
/// of phases that are many periods long.
pub fn phasor(turns: f32) -> Vec2 {
    let (sin, cos) = (std::f32::consts::TAU * (turns - turns.round())).sin_cos();
    Vec2::new(cos, sin)
}

/// Complex product.
pub fn cmul(a: Vec2, b: Vec2) -> Vec2 {
    Vec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

/// The phasor of π - Φ: what z becomes when its direction is turned round, -conj(z).
pub fn reversed(z: Vec2) -> Vec2 {
    Vec2::new(-z.x, z.y)
}
