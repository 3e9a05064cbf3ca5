//! The wave inside a triangle: the CPU twin of `material/triangle_wave.wgsl` and `material/wave.wgsl`.
//!
//! In: the three shared buffers, a triangle and barycentrics. Out: phase, confidence and gradient there. Eq. 13 and 14 of
//! Lichtenberg et al. 2018: every corner m predicts the phase at P over the aligned distance of `kite.rs`, and the three
//! phasors are added with the barycentrics as weights. On an edge all of it depends on the edge's two ends only (d stays
//! a vector in space, P - v_m too), so the pattern is continuous across triangles of any two planes.
//!
//! On a line field the corners are first turned to point alike. A triangle where that is impossible is *odd*: there the
//! three edges' own waves are blended with the weights b_i b_j, which keeps sin Φ continuous.

use super::{
    kite::{aligned_distance, cmul, phasor, reversed},
    layout::{FLAG_DISCS, FLAG_READY, FLAG_VECTOR, PatternRecord},
};
use crate::field::Symmetry;
use bevy::math::{Mat3, Vec2, Vec3, Vec4};
use std::f32::consts::TAU;

/// Guards divisions; far below anything that can be seen.
pub(super) const TINY: f32 = 1e-37;
/// Barycentrics of an odd triangle are kept above this, so that its edge weights never vanish together at a corner.
pub(super) const MIN_EDGE_WEIGHT: f32 = 1e-9;

/// The three corners of a triangle and what is known at them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corners {
    /// Rest positions v_m, in units of the mesh.
    pub position: [Vec3; 3],
    /// Unit directions d_m.
    pub direction: [Vec3; 3],
    /// Frequencies f_m, in periods per unit length.
    pub frequency: Vec3,
    /// Phasors z_m; only their argument counts.
    pub z: [Vec2; 3],
}

/// What the wave is at one point of a surface.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wave {
    /// There is a pattern here: the triangle belongs to a record that is ready to be drawn.
    pub defined: bool,
    /// The phase itself is defined, not only its sine ([`Symmetry::Vector`]).
    pub vector: bool,
    /// The corners of this triangle cannot be turned to point alike.
    pub odd: bool,
    /// sin Φ, in -1..=1; continuous across edges for both symmetries.
    pub value: f32,
    /// cis Φ, of modulus 1. On a line field it belongs to this triangle's frame: the neighbour may see π - Φ.
    pub phasor: Vec2,
    /// How well the corners agree, 0 (a branch) to 1.
    pub confidence: f32,
    /// ∇Φ / 2π in the triangle's plane, in periods per unit length.
    pub gradient: Vec3,
    /// Unit direction d at the point, oriented as the phase is; not projected onto the triangle.
    pub direction: Vec3,
    /// Frequency f at the point, in periods per unit length.
    pub frequency: f32,
    /// Rest position, in units of the mesh.
    pub position: Vec3,
    /// Unit normal of the triangle; zero if it has no area.
    pub normal: Vec3,
}

/// The contents of the shared buffers of [`layout`](super::layout).
#[derive(Debug, Clone, Copy)]
pub struct PatternMemory<'a> {
    /// Records and triangles.
    pub surface: &'a [u32],
    /// Positions and normals.
    pub geometry: &'a [Vec4],
    /// Directions, frequencies and phasors.
    pub wave: &'a [Vec2],
}

impl PatternMemory<'_> {
    /// The record at a tag; a record of zeros where there is none.
    pub fn record(&self, tag: u32) -> PatternRecord {
        let words = size_of::<PatternRecord>() / 4;
        let start = tag as usize;
        self.surface
            .get(start..start + words)
            .map_or_else(PatternRecord::default, |words| {
                bytemuck::pod_read_unaligned(bytemuck::cast_slice(words))
            })
    }

    /// What is known of a wave (0 or 1) at the corners of a triangle; `None` if the record has no such triangle or wave, or
    /// points outside of the buffers.
    pub fn corners(&self, record: &PatternRecord, triangle: u32, wave: u32) -> Option<Corners> {
        let waves = record.waves.max(1);
        if triangle >= record.triangles || wave >= waves {
            return None;
        }
        let start = (record.triangle_base + 3 * triangle) as usize;
        let vertices = self.surface.get(start..start + 3)?;
        let mut corners = Corners {
            position: [Vec3::ZERO; 3],
            direction: [Vec3::ZERO; 3],
            frequency: Vec3::ZERO,
            z: [Vec2::ZERO; 3],
        };
        for (m, &vertex) in vertices.iter().enumerate() {
            let geometry = |n: u32| self.geometry.get((record.geometry_base + 2 * vertex + n) as usize);
            corners.position[m] = geometry(0)?.truncate();
            let xy = self.wave.get((record.field_base + 2 * vertex) as usize)?;
            let zf = self.wave.get((record.field_base + 2 * vertex + 1) as usize)?;
            corners.direction[m] = Vec3::new(xy.x, xy.y, zf.x);
            corners.frequency[m] = zf.y;
            corners.z[m] = *self.wave.get((record.phasor_base + waves * vertex + wave) as usize)?;
            if wave == 1 {
                corners.direction[m] = geometry(1)?.truncate().cross(corners.direction[m]);
                corners.frequency[m] *= record.ratio;
            }
        }
        if record.flags & FLAG_DISCS != 0 {
            self.spread_disc(record, &mut corners, vertices[0], triangle, wave)?;
        }
        Some(corners)
    }
}

/// The wave of the pattern at `tag`, in its `triangle`, at barycentrics that sum to 1. Not `defined` where there is no
/// such pattern. Of a pattern with two waves see [`sample_pair`](super::shade_pair::sample_pair).
pub fn sample_wave(memory: &PatternMemory, tag: u32, triangle: u32, barycentrics: Vec3) -> Wave {
    let record = memory.record(tag);
    if tag == 0 || record.flags & FLAG_READY == 0 {
        return Wave::default();
    }
    let symmetry = if record.flags & FLAG_VECTOR != 0 {
        Symmetry::Vector
    } else {
        Symmetry::Line
    };
    memory
        .corners(&record, triangle, 0)
        .map_or_else(Wave::default, |corners| {
            wave_in_triangle(&corners, symmetry, barycentrics)
        })
}

/// The wave at barycentrics `b` of a triangle.
pub fn wave_in_triangle(corners: &Corners, symmetry: Symmetry, b: Vec3) -> Wave {
    let [s01, s12, s20] = edge_signs(corners);
    let mut wave = match symmetry {
        Symmetry::Vector => Wave {
            vector: true,
            ..corner_sum(corners, b, b, barycentric_gradients(corners))
        },
        Symmetry::Line if s01 * s12 * s20 > 0.0 => corner_sum(
            &oriented(corners, Vec3::new(1.0, s01, s20)),
            b,
            b,
            barycentric_gradients(corners),
        ),
        Symmetry::Line => odd_wave(corners, b, [s01, s12, s20]),
    };
    wave.defined = true;
    wave.position = corners.position[0] + offset(corners, 0, b);
    wave.normal = triangle_normal(corners);
    wave
}

/// Signs of ⟨d_0, d_1⟩, ⟨d_1, d_2⟩, ⟨d_2, d_0⟩; the sign of 0 is +.
pub fn edge_signs(corners: &Corners) -> [f32; 3] {
    let [d0, d1, d2] = corners.direction;
    [d0.dot(d1), d1.dot(d2), d2.dot(d0)].map(|c| if c < 0.0 { -1.0 } else { 1.0 })
}

/// The corners with their directions turned by the signs `s`; a phasor whose direction is turned becomes that of π - Φ.
pub fn oriented(corners: &Corners, s: Vec3) -> Corners {
    let mut turned = *corners;
    for m in 0..3 {
        if s[m] < 0.0 {
            turned.direction[m] = -corners.direction[m];
            turned.z[m] = reversed(corners.z[m]);
        }
    }
    turned
}

/// P - v_m from differences of corners, which stays exact far from the origin.
pub(super) fn offset(corners: &Corners, m: usize, b: Vec3) -> Vec3 {
    let v = corners.position;
    Mat3::from_cols(v[0] - v[m], v[1] - v[m], v[2] - v[m]) * b
}

pub(super) fn triangle_normal(corners: &Corners) -> Vec3 {
    let [v0, v1, v2] = corners.position;
    let normal = (v1 - v0).cross(v2 - v0);
    normal / normal.length().max(TINY)
}

/// ∇b_m as columns; zero for a triangle without an area.
pub(super) fn barycentric_gradients(corners: &Corners) -> Mat3 {
    let [v0, v1, v2] = corners.position;
    let normal = (v1 - v0).cross(v2 - v0);
    let n = normal / normal.length_squared().max(TINY);
    Mat3::from_cols(n.cross(v2 - v1), n.cross(v0 - v2), n.cross(v1 - v0))
}

/// Eq. 13 and 14: the phasor sum of corners that are oriented alike, at barycentrics `b`. `weight` is how much each corner
/// counts, `weight_gradient` holds its derivatives as columns.
pub(super) fn corner_sum(corners: &Corners, weight: Vec3, b: Vec3, weight_gradient: Mat3) -> Wave {
    let d_sum = Mat3::from_cols_array_2d(&corners.direction.map(|d| d.to_array())) * weight;
    let d_length = d_sum.length();
    let direction = d_sum / d_length.max(TINY);
    let frequency = weight.dot(corners.frequency);
    let mut sum = Vec2::ZERO;
    let (mut slope_re, mut slope_im) = (Vec3::ZERO, Vec3::ZERO);
    for m in 0..3 {
        let distance = aligned_distance(offset(corners, m, b), corners.direction[m], direction);
        let z = corners.z[m] / corners.z[m].length().max(TINY);
        let prediction = cmul(z, phasor(0.5 * (corners.frequency[m] + frequency) * distance));
        sum += weight[m] * prediction;
        slope_re += prediction.x * weight_gradient.col(m);
        slope_im += prediction.y * weight_gradient.col(m);
    }
    let modulus = sum.length();
    let unit = if modulus > TINY { sum / modulus } else { Vec2::X };
    // Φ = arg Σ w_m p_m: each p_m turns by 2πf d, and the weights shift between predictions that do not agree.
    let disagreement = (unit.x * slope_im - unit.y * slope_re) / (TAU * modulus.max(1e-4));
    Wave {
        value: unit.y,
        phasor: unit,
        // Where the directions of a vector field cancel, no phase is any better than another.
        confidence: modulus * smoothstep(0.05, 0.15, d_length),
        gradient: frequency * in_plane(direction, weight_gradient) + disagreement,
        direction,
        frequency,
        ..Wave::default()
    }
}

/// The part of d in the plane spanned by the gradients of the barycentrics; d itself if they span none.
fn in_plane(d: Vec3, gradients: Mat3) -> Vec3 {
    let normal = gradients.col(0).cross(gradients.col(1));
    d - normal * (normal.dot(d) / normal.length_squared().max(TINY))
}

/// A triangle whose corners cannot be oriented alike: the waves of its three edges, blended by b_i b_j.
fn odd_wave(corners: &Corners, b: Vec3, [s01, s12, s20]: [f32; 3]) -> Wave {
    let inside = b.max(Vec3::splat(MIN_EDGE_WEIGHT));
    let pairs = [
        (
            Vec3::new(inside.x, inside.y, 0.0),
            Vec3::new(1.0, s01, 1.0),
            inside.x * inside.y,
        ),
        (
            Vec3::new(0.0, inside.y, inside.z),
            Vec3::new(1.0, 1.0, s12),
            inside.y * inside.z,
        ),
        (
            Vec3::new(inside.x, 0.0, inside.z),
            Vec3::new(1.0, 1.0, s20),
            inside.z * inside.x,
        ),
    ];
    let total: f32 = pairs.iter().map(|pair| pair.2).sum();
    let mut blend = Wave {
        odd: true,
        ..Wave::default()
    };
    for (ends, signs, product) in pairs {
        let edge = corner_sum(&oriented(corners, signs), ends / ends.element_sum(), b, Mat3::ZERO);
        // Φ and π - Φ are the same here: take the one with cos Φ >= 0, so that gradients can be added.
        let fold = if edge.phasor.x < 0.0 { -1.0 } else { 1.0 };
        let share = product / total;
        blend.value += share * edge.value;
        blend.confidence += share * edge.confidence;
        blend.gradient += share * fold * edge.gradient;
        blend.direction += share * fold * edge.direction;
        blend.frequency += share * edge.frequency;
    }
    blend.phasor = Vec2::new((1.0 - blend.value * blend.value).max(0.0).sqrt(), blend.value);
    blend
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
