//! Makes a mosaic of an image: stones that lie along its edges, small where much happens, each of one colour.
//!
//! ```sh
//! cargo run --example mosaic -- photo.jpg
//! cargo run --example mosaic -- --ratio 5 --screenshot mosaic.png
//! ```
#![allow(unreachable_pub, reason = "modules of one program")]

#[path = "../common/mod.rs"]
mod common;
mod file;
mod painting;
mod panel;

use bevy::{math::DVec2, prelude::*};
use bevy_field_patterns::{
    prelude::*,
    sampling::{metric::Structure, planar::PlanarDomain},
};
use clap::Parser;
use common::{
    args::{OutputArgs, run_on},
    flat::FlatPlugin,
};
use std::{path::PathBuf, process::ExitCode};

/// Makes a mosaic of an image.
#[derive(Parser)]
struct Cli {
    /// PNG or JPEG file; a built-in painting without it
    image: Option<PathBuf>,
    /// Number of stones
    #[arg(long, default_value_t = 6000, value_parser = clap::value_parser!(u32).range(1..=200_000))]
    count: u32,
    /// Length of the longest stones over their width, 1 to 20
    #[arg(long, default_value_t = 4.0, value_parser = |text: &str| number(text, 1.0, 20.0))]
    ratio: f32,
    /// How much smaller stones are at edges, 0 (not at all) to 5
    #[arg(long, default_value_t = 1.5, value_parser = |text: &str| number(text, 0.0, 5.0))]
    detail: f32,
    /// How many more stones lie in bright places, 0 (not more) to 1
    #[arg(long, default_value_t = 0.0, value_parser = |text: &str| number(text, 0.0, 1.0))]
    importance: f32,
    #[command(flatten)]
    output: OutputArgs,
}

fn number(text: &str, least: f32, most: f32) -> Result<f32, String> {
    let number = text.parse().ok().filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| format!("expected a number from {least} to {most}"))
}

/// The wishes of the user, changed by the panel.
#[derive(Resource, Clone, Copy, PartialEq)]
struct Wishes {
    count: u32,
    ratio: f32,
    detail: f32,
    importance: f32,
    joint: f32,
}

/// The image that the mosaic is made of.
#[derive(Resource)]
struct Model(Handle<Image>);

/// Height of the mosaic; its width is that of the image in proportion.
const HEIGHT: f32 = 1.0;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let image = match cli
        .image
        .as_ref()
        .map_or_else(|| Ok(painting::evening()), |path| file::open(path))
    {
        Ok(image) => image,
        Err(message) => return common::args::refuse(&message),
    };
    let size = Vec2::new(HEIGHT * image.aspect_ratio().ratio(), HEIGHT);
    let stage = FlatPlugin {
        shown: Rect::from_corners(Vec2::ZERO, size),
    };
    run_on(stage, "Mosaic", &cli.output, |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(Wishes {
                count: cli.count,
                ratio: cli.ratio,
                detail: cli.detail,
                importance: cli.importance,
                joint: 0.1,
            })
            .add_systems(Startup, move |commands: Commands, images: ResMut<Assets<Image>>| {
                lay(commands, images, image.clone(), size);
            })
            .add_systems(Update, take_wishes.run_if(resource_changed::<Wishes>))
            .add_observer(colour);
        if cli.output.screenshot.is_none() {
            app.add_plugins(panel::PanelPlugin);
        }
        Ok(())
    })
}

/// The mosaic, as yet without stones.
fn lay(mut commands: Commands, mut images: ResMut<Assets<Image>>, image: Image, size: Vec2) {
    let domain = PlanarDomain::Rectangle {
        min: DVec2::ZERO,
        max: size.as_dvec2(),
    };
    commands.insert_resource(Model(images.add(image)));
    commands.spawn((domain, MeshMaterial2d::<CellMaterial2d>::default()));
}

fn take_wishes(
    wishes: Res<Wishes>,
    model: Res<Model>,
    mosaics: Query<Entity, With<PlanarDomain>>,
    mut materials: ResMut<Assets<CellMaterial2d>>,
    mut before: Local<Option<Wishes>>,
    mut commands: Commands,
) {
    for mosaic in &mosaics {
        let material = materials.add(CellMaterial2d {
            color: Color::srgb(0.20, 0.19, 0.18),
            cells: Cells {
                fill: CellFill::Values,
                border_width: BorderWidth::Relative(wishes.joint),
                border_color: LinearRgba::from(Srgba::rgb(0.20, 0.19, 0.18)),
                rounding: 0.12,
                jitter: 0.1,
                ..default()
            },
            ..default()
        });
        commands.entity(mosaic).insert(MeshMaterial2d(material));
        // Joints alone need no other stones.
        let same = |before: Wishes| {
            Wishes {
                joint: wishes.joint,
                ..before
            } == *wishes
        };
        if before.is_some_and(same) {
            continue;
        }
        let importance = match wishes.importance {
            0.0 => Importance::Uniform,
            strength => Importance::Image {
                image: model.0.clone(),
                floor: (1.0 - strength).max(0.02),
            },
        };
        commands.entity(mosaic).insert(AnisotropicSamples {
            metric: Metric {
                importance,
                ..Metric::new(MetricSource::Image {
                    image: model.0.clone(),
                    structure: Structure {
                        ratio: wishes.ratio,
                        detail: wishes.detail,
                        reach: 3.0,
                    },
                })
            },
            density: Density::Count(wishes.count),
            ..default()
        });
    }
    *before = Some(*wishes);
}

/// Gives every stone the colour of the image under it.
fn colour(
    ready: On<SamplesReady>,
    mosaics: Query<(&SampleSet, &PlanarDomain)>,
    model: Res<Model>,
    images: Res<Assets<Image>>,
    mut commands: Commands,
) {
    let (Ok((set, domain)), Some(image)) = (mosaics.get(ready.entity), images.get(&model.0)) else {
        return;
    };
    let (min, max) = domain.bounds();
    let uvs = set.positions.iter().map(|p| {
        let uv = (p.truncate() - min.as_vec2()) / (max - min).as_vec2();
        Vec2::new(uv.x, 1.0 - uv.y)
    });
    match SampleValues::from_image(image, uvs) {
        Some(values) => {
            commands.entity(ready.entity).insert(values);
        }
        None => error!("the image cannot be read"),
    }
}
