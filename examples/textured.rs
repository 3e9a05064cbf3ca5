//! Images on two waves, each on a field of its own symmetry.
//!
//! ```sh
//! cargo run --example textured -- arrows
//! cargo run --example textured -- tiles --screenshot tiles.png
//! ```

mod common;

use std::process::ExitCode;

use bevy::prelude::*;
use bevy_field_patterns::{field::Principal, prelude::*};
use clap::{Parser, ValueEnum};
use common::{
    args::{OutputArgs, run},
    mesh_file::to_bevy_mesh,
    scene::Subject,
    shapes,
};

/// Images that follow a field.
#[derive(Parser)]
struct Args {
    /// What to draw
    #[arg(default_value = "arrows")]
    look: Look,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Look {
    /// Arrows that travel along a vector field
    Arrows,
    /// Chevrons on a vector field, raised
    Chevrons,
    /// A quiet texture for flow
    Streaks,
    /// Cloth along a line field
    Weave,
    /// Leaves along a line field
    Twist,
    /// Tiles on a cross field
    Tiles,
    /// Pinwheels on a cross field
    Pinwheel,
    /// Arrows cut out of a shell
    Cutout,
    /// Arrows in a focus, streaks elsewhere, coloured by the distance from it
    Flow,
    /// Signs of a scalar: minus, dot, plus, one for each cell
    Patches,
}

fn main() -> ExitCode {
    let args = Args::parse();
    run("Images on two waves", &args.output, |app| {
        let look = args.look;
        let setup = move |commands: Commands,
                          assets: Res<AssetServer>,
                          meshes: ResMut<Assets<Mesh>>,
                          materials: ResMut<Assets<PatternTextureMaterial>>| {
            spawn(look, commands, assets, meshes, materials);
        };
        app.add_plugins(FieldPatternsPlugin).add_systems(Startup, setup);
        Ok(())
    })
}

fn spawn(
    look: Look,
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<PatternTextureMaterial>>,
) {
    let image = |name: &str| assets.load(format!("textures/{name}.png"));
    let ink = LinearRgba::rgb(0.02, 0.06, 0.16);
    let curvature = |direction| DirectionField::PrincipalCurvature {
        direction,
        smoothing: 30,
    };
    let axis = DirectionField::Axis(Dir3::new(Vec3::new(0.15, 1.0, 0.1)).unwrap_or(Dir3::Y));
    let style = |name: &str, tint: LinearRgba| PatternTexture {
        image: image(name),
        tint,
        ..default()
    };
    let moving = |name: &str| PatternTexture {
        travel: Travel::Periods(0.3),
        ..style(name, ink)
    };
    let white = LinearRgba::WHITE;
    let mesh = shapes::knot(480, 42);
    let scalars = |scalar: fn(Vec3) -> f32| PatternScalars {
        first: ScalarSource::Vertices(mesh.positions.iter().map(|&p| scalar(p)).collect()),
        ..default()
    };
    let scalars = match look {
        Look::Flow => scalars(|p| p.distance(Vec3::new(0.6, 0.5, 0.6))),
        Look::Patches => scalars(|p| (2.2 * p.x).sin() * (2.0 * p.y + 1.0).cos()),
        _ => PatternScalars::default(),
    };
    // Which waves and which symmetry an image fits is told at `PatternTextureMaterial`.
    let (field, symmetry, waves, extension) = match look {
        Look::Arrows => (axis, Symmetry::Vector, Waves::ORTHOGONAL, moving("arrow")),
        Look::Streaks => (
            axis,
            Symmetry::Vector,
            Waves::Orthogonal { ratio: 1.6 },
            moving("streaks"),
        ),
        Look::Chevrons => {
            let raised = PatternTexture {
                drive: PatternDrive {
                    bump: 0.012,
                    roughness: -0.2,
                    ..default()
                },
                ..moving("chevrons")
            };
            (axis, Symmetry::Vector, Waves::ORTHOGONAL, raised)
        }
        Look::Cutout => {
            let cut = PatternTexture {
                cutout: true,
                ..moving("arrow")
            };
            (axis, Symmetry::Vector, Waves::ORTHOGONAL, cut)
        }
        Look::Flow => {
            let fading = PatternTexture {
                fade: Some(TextureFade {
                    image: Some(image("streaks")),
                    begin: 0.7,
                    end: 1.2,
                    ..default()
                }),
                color: Some(ScalarColor {
                    map: ColorMap::Viridis,
                    high: 2.5,
                    ..default()
                }),
                tint: white,
                ..moving("arrow")
            };
            (axis, Symmetry::Vector, Waves::ORTHOGONAL, fading)
        }
        Look::Patches => {
            let chosen = PatternTexture {
                patches: Some(Patches {
                    columns: 3,
                    low: -0.6,
                    high: 0.6,
                    ..default()
                }),
                ..style("patches", white)
            };
            (axis, Symmetry::Line, Waves::ORTHOGONAL, chosen)
        }
        Look::Weave => (
            curvature(Principal::Minor),
            Symmetry::Line,
            Waves::ORTHOGONAL,
            style("weave", white),
        ),
        Look::Twist => (
            curvature(Principal::Minor),
            Symmetry::Line,
            Waves::ORTHOGONAL,
            style("twist", white),
        ),
        Look::Tiles => (
            curvature(Principal::Minor),
            Symmetry::Line,
            Waves::Cross,
            style("tiles", white),
        ),
        Look::Pinwheel => (
            curvature(Principal::Minor),
            Symmetry::Line,
            Waves::Cross,
            style("pinwheel", white),
        ),
    };
    let base = StandardMaterial {
        base_color: Color::srgb(0.88, 0.86, 0.82),
        perceptual_roughness: 0.6,
        double_sided: look == Look::Cutout,
        cull_mode: if look == Look::Cutout {
            None
        } else {
            StandardMaterial::default().cull_mode
        },
        ..default()
    };
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(to_bevy_mesh(&mesh))),
        MeshMaterial3d(materials.add(PatternTextureMaterial { base, extension })),
        field,
        symmetry,
        waves,
        scalars,
        Frequency::Uniform(6.0),
    ));
}
