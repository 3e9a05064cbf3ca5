//! Samples that are crowded are put where holes are.
//!
//! In: sites and labels. Out: as many sites, with labels. Lloyd's steps move a site by a part of a distance: a lack here and
//! an excess some ten distances away would not meet.

use super::{
    form, labels,
    mesh::{FineMesh, NONE},
    walk::{Site, walk},
};
use bevy::prelude::*;

/// A vertex farther than this from its site has room for another, squared, where touching samples are 2 apart; the corners
/// of a hexagonal cell are at 1.155.
const HOLE: f32 = 1.46 * 1.46;
/// Holes nearer than this to each other are one, squared.
const APART: f32 = 2.4 * 2.4;
/// Cells smaller than this part of the mean can be done without.
const SMALL: f32 = 0.85;
/// The most sites that are moved at once: one of so many.
const ONE_OF: usize = 64;
/// The farthest point that a cell is to have at last, in so many rounds, and after each pass with cells that are connected.
const REACH: f32 = 1.44;
const PASSES: usize = 2;
const ROUNDS: usize = 6;

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

/// Brings the sites of cells that reach far towards their farthest points: at borders, and where the metric changes within
/// a cell, as at the pole of a field, the centroid is not in its middle. Cells are connected before, so that no far point is
/// hidden in a part that is cut off.
pub(super) fn close(mesh: &FineMesh, sites: &mut [Site], labels: &mut [u32]) {
    for _ in 0..PASSES {
        labels::connect(mesh, sites, labels);
        let mut far = vec![Far::default(); sites.len()];
        let mut changed = vec![true; sites.len()];
        for _ in 0..ROUNDS {
            measure(mesh, sites, labels, &changed, &mut far);
            let reaching: Vec<bool> = far.iter().map(|far| far.square > REACH * REACH).collect();
            if !reaching.contains(&true) {
                break;
            }
            for (site, far) in sites.iter_mut().zip(&far).filter(|(_, far)| far.square > REACH * REACH) {
                let part = 1.0 - REACH / far.square.sqrt();
                *site = walk(mesh, site.triangle, site.position.lerp(far.point, part));
            }
            changed = relabel(mesh, sites, labels, reaching);
        }
    }
}

/// Brings labels up to date after some sites have moved. Returns which cells have changed.
fn relabel(mesh: &FineMesh, sites: &[Site], labels: &mut [u32], moved: Vec<bool>) -> Vec<bool> {
    let before = labels.to_vec();
    labels::claim(mesh, sites, labels);
    let is_moved = |&v: &u32| moved.get(labels[v as usize] as usize) == Some(&true);
    let around = (0..mesh.len() as u32).filter(is_moved).collect();
    labels::exchange_around(mesh, sites, labels, around, usize::MAX);
    let mut changed = moved;
    for (&old, &new) in before.iter().zip(&*labels).filter(|(old, new)| old != new) {
        for cell in [old, new].into_iter().filter(|&cell| cell != NONE) {
            changed[cell as usize] = true;
        }
    }
    changed
}

/// The farthest point of a cell.
#[derive(Clone, Copy, Default)]
struct Far {
    /// Its distance from the site, squared.
    square: f32,
    point: Vec3,
}

/// Finds the farthest points of those cells that have changed: vertices, and where cells meet on edges and in triangles.
fn measure(mesh: &FineMesh, sites: &[Site], labels: &[u32], changed: &[bool], far: &mut [Far]) {
    let is_changed = |label: u32| changed.get(label as usize) == Some(&true);
    for (far, _) in far.iter_mut().zip(changed).filter(|(_, changed)| **changed) {
        *far = Far::default();
    }
    let mut add = |label: u32, square: f32, point: Vec3| {
        let far = &mut far[label as usize];
        if is_changed(label) && square > far.square {
            *far = Far { square, point };
        }
    };
    for t in 0..mesh.triangles.len() {
        let names = mesh.triangles[t].map(|v| labels[v as usize]);
        if !names.into_iter().any(is_changed) || names.contains(&NONE) {
            continue;
        }
        let points = mesh.corners(t);
        let square = |label: u32, point: Vec3| sites[label as usize].square(point);
        for k in 0..3 {
            add(names[k], square(names[k], points[k]), points[k]);
        }
        if names == [names[0]; 3] {
            continue;
        }
        let mut meet = |point: Vec3| {
            let [first, second, third] = names.map(|label| (square(label, point), label));
            let nearest = [second, third]
                .into_iter()
                .fold(first, |a, b| if b.0 < a.0 { b } else { a });
            add(nearest.1, nearest.0, point);
        };
        // Squares are taken as linear between the corners.
        let squares = names.map(|label| Vec3::from_array(points.map(|point| square(label, point))));
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let excess = squares[a] - squares[b];
            if excess[a] < 0.0 && excess[b] > 0.0 {
                meet(points[a].lerp(points[b], excess[a] / (excess[a] - excess[b])));
            }
        }
        let weights = (squares[0] - squares[1]).cross(squares[1] - squares[2]);
        let weights = weights / weights.element_sum();
        if weights.min_element() >= 0.0 {
            meet(points[0] * weights.x + points[1] * weights.y + points[2] * weights.z);
        }
    }
}
