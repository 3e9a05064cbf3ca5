//! Eigenvectors of symmetric tensors.
//!
//! In: a symmetric 3×3 tensor per vertex, as (xx, yy, zz) and (xy, yz, xz). Out: a unit tangent per vertex, of line symmetry,
//! and the first two eigenvalues. Eigenvalues are in descending order. The tensor is diagonalised by six rounds of Jacobi
//! rotations, which give orthonormal eigenvectors for equal eigenvalues as well.

use super::{attribute, project_tangent, turn_tangent};
use crate::{error::PatternError, parallel, surface::SurfaceGraph};
use bevy::{
    math::{DVec3, Mat3A},
    mesh::MeshVertexAttribute,
    prelude::*,
};

/// Rounds of rotations: each squares the error, once it is small.
const ROUNDS: u32 = 6;
/// Below this share of the largest entry an off-diagonal entry counts as 0.
const VANISHING: f32 = 1e-12;

/// Which eigenvector of a tensor.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default)]
pub enum Eigenvector {
    /// Of the largest eigenvalue.
    #[default]
    Major,
    /// Of the second one.
    Medium,
}

/// A symmetric tensor per vertex of the mesh, such as stress; see [`DirectionField::Tensor`](super::DirectionField).
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default)]
pub struct TensorField {
    /// xx, yy, zz of each vertex, `Float32x3`, in the mesh's space. Reflection cannot carry the attribute: set it from code.
    #[reflect(ignore, default = "attribute::lost_in_reflection")]
    pub diagonal: MeshVertexAttribute,
    /// xy, yz, xz of each vertex, `Float32x3`. Reflection cannot carry the attribute: set it from code.
    #[reflect(ignore, default = "attribute::lost_in_reflection")]
    pub off_diagonal: MeshVertexAttribute,
    /// The eigenvector to follow. Default: major.
    pub eigenvector: Eigenvector,
}

impl Default for TensorField {
    fn default() -> Self {
        Self {
            diagonal: attribute::lost_in_reflection(),
            off_diagonal: attribute::lost_in_reflection(),
            eigenvector: Eigenvector::default(),
        }
    }
}

/// A symmetric tensor: (xx, yy, zz) and (xy, yz, xz).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SymmetricTensor {
    /// xx, yy, zz.
    pub diagonal: Vec3,
    /// xy, yz, xz.
    pub off_diagonal: Vec3,
}

impl SymmetricTensor {
    /// A T Aᵀ / |det A|^(2/3): the tensor carried along by the linear map A. Rotations carry the eigenvectors and uniform
    /// scales change nothing.
    pub fn carried(self, linear: Mat3A) -> Self {
        let scale = linear.determinant().abs().cbrt();
        let carried = linear * self.matrix() * linear.transpose() * (scale * scale).recip();
        Self {
            diagonal: Vec3::new(carried.x_axis.x, carried.y_axis.y, carried.z_axis.z),
            off_diagonal: Vec3::new(carried.x_axis.y, carried.y_axis.z, carried.x_axis.z),
        }
    }

    fn matrix(self) -> Mat3A {
        let (d, o) = (self.diagonal, self.off_diagonal);
        Mat3A::from_cols_array(&[d.x, o.x, o.z, o.x, d.y, o.y, o.z, o.y, d.z])
    }

    /// The eigenvalues in descending order and their unit eigenvectors.
    pub fn eigen(self) -> (Vec3, [Vec3; 3]) {
        let scale = self
            .diagonal
            .abs()
            .max_element()
            .max(self.off_diagonal.abs().max_element());
        let mut v = [Vec3::X, Vec3::Y, Vec3::Z];
        if !(scale > 0.0 && scale.is_finite()) {
            return (self.diagonal, v);
        }
        let (mut d, mut o) = (self.diagonal / scale, self.off_diagonal / scale);
        for _ in 0..ROUNDS {
            let (c, s, t) = rotation(d.x, d.y, o.x);
            d += Vec3::new(-t * o.x, t * o.x, 0.0);
            o = Vec3::new(0.0, s * o.z + c * o.y, c * o.z - s * o.y);
            [v[0], v[1]] = [c * v[0] - s * v[1], s * v[0] + c * v[1]];

            let (c, s, t) = rotation(d.y, d.z, o.y);
            d += Vec3::new(0.0, -t * o.y, t * o.y);
            o = Vec3::new(c * o.x - s * o.z, 0.0, s * o.x + c * o.z);
            [v[1], v[2]] = [c * v[1] - s * v[2], s * v[1] + c * v[2]];

            let (c, s, t) = rotation(d.x, d.z, o.z);
            d += Vec3::new(-t * o.z, 0.0, t * o.z);
            o = Vec3::new(c * o.x - s * o.y, s * o.x + c * o.y, 0.0);
            [v[0], v[2]] = [c * v[0] - s * v[2], s * v[0] + c * v[2]];
        }
        let mut values = (d * scale).to_array();
        for [a, b] in [[0, 1], [1, 2], [0, 1]] {
            if values[a] < values[b] {
                values.swap(a, b);
                v.swap(a, b);
            }
        }
        (values.into(), v)
    }
}

/// cos, sin and tan of the rotation that makes the entry `pq` vanish.
fn rotation(pp: f32, qq: f32, pq: f32) -> (f32, f32, f32) {
    if pq.abs() <= VANISHING {
        return (1.0, 0.0, 0.0);
    }
    let theta = (qq - pp) / (2.0 * pq);
    let sign = if theta < 0.0 { -1.0 } else { 1.0 };
    let t = sign / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = (t * t + 1.0).sqrt().recip();
    (c, t * c, t)
}

/// One tensor per graph vertex: the mean over the copies.
///
/// # Errors
/// [`NotFinite`](PatternError::NotFinite) (with the index of the mesh's vertex), [`WrongLength`](PatternError::WrongLength),
/// and those of the attributes.
pub fn tensors(field: &TensorField, graph: &SurfaceGraph, mesh: &Mesh) -> Result<Vec<SymmetricTensor>, PatternError> {
    let [diagonal, off_diagonal] = [field.diagonal, field.off_diagonal].map(|attribute| {
        let vectors = attribute::vectors(mesh, attribute)?;
        attribute::weld_means(vectors, graph, "tensors", "tensor of vertex")
    });
    let both = diagonal?.into_iter().zip(off_diagonal?);
    Ok(both
        .map(|(d, o): (DVec3, DVec3)| SymmetricTensor {
            diagonal: d.as_vec3(),
            off_diagonal: o.as_vec3(),
        })
        .collect())
}

/// Per vertex the eigenvector, projected into the tangent plane and turned by `turn` radians, and the first two
/// eigenvalues. Where the eigenvector is normal to the surface, any tangent.
pub fn tensor_directions(
    tensors: &[SymmetricTensor],
    eigenvector: Eigenvector,
    turn: f32,
    graph: &SurfaceGraph,
) -> (Vec<Vec3>, Vec<Vec2>) {
    let both = parallel::collect(graph.len(), |i| {
        let n = graph.normals[i];
        let (values, vectors) = tensors[i].eigen();
        let d = project_tangent(vectors[eigenvector as usize], n);
        (turn_tangent(d, n, turn), values.truncate())
    });
    both.into_iter().unzip()
}
