//! The solver on the CPU: the twin of every GPU pass, and [`solve_cpu`] for tools and servers without a GPU.
//!
//! In: a graph, a direction d and a frequency f per vertex. Out: a unit phasor z per vertex.
//!
//! Every vertex i sees each neighbour j through the edge's phase Φ_ji (Eq. 3 of Lichtenberg et al. 2018): as
//! `w e^{iΦ_ji} z_j`, or, where the two directions are opposed on a line field, as `-w conj(e^{iΦ_ji} z_j)`. A sweep moves
//! every z_i towards the sum t_i of what it sees, one colour class after the other; each such move lowers the energy
//! E = Σ w (1 - cos r) over the edges, r being the phase an edge is off by (Eq. 4, 5).

use super::{
    hierarchy::cold_start,
    kite::{aligned_distance, cmul, phasor, reversed},
    local_rule::solve_local,
    merged::{Field, solve_merged},
    waves::{Coupling, Waves, frame, turned},
};
pub use super::{
    hierarchy::{Child, align, coarsen, prolong, v_cycle},
    local_rule::{hash_turns, sweep_local},
    settings::{ColdStart, LocalRule, MergedRule, SolverSettings},
};
use crate::surface::{Level, SurfaceGraph};
use bevy::{
    math::{Vec2, Vec3},
    tasks::{ComputeTaskPool, TaskPool},
};

/// How a sweep moves a vertex towards the sum t of what it sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Relaxation {
    /// z ← t / |t|. Never raises the energy.
    Plain,
    /// z turns by about ω times its angle to t; the modulus stays 1. Never raises the energy for 0 < ω < 2.
    Turn {
        /// Over-relaxation ω.
        omega: f32,
    },
    /// Over-relaxation that keeps a modulus: z ← (1-ω) z + ω t / Σw, then z ← z |z|^(p-1). Fastest by far, not monotone.
    Soft {
        /// Over-relaxation ω.
        omega: f32,
        /// Exponent p.
        softness: f32,
    },
}

/// Vertices that are drawn to a crest or a trough ([`CreasePhase`](super::CreasePhase)).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pins<'a> {
    /// Whether each vertex is drawn; no vertex is where the list is empty.
    pub vertices: &'a [bool],
    /// How much, as the weight of an edge: above 0 to a crest, below to a trough.
    pub pull: f32,
}

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

/// z / |z|, or `fallback` where z is next to nothing.
pub fn normalize_or(z: Vec2, fallback: Vec2) -> Vec2 {
    let r = z.length();
    if r > 1e-14 { z / r } else { fallback }
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

/// One sweep: every node moves towards what it sees, colour class by colour class. `sums` (of weights, per node) is used
/// by [`Relaxation::Soft`] only.
pub fn sweep(level: &Level, edges: &Edges, sums: &[f32], z: &mut [Vec2], relaxation: Relaxation) {
    let waves = edges.waves;
    for_each_class(level, waves, z, |node, own, others| {
        let t = edges.seen_sum(level, node / waves, node % waves, |source| others.get(source));
        relax(own, t, sums.get(node).copied().unwrap_or(1.0), relaxation)
    });
}

/// The new phasor of a node that sees `t` in sum, with weights that sum to `sum`.
fn relax(z: Vec2, t: Vec2, sum: f32, relaxation: Relaxation) -> Vec2 {
    match relaxation {
        Relaxation::Plain => normalize_or(t, z),
        Relaxation::Turn { omega } => {
            let r = t.length();
            if r <= 1e-14 {
                return z;
            }
            let t = t / r;
            // The chord's extrapolation turns by a little more than ω; never past the point where E would rise.
            let u = normalize_or(t + (omega - 1.0) * (t - z), t);
            if u.dot(t) < z.dot(t) { t } else { u }
        }
        Relaxation::Soft { omega, softness } => {
            if sum <= 0.0 {
                return z;
            }
            let u = (1.0 - omega) * z + omega * (t / sum);
            let r = u.length();
            if r > 1e-14 { u * r.powf(softness - 1.0) } else { z }
        }
    }
}

/// Mean of 1 - cos r over the undirected edges, weighted (Eq. 5 divided by Σw): 0 is perfect, 1 is random.
pub fn energy(level: &Level, edges: &Edges, sums: &[f32], z: &[Vec2]) -> f32 {
    let mut off = 0.0f64;
    let waves = edges.waves;
    for node in 0..waves * level.len() {
        let (i, r) = (node / waves, node % waves);
        let own = normalize_or(z[node], Vec2::X);
        for k in level.edges(i) {
            let source = waves * level.neighbors[k] as usize + edges.source(k, r);
            let seen = edges.seen(k, r, normalize_or(z[source], Vec2::X));
            // |w z_i - seen|² / 2w = w (1 - cos r), without the cancellation of a difference from 1
            let w = seen.length();
            if w > 0.0 {
                off += f64::from((w * own - seen).length_squared() / (2.0 * w));
            }
        }
    }
    let total: f64 = sums.iter().map(|&s| f64::from(s)).sum();
    if total > 0.0 { (off / total) as f32 } else { 0.0 }
}

/// What a solve did.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The phasors of each vertex (wave r of vertex v at `waves * v + r`), in solver order; z_i refers to d_i as given.
    pub phasors: Vec<Vec2>,
    /// Sweeps made on the finest level.
    pub sweeps: u32,
}

/// Solves from nothing, on the CPU (cold start).
///
/// `directions` (unit tangents) and `frequencies` (stripes per unit length) are one per vertex of `graph`, in solver
/// order.
pub fn solve_cpu(
    graph: &SurfaceGraph,
    directions: &[Vec3],
    frequencies: &[f32],
    coupling: impl Into<Coupling>,
    settings: &SolverSettings,
) -> Solution {
    solve_pinned(graph, directions, frequencies, coupling, Pins::default(), settings)
}

/// [`solve_cpu`] with vertices that are drawn to a crest or a trough.
pub fn solve_pinned(
    graph: &SurfaceGraph,
    directions: &[Vec3],
    frequencies: &[f32],
    coupling: impl Into<Coupling>,
    pins: Pins,
    settings: &SolverSettings,
) -> Solution {
    let (settings, coupling) = (&settings.valid(), coupling.into());
    let (mut fine, mut sums) = edges(graph, directions, frequencies, coupling);
    if !pins.vertices.is_empty() {
        fine.pin(&mut sums, pins, coupling.waves);
    }
    match &settings.cold_start {
        ColdStart::Hierarchy { level_sweeps } => {
            let mut z = cold_start(graph, &fine, *level_sweeps, settings.omega);
            let level = graph.mesh_level();
            sweep_soft(level, &fine, &sums, &mut z, settings.soft_sweeps, true, settings);
            for _ in 0..settings.plain_sweeps {
                sweep(level, &fine, &sums, &mut z, Relaxation::Plain);
            }
            Solution {
                phasors: z,
                sweeps: settings.soft_sweeps + settings.plain_sweeps,
            }
        }
        ColdStart::Local(rule) => solve_local(graph, &fine, &sums, rule),
        ColdStart::Merged(rule) => {
            let field = Field {
                directions: directions.to_vec(),
                frequencies: frequencies.to_vec(),
            };
            solve_merged(graph, field, coupling, (&fine, &sums), rule)
        }
    }
}

/// Follows a changed input from the phasors of the frame before, on the CPU (warm start).
pub fn follow_cpu(
    graph: &SurfaceGraph,
    directions: &[Vec3],
    frequencies: &[f32],
    coupling: impl Into<Coupling>,
    settings: &SolverSettings,
    phasors: &mut [Vec2],
) {
    let settings = &settings.valid();
    let (fine, sums) = edges(graph, directions, frequencies, coupling);
    if settings.warm_level_sweeps > 0 {
        v_cycle(graph, &fine, settings.warm_level_sweeps, settings.omega, phasors);
    }
    sweep_soft(
        graph.mesh_level(),
        &fine,
        &sums,
        phasors,
        settings.warm_sweeps,
        false,
        settings,
    );
}

/// Soft sweeps; the first one after a start of unit phasors (`from_unit`) is not over-relaxed, which would overshoot.
fn sweep_soft(
    level: &Level,
    edges: &Edges,
    sums: &[f32],
    z: &mut [Vec2],
    sweeps: u32,
    from_unit: bool,
    settings: &SolverSettings,
) {
    for n in 0..sweeps {
        let omega = if n == 0 && from_unit { 1.0 } else { settings.omega };
        sweep(
            level,
            edges,
            sums,
            z,
            Relaxation::Soft {
                omega,
                softness: settings.softness,
            },
        );
    }
}

/// The phasors of all nodes outside the class that is being written.
struct Others<'a> {
    before: &'a [Vec2],
    after: &'a [Vec2],
    end: usize,
}

impl Others<'_> {
    fn get(&self, j: usize) -> Vec2 {
        if j < self.before.len() {
            self.before[j]
        } else {
            self.after[j - self.end]
        }
    }
}

/// Nodes below which a task costs more than it brings.
const TASK_NODES: usize = 1024;

fn chunk_len(nodes: usize) -> usize {
    let threads = ComputeTaskPool::get_or_init(TaskPool::default).thread_num().max(1);
    nodes.div_ceil(threads).max(TASK_NODES)
}

/// Sets z to `f(node, z, others)` for all waves of all nodes, class by class; those of a class in parallel.
fn for_each_class(level: &Level, waves: usize, z: &mut [Vec2], f: impl Fn(usize, Vec2, &Others) -> Vec2 + Sync) {
    let pool = ComputeTaskPool::get_or_init(TaskPool::default);
    for class in level.classes.windows(2) {
        let (start, end) = (waves * class[0] as usize, waves * class[1] as usize);
        let (before, rest) = z.split_at_mut(start);
        let (own, after) = rest.split_at_mut(end - start);
        let others = Others { before, after, end };
        let chunk = chunk_len(own.len());
        let update = |first: usize, own: &mut [Vec2]| {
            for (n, z) in own.iter_mut().enumerate() {
                *z = f(first + n, *z, &others);
            }
        };
        if own.len() <= chunk {
            update(start, own);
        } else {
            pool.scope(|scope| {
                for (c, own) in own.chunks_mut(chunk).enumerate() {
                    let update = &update;
                    scope.spawn(async move { update(start + c * chunk, own) });
                }
            });
        }
    }
}
