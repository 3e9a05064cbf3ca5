//! Every way Bevy draws a mesh: prepasses, deferred, multisampling, shadows, skins and morph targets.

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    material::OpaqueRendererMethod,
    mesh::{
        VertexAttributeValues,
        morph::{MeshMorphWeights, MorphAttributes},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
};
use bevy_field_patterns::material::*;

use crate::{Scene, black_on_white, square_on, stage::Lens, torus_view, unlit};

/// Stripes are drawn, and alike, in every way Bevy can draw them.
pub fn every_pass_draws(scene: &mut Scene) {
    let sun = scene.stage.sun(Vec3::new(1.0, 2.0, 3.0), true);
    let drive = PatternDrive {
        bump: 0.02,
        roughness: 0.1,
        emissive: 0.1,
        ..default()
    };
    let black = Stripes {
        color: LinearRgba::BLACK,
        ..default()
    };
    let bump = Stripes { drive, ..default() };
    let cutout = Stripes {
        cutout: true,
        ..default()
    };
    for (name, stripes) in [("colour", black), ("bump", bump), ("cut-out", cutout)] {
        alike_in_every_pass(scene, name, scene.line, stripes, torus_view(96, 64));
    }
    let mesh = scene.torus_mesh.clone();
    let lens = torus_view(96, 64);
    // Two cameras in one frame.
    let material = scene.stage.add(unlit(black_on_white()));
    let body = scene.stage.body(&mesh, &material, scene.line, Transform::IDENTITY);
    let (first, target) = scene.stage.camera(lens);
    let (second, other_target) = scene.stage.camera(lens);
    scene
        .stage
        .app
        .world_mut()
        .entity_mut(second)
        .get_mut::<Camera>()
        .unwrap()
        .order = 1;
    scene.stage.settle();
    let (one, other) = (scene.stage.read(&target), scene.stage.read(&other_target));
    assert!(one.contrast() > 0.1);
    assert_eq!(one.max_difference(&other), 0.0);
    scene.stage.clear([first, second, body, sun]);
}

/// Draws a style in every way and compares what is seen with the plain forward pass.
pub fn alike_in_every_pass<S: MaterialExtension>(scene: &mut Scene, name: &str, tag: u32, extension: S, lens: Lens) {
    let base = StandardMaterial {
        base_color: Color::WHITE,
        perceptual_roughness: 0.9,
        ..default()
    };
    let mesh = scene.torus_mesh.clone();
    let forward = scene.stage.add(ExtendedMaterial {
        base: base.clone(),
        extension: extension.clone(),
    });
    let deferred_base = StandardMaterial {
        opaque_render_method: OpaqueRendererMethod::Deferred,
        ..base.clone()
    };
    let deferred = scene.stage.add(ExtendedMaterial {
        base: deferred_base,
        extension,
    });
    let body = scene.stage.body(&mesh, &forward, tag, Transform::IDENTITY);
    let expected = scene.stage.picture(lens);
    let mut seen = vec![];
    let mut draw = |scene: &mut Scene, what: &str, lens: Lens, prepass: u32| {
        let (camera, target) = scene.stage.camera(lens);
        let mut camera = scene.stage.app.world_mut().entity_mut(camera);
        if prepass > 0 {
            camera.insert((DepthPrepass, MotionVectorPrepass));
        }
        if prepass == 1 {
            camera.insert(NormalPrepass);
        }
        if prepass == 2 {
            camera.insert(DeferredPrepass);
        }
        let camera = camera.id();
        scene.stage.settle();
        let picture = scene.stage.read(&target);
        scene.stage.clear([camera]);
        picture.save(&format!("{name} {what}"));
        seen.push((what.to_owned(), picture));
    };
    draw(scene, "prepass", lens, 1);
    draw(
        scene,
        "msaa",
        Lens {
            msaa: Msaa::Sample4,
            ..lens
        },
        0,
    );
    draw(
        scene,
        "msaa prepass",
        Lens {
            msaa: Msaa::Sample4,
            ..lens
        },
        1,
    );
    draw(scene, "ldr", Lens { hdr: false, ..lens }, 0);
    scene
        .stage
        .app
        .world_mut()
        .entity_mut(body)
        .insert(MeshMaterial3d(deferred.clone()));
    draw(scene, "deferred", lens, 2);
    scene.stage.clear([body]);
    assert!(expected.contrast() > 0.02, "{name}: nothing drawn");
    for (what, picture) in seen {
        let apart = picture
            .luminance()
            .iter()
            .zip(expected.luminance())
            .map(|(a, b)| (a - b).abs())
            .sum::<f32>()
            / picture.pixels.len() as f32;
        assert!(
            apart < 0.25 * expected.mean().y,
            "{name}, {what}: {apart} of {}",
            expected.mean().y
        );
    }
}

/// A skin that leaves the mesh in its place, a morph target that moves it: stripes stay on the surface.
pub fn skins_and_morph_targets_draw(scene: &mut Scene) {
    let material = scene.stage.add(unlit(black_on_white()));
    let plain = scene
        .stage
        .body(&scene.plane_mesh.clone(), &material, scene.plane_x, Transform::IDENTITY);
    let lens = square_on(64);
    let expected = scene.stage.picture(lens);
    scene.stage.clear([plain]);

    let corners = scene.plane.triangles.len() * 3;
    let joints = VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; corners]);
    let skinned = scene
        .plane
        .mesh()
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints)
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[0.5_f32, 0.5, 0.0, 0.0]; corners]);
    let rest = MorphAttributes::new(Vec3::new(-0.5, 0.0, 0.0), Vec3::ZERO, Vec3::ZERO);
    let mut both = skinned.clone();
    both.set_morph_targets(vec![rest; corners]);
    let mut morphed = scene.plane.mesh();
    morphed.set_morph_targets(vec![rest; corners]);

    for (name, mesh, skin, morph) in [
        ("skinned", skinned, true, false),
        ("morphed", morphed, false, true),
        ("both", both, true, true),
    ] {
        let mesh = scene.stage.add(mesh);
        // The morph target moves the plane by half a unit to the left; the entity moves it back.
        let back = Transform::from_xyz(if morph { 0.5 } else { 0.0 }, 0.0, 0.0);
        let body = scene.stage.body(&mesh, &material, scene.plane_x, back);
        let mut others = vec![];
        if skin {
            let poses = scene
                .stage
                .add(SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]));
            let joints: Vec<Entity> = (0..2).map(|_| scene.stage.app.world_mut().spawn(back).id()).collect();
            others.clone_from(&joints);
            let skin = SkinnedMesh {
                inverse_bindposes: poses,
                joints,
            };
            scene.stage.app.world_mut().entity_mut(body).insert(skin);
        }
        if morph {
            let weights = MeshMorphWeights::Value { weights: vec![1.0] };
            scene.stage.app.world_mut().entity_mut(body).insert(weights);
        }
        let (camera, target) = scene.stage.camera(lens);
        let prepass = (DepthPrepass, NormalPrepass, MotionVectorPrepass);
        scene.stage.app.world_mut().entity_mut(camera).insert(prepass);
        let sun = scene.stage.sun(Vec3::new(1.0, 2.0, 3.0), true);
        scene.stage.settle();
        let picture = scene.stage.read(&target);
        picture.save(name);
        let apart = (0..64 * 64)
            .filter(|&k| (picture.pixels[k] - expected.pixels[k]).length() > 0.05)
            .count();
        assert!(apart < 64, "{name}: {apart} pixels differ");
        others.extend([camera, body, sun]);
        scene.stage.clear(others);
    }
}

/// The shadow of a cut-out pane has the pane's stripes.
pub fn cut_outs_cast_striped_shadows(scene: &mut Scene) {
    let sun = scene.stage.sun(Vec3::new(0.0, 0.0, 4.0), true);
    let floor = scene.stage.add(Mesh::from(Rectangle::new(6.0, 6.0)));
    let white = scene.stage.add(StandardMaterial {
        perceptual_roughness: 1.0,
        ..default()
    });
    let ground = scene.stage.body(&floor, &white, 0, Transform::from_xyz(0.0, 0.0, -1.0));
    let mesh = scene.plane_mesh.clone();
    // From aside, so that the pane does not hide its shadow.
    let lens = Lens {
        width: 96,
        height: 96,
        from: Vec3::new(0.0, -4.0, 2.5),
        to: Vec3::new(0.0, 0.0, -0.6),
        ..default()
    };
    let shadow_contrast = |scene: &mut Scene, cutout: bool| {
        let material = scene.stage.add(StripeMaterial {
            base: StandardMaterial {
                double_sided: true,
                cull_mode: None,
                ..default()
            },
            extension: Stripes { cutout, ..default() },
        });
        let body = scene.stage.body(&mesh, &material, scene.plane_x, Transform::IDENTITY);
        let picture = scene.stage.picture(lens);
        picture.save(if cutout { "shadow cut-out" } else { "shadow whole" });
        let mode = scene
            .stage
            .app
            .world()
            .resource::<Assets<StripeMaterial>>()
            .get(&material)
            .unwrap()
            .base
            .alpha_mode;
        assert_eq!(mode == AlphaMode::Mask(0.5), cutout);
        scene.stage.clear([body]);
        // Changes from lit to dark along a row of the floor below the pane's lower edge.
        let row: Vec<bool> = (0..96)
            .map(|x| picture.at(x, 66).y > 0.5 * picture.at(4, 66).y)
            .collect();
        row.windows(2).filter(|pair| pair[0] != pair[1]).count()
    };
    assert_eq!(shadow_contrast(scene, false), 2, "a whole pane has one shadow");
    assert_eq!(shadow_contrast(scene, true), 8, "four stripes have four shadows");
    scene.stage.clear([sun, ground]);
}

/// Light from the side makes bumps seen on a surface of one colour; more so if they are higher.
pub fn bumps_shade(scene: &mut Scene) {
    let sun = scene.stage.sun(Vec3::new(4.0, 0.0, 3.0), false);
    let mesh = scene.plane_mesh.clone();
    let contrast = |scene: &mut Scene, bump: f32, prepass: bool| {
        let drive = PatternDrive {
            base_color: 0.0,
            bump,
            ..default()
        };
        let base = StandardMaterial {
            perceptual_roughness: 1.0,
            ..default()
        };
        let material = scene.stage.add(StripeMaterial {
            base,
            extension: Stripes { drive, ..default() },
        });
        let body = scene.stage.body(&mesh, &material, scene.plane_x, Transform::IDENTITY);
        let (camera, target) = scene.stage.camera(square_on(96));
        if prepass {
            scene
                .stage
                .app
                .world_mut()
                .entity_mut(camera)
                .insert((DepthPrepass, NormalPrepass));
        }
        scene.stage.settle();
        let picture = scene.stage.read(&target);
        picture.save(&format!("bump {bump} {prepass}"));
        scene.stage.clear([body, camera]);
        picture.contrast()
    };
    let (flat, low, high) = (
        contrast(scene, 0.0, false),
        contrast(scene, 0.01, false),
        contrast(scene, 0.03, false),
    );
    assert!(flat < 0.3 * low && low < high, "contrasts {flat}, {low}, {high}");
    let bent_twice = contrast(scene, 0.03, true);
    assert!(
        (bent_twice - high).abs() < 0.05 * high,
        "with a normal prepass {bent_twice} instead of {high}"
    );
    scene.stage.clear([sun]);
}
