//! How dense a pattern is.
//!
//! In: a [`Frequency`] and, where it names an attribute, the mesh. Out: stripes per unit length, one value per graph
//! vertex.

use super::{Eigenvector, FieldBuffer, attribute};
use crate::{error::PatternError, surface::SurfaceGraph};
use bevy::{mesh::MeshVertexAttribute, prelude::*};
use std::sync::Arc;

/// Stripes (periods) per unit length; finite, 0 or more. Between vertices it varies linearly.
///
/// The unit of length is the mesh's own, or the world's with [`PatternSpace::World`](super::PatternSpace).
/// Default: 10 stripes per unit length everywhere.
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub enum Frequency {
    /// The same everywhere.
    Uniform(f32),
    /// A vertex attribute of format `Float32`, one value per vertex of the mesh. Copies of a vertex at a seam are
    /// averaged. Reflection cannot carry the attribute: set it from code.
    Attribute(#[reflect(ignore, default = "attribute::lost_in_reflection")] MeshVertexAttribute),
    /// One value per vertex of the mesh, in the mesh's order. Copies of a vertex at a seam are averaged.
    Vertices(Arc<[f32]>),
    /// By the distance r to an entity, evaluated on the device when the entity or the surface moves: f goes linearly from
    /// `near_frequency` for r ≤ `near` to `far_frequency` for r ≥ `far`.
    DistanceTo {
        /// The entity; it must have a `GlobalTransform`.
        #[entities]
        entity: Entity,
        /// The distance is that to the segment from the entity's origin to this point, in the entity's space: an
        /// instrument's shaft. Zero: to the origin.
        segment: Vec3,
        /// A distance in units of the pattern's space, finite, 0 or more.
        near: f32,
        /// A distance, finite, above `near`.
        far: f32,
        /// Stripes per unit length; finite, 0 or more.
        near_frequency: f32,
        /// Stripes per unit length; finite, 0 or more.
        far_frequency: f32,
    },
    /// Stripes that keep their width on the screen of a camera: a period takes `pixels` where the surface faces the
    /// camera. Evaluated on the device while the pattern follows the camera.
    Screen {
        /// The camera; one that has drawn nothing yet is waited for.
        #[entities]
        camera: Entity,
        /// Logical pixels of one period; finite, above 0.
        pixels: f32,
        /// The relative change of a pixel's size, somewhere on the surface, up to which the pattern stays as it is and
        /// sleeps; finite, 0 or more, usually 0.1 to 0.5. Beyond it, the pattern follows the camera until that rests.
        hysteresis: f32,
    },
    /// By an eigenvalue of a [`DirectionField::Tensor`](super::DirectionField), or one of the entity's
    /// [`PatternScalars`](super::PatternScalars), evaluated on the device: f goes linearly from `low_frequency` for values
    /// up to `low` to `high_frequency` for values from `high` on.
    Eigenvalue {
        /// The first or the second one.
        eigenvalue: Eigenvector,
        /// A value, finite.
        low: f32,
        /// A value, finite, above `low`.
        high: f32,
        /// Stripes per unit length; finite, 0 or more.
        low_frequency: f32,
        /// Stripes per unit length; finite, 0 or more.
        high_frequency: f32,
    },
    /// Frequencies that a compute pass of your own writes on the device.
    Buffer(FieldBuffer),
}

impl Default for Frequency {
    fn default() -> Self {
        Self::Uniform(10.0)
    }
}

/// The frequency at each vertex of `graph`, in solver order. `mesh` is the mesh that `graph` was made from.
///
/// # Errors
/// [`NegativeFrequency`](PatternError::NegativeFrequency) and [`NotFinite`](PatternError::NotFinite) (with the index of
/// the mesh's vertex); [`WrongLength`](PatternError::WrongLength) of [`Frequency::Vertices`];
/// [`MissingAttribute`](PatternError::MissingAttribute), [`AttributeFormat`](PatternError::AttributeFormat) and
/// [`MeshDataTaken`](PatternError::MeshDataTaken) of [`Frequency::Attribute`]; [`NotOfMesh`](PatternError::NotOfMesh) of
/// frequencies that need more than a mesh.
pub fn frequencies(frequency: &Frequency, graph: &SurfaceGraph, mesh: &Mesh) -> Result<Vec<f32>, PatternError> {
    let per_vertex = |values: &[f32]| {
        let welded = attribute::weld_scalars(values, graph, "frequencies", "frequency of vertex")?;
        match values.iter().find(|&&f| f < 0.0) {
            Some(&negative) => Err(PatternError::NegativeFrequency(negative)),
            None => Ok(welded),
        }
    };
    match frequency {
        Frequency::Uniform(f) if !f.is_finite() => Err(PatternError::SettingNotFinite("Frequency::Uniform")),
        Frequency::Uniform(f) if *f < 0.0 => Err(PatternError::NegativeFrequency(*f)),
        Frequency::Uniform(f) => Ok(vec![*f; graph.len()]),
        Frequency::Attribute(attribute) => per_vertex(attribute::scalars(mesh, *attribute)?),
        Frequency::Vertices(values) => per_vertex(values),
        Frequency::DistanceTo { .. } => Err(PatternError::NotOfMesh("distance_frequency")),
        Frequency::Screen { .. } => Err(PatternError::NotOfMesh("screen_frequency")),
        Frequency::Eigenvalue { .. } => Err(PatternError::NotOfMesh("scalar_frequency")),
        Frequency::Buffer(_) => Err(PatternError::NotOfMesh("Frequency::Vertices")),
    }
}
