//! Normals of points that have none.
//!
//! In: points and who is near whom. Out: for each point the unit normal of the plane that fits it and its neighbours
//! best (in the sense of least squares), all on the same side of the surface (H. Hoppe et al., *Surface Reconstruction
//! from Unorganized Points*, 1992): the side is passed from point to point along a spanning tree that prefers steps
//! between nearly parallel planes. It begins in each part at the point farthest from the part's middle, where outside is
//! known.

use super::adjacency::Adjacency;
use crate::parallel;
use bevy::math::{DMat3, DVec3, Vec3};
use std::{cmp::Reverse, collections::BinaryHeap};

/// Squarings of the matrix whose largest eigenvector is sought: its power is 2 to that.
const SQUARINGS: usize = 6;

/// Unit normals of all points, on the outer side of each connected part.
pub(super) fn normals(points: &[Vec3], near: &Adjacency) -> Vec<Vec3> {
    let mut normals = parallel::collect(points.len(), |i| {
        plane(points[i], near.of(i as u32).iter().map(|&j| points[j as usize]))
    });
    orient(points, near, &mut normals);
    normals
}

/// The unit normal of the plane nearest to a point and those around it; one of many where they lie on a line.
pub(super) fn plane(point: Vec3, around: impl Iterator<Item = Vec3> + Clone) -> Vec3 {
    let origin = point.as_dvec3();
    let from_origin = around.map(|p| p.as_dvec3() - origin);
    let (sum, count) = from_origin
        .clone()
        .fold((DVec3::ZERO, 1.0), |(sum, count), p| (sum + p, count + 1.0));
    let mean = sum / count;
    let product = |p: DVec3| DMat3::from_cols(p * p.x, p * p.y, p * p.z);
    let covariance = from_origin.fold(product(mean), |sum, p| sum + product(p - mean));
    // The eigenvector of the smallest eigenvalue is that of the adjugate's largest; a high power is all but its product
    // with itself.
    let [a, b, c] = unit(covariance).to_cols_array_2d().map(DVec3::from);
    let mut power = unit(DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b)));
    for _ in 0..SQUARINGS {
        power = unit(power * power);
    }
    let longest = |m: DMat3| {
        let columns = [m.x_axis, m.y_axis, m.z_axis];
        columns
            .into_iter()
            .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
    };
    let along = |m: DMat3| longest(m).and_then(DVec3::try_normalize);
    along(power)
        .or_else(|| along(covariance).map(DVec3::any_orthonormal_vector))
        .map_or(Vec3::Z, DVec3::as_vec3)
}

/// The matrix over its largest column; as it is where it is zero.
fn unit(m: DMat3) -> DMat3 {
    let columns = [m.x_axis, m.y_axis, m.z_axis];
    let largest = columns
        .iter()
        .fold(0.0_f64, |largest, c| largest.max(c.abs().max_element()));
    if largest > 0.0 { m * (1.0 / largest) } else { m }
}

/// Turns normals to the same side as their neighbours'.
fn orient(points: &[Vec3], near: &Adjacency, normals: &mut [Vec3]) {
    let mut known = vec![false; points.len()];
    for part in parts(near) {
        let middle: DVec3 = part.iter().map(|&i| points[i as usize].as_dvec3()).sum::<DVec3>() / part.len() as f64;
        let out = |i: u32| points[i as usize].as_dvec3() - middle;
        let farther = |a: &&u32, b: &&u32| out(**a).length_squared().total_cmp(&out(**b).length_squared());
        let Some(&first) = part.iter().max_by(farther) else {
            continue;
        };
        if normals[first as usize].as_dvec3().dot(out(first)) < 0.0 {
            normals[first as usize] = -normals[first as usize];
        }
        // How far two planes are from parallel (as bits, which sort as the number does), from, to.
        let mut steps = BinaryHeap::from([Reverse((0, first, first))]);
        while let Some(Reverse((_, from, to))) = steps.pop() {
            if std::mem::replace(&mut known[to as usize], true) {
                continue;
            }
            if normals[from as usize].dot(normals[to as usize]) < 0.0 {
                normals[to as usize] = -normals[to as usize];
            }
            for &next in near.of(to).iter().filter(|&&next| !known[next as usize]) {
                let parallel = normals[to as usize].dot(normals[next as usize]).abs().min(1.0);
                steps.push(Reverse(((1.0 - parallel).to_bits(), to, next)));
            }
        }
    }
}

/// The connected parts of a graph.
fn parts(graph: &Adjacency) -> Vec<Vec<u32>> {
    let mut seen = vec![false; graph.len()];
    let mut parts = Vec::new();
    for start in 0..graph.len() as u32 {
        if std::mem::replace(&mut seen[start as usize], true) {
            continue;
        }
        let mut part = vec![start];
        let mut done = 0;
        while let Some(&node) = part.get(done) {
            done += 1;
            let unseen = graph
                .of(node)
                .iter()
                .filter(|&&next| !std::mem::replace(&mut seen[next as usize], true));
            part.extend(unseen);
        }
        parts.push(part);
    }
    parts
}
