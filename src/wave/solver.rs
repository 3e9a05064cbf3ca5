//! The solver on the CPU: the twin of every GPU pass, and [`solve_cpu`] for tools and servers without a GPU.
//!
//! In: a graph, a direction d and a frequency f per vertex. Out: a unit phasor z per vertex.
//!
//! Every vertex i sees each neighbour j through the edge's phase Φ_ji (Eq. 3 of Lichtenberg et al. 2018): as
//! `w e^{iΦ_ji} z_j`, or, where the two directions are opposed on a line field, as `-w conj(e^{iΦ_ji} z_j)`. A sweep moves
//! every z_i towards the sum t_i of what it sees, one colour class after the other; each such move lowers the energy
//! E = Σ w (1 - cos r) over the edges, r being the phase an edge is off by (Eq. 4, 5).
//!
//! The cold start is a Galerkin hierarchy. A coarse node p stands for one rigid phase rotation y_p of all its children,
//! `z_i ← z_i y_p` (σ_i = +1) or `z_i conj(y_p)` (σ_i = -1); in these unknowns the energy has the same form again, with
//! `t_p = Σ A_pq y_q + B_pq conj(y_q)`, and the coarse weights A, B are exact sums over the fine edges between two
//! aggregates. No coarse position, normal or direction is needed.

use super::kite::{cmul, edge_phase, phasor, reversed};
pub use super::settings::{ColdStart, LocalRule, SolverSettings};
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
    fn pair(&self, k: usize) -> [Vec2; 2] {
        match self {
            Self::Fine(e) if flips(e[k]) => [Vec2::ZERO, reversed(e[k])],
            Self::Fine(e) => [e[k], Vec2::ZERO],
            Self::Coarse(ab) => ab[k],
        }
    }
}

fn conj(z: Vec2) -> Vec2 {
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

/// Chooses the sign σ of every child and sets its phasor to what it sees of its root, whose own is 1 (cold start).
pub fn align(level: &Level, edges: &Edges, z: &mut [Vec2], sigma: &mut [f32]) {
    for (i, (z, sigma)) in z.iter_mut().zip(sigma).enumerate() {
        let parent = level.parents[i] as usize;
        let root = level.children[level.child_offsets[parent] as usize];
        (*z, *sigma) = (Vec2::X, 1.0);
        let range = level.edges(i);
        if let Ok(n) = level.neighbors[range.clone()].binary_search(&root) {
            let [a, b] = edges.pair(range.start + n);
            *z = normalize_or(a + b, Vec2::X);
            *sigma = if a.length_squared() >= b.length_squared() {
                1.0
            } else {
                -1.0
            };
        }
    }
}

/// The weights A, B of the coarser level: exact sums over the fine edges between two aggregates p < q. The edge back
/// has the weights conj(A) and B, since the energy is one.
pub fn coarsen(level: &Level, edges: &Edges, z: &[Vec2], sigma: &[f32], coarse: &Level) -> Edges {
    let mut ab = vec![[Vec2::ZERO; 2]; coarse.neighbors.len()];
    for p in 0..coarse.len() as u32 {
        let range = coarse.edges(p as usize);
        let neighbors = &coarse.neighbors[range.clone()];
        let children = level.child_offsets[p as usize] as usize..level.child_offsets[p as usize + 1] as usize;
        for &i in &level.children[children] {
            let i = i as usize;
            for k in level.edges(i) {
                let j = level.neighbors[k] as usize;
                let parent = level.parents[j];
                if parent <= p {
                    continue;
                }
                let Ok(n) = neighbors.binary_search(&parent) else {
                    continue;
                };
                let [a, b] = edges.pair(k);
                let mut al = cmul(conj(z[i]), cmul(a, z[j]));
                let mut be = cmul(conj(z[i]), cmul(b, conj(z[j])));
                if sigma[i] < 0.0 {
                    (al, be) = (conj(al), conj(be));
                }
                if sigma[i] != sigma[j] {
                    (al, be) = (be, al);
                }
                let sum = &mut ab[range.start + n];
                sum[0] += al;
                sum[1] += be;
            }
        }
        for (n, &q) in neighbors.iter().enumerate().filter(|&(_, &q)| q > p) {
            let back = coarse.edges(q as usize);
            if let Ok(m) = coarse.neighbors[back.clone()].binary_search(&p) {
                let [a, b] = ab[range.start + n];
                ab[back.start + m] = [conj(a), b];
            }
        }
    }
    Edges::Coarse(ab)
}

/// Applies the rotations y of the coarser level to the children.
pub fn prolong(level: &Level, y: &[Vec2], sigma: &[f32], z: &mut [Vec2]) {
    for (i, z) in z.iter_mut().enumerate() {
        let y = y[level.parents[i] as usize];
        *z = cmul(*z, if sigma[i] > 0.0 { y } else { conj(y) });
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

/// A phase from the id of a vertex, in turns 0..1: Jenkins' one-at-a-time hash over its four bytes.
pub fn hash_turns(id: u32) -> f32 {
    let mut x = 0u32;
    for byte in id.to_le_bytes() {
        x = x.wrapping_add(u32::from(byte));
        x = x.wrapping_add(x << 10);
        x ^= x >> 6;
    }
    x = x.wrapping_add(x << 3);
    x ^= x >> 11;
    x = x.wrapping_add(x << 15);
    (x >> 8) as f32 / 16_777_216.0
}

/// One sweep of the local rule: z_i ← (t + Δ_i) / |t + Δ_i|, Δ_i ← s_m (t - z_i) (Eq. 9 to 11), classes in `colors` only.
pub fn sweep_local(level: &Level, edges: &Edges, z: &mut [Vec2], delta: &mut [Vec2], momentum: f32, colors: usize) {
    for class in level.classes.windows(2).take(colors) {
        for i in class[0] as usize..class[1] as usize {
            let mut t = Vec2::ZERO;
            for k in level.edges(i) {
                t += edges.seen(k, z[level.neighbors[k] as usize]);
            }
            let old = z[i];
            z[i] = normalize_or(t + delta[i], old);
            delta[i] = momentum * (t - old);
        }
    }
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

/// The Galerkin cold start: up the levels aligning and coarsening, down again rotating and sweeping.
fn cold_start(graph: &SurfaceGraph, fine: &Edges, level_sweeps: u32, omega: f32) -> Vec<Vec2> {
    let levels = &graph.levels;
    let mut coarse_edges: Vec<Edges> = Vec::new();
    let mut states: Vec<(Vec<Vec2>, Vec<f32>)> = Vec::new();
    for (n, level) in levels.iter().enumerate() {
        let edges = if n == 0 { fine } else { &coarse_edges[n - 1] };
        let (mut z, mut sigma) = (vec![Vec2::X; level.len()], vec![1.0; level.len()]);
        if let Some(coarse) = levels.get(n + 1) {
            align(level, edges, &mut z, &mut sigma);
            let coarsened = coarsen(level, edges, &z, &sigma, coarse);
            coarse_edges.push(coarsened);
        }
        states.push((z, sigma));
    }
    let mut y: Vec<Vec2> = Vec::new();
    for (n, level) in levels.iter().enumerate().rev() {
        let edges = if n == 0 { fine } else { &coarse_edges[n - 1] };
        let (z, sigma) = &mut states[n];
        if n + 1 < levels.len() {
            prolong(level, &y, sigma, z);
        }
        let sweeps = if n == 0 { 0 } else { level_sweeps };
        for s in 0..sweeps {
            let omega = if s == 0 { 1.0 } else { omega };
            sweep(level, edges, &[], z, Relaxation::Turn { omega });
        }
        y = std::mem::take(z);
    }
    y
}

fn solve_local(graph: &SurfaceGraph, edges: &Edges, sums: &[f32], rule: &LocalRule) -> Solution {
    let level = graph.mesh_level();
    let mut z: Vec<Vec2> = graph
        .first_vertices()
        .into_iter()
        .map(|id| phasor(hash_turns(id)))
        .collect();
    let mut delta = vec![Vec2::ZERO; z.len()];
    let mut before = f32::INFINITY;
    let mut sweeps = 0;
    while sweeps < rule.max_sweeps {
        let colors = match rule.skip_last_third && sweeps % 2 == 1 {
            true => level.colors() - level.colors() / 3,
            false => level.colors(),
        };
        sweep_local(level, edges, &mut z, &mut delta, rule.momentum, colors);
        sweeps += 1;
        if rule.epsilon > 0.0 {
            let now = energy(level, edges, sums, &z);
            if (before - now).abs() < rule.epsilon * before {
                break;
            }
            before = now;
        }
    }
    Solution { phasors: z, sweeps }
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
