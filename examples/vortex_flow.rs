//! Flow on a surface around two vortex cores that move: arrows near the cores, a quiet texture far away, both carried
//! along by the flow. Where the pattern is finer the flow is slower.
//!
//! ```sh
//! cargo run --example vortex_flow
//! cargo run --example vortex_flow -- --screenshot vortex_flow.png
//! ```
//!
//! Space stops the cores.

mod common;

use bevy::prelude::*;
use bevy_field_patterns::prelude::*;
use common::{
    args::run_moving,
    clock::Clock,
    implicit::{ball, gradient, melt},
    isosurface,
    mesh_file::{RawMesh, to_bevy_mesh},
    scene::{Subject, View},
};
use std::{f32::consts::TAU, process::ExitCode};

/// Where a core begins, in radians.
#[derive(Component)]
struct Core(f32);

/// The surface, in the order of its vertices.
#[derive(Component)]
struct Pebble(RawMesh);

fn main() -> ExitCode {
    run_moving("Vortex flow", 2.0, 0.1, |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(View(Vec3::new(0.1, 0.55, 1.0)))
            .add_systems(Startup, setup)
            .add_systems(Update, wander);
    })
}

/// Balls that melt into a pebble: centres and radii.
const PEBBLE: [[f32; 4]; 5] = [
    [-0.75, 0.0, 0.1, 0.55],
    [-0.1, 0.1, -0.15, 0.62],
    [0.6, 0.05, 0.1, 0.6],
    [0.95, -0.05, -0.25, 0.45],
    [0.1, -0.1, 0.4, 0.5],
];

/// Distance from the pebble's surface.
fn pebble(p: Vec3) -> f32 {
    let near = |[x, y, z, radius]: [f32; 4]| ball(p, Vec3::new(x, y, z), radius);
    melt(PEBBLE.into_iter().map(near), 0.12)
}

/// The point of the pebble below a point near it.
fn onto_pebble(p: Vec3) -> Vec3 {
    (0..8).fold(p, |p, _| p - pebble(p) * gradient(&pebble, p, 1e-3))
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    server: Res<AssetServer>,
    mut textures: ResMut<Assets<PatternTextureMaterial>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let raw = isosurface::mesh(pebble, Vec3::new(-1.6, -1.0, -1.1), Vec3::new(1.7, 1.0, 1.2), 0.035);
    let material = textures.add(PatternTextureMaterial {
        base: StandardMaterial {
            base_color: Color::srgb(0.87, 0.89, 0.92),
            perceptual_roughness: 0.6,
            ..default()
        },
        extension: PatternTexture {
            image: server.load("textures/arrow.png"),
            tint: LinearRgba::from(Srgba::rgb(0.12, 0.18, 0.32)),
            travel: Travel::Periods(0.6),
            fade: Some(TextureFade {
                image: Some(server.load("textures/streaks.png")),
                begin: 0.45,
                end: 0.65,
                ..default()
            }),
            ..default()
        },
    });
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(to_bevy_mesh(&raw))),
        MeshMaterial3d(material),
        DirectionField::Vortices(VortexField {
            base: Vec3::new(0.12, 0.0, 0.0),
            ..default()
        }),
        Waves::ORTHOGONAL,
        Frequency::Uniform(9.0),
        PatternScalars::default(),
        Pebble(raw),
    ));
    let bead = meshes.add(Sphere::new(0.06));
    for (start, sense, color) in [
        (0.0, Sense::CounterClockwise, Color::srgb(0.93, 0.50, 0.10)),
        (0.5 * TAU, Sense::Clockwise, Color::srgb(0.10, 0.38, 0.85)),
    ] {
        let vortex = Vortex {
            sense,
            radius: 0.3,
            ..default()
        };
        commands.spawn((
            Core(start),
            vortex,
            Mesh3d(bead.clone()),
            MeshMaterial3d(materials.add(color)),
        ));
    }
}

/// Moves the cores over the pebble and tells its vertices how far they are from the nearest.
fn wander(
    clock: Res<Clock>,
    mut cores: Query<(&Core, &mut Transform)>,
    mut pebbles: Query<(&Pebble, &mut PatternScalars)>,
    mut seen: Local<Option<f32>>,
) {
    if seen.replace(clock.seconds) == Some(clock.seconds) {
        return;
    }
    let mut centres = Vec::new();
    for (core, mut transform) in &mut cores {
        let angle = core.0 + TAU * clock.seconds / 20.0;
        let above = Vec3::new(0.1 + 0.75 * angle.cos(), 0.55, 0.25 + 0.4 * (2.0 * angle).sin());
        transform.translation = onto_pebble(above);
        centres.push(transform.translation);
    }
    for (pebble, mut scalars) in &mut pebbles {
        let nearest = |p: &Vec3| centres.iter().map(|c| p.distance(*c)).fold(f32::INFINITY, f32::min);
        scalars.first = ScalarSource::Vertices(pebble.0.positions.iter().map(nearest).collect());
    }
}
