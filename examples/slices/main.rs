//! Scrolls through a volume: on each slice, cells and ellipses lie along the volume's structure, and keep their identity
//! from slice to slice.
//!
//! ```sh
//! cargo run --example slices
//! cargo run --example slices -- --depth 0.3 --screenshot slices.png
//! ```
//!
//! The arrow keys scroll by hand, space stops and goes on, E switches between cells and ellipses.
#![allow(unreachable_pub, reason = "modules of one program")]

#[path = "../common/mod.rs"]
mod common;

use bevy::{math::DVec2, prelude::*};
use bevy_field_patterns::{
    prelude::*,
    sampling::{
        metric::{MetricVolume, Slice, Structure},
        planar::{PlanarDomain, PlanarSampling, SliceSampler},
    },
};
use clap::Parser;
use common::{
    args::{OutputArgs, run_on},
    flat::FlatPlugin,
};
use std::process::ExitCode;

/// Scrolls through a generated volume with coherent anisotropic cells.
#[derive(Parser)]
struct Cli {
    /// Number of cells
    #[arg(long, default_value_t = 2500, value_parser = clap::value_parser!(u32).range(1..=50_000))]
    count: u32,
    /// Where to begin, 0 to 1
    #[arg(long, default_value_t = 0.5, value_parser = parse_depth)]
    depth: f32,
    /// Draw ellipses in place of cells
    #[arg(long)]
    ellipses: bool,
    #[command(flatten)]
    output: OutputArgs,
}

fn parse_depth(text: &str) -> Result<f32, String> {
    let depth = text.parse().ok().filter(|depth| (0.0..=1.0).contains(depth));
    depth.ok_or_else(|| "expected a number from 0 to 1".into())
}

/// Half the side of the volume.
const HALF: f32 = 1.0;
/// Grid points along each side of the volume.
const POINTS: u32 = 72;
/// How fast the slice moves, in sides of the volume per second.
const SPEED: f32 = 0.04;
/// Seconds from slice to slice at most, so that cells keep their places however slow the machine is.
const LONGEST_STEP: f32 = 0.05;
/// Relaxation steps per slice.
const STEPS: u32 = 5;

/// What is scrolled through, and how far.
#[derive(Resource)]
struct Scroll {
    volume: MetricVolume,
    sampler: SliceSampler,
    depth: f32,
    running: bool,
}

/// The slice.
#[derive(Component)]
struct Shown;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let stage = FlatPlugin {
        shown: Rect::from_center_half_size(Vec2::ZERO, Vec2::splat(HALF)),
    };
    run_on(stage, "Slices", &cli.output, |app| {
        let volume = volume().map_err(|error| error.to_string())?;
        let domain = PlanarDomain::Rectangle {
            min: DVec2::splat(-f64::from(HALF)),
            max: DVec2::splat(f64::from(HALF)),
        };
        let options = PlanarSampling {
            density: Density::Count(cli.count),
            ..default()
        };
        let sampler = SliceSampler::new(&domain, &on_slice(&volume, cli.depth), &options);
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(Scroll {
                sampler: sampler.map_err(|error| error.to_string())?,
                volume,
                depth: cli.depth,
                running: cli.output.screenshot.is_none(),
            })
            .add_systems(
                Startup,
                move |commands: Commands, materials: ResMut<Assets<CellMaterial2d>>| {
                    show(commands, materials, cli.ellipses);
                },
            )
            .add_systems(Update, (steer, scroll, switch_shape).chain());
        Ok(())
    })
}

/// Two interwoven labyrinths, stretched around a knot of denser tissue.
fn volume() -> Result<MetricVolume, PatternError> {
    let size = UVec3::splat(POINTS);
    let scalars: Vec<f32> = (0..POINTS.pow(3))
        .map(|i| {
            let voxel = UVec3::new(i % POINTS, i / POINTS % POINTS, i / (POINTS * POINTS)).as_vec3();
            let p = (voxel / (POINTS - 1) as f32 * 2.0 - 1.0) * HALF;
            let q = 5.0 * p + Vec3::new(0.0, 0.0, 1.5 * (2.0 * p.x).sin());
            let gyroid = q.x.sin() * q.y.cos() + q.y.sin() * q.z.cos() + q.z.sin() * q.x.cos();
            let knot =
                (-4.0 * (p - Vec3::new(0.3 * (3.0 * p.z).cos(), 0.3 * (3.0 * p.z).sin(), p.z)).length_squared()).exp();
            gyroid + 2.5 * knot
        })
        .collect();
    let structure = Structure {
        ratio: 5.0,
        detail: 0.8,
        reach: 2.0,
    };
    MetricVolume::from_scalars(Vec3::splat(-HALF), Vec3::splat(HALF), size, &scalars, &structure)
}

/// The metric of the slice at a depth of 0 to 1.
fn on_slice(volume: &MetricVolume, depth: f32) -> impl Fn(DVec2) -> glam_matrix_extras::SymmetricDMat2 + Sync {
    let slice = Slice {
        origin: Vec3::new(0.0, 0.0, (2.0 * depth - 1.0) * HALF),
        u: Dir3::X,
        v: Dir3::Y,
    };
    move |p| volume.on_slice(&slice, p)
}

fn steer(mut scroll: ResMut<Scroll>, keys: Res<ButtonInput<KeyCode>>, time: Res<Time>) {
    if keys.just_pressed(KeyCode::Space) {
        scroll.running = !scroll.running;
    }
    let by_hand = f32::from(keys.pressed(KeyCode::ArrowUp)) - f32::from(keys.pressed(KeyCode::ArrowDown));
    let speed = if scroll.running { SPEED } else { 0.0 } + 3.0 * SPEED * by_hand;
    if speed != 0.0 {
        scroll.depth = (scroll.depth + speed * time.delta_secs().min(LONGEST_STEP)).rem_euclid(1.0);
    }
}

/// Takes the sampler along to the slice.
fn scroll(mut scroll: ResMut<Scroll>, mut shown: Query<&mut SampleSet, With<Shown>>, mut seen: Local<Option<f32>>) {
    if *seen == Some(scroll.depth) {
        return;
    }
    let Scroll {
        volume, sampler, depth, ..
    } = &mut *scroll;
    if let Err(error) = sampler.advance(&on_slice(volume, *depth), STEPS) {
        error!("the slice at {depth}: {error}");
        return;
    }
    *seen = Some(*depth);
    for mut set in &mut shown {
        *set = sampler.samples().set();
    }
}

/// One entity whose samples are replaced from slice to slice.
fn show(mut commands: Commands, mut materials: ResMut<Assets<CellMaterial2d>>, ellipses: bool) {
    let cells = Cells {
        fill: CellFill::Palette(
            [
                (0.80, 0.62, 0.42),
                (0.66, 0.36, 0.27),
                (0.35, 0.43, 0.47),
                (0.86, 0.79, 0.66),
                (0.52, 0.55, 0.45),
            ]
            .map(|(r, g, b)| LinearRgba::from(Srgba::rgb(r, g, b)))
            .to_vec(),
        ),
        shape: if ellipses {
            CellShape::Ellipse { radius: 0.9 }
        } else {
            CellShape::Voronoi
        },
        border_width: BorderWidth::Relative(0.14),
        rounding: 0.15,
        ..default()
    };
    let material = materials.add(CellMaterial2d {
        color: Color::srgb(0.12, 0.11, 0.12),
        cells,
        ..default()
    });
    commands.spawn((Shown, SampleSet::default(), MeshMaterial2d(material)));
}

/// E: cells or ellipses.
fn switch_shape(keys: Res<ButtonInput<KeyCode>>, mut materials: ResMut<Assets<CellMaterial2d>>) {
    if keys.just_pressed(KeyCode::KeyE) {
        for (_, material) in materials.iter_mut() {
            material.cells.shape = match material.cells.shape {
                CellShape::Ellipse { .. } => CellShape::Voronoi,
                _ => CellShape::Ellipse { radius: 0.9 },
            };
        }
    }
}
