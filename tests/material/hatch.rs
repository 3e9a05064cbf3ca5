//! Hatching on a GPU: strokes of tones contain each other, ink is the share that the tone asks for, tones come from light,
//! distance and scalars.

use bevy::{material::OpaqueRendererMethod, prelude::*};
use bevy_field_patterns::{material::*, wave::Waves};

use crate::{
    Scene, WHITE,
    patterns::Pattern,
    square_on,
    stage::{Lens, Picture},
    torus_view,
};

/// Black ink on white paper.
pub fn hatch(tone: HatchTone) -> Hatch {
    Hatch {
        ink: LinearRgba::BLACK,
        paper: WHITE,
        tone,
        ..default()
    }
}

pub fn over(extension: Hatch) -> HatchMaterial {
    HatchMaterial {
        base: StandardMaterial {
            perceptual_roughness: 1.0,
            ..default()
        },
        extension,
    }
}

pub fn draw(scene: &mut Scene, mesh: &Handle<Mesh>, tag: u32, extension: Hatch, lens: Lens) -> Picture {
    let material = scene.stage.add(over(extension));
    let body = scene.stage.body(mesh, &material, tag, Transform::IDENTITY);
    let picture = scene.stage.picture(lens);
    scene.stage.clear([body]);
    picture
}

/// A part of the torus, so near that strokes are seen.
fn near_torus(width: u32, height: u32) -> Lens {
    Lens {
        from: Vec3::new(0.2, 1.3, 1.7),
        to: Vec3::new(0.4, 0.2, 0.9),
        ..torus_view(width, height)
    }
}

/// The most that a pixel is darker in `light` than in `dark`.
fn lost(light: &Picture, dark: &Picture) -> f32 {
    let pixels = light.pixels.iter().zip(&dark.pixels);
    pixels.map(|(light, dark)| dark.x - light.x).fold(0.0, f32::max)
}

/// Per pixel, a darker tone's ink contains a lighter tone's; however strokes are made, hand and all.
pub fn darker_tones_keep_strokes(scene: &mut Scene) {
    let mesh = scene.torus_mesh.clone();
    let lens = near_torus(160, 96);
    for tag in [scene.line, scene.pairs[0], scene.pairs[2]] {
        for (density, spacing) in [(0.0, StrokeSpacing::Period), (1.0, StrokeSpacing::Pixels(6.0))] {
            let tones = [0.08, 0.25, 0.45, 0.75].map(|share| {
                let mut style = hatch(HatchTone::Constant(share));
                style.strokes.density = density;
                style.strokes.spacing = spacing;
                draw(scene, &mesh, tag, style, lens)
            });
            for pair in tones.windows(2) {
                let lost = lost(&pair[0], &pair[1]);
                assert!(lost < 4e-3, "{lost} of a pixel's ink is lost in a darker tone");
                assert!(pair[0].mean().x > pair[1].mean().x + 0.02, "no darker");
            }
            // Strokes of another pattern are not contained.
            let style = hatch(HatchTone::Constant(0.45));
            let stranger = draw(scene, &mesh, scene.pairs[1], style, lens);
            assert!(lost(&tones[1], &stranger) > 0.2, "the comparison cannot fail");
        }
    }
}

/// The mean of a picture is the tone, for one wave and for two, near and so far that no stroke is seen.
pub fn ink_is_the_share_of_the_tone(scene: &mut Scene) {
    let pattern = Pattern::plane(2.0, 8, Vec3::X, 8.0);
    let mesh = scene.stage.add(pattern.mesh());
    let tags = [
        pattern,
        Pattern::woven(8.0, Waves::Orthogonal { ratio: 0.75 }, |_| 0),
        Pattern::woven(8.0, Waves::Cross, |v| v % 4),
    ]
    .map(|pattern| scene.memory.push(&pattern));
    scene.upload();
    for tag in tags {
        for share in [0.15, 0.5, 0.7] {
            for (hand, spacing, width) in [
                (HatchHand::STEADY, StrokeSpacing::Period, 128),
                (HatchHand::default(), StrokeSpacing::Period, 128),
                (HatchHand::default(), StrokeSpacing::Pixels(5.0), 192),
                (HatchHand::default(), StrokeSpacing::Period, 12),
            ] {
                let mut style = hatch(HatchTone::Constant(share));
                style.hand = hand;
                style.strokes.spacing = spacing;
                let found = 1.0 - draw(scene, &mesh, tag, style, square_on(width)).mean().x;
                assert!(
                    (found - share).abs() < 0.02,
                    "{found} of {share}: {hand:?}, {spacing:?}, {width} pixels"
                );
            }
        }
    }
}

/// Coming nearer, strokes stay in their places and new ones come between.
pub fn zooming_keeps_strokes(scene: &mut Scene) {
    let mesh = scene.plane_mesh.clone();
    let mut style = hatch(HatchTone::Constant(0.3));
    style.hand = HatchHand::STEADY;
    style.strokes = HatchStrokes {
        spacing: StrokeSpacing::Pixels(12.0),
        density: 0.0,
        softness: 0.0,
        ..default()
    };
    // Positions of the strokes' middles along a row, in units of length.
    let mut middles = |size: f32| {
        let lens = Lens {
            orthographic: Some(size),
            ..square_on(256)
        };
        let picture = draw(scene, &mesh, scene.plane_x, style.clone(), lens);
        let ink: Vec<f32> = (0..256).map(|x| 1.0 - picture.at(x, 40).x).collect();
        let mut found = vec![];
        let mut x = 0;
        while x < 256 {
            if ink[x] > 0.02 {
                let from = x;
                while x < 256 && ink[x] > 0.02 {
                    x += 1;
                }
                let (mass, moment) =
                    (from..x).fold((0.0, 0.0), |sum, k| (sum.0 + ink[k], sum.1 + ink[k] * (k as f32 + 0.5)));
                if from > 0 && x < 256 {
                    found.push((moment / mass / 256.0 - 0.5) * size);
                }
            }
            x += 1;
        }
        found
    };
    let mut before: Vec<f32> = vec![];
    for size in [1.9, 1.5, 1.0, 0.8, 0.5, 0.3] {
        let now = middles(size);
        let pixel = size / 256.0;
        for stroke in before.iter().filter(|x| x.abs() < 0.5 * size - 8.0 * pixel) {
            let nearest = now.iter().map(|x| (x - stroke).abs()).fold(f32::MAX, f32::min);
            assert!(nearest < pixel, "a stroke at {stroke} has gone at {size}");
        }
        let apart = size / now.len() as f32 / pixel;
        assert!(
            (5.0..30.0).contains(&apart),
            "strokes are {apart} pixels apart at {size}"
        );
        before = now;
    }
    assert!(before.len() > 8, "no strokes to compare");
}

/// A lit plane's drawing is as bright as the plane; more light, less ink. Distances and entities make tones, too.
pub fn tones_come_from_light_and_distance(scene: &mut Scene) {
    let pattern = Pattern::plane(2.0, 8, Vec3::X, 8.0);
    let mesh = scene.stage.add(pattern.mesh());
    let tag = scene.memory.push(&pattern);
    scene.upload();
    let lens = square_on(128);
    let mut means = vec![];
    for height in [1.0, 4.0] {
        let sun = scene.stage.sun(Vec3::new(3.0, 0.0, height), false);
        let mut bare = hatch(HatchTone::Constant(0.0));
        bare.paper = LinearRgba::NONE;
        let lit = draw(scene, &mesh, tag, bare, lens).mean().y;
        let style = Hatch {
            darkest: 1.0,
            ..hatch(HatchTone::Light { light: 1.0, dark: 0.0 })
        };
        let drawn = draw(scene, &mesh, tag, style, lens).mean().y;
        scene.stage.clear([sun]);
        assert!((0.05..0.95).contains(&lit), "a light of {lit} shows nothing");
        assert!((drawn - lit).abs() < 0.02, "{drawn} drawn for a light of {lit}");
        means.push(drawn);
    }
    assert!(means[1] > means[0] + 0.1, "{means:?}");

    let left = Vec3::new(-1.0, 0.0, 0.0);
    let distance = |from| HatchTone::Distance {
        from,
        light: 2.0,
        dark: 0.0,
    };
    let material = scene
        .stage
        .add(over(hatch(distance(DistanceFrom::Point(Vec3::splat(100.0))))));
    let body = scene.stage.body(&mesh, &material, tag, Transform::IDENTITY);
    let half = |picture: &Picture, from: usize| {
        let pixels = (0..128).flat_map(|y| (from..from + 64).map(move |x| (x, y)));
        pixels.map(|(x, y)| picture.at(x, y).x).sum::<f32>() / (64.0 * 128.0)
    };
    let far = scene.stage.picture(lens);
    assert!(far.mean().x > 0.99, "nothing is near");
    let source = ToneSource {
        materials: vec![material.clone()],
    };
    let source = scene
        .stage
        .app
        .world_mut()
        .spawn((source, Transform::from_translation(left)))
        .id();
    let near = scene.stage.picture(lens);
    near.save("hatch distance");
    scene.stage.clear([body, source]);
    assert!(half(&near, 64) > half(&near, 0) + 0.2, "darker on the left");
}

/// Scalars of the pattern make tones.
pub fn tones_come_from_scalars(scene: &mut Scene) {
    let mut pattern = Pattern::plane(2.0, 8, Vec3::X, 8.0);
    pattern.scalars = pattern.positions.iter().map(|p| Vec2::new(p.y, 3.0)).collect();
    let mesh = scene.stage.add(pattern.mesh());
    let tag = scene.memory.push(&pattern);
    scene.upload();
    let tone = |scalar| HatchTone::Scalar {
        scalar,
        light: 1.0,
        dark: -1.0,
    };
    let steady = Hatch {
        hand: HatchHand::STEADY,
        ..hatch(tone(ScalarChannel::First))
    };
    let picture = draw(scene, &mesh, tag, steady, square_on(128));
    picture.save("hatch scalar");
    let row = |y: usize| (0..128).map(|x| 1.0 - picture.at(x, y).x).sum::<f32>() / 128.0;
    for (y, height) in [(20, 0.68), (64, 0.0), (108, -0.68)] {
        let found = row(y);
        let expected = 0.85 * (1.0 - height) / 2.0;
        assert!(
            (found - expected).abs() < 0.03,
            "{found} instead of {expected} at {height}"
        );
    }
    let constant = draw(scene, &mesh, tag, hatch(tone(ScalarChannel::Second)), square_on(64));
    assert!(constant.mean().x > 0.99, "3 is beyond the lightest value");
}

/// Outlines are as wide on the screen as they should be, near and far, and dashes leave their gaps.
pub fn outlines_are_of_constant_width(scene: &mut Scene) {
    let ball = Pattern::ball(48, Vec3::Y, 6.0);
    let mesh = scene.stage.add(ball.mesh());
    let tag = scene.memory.push(&ball);
    scene.upload();
    for (size, width, dash, along) in [
        (2.6, 2.0, 0.0, DashAlong::Position),
        (2.6, 4.0, 0.0, DashAlong::Position),
        (5.0, 2.0, 0.0, DashAlong::Position),
        (2.6, 2.0, 12.0, DashAlong::Position),
        (2.6, 2.0, 12.0, DashAlong::Wave),
    ] {
        let mut style = hatch(HatchTone::Constant(0.0));
        style.outline = HatchOutline {
            width,
            dash,
            gap: 0.4,
            along,
        };
        let lens = Lens {
            from: Vec3::new(0.0, 1.0, 3.0),
            orthographic: Some(size),
            ..square_on(160)
        };
        // White ground.
        scene.stage.app.insert_resource(ClearColor(Color::WHITE));
        let picture = draw(scene, &mesh, tag, style, lens);
        scene.stage.app.insert_resource(ClearColor(Color::BLACK));
        picture.save(&format!("outline {size} {width} {dash} {along:?}"));
        let radius = 160.0 / size;
        let ink: f32 = picture.pixels.iter().map(|p| 1.0 - p.x).sum();
        let around = ink / (std::f32::consts::TAU * (radius - 0.5 * width));
        let expected = if dash > 0.0 { 0.6 * width } else { width };
        assert!(
            (around / expected - 1.0).abs() < if dash > 0.0 { 0.25 } else { 0.15 },
            "{around} pixels wide instead of {expected}: {size}, {dash}, {along:?}"
        );
    }
}

/// Red near, blue far.
pub fn depth_has_a_hue(scene: &mut Scene) {
    let mesh = scene.plane_mesh.clone();
    let mut style = hatch(HatchTone::Constant(0.5));
    style.chroma_depth = ChromaDepth {
        near: 2.0,
        far: 4.0,
        ink: 1.0,
        paper: 1.0,
    };
    for (distance, hue) in [(1.5, 1.0), (3.0, 0.0), (5.0, -1.0)] {
        let lens = Lens {
            from: Vec3::new(0.0, 0.0, distance),
            ..square_on(16)
        };
        let mean = draw(scene, &mesh, scene.plane_x, style.clone(), lens).mean();
        assert!((mean.x - mean.z - hue).abs() < 0.06, "{mean} at {distance}");
    }
}

/// Drawing by light needs the forward pass, whatever the base asks for; a cut-out masks.
pub fn styles_choose_their_pass(scene: &mut Scene) {
    for (tone, forward) in [
        (HatchTone::Light { light: 0.3, dark: 0.0 }, true),
        (HatchTone::Constant(0.4), false),
    ] {
        for cutout in [false, true] {
            let mut material = over(Hatch { cutout, ..hatch(tone) });
            material.base.opaque_render_method = OpaqueRendererMethod::Deferred;
            let material = scene.stage.add(material);
            scene.stage.app.update();
            scene.stage.app.update();
            let materials = scene.stage.app.world().resource::<Assets<HatchMaterial>>();
            let base = &materials.get(&material).unwrap().base;
            let is_forward = base.opaque_render_method != OpaqueRendererMethod::Deferred;
            assert_eq!(is_forward, forward, "{tone:?}");
            assert_eq!(base.alpha_mode == AlphaMode::Mask(0.5), cutout, "{tone:?}");
        }
    }
}
