//! The local rule as Lichtenberg et al. 2018 print it (section 3.3, Eq. 9 to 12).
//!
//! In: a graph with its edge constants. Out: phasors from hashed phases by coloured sweeps with momentum, until the energy
//! settles. Slow to find long waves; here for comparison.

use super::{
    kite::phasor,
    settings::LocalRule,
    solver::{Edges, Solution, energy, normalize_or},
};
use crate::surface::{Level, SurfaceGraph};
use bevy::math::Vec2;

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
    let waves = edges.waves();
    for class in level.classes.windows(2).take(colors) {
        for node in waves * class[0] as usize..waves * class[1] as usize {
            let t = edges.seen_sum(level, node / waves, node % waves, |source| z[source]);
            let old = z[node];
            z[node] = normalize_or(t + delta[node], old);
            delta[node] = momentum * (t - old);
        }
    }
}

pub(super) fn solve_local(graph: &SurfaceGraph, edges: &Edges, sums: &[f32], rule: &LocalRule) -> Solution {
    let level = graph.mesh_level();
    let mut z: Vec<Vec2> = graph
        .first_vertices()
        .into_iter()
        .flat_map(|id| (0..edges.waves() as u32).map(move |r| phasor(hash_turns(id ^ (r << 31)))))
        .collect();
    let sweeps = settle(level, edges, sums, rule, &mut z);
    Solution { phasors: z, sweeps }
}

/// Sweeps of the local rule until the energy settles (Eq. 12); how many.
pub(super) fn settle(level: &Level, edges: &Edges, sums: &[f32], rule: &LocalRule, z: &mut [Vec2]) -> u32 {
    let mut delta = vec![Vec2::ZERO; z.len()];
    let mut before = f32::INFINITY;
    let mut sweeps = 0;
    while sweeps < rule.max_sweeps {
        let colors = match rule.skip_last_third && sweeps % 2 == 1 {
            true => level.colors() - level.colors() / 3,
            false => level.colors(),
        };
        sweep_local(level, edges, z, &mut delta, rule.momentum, colors);
        sweeps += 1;
        if rule.epsilon > 0.0 {
            let now = energy(level, edges, sums, z);
            if (before - now).abs() < rule.epsilon * before {
                break;
            }
            before = now;
        }
    }
    sweeps
}
