//! Samples that are crowded are put where holes are.
//!
//! In: sites and labels. Out: as many sites, with labels. Lloyd's steps move a site by a part of a distance: a lack here and
//! an excess some ten distances away would not meet.

use super::{
    form, labels,
    mesh::{FineMesh, NONE},
    walk::{Site, walk},
};

/// A vertex farther than this from its site has room for another, squared, where touching samples are 2 apart; the corners
/// of a hexagonal cell are at 1.155.
const HOLE: f32 = 1.46 * 1.46;
/// Holes nearer than this to each other are one, squared.
const APART: f32 = 2.4 * 2.4;
/// Cells smaller than this part of the mean can be done without.
const SMALL: f32 = 0.85;
/// The most sites that are moved at once: one of so many.
const ONE_OF: usize = 64;
/// The farthest point that a cell is to have at last, and in how many rounds.
const REACH: f32 = 1.4;
const ROUNDS: usize = 12;

/// Moves the sites of the smallest cells into the largest holes.
pub(super) fn fill(mesh: &FineMesh, sites: &mut [Site], labels: &mut Vec<u32>) {
    let most = sites.len() / ONE_OF;
    let mut areas = vec![0.0_f32; sites.len()];
    let mut far: Vec<(f32, u32)> = Vec::new();
    for (v, &label) in labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
        areas[label as usize] += mesh.weights[v];
        let square = sites[label as usize].square(mesh.positions[v]);
        if square > HOLE {
            far.push((square, v as u32));
        }
    }
    far.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut holes: Vec<usize> = Vec::new();
    for v in far.into_iter().map(|(_, v)| v as usize) {
        let apart = |&w: &usize| form::square(&mesh.metrics[v], mesh.positions[v] - mesh.positions[w]) > APART;
        if holes.len() < most && holes.iter().all(apart) {
            holes.push(v);
        }
    }
    let limit = SMALL * areas.iter().sum::<f32>() / sites.len() as f32;
    let mut small: Vec<u32> = (0..sites.len() as u32).filter(|&i| areas[i as usize] < limit).collect();
    small.sort_by(|&a, &b| areas[a as usize].total_cmp(&areas[b as usize]));
    // Around a hole nothing is taken away.
    let mut stays = vec![false; sites.len()];
    for &v in &holes {
        let around = mesh.neighbors(v).iter().map(|&w| labels[w as usize]);
        around.chain([labels[v]]).for_each(|label| stays[label as usize] = true);
    }
    small.retain(|&i| !stays[i as usize]);
    let moved: Vec<(u32, usize)> = small.into_iter().zip(holes).collect();
    if moved.is_empty() {
        return;
    }
    let mut gone = vec![false; sites.len()];
    moved.iter().for_each(|&(i, _)| gone[i as usize] = true);
    for label in labels.iter_mut() {
        if gone.get(*label as usize).is_some_and(|gone| *gone) {
            *label = NONE;
        }
    }
    for (i, v) in moved {
        sites[i as usize] = Site::at_vertex(mesh, v as u32);
        labels[v] = i;
    }
    labels::exchange(mesh, sites, labels, usize::MAX);
}

/// Brings the sites of cells that reach far towards their farthest points: where the metric changes within a cell, as at
/// the pole of a field, the centroid is not in its middle.
pub(super) fn close(mesh: &FineMesh, sites: &mut [Site], labels: &mut Vec<u32>) {
    for _ in 0..ROUNDS {
        let mut farthest = vec![(REACH * REACH, NONE); sites.len()];
        for (v, &label) in labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
            let square = sites[label as usize].square(mesh.positions[v]);
            if square > farthest[label as usize].0 {
                farthest[label as usize] = (square, v as u32);
            }
        }
        if farthest.iter().all(|far| far.1 == NONE) {
            break;
        }
        for (site, (square, v)) in sites.iter_mut().zip(farthest).filter(|(_, far)| far.1 != NONE) {
            let way = mesh.positions[v as usize] - site.position;
            *site = walk(mesh, site.triangle, site.position + (1.0 - REACH / square.sqrt()) * way);
        }
        labels::claim(mesh, sites, labels);
        labels::exchange(mesh, sites, labels, usize::MAX);
    }
}
