//! Every way Bevy draws a mesh: prepasses, deferred, multisampling, two cameras.
#![allow(clippy::print_stdout, reason = "what was measured")]

use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    material::OpaqueRendererMethod,
    prelude::*,
};

use crate::{
    Scene,
    looks::{self, Look},
    stage::{Lens, Picture},
};

/// A part of the torus where a period is some 10 pixels.
fn near_torus() -> Lens {
    Lens {
        from: Vec3::new(0.2, 0.9, 2.0),
        to: Vec3::new(0.1, 0.1, 0.9),
        ..default()
    }
}

/// All styles are drawn, and alike, in every way Bevy can draw them.
pub fn every_pass_draws(scene: &mut Scene) {
    let sun = scene.stage.sun(Vec3::new(1.0, 2.0, 3.0), true);
    let mut looks = looks::plain(scene);
    looks.extend(looks::cut_out(scene));
    looks.extend(looks::special(scene));
    for look in &looks {
        alike_in_every_pass(scene, look);
        two_cameras_see_the_same(scene, look);
    }
    scene.stage.clear([sun]);
}

fn base() -> StandardMaterial {
    StandardMaterial {
        base_color: Color::WHITE,
        perceptual_roughness: 0.9,
        ..default()
    }
}

fn two_cameras_see_the_same(scene: &mut Scene, look: &Look) {
    let body = scene.stage.bare(&scene.torus_mesh, scene.pairs[0], Transform::IDENTITY);
    look.wear(&mut scene.stage, &base(), &[body]);
    let (first, target) = scene.stage.camera(near_torus());
    let (second, other_target) = scene.stage.camera(near_torus());
    let world = scene.stage.app.world_mut();
    world.get_mut::<Camera>(second).unwrap().order = 1;
    scene.stage.settle();
    let (one, other) = (scene.stage.read(&target), scene.stage.read(&other_target));
    assert!(one.contrast() > 0.02, "{}: nothing drawn", look.name);
    assert_eq!(one.max_difference(&other), 0.0, "{}", look.name);
    scene.stage.clear([first, second, body]);
}

/// Draws a style in every way and compares what is seen with the plain forward pass.
fn alike_in_every_pass(scene: &mut Scene, look: &Look) {
    let name = look.name;
    let lens = near_torus();
    let body = scene.stage.bare(&scene.torus_mesh, scene.pairs[0], Transform::IDENTITY);
    look.wear(&mut scene.stage, &base(), &[body]);
    let expected = scene.stage.picture(lens);
    expected.save(&format!("{name} forward"));
    assert!(expected.contrast() > 0.02, "{name}: nothing drawn");
    let multisampled = Lens {
        msaa: Msaa::Sample4,
        ..lens
    };
    let ldr = Lens { hdr: false, ..lens };
    for (what, lens, prepass, allowed) in [
        ("prepass", lens, Prepass::Forward, 0.01),
        ("msaa", multisampled, Prepass::None, 0.05),
        ("msaa prepass", multisampled, Prepass::Forward, 0.05),
        ("ldr", ldr, Prepass::None, 0.01),
        ("deferred", lens, Prepass::Deferred, 0.05),
    ] {
        let method = match prepass {
            Prepass::Deferred => OpaqueRendererMethod::Deferred,
            _ => OpaqueRendererMethod::Auto,
        };
        let base = StandardMaterial {
            opaque_render_method: method,
            ..base()
        };
        look.wear(&mut scene.stage, &base, &[body]);
        let picture = draw(scene, lens, prepass);
        picture.save(&format!("{name} {what}"));
        let pixels = picture.luminance().into_iter().zip(expected.luminance());
        let apart = pixels.map(|(a, b)| (a - b).abs()).sum::<f32>() / picture.pixels.len() as f32;
        let share = apart / expected.mean().y;
        println!("{name:28} {what:14} {share:.4}");
        assert!(share < allowed, "{name}, {what}: {share}");
    }
    scene.stage.clear([body]);
}

#[derive(Clone, Copy)]
enum Prepass {
    None,
    Forward,
    Deferred,
}

fn draw(scene: &mut Scene, lens: Lens, prepass: Prepass) -> Picture {
    let (camera, target) = scene.stage.camera(lens);
    let mut entity = scene.stage.app.world_mut().entity_mut(camera);
    match prepass {
        Prepass::None => {}
        Prepass::Forward => _ = entity.insert((DepthPrepass, MotionVectorPrepass, NormalPrepass)),
        Prepass::Deferred => _ = entity.insert((DepthPrepass, MotionVectorPrepass, DeferredPrepass)),
    }
    scene.stage.settle();
    let picture = scene.stage.read(&target);
    scene.stage.clear([camera]);
    picture
}
