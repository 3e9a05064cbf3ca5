//! The middle of a period cell: the CPU twin of `material/texture_patch.wgsl`.
//!
//! In: a point of a surface with two waves, and the phases (u, v) wanted. Out: the point of the same cell that has them, by
//! steps of Newton's method, each walked along the surface from triangle to triangle.

use super::{
    layout::PatternRecord,
    shade::{Corners, PatternMemory, TINY, barycentric_gradients},
    shade_pair::{WavePair, sample_pair},
};
use crate::surface::NO_TRIANGLE;
use bevy::math::{Vec2, Vec3};

/// Places looked at, one step of Newton's method after the other.
const PLACES: usize = 7;
/// Triangles that one step may cross.
const MAX_CROSSED: usize = 64;
/// Near enough to the middle, in periods.
const CLOSE: f32 = 0.005;

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Index of the triangle in the drawn mesh.
    pub triangle: u32,
    /// Weights of its corners, of sum 1; below 0 where the point lies beyond the surface's border.
    pub barycentrics: Vec3,
}

/// The pattern that a point lies on.
#[derive(Clone, Copy)]
struct Surface<'a> {
    memory: &'a PatternMemory<'a>,
    tag: u32,
    record: PatternRecord,
}

/// The point of the period cell around `point` at which the texture coordinates are those of `goal`, in periods; (0.5, 0.5)
/// is the cell's middle. Where a cell has no middle (at a branch), or none within a cell's diagonal is found, `point` itself.
/// `None` where there is no pattern with two waves.
pub fn cell_middle(memory: &PatternMemory, tag: u32, point: SurfacePoint, goal: Vec2) -> Option<SurfacePoint> {
    let record = memory.record(tag);
    let surface = Surface { memory, tag, record };
    let mut at = point;
    let mut begin = None;
    for _ in 0..PLACES {
        let pair = surface.main_pair(at)?;
        let position = pair.waves[0].position;
        if position.distance(*begin.get_or_insert(position)) > cell_diagonal(&pair) {
            break;
        }
        let missing = goal - pair.uv();
        let near = missing - missing.round();
        if near.abs().max_element() < CLOSE {
            return Some(at);
        }
        at = surface.walked(at, step_by(&pair, near))?;
    }
    Some(point)
}

/// In units of length.
fn cell_diagonal(pair: &WavePair) -> f32 {
    let [f, g] = pair.waves.map(|wave| wave.frequency.max(TINY));
    Vec2::new(1.0 / f, 1.0 / g).length()
}

/// The step in the triangle's plane by which the phases grow by `turns`; no longer than half a cell's diagonal.
fn step_by(pair: &WavePair, turns: Vec2) -> Vec3 {
    let n = pair.waves[0].normal;
    let [u, v] = pair.waves.map(|wave| wave.gradient);
    let (along, across) = (v.cross(n), n.cross(u));
    let area = u.dot(along);
    let area = if area.abs() < TINY { TINY } else { area };
    let wanted = (turns.x * along + turns.y * across) / area;
    wanted * (0.5 * cell_diagonal(pair) / wanted.length().max(TINY)).min(1.0)
}

impl Surface<'_> {
    /// Both waves as the piece with the largest share sees them.
    fn main_pair(&self, point: SurfacePoint) -> Option<WavePair> {
        let pieces = sample_pair(self.memory, self.tag, point.triangle, point.barycentrics);
        let larger = |best: WavePair, piece: WavePair| if piece.weight > best.weight { piece } else { best };
        pieces.into_iter().reduce(larger)
    }

    fn corners(&self, triangle: u32) -> Option<Corners> {
        self.memory.corners(&self.record, triangle, 0)
    }

    /// The point a step further along the surface; across an edge the step goes on at the angle at which it came. At the
    /// border it goes on in the plane of the last triangle.
    fn walked(&self, point: SurfacePoint, step: Vec3) -> Option<SurfacePoint> {
        let mut at = point;
        let mut rest = step;
        for _ in 0..MAX_CROSSED {
            let corners = self.corners(at.triangle)?;
            let gradients = barycentric_gradients(&corners);
            let move_by = gradients.transpose() * rest;
            let end = at.barycentrics + move_by;
            // The edge that is reached first lies opposite a corner whose weight falls to 0.
            let mut reached: Option<(usize, f32)> = None;
            for m in (0..3).filter(|&m| end[m] < 0.0 && move_by[m] < 0.0) {
                let t = (at.barycentrics[m] / -move_by[m]).clamp(0.0, 1.0);
                if reached.is_none_or(|(_, share)| t < share) {
                    reached = Some((m, t));
                }
            }
            let crossing = reached.map(|(left, share)| ((left + 1) % 3, share));
            let crossing = crossing.map(|(edge, share)| (edge, share, self.across_edge(at.triangle, edge)));
            let Some((edge, share, Some(next))) = crossing else {
                at.barycentrics = end;
                return Some(at);
            };
            let on_edge = at.barycentrics + share * move_by;
            rest *= 1.0 - share;
            (at, rest) = self.entered(at.triangle, next, edge, on_edge, rest)?;
        }
        Some(at)
    }

    /// The triangle behind the edge from corner `edge` to the next.
    fn across_edge(&self, triangle: u32, edge: usize) -> Option<u32> {
        let behind_triangles = self.record.triangle_base + 3 * self.record.triangles;
        let next = self
            .memory
            .surface
            .get((behind_triangles + 3 * triangle) as usize + edge)?;
        (*next != NO_TRIANGLE).then_some(*next)
    }

    fn vertices(&self, triangle: u32) -> Option<[u32; 3]> {
        let first = (self.record.triangle_base + 3 * triangle) as usize;
        self.memory.surface.get(first..first + 3)?.try_into().ok()
    }

    /// The same place `b` on the edge in the next triangle, and the step bent into its plane.
    fn entered(&self, from: u32, next: u32, edge: usize, b: Vec3, step: Vec3) -> Option<(SurfacePoint, Vec3)> {
        let other_end = (edge + 1) % 3;
        let here = self.vertices(from)?;
        let mut barycentrics = Vec3::ZERO;
        let mut third = 0;
        for (m, vertex) in self.vertices(next)?.into_iter().enumerate() {
            if vertex == here[edge] {
                barycentrics[m] = b[edge];
            } else if vertex == here[other_end] {
                barycentrics[m] = b[other_end];
            } else {
                third = m;
            }
        }
        barycentrics /= barycentrics.element_sum().max(TINY);
        let v = self.corners(from)?.position;
        let line = v[other_end] - v[edge];
        let unit = line / line.length().max(TINY);
        let backwards = rejected(v[3 - edge - other_end] - v[edge], unit);
        let forwards = rejected(self.corners(next)?.position[third] - v[edge], unit);
        let step = step.dot(unit) * unit - step.dot(backwards) * forwards;
        let point = SurfacePoint {
            triangle: next,
            barycentrics,
        };
        Some((point, step))
    }
}

/// The unit direction of a vector's part that is perpendicular to `unit`.
fn rejected(vector: Vec3, unit: Vec3) -> Vec3 {
    let part = vector - vector.dot(unit) * unit;
    part / part.length().max(TINY)
}
