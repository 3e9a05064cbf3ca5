//! Principal curvature directions.
//!
//! In: positions and normals of a graph. Out: a unit tangent per vertex, of line symmetry. The shape operator S of a
//! vertex is the symmetric 2×2 matrix that best explains how the normal changes towards the neighbours, S Δv ≈ Δn in the
//! least-squares sense. Its deviator ((S₁₁ - S₂₂)/2, S₁₂) is a complex number u at twice the angle of the major direction,
//! as long as the two curvatures differ; it is smoothed over the surface, u ← 0.3 u + 0.7 (mean of the neighbours' u,
//! carried over by the smallest rotation between the normals).

use super::{DirectionField, any_tangent, tangent};
use crate::{error::PatternError, parallel, surface::SurfaceGraph};
use bevy::{
    math::{DMat3, DVec2, DVec3},
    prelude::*,
};

/// One of the two principal curvature directions. Where the normals point outwards, convex counts as positive.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default)]
pub enum Principal {
    /// Across ridges: the direction in which the surface curves most (around a cylinder).
    #[default]
    Major,
    /// Along ridges: the direction in which it curves least, or most inwards (along a cylinder).
    Minor,
}

/// Share of the old value in a step of smoothing.
const KEEP: f32 = 0.3;
/// A vertex whose normal differs by less than this (in radians) between the two directions is flat or spherical: what is
/// left is rounding noise, and must not be smoothed into a field.
const NOISE: f64 = 1e-5;
/// Added to the matrix of a vertex's edges, which is divided by its trace; decides where they lie on one line.
const RIDGE: f64 = 1e-6;
/// The median is that of at most so many vertices, at equal steps.
const SAMPLES: usize = 16384;

/// A unit tangent per vertex along the principal direction, after `smoothing` steps.
pub(super) fn principal_directions(graph: &SurfaceGraph, principal: Principal, smoothing: u32) -> Vec<Vec3> {
    let frames = parallel::collect(graph.len(), |i| any_tangent(graph.normals[i]));
    let mut lines = lines(graph);
    if smoothing > 0 && !graph.is_empty() {
        smooth(graph, &frames, &mut lines, smoothing);
    }
    let sign = if principal == Principal::Major { 1.0 } else { -1.0 };
    parallel::collect(graph.len(), |i| {
        tangent::line_of(sign * lines[i], frames[i], graph.normals[i])
    })
}

/// Whether so many steps of smoothing are done.
///
/// # Errors
/// [`OutOfRange`](PatternError::OutOfRange).
pub(crate) fn check_smoothing(smoothing: u32) -> Result<(), PatternError> {
    if smoothing <= DirectionField::MAX_SMOOTHING {
        return Ok(());
    }
    Err(PatternError::OutOfRange {
        what: "DirectionField::PrincipalCurvature::smoothing",
        value: smoothing as f32,
        expected: "0..=1000",
    })
}

/// Steps of smoothing that follow a surface in a frame.
pub(crate) const FOLLOWING_STEPS: u32 = 3;

/// Whether so many steps of smoothing are worth to be spread over frames.
pub(crate) fn is_followed(smoothing: u32) -> bool {
    smoothing > 2 * FOLLOWING_STEPS
}

/// Share of the surface's own u in what a frame's steps start from: so that what is followed has been smoothed by as many
/// steps in the mean.
pub(crate) fn own_share(smoothing: u32) -> f32 {
    FOLLOWING_STEPS as f32 / smoothing.max(FOLLOWING_STEPS) as f32
}

/// Lines of principal curvature that follow a surface which moves: a few steps from those of the frame before, in which they
/// have `previous`, tangents along the major direction as long as |u|. While the surface moves the result is nearly as smooth as
/// after `smoothing` steps from nothing, where those of many frames are mixed; once it rests, it is smoothed from nothing.
/// Returns the same for the frame after.
pub fn follow_principal_lines(graph: &SurfaceGraph, smoothing: u32, previous: &[Vec3]) -> Vec<Vec3> {
    let frames = parallel::collect(graph.len(), |i| any_tangent(graph.normals[i]));
    let own = lines(graph);
    let share = own_share(smoothing);
    let mut lines = parallel::collect(graph.len(), |i| {
        let (x, y) = (frames[i], graph.normals[i].cross(frames[i]));
        let c = Vec2::new(previous[i].dot(x), previous[i].dot(y));
        let before = if c.length() > 1e-6 * previous[i].length() {
            tangent::squared(c) / c.length()
        } else {
            Vec2::ZERO
        };
        before.lerp(own[i], share)
    });
    smooth(graph, &frames, &mut lines, FOLLOWING_STEPS);
    parallel::collect(graph.len(), |i| {
        lines[i].length() * tangent::line_of(lines[i], frames[i], graph.normals[i])
    })
}

/// u of every vertex in the frame of [`any_tangent`], as it is smoothed: at most 1.
pub(super) fn lines(graph: &SurfaceGraph) -> Vec<Vec2> {
    let mut lines = parallel::collect(graph.len(), |i| deviator(graph, any_tangent(graph.normals[i]), i));
    limit(&mut lines);
    lines
}

/// u of vertex i in the frame (x, n × x): its modulus is half the difference of the principal curvatures.
fn deviator(graph: &SurfaceGraph, x: Vec3, i: usize) -> Vec2 {
    let level = graph.mesh_level();
    let (v, n) = (graph.positions[i], graph.normals[i]);
    let y = n.cross(x);
    // Normal equations of S (a, b) = (p, q) for the unknowns S₁₁, S₁₂, S₂₂.
    let (mut aa, mut ab, mut bb, mut right) = (0.0, 0.0, 0.0, DVec3::ZERO);
    for k in level.edges(i) {
        let j = level.neighbors[k] as usize;
        let (dv, dn) = (graph.positions[j] - v, graph.normals[j] - n);
        let [a, b, p, q] = [dv.dot(x), dv.dot(y), dn.dot(x), dn.dot(y)].map(f64::from);
        aa += a * a;
        ab += a * b;
        bb += b * b;
        right += DVec3::new(a * p, b * p + a * q, b * q);
    }
    let trace = aa + bb;
    if trace <= 0.0 {
        return Vec2::ZERO;
    }
    // Divided by the trace to be free of units.
    let [aa, ab, bb] = [aa, ab, bb].map(|m| m / trace);
    let matrix =
        DMat3::from_cols_array(&[aa, ab, 0.0, ab, 1.0, ab, 0.0, ab, bb]) + DMat3::from_diagonal(DVec3::splat(RIDGE));
    let shape = matrix.inverse() * (right / trace);
    let deviator = DVec2::new(0.5 * (shape.x - shape.z), shape.y);
    let edge = (trace / level.edges(i).len() as f64).sqrt();
    if deviator.is_finite() && deviator.length() * edge > NOISE {
        deviator.as_vec2()
    } else {
        Vec2::ZERO
    }
}

/// Measures u by its median over the vertices (the curved ones, where most are flat), and cuts it off there: what is
/// more curved than usual must not outvote all others.
fn limit(lines: &mut [Vec2]) {
    let step = lines.len().div_ceil(SAMPLES).max(1);
    let mut moduli: Vec<f32> = lines.iter().step_by(step).map(|u| u.length()).collect();
    let mut median = median(&mut moduli);
    if median == 0.0 {
        moduli.retain(|&modulus| modulus > 0.0);
        median = self::median(&mut moduli);
    }
    if median > 0.0 {
        for u in lines {
            *u = (*u / median).clamp_length_max(1.0);
        }
    }
}

fn median(values: &mut [f32]) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

fn smooth(graph: &SurfaceGraph, frames: &[Vec3], lines: &mut Vec<Vec2>, steps: u32) {
    let level = graph.mesh_level();
    let transports = transports(graph, frames);
    let mut next = vec![Vec2::ZERO; lines.len()];
    for _ in 0..steps {
        parallel::fill(&mut next, |i| {
            let edges = level.edges(i);
            let share = (1.0 - KEEP) / edges.len().max(1) as f32;
            let sum: Vec2 = edges
                .map(|k| transports[k].rotate(lines[level.neighbors[k] as usize]))
                .sum();
            KEEP * lines[i] + share * sum
        });
        std::mem::swap(lines, &mut next);
    }
}

/// Per directed edge: the unit complex number that takes u from the source's frame to the target's, at twice the angle
/// between the two frames.
fn transports(graph: &SurfaceGraph, frames: &[Vec3]) -> Vec<Vec2> {
    let level = graph.mesh_level();
    let mut targets = vec![0; level.neighbors.len()];
    for i in 0..level.len() {
        targets[level.edges(i)].fill(i);
    }
    parallel::collect(level.neighbors.len(), |k| {
        let (i, j) = (targets[k], level.neighbors[k] as usize);
        let n = graph.normals[i];
        let carried = Quat::from_rotation_arc(graph.normals[j], n) * frames[j];
        let angle = Vec2::new(carried.dot(frames[i]), carried.dot(n.cross(frames[i])));
        tangent::squared(angle.normalize_or(Vec2::X))
    })
}
