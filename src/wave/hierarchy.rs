//! The Galerkin hierarchy of the cold start; the twin of `hierarchy.wgsl`.
//!
//! In: the levels of a graph, and the edge constants of the finest. Out: unit phasors on the mesh, long waves first.
//!
//! A coarse node p stands for one rigid phase rotation y_p of all its children,
//! `z_i ← z_i y_p` (σ_i = +1) or `z_i conj(y_p)` (σ_i = -1); in these unknowns the energy has the same form again, with
//! `t_p = Σ A_pq y_q + B_pq conj(y_q)`, and the coarse weights A, B are exact sums over the fine edges between two
//! aggregates. No coarse position, normal or direction is needed.

use super::{
    edges::{Edges, conj, with_swap},
    kite::cmul,
    solver::{Relaxation, normalize_or, sweep},
};
use crate::surface::{Level, SurfaceGraph};
use bevy::math::Vec2;

/// How a wave of a child follows its parent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Child {
    /// σ = -1: it turns by conj(y).
    pub reversed: bool,
    /// It follows the parent's other wave.
    pub swap: bool,
}

impl Child {
    fn sees(self, y: Vec2) -> Vec2 {
        if self.reversed { conj(y) } else { y }
    }
}

/// Chooses how every child follows its parent, and sets its phasor to what it sees of its root, whose own is 1 (cold
/// start).
pub fn align(level: &Level, edges: &Edges, z: &mut [Vec2], children: &mut [Child]) {
    for (node, (z, child)) in z.iter_mut().zip(children).enumerate() {
        (*child, *z) = joined(level, edges, node);
    }
}

/// How a node follows its parent, and what it sees of its root where the root's own phasor is 1.
fn joined(level: &Level, edges: &Edges, node: usize) -> (Child, Vec2) {
    let waves = edges.waves();
    let (i, r) = (node / waves, node % waves);
    let parent = level.parents[i] as usize;
    let root = level.children[level.child_offsets[parent] as usize];
    let range = level.edges(i);
    let Ok(n) = level.neighbors[range.clone()].binary_search(&root) else {
        return (Child::default(), Vec2::X);
    };
    let k = range.start + n;
    let [a, b] = edges.pair(k, r);
    let child = Child {
        reversed: a.length_squared() < b.length_squared(),
        swap: edges.source(k, r) != r,
    };
    (child, normalize_or(a + b, Vec2::X))
}

/// The weights A, B of the coarser level: sums over the fine edges between two aggregates p < q. The edge back has the
/// weights conj(A) and B, since the energy is one.
///
/// Of a cross field some of those edges join equal waves and some different ones, where a singularity lies between; the
/// heavier kind is kept.
pub fn coarsen(level: &Level, edges: &Edges, z: &[Vec2], children: &[Child], coarse: &Level) -> Edges {
    let waves = edges.waves();
    let mut ab = vec![[Vec2::ZERO; 2]; waves * coarse.neighbors.len()];
    for p in 0..coarse.len() as u32 {
        let range = coarse.edges(p as usize);
        let neighbors = &coarse.neighbors[range.clone()];
        // Per neighbour and wave, for edges between equal and between different waves.
        let mut sums = vec![[[[Vec2::ZERO; 2]; 2]; 2]; neighbors.len()];
        let own = level.child_offsets[p as usize] as usize..level.child_offsets[p as usize + 1] as usize;
        for &i in &level.children[own] {
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
                for r in 0..waves {
                    let m = edges.source(k, r);
                    let (target, source) = (waves * i + r, waves * j + m);
                    let (child, other) = (children[target], children[source]);
                    let [a, b] = edges.pair(k, r);
                    let mut al = cmul(conj(z[target]), cmul(a, z[source]));
                    let mut be = cmul(conj(z[target]), cmul(b, conj(z[source])));
                    if child.reversed {
                        (al, be) = (conj(al), conj(be));
                    }
                    if child.reversed != other.reversed {
                        (al, be) = (be, al);
                    }
                    let swap = child.swap ^ (m != r) ^ other.swap;
                    let sum = &mut sums[n][usize::from(swap)][r ^ usize::from(child.swap)];
                    sum[0] += al;
                    sum[1] += be;
                }
            }
        }
        for (n, &q) in neighbors.iter().enumerate().filter(|&(_, &q)| q > p) {
            let weight = |kind: &[[Vec2; 2]; 2]| kind.iter().flatten().map(|w| w.length_squared()).sum::<f32>();
            let swap = weight(&sums[n][1]) > weight(&sums[n][0]);
            let back = coarse.edges(q as usize);
            let Ok(m) = coarse.neighbors[back.clone()].binary_search(&p) else {
                continue;
            };
            for r in 0..waves {
                let [a, b] = sums[n][usize::from(swap)][r];
                ab[waves * (range.start + n) + r] = [with_swap(a, swap), b];
                ab[waves * (back.start + m) + (r ^ usize::from(swap))] = [with_swap(conj(a), swap), b];
            }
        }
    }
    Edges::coarse(waves, ab)
}

/// Applies the rotations y of the coarser level to the children.
pub fn prolong(level: &Level, y: &[Vec2], children: &[Child], z: &mut [Vec2]) {
    let waves = z.len() / level.len().max(1);
    for (node, (z, child)) in z.iter_mut().zip(children).enumerate() {
        let (i, r) = (node / waves, node % waves);
        let y = y[waves * level.parents[i] as usize + (r ^ usize::from(child.swap))];
        *z = cmul(*z, child.sees(y));
    }
}

/// The Galerkin cold start: up the levels aligning and coarsening, down again rotating and sweeping.
pub(super) fn cold_start(graph: &SurfaceGraph, fine: &Edges, level_sweeps: u32, omega: f32) -> Vec<Vec2> {
    let nodes = fine.waves() * graph.mesh_level().len();
    let mut z = vec![Vec2::X; nodes];
    cycle(graph, fine, level_sweeps, omega, true, &mut z);
    z
}

/// A V-cycle (warm start): aggregates of ever coarser levels turn as a whole to where they fit better, starting from the
/// phasors as they are. Of phasors with a modulus the surer count more. On unit phasors it raises the energy no more than
/// the edges that flip inside an aggregate do.
pub fn v_cycle(graph: &SurfaceGraph, fine: &Edges, level_sweeps: u32, omega: f32, z: &mut [Vec2]) {
    cycle(graph, fine, level_sweeps, omega, false, z);
}

/// Up the levels coarsening, where `aligning` after children took what they see of their root; down again sweeping and
/// rotating.
fn cycle(graph: &SurfaceGraph, fine: &Edges, level_sweeps: u32, omega: f32, aligning: bool, z: &mut [Vec2]) {
    let levels = &graph.levels;
    let mut coarse_edges: Vec<Edges> = Vec::new();
    let mut states: Vec<(Vec<Vec2>, Vec<Child>)> = Vec::new();
    for (n, level) in levels.iter().enumerate() {
        let edges = if n == 0 { fine } else { &coarse_edges[n - 1] };
        let nodes = fine.waves() * level.len();
        let mut z = if n == 0 { z.to_vec() } else { vec![Vec2::X; nodes] };
        let mut children = vec![Child::default(); nodes];
        if let Some(coarse) = levels.get(n + 1) {
            if aligning {
                align(level, edges, &mut z, &mut children);
            } else {
                children = (0..nodes).map(|node| joined(level, edges, node).0).collect();
            }
            let coarsened = coarsen(level, edges, &z, &children, coarse);
            coarse_edges.push(coarsened);
        }
        states.push((z, children));
    }
    let mut y: Vec<Vec2> = Vec::new();
    for (n, level) in levels.iter().enumerate().rev() {
        let edges = if n == 0 { fine } else { &coarse_edges[n - 1] };
        let (z, children) = &mut states[n];
        if n + 1 < levels.len() {
            prolong(level, &y, children, z);
        }
        let sweeps = if n == 0 { 0 } else { level_sweeps };
        for s in 0..sweeps {
            let omega = if s == 0 { 1.0 } else { omega };
            sweep(level, edges, &[], z, Relaxation::Turn { omega });
        }
        y = std::mem::take(z);
    }
    z.copy_from_slice(&y);
}
