//! The result of sampling.

use crate::error::PatternError;
use bevy::prelude::*;
use glam_matrix_extras::SymmetricMat3;

/// Samples on a surface or in a plane, with the cells' neighbourhood.
///
/// All per-sample lists have the same length and order. In the plane z = 0 and the normals are +z.
#[derive(Component, Debug, Clone, Default, PartialEq)]
pub struct SampleSet {
    /// Position of each sample, in the units of the mesh or the plane.
    pub positions: Vec<Vec3>,
    /// Unit normal of the surface at each sample.
    pub normals: Vec<Vec3>,
    /// Metric of each sample. Its unit ball is the ellipse that the sample stands for; along the normal its eigenvalue is
    /// the geometric mean of the other two.
    pub metrics: Vec<SymmetricMat3>,
    /// The triangle that each sample lies in: an index into [`SurfaceGraph::triangles`](crate::surface::SurfaceGraph) on a
    /// surface, into [`seeds`](Self::seeds) in the plane.
    pub triangles: Vec<u32>,
    /// Weights of the triangle's corners at each sample; not negative, of sum 1.
    pub barycentrics: Vec<Vec3>,
    /// `neighbor_offsets[i]..neighbor_offsets[i + 1]` are the entries of [`neighbors`](Self::neighbors) of sample `i`;
    /// `samples + 1` entries, or none.
    pub neighbor_offsets: Vec<u32>,
    /// Samples whose cells touch, ascending per sample, symmetric, without the sample itself.
    pub neighbors: Vec<u32>,
    /// For each triangle of the surface, the samples nearest to its three corners (in their own metrics): where the search
    /// for a point's cell begins. In the plane the triangles are those of the triangulated samples themselves.
    pub seeds: Vec<[u32; 3]>,
    /// Of a planar set, where the corners of each triangle of [`seeds`](Self::seeds) are: at the samples themselves, but for
    /// corners of a domain that has too few samples to have one there. Empty on a surface.
    pub corners: Vec<[Vec3; 3]>,
}

impl SampleSet {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The samples whose cells touch that of sample `i`.
    pub fn ring(&self, i: usize) -> &[u32] {
        match (self.neighbor_offsets.get(i), self.neighbor_offsets.get(i + 1)) {
            (Some(&first), Some(&end)) => &self.neighbors[first as usize..end as usize],
            _ => &[],
        }
    }

    /// Squared distance of a point from sample `i`, in the sample's own metric.
    pub fn distance_squared(&self, i: usize, point: Vec3) -> f32 {
        let r = point - self.positions[i];
        r.dot(self.metrics[i] * r)
    }

    /// Whether 1/r² of every sample is within single precision, with room for long ellipses: metrics, and what shaders
    /// compute of them.
    pub(crate) fn check_radii(&self) -> Result<(), PatternError> {
        let radius = |m: &SymmetricMat3| (3.0 / (f64::from(m.m00) + f64::from(m.m11) + f64::from(m.m22))).sqrt() as f32;
        match self.metrics.iter().map(radius).find(|r| *r < 1e-16 || *r > 1e16) {
            Some(value) => Err(PatternError::OutOfRange {
                what: "the radius of a sample",
                value,
                expected: "1e-16 to 1e16; scale the mesh or the plane",
            }),
            None => Ok(()),
        }
    }
}
