//! How good a wave is.
//!
//! In: a graph with directions d, frequencies f and phasors z per vertex. Out: the energy of Eq. 4 and 5 of Lichtenberg et
//! al. 2018 as a weighted mean, the branches, and how far direction and spacing of the stripes are from what was asked.
//! Everything is computed in f64, on the CPU.
//!
//! A triangle is judged in its own frame: its corners' directions are turned to the side of the first one's (on a cross
//! field by quarter turns), and the phases with them (Φ → π - Φ). Around it the phase advances by σ_k = Ω_k + wrap(Φ_{k+1} - Φ_k - Ω_k) per side, where Ω
//! is the advance that d and f ask for; Σ σ / 2π is its winding. The wave's gradient on the triangle is that of the σ_k,
//! less a third of their sum.

use super::waves::{Coupling, Frame, frame, turned};
use crate::surface::SurfaceGraph;
use bevy::{
    math::{DVec2, DVec3},
    prelude::*,
};
use std::f64::consts::TAU;

/// The figures by which waves are compared. Triangles without an area are left out everywhere, odd ones from all other
/// figures of triangles; branches count. Of two waves, means are over both.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Default)]
pub struct Quality {
    /// Weighted mean over the edges of 1 - cos(residual phase): 0 perfect, 1 random, 2 at worst.
    pub energy: f64,
    /// Triangles around which the phase winds: a stripe begins or ends there. Counted for each wave.
    pub branches: usize,
    /// Triangles whose directions cannot be oriented: singularities of the line or cross field itself. 0 for vectors.
    pub odd_triangles: usize,
    /// Share of the area, 0 to 1, on which the wave's gradient is more than 5 degrees off the direction.
    pub angle_over_5deg: f64,
    /// Mean angle between the wave's gradient and the direction, in degrees, 0 to 90, weighted by area.
    pub angle_mean_deg: f64,
    /// Median of the relative error of the frequency, | |∇Φ| / 2πf - 1 |, weighted by area. Where f is 0 it is undefined
    /// and left out.
    pub spacing_p50: f64,
    /// 95 % of the area has at most this relative error of the frequency.
    pub spacing_p95: f64,
}

/// Judges a wave. All slices have one entry per vertex of `graph`, in solver order: unit `directions` (used as given),
/// `frequencies` in stripes per unit length, `phasors` of any modulus (zero counts as phase 0), those of two waves side by
/// side.
///
/// # Panics
/// Where a slice is shorter than the graph.
pub fn quality(
    graph: &SurfaceGraph,
    directions: &[Vec3],
    frequencies: &[f32],
    phasors: &[Vec2],
    coupling: impl Into<Coupling>,
) -> Quality {
    let coupling = coupling.into();
    let waves = Judge {
        positions: &graph.positions,
        frames: (0..graph.len())
            .map(|v| frame(directions[v], graph.normals[v]))
            .collect(),
        frequencies,
        phasors: phasors.iter().map(|z| unit(z.as_dvec2())).collect(),
        coupling,
    };
    let mut quality = Quality {
        energy: waves.energy(graph),
        ..default()
    };
    let mut angles = Vec::new();
    let mut spacings = Vec::new();
    for &triangle in &graph.triangles {
        match waves.judge(triangle) {
            Verdict::Degenerate => {}
            Verdict::Odd => quality.odd_triangles += 1,
            Verdict::Even(waves) => {
                for figures in waves {
                    quality.branches += usize::from(figures.branch);
                    angles.push((figures.angle, figures.area));
                    spacings.extend(figures.spacing.map(|spacing| (spacing, figures.area)));
                }
            }
        }
    }
    let area: f64 = angles.iter().map(|(_, area)| area).sum();
    if area > 0.0 {
        quality.angle_over_5deg = angles
            .iter()
            .filter(|(angle, _)| *angle > 5.0)
            // Summed from 0: the sum of nothing is -0.
            .fold(0.0, |sum, (_, area)| sum + area)
            / area;
        quality.angle_mean_deg = angles.iter().map(|(angle, area)| angle * area).sum::<f64>() / area;
    }
    spacings.sort_by(|a, b| a.0.total_cmp(&b.0));
    quality.spacing_p50 = quantile(&spacings, 0.5);
    quality.spacing_p95 = quantile(&spacings, 0.95);
    quality
}

/// What is judged; phasors are of modulus 1.
struct Judge<'a> {
    positions: &'a [Vec3],
    frames: Vec<Frame>,
    frequencies: &'a [f32],
    phasors: Vec<DVec2>,
    coupling: Coupling,
}

enum Verdict {
    /// No area.
    Degenerate,
    /// Not orientable.
    Odd,
    /// One judgement per wave.
    Even(Vec<Figures>),
}

struct Figures {
    branch: bool,
    /// Between gradient and direction, in degrees.
    angle: f64,
    /// Relative error of the frequency.
    spacing: Option<f64>,
    area: f64,
}

/// A wave at a vertex, turned to the side of another vertex.
#[derive(Clone, Copy)]
struct Sided {
    vertex: usize,
    direction: DVec3,
    phasor: DVec2,
}

impl Judge<'_> {
    fn waves(&self) -> usize {
        self.coupling.waves.count()
    }

    /// The advance of the phase of wave `r` from vertex j with direction d_j to vertex i with d_i, oriented alike, in
    /// radians.
    fn advance(&self, r: usize, j: usize, d_j: DVec3, i: usize, d_i: DVec3) -> f64 {
        let edge = self.positions[i].as_dvec3() - self.positions[j].as_dvec3();
        TAU * 0.5 * (self.frequency(i, r) + self.frequency(j, r)) * aligned_distance(edge, d_j, d_i)
    }

    fn frequency(&self, i: usize, r: usize) -> f64 {
        let ratio = if r == 0 { 1.0 } else { self.coupling.waves.ratio() };
        f64::from(ratio) * f64::from(self.frequencies[i])
    }

    /// Wave `r` of vertex `i` after `k` quarter turns.
    fn sided(&self, i: usize, r: usize, k: u32) -> Sided {
        let (m, flip) = turned(k, r);
        let s = if flip { -1.0 } else { 1.0 };
        let z = self.phasors[self.waves() * i + m];
        Sided {
            vertex: i,
            direction: s * self.frames[i][m].as_dvec3(),
            phasor: DVec2::new(s * z.x, z.y),
        }
    }

    fn energy(&self, graph: &SurfaceGraph) -> f64 {
        let level = graph.mesh_level();
        let (mut energy, mut weights) = (0.0, 0.0);
        for i in 0..level.len() {
            for j in level
                .edges(i)
                .map(|k| level.neighbors[k] as usize)
                .take_while(|&j| j < i)
            {
                let turns = self.coupling.quarter_turns(self.frames[j], self.frames[i]);
                for r in 0..self.waves() {
                    let (target, source) = (self.sided(i, r, 0), self.sided(j, r, turns));
                    let weight = target.direction.dot(source.direction).max(0.0);
                    let advance = self.advance(r, j, source.direction, i, target.direction);
                    let seen = DVec2::from_angle(advance).rotate(source.phasor);
                    // (1 - cos r) without the cancellation.
                    energy += weight * 0.5 * target.phasor.distance_squared(seen);
                    weights += weight;
                }
            }
        }
        if weights > 0.0 { energy / weights } else { 0.0 }
    }

    fn judge(&self, triangle: [u32; 3]) -> Verdict {
        let v = triangle.map(|v| v as usize);
        let p = v.map(|v| self.positions[v].as_dvec3());
        let area = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).length();
        if area <= 0.0 {
            return Verdict::Degenerate;
        }
        let turns = |j: usize, i: usize| self.coupling.quarter_turns(self.frames[v[j]], self.frames[v[i]]);
        let around = [0, turns(1, 0), turns(2, 0)];
        if !(around[1] + turns(2, 1) + 4 - around[2]).is_multiple_of(4) {
            return Verdict::Odd;
        }
        let figures = |r| self.figures(r, p, std::array::from_fn(|c| self.sided(v[c], r, around[c])), area);
        Verdict::Even((0..self.waves()).map(figures).collect())
    }

    /// Judges wave `r` by its `corners`, which point alike.
    fn figures(&self, r: usize, p: [DVec3; 3], corners: [Sided; 3], area: f64) -> Figures {
        let (e1, e2) = (p[1] - p[0], p[2] - p[0]);
        let normal = e1.cross(e2) / (2.0 * area);
        let side = |k: usize| {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            let asked = self.advance(r, from.vertex, from.direction, to.vertex, to.direction);
            asked + wrap(to.phasor.to_angle() - from.phasor.to_angle() - asked)
        };
        let sides = [side(0), side(1), side(2)];
        let defect: f64 = sides.iter().sum();

        // Linear with these differences along e1 and e2.
        let (along_e1, along_e2) = (sides[0] - defect / 3.0, defect / 3.0 - sides[2]);
        let gradient = (along_e1 * e2.cross(normal) + along_e2 * normal.cross(e1)) / (2.0 * area);
        let direction = corners.map(|corner| corner.direction).iter().sum::<DVec3>();
        let direction = direction.reject_from_normalized(normal);
        let frequency = corners
            .map(|corner| self.frequency(corner.vertex, r))
            .iter()
            .sum::<f64>()
            / 3.0;
        Figures {
            branch: (defect / TAU).round() != 0.0,
            angle: gradient
                .cross(direction)
                .length()
                .atan2(gradient.dot(direction).abs())
                .to_degrees(),
            spacing: (frequency > 0.0).then(|| (gradient.length() / (TAU * frequency) - 1.0).abs()),
            area,
        }
    }
}

/// The kite of [`kite`](super::kite) in f64.
fn aligned_distance(e: DVec3, d_j: DVec3, d_i: DVec3) -> f64 {
    e.dot(d_j + d_i) / (1.0 + d_i.dot(d_j).max(0.0))
}

/// To -π ..= π, by whole periods.
fn wrap(phase: f64) -> f64 {
    phase - TAU * (phase / TAU).round()
}

/// NaN stays NaN: a broken wave must not look like a good one.
fn unit(z: DVec2) -> DVec2 {
    if z == DVec2::ZERO { DVec2::X } else { z / z.length() }
}

/// The smallest value such that the values up to it have this share of the weights; 0 of nothing. `values` are pairs of
/// (value, weight) in ascending order.
fn quantile(values: &[(f64, f64)], share: f64) -> f64 {
    let total: f64 = values.iter().map(|(_, weight)| weight).sum();
    let mut below = 0.0;
    for &(value, weight) in values {
        below += weight;
        if below >= share * total {
            return value;
        }
    }
    values.last().map_or(0.0, |&(value, _)| value)
}
