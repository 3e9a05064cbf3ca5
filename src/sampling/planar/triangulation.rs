//! Triangles that know their neighbours: the ground on which samples are inserted, moved and removed.
//!
//! In: points and counter-clockwise triangles. Out: the same under splits, flips and merges, each O(1).

use super::{
    metric::det,
    order::{argsort, inverse, morton_order},
};
use bevy::math::DVec2;
use glam_matrix_extras::SymmetricDMat2;
use std::collections::HashMap;

/// The corner after `k`.
#[inline]
pub(super) const fn next(k: usize) -> usize {
    [1, 2, 0][k]
}

/// The corner before `k`.
#[inline]
pub(super) const fn previous(k: usize) -> usize {
    [2, 0, 1][k]
}

/// A side of a triangle; side `k` is opposite to corner `k`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Side(u32);

impl Side {
    /// What lies beyond a border.
    pub(super) const NONE: Self = Self(u32::MAX);

    #[inline]
    pub(super) const fn new(triangle: u32, k: usize) -> Self {
        Self(triangle << 2 | k as u32)
    }

    #[inline]
    pub(super) const fn triangle(self) -> usize {
        (self.0 >> 2) as usize
    }

    #[inline]
    pub(super) const fn k(self) -> usize {
        (self.0 & 3) as usize
    }
}

/// Corners counter-clockwise, and for each side the same side seen from the neighbour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) v: [u32; 3],
    pub(super) n: [Side; 3],
}

/// A position with its (scaled) metric.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub(super) p: DVec2,
    pub(super) m: SymmetricDMat2,
}

/// Where a vertex may go.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Place {
    /// Anywhere in the domain.
    Free,
    /// Along a rail, a straight part of the border.
    Rail(u32),
    /// Nowhere.
    Corner,
}

/// The triangulation of the domain by its vertices.
#[derive(Clone, Default)]
pub(super) struct Triangulation {
    pub(super) vertices: Vec<Vertex>,
    pub(super) places: Vec<Place>,
    pub(super) triangles: Vec<Triangle>,
    /// Work list of the flips, kept for its memory.
    pub(super) stack: Vec<Side>,
}

impl Triangulation {
    /// Links counter-clockwise triangles between fixed corners. Every edge has one triangle (a border) or two.
    pub(super) fn new(vertices: Vec<Vertex>, corners: &[[u32; 3]]) -> Self {
        let mut sides = HashMap::with_capacity(3 * corners.len());
        for (v, t) in corners.iter().zip(0..) {
            for k in 0..3 {
                sides.insert((v[next(k)], v[previous(k)]), Side::new(t, k));
            }
        }
        let twin = |a: u32, b: u32| sides.get(&(b, a)).copied().unwrap_or(Side::NONE);
        let triangles = corners
            .iter()
            .map(|&v| Triangle {
                v,
                n: [twin(v[1], v[2]), twin(v[2], v[0]), twin(v[0], v[1])],
            })
            .collect();
        Self {
            places: vec![Place::Corner; vertices.len()],
            vertices,
            triangles,
            stack: Vec::new(),
        }
    }

    /// Makes room for `count` vertices.
    pub(super) fn reserve(&mut self, count: usize) {
        self.vertices.reserve(count);
        self.places.reserve(count);
        self.triangles.reserve(2 * count);
    }

    /// Tells the triangle beyond `side` that it now borders on `other`.
    #[inline]
    pub(super) fn link(&mut self, side: Side, other: Side) {
        if side != Side::NONE {
            self.triangles[side.triangle()].n[side.k()] = other;
        }
    }

    pub(super) fn push(&mut self, vertex: Vertex, place: Place) -> u32 {
        self.vertices.push(vertex);
        self.places.push(place);
        self.vertices.len() as u32 - 1
    }

    /// The three corners of a triangle.
    #[inline(always)]
    pub(super) fn corners(&self, t: usize) -> [&Vertex; 3] {
        let [a, b, c] = self.triangles[t].v;
        [self.vertex(a), self.vertex(b), self.vertex(c)]
    }

    #[inline(always)]
    pub(super) fn vertex(&self, v: u32) -> &Vertex {
        &self.vertices[v as usize]
    }

    /// Inserts a free vertex into triangle `t`; it becomes corner 0 of the three new triangles, which are returned.
    pub(super) fn split(&mut self, t: u32, vertex: Vertex) -> [u32; 3] {
        let x = self.push(vertex, Place::Free);
        let Triangle {
            v: [a, b, c],
            n: [na, nb, nc],
        } = self.triangles[t as usize];
        let (t1, t2) = (self.triangles.len() as u32, self.triangles.len() as u32 + 1);
        self.triangles[t as usize] = Triangle {
            v: [x, b, c],
            n: [na, Side::new(t1, 2), Side::new(t2, 1)],
        };
        self.triangles.push(Triangle {
            v: [x, c, a],
            n: [nb, Side::new(t2, 2), Side::new(t, 1)],
        });
        self.triangles.push(Triangle {
            v: [x, a, b],
            n: [nc, Side::new(t, 2), Side::new(t1, 1)],
        });
        self.link(na, Side::new(t, 0));
        self.link(nb, Side::new(t1, 0));
        self.link(nc, Side::new(t2, 0));
        [t, t1, t2]
    }

    /// Inserts a vertex on the border `side`; it becomes corner 0 of the two new triangles, which are returned. Side 2 of
    /// the second is the part of the border that comes after the vertex, and stays so when sides 0 are flipped.
    pub(super) fn split_border(&mut self, side: Side, vertex: Vertex, place: Place) -> [u32; 2] {
        let x = self.push(vertex, place);
        let (t, k) = (side.triangle() as u32, side.k());
        let Triangle { v, n } = self.triangles[t as usize];
        let (a, b, c) = (v[k], v[next(k)], v[previous(k)]);
        let (nb, nc) = (n[next(k)], n[previous(k)]);
        let t1 = self.triangles.len() as u32;
        self.triangles[t as usize] = Triangle {
            v: [x, a, b],
            n: [nc, Side::NONE, Side::new(t1, 1)],
        };
        self.triangles.push(Triangle {
            v: [x, c, a],
            n: [nb, Side::new(t, 2), Side::NONE],
        });
        self.link(nc, Side::new(t, 0));
        self.link(nb, Side::new(t1, 0));
        [t, t1]
    }

    /// Turns the edge `side` in its quad; corner k of its triangle becomes corner 0 of both. Returns the other triangle.
    #[inline]
    pub(super) fn flip(&mut self, side: Side) -> u32 {
        let (t, k) = (side.triangle() as u32, side.k());
        let Triangle { v, n } = self.triangles[t as usize];
        let (u, j) = (n[k].triangle() as u32, n[k].k());
        let Triangle { v: w, n: o } = self.triangles[u as usize];
        let (a, b, c, d) = (v[k], v[next(k)], v[previous(k)], w[j]);
        let (beyond_ca, beyond_ab) = (n[next(k)], n[previous(k)]);
        let (beyond_bd, beyond_dc) = (o[next(j)], o[previous(j)]);
        self.triangles[t as usize] = Triangle {
            v: [a, b, d],
            n: [beyond_bd, Side::new(u, 2), beyond_ab],
        };
        self.triangles[u as usize] = Triangle {
            v: [a, d, c],
            n: [beyond_dc, beyond_ca, Side::new(t, 1)],
        };
        self.link(beyond_bd, Side::new(t, 0));
        self.link(beyond_ab, Side::new(t, 2));
        self.link(beyond_dc, Side::new(u, 0));
        self.link(beyond_ca, Side::new(u, 1));
        u
    }

    /// The border that follows the border `side` around its end; the triangles lie to the left.
    pub(super) fn next_border(&self, side: Side) -> Side {
        let mut side = Side::new(side.triangle() as u32, next(side.k()));
        loop {
            let beyond = self.triangles[side.triangle()].n[side.k()];
            if beyond == Side::NONE {
                return side;
            }
            side = Side::new(beyond.triangle() as u32, next(beyond.k()));
        }
    }

    /// The border side from vertex `a` to vertex `b`.
    pub(super) fn border(&self, a: u32, b: u32) -> Option<Side> {
        self.borders().find(|&side| self.ends(side) == [a, b])
    }

    /// All border sides.
    pub(super) fn borders(&self) -> impl Iterator<Item = Side> + '_ {
        self.triangles.iter().zip(0..).flat_map(|(triangle, t)| {
            (0..3)
                .filter(|&k| triangle.n[k] == Side::NONE)
                .map(move |k| Side::new(t, k))
        })
    }

    /// First and last vertex of a side, counter-clockwise.
    pub(super) fn ends(&self, side: Side) -> [u32; 2] {
        let v = self.triangles[side.triangle()].v;
        [v[next(side.k())], v[previous(side.k())]]
    }

    /// Twice the signed area of a triangle.
    #[inline]
    pub(super) fn double_area(&self, t: usize) -> f64 {
        let [a, b, c] = self.corners(t);
        (b.p - a.p).perp_dot(c.p - a.p)
    }

    /// Metric area of a triangle, with the mean of its corners' metrics.
    #[inline]
    pub(super) fn metric_area(&self, t: usize) -> f64 {
        let [a, b, c] = self.corners(t);
        (b.p - a.p).perp_dot(c.p - a.p) * det(&(a.m + b.m + c.m)).sqrt() / 6.0
    }

    /// The square of the metric area.
    #[inline]
    pub(super) fn metric_area_squared(&self, t: usize) -> f64 {
        let [a, b, c] = self.corners(t);
        let double_area = (b.p - a.p).perp_dot(c.p - a.p);
        double_area * double_area * det(&(a.m + b.m + c.m)) / 36.0
    }

    /// The metric area of all triangles.
    pub(super) fn total_area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| self.metric_area(t)).sum()
    }

    /// Multiplies all metrics by a factor.
    pub(super) fn scale(&mut self, factor: f64) {
        for vertex in &mut self.vertices {
            vertex.m *= factor;
        }
    }

    /// All edges, each once, as (smaller, larger) vertex.
    pub(super) fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(self.vertices.len() + self.triangles.len());
        for (triangle, t) in self.triangles.iter().zip(0..) {
            for k in 0..3 {
                let beyond = triangle.n[k];
                if beyond == Side::NONE || beyond.triangle() > t {
                    let (a, b) = (triangle.v[next(k)], triangle.v[previous(k)]);
                    edges.push([a.min(b), a.max(b)]);
                }
            }
        }
        edges
    }

    /// Stores vertices and triangles along a Morton curve, so that neighbours in space are neighbours in memory. Returns
    /// the former index of each vertex.
    pub(super) fn reorder(&mut self) -> Vec<u32> {
        let order = morton_order(&self.vertices);
        let rank = inverse(&order);
        self.vertices = order.iter().map(|&i| self.vertices[i as usize]).collect();
        self.places = order.iter().map(|&i| self.places[i as usize]).collect();
        for triangle in &mut self.triangles {
            triangle.v = triangle.v.map(|v| rank[v as usize]);
        }
        let least: Vec<u32> = self
            .triangles
            .iter()
            .map(|triangle| triangle.v[0].min(triangle.v[1]).min(triangle.v[2]))
            .collect();
        let triangle_order = argsort(&least);
        let triangle_rank = inverse(&triangle_order);
        self.triangles = triangle_order.iter().map(|&t| self.triangles[t as usize]).collect();
        for side in self.triangles.iter_mut().flat_map(|triangle| &mut triangle.n) {
            if *side != Side::NONE {
                *side = Side::new(triangle_rank[side.triangle()], side.k());
            }
        }
        order
    }
}
