//! Relaxation: every sample moves towards the centroid of its cell.
//!
//! In: a triangulation with metrics. Out: the same with vertices moved, no triangle turned over, and no violated edge.
//! All samples move at once from the same state, so that their order does not matter.

use super::{
    boundary::Rail,
    metric::{ScaledMetric, det, dot},
    sampler::HEX_DISTANCE,
    triangulation::{Place, Triangulation, next, previous},
};
use crate::error::PatternError;
use bevy::math::DVec2;
use glam_matrix_extras::SymmetricDMat2;

/// How a sample's cell is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Relaxation {
    /// The dual cell of the triangles' metric circumcentres, put together from kites. After some steps crowded samples are
    /// put where holes are, and at last the largest holes are closed.
    #[default]
    Kite,
    /// The star of triangles around the sample, as in the paper (Eq. 7, with `M(q_j) q_j` for `M(q_j) p_i`). It comes to a
    /// halt after some five steps.
    Star,
}

/// Longest move of one step, in metric units; neighbours are about 2 apart.
const STEP: f64 = 1.0;
/// Halvings of a move that turns a triangle over, before it is undone.
const HALVINGS: usize = 6;

/// Σ w M and Σ w M (q - p): what the pieces of one cell add up to.
#[derive(Clone, Copy)]
struct Moments {
    mass: SymmetricDMat2,
    moment: DVec2,
}

impl Moments {
    /// Not the default, since that of a matrix is the identity.
    const ZERO: Self = Self {
        mass: SymmetricDMat2::ZERO,
        moment: DVec2::ZERO,
    };

    #[inline]
    fn add(&mut self, weight: f64, m: &SymmetricDMat2, offset: DVec2) {
        self.mass += *m * weight;
        self.moment += *m * offset;
    }

    /// (Σ w M)⁻¹ Σ w M (q - p), or nothing where a cell's signed pieces do not add up to one.
    #[inline]
    fn shift(&self) -> DVec2 {
        let (m, b) = (&self.mass, self.moment);
        let determinant = det(m);
        if !(m.m00 > 0.0 && determinant > 0.0) {
            return DVec2::ZERO;
        }
        DVec2::new(m.m11 * b.x - m.m01 * b.y, m.m00 * b.y - m.m01 * b.x) / determinant
    }
}

/// Relaxes a triangulation; keeps its memory between steps.
#[derive(Default, Clone)]
pub(super) struct Relaxer {
    moments: Vec<Moments>,
    before: Vec<DVec2>,
}

impl Relaxer {
    /// One step. Returns the root mean square of the moves, in metric units.
    pub(super) fn step(
        &mut self,
        mesh: &mut Triangulation,
        rails: &[Rail],
        metric: &ScaledMetric,
        relaxation: Relaxation,
    ) -> Result<f64, PatternError> {
        self.moments.clear();
        self.moments.resize(mesh.vertices.len(), Moments::ZERO);
        match relaxation {
            Relaxation::Kite => self.add_kites(mesh),
            Relaxation::Star => self.add_stars(mesh),
        }
        self.add_border(mesh, rails);
        self.remember(mesh);
        let rms = self.apply(mesh, rails);
        self.settle(mesh, metric)?;
        Ok(rms)
    }

    /// Keeps the positions before a move.
    pub(super) fn remember(&mut self, mesh: &Triangulation) {
        self.before.clear();
        self.before.extend(mesh.vertices.iter().map(|vertex| vertex.p));
    }

    /// After a move: no triangle is turned over, metrics are up to date, and no edge is violated.
    pub(super) fn settle(&self, mesh: &mut Triangulation, metric: &ScaledMetric) -> Result<(), PatternError> {
        self.undo_inversions(mesh);
        for (index, vertex) in mesh.vertices.iter_mut().enumerate() {
            if vertex.p != self.before[index] {
                vertex.m = metric.at(vertex.p, index)?;
            }
        }
        mesh.flip_violated();
        Ok(())
    }

    /// The cells of the circumcentre dual. Corner k of a triangle owns the kite between its half edges and the
    /// circumcentre, as two triangles with signs.
    fn add_kites(&mut self, mesh: &Triangulation) {
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let corners = mesh.corners(t);
            let m = (corners[0].m + corners[1].m + corners[2].m) * (1.0 / 3.0);
            let p = [corners[0].p, corners[1].p, corners[2].p];
            let Some((weights, double_area)) = circumcentre(p, &m) else {
                continue;
            };
            let centre = weights[0] * p[0] + weights[1] * p[1] + weights[2] * p[2];
            for k in 0..3 {
                let (after, before) = (next(k), previous(k));
                let (a1, a2) = (
                    0.25 * weights[before] * double_area,
                    0.25 * weights[after] * double_area,
                );
                let to_centre = centre - p[k];
                let (half1, half2) = (0.5 * (p[after] - p[k]), 0.5 * (p[before] - p[k]));
                // The metric at the centroid of the kite; that of the triangle alone makes samples drift.
                let kite = corners[k].m * 0.417 + m * 0.583;
                let offset = (a1 * (half1 + to_centre) + a2 * (half2 + to_centre)) / 3.0;
                self.moments[triangle.v[k] as usize].add(a1 + a2, &kite, offset);
            }
        }
    }

    /// The stars of triangles, weighted by their areas (Eq. 7).
    fn add_stars(&mut self, mesh: &Triangulation) {
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(t);
            let area = 0.5 * (b.p - a.p).perp_dot(c.p - a.p);
            let m = (a.m + b.m + c.m) * (1.0 / 3.0);
            let centre = (a.p + b.p + c.p) / 3.0;
            for (v, corner) in triangle.v.into_iter().zip([a, b, c]) {
                self.moments[v as usize].add(area, &m, area * (centre - corner.p));
            }
        }
    }

    /// The cells of border samples: their two halves of border edges. In one dimension M is μ², and the length of an
    /// edge weighs by μ³.
    fn add_border(&mut self, mesh: &Triangulation, rails: &[Rail]) {
        for (place, moments) in mesh.places.iter().zip(&mut self.moments) {
            if *place != Place::Free {
                *moments = Moments::ZERO;
            }
        }
        for side in mesh.borders() {
            let ends = mesh.ends(side);
            let [a, b] = ends.map(|v| mesh.vertices[v as usize]);
            let edge = b.p - a.p;
            let length = edge.length();
            if length == 0.0 {
                continue;
            }
            let m = (a.m + b.m) * 0.5;
            let mu = dot(&m, edge, edge).sqrt() / length;
            for (v, offset) in ends.into_iter().zip([0.5 * edge, -0.5 * edge]) {
                if let Place::Rail(r) = mesh.places[v as usize] {
                    let rail = &rails[r as usize];
                    let mu = mu * rail.density([a.p, b.p], &m, HEX_DISTANCE);
                    // Two distances are in balance where they are as the roots of their weights.
                    let weight = length * mu * mu * mu / rail.first([a.p, b.p], &m).powi(2);
                    let moments = &mut self.moments[v as usize];
                    moments.mass.m00 += weight;
                    // As a part of the rail's length.
                    moments.moment.x += weight * rail.part(rail.start + offset);
                }
            }
        }
    }

    /// Moves all samples, none further than [`STEP`].
    fn apply(&self, mesh: &mut Triangulation, rails: &[Rail]) -> f64 {
        let (mut sum, mut moving) = (0.0, 0);
        for ((vertex, place), moments) in mesh.vertices.iter_mut().zip(&mesh.places).zip(&self.moments) {
            let shift = match *place {
                Place::Corner => continue,
                Place::Rail(r) if moments.mass.m00 > 0.0 => {
                    let rail = &rails[r as usize];
                    (rail.end - rail.start) * (moments.moment.x / moments.mass.m00)
                }
                Place::Rail(_) => DVec2::ZERO,
                Place::Free => moments.shift(),
            };
            let squared = dot(&vertex.m, shift, shift);
            let within = if squared > STEP * STEP {
                STEP / squared.sqrt()
            } else {
                1.0
            };
            moving += 1;
            if !squared.is_finite() {
                continue;
            }
            sum += squared.min(STEP * STEP);
            vertex.p = match *place {
                Place::Rail(r) => {
                    let rail = &rails[r as usize];
                    rail.point(rail.part(vertex.p + within * shift))
                }
                _ => vertex.p + within * shift,
            };
        }
        (sum / f64::from(moving.max(1))).sqrt()
    }

    /// Halves the moves of turned triangles' corners, and undoes them in the end: then each triangle has the area that it
    /// had before.
    fn undo_inversions(&self, mesh: &mut Triangulation) {
        for round in 0.. {
            let mut changed = false;
            for t in 0..mesh.triangles.len() {
                if mesh.double_area(t) > 0.0 {
                    continue;
                }
                for v in mesh.triangles[t].v {
                    let (p, before) = (&mut mesh.vertices[v as usize].p, self.before[v as usize]);
                    if *p != before {
                        let halve = round < HALVINGS && mesh.places[v as usize] == Place::Free;
                        *p = if halve { 0.5 * (*p + before) } else { before };
                        changed = true;
                    }
                }
            }
            if !changed {
                return;
            }
        }
    }
}

/// The barycentric weights of the metric circumcentre, and twice the metric area of the triangle. The centre of an obtuse
/// triangle is kept at a bounded distance. Nothing for a triangle without an area.
#[inline]
pub(super) fn circumcentre(p: [DVec2; 3], m: &SymmetricDMat2) -> Option<([f64; 3], f64)> {
    let (e, g) = (p[1] - p[0], p[2] - p[0]);
    let (ee, eg, gg) = (dot(m, e, e), dot(m, e, g), dot(m, g, g));
    let gram = ee * gg - eg * eg;
    if gram <= 0.0 {
        return None;
    }
    let third = 1.0 / 3.0;
    // Relative to the barycentre.
    let mut u = 0.5 * gg * (ee - eg) / gram - third;
    let mut w = 0.5 * ee * (gg - eg) / gram - third;
    let length = |u: f64, w: f64| u * u * ee + 2.0 * u * w * eg + w * w * gg;
    let farthest = length(-third, -third)
        .max(length(2.0 * third, -third))
        .max(length(-third, 2.0 * third));
    let (distance, bound) = (length(u, w), 2.0 * farthest);
    if distance > bound {
        let factor = (bound / distance).sqrt();
        u *= factor;
        w *= factor;
    }
    Some(([third - u - w, third + u, third + w], gram.sqrt()))
}
