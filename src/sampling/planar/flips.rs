//! Edge flips by the summed metric: what makes a triangulation the dual of the anisotropic cells.
//!
//! In: a triangulation whose vertices have metrics. Out: one without violated edges. An edge between b and c with the
//! opposite corners a and d is violated where the angles at a and d sum to more than π, both measured in
//! `M = M_a + M_b + M_c + M_d`. One metric for both diagonals: so an edge cannot flip to and fro. (Eq. 2, with M for its
//! inverse.)
//!
//! That flips end is a theorem for one metric. Where M changes much from sample to sample they can go in a circle: of the
//! five triangulations of a pentagon each may have a violated edge. Such a *knot* is left with the edge that is violated
//! least, and its samples are told to the caller, who can put them elsewhere.

use super::{
    metric::{det, dot},
    triangulation::{Place, Side, Triangulation, Vertex, next, previous},
};
use glam_matrix_extras::SymmetricDMat2;

/// Flips after which the star of an inserted vertex is left as it is.
const STAR_CAP: usize = 256;
/// Flips of a triangle that any violation is worth. From then on it must be larger, by the sum of the cotangents of the two
/// angles: at first by [`SLACK`], then [`GROWTH`] times as much with every flip.
const FREE_FLIPS: u8 = 20;
const SLACK: f64 = 1e-3;
const GROWTH: f64 = 2.0;
/// By how much the angles must be violated, relative to the trace of the metric.
const EPSILON: f64 = 1e-9;

/// α + β > π without trigonometry: ⟨v,w⟩ G' + ⟨v',w'⟩ G < 0 with G = |v × w|; and the flip leaves no triangle turned over.
#[inline]
fn violated(quad: [&Vertex; 4]) -> bool {
    exceeds(quad, |m| EPSILON * (m.m00 + m.m11))
}

/// Whether cot α + cot β < -slack.
fn violated_by(quad: [&Vertex; 4], slack: f64) -> bool {
    exceeds(quad, |m| slack * det(m).sqrt())
}

#[inline(always)]
fn exceeds([a, b, c, d]: [&Vertex; 4], least: impl Fn(&SymmetricDMat2) -> f64) -> bool {
    let m = (a.m + b.m) + (c.m + d.m);
    let (v, w) = (b.p - a.p, c.p - a.p);
    let (v1, w1) = (c.p - d.p, b.p - d.p);
    let (g, g1) = (v.perp_dot(w), v1.perp_dot(w1));
    dot(&m, v, w) * g1 + dot(&m, v1, w1) * g < -least(&m) * g * g1 && convex(a, b, c, d)
}

/// Whether both triangles have an area after the flip of b-c to a-d.
#[inline]
pub(super) fn convex(a: &Vertex, b: &Vertex, c: &Vertex, d: &Vertex) -> bool {
    let diagonal = d.p - a.p;
    (b.p - a.p).perp_dot(diagonal) > 0.0 && diagonal.perp_dot(c.p - a.p) > 0.0
}

impl Triangulation {
    /// The corners a, b, c of a triangle from that opposite to `side`, and d beyond it.
    #[inline(always)]
    pub(super) fn quad(&self, side: Side, beyond: Side) -> [&Vertex; 4] {
        let v = &self.triangles[side.triangle()].v;
        let d = self.triangles[beyond.triangle()].v[beyond.k()];
        let (a, b, c) = (v[side.k()], v[next(side.k())], v[previous(side.k())]);
        [self.vertex(a), self.vertex(b), self.vertex(c), self.vertex(d)]
    }

    /// Flips the sides opposite to a new vertex (corner 0 of all triangles of its star) until none is violated. Calls
    /// `done` with each triangle of the final star and the square of its metric area.
    #[inline]
    pub(super) fn settle_star(&mut self, star: &[u32], mut done: impl FnMut(u32, f64)) {
        let mut stack = std::mem::take(&mut self.stack);
        stack.extend(star.iter().map(|&t| Side::new(t, 0)));
        let mut flips = 0;
        while let Some(side) = stack.pop() {
            let [&a, &b, &c] = self.corners(side.triangle());
            let beyond = self.triangles[side.triangle()].n[0];
            if beyond != Side::NONE && flips < STAR_CAP {
                let d = self.vertices[self.triangles[beyond.triangle()].v[beyond.k()] as usize];
                if violated([&a, &b, &c, &d]) {
                    let other = self.flip(side);
                    flips += 1;
                    stack.push(side);
                    stack.push(Side::new(other, 0));
                    continue;
                }
            }
            let double_area = (b.p - a.p).perp_dot(c.p - a.p);
            let area_squared = double_area * double_area * det(&(a.m + b.m + c.m)) / 36.0;
            done(side.triangle() as u32, area_squared);
        }
        self.stack = stack;
    }

    /// Flips violated edges until there are none but knots. Returns the free vertices of those.
    pub(super) fn flip_violated(&mut self) -> Vec<u32> {
        let mut flips = vec![0_u8; self.triangles.len()];
        let mut knots = Vec::new();
        let mut stack = std::mem::take(&mut self.stack);
        for t in 0..self.triangles.len() {
            for k in 0..3 {
                let beyond = self.triangles[t].n[k];
                // Each edge once.
                if beyond == Side::NONE || beyond.triangle() < t {
                    continue;
                }
                stack.push(Side::new(t as u32, k));
                while let Some(side) = stack.pop() {
                    let beyond = self.triangles[side.triangle()].n[side.k()];
                    if beyond == Side::NONE || !violated(self.quad(side, beyond)) {
                        continue;
                    }
                    let more = flips[side.triangle()]
                        .max(flips[beyond.triangle()])
                        .checked_sub(FREE_FLIPS);
                    if more.is_some_and(|more| !violated_by(self.quad(side, beyond), SLACK * GROWTH.powi(more.into())))
                    {
                        knots.push(side);
                        continue;
                    }
                    let (t, u) = (side.triangle() as u32, self.flip(side));
                    flips[t as usize] = flips[t as usize].saturating_add(1);
                    flips[u as usize] = flips[u as usize].saturating_add(1);
                    stack.extend([Side::new(t, 0), Side::new(t, 2), Side::new(u, 0), Side::new(u, 1)]);
                }
            }
        }
        self.stack = stack;
        self.free_corners(&knots)
    }

    /// The free corners of the triangles at those sides that are still violated.
    fn free_corners(&self, sides: &[Side]) -> Vec<u32> {
        let mut free = Vec::new();
        for &side in sides {
            let beyond = self.triangles[side.triangle()].n[side.k()];
            if beyond != Side::NONE && violated(self.quad(side, beyond)) {
                let corners = [side, beyond].map(|side| self.triangles[side.triangle()].v);
                free.extend(corners.as_flattened());
            }
        }
        free.retain(|&v| self.places[v as usize] == Place::Free);
        free.sort_unstable();
        free.dedup();
        free
    }
}
