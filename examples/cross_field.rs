//! A texture on a cross field: on a surface with seventeen tunnels, tiles that look the same after a quarter turn lie
//! without seams, although no direction could be chosen for all of it.
//!
//! ```sh
//! cargo run --example cross_field
//! cargo run --example cross_field -- --screenshot cross_field.png
//! ```

mod common;

use bevy::{gltf::GltfAssetLabel, prelude::*};
use bevy_field_patterns::prelude::*;
use common::{
    args::run_plain,
    gltf::FIELD_ATTRIBUTE,
    scene::{Subject, View},
};
use std::process::ExitCode;

fn main() -> ExitCode {
    run_plain("Cross field", |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(View(Vec3::new(0.35, 0.3, 1.0)))
            .add_systems(Startup, setup);
    })
}

fn setup(mut commands: Commands, server: Res<AssetServer>, mut textures: ResMut<Assets<PatternTextureMaterial>>) {
    let material = textures.add(PatternTextureMaterial {
        base: StandardMaterial {
            base_color: Color::srgb(0.16, 0.30, 0.42),
            perceptual_roughness: 0.35,
            ..default()
        },
        extension: PatternTexture {
            image: server.load("textures/tiles.png"),
            ..default()
        },
    });
    let ball = GltfAssetLabel::Primitive { mesh: 0, primitive: 0 }.from_asset("models/hyperball.glb");
    commands.spawn((
        Subject,
        Mesh3d(server.load(ball)),
        MeshMaterial3d(material),
        // Good up to quarter turns.
        DirectionField::Attribute(FIELD_ATTRIBUTE),
        Waves::Cross,
        Frequency::Uniform(11.0),
    ));
}
