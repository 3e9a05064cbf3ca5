//! A point cloud: no triangles, only points, as a scanner brings them, drawn as oriented discs. Normals and curvature are
//! fitted to the points; the stripes follow the curvature.
//!
//! ```sh
//! cargo run --example point_cloud
//! cargo run --example point_cloud -- --screenshot point_cloud.png
//! ```

mod common;

use std::process::ExitCode;

use bevy::{asset::RenderAssetUsages, mesh::PrimitiveTopology, prelude::*};
use bevy_field_patterns::prelude::*;
use common::{args::run_plain, scene::Subject, shapes};

fn main() -> ExitCode {
    run_plain("Point cloud", |app| {
        app.add_plugins(FieldPatternsPlugin).add_systems(Startup, setup);
    })
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut stripes: ResMut<Assets<StripeMaterial>>) {
    // A knot's vertices, of which only the places are kept.
    let points = shapes::knot(700, 56).positions;
    let cloud = Mesh::new(PrimitiveTopology::PointList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, points);
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(cloud)),
        MeshMaterial3d(stripes.add(StripeMaterial {
            base: StandardMaterial {
                base_color: Color::srgb(0.95, 0.93, 0.88),
                perceptual_roughness: 0.6,
                ..default()
            },
            extension: Stripes {
                color: Color::srgb(0.55, 0.12, 0.16).into(),
                ..default()
            },
        })),
        DirectionField::default(),
        Frequency::Uniform(12.0),
    ));
}
