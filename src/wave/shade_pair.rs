//! Two waves inside a triangle, in one frame: the CPU twin of `material/triangle_pair.wgsl`.
//!
//! In: the corners of both waves. Out: both waves at a point, and the texture coordinates that they make (section 3.6 of
//! Lichtenberg et al. 2018). The corners are first turned, by quarter turns, to the first one's frame. Where the turns around the
//! triangle do not close there is no such frame: the triangle is drawn as the blend of three pieces, each of which knows one
//! edge only, so that it meets its neighbours.

use super::{
    kite::reversed,
    layout::{FLAG_CROSS, FLAG_READY, FLAG_VECTOR},
    shade::{
        Corners, MIN_EDGE_WEIGHT, PatternMemory, Wave, barycentric_gradients, corner_sum, offset, triangle_normal,
    },
    waves::{Coupling, Frame, Waves, turned},
};
use crate::field::Symmetry;
use bevy::math::{Mat3, Vec2, Vec3};
use std::f32::consts::TAU;

/// What is known of both waves at the corners of a triangle.
pub type PairCorners = [Corners; 2];

/// Both waves at a point, as one piece of the triangle sees them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WavePair {
    /// The waves along d and along n × d, in the frame of the piece.
    pub waves: [Wave; 2],
    /// Share of the piece, 0..=1; those of all pieces sum to 1.
    pub weight: f32,
}

impl WavePair {
    /// Where a texture is read: u along d, v along n × d, in periods, 0..1, with the crests of both in its middle.
    pub fn uv(&self) -> Vec2 {
        let [u, v] = self
            .waves
            .map(|wave| wave.phasor.to_angle() / TAU + 0.25)
            .map(|turns| turns - turns.floor());
        Vec2::new(u, v)
    }
}

/// Both waves of the pattern at `tag`, in its `triangle`, at barycentrics that sum to 1: one piece, or three where no frame
/// fits all corners. Empty where there is no pattern with two waves.
pub fn sample_pair(memory: &PatternMemory, tag: u32, triangle: u32, barycentrics: Vec3) -> Vec<WavePair> {
    let record = memory.record(tag);
    if tag == 0 || record.flags & FLAG_READY == 0 {
        return Vec::new();
    }
    let corners = [0, 1].map(|wave| memory.corners(&record, triangle, wave));
    let [Some(first), Some(second)] = corners else {
        return Vec::new();
    };
    let coupling = Coupling {
        waves: if record.flags & FLAG_CROSS != 0 {
            Waves::Cross
        } else {
            Waves::ORTHOGONAL
        },
        symmetry: if record.flags & FLAG_VECTOR != 0 {
            Symmetry::Vector
        } else {
            Symmetry::Line
        },
    };
    pair_in_triangle(&[first, second], coupling, barycentrics)
}

/// Both waves at barycentrics `b` of a triangle, piece by piece.
pub fn pair_in_triangle(corners: &PairCorners, coupling: Coupling, b: Vec3) -> Vec<WavePair> {
    let frames: [Frame; 3] = std::array::from_fn(|m| [corners[0].direction[m], corners[1].direction[m]]);
    let one = coupling.quarter_turns(frames[1], frames[0]);
    let two = coupling.quarter_turns(frames[2], frames[0]);
    let across = coupling.quarter_turns(frames[2], frames[1]);
    let vector = coupling.symmetry == Symmetry::Vector;
    if (one + across + 4 - two).is_multiple_of(4) {
        let corners = turn_corner(&turn_corner(corners, 1, one), 2, two);
        let waves = corners.map(|corners| {
            let wave = corner_sum(&corners, b, b, barycentric_gradients(&corners));
            placed(wave, &corners, vector, false, b)
        });
        return vec![WavePair { waves, weight: 1.0 }];
    }
    let inside = b.max(Vec3::splat(MIN_EDGE_WEIGHT));
    let pieces = [
        (1, one, Vec3::new(inside.x, inside.y, 0.0), inside.x * inside.y),
        (2, across, Vec3::new(0.0, inside.y, inside.z), inside.y * inside.z),
        (2, two, Vec3::new(inside.x, 0.0, inside.z), inside.z * inside.x),
    ];
    let total: f32 = pieces.iter().map(|piece| piece.3).sum();
    let piece = |(m, k, ends, product): (usize, u32, Vec3, f32)| {
        let corners = turn_corner(corners, m, k);
        let waves = corners.map(|corners| {
            let wave = corner_sum(&corners, ends / ends.element_sum(), b, Mat3::ZERO);
            placed(wave, &corners, vector, true, b)
        });
        let weight = product / total;
        WavePair { waves, weight }
    };
    pieces.map(piece).to_vec()
}

/// Corner `m` turned by `k` quarter turns.
fn turn_corner(corners: &PairCorners, m: usize, k: u32) -> PairCorners {
    let mut result = *corners;
    for (r, wave) in result.iter_mut().enumerate() {
        let (source, reverse) = turned(k, r);
        let (d, z) = (corners[source].direction[m], corners[source].z[m]);
        (wave.direction[m], wave.z[m]) = if reverse { (-d, reversed(z)) } else { (d, z) };
    }
    result
}

fn placed(wave: Wave, corners: &Corners, vector: bool, odd: bool, b: Vec3) -> Wave {
    Wave {
        defined: true,
        vector,
        odd,
        position: corners.position[0] + offset(corners, 0, b),
        normal: triangle_normal(corners),
        ..wave
    }
}
