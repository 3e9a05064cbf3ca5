//! Surgical guidance: the hatching of a vessel tree gets finer the nearer the tip of a needle is, so that lines are about
//! a tenth of the distance wide.
//!
//! ```sh
//! cargo run --example needle
//! cargo run --example needle -- --screenshot needle.png
//! ```
//!
//! Space stops the needle.

mod common;

use bevy::{gltf::GltfAssetLabel, prelude::*};
use bevy_field_patterns::prelude::*;
use common::{
    args::run_moving,
    clock::Clock,
    gltf::FIELD_ATTRIBUTE,
    instrument,
    mesh_file::to_bevy_mesh,
    scene::{Subject, View},
    shapes,
};
use std::{f32::consts::TAU, process::ExitCode};

/// The needle; its tip is its origin.
#[derive(Component)]
struct Needle;

/// Where the needle is to go, in the tree's crown.
const TARGET: Vec3 = Vec3::new(-0.36, 0.28, 0.2);

fn main() -> ExitCode {
    run_moving("Needle", 3.0, 0.2, |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(View(Vec3::new(0.15, 0.1, 1.0)))
            .add_systems(Startup, setup)
            .add_systems(Update, advance);
    })
}

fn setup(
    mut commands: Commands,
    server: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut hatches: ResMut<Assets<HatchMaterial>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let metal = materials.add(StandardMaterial {
        base_color: Color::srgb(0.25, 0.62, 0.30),
        perceptual_roughness: 0.3,
        metallic: 0.2,
        ..default()
    });
    let needle = (
        Needle,
        Mesh3d(meshes.add(to_bevy_mesh(&instrument::needle(24)))),
        MeshMaterial3d(metal),
        Transform::default(),
    );
    let needle = commands.spawn(needle).id();
    let tumour = materials.add(StandardMaterial {
        base_color: Color::srgb(0.48, 0.30, 0.18),
        perceptual_roughness: 0.7,
        ..default()
    });
    commands.spawn((
        Mesh3d(meshes.add(to_bevy_mesh(&shapes::icosphere(4, 0.1)))),
        MeshMaterial3d(tumour),
        Transform::from_translation(TARGET),
    ));
    let hatching = hatches.add(HatchMaterial {
        base: StandardMaterial {
            base_color: Color::srgb(0.96, 0.93, 0.88),
            perceptual_roughness: 0.9,
            ..default()
        },
        extension: Hatch {
            ink: LinearRgba::from(Srgba::rgb(0.45, 0.05, 0.06)),
            paper: LinearRgba::NONE,
            // Lines of one width, as far apart as the pattern says.
            tone: HatchTone::Constant(0.4),
            strokes: HatchStrokes {
                width: 0.4,
                spacing: StrokeSpacing::Period,
                ..default()
            },
            hand: HatchHand::STEADY,
            outline: HatchOutline::solid(1.5),
            ..default()
        },
    });
    commands.spawn((
        Subject,
        Mesh3d(server.load(GltfAssetLabel::Primitive { mesh: 0, primitive: 0 }.from_asset("models/vessels.glb"))),
        MeshMaterial3d(hatching),
        DirectionField::Attribute(FIELD_ATTRIBUTE),
        Symmetry::Vector,
        // At 0.1 units lines are 0.008 wide, at 0.8 units 0.07.
        Frequency::DistanceTo {
            entity: needle,
            segment: Vec3::ZERO,
            near: 0.1,
            far: 0.8,
            near_frequency: 50.0,
            far_frequency: 6.0,
        },
    ));
}

/// In and out, along its shaft.
fn advance(clock: Res<Clock>, mut needles: Query<&mut Transform, With<Needle>>) {
    let back = 0.14 + 0.5 * (1.0 + (TAU * clock.seconds / 6.0).cos());
    let shaft = Vec3::new(0.55, 0.75, 0.4).normalize();
    for mut needle in &mut needles {
        needle.translation = TARGET + back * shaft;
        needle.rotation = Quat::from_rotation_arc(Vec3::Y, shaft);
    }
}
