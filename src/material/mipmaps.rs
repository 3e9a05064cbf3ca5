//! Mip levels: smaller and smaller copies of an image, so that it can be drawn small without sparkling.
//!
//! In: images of one level. Out: the same with all levels down to one texel. Each texel is the mean of the area it covers,
//! in linear light and weighted by alpha: what is transparent has no colour to give.

use super::PatternTextureMaterial;
use crate::error::PatternError;
use bevy::{
    asset::AssetMut,
    platform::collections::HashSet,
    prelude::*,
    render::render_resource::{TextureDimension, TextureFormat},
};

/// The image with mip levels down to one texel, of any size, powers of two or not. An image that has levels stays as it is.
///
/// The images of a [`PatternTextureMaterial`] get them by themselves, as soon as they are loaded.
///
/// # Errors
/// [`PatternError::Image`]: the image's data is not there, it is not a single 2D image, or its format is neither
/// `Rgba8UnormSrgb` nor `Rgba8Unorm`.
pub fn with_mipmaps(mut image: Image) -> Result<Image, PatternError> {
    generate(&mut image)?;
    Ok(image)
}

fn generate(image: &mut Image) -> Result<(), PatternError> {
    let descriptor = &image.texture_descriptor;
    if descriptor.mip_level_count > 1 {
        return Ok(());
    }
    let wrong = |what: String| Err(PatternError::Image(what));
    let srgb = match descriptor.format {
        TextureFormat::Rgba8UnormSrgb => true,
        TextureFormat::Rgba8Unorm => false,
        format => {
            return wrong(format!(
                "mip levels are made of Rgba8UnormSrgb and Rgba8Unorm, not of {format:?}"
            ));
        }
    };
    if descriptor.dimension != TextureDimension::D2 || descriptor.size.depth_or_array_layers != 1 {
        return wrong("mip levels are made of a single 2D image".into());
    }
    let (width, height) = (descriptor.size.width as usize, descriptor.size.height as usize);
    let Some(data) = image.data.as_mut().filter(|data| data.len() == 4 * width * height) else {
        return wrong(
            "its data was moved to the GPU; load it with RenderAssetUsages::MAIN_WORLD | RENDER_WORLD".into(),
        );
    };
    let transfer = Transfer::new(srgb);
    let mut level = Level {
        width,
        height,
        texels: data
            .as_chunks::<4>()
            .0
            .iter()
            .map(|&texel| transfer.read(texel))
            .collect(),
    };
    let mut levels = 1;
    while level.width.max(level.height) > 1 {
        level = level.halved();
        data.extend(level.texels.iter().flat_map(|&texel| transfer.write(texel)));
        levels += 1;
    }
    image.texture_descriptor.mip_level_count = levels;
    Ok(())
}

/// Between bytes and linear light, premultiplied.
struct Transfer {
    srgb: bool,
    linear: [f32; 256],
}

impl Transfer {
    fn new(srgb: bool) -> Self {
        let linear = std::array::from_fn(|byte| {
            let value = byte as f32 / 255.0;
            if srgb { Srgba::gamma_function(value) } else { value }
        });
        Self { srgb, linear }
    }

    fn read(&self, [r, g, b, a]: [u8; 4]) -> Vec4 {
        let alpha = f32::from(a) / 255.0;
        let color = [r, g, b].map(|byte| self.linear[usize::from(byte)]);
        // An all but vanishing weight keeps the colour of what is wholly transparent.
        (Vec3::from(color) * alpha.max(1e-4)).extend(alpha)
    }

    fn write(&self, texel: Vec4) -> [u8; 4] {
        let color = texel.truncate() / texel.w.max(1e-4);
        let byte = |value: f32| (255.0 * value).round() as u8;
        let encoded = |value: f32| {
            byte(if self.srgb {
                Srgba::gamma_function_inverse(value)
            } else {
                value
            })
        };
        [encoded(color.x), encoded(color.y), encoded(color.z), byte(texel.w)]
    }
}

struct Level {
    width: usize,
    height: usize,
    texels: Vec<Vec4>,
}

impl Level {
    /// Half as wide and high, rounded down; at least 1. Each texel is the mean of its share of the larger image.
    fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let columns: Vec<Share> = (0..width).map(|x| Share::new(x, width, self.width)).collect();
        let rows: Vec<Share> = (0..height).map(|y| Share::new(y, height, self.height)).collect();
        let mut texels = Vec::with_capacity(width * height);
        for row in &rows {
            for column in &columns {
                let line = |(y, weight): (usize, f32)| {
                    let texel = |(x, share): (usize, f32)| share * self.texels[y * self.width + x];
                    weight * column.weights().map(texel).sum::<Vec4>()
                };
                texels.push(row.weights().map(line).sum());
            }
        }
        Self { width, height, texels }
    }
}

/// The texels of a line that a texel of a shorter line covers, and how much of each: at most 3.
struct Share {
    first: usize,
    weights: [f32; 3],
}

impl Share {
    fn new(index: usize, len: usize, of: usize) -> Self {
        let size = of as f32 / len as f32;
        let (begin, end) = (index as f32 * size, (index + 1) as f32 * size);
        let first = begin as usize;
        let covered = |k: usize| {
            let at = (first + k) as f32;
            ((at + 1.0).min(end) - at.max(begin)).max(0.0) / size
        };
        Self {
            first,
            weights: std::array::from_fn(covered),
        }
    }

    fn weights(&self) -> impl Iterator<Item = (usize, f32)> {
        let weights = self.weights.into_iter().enumerate();
        // Rounding must not reach behind the last texel.
        weights
            .filter(|weight| weight.1 > 1e-4)
            .map(|(k, weight)| (self.first + k, weight))
    }
}

/// Gives mip levels to the images of materials, once they are loaded, and says so where that cannot be.
pub(super) fn add_mipmaps(
    mut image_changes: MessageReader<AssetEvent<Image>>,
    mut material_changes: MessageReader<AssetEvent<PatternTextureMaterial>>,
    mut materials: ResMut<Assets<PatternTextureMaterial>>,
    images: Option<ResMut<Assets<Image>>>,
    mut refused: Local<HashSet<AssetId<Image>>>,
) {
    // Without a renderer there are none.
    let Some(mut images) = images else { return };
    let mut changed = HashSet::new();
    for event in image_changes.read() {
        match *event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                changed.insert(id);
            }
            AssetEvent::Removed { id } => {
                refused.remove(&id);
            }
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
    let any_material = material_changes.read().count() > 0;
    if changed.is_empty() && !any_material {
        return;
    }
    let mut touched = Vec::new();
    for (id, material) in materials.iter() {
        for image in material.extension.images().map(Handle::id) {
            if changed.contains(&image) {
                // Bevy binds a texture that was made anew only with a material that has changed.
                touched.push(id);
            }
            let lacks_levels =
                |image: &Image| image.texture_descriptor.mip_level_count == 1 && image.size() != UVec2::ONE;
            if refused.contains(&image) || !images.get(image).is_some_and(lacks_levels) {
                continue;
            }
            let Some(mut loaded) = images.get_mut(image) else {
                continue;
            };
            if let Err(error) = generate(&mut loaded) {
                warn!("a texture without mip levels sparkles where it is small: {error}");
                refused.insert(image);
            }
        }
    }
    for id in touched {
        // Access is what marks it.
        materials.get_mut(id).map(AssetMut::into_inner);
    }
}
