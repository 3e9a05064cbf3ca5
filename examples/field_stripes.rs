//! Fields and styles: six shapes, each with another field, some of which share a material.
//!
//! In front an axis, principal curvatures and a travelling phase; behind a gradient, a vector per vertex and a cut-out
//! that throws a striped shadow. A light circles around them.

mod common;

use std::{f32::consts::TAU, process::ExitCode};

use bevy::{mesh::MeshVertexAttribute, prelude::*, render::render_resource::VertexFormat};
use bevy_field_patterns::{field::Principal, prelude::*};
use clap::Parser;
use common::{
    args::{OutputArgs, run},
    mesh_file::to_bevy_mesh,
    scene::Subject,
    shapes,
};

/// A scalar per vertex, whose gradient a pattern follows.
const HEAT: MeshVertexAttribute = MeshVertexAttribute::new("Heat", 0x0F1E_1D05, VertexFormat::Float32);

/// Shows shapes with stripes along different fields.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    output: OutputArgs,
}

/// The light that circles.
#[derive(Component)]
struct Circling;

fn main() -> ExitCode {
    run("Fields and styles", &Cli::parse().output, |app| {
        app.add_plugins(FieldPatternsPlugin)
            .add_systems(Startup, setup)
            .add_systems(Update, circle);
        Ok(())
    })
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut stripes: ResMut<Assets<StripeMaterial>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut style = |base: Color, roughness: f32, extension: Stripes| {
        let base = StandardMaterial {
            base_color: base,
            perceptual_roughness: roughness,
            ..default()
        };
        stripes.add(StripeMaterial { base, extension })
    };
    let ink = Stripes {
        color: LinearRgba::rgb(0.01, 0.03, 0.12),
        ..default()
    };
    // Two shapes share this one.
    let porcelain = style(Color::srgb(0.95, 0.93, 0.88), 0.4, ink.clone());
    let carved = style(
        Color::srgb(0.80, 0.45, 0.22),
        0.5,
        Stripes {
            color: LinearRgba::rgb(0.20, 0.05, 0.02),
            duty: 0.35,
            drive: StripeDrive {
                bump: -0.012,
                ..default()
            },
            ..ink.clone()
        },
    );
    let travelling = style(
        Color::srgb(0.05, 0.09, 0.12),
        0.6,
        Stripes {
            color: LinearRgba::rgb(0.05, 0.75, 0.60),
            profile: Profile::Sine,
            phase_speed: 0.6,
            drive: StripeDrive {
                emissive: 0.5,
                ..default()
            },
            ..ink.clone()
        },
    );
    let soft = style(
        Color::srgb(0.98, 0.85, 0.60),
        0.7,
        Stripes {
            color: LinearRgba::rgb(0.45, 0.03, 0.05),
            softness: 0.8,
            ..ink.clone()
        },
    );
    let basket = style(
        Color::srgb(0.75, 0.60, 0.35),
        0.6,
        Stripes {
            color: LinearRgba::rgb(0.45, 0.25, 0.08),
            duty: 0.6,
            cutout: true,
            ..ink
        },
    );
    if let Some(mut material) = stripes.get_mut(&basket) {
        // Its inside is seen through the holes.
        material.base.cull_mode = None;
        material.base.double_sided = true;
    }

    let torus = to_bevy_mesh(&shapes::torus(120, 48, 0.62, 0.28, 0.0, 1));
    let knot = to_bevy_mesh(&shapes::knot(320, 32));
    let ball = shapes::icosphere(5, 0.8);
    let warmest = Vec3::new(0.4, 0.7, 0.6).normalize();
    let heat: Vec<f32> = ball.positions.iter().map(|p| (2.5 * p.dot(warmest)).sin()).collect();
    let hot_ball = to_bevy_mesh(&ball).with_inserted_attribute(HEAT, heat);
    // Around the y axis, rising: a helix.
    let helix: Vec<Vec3> = ball.positions.iter().map(|p| Vec3::new(p.z, 0.35, -p.x)).collect();
    let shell = to_bevy_mesh(&ball);
    let capsule = Capsule3d::new(0.45, 0.8)
        .mesh()
        .longitudes(48)
        .latitudes(24)
        .rings(24)
        .build();

    let curvature = |direction| DirectionField::PrincipalCurvature {
        direction,
        smoothing: 30,
    };
    let mut show = |mesh: Mesh, material: &Handle<StripeMaterial>, field: DirectionField, frequency: f32, at: Vec3| {
        let looks = (
            Mesh3d(meshes.add(mesh)),
            MeshMaterial3d(material.clone()),
            Transform::from_translation(at),
        );
        commands
            .spawn((Subject, looks, field, Frequency::Uniform(frequency)))
            .id()
    };
    show(
        torus,
        &porcelain,
        DirectionField::Axis(Dir3::Y),
        16.0,
        Vec3::new(-2.1, 0.9, 0.9),
    );
    show(
        knot,
        &porcelain,
        curvature(Principal::Minor),
        9.0,
        Vec3::new(0.0, 1.05, 1.0),
    );
    show(
        capsule,
        &travelling,
        DirectionField::Axis(Dir3::Y),
        7.0,
        Vec3::new(2.1, 0.85, 0.9),
    );
    let gradient = DirectionField::Gradient {
        attribute: HEAT,
        quarter_turn: false,
    };
    show(hot_ball, &soft, gradient, 9.0, Vec3::new(-2.1, 0.8, -1.6));
    let open = show(
        shell,
        &basket,
        DirectionField::Vertices(helix.into()),
        7.0,
        Vec3::new(0.0, 0.8, -1.6),
    );
    let tall = to_bevy_mesh(&shapes::torus(120, 60, 0.6, 0.3, 0.0, 1));
    show(
        tall,
        &carved,
        curvature(Principal::Major),
        8.0,
        Vec3::new(2.1, 0.9, -1.6),
    );

    commands.entity(open).insert(Symmetry::Vector);
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(Plane3d::default().mesh().size(7.5, 6.0))),
        MeshMaterial3d(materials.add(StandardMaterial::from(Color::srgb(0.72, 0.73, 0.75)))),
    ));
    let lamp = PointLight {
        intensity: 400_000.0,
        color: Color::srgb(1.0, 0.85, 0.65),
        range: 20.0,
        ..default()
    };
    commands.spawn((Circling, lamp, Transform::default()));
}

fn circle(time: Res<Time>, mut lights: Query<&mut Transform, With<Circling>>) {
    let angle = TAU * time.elapsed_secs() / 12.0;
    for mut transform in &mut lights {
        transform.translation = Vec3::new(4.0 * angle.sin(), 3.0, 4.0 * angle.cos());
    }
}
