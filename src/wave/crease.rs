//! Crests or troughs on the sharp features of a surface.
//!
//! In: the component [`CreasePhase`]. Out: how much the vertices of creases are drawn to z = ±i, where a stripe's middle
//! or the gap's is. That phase is the same for d and -d, so it needs no orientation.

use crate::error::PatternError;
use bevy::prelude::*;
use std::f32::consts::PI;

/// Puts a crest or a trough of the waves where the surface is folded.
///
/// It is a pull, not a constraint, and only works well where stripes run along the creases: choose a field that does, or
/// turn it. Of two waves the first is pulled, of a cross field both. Point clouds have no creases.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct CreasePhase {
    /// A crease is an edge whose two triangles' normals part by more than this many radians, 0..=π, in the mesh's own
    /// space. Default 35 degrees.
    pub angle: f32,
    /// The mesh's borders count as well. Default no.
    pub boundary: bool,
    /// What lies on the crease. Default: a crest.
    pub phase: CreaseLine,
    /// Weight of the pull against that of an edge, of which a vertex has about six; 0..=1000. Default 3; with 12 the creases
    /// win everywhere, with 0.5 they win where the field has nothing against it.
    pub weight: f32,
}

/// What a [`CreasePhase`] puts on creases.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Default)]
#[reflect(Default)]
pub enum CreaseLine {
    /// sin Φ = 1: the middle of a stripe.
    #[default]
    Crest,
    /// sin Φ = -1: the middle between two stripes.
    Trough,
}

impl Default for CreasePhase {
    fn default() -> Self {
        Self {
            angle: 35_f32.to_radians(),
            boundary: false,
            phase: CreaseLine::Crest,
            weight: 3.0,
        }
    }
}

impl CreasePhase {
    /// The weight of the pull to a crest; below 0 to a trough. As [`Edges::pin`](super::solver::Edges::pin) wants it.
    pub fn pull(&self) -> f32 {
        match self.phase {
            CreaseLine::Crest => self.weight,
            CreaseLine::Trough => -self.weight,
        }
    }

    /// Whether every value is in its range.
    ///
    /// # Errors
    /// [`OutOfRange`](PatternError::OutOfRange) with the first value that is not.
    pub fn check(&self) -> Result<(), PatternError> {
        let error = |what, value, expected| Err(PatternError::OutOfRange { what, value, expected });
        if !(0.0..=PI).contains(&self.angle) {
            return error("CreasePhase::angle", self.angle, "0..=π radians");
        }
        if !(0.0..=1000.0).contains(&self.weight) {
            return error("CreasePhase::weight", self.weight, "0..=1000");
        }
        Ok(())
    }
}
