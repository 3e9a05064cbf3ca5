//! Samples that are too few to keep the domain's corners: from a single one to some thirty in a square.
//!
//! In: a plan without border samples. Out: [`PlanarSamples`], all free. They are relaxed by Lloyd's method on a raster: each
//! moves to the centroid of the points that are nearest to it. The corners serve as vertices of the triangulation only.

use super::{
    domain::PlanarDomain,
    metric::{ScaledMetric, det, dot},
    options::PlanarSampling,
    raster::{Nearest, Raster},
    sampler::{HEX_DISTANCE, Plan},
    samples::{PlanarSamples, corners},
    triangulation::{Triangulation, Vertex},
};
use crate::{
    error::PatternError,
    sampling::{Progress, SamplingTimes},
};
use bevy::{
    math::{DVec2, UVec2},
    platform::time::Instant,
};
use glam_matrix_extras::SymmetricDMat2;

/// Points of the raster per sample, and for all samples at least and at most.
const POINTS: (usize, usize, usize) = (256, 16_384, 1 << 20);

type Sample = (DVec2, SymmetricDMat2);

/// Samples a domain with `plan.count` samples, none of them on the border.
pub(super) fn few_samples(
    domain: &PlanarDomain,
    plan: &Plan,
    sampling: &PlanarSampling,
    progress: &Progress,
    start: Instant,
) -> Result<PlanarSamples, PatternError> {
    let mut samples = inserted(plan, sampling)?;
    let initial = start.elapsed().as_secs_f32() * 1e3;
    let raster = raster(domain, plan.count);
    let (mut steps, mut rms_move) = (0, 0.0);
    while steps < sampling.steps {
        progress.report((steps + 1) as f32 / (sampling.steps + 2) as f32)?;
        rms_move = step(domain, &plan.metric, &raster, &mut samples)?;
        steps += 1;
        if rms_move < f64::from(sampling.tolerance) {
            break;
        }
    }
    let relaxed = start.elapsed().as_secs_f32() * 1e3;
    let (triangles, corners) = triangles(plan, &samples)?;
    let mut edges = edges(&triangles);
    edges.extend(touching(&raster, &nearest(&raster, &samples)));
    edges.sort_unstable();
    edges.dedup();
    progress.report(1.0)?;
    Ok(PlanarSamples {
        positions: samples.iter().map(|(p, _)| *p).collect(),
        metrics: samples.iter().map(|(_, m)| *m).collect(),
        boundary: vec![false; samples.len()],
        triangles,
        corners,
        edges,
        scale: plan.metric.scale,
        steps,
        rms_move,
        times: SamplingTimes {
            initial,
            per_step: (relaxed - initial) / steps.max(1) as f32,
            total: start.elapsed().as_secs_f32() * 1e3,
        },
    })
}

/// The first places: barycentres of the largest triangles, those of the domain's corners to begin with.
fn inserted(plan: &Plan, sampling: &PlanarSampling) -> Result<Vec<Sample>, PatternError> {
    let mut mesh = plan.corners()?;
    let corners = mesh.vertices.len();
    mesh.flip_violated();
    plan.inserter(sampling.seed).exactly(&mut mesh, corners + plan.count)?;
    Ok(mesh.vertices[corners..]
        .iter()
        .map(|vertex| (vertex.p, vertex.m))
        .collect())
}

/// A raster with square cells.
fn raster(domain: &PlanarDomain, count: usize) -> Raster {
    let (min, max) = domain.bounds();
    let extent = max - min;
    let (each, least, most) = POINTS;
    let points = count.saturating_mul(each).clamp(least, most) as f64;
    let columns = (points * extent.x / extent.y).sqrt().clamp(8.0, points / 8.0);
    Raster::new(
        domain,
        DVec2::new(columns, points / columns).ceil().as_uvec2().max(UVec2::ONE),
    )
}

fn nearest(raster: &Raster, samples: &[Sample]) -> Nearest {
    raster.nearest(samples, HEX_DISTANCE, 0.0)
}

/// Moves each sample to the centroid of its cell, weighted by the metric area; where that is outside, to the point of the
/// cell that is nearest to it. Returns the root mean square of the moves.
fn step(
    domain: &PlanarDomain,
    metric: &ScaledMetric,
    raster: &Raster,
    samples: &mut [Sample],
) -> Result<f64, PatternError> {
    let Nearest { label, .. } = nearest(raster, samples);
    let mut sums = vec![(0.0, DVec2::ZERO); samples.len()];
    for (k, x) in raster.points() {
        let weight = det(&metric.at(x, k)?).sqrt();
        let (mass, moment) = &mut sums[label[k] as usize];
        *mass += weight;
        *moment += weight * x;
    }
    let mut targets: Vec<DVec2> = samples
        .iter()
        .zip(sums)
        .map(|((p, _), (mass, moment))| if mass > 0.0 { moment / mass } else { *p })
        .collect();
    let outside: Vec<bool> = targets.iter().map(|&p| !domain.contains(p)).collect();
    if outside.contains(&true) {
        let mut best = vec![f64::INFINITY; samples.len()];
        let centroids = targets.clone();
        for (k, x) in raster.points() {
            let i = label[k] as usize;
            let r = x - centroids[i];
            let squared = dot(&samples[i].1, r, r);
            if outside[i] && squared < best[i] {
                best[i] = squared;
                targets[i] = x;
            }
        }
    }
    let mut sum = 0.0;
    for (index, ((p, m), target)) in samples.iter_mut().zip(targets).enumerate() {
        sum += dot(m, target - *p, target - *p);
        *p = target;
        *m = metric.at(target, index)?;
    }
    Ok((sum / samples.len() as f64).sqrt())
}

/// The triangulation of the samples and the domain's corners, a corner named by the nearest sample; and where its corners
/// are.
fn triangles(plan: &Plan, samples: &[Sample]) -> Result<(Vec<[u32; 3]>, Vec<[DVec2; 3]>), PatternError> {
    let mut mesh = plan.corners()?;
    let helpers = mesh.vertices.len() as u32;
    mesh.flip_violated();
    for &(p, m) in samples {
        let t = triangle_at(&mesh, p);
        let star = mesh.split(t, Vertex { p, m });
        mesh.settle_star(&star, |_, _| ());
    }
    mesh.flip_violated();
    let nearest = |p: DVec2| {
        let squared = |&(q, m): &Sample| dot(&m, p - q, p - q);
        let by_distance = |(_, a): &(u32, &Sample), (_, b): &(u32, &Sample)| squared(a).total_cmp(&squared(b));
        (0..).zip(samples).min_by(by_distance).map_or(0, |(i, _)| i)
    };
    let named: Vec<u32> = plan.ground.points.iter().map(|&p| nearest(p)).collect();
    let name = |v: u32| if v < helpers { named[v as usize] } else { v - helpers };
    let names = mesh.triangles.iter().map(|triangle| triangle.v.map(name)).collect();
    Ok((names, corners(&mesh)))
}

/// The triangle that a point lies in, or lies in most nearly.
fn triangle_at(mesh: &Triangulation, p: DVec2) -> u32 {
    let depth = |t: usize| {
        let [a, b, c] = mesh.corners(t).map(|corner| corner.p);
        let signed = [(a, b), (b, c), (c, a)].map(|(a, b)| (b - a).perp_dot(p - a));
        signed.into_iter().fold(f64::INFINITY, f64::min) / mesh.double_area(t).max(f64::MIN_POSITIVE)
    };
    (0..mesh.triangles.len())
        .map(|t| (depth(t), t as u32))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(0, |(_, t)| t)
}

/// The edges of the triangles, but for those from a sample to itself.
fn edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    sides
        .filter(|[a, b]| a != b)
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect()
}

/// Samples whose cells meet between two points of the raster.
fn touching(raster: &Raster, nearest: &Nearest) -> Vec<[u32; 2]> {
    let columns = raster.size.x as usize;
    let label = &nearest.label;
    let mut pairs = Vec::new();
    for (k, _) in raster.points() {
        let right = if (k + 1) % columns == 0 { k } else { k + 1 };
        for other in [right, k + columns] {
            if other < label.len() && label[other] != u32::MAX && label[other] != label[k] {
                pairs.push([label[k].min(label[other]), label[k].max(label[other])]);
            }
        }
    }
    pairs
}
