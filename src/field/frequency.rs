//! How dense a pattern is.
//!
//! In: a [`Frequency`] and, where it names an attribute, the mesh. Out: stripes per unit length, one value per graph
//! vertex.

use super::attribute;
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
/// [`MeshDataTaken`](PatternError::MeshDataTaken) of [`Frequency::Attribute`].
pub fn frequencies(frequency: &Frequency, graph: &SurfaceGraph, mesh: &Mesh) -> Result<Vec<f32>, PatternError> {
    let per_vertex = |values: &[f32]| {
        let welded = attribute::weld_scalars(values, graph, "frequencies", "frequency of vertex")?;
        match values.iter().find(|&&f| f < 0.0) {
            Some(&negative) => Err(PatternError::NegativeFrequency(negative)),
            None => Ok(welded),
        }
    };
    match frequency {
        Frequency::Uniform(f) if !f.is_finite() => Err(PatternError::NotFinite {
            what: "frequency of vertex",
            index: 0,
        }),
        Frequency::Uniform(f) if *f < 0.0 => Err(PatternError::NegativeFrequency(*f)),
        Frequency::Uniform(f) => Ok(vec![*f; graph.len()]),
        Frequency::Attribute(attribute) => per_vertex(attribute::scalars(mesh, *attribute)?),
        Frequency::Vertices(values) => per_vertex(values),
    }
}
