//! Fields and styles: six shapes, each with another field, some of which share a material.
//!
//! In front an axis, a gradient and a travelling phase; behind a vector per vertex, cut out so that its shadow is striped
//! as well, and the two principal curvatures. A light circles around them.

mod common;

use std::{f32::consts::TAU, process::ExitCode, sync::Arc};

use bevy::{mesh::MeshVertexAttribute, prelude::*, render::render_resource::VertexFormat};
use bevy_field_patterns::{field::Principal, prelude::*};
use common::{args::run_plain, mesh_file::to_bevy_mesh, scene::Subject, shapes};

/// A scalar per vertex, whose gradient a pattern follows.
const HEAT: MeshVertexAttribute = MeshVertexAttribute::new("Heat", 0x0F1E_1D05, VertexFormat::Float32);

/// The light that circles.
#[derive(Component)]
struct Circling;

fn main() -> ExitCode {
    run_plain("Fields and styles", |app| {
        app.add_plugins(FieldPatternsPlugin)
            .add_systems(Startup, setup)
            .add_systems(Update, circle);
    })
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut stripes: ResMut<Assets<StripeMaterial>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let [porcelain, glowing, carved, soft, basket] = styles().map(|style| stripes.add(style));
    let curvature = |direction| DirectionField::PrincipalCurvature {
        direction,
        smoothing: 30,
    };
    let along_y = DirectionField::Axis(Dir3::Y);
    let ball = shapes::icosphere(5, 0.7);
    let stoves = [
        Vec3::new(0.6, 0.4, 0.5),
        Vec3::new(-0.5, -0.3, 0.7),
        Vec3::new(0.0, 0.6, -0.6),
    ];
    let warmth = |p: &Vec3| stoves.iter().map(|stove| 1.0 / p.distance(*stove)).sum::<f32>();
    let heat: Vec<f32> = ball.positions.iter().map(warmth).collect();
    let warm_ball = to_bevy_mesh(&ball).with_inserted_attribute(HEAT, heat);
    let ascent = DirectionField::Gradient {
        attribute: HEAT,
        quarter_turn: false,
    };
    // Around the y axis, and rising.
    let helix: Arc<[Vec3]> = ball.positions.iter().map(|p| Vec3::new(p.z, 0.3, -p.x)).collect();
    let ring = to_bevy_mesh(&shapes::torus(120, 60, 0.6, 0.28, 0.0, 1));
    let knot = to_bevy_mesh(&shapes::knot(320, 32));
    let capsule = Capsule3d::new(0.4, 0.65)
        .mesh()
        .longitudes(48)
        .latitudes(24)
        .rings(24)
        .build();

    let shown = [
        // The first two share a style.
        (
            ring.clone(),
            &porcelain,
            along_y.clone(),
            9.0,
            Vec3::new(-1.9, 0.88, 0.9),
        ),
        (
            knot,
            &porcelain,
            curvature(Principal::Minor),
            8.0,
            Vec3::new(0.2, 1.05, -1.7),
        ),
        (capsule, &glowing, along_y, 7.0, Vec3::new(1.9, 0.73, 0.9)),
        (warm_ball, &soft, ascent, 8.0, Vec3::new(0.1, 0.7, 1.0)),
        (
            to_bevy_mesh(&ball),
            &basket,
            DirectionField::Vertices(helix),
            5.0,
            Vec3::new(-2.4, 0.7, -1.6),
        ),
        (
            ring,
            &carved,
            curvature(Principal::Major),
            7.0,
            Vec3::new(2.5, 0.88, -1.6),
        ),
    ];
    for (mesh, style, field, frequency, at) in shown {
        let look = (
            Mesh3d(meshes.add(mesh)),
            MeshMaterial3d(style.clone()),
            Transform::from_translation(at),
        );
        // All but the curvatures are vectors, not lines.
        let symmetry = match field {
            DirectionField::PrincipalCurvature { .. } => Symmetry::Line,
            _ => Symmetry::Vector,
        };
        commands.spawn((Subject, look, field, symmetry, Frequency::Uniform(frequency)));
    }

    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(5.0, 0.1).mesh().resolution(128))),
        MeshMaterial3d(materials.add(StandardMaterial::from(Color::srgb(0.72, 0.73, 0.75)))),
        Transform::from_xyz(0.0, -0.05, 0.0),
    ));
    let lamp = DirectionalLight {
        illuminance: 4_000.0,
        color: Color::srgb(1.0, 0.80, 0.55),
        ..default()
    };
    commands.spawn((Circling, lamp));
}

/// Porcelain, glowing and travelling, carved, soft, and a basket.
fn styles() -> [StripeMaterial; 5] {
    let style = |base: Color, color: Color, adapt: fn(&mut StripeMaterial)| {
        let mut style = StripeMaterial {
            base: base.into(),
            extension: default(),
        };
        style.extension.color = color.into();
        adapt(&mut style);
        style
    };
    [
        style(Color::srgb(0.95, 0.93, 0.88), Color::srgb(0.1, 0.19, 0.38), |_| ()),
        style(Color::srgb(0.05, 0.09, 0.12), Color::srgb(0.25, 0.88, 0.80), |style| {
            style.extension.profile = Profile::Sine;
            style.extension.phase_speed = 0.6;
            style.extension.drive.emissive = 0.5;
        }),
        style(Color::srgb(0.80, 0.45, 0.22), Color::srgb(0.48, 0.25, 0.15), |style| {
            style.extension.duty = 0.35;
            style.extension.drive.bump = -0.02;
        }),
        style(Color::srgb(0.98, 0.85, 0.60), Color::srgb(0.70, 0.19, 0.25), |style| {
            style.extension.softness = 0.8;
        }),
        style(Color::srgb(0.75, 0.60, 0.35), Color::srgb(0.70, 0.54, 0.31), |style| {
            style.extension.duty = 0.6;
            style.extension.cutout = true;
            // Its inside is seen through the holes.
            style.base.cull_mode = None;
            style.base.double_sided = true;
        }),
    ]
}

fn circle(time: Res<Time>, mut lights: Query<&mut Transform, With<Circling>>) {
    let angle = TAU * time.elapsed_secs() / 12.0;
    for mut transform in &mut lights {
        *transform = Transform::from_xyz(angle.sin(), 0.8, angle.cos()).looking_at(Vec3::ZERO, Vec3::Y);
    }
}
