//! Stripes on points: a scan of a creature, noisy, without a mesh. Each point is drawn as a disc that knows its neighbours'
//! waves; beside it the same pattern, carried onto a mesh.
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
    mesh_file::to_bevy_mesh,
    points,
    scene::{Subject, View},
};
use std::process::ExitCode;

/// Points of the scan.
const COUNT: usize = 40_000;
/// How far they are off, in units of length; the creature is about 2 units long.
const NOISE: f32 = 0.002;
/// Where the mesh stands, and the points on the other side.
const ASIDE: Vec3 = Vec3::new(0.65, 0.0, -0.85);

fn main() -> ExitCode {
    run_plain("Point cloud", |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(View(Vec3::new(1.0, 0.25, 0.75)))
            .add_systems(Startup, setup);
    })
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut stripes: ResMut<Assets<StripeMaterial>>) {
    let body = Creature::generate(0.03).mesh;
    let cloud = points::scan(&body, COUNT, NOISE, 1);
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
    let scanned = commands.spawn((
        Subject,
        Mesh3d(meshes.add(points::to_bevy_mesh(&cloud))),
        MeshMaterial3d(material.clone()),
        DirectionField::Axis(Dir3::Z),
        Frequency::Uniform(12.0),
        Transform::from_translation(-ASIDE),
    ));
    let scanned = scanned.id();
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(to_bevy_mesh(&body))),
        MeshMaterial3d(material),
        CarriesPattern { of: scanned },
        Transform::from_translation(ASIDE),
    ));
}
