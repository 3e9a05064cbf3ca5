//! Images for textures on waves, drawn by formula.
//!
//! In: a size in pixels, colours. Out: square images with soft edges; u runs to the right along d, v upwards along
//! n × d. What is not drawn is transparent and has the colour of what is, so that it does not bleed.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

/// An arrow along d.
pub fn arrow(size: u32, color: Srgba) -> Image {
    image(UVec2::splat(size), move |p| {
        // Half of it: it is the same above and below.
        let q = Vec2::new(p.x, p.y.abs());
        let shaft = (q - Vec2::new(-0.2, 0.0)).abs() - Vec2::new(0.5, 0.1);
        let shaft = shaft.max_element();
        // A head from (0.05, 0.34) to the tip at (0.85, 0).
        let side = Vec2::new(0.34, 0.80).normalize();
        let head = side.dot(q - Vec2::new(0.85, 0.0)).max(0.05 - q.x);
        (color, shaft.min(head))
    })
}

/// A dash along d, thin and pale, for where the eye should not rest.
pub fn dash(size: u32, color: Srgba) -> Image {
    image(UVec2::splat(size), move |p| {
        let x = (p.x.abs() - 0.5).max(0.0);
        (color, Vec2::new(x, p.y).length() - 0.09)
    })
}

/// A row of three tiles: minus, dot, plus, on discs of three colours.
pub fn charges(size: u32, colors: [Srgba; 3]) -> Image {
    image(UVec2::new(3 * size, size), move |p| {
        let tile = ((p.x + 3.0) / 2.0).floor().clamp(0.0, 2.0);
        let q = Vec2::new(p.x + 2.0 - 2.0 * tile, p.y);
        let bar = |q: Vec2| (q.abs() - Vec2::new(0.5, 0.13)).max_element();
        let sign = match tile as u8 {
            0 => bar(q),
            1 => q.length() - 0.2,
            _ => bar(q).min(bar(q.yx())),
        };
        (colors[tile as usize], sign)
    })
}

/// An ornament that looks the same after a quarter turn: a woven square.
pub fn weave(size: u32, color: Srgba) -> Image {
    image(UVec2::splat(size), move |p| {
        let ring = (p.length() - 0.62).abs() - 0.11;
        let cross = p.x.abs().min(p.y.abs()) - 0.085;
        let corner = (p.abs() - Vec2::ONE).length() - 0.22;
        (color, ring.min(cross.max(p.length() - 0.36)).min(corner))
    })
}

/// An image of a colour and a signed distance per point; the shorter side reaches from -1 to 1.
fn image(size: UVec2, draw: impl Fn(Vec2) -> (Srgba, f32)) -> Image {
    let short = size.min_element() as f32;
    let mut data = Vec::with_capacity(4 * (size.x * size.y) as usize);
    for y in 0..size.y {
        for x in 0..size.x {
            let pixel = UVec2::new(x, y).as_vec2() + 0.5;
            let (color, distance) = draw((2.0 * pixel - size.as_vec2()) / short);
            // Half a pixel to either side.
            let alpha = (0.5 - 0.5 * distance * short).clamp(0.0, 1.0);
            data.extend([color.red, color.green, color.blue, color.alpha * alpha].map(|c| (255.0 * c).round() as u8));
        }
    }
    let mut image = Image::new(
        Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        address_mode_v: ImageAddressMode::Repeat,
        mag_filter: ImageFilterMode::Linear,
        min_filter: ImageFilterMode::Linear,
        mipmap_filter: ImageFilterMode::Linear,
        ..default()
    });
    image
}
