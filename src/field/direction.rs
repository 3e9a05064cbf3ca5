//! Directions.

use bevy::prelude::*;

/// Whether a direction and its opposite mean the same.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Component, Default)]
pub enum Symmetry {
    /// d and -d are the same: curvature, tensors. Only sin Φ is defined; stripes have no sense of direction.
    #[default]
    Line,
    /// d and -d differ: flow, an axis. The phase itself is defined.
    Vector,
}
