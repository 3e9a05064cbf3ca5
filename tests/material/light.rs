//! Light on patterns: shadows of cut-outs, bumps, fog.

use bevy::{
    core_pipeline::prepass::{DepthPrepass, NormalPrepass},
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
};

use crate::{
    Scene,
    looks::{self, Look},
    square_on,
    stage::Lens,
};

/// The shadow of a cut-out pane has the pane's stripes.
pub fn cut_outs_cast_striped_shadows(scene: &mut Scene) {
    let sun = scene.stage.sun(Vec3::new(0.0, 0.0, 4.0), true);
    let floor = scene.stage.add(Mesh::from(Rectangle::new(6.0, 6.0)));
    let white = scene.stage.add(StandardMaterial {
        perceptual_roughness: 1.0,
        ..default()
    });
    let ground = scene.stage.body(&floor, &white, 0, Transform::from_xyz(0.0, 0.0, -1.0));
    for look in looks::plain(scene) {
        assert_eq!(
            shadow_edges(scene, &look),
            2,
            "{}: a whole pane has one shadow",
            look.name
        );
    }
    for look in looks::cut_out(scene) {
        assert_eq!(
            shadow_edges(scene, &look),
            8,
            "{}: four stripes have four shadows",
            look.name
        );
    }
    scene.stage.clear([sun, ground]);
}

/// Changes from lit to dark along a row of the floor, below the lower edge of a pane.
fn shadow_edges(scene: &mut Scene, look: &Look) -> usize {
    let base = StandardMaterial {
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    let pane = scene.stage.bare(&scene.woven_mesh, scene.woven[0], Transform::IDENTITY);
    look.wear(&mut scene.stage, &base, &[pane]);
    // From aside, so that the pane does not hide its shadow.
    let picture = scene.stage.picture(Lens {
        width: 96,
        height: 96,
        from: Vec3::new(0.0, -4.0, 2.5),
        to: Vec3::new(0.0, 0.0, -0.6),
        ..default()
    });
    picture.save(&format!("{} shadow", look.name));
    scene.stage.clear([pane]);
    let lit = |x: usize| picture.at(x, 66).y > 0.5 * picture.at(4, 66).y;
    (1..96).filter(|&x| lit(x) != lit(x - 1)).count()
}

/// Light from the side makes bumps seen on a surface of one colour; more so if they are higher.
pub fn bumps_shade(scene: &mut Scene) {
    let sun = scene.stage.sun(Vec3::new(4.0, 0.0, 3.0), false);
    let [flat, low, high] = [0.0, 0.01, 0.03].map(|bump| looks::bumped(scene, bump, 0.0));
    for ((flat, low), bumped) in flat.iter().zip(&low).zip(&high) {
        let name = flat.name;
        let [flat, low, high] = [flat, low, bumped].map(|look| bump_contrast(scene, look, false));
        assert!(
            flat < 0.3 * low && low < high,
            "{name}: contrasts {flat}, {low}, {high}"
        );
        let bent_twice = bump_contrast(scene, bumped, true);
        assert!(
            (bent_twice - high).abs() < 0.05 * high,
            "{name}: with a normal prepass {bent_twice} instead of {high}"
        );
    }
    scene.stage.clear([sun]);
}

fn bump_contrast(scene: &mut Scene, look: &Look, prepass: bool) -> f32 {
    let base = StandardMaterial {
        perceptual_roughness: 1.0,
        ..default()
    };
    let body = scene.stage.bare(&scene.woven_mesh, scene.woven[0], Transform::IDENTITY);
    look.wear(&mut scene.stage, &base, &[body]);
    let (camera, target) = scene.stage.camera(square_on(96));
    if prepass {
        let mut camera = scene.stage.app.world_mut().entity_mut(camera);
        camera.insert((DepthPrepass, NormalPrepass));
    }
    scene.stage.settle();
    let picture = scene.stage.read(&target);
    picture.save(&format!("{} {prepass}", look.name));
    scene.stage.clear([body, camera]);
    picture.contrast()
}

/// Fog veils every style as it veils the base.
pub fn fog_veils(scene: &mut Scene) {
    let fog = Color::linear_rgb(0.2, 0.3, 0.9);
    for look in looks::plain(scene) {
        let body = scene.stage.bare(&scene.woven_mesh, scene.woven[0], Transform::IDENTITY);
        let base = StandardMaterial {
            unlit: true,
            ..default()
        };
        look.wear(&mut scene.stage, &base, &[body]);
        // The plane is 3 away.
        let [clear, half, thick] = [1e6, 6.0, 3.0].map(|end| {
            let (camera, target) = scene.stage.camera(square_on(64));
            let falloff = FogFalloff::Linear { start: 0.0, end };
            let fog = DistanceFog {
                color: fog,
                falloff,
                ..default()
            };
            scene.stage.app.world_mut().entity_mut(camera).insert(fog);
            scene.stage.settle();
            let picture = scene.stage.read(&target);
            scene.stage.clear([camera]);
            picture
        });
        half.save(&format!("{} fog", look.name));
        scene.stage.clear([body]);
        let color = fog.to_linear().to_vec3();
        let veiled = |k: usize, share: f32| clear.pixels[k].truncate().lerp(color, share);
        for k in 0..clear.pixels.len() {
            let off = (half.pixels[k].truncate() - veiled(k, 0.5)).abs().max_element();
            // Corners are farther away than the middle.
            assert!(off < 0.06, "{}: {off} off the half veiled picture", look.name);
            let left = (thick.pixels[k].truncate() - color).abs().max_element();
            assert!(left < 5e-3, "{}: {left} shows through thick fog", look.name);
        }
        assert!(clear.contrast() > 0.1, "{}: nothing drawn", look.name);
    }
}
