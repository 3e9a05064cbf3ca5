//! How a mesh can be posed, and a pose.
//!
//! In: a mesh and its graph. Out: joints, weights and morph targets of the welded vertices; a welded vertex goes where the
//! first of its mesh vertices goes.

use crate::{error::PatternError, surface::SurfaceGraph};
use bevy::{
    math::{Affine3A, Mat3A},
    mesh::{MeshVertexAttribute, VertexAttributeValues},
    prelude::*,
};

/// What moves the vertices of a graph.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rig {
    /// The four joints of each vertex; empty where the mesh has no skin.
    pub joints: Vec<[u16; 4]>,
    /// How much each of them counts, as many as there are joints. They sum to 1, as a rule.
    pub weights: Vec<Vec4>,
    /// By how much each morph target displaces each vertex, target after target, in the mesh's units.
    pub displacements: Vec<Vec3>,
}

impl Rig {
    /// The rig of `mesh`, which `graph` was made from. A mesh without joints and targets has an empty one.
    ///
    /// # Errors
    /// [`MeshDataTaken`](PatternError::MeshDataTaken), and [`NotFinite`](PatternError::NotFinite) with the index of a vertex
    /// of the mesh.
    pub fn from_mesh(mesh: &Mesh, graph: &SurfaceGraph) -> Result<Self, PatternError> {
        let first = graph.first_vertices();
        let mut rig = Self::default();
        let joints = attribute(mesh, Mesh::ATTRIBUTE_JOINT_INDEX)?;
        let weights = attribute(mesh, Mesh::ATTRIBUTE_JOINT_WEIGHT)?;
        if let (Some(VertexAttributeValues::Uint16x4(joints)), Some(VertexAttributeValues::Float32x4(weights))) =
            (joints, weights)
        {
            check(
                weights.iter().map(|&w| Vec4::from(w).is_finite()),
                "joint weight of vertex",
            )?;
            rig.joints = first.iter().map(|&v| joints[v as usize]).collect();
            rig.weights = first.iter().map(|&v| weights[v as usize].into()).collect();
        }
        let targets = mesh.try_has_morph_targets().map_err(|_| PatternError::MeshDataTaken)?;
        if targets {
            let targets = mesh.try_morph_targets().map_err(|_| PatternError::MeshDataTaken)?;
            check(targets.iter().map(|t| t.position.is_finite()), "morph target of vertex")?;
            rig.displacements = targets
                .chunks_exact(graph.vertex_of.len().max(1))
                .flat_map(|target| first.iter().map(|&v| target[v as usize].position))
                .collect();
        }
        Ok(rig)
    }

    /// Number of morph targets on a graph of `vertices`.
    pub fn targets(&self, vertices: usize) -> usize {
        self.displacements.len() / vertices.max(1)
    }
}

fn attribute(mesh: &Mesh, name: MeshVertexAttribute) -> Result<Option<&VertexAttributeValues>, PatternError> {
    mesh.try_attribute_option(name).map_err(|_| PatternError::MeshDataTaken)
}

fn check(mut are_finite: impl Iterator<Item = bool>, what: &'static str) -> Result<(), PatternError> {
    match are_finite.position(|finite| !finite) {
        Some(index) => Err(PatternError::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// Where the joints are, and how much each morph target counts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Pose {
    /// Per joint, what takes a vertex of the mesh to the pattern's space; one for all where there is no skin.
    pub matrices: Vec<Affine3A>,
    /// Per morph target, as far as there are weights.
    pub weights: Vec<f32>,
}

/// Share of the mesh's size by which a vertex may be off before it counts as moved. A skeleton that is carried through the
/// world is off by roundings of its place there.
const STILL: f32 = 1e-5;

/// What a pattern follows at most: the change of a joint's axes as parts of their lengths (half a radian, say), the way of a joint
/// in units of half the mesh's diagonal, and the change of a weight.
const JUMP: f32 = 0.5;

/// Where a mesh is at rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Extent {
    center: Vec3,
    /// Half the diagonal.
    pub(crate) half: f32,
}

impl Extent {
    pub(crate) fn of(positions: &[Vec3]) -> Self {
        let (low, high) = positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| {
                (low.min(p), high.max(p))
            });
        Self {
            center: 0.5 * (low + high),
            half: 0.5 * (high - low).length(),
        }
    }

    /// Its middle, and points around that.
    fn points(&self) -> [Vec3; 7] {
        let axes = [
            Vec3::ZERO,
            Vec3::X,
            Vec3::NEG_X,
            Vec3::Y,
            Vec3::NEG_Y,
            Vec3::Z,
            Vec3::NEG_Z,
        ];
        axes.map(|axis| self.center + self.half * axis)
    }
}

impl Pose {
    /// The pose of a mesh that nothing moves.
    pub fn rest() -> Self {
        Self {
            matrices: vec![Affine3A::IDENTITY],
            weights: Vec::new(),
        }
    }

    /// Whether a mesh of this size looks the same in both.
    pub(crate) fn is_near(&self, other: &Self, size: f32) -> bool {
        let near = |a: &Affine3A, b: &Affine3A| {
            let linear = (0..3).all(|k| {
                let (a, b) = (a.matrix3.col(k), b.matrix3.col(k));
                (a - b).abs().max_element() <= STILL * a.abs().max_element()
            });
            let scale = (0..3).map(|k| a.matrix3.col(k).length()).fold(0.0, f32::max);
            linear && (a.translation - b.translation).abs().max_element() <= STILL * scale * size
        };
        self.matrices.len() == other.matrices.len()
            && self.weights.len() == other.weights.len()
            && self.matrices.iter().zip(&other.matrices).all(|(a, b)| near(a, b))
            && self
                .weights
                .iter()
                .zip(&other.weights)
                .all(|(a, b)| (a - b).abs() <= STILL)
    }

    /// Whether a mesh looks so different from before that its pattern had better be solved anew: a joint has turned, grown or
    /// gone away by much, or the weight of a morph target is another one by much. `extent`: of the mesh at rest.
    pub(crate) fn jumps(&self, before: &Self, extent: &Extent) -> bool {
        let joint_jumps = |(now, before): (&Affine3A, &Affine3A)| {
            let motion = *now * before.inverse();
            let turned = motion.matrix3 - Mat3A::IDENTITY;
            let turned = (0..3).map(|k| turned.col(k).length()).fold(0.0, f32::max);
            // A turn leaves some point where it was.
            let way = |p| before.transform_point3(p).distance(now.transform_point3(p));
            let way = extent.points().map(way).into_iter().fold(f32::INFINITY, f32::min);
            let size = extent.half * before.matrix3.determinant().abs().cbrt();
            // Where a joint was flat, its motion is no number.
            !(turned <= JUMP && way <= JUMP * size)
        };
        self.matrices.iter().zip(&before.matrices).any(joint_jumps)
            || self
                .weights
                .iter()
                .zip(&before.weights)
                .any(|(a, b)| (a - b).abs() > JUMP)
    }

    /// As they lie in the geometry buffer: the rows of each matrix, then an element per weight.
    pub(crate) fn elements(&self) -> Vec<Vec4> {
        let rows = self.matrices.iter().flat_map(|matrix| {
            let (linear, at) = (matrix.matrix3.transpose(), matrix.translation);
            [
                linear.x_axis.extend(at.x),
                linear.y_axis.extend(at.y),
                linear.z_axis.extend(at.z),
            ]
        });
        rows.chain(self.weights.iter().map(|&weight| Vec4::new(weight, 0.0, 0.0, 0.0)))
            .collect()
    }
}
