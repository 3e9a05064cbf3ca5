//! The triangles around each vertex, so that each neighbour is met once.
//!
//! In: the triangles of a graph. Out: per vertex runs of neighbours, counter-clockwise: a vertex, an entry and the next one
//! make a triangle. A closed fan names its first neighbour again at its end; between two fans there is a
//! [`NO_VERTEX`].

use crate::{surface::SurfaceGraph, wave::layout::NO_VERTEX};

/// Offsets, one more than there are vertices, then the entries of all vertices.
pub(super) fn fans(graph: &SurfaceGraph) -> Vec<u32> {
    let mut sides = vec![Vec::new(); graph.len()];
    for &[a, b, c] in &graph.triangles {
        for [at, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
            sides[at as usize].push([from, to]);
        }
    }
    let mut offsets = vec![0];
    let mut entries = Vec::new();
    for sides in &mut sides {
        chain(sides, &mut entries);
        offsets.push(entries.len() as u32);
    }
    offsets.extend(entries);
    offsets
}

/// Puts the sides opposite to a vertex one behind the other, each beginning where the one before it ends.
fn chain(sides: &mut [[u32; 2]], entries: &mut Vec<u32>) {
    sides.sort_unstable();
    let mut ends: Vec<u32> = sides.iter().map(|side| side[1]).collect();
    ends.sort_unstable();
    // Open fans begin at a border; what is left is closed.
    let at_border = |n: &usize| ends.binary_search(&sides[*n][0]).is_err();
    let (open, closed): (Vec<usize>, Vec<usize>) = (0..sides.len()).partition(at_border);
    let mut met = vec![false; sides.len()];
    let before = entries.len();
    for first in open.into_iter().chain(closed) {
        if met[first] {
            continue;
        }
        if entries.len() > before {
            entries.push(NO_VERTEX);
        }
        entries.push(sides[first][0]);
        let mut next = Some(first);
        while let Some(n) = next {
            met[n] = true;
            let to = sides[n][1];
            entries.push(to);
            let from = sides.partition_point(|side| side[0] < to);
            let mut following = (from..sides.len()).take_while(|&k| sides[k][0] == to);
            next = following.find(|&k| !met[k]);
        }
    }
}
