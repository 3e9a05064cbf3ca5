//! A creature that walks and breathes, twice: skin, morph targets, animation and field come from one glTF file. On the left
//! one stripes stick to the skin and stretch with it; on the right one they keep their distance.
//!
//! ```sh
//! cargo run --example striped_character
//! cargo run --example striped_character -- --screenshot striped_character.png
//! ```

mod common;

use bevy::{
    gltf::GltfAssetLabel,
    prelude::*,
    world_serialization::{WorldAsset, WorldAssetRoot},
};
use bevy_field_patterns::prelude::*;
use common::{
    args::run_moving,
    clock::Clock,
    gltf::{FIELD_ATTRIBUTE, register_scene_types},
    scene::{Subject, View},
};
use std::process::ExitCode;

const MODEL: &str = "models/creature.glb";

/// The animation of the file.
#[derive(Resource)]
struct Walk(Handle<AnimationGraph>, AnimationNodeIndex);

fn main() -> ExitCode {
    run_moving("A striped character", 0.5, 0.2, |app| {
        register_scene_types(app);
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(View(Vec3::new(0.0, 0.25, 1.0)))
            .add_systems(Startup, setup)
            .add_systems(Update, walk);
    })
}

fn setup(mut commands: Commands, server: Res<AssetServer>, mut graphs: ResMut<Assets<AnimationGraph>>) {
    let clip = server.load(GltfAssetLabel::Animation(0).from_asset(MODEL));
    let (graph, node) = AnimationGraph::from_clip(clip);
    commands.insert_resource(Walk(graphs.add(graph), node));
    let scene: Handle<WorldAsset> = server.load(GltfAssetLabel::Scene(0).from_asset(MODEL));
    for (x, turn, pose, color) in [
        (-1.15, 1.1, PatternPose::Rest, Srgba::rgb(0.16, 0.09, 0.05)),
        (1.15, 0.7, PatternPose::Live, Srgba::rgb(0.05, 0.14, 0.22)),
    ] {
        commands.spawn((
            Subject,
            WorldAssetRoot(scene.clone()),
            Transform::from_xyz(x, 0.0, 0.0).with_rotation(Quat::from_rotation_y(turn)),
            PatternScene {
                // Along the limbs, so that stripes lie around them.
                field: DirectionField::Attribute(FIELD_ATTRIBUTE),
                frequency: Frequency::Uniform(8.0),
                pose,
                style: Stripes {
                    color: color.into(),
                    duty: 0.38,
                    softness: 0.1,
                    ..default()
                },
                ..default()
            },
        ));
    }
}

/// Keeps the animation at the clock's time.
fn walk(
    clock: Res<Clock>,
    walk: Res<Walk>,
    mut players: Query<(Entity, &mut AnimationPlayer)>,
    mut commands: Commands,
) {
    for (entity, mut player) in &mut players {
        if !player.is_playing_animation(walk.1) {
            commands.entity(entity).insert(AnimationGraphHandle(walk.0.clone()));
            player.play(walk.1).repeat().set_speed(0.0);
        }
        if let Some(animation) = player.animation_mut(walk.1) {
            animation.seek_to(clock.seconds % common::creature_walk::STRIDE);
        }
    }
}
