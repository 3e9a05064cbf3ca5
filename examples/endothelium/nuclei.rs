//! What lies in the cells: a texture of nuclei, as in figure 9 of Kratz et al. 2013.

use bevy::{
    asset::RenderAssetUsages,
    image::ImageSampler,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

/// Tiles of the atlas, side by side.
pub const TILES: u32 = 6;
/// Width and height of a tile in pixels; soft shapes need no more.
const TILE: u32 = 40;

/// An atlas of nuclei of several sizes, each a little off the middle of its tile.
pub fn atlas() -> Image {
    let texels = (0..TILE).flat_map(|y| (0..TILES * TILE).map(move |x| (x / TILE, x % TILE, y)));
    let data = texels.flat_map(|(tile, x, y)| {
        let p = (Vec2::new(x as f32, y as f32) + 0.5) / TILE as f32 * 2.0 - 1.0;
        texel(tile as f32, p).map(|c| (255.0 * c).round() as u8)
    });
    let mut image = Image::new(
        Extent3d {
            width: TILES * TILE,
            height: TILE,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        data.collect(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    image.sampler = ImageSampler::linear();
    image
}

/// Colour (sRGB) and alpha of a tile at a point of [-1, 1]².
fn texel(tile: f32, p: Vec2) -> [f32; 4] {
    let middle = 0.10 * Vec2::new((2.4 * tile).sin(), (1.7 * tile + 1.0).sin());
    let radius = 0.30 + 0.04 * (3.1 * tile).cos();
    let from_middle = p.distance(middle) / radius;
    let nucleus = 1.0 - smooth(0.75, 1.2, from_middle);
    // Its middle is a little lighter than its rim.
    let shade = 0.75 + 0.25 * smooth(0.2, 0.9, from_middle);
    [0.48 / shade, 0.13 / shade, 0.22 / shade, 0.75 * nucleus]
}

fn smooth(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
