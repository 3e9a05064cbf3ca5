//! The gradient of a scalar on the surface.
//!
//! In: a scalar φ per graph vertex. Out: the direction of its steepest ascent per vertex, a unit vector or zero: the sum
//! over the triangles of area × gradient, where the gradient of a triangle with corners p₀ p₁ p₂ and unit normal n is
//! ((φ₁ - φ₀) (p₂ - p₀) × n + (φ₂ - φ₀) n × (p₁ - p₀)) / (2 area). On a point cloud: the tangent g that best explains the
//! neighbours, φⱼ - φᵢ = ⟨g, pⱼ - pᵢ⟩, in the sense of least squares.

use crate::{parallel, surface::SurfaceGraph};
use bevy::math::{DMat2, DVec2, DVec3, Vec3};

/// A sum of gradients that cancels to less than this share is rounding noise.
const VANISHING: f64 = 1e-6;

/// The direction in which `scalars` (one per graph vertex, finite) grows fastest; zero where it is constant or where the
/// gradients around a vertex cancel.
pub(super) fn ascent(scalars: &[f32], graph: &SurfaceGraph) -> Vec<Vec3> {
    if graph.is_cloud() {
        return parallel::collect(graph.len(), |i| fitted(scalars, graph, i));
    }
    // Sum of area × gradient, and of its modulus. In f64, so that huge scalars stay in range.
    let mut sums = vec![(DVec3::ZERO, 0.0); graph.len()];
    for triangle in &graph.triangles {
        let corners = triangle.map(|v| v as usize);
        let [p0, p1, p2] = corners.map(|v| graph.positions[v].as_dvec3());
        let [s0, s1, s2] = corners.map(|v| f64::from(scalars[v]));
        let (e1, e2) = (p1 - p0, p2 - p0);
        let Some(n) = e1.cross(e2).try_normalize() else {
            continue;
        };
        let gradient = 0.5 * ((s1 - s0) * e2.cross(n) + (s2 - s0) * n.cross(e1));
        for v in corners {
            sums[v].0 += gradient;
            sums[v].1 += gradient.length();
        }
    }
    let direction = |(sum, modulus): (DVec3, f64)| {
        if sum.length() > VANISHING * modulus {
            sum.normalize_or_zero().as_vec3()
        } else {
            Vec3::ZERO
        }
    };
    sums.into_iter().map(direction).collect()
}

fn fitted(scalars: &[f32], graph: &SurfaceGraph, i: usize) -> Vec3 {
    let level = graph.mesh_level();
    let (x, n) = (graph.normals[i].any_orthonormal_vector(), graph.normals[i]);
    let (x, y) = (x.as_dvec3(), n.cross(x).as_dvec3());
    let (mut matrix, mut right, mut size) = (DMat2::ZERO, DVec2::ZERO, 0.0);
    for k in level.edges(i) {
        let j = level.neighbors[k] as usize;
        let e = graph.positions[j].as_dvec3() - graph.positions[i].as_dvec3();
        let (e, rise) = (
            DVec2::new(e.dot(x), e.dot(y)),
            f64::from(scalars[j]) - f64::from(scalars[i]),
        );
        matrix += DMat2::from_cols(e * e.x, e * e.y);
        right += e * rise;
        size += e.length() * rise.abs();
    }
    // The adjugate: only the direction counts, and it does not divide.
    let g = DVec2::new(
        matrix.y_axis.y * right.x - matrix.y_axis.x * right.y,
        matrix.x_axis.x * right.y - matrix.x_axis.y * right.x,
    );
    let trace = matrix.x_axis.x + matrix.y_axis.y;
    if g.length() > VANISHING * trace * size {
        (g.x * x + g.y * y).normalize_or_zero().as_vec3()
    } else {
        Vec3::ZERO
    }
}
