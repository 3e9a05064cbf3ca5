//! The lining of a blood vessel with an aneurysm: cells stretch along the shear stress of the flow on the wall and are
//! round where the flow comes to rest, as in figures 14 and 15 of Kratz et al. 2013.
//!
//! ```sh
//! cargo run --example endothelium
//! cargo run --example endothelium -- --no-borders --screenshot endothelium.png
//! ```
//!
//! B switches borders on and off, space stops and starts the pulse.
#![allow(unreachable_pub, reason = "modules of one program")]

#[path = "../common/mod.rs"]
mod common;
mod nuclei;

use bevy::prelude::*;
use bevy_field_patterns::{prelude::*, sampling::MetricSource};
use clap::Parser;
use common::{
    args::{OutputArgs, run},
    mesh_file::to_bevy_mesh,
    scene::Subject,
    vessel::Vessel,
};
use std::process::ExitCode;

/// Cells on the wall of a vessel, aligned with the shear stress of the flow.
#[derive(Parser)]
struct Cli {
    /// Number of cells
    #[arg(long, default_value_t = 3000, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    count: u32,
    /// Length of a cell over its width where the flow is fast, 1 to 20
    #[arg(long, default_value_t = 4.0, value_parser = parse_ratio)]
    ratio: f32,
    /// Leave the borders out
    #[arg(long)]
    no_borders: bool,
    #[command(flatten)]
    output: OutputArgs,
}

fn parse_ratio(text: &str) -> Result<f32, String> {
    let ratio = text.parse().ok().filter(|ratio| (1.0..=20.0).contains(ratio));
    ratio.ok_or_else(|| "expected a number from 1 to 20".into())
}

/// Beats of the heart per second; slow enough to see.
const PULSE: f32 = 0.2;
/// Beats from one set of samples to the next at most, so that cells keep their places however slow the machine is.
const LONGEST_STEP: f32 = 0.02;

/// The wall that is sampled, and the beat of the heart.
#[derive(Component)]
struct Wall {
    vessel: Vessel,
    ratio: f32,
    /// In beats.
    phase: f32,
    /// Beats since then that the samples have not followed yet.
    behind: f32,
    beating: bool,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    run("Endothelium", &cli.output, |app| {
        let wall = Wall {
            vessel: Vessel::default(),
            ratio: cli.ratio,
            phase: 0.0,
            behind: 0.0,
            beating: cli.output.screenshot.is_none(),
        };
        let (count, borders) = (cli.count, !cli.no_borders);
        let mut wall = Some(wall);
        app.add_plugins(FieldPatternsPlugin)
            .add_systems(
                Startup,
                move |commands: Commands,
                      meshes: ResMut<Assets<Mesh>>,
                      images: ResMut<Assets<Image>>,
                      materials: ResMut<Assets<CellMaterial>>| {
                    if let Some(wall) = wall.take() {
                        setup(commands, meshes, images, materials, wall, count, borders);
                    }
                },
            )
            .add_systems(Update, (beat, switch_borders));
        Ok(())
    })
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut images: ResMut<Assets<Image>>,
    mut materials: ResMut<Assets<CellMaterial>>,
    wall: Wall,
    count: u32,
    borders: bool,
) {
    let material = materials.add(CellMaterial {
        base: StandardMaterial {
            base_color: Color::srgb(0.80, 0.42, 0.36),
            perceptual_roughness: 0.6,
            reflectance: 0.25,
            double_sided: true,
            cull_mode: None,
            ..default()
        },
        extension: Cells {
            fill: CellFill::Palette(tissue()),
            border_width: border_width(borders),
            border_color: LinearRgba::from(Srgba::rgb(0.32, 0.09, 0.09)),
            noise: 0.1,
            rounding: 0.2,
            bump: 0.35,
            bump_width: 0.6,
            jitter: 0.05,
            texture: Some(CellTexture {
                image: images.add(nuclei::atlas()),
                columns: nuclei::TILES,
                radius: 1.2,
                ..default()
            }),
            ..default()
        },
    });
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(to_bevy_mesh(&wall.vessel.mesh()))),
        MeshMaterial3d(material),
        AnisotropicSamples {
            metric: metric(&wall),
            density: Density::Count(count),
            // Cells grow and turn with the pulse; they are not laid anew.
            follow: true,
            ..default()
        },
        wall,
    ));
}

/// Cells lie along the shear stress; the stress of the healthy vessel stretches them fully.
fn metric(wall: &Wall) -> Metric {
    Metric::new(MetricSource::Vectors {
        vectors: wall.vessel.wall_shear_stress(wall.phase).into(),
        ratio: wall.ratio,
        full_length: 0.8,
    })
}

fn tissue() -> Vec<LinearRgba> {
    [
        (0.90, 0.56, 0.48),
        (0.84, 0.46, 0.40),
        (0.93, 0.64, 0.55),
        (0.79, 0.41, 0.37),
    ]
    .map(|(r, g, b)| LinearRgba::from(Srgba::rgb(r, g, b)))
    .to_vec()
}

fn border_width(borders: bool) -> BorderWidth {
    BorderWidth::Relative(if borders { 0.12 } else { 0.0 })
}

/// Samples anew, as soon as the last samples are there, for the flow of the moment.
fn beat(
    mut walls: Query<(&mut Wall, &mut AnisotropicSamples, &SamplingState)>,
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
) {
    for (mut wall, mut samples, state) in &mut walls {
        if keys.just_pressed(KeyCode::Space) {
            wall.beating = !wall.beating;
        }
        if !wall.beating {
            continue;
        }
        wall.behind += PULSE * time.delta_secs();
        if *state == SamplingState::Ready {
            wall.phase = (wall.phase + wall.behind.min(LONGEST_STEP)).fract();
            wall.behind = 0.0;
            samples.metric = metric(&wall);
        }
    }
}

fn switch_borders(keys: Res<ButtonInput<KeyCode>>, mut materials: ResMut<Assets<CellMaterial>>) {
    if keys.just_pressed(KeyCode::KeyB) {
        for (_, material) in materials.iter_mut() {
            let none = material.extension.border_width == border_width(false);
            material.extension.border_width = border_width(none);
        }
    }
}
