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
    kite::{cmul, edge_phase, phasor, reversed},
    local_rule::solve_local,
};
pub use super::{
    hierarchy::{align, coarsen, prolong},
    local_rule::{hash_turns, sweep_local},
    settings::{ColdStart, LocalRule, SolverSettings},
};
use crate::{
    field::Symmetry,
    surface::{Level, SurfaceGraph},
};
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

/// The edge constants of one level.
#[derive(Debug, Clone, PartialEq)]
pub enum Edges {
    /// The mesh: `E = w e^{iΦ_ji}` per directed edge; the lowest bit of E.x says that the edge flips.
    Fine(Vec<Vec2>),
    /// A coarse level: A and B per directed edge.
    Coarse(Vec<[Vec2; 2]>),
}

impl Edges {
    /// What the target of edge `k` sees of its source's phasor `z`.
    pub fn seen(&self, k: usize, z: Vec2) -> Vec2 {
        match self {
            Self::Fine(e) => {
                let seen = cmul(e[k], z);
                if flips(e[k]) { reversed(seen) } else { seen }
            }
            Self::Coarse(ab) => cmul(ab[k][0], z) + cmul(ab[k][1], conj(z)),
        }
    }

    /// The pair (A, B) of edge `k`: the target sees A z + B conj(z).
    pub(super) fn pair(&self, k: usize) -> [Vec2; 2] {
        match self {
            Self::Fine(e) if flips(e[k]) => [Vec2::ZERO, reversed(e[k])],
            Self::Fine(e) => [e[k], Vec2::ZERO],
            Self::Coarse(ab) => ab[k],
        }
    }
}

pub(super) fn conj(z: Vec2) -> Vec2 {
    Vec2::new(z.x, -z.y)
}

fn flips(e: Vec2) -> bool {
    e.x.to_bits() & 1 == 1
}

fn with_flip(e: Vec2, flip: bool) -> Vec2 {
    Vec2::new(f32::from_bits((e.x.to_bits() & !1) | u32::from(flip)), e.y)
}

/// z / |z|, or `fallback` where z is next to nothing.
pub fn normalize_or(z: Vec2, fallback: Vec2) -> Vec2 {
    let r = z.length();
    if r > 1e-14 { z / r } else { fallback }
}

/// The edge pass (Eq. 3, kite form): `w e^{iΦ_ji}` and flip of every directed edge, and the sum of weights per vertex.
///
/// `directions` and `frequencies` are one per vertex, in solver order; `Φ_ji = 2π (f_i + f_j)/2` times the aligned distance.
pub fn edges(graph: &SurfaceGraph, directions: &[Vec3], frequencies: &[f32], symmetry: Symmetry) -> (Edges, Vec<f32>) {
    let level = graph.mesh_level();
    let mut e = vec![Vec2::ZERO; level.neighbors.len()];
    let mut sums = vec![0.0; level.len()];
    let chunk = chunk_len(level.len());
    let pool = ComputeTaskPool::get_or_init(TaskPool::default);
    pool.scope(|scope| {
        let mut rest = e.as_mut_slice();
        for (c, sums) in sums.chunks_mut(chunk).enumerate() {
            let first = c * chunk;
            let start = level.offsets[first] as usize;
            let end = level.offsets[first + sums.len()] as usize;
            let (e, tail) = rest.split_at_mut(end - start);
            rest = tail;
            scope.spawn(async move {
                for (n, sum) in sums.iter_mut().enumerate() {
                    let i = first + n;
                    for k in level.edges(i) {
                        let j = level.neighbors[k] as usize;
                        let edge = edge_phase(
                            graph.positions[i] - graph.positions[j],
                            directions[j],
                            directions[i],
                            symmetry,
                        );
                        let turns = 0.5 * (frequencies[i] + frequencies[j]) * edge.distance;
                        e[k - start] = with_flip(edge.weight * phasor(turns), edge.flip);
                        *sum += edge.weight;
                    }
                }
            });
        }
    });
    (Edges::Fine(e), sums)
}

/// One sweep: every node moves towards what it sees, colour class by colour class. `sums` (of weights, per node) is used
/// by [`Relaxation::Soft`] only.
pub fn sweep(level: &Level, edges: &Edges, sums: &[f32], z: &mut [Vec2], relaxation: Relaxation) {
    for_each_class(level, z, |i, own, others| {
        let mut t = Vec2::ZERO;
        for k in level.edges(i) {
            t += edges.seen(k, others.get(level.neighbors[k]));
        }
        relax(own, t, sums.get(i).copied().unwrap_or(1.0), relaxation)
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
    for i in 0..level.len() {
        let own = normalize_or(z[i], Vec2::X);
        for k in level.edges(i) {
            let source = normalize_or(z[level.neighbors[k] as usize], Vec2::X);
            let seen = edges.seen(k, source);
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
    /// A phasor per vertex, in solver order; z_i refers to the sign of d_i as given.
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
    symmetry: Symmetry,
    settings: &SolverSettings,
) -> Solution {
    let settings = &settings.valid();
    let (fine, sums) = edges(graph, directions, frequencies, symmetry);
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
    }
}

/// Follows a changed input from the phasors of the frame before, on the CPU (warm start).
pub fn follow_cpu(
    graph: &SurfaceGraph,
    directions: &[Vec3],
    frequencies: &[f32],
    symmetry: Symmetry,
    settings: &SolverSettings,
    phasors: &mut [Vec2],
) {
    let settings = &settings.valid();
    let (fine, sums) = edges(graph, directions, frequencies, symmetry);
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
    fn get(&self, j: u32) -> Vec2 {
        let j = j as usize;
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

/// Sets z_i to `f(i, z_i, others)` for all nodes, class by class; the nodes of a class in parallel.
fn for_each_class(level: &Level, z: &mut [Vec2], f: impl Fn(usize, Vec2, &Others) -> Vec2 + Sync) {
    let pool = ComputeTaskPool::get_or_init(TaskPool::default);
    for class in level.classes.windows(2) {
        let (start, end) = (class[0] as usize, class[1] as usize);
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
