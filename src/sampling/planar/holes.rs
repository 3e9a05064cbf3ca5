//! Samples that are crowded are put where holes are.
//!
//! In: a triangulation of samples. Out: the same, with as many. Relaxation moves a sample by a part of a distance per step:
//! a lack here and an excess some ten distances away would not meet.

use super::{
    insertion::Inserter,
    metric::{ScaledMetric, dot},
    relaxation::{Relaxer, circumcentre},
    sampler::{HEX_AREA, HEX_DISTANCE},
    triangulation::{Place, Side, Triangulation},
};
use crate::error::PatternError;
use bevy::math::DVec2;

/// Circumradius of a triangle with room for another sample, in distances; that of the hexagonal packing is 0.577.
const HOLE: f64 = 0.75;
/// The circumradius that triangles with a larger one are brought to at last, and in how many rounds.
const CLOSED: f64 = 0.75;
const ROUNDS: usize = 2;
/// Samples that are farther than this from all others stay, in distances.
const CROWDED: f64 = 0.75;

impl Triangulation {
    /// The distance of neighbours in a hexagonal packing of as many samples.
    fn spacing(&self) -> f64 {
        HEX_DISTANCE * (self.total_area() / (self.vertices.len() as f64 * HEX_AREA)).sqrt()
    }

    /// The metric circumcentre of a triangle, and its squared distance from the corners; the first corner and 0 where the
    /// triangle has no area, or the centre is beyond a border.
    fn circumcircle(&self, t: usize) -> (DVec2, f64) {
        let [a, b, c] = self.corners(t);
        let m = (a.m + b.m + c.m) * (1.0 / 3.0);
        let sides = self.triangles[t].n;
        match circumcentre([a.p, b.p, c.p], &m) {
            Some((weights, _)) if (0..3).all(|k| weights[k] >= 0.0 || sides[k] != Side::NONE) => {
                let way = weights[1] * (b.p - a.p) + weights[2] * (c.p - a.p);
                (a.p + way, dot(&m, way, way))
            }
            _ => (a.p, 0.0),
        }
    }

    /// Triangles with a larger metric circumradius, the largest first, no two of them with a corner in common.
    fn holes(&self, radius: f64) -> Vec<u32> {
        let mut holes: Vec<(f64, u32)> = (0..self.triangles.len() as u32)
            .map(|t| (self.circumcircle(t as usize).1, t))
            .filter(|&(squared, _)| squared > radius * radius)
            .collect();
        holes.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut taken = vec![false; self.vertices.len()];
        holes.retain(|&(_, t)| {
            let corners = self.triangles[t as usize].v;
            let free = corners.iter().all(|&v| !taken[v as usize]);
            if free {
                corners.iter().for_each(|&v| taken[v as usize] = true);
            }
            free
        });
        holes.into_iter().map(|(_, t)| t).collect()
    }
}

impl Relaxer {
    /// Draws samples towards the centres of the triangles with the largest circumradius.
    pub(super) fn close_holes(&mut self, mesh: &mut Triangulation, metric: &ScaledMetric) -> Result<(), PatternError> {
        let radius = CLOSED * mesh.spacing();
        let shifts = |mesh: &Triangulation| {
            let mut shifts = vec![DVec2::ZERO; mesh.vertices.len()];
            for (t, triangle) in mesh.triangles.iter().enumerate() {
                let (centre, squared) = mesh.circumcircle(t);
                if squared > radius * radius {
                    for v in triangle.v {
                        let way = centre - mesh.vertex(v).p;
                        shifts[v as usize] += way * (1.0 - radius / squared.sqrt());
                    }
                }
            }
            shifts
        };
        for _ in 0..ROUNDS {
            let shifts = shifts(mesh);
            if shifts.iter().all(|shift| *shift == DVec2::ZERO) {
                break;
            }
            self.remember(mesh);
            for ((vertex, place), shift) in mesh.vertices.iter_mut().zip(&mesh.places).zip(shifts) {
                if *place == Place::Free {
                    vertex.p += shift;
                }
            }
            self.settle(mesh, metric)?;
        }
        Ok(())
    }
}

impl Inserter<'_> {
    /// Takes out as many crowded samples as there are holes, and fills the largest holes that there are then.
    pub(super) fn fill_holes(&mut self, mesh: &mut Triangulation) -> Result<(), PatternError> {
        let count = mesh.vertices.len();
        let distance = mesh.spacing();
        let radius = HOLE * distance;
        let mut crowded = mesh.crowded(CROWDED * distance);
        crowded.truncate(mesh.holes(radius).len());
        if mesh.remove(&crowded).is_none() {
            return Ok(());
        }
        mesh.flip_violated();
        for t in mesh.holes(radius) {
            if mesh.vertices.len() < count {
                self.insert(mesh, t, |_, _| ())?;
            }
        }
        self.exactly(mesh, count)
    }
}
