//! Edge constants: what every node sees of its neighbours; the twin of `edges.wgsl`.
//!
//! In: a graph, directions and frequencies, or the constants of a finer level. Out: [`Edges`], and the sum of weights per
//! node.

use super::{
    kite::{aligned_distance, cmul, phasor, reversed},
    solver::{Pins, chunk_len},
    waves::{Coupling, Waves, frame, turned},
};
use crate::surface::{Level, SurfaceGraph};
use bevy::{
    math::{Vec2, Vec3},
    tasks::{ComputeTaskPool, TaskPool},
};

/// The edge constants of one level: those of wave r over edge k at `waves * k + r`.
#[derive(Debug, Clone, PartialEq)]
pub struct Edges {
    waves: usize,
    constants: Constants,
    /// How much each node is drawn to a crest (below 0: to a trough), as the weight of an edge; empty where none is.
    pins: Vec<f32>,
}

#[derive(Debug, Clone, PartialEq)]
enum Constants {
    /// The mesh: `E = w e^{iΦ_ji}` per directed edge; the lowest bit of E.x says that the edge flips, that of E.y that the
    /// source is the other wave.
    Fine(Vec<Vec2>),
    /// A coarse level: A and B per directed edge; the lowest bit of A.y says that the source is the other wave.
    Coarse(Vec<[Vec2; 2]>),
}

impl Edges {
    pub(super) fn coarse(waves: usize, pairs: Vec<[Vec2; 2]>) -> Self {
        Self {
            waves,
            constants: Constants::Coarse(pairs),
            pins: Vec::new(),
        }
    }

    /// Draws vertices to crests, z = i (which a reversed direction sees at the same place), or to troughs. The first wave
    /// is, and both of a cross field. The weights are added to `sums`.
    pub fn pin(&mut self, sums: &mut [f32], pins: Pins, waves: Waves) {
        let count = self.waves;
        self.pins = vec![0.0; sums.len()];
        for (node, (pin, sum)) in self.pins.iter_mut().zip(sums).enumerate() {
            let is_drawn = node % count == 0 || waves == Waves::Cross;
            if is_drawn && pins.vertices.get(node / count) == Some(&true) {
                *pin = pins.pull;
                *sum += pins.pull.abs();
            }
        }
    }

    /// Number of waves, 1 or 2; node n of wave r is number `waves * n + r` in all lists of phasors and sums.
    pub fn waves(&self) -> usize {
        self.waves
    }

    /// The wave of the source that wave `r` of the target of edge `k` sees.
    pub fn source(&self, k: usize, r: usize) -> usize {
        let y = match &self.constants {
            Constants::Fine(e) => e[self.waves * k + r].y,
            Constants::Coarse(ab) => ab[self.waves * k + r][0].y,
        };
        r ^ (y.to_bits() as usize & (self.waves - 1))
    }

    /// What wave `r` of the target of edge `k` sees of its source's phasor `z`.
    pub fn seen(&self, k: usize, r: usize, z: Vec2) -> Vec2 {
        match &self.constants {
            Constants::Fine(e) => {
                let e = e[self.waves * k + r];
                let seen = cmul(e, z);
                if flips(e) { reversed(seen) } else { seen }
            }
            Constants::Coarse(ab) => {
                let [a, b] = ab[self.waves * k + r];
                cmul(a, z) + cmul(b, conj(z))
            }
        }
    }

    /// What wave `r` of node `i` sees in sum, and what it is drawn to; `z` is the phasor of a node's wave.
    pub fn seen_sum(&self, level: &Level, i: usize, r: usize, z: impl Fn(usize) -> Vec2) -> Vec2 {
        let pull = self.pins.get(self.waves * i + r).copied().unwrap_or(0.0);
        level.edges(i).fold(Vec2::new(0.0, pull), |t, k| {
            let source = self.waves * level.neighbors[k] as usize + self.source(k, r);
            t + self.seen(k, r, z(source))
        })
    }

    /// The pair (A, B) of edge `k`: wave `r` of the target sees A z + B conj(z).
    pub(super) fn pair(&self, k: usize, r: usize) -> [Vec2; 2] {
        match &self.constants {
            Constants::Fine(e) => {
                let e = e[self.waves * k + r];
                if flips(e) {
                    [Vec2::ZERO, reversed(e)]
                } else {
                    [e, Vec2::ZERO]
                }
            }
            Constants::Coarse(ab) => ab[self.waves * k + r],
        }
    }
}

pub(super) fn conj(z: Vec2) -> Vec2 {
    Vec2::new(z.x, -z.y)
}

fn flips(e: Vec2) -> bool {
    e.x.to_bits() & 1 == 1
}

fn with_bit(x: f32, bit: bool) -> f32 {
    f32::from_bits((x.to_bits() & !1) | u32::from(bit))
}

/// `z` with the mark that its source is the other wave.
pub(super) fn with_swap(z: Vec2, swap: bool) -> Vec2 {
    Vec2::new(z.x, with_bit(z.y, swap))
}

/// The edge pass (Eq. 3, kite form): `w e^{iΦ_ji}`, flip and source of every directed edge, and the sum of weights per
/// node.
///
/// `directions` and `frequencies` are one per vertex, in solver order; `Φ_ji = 2π (f_i + f_j)/2` times the aligned distance.
pub fn edges(
    graph: &SurfaceGraph,
    directions: &[Vec3],
    frequencies: &[f32],
    coupling: impl Into<Coupling>,
) -> (Edges, Vec<f32>) {
    let coupling = coupling.into();
    let waves = coupling.waves.count();
    let factors = [1.0, coupling.waves.ratio()];
    let frame = |v: usize| frame(directions[v], graph.normals[v]);
    let level = graph.mesh_level();
    let mut e = vec![Vec2::ZERO; waves * level.neighbors.len()];
    let mut sums = vec![0.0; waves * level.len()];
    let chunk = chunk_len(level.len());
    let pool = ComputeTaskPool::get_or_init(TaskPool::default);
    pool.scope(|scope| {
        let mut rest = e.as_mut_slice();
        for (c, sums) in sums.chunks_mut(waves * chunk).enumerate() {
            let first = c * chunk;
            let start = level.offsets[first] as usize;
            let end = level.offsets[first + sums.len() / waves] as usize;
            let (e, tail) = rest.split_at_mut(waves * (end - start));
            rest = tail;
            scope.spawn(async move {
                for (n, sums) in sums.chunks_mut(waves).enumerate() {
                    let i = first + n;
                    let d_i = frame(i);
                    for k in level.edges(i) {
                        let j = level.neighbors[k] as usize;
                        let d_j = frame(j);
                        let turns = coupling.quarter_turns(d_j, d_i);
                        let v = graph.positions[i] - graph.positions[j];
                        let frequency = 0.5 * (frequencies[i] + frequencies[j]);
                        for (r, sum) in sums.iter_mut().enumerate() {
                            let (m, flip) = turned(turns, r);
                            let d_i = if flip { -d_i[r] } else { d_i[r] };
                            let weight = d_i.dot(d_j[m]).max(0.0);
                            let periods = factors[r] * frequency * aligned_distance(v, d_j[m], d_i);
                            let mut constant = with_swap(weight * phasor(periods), m != r);
                            constant.x = with_bit(constant.x, flip);
                            e[waves * (k - start) + r] = constant;
                            *sum += weight;
                        }
                    }
                }
            });
        }
    });
    let edges = Edges {
        waves,
        constants: Constants::Fine(e),
        pins: Vec::new(),
    };
    (edges, sums)
}
