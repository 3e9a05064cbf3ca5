//! Labels: the sample that each vertex of the mesh belongs to.
//!
//! In: sites and labels that may be out of date. Out: labels that no exchange with a neighbour improves. A vertex knows only
//! its neighbours' labels, so cells stay connected over the surface and the sheets of a thin part do not mix.

use super::{
    mesh::{FineMesh, NONE},
    walk::Site,
};
use crate::parallel;

/// Exchanges labels until nothing changes, at most `sweeps` times: each vertex takes the best label among its own and its
/// neighbours'. A sweep reads the labels of the one before, so that its result does not depend on the order.
pub(super) fn exchange(mesh: &FineMesh, sites: &[Site], labels: &mut Vec<u32>, sweeps: usize) {
    let next: Vec<u32> = parallel::collect(mesh.len(), |v| best_label(mesh, sites, labels, v));
    let changed: Vec<u32> = (0..mesh.len())
        .filter(|&v| next[v] != labels[v])
        .map(|v| v as u32)
        .collect();
    *labels = next;
    exchange_around(mesh, sites, labels, changed, sweeps.saturating_sub(1));
}

/// [`exchange`] that begins at the neighbours of some vertices.
pub(super) fn exchange_around(
    mesh: &FineMesh,
    sites: &[Site],
    labels: &mut [u32],
    mut changed: Vec<u32>,
    sweeps: usize,
) {
    let mut seen = vec![0_u32; mesh.len()];
    let mut around = Vec::new();
    for sweep in 1..=sweeps {
        if changed.is_empty() {
            break;
        }
        around.clear();
        for &w in changed.iter().flat_map(|&v| mesh.neighbors(v as usize)) {
            if std::mem::replace(&mut seen[w as usize], sweep as u32) != sweep as u32 {
                around.push(w);
            }
        }
        let next: Vec<u32> = parallel::collect(around.len(), |k| best_label(mesh, sites, labels, around[k] as usize));
        changed.clear();
        for (&v, &label) in around.iter().zip(&next) {
            if std::mem::replace(&mut labels[v as usize], label) != label {
                changed.push(v);
            }
        }
    }
}

/// The label of the nearest site among those of a vertex and its neighbours; its own where they are equally near.
#[inline]
fn best_label(mesh: &FineMesh, sites: &[Site], labels: &[u32], vertex: usize) -> u32 {
    let own = labels[vertex];
    let Some(&first) = mesh.neighbors(vertex).iter().find(|&&w| labels[w as usize] != own) else {
        return own;
    };
    let point = mesh.positions[vertex];
    let square = |label: u32| match sites.get(label as usize) {
        Some(site) => site.square(point),
        None => f32::INFINITY,
    };
    // Two neighbours often have the same label: the last one that was no better is remembered.
    let (mut best, mut least, mut worse) = (own, square(own), own);
    for &neighbor in mesh.neighbors(vertex).iter().skip_while(|&&w| w != first) {
        let label = labels[neighbor as usize];
        if label == best || label == worse || label == own {
            continue;
        }
        let found = square(label);
        if found < least {
            (best, least) = (label, found);
        } else {
            worse = label;
        }
    }
    best
}

/// Gives every site its vertex, so that no cell is lost while labels are exchanged. Of two sites at one vertex the first
/// has it; the other one takes another corner of its triangle.
pub(super) fn claim(mesh: &FineMesh, sites: &[Site], labels: &mut [u32]) {
    let mut taken = vec![false; mesh.len()];
    for (i, site) in sites.iter().enumerate() {
        let corners = mesh.triangles[site.triangle as usize];
        let free = std::iter::once(site.vertex)
            .chain(corners)
            .find(|&v| !taken[v as usize]);
        if let Some(vertex) = free {
            taken[vertex as usize] = true;
            labels[vertex as usize] = i as u32;
        }
    }
}

/// Gives parts of cells that are cut off from their site to the cells around.
pub(super) fn connect(mesh: &FineMesh, sites: &[Site], labels: &mut [u32]) {
    let mut reached = vec![false; mesh.len()];
    let mut front: Vec<u32> = Vec::new();
    for (site, i) in sites.iter().zip(0..) {
        let corners = mesh.triangles[site.triangle as usize];
        front.extend(corners.iter().filter(|&&v| labels[v as usize] == i));
    }
    front.iter().for_each(|&v| reached[v as usize] = true);
    while let Some(v) = front.pop() {
        for &w in mesh.neighbors(v as usize) {
            if labels[w as usize] == labels[v as usize] && !std::mem::replace(&mut reached[w as usize], true) {
                front.push(w);
            }
        }
    }
    let cut_off: Vec<usize> = (0..mesh.len()).filter(|&v| !reached[v]).collect();
    cut_off.iter().for_each(|&v| labels[v] = NONE);
    let around = cut_off.into_iter().flat_map(|v| mesh.neighbors(v)).copied().collect();
    exchange_around(mesh, sites, labels, around, usize::MAX);
}

/// Moves sites that own no vertex to the vertices farthest from their sites, until every site owns one. Returns how many
/// were moved.
pub(super) fn rescue(mesh: &FineMesh, sites: &mut [Site], labels: &mut Vec<u32>) -> usize {
    const ROUNDS: usize = 32;
    let mut moved = 0;
    for _ in 0..ROUNDS {
        let empty = empty_cells(sites.len(), labels);
        if empty.is_empty() {
            break;
        }
        moved += empty.len();
        let mut farthest: Vec<(f32, u32)> = labels
            .iter()
            .enumerate()
            .filter(|&(v, &label)| label != NONE && sites[label as usize].vertex != v as u32)
            .map(|(v, &label)| (sites[label as usize].square(mesh.positions[v]), v as u32))
            .collect();
        farthest.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        // One new site per cell and round, as far as there are cells enough.
        let mut used = vec![false; sites.len()];
        let mut places: Vec<u32> = Vec::new();
        for spread in [true, false] {
            for &(_, v) in &farthest {
                let label = labels[v as usize] as usize;
                if places.len() < empty.len() && (!spread || !std::mem::replace(&mut used[label], true)) {
                    places.push(v);
                }
            }
        }
        places.sort_unstable();
        places.dedup();
        for (&i, &v) in empty.iter().zip(&places) {
            sites[i as usize] = Site::at_vertex(mesh, v);
            labels[v as usize] = i;
        }
        exchange(mesh, sites, labels, usize::MAX);
    }
    moved
}

/// Sites without a vertex.
pub(super) fn empty_cells(sites: usize, labels: &[u32]) -> Vec<u32> {
    let mut owns = vec![false; sites];
    for &label in labels {
        if let Some(owns) = owns.get_mut(label as usize) {
            *owns = true;
        }
    }
    (0..sites as u32).filter(|&i| !owns[i as usize]).collect()
}
