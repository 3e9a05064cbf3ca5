//! One sample per pixel looks like the mean of many: hatching and a tensor's stripes against 144 unfiltered samples.
#![allow(clippy::print_stdout, reason = "what was measured")]

use bevy::prelude::*;
use bevy_field_patterns::material::*;

use crate::{
    Scene,
    hatch::{hatch, over},
    patterns::Pattern,
    stage::{Lens, Picture},
    tensor,
};

const WIDTH: u32 = 112;
const HEIGHT: u32 = 80;
/// Samples per pixel, along each side.
const SAMPLES: u32 = 12;

/// The mean of a larger picture's pixels.
fn reduced(large: &Picture) -> Picture {
    let samples = SAMPLES as usize;
    let pixels = (0..WIDTH as usize * HEIGHT as usize).map(|k| {
        let (x, y) = (k % WIDTH as usize * samples, k / WIDTH as usize * samples);
        let sum: Vec4 = (0..samples * samples)
            .map(|s| large.at(x + s % samples, y + s / samples))
            .sum();
        sum / (samples * samples) as f32
    });
    Picture {
        width: WIDTH as usize,
        pixels: pixels.collect(),
    }
}

/// Pixels that are surface (the ground is blue), as are all pixels up to two away.
fn inside(truth: &Picture) -> Vec<usize> {
    let whole = |x: usize, y: usize| truth.at(x, y).w > 0.99;
    (2..HEIGHT as usize - 2)
        .flat_map(|y| (2..WIDTH as usize - 2).map(move |x| (x, y)))
        .filter(|&(x, y)| (y - 2..=y + 2).all(|y| (x - 2..=x + 2).all(|x| whole(x, y))))
        .map(|(x, y)| y * WIDTH as usize + x)
        .collect()
}

/// What to draw with so many samples along a pixel's side, filtered or not.
type Style<'a> = &'a dyn Fn(&mut Scene, f32, bool, Lens) -> Picture;

/// What is further from the truth than allowed.
fn check(scene: &mut Scene, name: &str, style: Style, allowed: f32) -> Vec<String> {
    let mut failures = vec![];
    for (view, distance) in [("near", 1.0), ("middle", 2.5), ("far", 5.0)] {
        let lens = |samples| Lens {
            width: samples * WIDTH,
            height: samples * HEIGHT,
            from: Vec3::new(0.31, 0.23, 0.87) * distance + Vec3::Z,
            to: Vec3::new(0.1, 0.05, 0.95),
            ..default()
        };
        scene.stage.app.insert_resource(ClearColor(Color::NONE));
        let filtered = style(scene, 1.0, true, lens(1));
        let unfiltered = style(scene, 1.0, false, lens(1));
        let truth = reduced(&style(scene, SAMPLES as f32, false, lens(SAMPLES)));
        scene.stage.app.insert_resource(ClearColor(Color::BLACK));
        for (picture, kind) in [(&filtered, "filtered"), (&unfiltered, "unfiltered"), (&truth, "truth")] {
            picture.save(&format!("smooth {name} {view} {kind}"));
        }
        let inside = inside(&truth);
        let rms = |picture: &Picture| {
            let squares = inside
                .iter()
                .map(|&k| (picture.pixels[k].y - truth.pixels[k].y).powi(2));
            (squares.sum::<f32>() / inside.len() as f32).sqrt()
        };
        let (with, without) = (rms(&filtered), rms(&unfiltered));
        println!(
            "{name:16} {view:8} {with:.4} of white, unfiltered {without:.4}, {} pixels",
            inside.len()
        );
        if inside.len() < 80 || with > allowed || without < 2.0 * with {
            failures.push(format!("{name}, {view}: {with}, unfiltered {without}"));
        }
    }
    failures
}

pub fn one_sample_is_the_mean_of_many(scene: &mut Scene) {
    let mut failures = vec![];
    // Jittered, with exact phases: what branches do to a pixel is not the filter's.
    let scalar = |p: Vec2| 0.5 + 0.5 * (3.0 * p.x + p.y).sin();
    let (pair, _) = Pattern::bent(24, 0.4, 7.0, 0.8, scalar);
    let mut single = pair.clone();
    single.pair = None;
    single.z = pair.z.iter().copied().step_by(2).collect();
    let mesh = scene.stage.add(pair.mesh());
    let [single, pair] = [single, pair].map(|pattern| scene.memory.push(&pattern));
    scene.upload();
    for (name, tag, share, spacing) in [
        ("hatch", single, 0.3, Some(8.0)),
        ("hatch fine", single, 0.4, Some(3.0)),
        ("hatch period", single, 0.5, None),
        ("hatch crossed", pair, 0.6, Some(8.0)),
    ] {
        let draw = |scene: &mut Scene, samples: f32, anti_aliasing, lens| {
            let mut style = Hatch {
                anti_aliasing,
                ..hatch(HatchTone::Constant(share))
            };
            style.strokes.spacing =
                spacing.map_or(StrokeSpacing::Period, |pixels| StrokeSpacing::Pixels(pixels * samples));
            let material = scene.stage.add(over(style));
            let body = scene.stage.body(&mesh, &material, tag, Transform::IDENTITY);
            let picture = scene.stage.picture(lens);
            scene.stage.clear([body]);
            picture
        };
        failures.extend(check(scene, name, &draw, 0.015));
    }
    let draw = |scene: &mut Scene, samples: f32, anti_aliasing, lens| {
        let style = Tensor {
            anti_aliasing,
            line_width: 2.0 * samples,
            ..tensor::style()
        };
        let material = scene.stage.add(tensor::over(style));
        let body = scene.stage.body(&mesh, &material, single, Transform::IDENTITY);
        let picture = scene.stage.picture(lens);
        scene.stage.clear([body]);
        picture
    };
    // Far away a limit's line is as wide as many triangles.
    failures.extend(check(scene, "tensor", &draw, 0.03));
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
