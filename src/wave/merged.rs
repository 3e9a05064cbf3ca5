//! The local rule on ever finer surfaces of merged vertices (section 3.4 of Lichtenberg et al. 2018).
//!
//! In: a graph, a direction d and a frequency f per vertex. Out: phasors. Going up, d and f of a merged vertex are the means
//! of its parts, weighted by area; so this only works where they are smooth. On the coarsest surface the phases begin as
//! hashes; on each, the local rule sweeps until the energy settles; going down, a vertex gets the phase that it sees of
//! the one that it was merged into, over the same aligned distance as along an edge. Here for comparison.

use super::{
    kite::{aligned_distance, cmul, phasor, reversed},
    local_rule::settle,
    settings::MergedRule,
    solver::{Edges, Solution, edges, hash_turns},
    waves::{Coupling, frame, turned},
};
use crate::{
    field::project_tangent,
    surface::{MergedSurface, SurfaceGraph},
};
use bevy::math::{Vec2, Vec3};

/// The directions and frequencies of a graph's vertices.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    pub(super) directions: Vec<Vec3>,
    pub(super) frequencies: Vec<f32>,
}

/// Means over the parts of each merged vertex, weighted by area. The frames of the parts are turned to the first one's, by
/// turns that leave the pattern as it is.
pub(super) fn merge_fields(finer: &SurfaceGraph, field: &Field, merged: &MergedSurface, coupling: Coupling) -> Field {
    let nodes = merged.graph.len();
    let mut first = vec![None; nodes];
    let mut sums = vec![(Vec3::ZERO, 0.0, 0.0); nodes];
    for (i, &parent) in merged.parents.iter().enumerate() {
        let own = frame(field.directions[i], finer.normals[i]);
        let reference = *first[parent as usize].get_or_insert(own);
        let (m, reversed) = turned(coupling.quarter_turns(own, reference), 0);
        let d = if reversed { -own[m] } else { own[m] };
        // Without areas all count alike.
        let weight = finer.areas[i].max(f32::MIN_POSITIVE);
        let (direction, frequency, total) = &mut sums[parent as usize];
        *direction += weight * d;
        *frequency += weight * field.frequencies[i];
        *total += weight;
    }
    let direction = |(sum, &n): (&(Vec3, f32, f32), &Vec3)| project_tangent((sum.0 / sum.2).normalize_or_zero(), n);
    Field {
        directions: sums.iter().zip(&merged.graph.normals).map(direction).collect(),
        frequencies: sums.iter().map(|sum| sum.1 / sum.2).collect(),
    }
}

/// The phasors that the vertices of `finer` see of those that they are merged into.
pub(super) fn spread_phases(
    (finer, field): (&SurfaceGraph, &Field),
    (merged, coarse): (&MergedSurface, &Field),
    coupling: Coupling,
    z: &[Vec2],
) -> Vec<Vec2> {
    let waves = coupling.waves.count();
    let factors = [1.0, coupling.waves.ratio()];
    let of_vertex = |(i, &parent): (usize, &u32)| {
        let p = parent as usize;
        let source = frame(coarse.directions[p], merged.graph.normals[p]);
        let target = frame(field.directions[i], finer.normals[i]);
        let turns = coupling.quarter_turns(source, target);
        let e = finer.positions[i] - merged.graph.positions[p];
        let frequency = 0.5 * (coarse.frequencies[p] + field.frequencies[i]);
        (0..waves).map(move |r| {
            let (m, flip) = turned(turns, r);
            let d = if flip { -target[r] } else { target[r] };
            let periods = factors[r] * frequency * aligned_distance(e, source[m], d);
            let seen = cmul(z[waves * p + m], phasor(periods));
            if flip { reversed(seen) } else { seen }
        })
    };
    merged.parents.iter().enumerate().flat_map(of_vertex).collect()
}

/// Up the surfaces merging fields, down again sweeping. `fine` are the edge constants of `graph` itself, with pins.
pub(super) fn solve_merged(
    graph: &SurfaceGraph,
    field: Field,
    coupling: Coupling,
    (fine, sums): (&Edges, &[f32]),
    rule: &MergedRule,
) -> Solution {
    let surfaces = graph.merged(rule.levels);
    let graphs: Vec<&SurfaceGraph> = [graph]
        .into_iter()
        .chain(surfaces.iter().map(|surface| &surface.graph))
        .collect();
    let mut fields = vec![field];
    for (n, merged) in surfaces.iter().enumerate() {
        fields.push(merge_fields(graphs[n], &fields[n], merged, coupling));
    }
    let waves = coupling.waves.count();
    let mut z: Vec<Vec2> = graphs[surfaces.len()]
        .first_vertices()
        .into_iter()
        .flat_map(|id| (0..waves as u32).map(move |r| phasor(hash_turns(id ^ (r << 31)))))
        .collect();
    for n in (1..graphs.len()).rev() {
        let (constants, sums) = edges(graphs[n], &fields[n].directions, &fields[n].frequencies, coupling);
        settle(graphs[n].mesh_level(), &constants, &sums, &rule.local, &mut z);
        let (finer, coarser) = ((graphs[n - 1], &fields[n - 1]), (&surfaces[n - 1], &fields[n]));
        z = spread_phases(finer, coarser, coupling, &z);
    }
    let sweeps = settle(graph.mesh_level(), fine, sums, &rule.local, &mut z);
    Solution { phasors: z, sweeps }
}
