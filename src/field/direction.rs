//! Which way a pattern runs.
//!
//! In: a [`DirectionField`], its [`Symmetry`] and turn, and, where it names an attribute, the mesh. Out: a unit tangent
//! per graph vertex.

use super::{
    FieldBuffer, Principal, SmoothField, Snapshot, TensorField, VortexField, attribute, curvature, gradient,
    project_tangent, smooth, smooth_constraints, tensor, turn_tangent,
};
use crate::{error::PatternError, parallel, surface::SurfaceGraph};
use bevy::{mesh::MeshVertexAttribute, prelude::*};
use std::sync::Arc;

/// Whether a direction and its opposite mean the same.
///
/// As a component it overrides [`DirectionField::default_symmetry`].
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Component, Default)]
pub enum Symmetry {
    /// d and -d are the same: curvature, tensors. Only sin Φ is defined; stripes have no sense of direction.
    #[default]
    Line,
    /// d and -d differ: flow, an axis. The phase itself is defined.
    Vector,
}

/// The tangent field that a pattern follows: the phase of the wave grows along it, stripes lie across it.
///
/// Every variant is projected into the tangent plane (of the angle-weighted vertex normal) and normalised. Where it
/// vanishes there, any tangent is taken: the pattern has a singularity in such places anyway.
///
/// Default: the major principal curvature with 30 smoothing steps.
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub enum DirectionField {
    /// One direction for the whole mesh, in the mesh's space.
    Axis(Dir3),
    /// A vertex attribute of format `Float32x3`: one vector of any length per vertex of the mesh, in the mesh's space.
    /// This is also the way in for custom attributes of a `glTF` file. Copies of a vertex at a seam are averaged, as
    /// lines or as vectors by the [`Symmetry`]. Reflection cannot carry the attribute: set it from code.
    Attribute(#[reflect(ignore, default = "attribute::lost_in_reflection")] MeshVertexAttribute),
    /// A direction of principal curvature. It is unstable where the surface is flat or spherical; smoothing carries it
    /// there from places where it is clear.
    PrincipalCurvature {
        /// Which of the two.
        direction: Principal,
        /// Steps of smoothing; one step reaches as far as the next vertices. 0..=[`MAX_SMOOTHING`](DirectionField::MAX_SMOOTHING),
        /// 0 for none; 30 by default.
        smoothing: u32,
    },
    /// The gradient of a scalar, a vertex attribute of format `Float32` that is continuous over the surface.
    Gradient {
        /// One scalar per vertex of the mesh. Reflection cannot carry the attribute: set it from code.
        #[reflect(ignore, default = "attribute::lost_in_reflection")]
        attribute: MeshVertexAttribute,
        /// Follow the contour lines (the gradient turned by 90 degrees, n × d) instead.
        quarter_turn: bool,
    },
    /// One vector of any length per vertex of the mesh, in the mesh's order and space. Copies of a vertex at a seam are
    /// averaged, as lines or as vectors by the [`Symmetry`].
    Vertices(Arc<[Vec3]>),
    /// As [`Vertices`](Self::Vertices), but taken as given: normalised, not projected into the tangent plane; of the
    /// copies of a vertex at a seam the first counts. For tangents that were computed elsewhere.
    Tangents(Arc<[Vec3]>),
    /// Flow around [`Vortex`](super::Vortex) cores, which are entities and may move: evaluated on the device when one does.
    Vortices(#[entities] VortexField),
    /// An eigenvector of a symmetric tensor per vertex, projected. The first two eigenvalues become the pattern's scalars,
    /// unless the entity has [`PatternScalars`](super::PatternScalars).
    Tensor(TensorField),
    /// The smoothest field of lines or crosses that is drawn to curvature, boundary, creases or directions of your own;
    /// smoothed on the device. Where the surface moves or is edited, it continues from where it was by a few sweeps per frame,
    /// [`steps`](SmoothField::steps) of them in all; a change of this component starts from nothing.
    Smooth(SmoothField),
    /// Vectors at a number of times, in ascending order, at least one; between two of them the device blends, as lines or
    /// as vectors by the [`Symmetry`]. [`FieldTime`](super::FieldTime) on the entity tells the time.
    Snapshots(Arc<[Snapshot]>),
    /// Vectors that a compute pass of your own writes on the device.
    Buffer(FieldBuffer),
}

impl Default for DirectionField {
    fn default() -> Self {
        Self::PrincipalCurvature {
            direction: Principal::Major,
            smoothing: 30,
        }
    }
}

impl DirectionField {
    /// The most steps of smoothing of principal curvature.
    pub const MAX_SMOOTHING: u32 = 1000;

    /// The symmetry of the field where the entity has no [`Symmetry`] component: `Vector` for an axis, a gradient and
    /// vortices, `Line` for all others.
    pub fn default_symmetry(&self) -> Symmetry {
        match self {
            Self::Axis(_) | Self::Gradient { .. } | Self::Vortices(_) => Symmetry::Vector,
            Self::Attribute(_)
            | Self::PrincipalCurvature { .. }
            | Self::Vertices(_)
            | Self::Tangents(_)
            | Self::Tensor(_)
            | Self::Smooth(_)
            | Self::Snapshots(_)
            | Self::Buffer(_) => Symmetry::Line,
        }
    }
}

/// Turns a [`DirectionField`] in the tangent plane: an angle in radians, finite, counter-clockwise seen against the
/// normal. Default 0.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Default, Deref, DerefMut)]
#[reflect(Component, Default)]
pub struct FieldTurn(pub f32);

/// The space in which directions and lengths are meant.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Component, Default)]
pub enum PatternSpace {
    /// The mesh's own: the pattern is solved once and is carried, stretched and sheared along with the entity.
    #[default]
    Mesh,
    /// The world's: positions, normals and field are taken through the linear part (rotation, scale, shear) of the
    /// entity's `GlobalTransform`, so that a scaled entity gets more stripes, not wider ones, and an axis stays put while
    /// the entity turns. Translation changes nothing.
    World,
}

/// The direction at each vertex of `graph`: unit tangents in solver order. `mesh` is the mesh that `graph` was made
/// from; `turn` is in radians ([`FieldTurn`]).
///
/// # Errors
/// [`NotFinite`](PatternError::NotFinite) (with the index of the mesh's vertex) and
/// [`SettingNotFinite`](PatternError::SettingNotFinite); [`OutOfRange`](PatternError::OutOfRange) of steps of smoothing;
/// [`WrongLength`](PatternError::WrongLength)
/// of [`DirectionField::Vertices`]; [`MissingAttribute`](PatternError::MissingAttribute),
/// [`AttributeFormat`](PatternError::AttributeFormat) and [`MeshDataTaken`](PatternError::MeshDataTaken) of fields that
/// name an attribute; [`NotOfMesh`](PatternError::NotOfMesh) of fields that need more than a mesh.
pub fn directions(
    field: &DirectionField,
    symmetry: Symmetry,
    turn: f32,
    graph: &SurfaceGraph,
    mesh: &Mesh,
) -> Result<Vec<Vec3>, PatternError> {
    if !turn.is_finite() {
        return Err(PatternError::SettingNotFinite("FieldTurn"));
    }
    let normals = &graph.normals;
    let mut directions = match field {
        DirectionField::Axis(axis) if !axis.is_finite() => {
            return Err(PatternError::SettingNotFinite("the direction of DirectionField::Axis"));
        }
        DirectionField::Axis(axis) => parallel::collect(graph.len(), |i| project_tangent(**axis, normals[i])),
        DirectionField::Attribute(attribute) => {
            attribute::weld_directions(attribute::vectors(mesh, *attribute)?, symmetry, graph)?
        }
        DirectionField::PrincipalCurvature { direction, smoothing } => {
            curvature::check_smoothing(*smoothing)?;
            curvature::principal_directions(graph, *direction, *smoothing)
        }
        DirectionField::Gradient {
            attribute,
            quarter_turn,
        } => {
            let scalars = attribute::scalars(mesh, *attribute)?;
            let ascent = gradient::ascent(
                &attribute::weld_scalars(scalars, graph, "scalars", "scalar of vertex")?,
                graph,
            );
            parallel::collect(graph.len(), |i| {
                let d = project_tangent(ascent[i], normals[i]);
                if *quarter_turn { normals[i].cross(d) } else { d }
            })
        }
        DirectionField::Vertices(vectors) => attribute::weld_directions(vectors, symmetry, graph)?,
        DirectionField::Tangents(vectors) => attribute::first_directions(vectors, graph)?,
        DirectionField::Tensor(field) => {
            let tensors = tensor::tensors(field, graph, mesh)?;
            tensor::tensor_directions(&tensors, field.eigenvector, 0.0, graph).0
        }
        DirectionField::Smooth(field) => {
            smooth::smooth_directions(field, &smooth_constraints(field, graph, mesh)?, 0.0, graph)
        }
        DirectionField::Vortices(_) => return Err(PatternError::NotOfMesh("vortex_directions")),
        DirectionField::Snapshots(_) => return Err(PatternError::NotOfMesh("snapshot_directions")),
        DirectionField::Buffer(_) => return Err(PatternError::NotOfMesh("DirectionField::Vertices")),
    };
    if turn != 0.0 {
        for (d, &n) in directions.iter_mut().zip(normals) {
            *d = turn_tangent(*d, n, turn);
        }
    }
    Ok(directions)
}
