//! Sees into an organ: where the focus is, stripes are cut out of a liver's hull, and what lies inside is seen in its own
//! colours between them.
//!
//! ```sh
//! cargo run --example see_through
//! cargo run --example see_through -- --screenshot see_through.png
//! ```
//!
//! The focus is an entity that wanders; nothing is solved again when it moves. Space stops it.

mod common;

use bevy::prelude::*;
use bevy_field_patterns::{field::Principal, prelude::*};
use common::{
    args::run_moving,
    clock::Clock,
    mesh_file::to_bevy_mesh,
    organs::Organs,
    scene::{Subject, View},
};
use std::{f32::consts::TAU, process::ExitCode};

/// What the focus circles around.
#[derive(Component)]
struct Around(Vec3);

fn main() -> ExitCode {
    run_moving("See-through", 0.0, 0.0, |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(View(Vec3::new(-0.1, 0.18, 1.0)))
            .add_systems(Startup, setup)
            .add_systems(Update, wander);
    })
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut stripes: ResMut<Assets<StripeMaterial>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let organs = Organs::generate(0.03, 5);
    let flesh = |color: Color, roughness: f32| StandardMaterial {
        base_color: color,
        perceptual_roughness: roughness,
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    let hull = stripes.add(StripeMaterial {
        base: flesh(Color::srgb(0.62, 0.27, 0.20), 0.35),
        extension: Stripes {
            color: LinearRgba::NONE,
            duty: 0.3,
            cutout: true,
            focus: Focus {
                border: 0.5,
                ..default()
            },
            ..default()
        },
    });
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(to_bevy_mesh(&organs.hull))),
        MeshMaterial3d(hull.clone()),
        DirectionField::PrincipalCurvature {
            direction: Principal::Minor,
            smoothing: 200,
        },
        Frequency::Uniform(14.0),
    ));
    for (mesh, color) in [
        (&organs.vessels, Color::srgb(0.36, 0.45, 0.78)),
        (&organs.tumour, Color::srgb(0.85, 0.74, 0.42)),
    ] {
        let material = materials.add(flesh(color, 0.4));
        commands.spawn((Mesh3d(meshes.add(to_bevy_mesh(mesh))), MeshMaterial3d(material)));
    }
    commands.spawn((Around(organs.target), FocusSource::sphere(0.75, [hull])));
}

fn wander(clock: Res<Clock>, mut focus: Query<(&Around, &mut Transform)>) {
    for (around, mut transform) in &mut focus {
        let (sin, cos) = (TAU * clock.seconds / 9.0).sin_cos();
        transform.translation = around.0 + Vec3::new(0.45 * sin + 0.25, 0.15 * (1.0 - cos), 0.4);
    }
}
