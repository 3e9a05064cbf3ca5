//! Meshes that move and meshes that share a material: skins, morph targets, instances.

use bevy::{
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
    mesh::{
        VertexAttributeValues,
        morph::{MeshMorphWeights, MorphAttributes},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};

use crate::{
    Scene,
    looks::{self, Look},
    square_on,
    stage::{Lens, Picture},
};

fn unlit() -> StandardMaterial {
    StandardMaterial {
        unlit: true,
        ..default()
    }
}

/// A skin that leaves the mesh in its place, a morph target that moves it: every style stays on the surface.
pub fn skins_and_morph_targets_draw(scene: &mut Scene) {
    for look in looks::plain(scene) {
        let plain = scene.stage.bare(&scene.woven_mesh, scene.woven[0], Transform::IDENTITY);
        look.wear(&mut scene.stage, &unlit(), &[plain]);
        let expected = scene.stage.picture(square_on(64));
        scene.stage.clear([plain]);
        assert!(expected.contrast() > 0.1, "{}: nothing drawn", look.name);
        for (skin, morph) in [(true, false), (false, true), (true, true)] {
            let picture = posed(scene, &look, skin, morph);
            let differs = |k: &usize| (picture.pixels[*k] - expected.pixels[*k]).length() > 0.05;
            let apart = (0..64 * 64).filter(differs).count();
            let what = format!("{} skinned {skin} morphed {morph}", look.name);
            picture.save(&what);
            assert!(apart < 64, "{what}: {apart} pixels differ");
        }
    }
}

/// The plane as it was, by other means: a morph target moves it by half a unit to the left, the entity moves it back.
fn posed(scene: &mut Scene, look: &Look, skin: bool, morph: bool) -> Picture {
    let meshes = scene.stage.app.world().resource::<Assets<Mesh>>();
    let mut mesh = meshes.get(&scene.woven_mesh).unwrap().clone();
    let corners = mesh.count_vertices();
    if skin {
        let joints = VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; corners]);
        mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints);
        mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[0.5_f32, 0.5, 0.0, 0.0]; corners]);
    }
    if morph {
        let left = MorphAttributes::new(Vec3::new(-0.5, 0.0, 0.0), Vec3::ZERO, Vec3::ZERO);
        mesh.set_morph_targets(vec![left; corners]);
    }
    let mesh = scene.stage.add(mesh);
    let back = Transform::from_xyz(if morph { 0.5 } else { 0.0 }, 0.0, 0.0);
    let body = scene.stage.bare(&mesh, scene.woven[0], back);
    let mut spawned = vec![body];
    if skin {
        let poses = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]);
        let inverse_bindposes = scene.stage.add(poses);
        let joints: Vec<Entity> = (0..2).map(|_| scene.stage.app.world_mut().spawn(back).id()).collect();
        spawned.extend(&joints);
        let skin = SkinnedMesh {
            inverse_bindposes,
            joints,
        };
        scene.stage.app.world_mut().entity_mut(body).insert(skin);
    }
    if morph {
        let weights = MeshMorphWeights::Value { weights: vec![1.0] };
        scene.stage.app.world_mut().entity_mut(body).insert(weights);
    }
    let (camera, target) = scene.stage.camera(square_on(64));
    let prepass = (DepthPrepass, NormalPrepass, MotionVectorPrepass);
    scene.stage.app.world_mut().entity_mut(camera).insert(prepass);
    look.wear(&mut scene.stage, &unlit(), &[body]);
    spawned.extend([camera, scene.stage.sun(Vec3::new(1.0, 2.0, 3.0), true)]);
    scene.stage.settle();
    let picture = scene.stage.read(&target);
    scene.stage.clear(spawned);
    picture
}

/// One mesh and one material, two tags in one picture: two patterns, each as it is alone.
pub fn instances_share_a_material(scene: &mut Scene) {
    let lens = Lens {
        width: 128,
        ..square_on(64)
    };
    let places = [-1.0, 1.0].map(|x| Transform::from_xyz(x, 0.0, 0.0));
    for look in looks::plain(scene) {
        let spawn = |scene: &mut Scene, k: usize| scene.stage.bare(&scene.woven_mesh, scene.woven[k], places[k]);
        let alone = [0, 1].map(|k| {
            let body = spawn(scene, k);
            look.wear(&mut scene.stage, &unlit(), &[body]);
            let picture = scene.stage.picture(lens);
            scene.stage.clear([body]);
            picture
        });
        let bodies = [0, 1].map(|k| spawn(scene, k));
        look.wear(&mut scene.stage, &unlit(), &bodies);
        let both = scene.stage.picture(lens);
        both.save(&format!("{} instances", look.name));
        scene.stage.clear(bodies);
        let (mut apart, mut other) = (0.0_f32, 0.0_f32);
        for (k, pixel) in both.pixels.iter().enumerate() {
            let side = usize::from(k % 128 >= 64);
            let mirrored = if side == 0 { k + 64 } else { k - 64 };
            apart = apart.max((*pixel - alone[side].pixels[k]).abs().max_element());
            other = other.max((*pixel - alone[1 - side].pixels[mirrored]).abs().max_element());
        }
        assert!(apart < 2e-3, "{}: {apart} off the picture of one alone", look.name);
        assert!(other > 0.5, "{}: both have one pattern", look.name);
    }
}
