//! Points on the surface, and the way back to it.
//!
//! In: a point near the surface and a triangle to begin with. Out: the nearest point of the surface that can be reached by
//! going from triangle to adjacent triangle, ever nearer. It does not jump to another sheet, and needs no search tree.

use super::mesh::{FineMesh, NONE};
use bevy::prelude::*;
use glam_matrix_extras::SymmetricMat3;

/// The most triangles that one walk visits.
const MAX_STEPS: usize = 1000;
/// A triangle must be nearer by this factor to go there, so that rounding cannot lead in circles.
const NEARER: f32 = 1.0 - 1e-6;

/// A sample on a [`FineMesh`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Site {
    pub(super) position: Vec3,
    pub(super) metric: SymmetricMat3,
    /// The triangle that it lies in.
    pub(super) triangle: u32,
    /// Weights of the triangle's corners.
    pub(super) weights: Vec3,
    /// A vertex close to it.
    pub(super) vertex: u32,
}

impl Site {
    /// The site at a point of a triangle.
    #[inline]
    pub(super) fn new(mesh: &FineMesh, triangle: u32, weights: Vec3) -> Self {
        let [a, b, c] = mesh.corners(triangle as usize);
        let corner = (0..3).fold(0, |best, k| if weights[k] > weights[best] { k } else { best });
        Self {
            position: a * weights.x + b * weights.y + c * weights.z,
            metric: mesh.metric_at(triangle as usize, weights),
            triangle,
            weights,
            vertex: mesh.triangles[triangle as usize][corner],
        }
    }

    /// The site at a vertex that has triangles.
    pub(super) fn at_vertex(mesh: &FineMesh, vertex: u32) -> Self {
        let triangle = mesh.faces(vertex as usize)[0];
        let weights = mesh.triangles[triangle as usize].map(|v| f32::from(u8::from(v == vertex)));
        Self::new(mesh, triangle, Vec3::from_array(weights))
    }

    /// Squared distance of a point, in the site's metric.
    #[inline(always)]
    pub(super) fn square(&self, point: Vec3) -> f32 {
        super::form::square(&self.metric, point - self.position)
    }
}

/// The site nearest to a point among those that a walk from a triangle reaches.
pub(super) fn walk(mesh: &FineMesh, start: u32, point: Vec3) -> Site {
    let mut here = Nearest::new(mesh, start, point);
    for _ in 0..MAX_STEPS {
        let mut next = here;
        let corners = mesh.triangles[here.triangle as usize];
        // The nearest point lies on the feature of the corners with a weight: a vertex, an edge, or inside. Triangles with
        // that feature may be nearer.
        let on = |k: usize| here.weights[k] > 0.0;
        if let Some(k) = (0..3).find(|&k| on(k))
            && here.weights.min_element() <= 0.0
        {
            let other = (k + 1..3).find(|&k| on(k)).unwrap_or(k);
            for &t in mesh.faces(corners[k] as usize) {
                if t != here.triangle && mesh.triangles[t as usize].contains(&corners[other]) {
                    next = next.or_in(mesh, t, point);
                }
            }
        }
        if next.triangle == here.triangle {
            break;
        }
        here = next;
    }
    Site::new(mesh, here.triangle, here.weights)
}

/// The triangle of a walk, with the point of it that is nearest.
#[derive(Clone, Copy)]
struct Nearest {
    triangle: u32,
    weights: Vec3,
    square: f32,
}

impl Nearest {
    #[inline]
    fn new(mesh: &FineMesh, triangle: u32, point: Vec3) -> Self {
        let corners = mesh.corners(triangle as usize);
        let weights = closest_weights(point, corners);
        let [a, b, c] = corners;
        let square = (a * weights.x + b * weights.y + c * weights.z).distance_squared(point);
        Self {
            triangle,
            weights,
            square,
        }
    }

    #[inline]
    fn or_in(self, mesh: &FineMesh, triangle: u32, point: Vec3) -> Self {
        let other = Self::new(mesh, triangle, point);
        if other.square < self.square * NEARER {
            other
        } else {
            self
        }
    }
}

/// Weights of the corners at the point of a triangle that is nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
#[inline]
pub(super) fn closest_weights(p: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return Vec3::X;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return Vec3::Y;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return Vec3::new(1.0 - v, v, 0.0);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return Vec3::Z;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return Vec3::new(1.0 - w, 0.0, w);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return Vec3::new(0.0, 1.0 - w, w);
    }
    let sum = va + vb + vc;
    if sum.is_nan() || sum <= 0.0 {
        return Vec3::X;
    }
    let (v, w) = (vb / sum, vc / sum);
    Vec3::new((1.0 - v - w).max(0.0), v, w)
}

/// The connected component of each vertex, and the metric area of each; isolated vertices are in none.
pub(super) fn components(mesh: &FineMesh) -> (Vec<u32>, Vec<f64>) {
    let mut component = vec![NONE; mesh.len()];
    let mut areas = Vec::new();
    let mut stack = Vec::new();
    for seed in 0..mesh.len() {
        if component[seed] != NONE || mesh.faces(seed).is_empty() {
            continue;
        }
        let id = areas.len() as u32;
        let mut area = 0.0;
        component[seed] = id;
        stack.push(seed as u32);
        while let Some(v) = stack.pop() {
            area += f64::from(mesh.weights[v as usize]);
            for &w in mesh.neighbors(v as usize) {
                if component[w as usize] == NONE {
                    component[w as usize] = id;
                    stack.push(w);
                }
            }
        }
        areas.push(area);
    }
    (component, areas)
}
