//! The Galerkin hierarchy of the cold start; the twin of `hierarchy.wgsl`.
//!
//! In: the levels of a graph, and the edge constants of the finest. Out: unit phasors on the mesh, long waves first.
//!
//! A coarse node p stands for one rigid phase rotation y_p of all its children,
//! `z_i ← z_i y_p` (σ_i = +1) or `z_i conj(y_p)` (σ_i = -1); in these unknowns the energy has the same form again, with
//! `t_p = Σ A_pq y_q + B_pq conj(y_q)`, and the coarse weights A, B are exact sums over the fine edges between two
//! aggregates. No coarse position, normal or direction is needed.

use super::{
    kite::cmul,
    solver::{Edges, Relaxation, conj, normalize_or, sweep},
};
use crate::surface::{Level, SurfaceGraph};
use bevy::math::Vec2;

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

/// The Galerkin cold start: up the levels aligning and coarsening, down again rotating and sweeping.
pub(super) fn cold_start(graph: &SurfaceGraph, fine: &Edges, level_sweeps: u32, omega: f32) -> Vec<Vec2> {
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
