//! Stripes on points: a scan of a creature, noisy, without a mesh. Each point is drawn as a disc that knows its
//! neighbours' waves.
//!
//! ```sh
//! cargo run --example point_cloud
//! cargo run --example point_cloud -- --screenshot point_cloud.png
//! ```

mod common;

use bevy::prelude::*;
use bevy_field_patterns::prelude::*;
use common::{
    args::run_plain,
    creature::Creature,
    points,
    scene::{Subject, View},
};
use std::process::ExitCode;

/// Points of the scan.
const COUNT: usize = 40_000;
/// How far they are off, in units of length; the creature is about 2 units long.
const NOISE: f32 = 0.002;

fn main() -> ExitCode {
    run_plain("Point cloud", |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(View(Vec3::new(1.0, 0.25, 0.75)))
            .add_systems(Startup, setup);
    })
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut stripes: ResMut<Assets<StripeMaterial>>) {
    let cloud = points::scan(&Creature::generate(0.03).mesh, COUNT, NOISE, 1);
    let material = stripes.add(StripeMaterial {
        base: StandardMaterial {
            base_color: Color::srgb(0.92, 0.90, 0.84),
            perceptual_roughness: 0.7,
            ..default()
        },
        extension: Stripes {
            color: LinearRgba::from(Srgba::rgb(0.05, 0.30, 0.38)),
            ..default()
        },
    });
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(points::to_bevy_mesh(&cloud))),
        MeshMaterial3d(material),
        DirectionField::Axis(Dir3::Z),
        Frequency::Uniform(12.0),
    ));
}
