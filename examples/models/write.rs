//! The models as files.
//!
//! In: a folder. Out: `aneurysm.glb` with `_TENSOR_DIAGONAL` and `_TENSOR_OFFDIAGONAL`, `vessels.glb` and `hyperball.glb`
//! with `_FIELD`, `creature.glb` with skin, morph targets and its walk; each below a megabyte.

use bevy::prelude::*;
use std::{fs, path::Path};

use crate::common::{
    aneurysm::Aneurysm,
    creature::{Creature, MORPHS, SKELETON},
    creature_walk::{self, STRIDE},
    glb::{self, Model, Skin},
    hyperball::Hyperball,
    mesh_file::{RawMesh, smooth_normals},
    vessel_tree::VesselTree,
};

/// Key frames of the walk; the last is the first.
const FRAMES: u8 = 25;

/// Writes all files.
///
/// # Errors
///
/// One of them cannot be written.
pub fn write_all(folder: &Path) -> Result<(), String> {
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for (name, bytes) in [
        ("aneurysm", aneurysm()),
        ("vessels", vessels()),
        ("hyperball", hyperball()),
        ("creature", creature()),
    ] {
        let path = folder.join(name).with_extension("glb");
        fs::write(&path, bytes).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}

/// A mesh with attributes and nothing else.
fn plain(name: &str, mesh: &RawMesh, attributes: &[glb::Attribute]) -> Vec<u8> {
    glb::write(&Model {
        name,
        mesh: Some(mesh),
        normals: &smooth_normals(mesh),
        color: LinearRgba::rgb(0.75, 0.7, 0.65),
        attributes,
        ..default()
    })
}

fn aneurysm() -> Vec<u8> {
    let shape = Aneurysm::default();
    let mesh = shape.mesh(0.045);
    let stress = shape.stress(&mesh);
    let diagonal: Vec<Vec3> = stress.iter().map(|t| Vec3::new(t.m00, t.m11, t.m22)).collect();
    let others: Vec<Vec3> = stress.iter().map(|t| Vec3::new(t.m01, t.m12, t.m02)).collect();
    plain(
        "aneurysm",
        &mesh,
        &[("_TENSOR_DIAGONAL", &diagonal), ("_TENSOR_OFFDIAGONAL", &others)],
    )
}

fn vessels() -> Vec<u8> {
    let tree = VesselTree::default();
    let mesh = tree.mesh(0.017);
    let flow: Vec<Vec3> = mesh.positions.iter().map(|&p| tree.flow(p)).collect();
    plain("vessels", &mesh, &[("_FIELD", &flow)])
}

fn hyperball() -> Vec<u8> {
    let shape = Hyperball::default();
    let mesh = shape.mesh(0.04);
    plain("hyperball", &mesh, &[("_FIELD", &shape.cross_field(&mesh))])
}

fn creature() -> Vec<u8> {
    let creature = Creature::generate(0.03);
    let turns = creature.morph_turns();
    let times: Vec<f32> = (0..FRAMES)
        .map(|i| STRIDE * f32::from(i) / f32::from(FRAMES - 1))
        .collect();
    let joints: Vec<_> = SKELETON
        .iter()
        .enumerate()
        .map(|(i, joint)| (joint.name, joint.parent, creature_walk::local_position(i)))
        .collect();
    let rotations: Vec<Vec<Quat>> = (0..SKELETON.len())
        .map(|joint| times.iter().map(|&time| creature_walk::rotation(joint, time)).collect())
        .collect();
    let positions: Vec<Vec3> = times.iter().map(|&time| creature_walk::root_position(time)).collect();
    let weights: Vec<Vec<f32>> = times
        .iter()
        .map(|&time| creature_walk::morph_weights(time).to_vec())
        .collect();
    let morphs: Vec<_> = (0..MORPHS.len())
        .map(|i| (MORPHS[i], creature.morphs[i].as_slice(), turns[i].as_slice()))
        .collect();
    glb::write(&Model {
        name: "creature",
        mesh: Some(&creature.mesh),
        normals: &smooth_normals(&creature.mesh),
        color: LinearRgba::rgb(0.78, 0.45, 0.15),
        attributes: &[("_FIELD", &creature.along)],
        morphs: &morphs,
        skin: Some(Skin {
            joints: &joints,
            inverse_bindposes: &creature_walk::inverse_bindposes(),
            indices: &creature.joints,
            weights: &creature.weights,
            times: &times,
            rotations: &rotations,
            positions: &positions,
            morphs: &weights,
        }),
    })
}
