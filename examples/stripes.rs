//! The smallest program: a torus with stripes that follow an axis.
//!
//! ```sh
//! cargo run --example stripes
//! cargo run --example stripes -- --screenshot stripes.png
//! ```

mod common;

use std::process::ExitCode;

use bevy::{color::palettes::css::NAVY, prelude::*};
use bevy_field_patterns::prelude::*;
use common::{args::run_plain, scene::Subject};

fn main() -> ExitCode {
    // The camera and the lights are the examples' own; the rest is all that stripes need.
    run_plain("Stripes", |app| {
        app.add_plugins(FieldPatternsPlugin).add_systems(Startup, setup);
    })
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut stripes: ResMut<Assets<StripeMaterial>>) {
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(Torus::default().mesh().major_resolution(96).minor_resolution(48))),
        MeshMaterial3d(stripes.add(StripeMaterial {
            base: StandardMaterial::from(Color::WHITE),
            extension: Stripes {
                color: NAVY.into(),
                ..default()
            },
        })),
        DirectionField::Axis(Dir3::Y),
        Frequency::Uniform(12.0),
    ));
}
