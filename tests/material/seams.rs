//! Nothing shows where the field has no sign or no first direction.

use bevy::prelude::*;
use bevy_field_patterns::{
    field::Symmetry,
    material::*,
    wave::{Waves, kite::reversed},
};

use crate::{
    Scene,
    hatch::{draw, hatch},
    patterns::Pattern,
    square_on,
    stage::Picture,
    torus_view,
};

/// Turning a cross field's frames by quarter turns changes no picture, neither of strokes nor of stripes: no seams.
pub fn quarter_turns_leave_no_seams(scene: &mut Scene) {
    let pattern = Pattern::woven(3.0, Waves::Cross, |_| 0);
    let mesh = scene.stage.add(pattern.mesh());
    let turned = |waves| Pattern::woven(3.0, waves, |v| v * 7 % 4);
    let tags = [
        pattern,
        turned(Waves::Cross),
        // Not linked: turning frames is another field.
        turned(Waves::Orthogonal { ratio: 1.0 }),
    ]
    .map(|pattern| scene.memory.push(&pattern));
    scene.upload();
    let lens = square_on(128);
    let compare = |pictures: [Picture; 3], what: &str| {
        pictures[0].save(&format!("woven {what}"));
        assert!(pictures[0].contrast() > 0.2, "{what}: nothing drawn");
        let apart = pictures[0].max_difference(&pictures[1]);
        assert!(apart < 2e-3, "{what}: {apart} after quarter turns");
        assert!(
            pictures[0].max_difference(&pictures[2]) > 0.5,
            "{what}: the comparison cannot fail"
        );
    };
    // Without the hand's stray, which may differ where frames differ: only its direction counts.
    let hatched = tags.map(|tag| draw(scene, &mesh, tag, hatch(HatchTone::Constant(0.5)), lens));
    compare(hatched, "strokes");
    let striped = tags.map(|tag| {
        let material = scene.stage.add(crate::unlit(Stripes {
            duty: 0.3,
            waves: StripeWaves::Both,
            ..crate::black_on_white()
        }));
        let body = scene.stage.body(&mesh, &material, tag, Transform::IDENTITY);
        let picture = scene.stage.picture(lens);
        scene.stage.clear([body]);
        picture
    });
    compare(striped, "stripes");
}

/// Stripes of the first wave, of the second and of both: the union.
pub fn stripes_of_two_waves(scene: &mut Scene) {
    let pattern = Pattern::woven(3.0, Waves::Orthogonal { ratio: 0.5 }, |_| 0);
    let mesh = scene.stage.add(pattern.mesh());
    let tag = scene.memory.push(&pattern);
    scene.upload();
    let [first, second, both] = [StripeWaves::First, StripeWaves::Second, StripeWaves::Both].map(|waves| {
        let material = scene.stage.add(crate::unlit(Stripes {
            duty: 0.4,
            waves,
            ..crate::black_on_white()
        }));
        let body = scene.stage.body(&mesh, &material, tag, Transform::IDENTITY);
        let picture = scene.stage.picture(square_on(120));
        scene.stage.clear([body]);
        picture
    });
    let changes = |picture: &Picture, along_x: bool| {
        let at = |k: usize| {
            if along_x {
                picture.at(k, 9).x
            } else {
                picture.at(9, k).x
            }
        };
        (1..120).filter(|&k| (at(k) > 0.5) != (at(k - 1) > 0.5)).count()
    };
    assert_eq!((changes(&first, true), changes(&first, false)), (12, 0));
    assert_eq!((changes(&second, true), changes(&second, false)), (0, 6));
    for k in 0..first.pixels.len() {
        let union = first.pixels[k].x * second.pixels[k].x;
        assert!((both.pixels[k].x - union).abs() < 2e-3, "the union at {k}");
    }
}

/// A line field has no sign: turning directions round changes no picture, the hand included.
pub fn line_fields_have_no_seams(scene: &mut Scene) {
    let axis = Vec3::new(0.15, 1.0, 0.1).normalize();
    let base = Pattern::torus(0.4, 0.6, axis, 10.0, Symmetry::Line);
    let mut turned = base.clone();
    for v in (0..turned.z.len()).filter(|v| v * 2_654_435_761 % 97 < 40) {
        turned.z[v] = reversed(turned.z[v]);
        turned.directions[v] = -turned.directions[v];
    }
    // Its phases are turned round without their directions.
    let mut wrong = base.clone();
    for v in 0..wrong.z.len() / 2 {
        wrong.z[v] = reversed(wrong.z[v]);
    }
    let tags = [base, turned, wrong].map(|pattern| scene.memory.push(&pattern));
    scene.upload();
    let mesh = scene.torus_mesh.clone();
    let pictures = tags.map(|tag| {
        let style = Hatch {
            hand: HatchHand {
                wobble: 0.2,
                ..default()
            },
            ..hatch(HatchTone::Constant(0.35))
        };
        draw(scene, &mesh, tag, style, torus_view(160, 96))
    });
    let apart = |other: &Picture| {
        let pixels = pictures[0].pixels.iter().zip(&other.pixels);
        pixels.filter(|(a, b)| (a.x - b.x).abs() > 0.02).count()
    };
    assert!(apart(&pictures[1]) < 16, "{} pixels differ", apart(&pictures[1]));
    assert!(apart(&pictures[2]) > 200, "the comparison cannot fail");
}
