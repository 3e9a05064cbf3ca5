//! Draws the images of `assets/textures` from formulas, for waves of every symmetry.
//!
//! ```sh
//! cargo run --example make_textures -- assets/textures
//! ```
//!
//! An image is drawn in coordinates from -1 to 1, x to the right (along d) and y up (along n × d).
#![allow(clippy::print_stderr, reason = "errors of the command line")]

use std::{path::PathBuf, process::ExitCode};

use bevy::{
    asset::RenderAssetUsages,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use clap::Parser;

/// Draw the textures of the examples.
#[derive(Parser)]
struct Args {
    /// The folder to write PNG files into
    folder: PathBuf,
}

/// Samples per texel, along each side.
const SAMPLES: u32 = 4;
/// Sides of an image, and of a tile of an atlas.
const SIZE: u32 = 192;
const TILE: u32 = 128;

/// A colour (sRGB) and how opaque it is at a point.
type Drawing = fn(Vec2) -> Vec4;

fn main() -> ExitCode {
    let folder = Args::parse().folder;
    let single: [(&str, Drawing); 7] = [
        ("arrow", arrow),
        ("chevrons", chevrons),
        ("streaks", streaks),
        ("weave", weave),
        ("twist", twist),
        ("tiles", tiles),
        ("pinwheel", pinwheel),
    ];
    let single = single.map(|(name, drawing)| (name, picture(&[drawing], SIZE)));
    let atlas = ("patches", picture(&[minus, dot, plus], TILE));
    for (name, image) in single.into_iter().chain([atlas]) {
        let path = folder.join(format!("{name}.png"));
        let image = image.try_into_dynamic().expect("an image of bytes").to_rgba8();
        if let Err(error) = image.save(&path) {
            eprintln!("{}: cannot be written: {error}", path.display());
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}

/// Drawings side by side.
fn picture(drawings: &[Drawing], side: u32) -> Image {
    let width = side * drawings.len() as u32;
    let texel = |k: u32| {
        let (x, y) = (k % width, k / width);
        let drawing = drawings[(x / side) as usize];
        let mut sum = Vec4::ZERO;
        for sample in 0..SAMPLES * SAMPLES {
            let within = (Vec2::new((sample % SAMPLES) as f32, (sample / SAMPLES) as f32) + 0.5) / SAMPLES as f32;
            let at = (UVec2::new(x % side, y).as_vec2() + within) * 2.0 / side as f32 - 1.0;
            let color = drawing(Vec2::new(at.x, -at.y));
            sum += (color.truncate() * color.w).extend(color.w);
        }
        let clear = drawing(Vec2::splat(-1.0)).truncate();
        let color = if sum.w > 0.0 { sum.truncate() / sum.w } else { clear };
        let alpha = sum.w / (SAMPLES * SAMPLES) as f32;
        color
            .extend(alpha)
            .to_array()
            .map(|value| (255.0 * value).round() as u8)
    };
    let size = Extent3d {
        width,
        height: side,
        depth_or_array_layers: 1,
    };
    let texels = (0..width * side).flat_map(texel).collect();
    Image::new(
        size,
        TextureDimension::D2,
        texels,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    )
}

fn painted(color: [f32; 3], share: f32) -> Vec4 {
    Vec3::from(color).extend(share.clamp(0.0, 1.0))
}

fn inked(color: [f32; 3], inside: bool) -> Vec4 {
    painted(color, f32::from(u8::from(inside)))
}

const WHITE: [f32; 3] = [1.0; 3];

/// An arrow to the right; white, to be tinted. For vector fields.
fn arrow(p: Vec2) -> Vec4 {
    let shaft = p.y.abs() < 0.13 && (-0.78..0.2).contains(&p.x);
    let head = (0.08..0.82).contains(&p.x) && p.y.abs() < 0.6 * (0.82 - p.x);
    inked(WHITE, shaft || head)
}

/// Chevrons that continue each other sideways, pointing right; white. For vector fields.
fn chevrons(p: Vec2) -> Vec4 {
    let along = 0.5 * (p.x + 0.6 * p.y.abs()) - 0.3;
    inked(WHITE, (along - along.floor() - 0.5).abs() < 0.17)
}

/// Drops with soft tails: quiet, to fade to. For vector fields.
fn streaks(p: Vec2) -> Vec4 {
    let drop = |middle: Vec2, length: f32| {
        let along = (p.x - middle.x - 2.0 * (0.5 * (p.x - middle.x)).round()) / length + 0.5;
        let across = (p.y - middle.y - 2.0 * (0.5 * (p.y - middle.y)).round()) / 0.12;
        let tail = along.clamp(0.0, 1.0) * f32::from(u8::from((0.0..1.0).contains(&along)));
        tail * (-across * across).exp() * ((1.0 - along) * 12.0).clamp(0.0, 1.0)
    };
    let drops = [(0.1, 0.5, 1.3), (-0.75, -0.1, 1.1), (0.45, -0.65, 1.4)];
    let share: f32 = drops
        .into_iter()
        .map(|(x, y, length)| drop(Vec2::new(x, y), length))
        .sum();
    painted(WHITE, 0.8 * share)
}

/// Cloth whose two yarns differ: the same after half a turn. For line fields.
fn weave(p: Vec2) -> Vec4 {
    let cell = p.floor();
    let over = (cell.x + cell.y).rem_euclid(2.0) == 0.0;
    let q = p - cell - 0.5;
    // The yarn along x lies on top in every other cell.
    let (along, across, color) = if over {
        (q.x, q.y, [0.82, 0.69, 0.46])
    } else {
        (q.y, q.x, [0.25, 0.36, 0.50])
    };
    let width = 0.40;
    let gap = [0.10, 0.09, 0.08];
    if across.abs() > width {
        return painted(gap, 1.0);
    }
    let round = (1.0 - (across / width).powi(2)).sqrt();
    let bent = (std::f32::consts::PI * along).cos();
    let light = (0.35 + 0.35 * round + 0.35 * bent).min(1.05);
    painted(color.map(|c| (c * light).min(1.0)), 1.0)
}

/// A leaf bent like an S: the same after half a turn, but not in a mirror. For line fields.
fn twist(p: Vec2) -> Vec4 {
    let middle = 0.34 * (std::f32::consts::PI * p.x).sin();
    let half = 0.34 * (1.0 - (p.x / 0.92).powi(2)).max(0.0);
    let across = (p.y - middle) / half.max(1e-3);
    let vein = across.abs() < 0.12;
    let color = if vein { [0.93, 0.95, 0.80] } else { [0.13, 0.45, 0.30] };
    inked(color, across.abs() < 1.0 && p.x.abs() < 0.92)
}

/// A tile with a frame and a star: the same after a quarter turn and in a mirror. For cross fields.
fn tiles(p: Vec2) -> Vec4 {
    let q = p.abs();
    let frame = q.max_element();
    let petals = 0.52 + 0.16 * (4.0 * p.y.atan2(p.x)).cos();
    let color = if frame > 0.94 {
        [0.80, 0.78, 0.74]
    } else if p.length() < 0.18 {
        [0.90, 0.68, 0.20]
    } else if p.length() < petals {
        [0.12, 0.32, 0.55]
    } else if frame > 0.80 || q.x + q.y > 1.45 {
        [0.20, 0.52, 0.62]
    } else {
        [0.95, 0.94, 0.88]
    };
    painted(color, 1.0)
}

/// A pinwheel: the same after a quarter turn, but not in a mirror. For cross fields.
fn pinwheel(p: Vec2) -> Vec4 {
    // Turned into the quadrant to the right.
    let turns = (p.y.atan2(p.x) / std::f32::consts::FRAC_PI_2).round() as i32;
    let q = (0..turns.rem_euclid(4)).fold(p, |q, _| Vec2::new(q.y, -q.x));
    let blade = q.x < 0.8 && q.y > -0.06 && q.y < 0.7 * q.x && q.x > 0.06;
    let color = if blade { [0.80, 0.25, 0.16] } else { [0.94, 0.90, 0.80] };
    painted(if q.x > 0.93 { [0.55, 0.50, 0.42] } else { color }, 1.0)
}

fn bar(p: Vec2) -> bool {
    p.x.abs() < 0.52 && p.y.abs() < 0.15
}

/// The patches of charges: negative, neutral, positive. The same after half a turn; plus and dot after a quarter turn.
fn minus(p: Vec2) -> Vec4 {
    inked([0.10, 0.50, 0.28], bar(p))
}

fn dot(p: Vec2) -> Vec4 {
    inked([0.45, 0.45, 0.45], p.length() < 0.17)
}

fn plus(p: Vec2) -> Vec4 {
    inked([0.85, 0.36, 0.05], bar(p) || bar(p.yx()))
}
