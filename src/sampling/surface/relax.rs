//! Relaxation of a triangulation: samples move to the centroids of their surroundings, and back to the surface.
//!
//! In: a [`Triangulation`] and a [`Centroid`]. Out: the same samples, moved, with edges flipped. With S = Σ w M and
//! b = Σ w M (c - p) over the pieces around a sample p, of area w, centroid c and metric M, it moves by S⁻¹ b (Eq. 7 of the
//! paper, corrected). Back to the surface it walks from triangle to adjacent triangle. Moves that fold a triangle over are
//! undone. Samples at borders stay.

use super::{
    form,
    mesh::FineMesh,
    triangulation::Triangulation,
    walk::{Site, walk},
};
use bevy::prelude::*;
use glam_matrix_extras::SymmetricMat3;

/// The farthest move of one step, where touching samples are 2 apart.
const MAX_MOVE: f32 = 1.0;
/// How often folded triangles are looked for.
const UNFOLD_ROUNDS: usize = 4;
/// The part of the triangle's metric in that of a kite, whose centroid is nearer to the triangle's than to the sample.
const KITE_BLEND: f32 = 0.583;
/// The farthest that a circumcentre is taken to be from the triangle's centroid, in barycentric coordinates.
const MAX_CENTER: f32 = 1.2;

/// What a sample's surroundings are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Centroid {
    /// The star of triangles (the paper's).
    Star,
    /// The dual cell whose corners are the triangles' circumcentres in the metric.
    Kite,
}

/// The sums S and b of a sample.
#[derive(Clone, Copy)]
struct Pull {
    matrix: SymmetricMat3,
    vector: Vec3,
}

impl Pull {
    const NONE: Self = Self {
        matrix: SymmetricMat3::ZERO,
        vector: Vec3::ZERO,
    };

    /// Adds a piece of a weight and a metric whose weighted centroid is `moment` away.
    #[inline(always)]
    fn add(&mut self, weight: f32, metric: &SymmetricMat3, moment: Vec3) {
        self.matrix = form::blend([&self.matrix, metric, metric], Vec3::new(1.0, weight, 0.0));
        self.vector += form::apply(metric, moment);
    }

    fn step(&self) -> Option<Vec3> {
        form::solve(&self.matrix, self.vector)
    }
}

/// One step of relaxation.
pub(super) fn relax(mesh: &FineMesh, samples: &mut Triangulation, centroid: Centroid) {
    let mut pulls = vec![Pull::NONE; samples.sites.len()];
    for t in 0..samples.triangles.len() {
        match centroid {
            Centroid::Star => pull_of_star(samples, t, &mut pulls),
            Centroid::Kite => pull_of_kites(samples, t, &mut pulls),
        }
    }
    let before = (samples.sites.clone(), samples.normals.clone());
    let upright: Vec<bool> = (0..samples.triangles.len()).map(|t| samples.is_upright(t)).collect();
    for (i, pull) in pulls.iter().enumerate() {
        let Some(step) = pull.step().filter(|_| !samples.fixed[i]) else {
            continue;
        };
        let site = &samples.sites[i];
        let length = form::square(&site.metric, step).sqrt();
        let step = step * (MAX_MOVE / length.max(MAX_MOVE));
        samples.sites[i] = walk(mesh, site.triangle, site.position + step);
        samples.normals[i] = mesh.normal(&samples.sites[i]);
    }
    unfold(samples, &before, &upright);
    samples.flip_all();
}

/// The triangle's centroid, weighted by its area as it is (Eq. 7).
fn pull_of_star(samples: &Triangulation, t: usize, pulls: &mut [Pull]) {
    let [a, b, c] = samples.corners(t);
    let (metric, weight) = (samples.metric(t), 0.5 * (b - a).cross(c - a).length());
    let center = (a + b + c) / 3.0;
    for (&v, corner) in samples.triangles[t].corners.iter().zip([a, b, c]) {
        pulls[v as usize].add(weight, &metric, weight * (center - corner));
    }
}

/// The three kites of a triangle, between its circumcentre in the metric and the middles of its edges, each of two
/// right-angled triangles with signed areas.
fn pull_of_kites(samples: &Triangulation, t: usize, pulls: &mut [Pull]) {
    let corners = samples.corners(t);
    let metric = samples.metric(t);
    let (e, g) = (corners[1] - corners[0], corners[2] - corners[0]);
    let (ee, eg, gg) = form::gram(&metric, e, g);
    let determinant = ee * gg - eg * eg;
    if determinant.is_nan() || determinant <= 0.0 {
        return;
    }
    let (u, w) = near_centroid(0.5 * gg * (ee - eg) / determinant, 0.5 * ee * (gg - eg) / determinant);
    let center = corners[0] + u * e + w * g;
    let weights = [1.0 - u - w, u, w];
    let quarter = 0.25 * determinant.sqrt();
    for k in 0..3 {
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        let site = samples.triangles[t].corners[k] as usize;
        let blend = Vec3::new(1.0 - KITE_BLEND, KITE_BLEND, 0.0);
        let own = form::blend([&samples.sites[site].metric, &metric, &metric], blend);
        let (first, second) = (quarter * weights[last], quarter * weights[next]);
        let to = |point: Vec3| point - corners[k];
        let moment = |area: f32, end: usize| area / 3.0 * (0.5 * to(corners[end]) + to(center));
        pulls[site].add(first + second, &own, moment(first, next) + moment(second, last));
    }
}

/// Barycentric coordinates no farther from the centroid than [`MAX_CENTER`].
#[inline(always)]
fn near_centroid(u: f32, w: f32) -> (f32, f32) {
    let (du, dw) = (u - 1.0 / 3.0, w - 1.0 / 3.0);
    let far = (du * du + dw * dw + du * dw).sqrt();
    let factor = MAX_CENTER / far.max(MAX_CENTER);
    (1.0 / 3.0 + factor * du, 1.0 / 3.0 + factor * dw)
}

/// Puts the corners of triangles that were folded over back to where they were.
fn unfold(samples: &mut Triangulation, (sites, normals): &(Vec<Site>, Vec<Vec3>), upright: &[bool]) {
    for _ in 0..UNFOLD_ROUNDS {
        let folded: Vec<usize> = (0..upright.len())
            .filter(|&t| upright[t] && !samples.is_upright(t))
            .collect();
        if folded.is_empty() {
            break;
        }
        for v in folded.into_iter().flat_map(|t| samples.triangles[t].corners) {
            samples.sites[v as usize] = sites[v as usize];
            samples.normals[v as usize] = normals[v as usize];
        }
    }
}
