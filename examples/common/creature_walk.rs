//! The creature's walk, and the creature in a Bevy world.
//!
//! In: a time, or a [`Creature`]. Out: where each joint is turned and how much each morph target weighs, once around per
//! [`STRIDE`]; or a mesh, entities for the joints and a system that moves them.

use bevy::{
    camera::visibility::DynamicSkinnedMeshBounds,
    mesh::{
        VertexAttributeValues,
        morph::{MeshMorphWeights, MorphAttributes},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};
use std::f32::consts::TAU;

use super::{
    creature::{Creature, MORPHS, SKELETON},
    mesh_file::to_bevy_mesh,
};

/// Seconds until all four feet have made one step.
pub const STRIDE: f32 = 1.6;

/// Where a joint is turned, in its parent's axes; the root also moves.
pub fn rotation(joint: usize, seconds: f32) -> Quat {
    let phase = TAU * seconds / STRIDE;
    let name = SKELETON[joint].name;
    // A walk: one foot after the other, hind left, fore left, hind right, fore right.
    let step = phase
        + TAU
            * match name.split_once('.') {
                Some(("hindleg", side)) => {
                    if side.starts_with("left") {
                        0.0
                    } else {
                        0.5
                    }
                }
                Some(("foreleg", side)) => {
                    if side.starts_with("left") {
                        0.75
                    } else {
                        0.25
                    }
                }
                _ => 0.0,
            };
    let lift = step.cos().max(0.0).powi(2);
    let (fore, segment) = (name.starts_with("foreleg"), name.rsplit('.').next().unwrap_or_default());
    let [x, y, z] = match (name, segment) {
        ("pelvis", _) => [0.0, 0.05 * phase.sin(), 0.035 * phase.cos()],
        ("spine", _) => [0.02 * (2.0 * phase).sin(), -0.08 * phase.sin(), 0.0],
        ("chest", _) => [0.0, -0.05 * phase.sin(), -0.03 * phase.cos()],
        ("neck", _) => [0.06 * (2.0 * phase + 0.6).sin(), 0.07 * phase.sin(), 0.0],
        ("head", _) => [0.05 * (2.0 * phase).cos(), 0.05 * phase.sin(), 0.0],
        ("ear.left" | "ear.right", _) => [0.1 * (2.0 * phase + 1.0).sin(), 0.0, 0.0],
        ("tail.1" | "tail.2" | "tail.3", segment) => {
            let late = 0.7 * f32::from(segment.as_bytes()[0] - b'0');
            [0.06 * (2.0 * phase - late).cos(), 0.26 * (phase - late).sin(), 0.0]
        }
        // Forwards is a negative turn about x.
        (_, "1") => [-0.38 * step.sin() - 0.1 * lift, 0.0, 0.0],
        (_, "2") if fore => [0.15 + 0.85 * lift, 0.0, 0.0],
        (_, "2") => [-0.05 + 0.55 * lift, 0.0, 0.0],
        (_, "3") => [0.3 * step.sin() - 0.1 + if fore { 0.5 } else { -0.3 } * lift, 0.0, 0.0],
        _ => [0.0; 3],
    };
    Quat::from_euler(EulerRot::YXZ, y, x, z)
}

/// Where the root is, from its parent.
pub fn root_position(seconds: f32) -> Vec3 {
    let phase = TAU * seconds / STRIDE;
    SKELETON[0].position + Vec3::new(0.012 * phase.sin(), -0.03 + 0.012 * (2.0 * phase).cos(), 0.0)
}

/// The weights of the [`MORPHS`]: two breaths per stride, ears that perk up once.
pub fn morph_weights(seconds: f32) -> [f32; MORPHS.len()] {
    let phase = TAU * seconds / STRIDE;
    [0.5 - 0.5 * phase.cos(), 0.5 + 0.5 * (phase + 1.0).sin()]
}

/// Where a joint is in its parent's axes.
pub fn local_position(joint: usize) -> Vec3 {
    let Some(parent) = SKELETON[joint].parent else {
        return SKELETON[joint].position;
    };
    SKELETON[joint].position - SKELETON[parent].position
}

/// A mesh with joints, weights, morph targets and smooth normals.
pub fn to_skinned_mesh(creature: &Creature) -> Mesh {
    let mut mesh = to_bevy_mesh(&creature.mesh);
    let targets = creature
        .morphs
        .iter()
        .zip(creature.morph_turns())
        .flat_map(|(moves, turns)| {
            let targets = moves.iter().zip(turns).map(|(&position, normal)| MorphAttributes {
                position,
                normal,
                ..default()
            });
            targets.collect::<Vec<_>>()
        });
    let targets = targets.collect();
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_JOINT_INDEX,
        VertexAttributeValues::Uint16x4(creature.joints.clone()),
    );
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, creature.weights.clone());
    if let Err(error) = mesh.generate_skinned_mesh_bounds() {
        error!("the creature has no bounds: {error}");
    }
    mesh.with_morph_targets(targets)
        .with_morph_target_names(MORPHS.map(String::from).to_vec())
}

/// Undoes the rest pose: a joint only moves there.
pub fn inverse_bindposes() -> Vec<Mat4> {
    SKELETON
        .iter()
        .map(|joint| Mat4::from_translation(-joint.position))
        .collect()
}

/// A creature that walks on the spot.
#[derive(Component, Clone, Debug)]
pub struct Walker {
    /// One entity per joint of [`SKELETON`].
    pub joints: Vec<Entity>,
    /// Seconds since it set out.
    pub time: f32,
    /// How fast time passes for it; 0 stops it.
    pub pace: f32,
}

/// Spawns the joints and the creature with `mesh` (of [`to_skinned_mesh`]); they are children of a new entity at
/// `transform`. Gives the creature, for a material.
pub fn spawn(
    commands: &mut Commands,
    mesh: Handle<Mesh>,
    inverse_bindposes: Handle<SkinnedMeshInverseBindposes>,
    transform: Transform,
) -> Entity {
    let root = commands.spawn((transform, Visibility::default())).id();
    let mut joints: Vec<Entity> = Vec::with_capacity(SKELETON.len());
    for (i, joint) in SKELETON.iter().enumerate() {
        let parent = joint.parent.map_or(root, |parent| joints[parent]);
        let at = Transform::from_translation(local_position(i));
        joints.push(commands.spawn((Name::new(joint.name), at, ChildOf(parent))).id());
    }
    let skin = SkinnedMesh {
        inverse_bindposes,
        joints: joints.clone(),
    };
    let walker = Walker {
        joints,
        time: 0.0,
        pace: 1.0,
    };
    let weights = MeshMorphWeights::Value {
        weights: morph_weights(0.0).to_vec(),
    };
    let body = (Mesh3d(mesh), skin, weights, walker, DynamicSkinnedMeshBounds);
    commands.spawn((body, Transform::default(), ChildOf(root))).id()
}

/// Moves all walkers on.
pub fn walk(
    time: Res<Time>,
    mut walkers: Query<(&mut Walker, &mut MeshMorphWeights)>,
    mut joints: Query<&mut Transform>,
) {
    for (mut walker, mut weights) in &mut walkers {
        walker.time += walker.pace * time.delta_secs();
        *weights = MeshMorphWeights::Value {
            weights: morph_weights(walker.time).to_vec(),
        };
        for (i, &joint) in walker.joints.iter().enumerate() {
            if let Ok(mut transform) = joints.get_mut(joint) {
                transform.rotation = rotation(i, walker.time);
                if i == 0 {
                    transform.translation = root_position(walker.time);
                }
            }
        }
    }
}
