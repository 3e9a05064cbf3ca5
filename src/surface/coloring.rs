//! Colours: classes of nodes that can be solved for at the same time, since no two of them are neighbours.
//!
//! In: the neighbours of each node and an order along a space-filling curve. Out: the solver order, colour class by
//! colour class, inside a class valence by valence, and along the curve inside a valence. Processors that work on many
//! nodes in lockstep wait for the one with the most neighbours, so equal valences belong together.
//!
//! The colours are those of Jones and Plassmann (1993) with first fit: a node waits for its neighbours of higher
//! priority and takes the smallest colour that is free. One after the other in descending priority gives the same
//! result. A second pass visits the nodes class by class, the last class first, and starts anew with first fit, which
//! never needs more colours and on meshes saves one (7 → 6). Class 0 is visited before all others and so stays as it is.
//!
//! First fit makes class 0 a *maximal* independent set: whoever has another colour has seen a neighbour of colour 0.
//! The hierarchy stands on it, which is why priority is not quite random: hubs come first. Otherwise the many leaves of
//! a star would be class 0, and each coarser level would be the same star with one leaf less.

use super::{adjacency::Adjacency, order};

/// Nodes of a smaller valence are no hubs. Vertices of ordinary meshes and aggregates stay below.
const HUB: u32 = 16;
/// Valences that are told apart in the solver order; larger ones count as the last.
const VALENCES: u32 = 32;
const UNCOLORED: u32 = u32::MAX;

/// The nodes in solver order, and the offset of each colour class in it.
pub(super) struct SolverOrder {
    pub(super) order: Vec<u32>,
    pub(super) classes: Vec<u32>,
}

impl SolverOrder {
    /// Colours the graph. `curve` lists its nodes along a space-filling curve.
    pub(super) fn new(graph: &Adjacency, curve: &[u32]) -> Self {
        let (colors, count) = first_fit(graph, &by_priority(graph));
        let (classes, members) = order::group(&colors, count);
        let class = |c: usize| &members[classes[c] as usize..classes[c + 1] as usize];
        let revisit: Vec<u32> = (0..count.min(1))
            .chain((1..count).rev())
            .flat_map(class)
            .copied()
            .collect();
        let (colors, count) = first_fit(graph, &revisit);

        let valence = |node: u32| (graph.of(node).len() as u32).min(VALENCES - 1);
        let along_curve: Vec<u32> = curve
            .iter()
            .map(|&node| colors[node as usize] * VALENCES + valence(node))
            .collect();
        let (groups, members) = order::group(&along_curve, count * VALENCES as usize);
        Self {
            order: members.into_iter().map(|i| curve[i as usize]).collect(),
            classes: groups.into_iter().step_by(VALENCES as usize).collect(),
        }
    }
}

/// The nodes in an order in which each one comes after its neighbours of higher priority; all such orders give the same
/// colours. A node follows as soon as the last of those has come, so the order moves from neighbour to neighbour and
/// memory is read where it has just been read; strictly descending priority jumps about in it.
fn by_priority(graph: &Adjacency) -> Vec<u32> {
    let nodes = 0..graph.len() as u32;
    let priorities: Vec<u64> = nodes.clone().map(|node| priority(node, graph.of(node).len())).collect();
    let comes_before = |a: u32, b: u32| priorities[a as usize] > priorities[b as usize];
    let mut waits_for: Vec<u32> = nodes
        .clone()
        .map(|node| {
            graph
                .of(node)
                .iter()
                .filter(|&&other| comes_before(other, node))
                .count() as u32
        })
        .collect();
    let first: Vec<u32> = nodes.filter(|&node| waits_for[node as usize] == 0).collect();
    let mut order = Vec::with_capacity(graph.len());
    let mut ready = Vec::new();
    for start in first {
        ready.push(start);
        while let Some(node) = ready.pop() {
            order.push(node);
            for &other in graph.of(node).iter().filter(|&&other| comes_before(node, other)) {
                waits_for[other as usize] -= 1;
                if waits_for[other as usize] == 0 {
                    ready.push(other);
                }
            }
        }
    }
    order
}

/// Hubs by the magnitude of their valence, then at random; different for all nodes.
fn priority(node: u32, valence: usize) -> u64 {
    let magnitude = (valence as u32).max(HUB - 1).ilog2();
    u64::from(magnitude) << 32 | u64::from(scramble(node))
}

/// A bijective integer hash ("lowbias32" of C. Wellons), so that no two nodes have the same priority.
fn scramble(x: u32) -> u32 {
    let x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    let x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

/// Gives each node, one after the other, the smallest colour that none of its neighbours has; and the number of colours.
fn first_fit(graph: &Adjacency, sequence: &[u32]) -> (Vec<u32>, usize) {
    let mut colors = vec![UNCOLORED; graph.len()];
    // The node that last saw each colour at a neighbour.
    let mut seen_by: Vec<u32> = Vec::new();
    for &node in sequence {
        for &other in graph.of(node) {
            let color = colors[other as usize];
            if color != UNCOLORED {
                seen_by[color as usize] = node;
            }
        }
        let free = seen_by.iter().position(|&seer| seer != node).unwrap_or(seen_by.len());
        if free == seen_by.len() {
            seen_by.push(UNCOLORED);
        }
        colors[node as usize] = free as u32;
    }
    (colors, seen_by.len())
}
