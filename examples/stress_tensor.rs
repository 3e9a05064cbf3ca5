//! The stress in the wall of an aneurysm: stripes run along the largest stress; green stripes show how large it is, orange
//! ones the second, by colour and width. When the camera comes nearer there are more of them.
//!
//! ```sh
//! cargo run --example stress_tensor
//! cargo run --example stress_tensor -- --screenshot stress_tensor.png
//! ```

mod common;

use bevy::{gltf::GltfAssetLabel, prelude::*};
use bevy_field_patterns::{
    material::{Eigenvalue, Tensor, TensorMaterial},
    prelude::*,
};
use common::{
    args::run_plain,
    gltf::{TENSOR_DIAGONAL_ATTRIBUTE, TENSOR_OFFDIAGONAL_ATTRIBUTE},
    scene::{StudioCamera, Subject, View},
};
use std::{f32::consts::FRAC_PI_2, process::ExitCode};

fn main() -> ExitCode {
    run_plain("Stress tensor", |app| {
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(View(Vec3::new(0.3, 0.2, 1.0)))
            .add_systems(PostStartup, setup);
    })
}

fn setup(
    mut commands: Commands,
    server: Res<AssetServer>,
    camera: Single<Entity, With<StudioCamera>>,
    mut materials: ResMut<Assets<TensorMaterial>>,
) {
    // In the unit of the stress along the healthy artery; around it the stress is twice that.
    let material = materials.add(TensorMaterial {
        base: StandardMaterial {
            base_color: Color::srgb(0.94, 0.92, 0.89),
            perceptual_roughness: 0.6,
            double_sided: true,
            cull_mode: None,
            ..default()
        },
        extension: Tensor {
            first: Eigenvalue::default().with_range(1.5, 4.5).with_limit(3.6),
            second: Eigenvalue::SECOND.with_range(0.8, 3.0).with_limit(2.6),
            ..default()
        },
    });
    let artery = GltfAssetLabel::Primitive { mesh: 0, primitive: 0 }.from_asset("models/aneurysm.glb");
    commands.spawn((
        Subject,
        Mesh3d(server.load(artery)),
        MeshMaterial3d(material),
        DirectionField::Tensor(TensorField {
            diagonal: TENSOR_DIAGONAL_ATTRIBUTE,
            off_diagonal: TENSOR_OFFDIAGONAL_ATTRIBUTE,
            ..default()
        }),
        // Stripes lie across the field.
        FieldTurn(FRAC_PI_2),
        Frequency::Screen {
            camera: *camera,
            pixels: 24.0,
            hysteresis: 0.25,
        },
    ));
}
