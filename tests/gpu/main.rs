//! The plugin on a device: the solver against its CPU twin, the life of patterns, the shared memory.

mod budget;
mod buffers;
#[path = "../common/mod.rs"]
mod common;
mod creases;
mod fields;
mod flow;
mod frequencies;
mod life;
mod signs;
mod twin;
mod work;

use bevy_field_patterns::{field::Principal, prelude::*};

fn curvature() -> DirectionField {
    DirectionField::PrincipalCurvature {
        direction: Principal::Major,
        smoothing: 10,
    }
}
