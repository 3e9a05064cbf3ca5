//! A flag in the wind: the mesh is edited on the CPU in every frame, and its stripes keep their distance.
//!
//! ```sh
//! cargo run --example deforming
//! cargo run --example deforming -- --screenshot deforming.png
//! ```
//!
//! Space stops the wind.

mod common;

use bevy::prelude::*;
use bevy_field_patterns::prelude::*;
use common::{
    args::run_moving,
    clock::Clock,
    flag::Flag,
    mesh_file::{RawMesh, smooth_normals, to_bevy_mesh},
    scene::{Subject, View},
};
use std::process::ExitCode;

/// The mesh that the wind moves.
#[derive(Component)]
struct Cloth {
    flag: Flag,
    raw: RawMesh,
    mesh: Handle<Mesh>,
}

fn main() -> ExitCode {
    run_moving("A flag in the wind", 1.9, 0.25, |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(View(Vec3::new(0.25, 0.12, 1.0)))
            .add_systems(Startup, setup)
            .add_systems(Update, blow);
    })
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut stripes: ResMut<Assets<StripeMaterial>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let flag = Flag::default();
    let raw = flag.mesh();
    let mesh = meshes.add(to_bevy_mesh(&raw));
    let material = stripes.add(StripeMaterial {
        base: StandardMaterial {
            base_color: Color::srgb(0.95, 0.92, 0.85),
            perceptual_roughness: 0.8,
            double_sided: true,
            cull_mode: None,
            ..default()
        },
        extension: Stripes {
            color: LinearRgba::from(Srgba::rgb(0.72, 0.13, 0.16)),
            ..default()
        },
    });
    commands.spawn((
        Subject,
        Mesh3d(mesh.clone()),
        MeshMaterial3d(material),
        DirectionField::Axis(Dir3::Y),
        FieldTurn(0.6),
        Frequency::Uniform(3.0),
        Cloth { flag, raw, mesh },
    ));
    let wood = materials.add(StandardMaterial {
        base_color: Color::srgb(0.45, 0.33, 0.24),
        perceptual_roughness: 0.6,
        ..default()
    });
    let pole = Cylinder::new(0.035, 3.4).mesh().resolution(32);
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(pole)),
        MeshMaterial3d(wood.clone()),
        Transform::from_xyz(-0.035, -0.65, 0.0),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(0.075))),
        MeshMaterial3d(wood),
        Transform::from_xyz(-0.035, 1.1, 0.0),
    ));
}

/// Moves the vertices; the plugin notices that the asset has changed.
fn blow(
    clock: Res<Clock>,
    mut cloths: Query<&mut Cloth>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut seen: Local<Option<f32>>,
) {
    if *seen == Some(clock.seconds) {
        return;
    }
    *seen = Some(clock.seconds);
    for mut cloth in &mut cloths {
        cloth.raw.positions = cloth.flag.positions(clock.seconds);
        if let Some(mut mesh) = meshes.get_mut(&cloth.mesh) {
            mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, smooth_normals(&cloth.raw));
            mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, cloth.raw.positions.clone());
        }
    }
}
