//! The paper's first set: a coarse mesh, and samples put into its largest triangles.
//!
//! In: a [`FineMesh`] and a count or a fill rate η. Out: a [`Triangulation`]. The triangle with the least fill, that is the
//! largest metric area, gets a sample at its centroid, brought to the surface by a walk; edges around it are flipped. Fill is
//! the area of half a unit ellipse divided by that of the triangle (Eq. 6, with 1/√det M). On a surface the centroid may come
//! back near a corner or fold the triangle: such a triangle is left out, or the loop would not end.

use super::{
    form,
    mesh::FineMesh,
    qem::{coarse_mesh, triangles_between},
    triangulation::Triangulation,
    walk::{Site, walk},
};
use crate::{error::PatternError, sampling::Progress};
use bevy::prelude::*;
use std::collections::BinaryHeap;

/// Samples of the coarse mesh, relative to all samples.
const COARSE: usize = 10;
/// The least vertices of the coarse mesh.
const LEAST_COARSE: usize = 4;
/// The fill rate at which about the count of a hexagonal packing is reached.
const FILL: f32 = 0.55;
/// How the fill rate grows where it left too few samples, and how often.
const DENSER: f32 = 1.2;
const ROUNDS: usize = 8;
/// A new sample's least distance from the triangle's corners, relative to the edge of the largest triangle allowed.
const SEPARATION: f32 = 0.45;
/// The most flips for one sample.
const MAX_FLIPS: usize = 200;

/// When to stop inserting.
#[derive(Debug, Clone, Copy)]
pub(super) enum Target {
    /// At so many samples.
    Count(usize),
    /// Where every triangle is filled to this rate, or at so many samples.
    Fill(f32, usize),
}

/// A triangulation of about the target's samples: no more than its count, and fewer only where triangles were left out.
/// Where the coarse mesh has too many vertices already, as one of very many components has, it is made of the `darts`.
pub(super) fn triangulation(
    mesh: &FineMesh,
    target: Target,
    darts: &[u32],
    progress: &Progress,
) -> Result<Triangulation, PatternError> {
    let (mut vertices, mut triangles) = coarse_mesh(mesh, (darts.len() / COARSE).max(LEAST_COARSE))?;
    if vertices.len() > darts.len() {
        (vertices, triangles) = (darts.to_vec(), triangles_between(mesh, darts)?);
    }
    let sites: Vec<Site> = vertices.iter().map(|&v| Site::at_vertex(mesh, v)).collect();
    let mut samples = Triangulation::new(mesh, sites, &triangles);
    samples.flip_all();
    match target {
        Target::Fill(rate, most) => insert(mesh, &mut samples, rate, most, progress)?,
        Target::Count(count) => {
            for round in 0..ROUNDS {
                insert(mesh, &mut samples, FILL * DENSER.powi(round as i32), count, progress)?;
            }
        }
    }
    Ok(samples)
}

/// Inserts samples, into the largest triangle first, until all are filled or there are `most`.
fn insert(
    mesh: &FineMesh,
    samples: &mut Triangulation,
    rate: f32,
    most: usize,
    progress: &Progress,
) -> Result<(), PatternError> {
    let largest = std::f32::consts::FRAC_PI_2 / rate;
    let separation = SEPARATION * (4.0 * largest / 3.0_f32.sqrt()).sqrt();
    let mut heap = BinaryHeap::new();
    let push = |heap: &mut BinaryHeap<(u32, u32)>, samples: &Triangulation, t: u32| {
        let area = samples.area(t as usize);
        if area > largest {
            heap.push((area.to_bits(), t));
        }
    };
    (0..samples.triangles.len() as u32).for_each(|t| push(&mut heap, samples, t));
    let (mut stack, mut changed) = (Vec::new(), Vec::new());
    while let Some((area, t)) = heap.pop() {
        progress.check()?;
        if samples.sites.len() >= most {
            break;
        }
        // Triangles that changed since are in the heap anew.
        if samples.area(t as usize).to_bits() != area {
            continue;
        }
        let Some((site, normal)) = candidate(mesh, samples, t as usize, separation) else {
            continue;
        };
        let [second, third] = samples.insert(t, site, normal);
        changed.clear();
        changed.extend([t, second, third]);
        stack.extend([(t, 0), (second, 0), (third, 0)]);
        samples.flip_stacked(&mut stack, &mut MAX_FLIPS.clone(), |pair| changed.extend(pair));
        changed.sort_unstable();
        changed.dedup();
        changed.iter().for_each(|&t| push(&mut heap, samples, t));
    }
    Ok(())
}

/// The sample at a triangle's centroid, if it is far enough from the corners and folds nothing.
fn candidate(mesh: &FineMesh, samples: &Triangulation, t: usize, separation: f32) -> Option<(Site, Vec3)> {
    let corners = samples.corners(t);
    let names = samples.triangles[t].corners;
    let center = (corners[0] + corners[1] + corners[2]) / 3.0;
    let site = walk(mesh, samples.sites[names[0] as usize].triangle, center);
    let apart = |&v: &u32| {
        let corner = &samples.sites[v as usize];
        let metric = form::middle(&site.metric, &corner.metric);
        form::square(&metric, site.position - corner.position) > separation * separation
    };
    let normal: Vec3 = names.iter().map(|&v| samples.normals[v as usize]).sum();
    let upright = |k: usize| {
        let (x, y) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
        (x - site.position).cross(y - site.position).dot(normal) > 0.0
    };
    (names.iter().all(apart) && (0..3).all(upright)).then(|| (site, mesh.normal(&site)))
}
