//! The CPU twins of the passes `pose_vertices` and `carry_directions`.
//!
//! In: a graph at rest, and a pose or the same graph posed. Out: positions, and directions that a deformation carries along.

use super::{Pose, Rig};
use crate::{
    field::{any_tangent, project_tangent},
    parallel,
    surface::SurfaceGraph,
};
use bevy::{
    math::{Mat2, Vec3A},
    prelude::*,
};

/// The position of each vertex of `graph` in a pose: displaced by its morph targets, then carried by its joints, as Bevy's
/// vertex shader does it. Joints beyond the pose's last matrix count as the last; without a matrix nothing is carried.
pub fn pose_vertices(graph: &SurfaceGraph, rig: &Rig, pose: &Pose) -> Vec<Vec3> {
    let vertices = graph.len();
    let count = pose.weights.len().min(rig.targets(vertices));
    parallel::collect(vertices, |v| {
        let displaced = (0..count).fold(graph.positions[v], |p, t| {
            p + pose.weights[t] * rig.displacements[t * vertices + v]
        });
        let (Some(last), p) = (pose.matrices.len().checked_sub(1), Vec3A::from(displaced)) else {
            return displaced;
        };
        if rig.joints.is_empty() {
            return pose.matrices[0].transform_point3a(p).into();
        }
        let carried = |k: usize| {
            let joint = usize::from(rig.joints[v][k]).min(last);
            rig.weights[v][k] * pose.matrices[joint].transform_point3a(p)
        };
        (carried(0) + carried(1) + carried(2) + carried(3)).into()
    })
}

/// Added to the matrix of a vertex's edges, which is divided by its trace; decides where they lie on one line.
const RIDGE: f32 = 1e-6;

/// Unit tangents `directions` of the graph at rest, carried along to `posed`, the same graph with other positions and
/// normals. The deformation at a vertex is the linear map of the tangent plane that best explains where the edges to its
/// neighbours have gone, in the least-squares sense.
pub fn carry_directions(rest: &SurfaceGraph, posed: &SurfaceGraph, directions: &[Vec3]) -> Vec<Vec3> {
    let level = rest.mesh_level();
    parallel::collect(rest.len(), |i| {
        let (n, d) = (rest.normals[i], directions[i]);
        let x = any_tangent(n);
        let y = n.cross(x);
        let scale = rest.areas[i].max(f32::MIN_POSITIVE).sqrt().recip();
        let edges = level.edges(i).map(|k| {
            let j = level.neighbors[k] as usize;
            let e = (rest.positions[j] - rest.positions[i]) * scale;
            let moved = posed.positions[j] - posed.positions[i];
            (Vec2::new(e.dot(x), e.dot(y)), moved * scale)
        });
        let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
        for (e, _) in edges.clone() {
            aa += e.x * e.x;
            ab += e.x * e.y;
            bb += e.y * e.y;
        }
        let trace = aa + bb;
        if trace <= 0.0 {
            return project_tangent(d, posed.normals[i]);
        }
        let moments = Mat2::from_cols_array(&[aa / trace + RIDGE, ab / trace, ab / trace, bb / trace + RIDGE]);
        let c = moments.inverse() * Vec2::new(d.dot(x), d.dot(y));
        let carried: Vec3 = edges.map(|(e, moved)| moved * e.dot(c)).sum();
        project_tangent(carried.normalize_or(d), posed.normals[i])
    })
}
