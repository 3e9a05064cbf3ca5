//! The CPU twins of the pass `pose_vertices` and of `deform.wgsl`.
//!
//! In: a graph at rest, and a pose or the same graph posed. Out: positions, and what carries vectors along.

use super::{Pose, Rig};
use crate::{field::any_tangent, parallel, surface::SurfaceGraph};
use bevy::{math::Vec3A, prelude::*};

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

/// Per vertex, what carries a vector of the graph at rest to `posed`, the same graph with other positions and normals. In the
/// tangent plane it is the linear map that best explains where the edges to the neighbours have gone, in the least-squares
/// sense; the normal goes to the normal, stretched as much as the surface is in the mean.
pub fn deformations(rest: &SurfaceGraph, posed: &SurfaceGraph) -> Vec<Mat3> {
    let level = rest.mesh_level();
    parallel::collect(rest.len(), |i| {
        let n = rest.normals[i];
        let x = any_tangent(n);
        let y = n.cross(x);
        let scale = rest.areas[i].max(f32::MIN_POSITIVE).sqrt().recip();
        let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
        // Sums of the edges as they are now, times the tangential coordinates they had.
        let (mut along_x, mut along_y) = (Vec3::ZERO, Vec3::ZERO);
        for k in level.edges(i) {
            let j = level.neighbors[k] as usize;
            let e = (rest.positions[j] - rest.positions[i]) * scale;
            let moved = (posed.positions[j] - posed.positions[i]) * scale;
            let (a, b) = (e.dot(x), e.dot(y));
            aa += a * a;
            ab += a * b;
            bb += b * b;
            along_x += a * moved;
            along_y += b * moved;
        }
        let trace = aa + bb;
        if trace <= 0.0 {
            return Mat3::IDENTITY;
        }
        let (aa, ab, bb) = (aa / trace + RIDGE, ab / trace, bb / trace + RIDGE);
        let determinant = (aa * bb - ab * ab) * trace;
        let x_now = (bb * along_x - ab * along_y) / determinant;
        let y_now = (aa * along_y - ab * along_x) / determinant;
        let n_now = x_now.cross(y_now).length().sqrt() * posed.normals[i];
        Mat3::from_cols(x_now, y_now, n_now) * Mat3::from_cols(x, y, n).transpose()
    })
}
