//! What users set and read of cells.

use crate::{error::PatternError, sampling::SampleSet};
use bevy::prelude::*;

/// How far an entity's cells have come. Set by the plugin on every entity with a [`SampleSet`] and a material that draws
/// cells, in an app that renders.
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
pub enum CellState {
    /// The mesh is being loaded, its surface is being built, or it is being sampled; the base material is drawn.
    #[default]
    Preparing,
    /// The cells are drawn.
    Ready,
    /// The cells cannot be drawn; the base material is drawn instead. A change of an input tries again.
    Failed(PatternError),
}

/// One colour per sample of the entity's [`SampleSet`], for [`CellFill::Values`](crate::material::CellFill::Values) and
/// [`TileChoice::Value`](crate::material::TileChoice::Value): a mosaic's stones, or any quantity that was given a colour.
///
/// Values belong to their set: give a new set new values before it is drawn, as an observer of
/// [`SamplesReady`](crate::sampling::SamplesReady) does. Another number of them is an error.
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default, Deref, DerefMut)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct SampleValues(pub Vec<LinearRgba>);

/// The entity's material draws the cells of its [`SampleSet`].
///
/// `MeshMaterial3d<CellMaterial>` and `MeshMaterial2d<CellMaterial2d>` require it; insert it yourself where your own
/// material samples `bevy_field_patterns::cells`.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, Default)]
#[reflect(Component, Default, Clone, PartialEq)]
pub struct DrawCells;

/// Whether a set's lists fit together and hold what can be drawn.
///
/// # Errors
/// [`SampleLists`](PatternError::SampleLists), [`SampleIndex`](PatternError::SampleIndex),
/// [`OutOfRange`](PatternError::OutOfRange) of radii, [`NotFinite`](PatternError::NotFinite) and
/// [`NotPositive`](PatternError::NotPositive).
pub fn check_samples(set: &SampleSet) -> Result<(), PatternError> {
    let n = set.len();
    let lists = [
        ("normals", set.normals.len(), n),
        ("metrics", set.metrics.len(), n),
        ("neighbour offsets", set.neighbor_offsets.len(), n + 1),
        (
            "neighbours",
            set.neighbors.len(),
            set.neighbor_offsets.last().map_or(0, |&end| end as usize),
        ),
    ];
    for (what, found, expected) in lists {
        if found != expected {
            return Err(PatternError::SampleLists { what, found, expected });
        }
    }
    if !set.neighbor_offsets.is_sorted() {
        return Err(PatternError::OutOfRange {
            what: "a neighbour offset",
            value: -1.0,
            expected: "not less than the one before",
        });
    }
    check_indices("neighbour", &set.neighbors, n)?;
    check_indices("seed", set.seeds.as_flattened(), n)?;
    set.check_radii()?;
    let finite = |i: usize| set.positions[i].is_finite() && set.normals[i].is_finite() && set.metrics[i].is_finite();
    if let Some(index) = (0..n).find(|&i| !finite(i)) {
        return Err(PatternError::NotFinite { what: "sample", index });
    }
    // Sylvester's criterion.
    let positive = |i: usize| {
        let m = set.metrics[i].as_symmetric_dmat3();
        m.m00 > 0.0 && m.m00 * m.m11 - m.m01 * m.m01 > 0.0 && m.to_mat3().determinant() > 0.0
    };
    match (0..n).find(|&i| !positive(i)) {
        Some(index) => Err(PatternError::NotPositive {
            what: "metric of sample",
            index,
        }),
        None => Ok(()),
    }
}

fn check_indices(what: &'static str, indices: &[u32], samples: usize) -> Result<(), PatternError> {
    match indices.iter().find(|&&index| index as usize >= samples) {
        Some(&index) => Err(PatternError::SampleIndex { what, index, samples }),
        None => Ok(()),
    }
}
