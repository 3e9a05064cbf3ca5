//! Samples are taken out of a triangulation.
//!
//! In: a triangulation and the vertices that shall go. Out: the same without them, their stars closed by flips. A free
//! vertex is flipped down to three triangles, which become one; a border sample to two.

use super::{
    flips::convex,
    metric::dot,
    triangulation::{Place, Side, Triangulation, next, previous},
};

/// Triangles of a star, above which a vertex stays.
const LARGEST_STAR: usize = 64;

/// What goes: vertices and triangles that are out of use until they are cleared away.
struct Dead {
    vertices: Vec<bool>,
    triangles: Vec<bool>,
    /// A living triangle of each vertex.
    triangle_of: Vec<u32>,
}

impl Triangulation {
    /// Takes vertices out; fixed ones, and those whose star cannot be closed, stay. Returns the former indices of those
    /// that are left, ascending, or nothing where all are left.
    pub(super) fn remove(&mut self, vertices: &[u32]) -> Option<Vec<u32>> {
        if vertices.is_empty() {
            return None;
        }
        let mut dead = Dead {
            vertices: vec![false; self.vertices.len()],
            triangles: vec![false; self.triangles.len()],
            triangle_of: vec![0; self.vertices.len()],
        };
        for (triangle, t) in self.triangles.iter().zip(0..) {
            for v in triangle.v {
                dead.triangle_of[v as usize] = t;
            }
        }
        for &v in vertices {
            if self.places[v as usize] != Place::Corner {
                self.remove_one(v, &mut dead);
            }
        }
        Some(self.clear(&dead))
    }

    /// The triangles around a vertex, counter-clockwise, as the sides opposite to it; and whether they are all around.
    fn star(&self, v: u32, t: u32) -> (Vec<Side>, bool) {
        let corner = |t: usize| self.triangles[t].v.iter().position(|&w| w == v).unwrap_or(0);
        let first = Side::new(t, corner(t as usize));
        let mut star = vec![first];
        let mut side = first;
        while star.len() <= LARGEST_STAR {
            let beyond = self.triangles[side.triangle()].n[next(side.k())];
            if beyond == Side::NONE {
                break;
            }
            side = Side::new(beyond.triangle() as u32, next(beyond.k()));
            if side == first {
                return (star, true);
            }
            star.push(side);
        }
        // Clockwise from the first up to the border.
        let mut side = first;
        while star.len() <= LARGEST_STAR {
            let beyond = self.triangles[side.triangle()].n[previous(side.k())];
            if beyond == Side::NONE {
                break;
            }
            side = Side::new(beyond.triangle() as u32, previous(beyond.k()));
            star.insert(0, side);
        }
        (star, false)
    }

    fn remove_one(&mut self, v: u32, dead: &mut Dead) {
        for _ in 0..LARGEST_STAR {
            let (star, closed) = self.star(v, dead.triangle_of[v as usize]);
            if star.len() > LARGEST_STAR || closed != (self.places[v as usize] == Place::Free) {
                return;
            }
            if star.len() == if closed { 3 } else { 2 } {
                self.merge(v, &star, closed, dead);
                return;
            }
            let spoke = star
                .iter()
                .map(|side| Side::new(side.triangle() as u32, next(side.k())));
            let Some(spoke) = spoke.into_iter().find(|&spoke| self.is_convex(spoke)) else {
                return;
            };
            let other = self.flip(spoke);
            for t in [spoke.triangle() as u32, other] {
                for w in self.triangles[t as usize].v {
                    dead.triangle_of[w as usize] = t;
                }
            }
        }
    }

    /// Whether an edge can be flipped.
    fn is_convex(&self, side: Side) -> bool {
        let beyond = self.triangles[side.triangle()].n[side.k()];
        if beyond == Side::NONE {
            return false;
        }
        let [a, b, c, d] = self.quad(side, beyond);
        convex(a, b, c, d)
    }

    /// Makes one triangle of a star of three, or of two at the border.
    fn merge(&mut self, v: u32, star: &[Side], closed: bool, dead: &mut Dead) {
        let outer = |side: Side| self.triangles[side.triangle()].n[side.k()];
        let after = |side: Side| self.triangles[side.triangle()].v[next(side.k())];
        let before = |side: Side| self.triangles[side.triangle()].v[previous(side.k())];
        let last = if closed { outer(star[2]) } else { Side::NONE };
        let corners = [after(star[0]), before(star[0]), before(star[1])];
        let sides = [outer(star[1]), last, outer(star[0])];
        let t = star[0].triangle() as u32;
        self.triangles[t as usize].v = corners;
        self.triangles[t as usize].n = sides;
        for (k, side) in sides.into_iter().enumerate() {
            self.link(side, Side::new(t, k));
        }
        for side in &star[1..] {
            dead.triangles[side.triangle()] = true;
        }
        dead.vertices[v as usize] = true;
        for w in corners {
            dead.triangle_of[w as usize] = t;
        }
    }

    /// Closes the gaps that the dead leave in the lists. Returns the former indices of the living vertices.
    fn clear(&mut self, dead: &Dead) -> Vec<u32> {
        let (vertices, vertex_rank) = living(&dead.vertices);
        let (triangles, triangle_rank) = living(&dead.triangles);
        self.vertices = vertices.iter().map(|&v| self.vertices[v as usize]).collect();
        self.places = vertices.iter().map(|&v| self.places[v as usize]).collect();
        self.triangles = triangles.iter().map(|&t| self.triangles[t as usize]).collect();
        for triangle in &mut self.triangles {
            triangle.v = triangle.v.map(|v| vertex_rank[v as usize]);
            for side in triangle.n.iter_mut().filter(|side| **side != Side::NONE) {
                *side = Side::new(triangle_rank[side.triangle()], side.k());
            }
        }
        vertices
    }

    /// Free vertices that are nearer than `distance` to a neighbour (in the mean of the two metrics), so that no two of
    /// those left are; the nearest pairs first.
    pub(super) fn crowded(&self, distance: f64) -> Vec<u32> {
        let mut pairs = Vec::new();
        for triangle in &self.triangles {
            for k in 0..3 {
                let (i, j) = (triangle.v[k], triangle.v[next(k)]);
                let (a, b) = (&self.vertices[i as usize], &self.vertices[j as usize]);
                let squared = 0.5 * dot(&(a.m + b.m), b.p - a.p, b.p - a.p);
                if squared < distance * distance {
                    pairs.push((squared, i.min(j), i.max(j)));
                }
            }
        }
        pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut gone = vec![false; self.vertices.len()];
        let mut crowded = Vec::new();
        for (_, i, j) in pairs {
            if gone[i as usize] || gone[j as usize] {
                continue;
            }
            if let Some(v) = [j, i].into_iter().find(|&v| self.places[v as usize] == Place::Free) {
                gone[v as usize] = true;
                crowded.push(v);
            }
        }
        crowded
    }
}

/// The indices of those not dead, and the new index of each.
fn living(dead: &[bool]) -> (Vec<u32>, Vec<u32>) {
    let mut list = Vec::with_capacity(dead.len());
    let mut rank = vec![0; dead.len()];
    for (i, _) in dead.iter().enumerate().filter(|(_, dead)| !**dead) {
        rank[i] = list.len() as u32;
        list.push(i as u32);
    }
    (list, rank)
}
