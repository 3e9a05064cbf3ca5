//! The picture that becomes a mosaic where the user brings none: an evening by the sea.

use bevy::{
    asset::RenderAssetUsages,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

/// Width and height in pixels.
const SIZE: UVec2 = UVec2::new(720, 480);

/// Paints it.
pub fn evening() -> Image {
    let texels: Vec<u8> = (0..SIZE.y)
        .flat_map(|y| (0..SIZE.x).map(move |x| UVec2::new(x, y)))
        .flat_map(|pixel| {
            // x from -1.5 to 1.5, y from -1 at the bottom to 1.
            let p = (pixel.as_vec2() + 0.5 - 0.5 * SIZE.as_vec2()) * Vec2::new(2.0, -2.0) / SIZE.y as f32;
            let c = (color(p).clamp(Vec3::ZERO, Vec3::ONE) * 255.0).round();
            [c.x as u8, c.y as u8, c.z as u8, 255]
        })
        .collect();
    Image::new(
        Extent3d {
            width: SIZE.x,
            height: SIZE.y,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        texels,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    )
}

const SUN: Vec2 = Vec2::new(0.35, 0.28);
const HORIZON: f32 = -0.12;

/// The colour (sRGB) at a point.
fn color(p: Vec2) -> Vec3 {
    let from_sun = p.distance(SUN);
    let sky = mix(
        Vec3::new(0.98, 0.72, 0.42),
        Vec3::new(0.16, 0.28, 0.52),
        (p.y - HORIZON) / 1.1,
    );
    let glow = Vec3::new(0.55, 0.30, 0.12) * (-6.0 * from_sun * from_sun).exp();
    let mut c = sky + glow;
    // Bands of cloud that bend around the sun.
    let band = (9.0 * (p.y + 0.10 * (2.3 * p.x).sin()) + 2.0 * from_sun).sin();
    c = mix(
        c,
        Vec3::new(0.86, 0.47, 0.44),
        edge(band - 0.72, 0.2) * 0.7 * edge(p.y - 0.1, 0.1),
    );
    c = mix(c, Vec3::new(1.0, 0.95, 0.75), edge(0.19 - from_sun, 0.012));
    // Hills, one behind the other.
    for (k, tone) in [Vec3::new(0.42, 0.36, 0.50), Vec3::new(0.28, 0.27, 0.42)]
        .into_iter()
        .enumerate()
    {
        let k = k as f32;
        let ridge = HORIZON + 0.20 - 0.09 * k + 0.10 * ((1.7 + k) * p.x + 2.0 * k).sin() + 0.03 * (5.0 * p.x + k).cos();
        c = mix(c, tone, edge(ridge - p.y, 0.012));
    }
    // The sea mirrors the sun in a broken column.
    let depth = (HORIZON - p.y).max(0.0);
    let wave = (34.0 / (0.22 + depth) * (p.y + 0.012 * (9.0 * p.x).sin())).sin();
    let column = (-(p.x - SUN.x).powi(2) / (0.01 + 0.10 * depth)).exp();
    let sea = mix(Vec3::new(0.20, 0.33, 0.47), Vec3::new(0.06, 0.13, 0.25), depth / 0.9);
    let sea = mix(sea, Vec3::new(1.0, 0.76, 0.45), column * edge(wave + 0.2, 0.5));
    c = mix(c, sea, edge(HORIZON - p.y, 0.008));
    // A sail.
    let sail = p - Vec2::new(-0.55, -0.34);
    let cloth = edge(0.26 * (1.0 - sail.y / 0.52) - sail.x, 0.01) * edge(sail.x + 0.02 * sail.y, 0.01);
    c = mix(
        c,
        Vec3::new(0.97, 0.93, 0.86),
        cloth * edge(sail.y, 0.01) * edge(0.52 - sail.y, 0.01),
    );
    let hull =
        edge(0.075 - (sail.y + 0.045).abs() * 1.4, 0.01) * edge(0.34 - (sail.x - 0.06).abs() + 0.8 * sail.y, 0.01);
    mix(c, Vec3::new(0.30, 0.10, 0.09), hull)
}

fn mix(a: Vec3, b: Vec3, t: f32) -> Vec3 {
    a.lerp(b, t.clamp(0.0, 1.0))
}

/// 0 below 0, 1 above, over a width of `soft`.
fn edge(value: f32, soft: f32) -> f32 {
    let t = (value / soft + 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
