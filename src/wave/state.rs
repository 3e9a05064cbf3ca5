//! What users can read of a pattern, and the events it sends.

use super::waves::{Coupling, Waves};
use crate::{error::PatternError, field::Symmetry};
use bevy::prelude::*;

/// How far a pattern has come. Set by the plugin on every entity with a
/// [`DirectionField`](crate::field::DirectionField).
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default)]
pub enum PatternState {
    /// The mesh is being loaded, or its graph or field is being computed; the base material is drawn.
    #[default]
    Preparing,
    /// An input has changed within the last frames; the pattern is drawn and follows. After a leap it is solved from nothing:
    /// where an axis or [`FieldTurn`](crate::field::FieldTurn) turns by more than half a radian in a frame, a uniform frequency
    /// changes by more than a quarter, a vortex moves by more than its radius, the kind of field or frequency is another, or, in
    /// [`PatternSpace::World`](crate::field::PatternSpace), the transform's axes change by more than a quarter of their lengths.
    Solving,
    /// Nothing changes and nothing is computed.
    Converged,
    /// The app renders nothing. The graph is ready in [`PatternMesh`](crate::surface::PatternMesh); [`solve_cpu`](crate::wave::solver::solve_cpu)
    /// solves on it.
    NoGpu,
    /// The pattern cannot be drawn; the base material is drawn instead. A change of an input tries again.
    Failed(PatternError),
}

/// Sent to an entity when its pattern is drawn for the first time, or anew after a failure.
#[derive(EntityEvent, Debug, Clone)]
pub struct PatternReady {
    /// The entity with the pattern.
    pub entity: Entity,
}

/// Sent to an entity when its pattern cannot be drawn.
#[derive(EntityEvent, Debug, Clone)]
pub struct PatternFailed {
    /// The entity without a pattern.
    pub entity: Entity,
    /// Why.
    pub error: PatternError,
}

/// Send it to an entity to solve its pattern from nothing.
#[derive(EntityEvent, Debug, Clone)]
pub struct RestartPattern {
    /// The entity with the pattern.
    pub entity: Entity,
}

/// What an entity's style asks of its pattern, each with the name of the setting that asks for it; the material sets it, and
/// a pattern that lacks it fails. Materials of your own may set it as well.
#[derive(Component, Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StyleNeeds {
    /// A field where d and -d differ, or [`PatternError::NeedsVectorSymmetry`].
    pub vector: Option<&'static str>,
    /// Two waves, or [`PatternError::NeedsTwoWaves`].
    pub two_waves: Option<&'static str>,
    /// Two waves that are told apart, so no cross field, or [`PatternError::NeedsBothWaves`].
    pub apart: Option<&'static str>,
}

impl StyleNeeds {
    pub(crate) fn check(self, coupling: Coupling) -> Result<(), PatternError> {
        match self {
            Self {
                two_waves: Some(what), ..
            } if coupling.waves.count() < 2 => Err(PatternError::NeedsTwoWaves(what)),
            Self { vector: Some(what), .. } if coupling.symmetry == Symmetry::Line => {
                Err(PatternError::NeedsVectorSymmetry(what))
            }
            Self { apart: Some(what), .. } if coupling.waves == Waves::Cross => Err(PatternError::NeedsBothWaves(what)),
            _ => Ok(()),
        }
    }
}
