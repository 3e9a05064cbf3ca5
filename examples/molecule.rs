//! The charge on caffeine's surface: every period cell of a pattern shows a minus, a dot or a plus, and the colour stays
//! free for something else, here the light.
//!
//! ```sh
//! cargo run --example molecule
//! cargo run --example molecule -- --screenshot molecule.png
//! ```

mod common;

use bevy::prelude::*;
use bevy_field_patterns::prelude::*;
use common::{
    args::run_plain,
    mesh_file::to_bevy_mesh,
    molecule::{self, CAFFEINE},
    scene::{Subject, View},
};
use std::process::ExitCode;

/// Elementary charges on the surface that are told from none.
const THRESHOLD: f32 = 0.12;

fn main() -> ExitCode {
    run_plain("Molecule", |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(View(Vec3::new(0.25, 0.35, 1.0)))
            .add_systems(Startup, setup);
    })
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    server: Res<AssetServer>,
    mut textures: ResMut<Assets<PatternTextureMaterial>>,
) {
    let surface = molecule::surface(&CAFFEINE, 0.13);
    let charges = molecule::charges(&CAFFEINE, &surface.positions);
    let material = textures.add(PatternTextureMaterial {
        base: StandardMaterial {
            base_color: Color::srgb(0.93, 0.93, 0.91),
            perceptual_roughness: 0.5,
            ..default()
        },
        extension: PatternTexture {
            image: server.load("textures/patches.png"),
            patches: Some(Patches {
                columns: 3,
                low: -3.0 * THRESHOLD,
                high: 3.0 * THRESHOLD,
                ..default()
            }),
            ..default()
        },
    });
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(to_bevy_mesh(&surface))),
        MeshMaterial3d(material),
        // In ångströms, with lines from left to right so that a minus lies flat.
        DirectionField::Axis(Dir3::X),
        Waves::ORTHOGONAL,
        Frequency::Uniform(1.6),
        PatternScalars {
            first: ScalarSource::Vertices(charges.into()),
            ..default()
        },
    ));
}
