//! The samples of a plane, and the [`SampleSet`] that other rooms read.

use super::{
    metric::det,
    triangulation::{Place, Triangulation},
};
use crate::sampling::{SampleSet, SamplingTimes};
use bevy::math::{DVec2, Mat3, Vec3};
use glam_matrix_extras::{SymmetricDMat2, SymmetricMat3};

/// Samples of a planar domain, with their triangulation.
///
/// The lists per sample have the same length and order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlanarSamples {
    /// Position of each sample.
    pub positions: Vec<DVec2>,
    /// Metric of each sample, scaled so that the unit ball is the sample's ellipse.
    pub metrics: Vec<SymmetricDMat2>,
    /// Whether a sample lies on the domain's border.
    pub boundary: Vec<bool>,
    /// The samples at the corners of each triangle, counter-clockwise. Where the samples are too few to keep the domain's
    /// corners, a corner is named by the sample whose cell it lies in: then a sample can be named twice in a triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Where the corners of each triangle are.
    pub corners: Vec<[DVec2; 3]>,
    /// Samples whose cells touch, as (smaller, larger) index, each pair once, in no order.
    pub edges: Vec<[u32; 2]>,
    /// The factor between the user's metric and [`metrics`](Self::metrics).
    pub scale: f64,
    /// Relaxation steps that were done.
    pub steps: u32,
    /// Root mean square of the moves of the last step, in metric units; neighbours are about 2 apart.
    pub rms_move: f64,
    /// What it took.
    pub times: SamplingTimes,
}

impl PlanarSamples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The samples of a triangulation whose vertices are samples.
    pub(super) fn from_mesh(mesh: &Triangulation, scale: f64) -> Self {
        Self {
            positions: mesh.vertices.iter().map(|vertex| vertex.p).collect(),
            metrics: mesh.vertices.iter().map(|vertex| vertex.m).collect(),
            boundary: mesh.places.iter().map(|place| *place != Place::Free).collect(),
            edges: mesh.edges(),
            triangles: mesh.triangles.iter().map(|triangle| triangle.v).collect(),
            corners: corners(mesh),
            scale,
            ..Self::default()
        }
    }

    /// As a set in the plane z = 0, with normals along +z. A sample's triangle is one that it is a corner of; the seeds
    /// are the triangles.
    pub fn set(&self) -> SampleSet {
        let (triangles, barycentrics) = self.places_in_triangles();
        let (neighbor_offsets, neighbors) = self.rings();
        SampleSet {
            positions: self.positions.iter().map(|p| p.as_vec2().extend(0.0)).collect(),
            normals: vec![Vec3::Z; self.len()],
            metrics: self.metrics.iter().map(raised).collect(),
            triangles,
            barycentrics,
            neighbor_offsets,
            neighbors,
            seeds: self.triangles.clone(),
            corners: self
                .corners
                .iter()
                .map(|corners| corners.map(|p| p.as_vec2().extend(0.0)))
                .collect(),
        }
    }

    /// A triangle of each sample, and the sample's weights in it.
    fn places_in_triangles(&self) -> (Vec<u32>, Vec<Vec3>) {
        let mut triangles = vec![0; self.len()];
        let mut barycentrics = vec![Vec3::X; self.len()];
        for (corners, t) in self.triangles.iter().zip(0..) {
            for (k, &v) in corners.iter().enumerate() {
                triangles[v as usize] = t;
                barycentrics[v as usize] = Mat3::IDENTITY.col(k);
            }
        }
        (triangles, barycentrics)
    }

    /// The neighbours of each sample in CSR form.
    fn rings(&self) -> (Vec<u32>, Vec<u32>) {
        let mut offsets = vec![0; self.len() + 1];
        for &v in self.edges.iter().flatten() {
            offsets[v as usize + 1] += 1;
        }
        for i in 0..self.len() {
            offsets[i + 1] += offsets[i];
        }
        let mut end = offsets.clone();
        let mut neighbors = vec![0; 2 * self.edges.len()];
        for &[a, b] in &self.edges {
            for (from, to) in [(a, b), (b, a)] {
                let slot = &mut end[from as usize];
                neighbors[*slot as usize] = to;
                *slot += 1;
            }
        }
        for ring in offsets.windows(2) {
            neighbors[ring[0] as usize..ring[1] as usize].sort_unstable();
        }
        (offsets, neighbors)
    }
}

/// Where the corners of a triangulation's triangles are.
pub(super) fn corners(mesh: &Triangulation) -> Vec<[DVec2; 3]> {
    (0..mesh.triangles.len())
        .map(|t| mesh.corners(t).map(|corner| corner.p))
        .collect()
}

/// The metric in space, with the eigenvalue √(λ₁λ₂) along z.
fn raised(m: &SymmetricDMat2) -> SymmetricMat3 {
    SymmetricMat3 {
        m00: m.m00 as f32,
        m01: m.m01 as f32,
        m11: m.m11 as f32,
        m22: det(m).sqrt() as f32,
        ..SymmetricMat3::ZERO
    }
}
