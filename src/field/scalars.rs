//! Scalars that styles may show.

use super::attribute;
use crate::{error::PatternError, surface::SurfaceGraph};
use bevy::{mesh::MeshVertexAttribute, prelude::*};
use std::sync::Arc;

/// Two scalars per vertex, for the styles of an entity with a pattern (fade, colour, tone) and for
/// [`Frequency::Eigenvalue`](super::Frequency). Without this component, those of a [`DirectionField::Tensor`](super::DirectionField)
/// are its first two eigenvalues; other fields have none.
///
/// A change of scalars alone solves nothing again, unless the frequency depends on them.
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct PatternScalars {
    /// The first scalar.
    pub first: ScalarSource,
    /// The second one.
    pub second: ScalarSource,
}

/// Where a scalar per vertex comes from. Copies of a vertex at a seam are averaged; between vertices it varies linearly.
#[derive(Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Default)]
pub enum ScalarSource {
    /// 0 everywhere.
    #[default]
    None,
    /// A vertex attribute of format `Float32`. Reflection cannot carry the attribute: set it from code.
    Attribute(#[reflect(ignore, default = "attribute::lost_in_reflection")] MeshVertexAttribute),
    /// One value per vertex of the mesh, in the mesh's order.
    Vertices(Arc<[f32]>),
}

/// The two scalars at each vertex of `graph`, in solver order. `mesh` is the mesh that `graph` was made from.
///
/// # Errors
/// [`NotFinite`](PatternError::NotFinite) (with the index of the mesh's vertex), [`WrongLength`](PatternError::WrongLength),
/// and those of an attribute.
pub fn scalars(scalars: &PatternScalars, graph: &SurfaceGraph, mesh: &Mesh) -> Result<Vec<Vec2>, PatternError> {
    let [first, second] = [&scalars.first, &scalars.second].map(|source| {
        let weld = |values: &[f32]| attribute::weld_scalars(values, graph, "scalars", "scalar of vertex");
        match source {
            ScalarSource::None => Ok(vec![0.0; graph.len()]),
            ScalarSource::Attribute(attribute) => weld(attribute::scalars(mesh, *attribute)?),
            ScalarSource::Vertices(values) => weld(values),
        }
    });
    Ok(first?.into_iter().zip(second?).map(Vec2::from).collect())
}
