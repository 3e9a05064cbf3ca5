//! The solver on the CPU: the twin of every GPU pass, and [`solve_cpu`] for tools and servers without a GPU.
//!
//! In: a graph, a direction d and a frequency f per vertex. Out: a unit phasor z per vertex.
//!
//! Every vertex i sees each neighbour j through the edge's phase Φ_ji (Eq. 3 of Lichtenberg et al. 2018): as
//! `w e^{iΦ_ji} z_j`, or, where the two directions are opposed on a line field, as `-w conj(e^{iΦ_ji} z_j)`. A sweep moves
//! every z_i towards the sum t_i of what it sees, one colour class after the other; each such move lowers the energy
//! E = Σ w (1 - cos r) over the edges, r being the phase an edge is off by (Eq. 4, 5).

pub use super::{
    edges::{Edges, edges},
    hierarchy::{Child, align, coarsen, prolong, v_cycle},
    local_rule::{hash_turns, sweep_local},
    settings::{ColdStart, LocalRule, MergedRule, SolverSettings},
};
use super::{
    hierarchy::cold_start,
    local_rule::solve_local,
    merged::{Field, solve_merged},
    waves::Coupling,
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

/// z / |z|, or `fallback` where z is next to nothing.
pub fn normalize_or(z: Vec2, fallback: Vec2) -> Vec2 {
    let r = z.length();
    if r > 1e-14 { z / r } else { fallback }
}

/// One sweep: every node moves towards what it sees, colour class by colour class. `sums` (of weights, per node) is used
/// by [`Relaxation::Soft`] only.
pub fn sweep(level: &Level, edges: &Edges, sums: &[f32], z: &mut [Vec2], relaxation: Relaxation) {
    let waves = edges.waves();
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
    let waves = edges.waves();
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

pub(super) fn chunk_len(nodes: usize) -> usize {
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
