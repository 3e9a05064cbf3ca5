//! Edge flips towards the triangulation that is Delaunay in the metric.
//!
//! In: a [`Triangulation`]. Out: the same samples with better edges. With M the sum of the four metrics, the same from both
//! sides, an edge (b, c) with the opposite corners a and d is flipped where the angles at a and d, measured in M, are more
//! than π together (Eq. 2 and 3 of the paper, M instead of its inverse). Without trigonometry, for v = b - a, w = c - a,
//! v' = c - d, w' = b - d and areas G, G': `<v,w> G' + <v',w'> G < 0`.

use super::{form, mesh::NONE, triangulation::Triangulation};
use bevy::prelude::*;

/// Relative slack of the test, so that rounding cannot flip an edge to and fro.
const SLACK: f32 = 1e-3;
/// The least cosine between a new triangle and the mean normal of its corners: 78 degrees.
const UPRIGHT: f32 = 0.2;
/// The most flips of one call, per triangle.
const MAX_FLIPS: usize = 10;
/// The most triangles around a sample that are looked at.
const MAX_RING: usize = 64;

impl Triangulation {
    /// Flips edges until none should be.
    pub(super) fn flip_all(&mut self) {
        let mut left = MAX_FLIPS * self.triangles.len();
        let mut stack = Vec::new();
        for t in 0..self.triangles.len() as u32 {
            stack.extend([(t, 0), (t, 1), (t, 2)]);
            self.flip_stacked(&mut stack, &mut left, |_| ());
        }
    }

    /// Flips the edges on a stack, and edges around those that were flipped, which are told to `touched`.
    pub(super) fn flip_stacked(
        &mut self,
        stack: &mut Vec<(u32, usize)>,
        left: &mut usize,
        mut touched: impl FnMut([u32; 2]),
    ) {
        while let Some((t, k)) = stack.pop() {
            if *left > 0 && self.should_flip(t, k) {
                *left -= 1;
                let u = self.flip(t, k);
                touched([t, u]);
                stack.extend([(t, 0), (t, 2), (u, 0), (u, 1)]);
            }
        }
    }

    fn should_flip(&self, t: u32, k: usize) -> bool {
        let triangle = &self.triangles[t as usize];
        let u = triangle.neighbors[k];
        if u == NONE {
            return false;
        }
        let names = [
            triangle.corners[k],
            triangle.corners[(k + 1) % 3],
            triangle.corners[(k + 2) % 3],
            self.triangles[u as usize].corners[self.side_of(u, t)],
        ];
        let [a, b, c, d] = names.map(|v| &self.sites[v as usize]);
        let metric = form::blend([&a.metric, &b.metric, &c.metric], Vec3::ONE);
        let metric = form::blend([&metric, &d.metric, &d.metric], Vec3::X + Vec3::Y);
        let [a, b, c, d] = [a, b, c, d].map(|site| site.position);
        let angle = |v: Vec3, w: Vec3| {
            let (vv, vw, ww) = form::gram(&metric, v, w);
            (vw, (vv * ww - vw * vw).max(0.0).sqrt())
        };
        let ((cos_a, area_a), (cos_d, area_d)) = (angle(b - a, c - a), angle(c - d, b - d));
        if cos_a * area_d + cos_d * area_a >= -SLACK * area_a * area_d || names[0] == names[3] {
            return false;
        }
        let normal: Vec3 = names.iter().map(|&v| self.normals[v as usize]).sum();
        let upright = |n: Vec3| n.dot(normal) > UPRIGHT * (n.length_squared() * normal.length_squared()).sqrt();
        upright((b - a).cross(d - a)) && upright((d - a).cross(c - a)) && !self.has_edge(t, names[0], names[3])
    }

    /// The side of triangle `u` that triangle `t` is at.
    #[inline(always)]
    fn side_of(&self, u: u32, t: u32) -> usize {
        let [first, second, _] = self.triangles[u as usize].neighbors;
        if first == t { 0 } else { 2 - usize::from(second == t) }
    }

    /// Replaces the edge opposite to corner k of t = (a, b, c) by that to the far corner d of the neighbour u: t becomes
    /// (a, b, d) and u becomes (a, d, c). Returns u.
    fn flip(&mut self, t: u32, k: usize) -> u32 {
        let one = self.triangles[t as usize];
        let u = one.neighbors[k];
        let two = self.triangles[u as usize];
        let j = self.side_of(u, t);
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        let (a, b, c, d) = (one.corners[k], one.corners[next], one.corners[last], two.corners[j]);
        let (across_b, across_c) = (one.neighbors[next], one.neighbors[last]);
        // Beside d, the neighbour across (b, d) is opposite to c, and that across (d, c) is opposite to b.
        let (beside_b, beside_c) = (two.neighbors[(j + 1) % 3], two.neighbors[(j + 2) % 3]);
        self.triangles[t as usize].corners = [a, b, d];
        self.triangles[t as usize].neighbors = [beside_b, u, across_c];
        self.triangles[u as usize].corners = [a, d, c];
        self.triangles[u as usize].neighbors = [beside_c, across_b, t];
        self.relink(beside_b, u, t);
        self.relink(across_b, t, u);
        u
    }

    /// Whether samples a and d are joined already: d is looked for around a, beginning in triangle t, both ways.
    fn has_edge(&self, t: u32, a: u32, d: u32) -> bool {
        for turn in [1, 2] {
            let mut here = t;
            for _ in 0..MAX_RING {
                let triangle = &self.triangles[here as usize];
                if triangle.corners.contains(&d) {
                    return true;
                }
                let Some(k) = triangle.corners.iter().position(|&v| v == a) else {
                    break;
                };
                here = triangle.neighbors[(k + turn) % 3];
                if here == t {
                    return false;
                }
                if here == NONE {
                    break;
                }
            }
        }
        false
    }
}
