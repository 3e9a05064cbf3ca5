//! The gradient of a scalar on the surface.
//!
//! In: a scalar φ per graph vertex. Out: the direction of its steepest ascent per vertex, a unit vector or zero: the sum
//! over the triangles of area × gradient, where the gradient of a triangle with corners p₀ p₁ p₂ and unit normal n is
//! ((φ₁ - φ₀) (p₂ - p₀) × n + (φ₂ - φ₀) n × (p₁ - p₀)) / (2 area).

use crate::surface::SurfaceGraph;
use bevy::math::{DVec3, Vec3};

/// A sum of gradients that cancels to less than this share is rounding noise.
const VANISHING: f64 = 1e-6;

/// The direction in which `scalars` (one per graph vertex, finite) grows fastest; zero where it is constant or where the
/// gradients around a vertex cancel.
pub(super) fn ascent(scalars: &[f32], graph: &SurfaceGraph) -> Vec<Vec3> {
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
