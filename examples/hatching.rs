//! Vessels as an illustrator draws them, side by side: strokes by light, strokes that cross where it is dark, a dashed
//! outline with what lies far away in blue.
//!
//! ```sh
//! cargo run --example hatching
//! cargo run --example hatching -- --screenshot hatching.png
//! ```

mod common;

use bevy::prelude::*;
use bevy_field_patterns::{field::Principal, prelude::*};
use clap::Parser;
use common::{
    args::{OutputArgs, run},
    mesh_file::to_bevy_mesh,
    scene::{Subject, View},
    vessel_tree::VesselTree,
};
use std::process::ExitCode;

/// Hatched vessels.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    output: OutputArgs,
    /// Periods of the wave per unit length; strokes are denser, as the view needs
    #[arg(long, default_value_t = 7.0)]
    frequency: f32,
}

#[derive(Resource)]
struct StrokeFrequency(f32);

fn main() -> ExitCode {
    let cli = Cli::parse();
    run("Hatching", &cli.output, |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(ClearColor(Color::srgb(0.90, 0.87, 0.80)))
            .insert_resource(View(Vec3::new(0.0, 0.1, 1.0)))
            .insert_resource(StrokeFrequency(cli.frequency))
            .add_systems(Startup, setup);
        Ok(())
    })
}

/// White paper, as bright as the camera's tone mapping asks for.
const PAPER: LinearRgba = LinearRgba::rgb(2.6, 2.5, 2.3);

/// Ink on paper, dark where little light falls.
fn strokes() -> Hatch {
    Hatch {
        paper: PAPER,
        tone: HatchTone::Light { light: 2.6, dark: 0.3 },
        strokes: HatchStrokes {
            cross_from: 0.25,
            spacing: StrokeSpacing::Pixels(6.0),
            ..default()
        },
        outline: HatchOutline::solid(1.6),
        ..default()
    }
}

/// Only what outlines say, and a few strokes in the shadow.
fn dashed() -> Hatch {
    Hatch {
        ink: LinearRgba::rgb(0.02, 0.03, 0.10),
        paper: PAPER,
        tone: HatchTone::Light { light: 0.8, dark: 0.0 },
        darkest: 0.5,
        outline: HatchOutline::dashed(2.0, 14.0),
        chroma_depth: ChromaDepth {
            near: 3.6,
            far: 5.2,
            ink: 0.7,
            paper: 0.0,
        },
        ..default()
    }
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut hatchings: ResMut<Assets<HatchMaterial>>,
    frequency: Res<StrokeFrequency>,
) {
    let mesh = meshes.add(to_bevy_mesh(&VesselTree::default().mesh(0.02)));
    for (k, (style, waves)) in [
        (strokes(), Waves::Single),
        (strokes(), Waves::ORTHOGONAL),
        (dashed(), Waves::Single),
    ]
    .into_iter()
    .enumerate()
    {
        let material = hatchings.add(HatchMaterial {
            base: StandardMaterial {
                perceptual_roughness: 0.9,
                ..default()
            },
            extension: style,
        });
        commands.spawn((
            Subject,
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material),
            Transform::from_xyz(2.0 * k as f32, 0.0, 0.0),
            DirectionField::PrincipalCurvature {
                direction: Principal::Minor,
                smoothing: 30,
            },
            Frequency::Uniform(frequency.0),
            waves,
        ));
    }
}
