//! Image files, told apart by their first bytes: PNG is read by Bevy, JPEG by a decoder of its own, because Bevy is built
//! without one here.

use bevy::{
    asset::RenderAssetUsages,
    image::{CompressedImageFormats, ImageFormat, ImageSampler, ImageType},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use std::path::Path;
use zune_jpeg::{
    JpegDecoder,
    errors::DecodeErrors,
    zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions},
};

/// Reads an image file. Errors name the file.
pub fn open(path: &Path) -> Result<Image, String> {
    let read = || {
        let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
        match bytes.as_slice() {
            [0x89, b'P', b'N', b'G', ..] => png(&bytes),
            [0xff, 0xd8, ..] => jpeg(bytes),
            _ => Err("is neither a PNG nor a JPEG file".to_owned()),
        }
    };
    read().map_err(|error| format!("{}: {error}", path.display()))
}

fn png(bytes: &[u8]) -> Result<Image, String> {
    let kind = ImageType::Format(ImageFormat::Png);
    let (formats, sampler) = (CompressedImageFormats::NONE, ImageSampler::Default);
    let image = Image::from_buffer(bytes, kind, formats, true, sampler, RenderAssetUsages::default());
    let mut image = image.map_err(|error| format!("cannot be read as PNG: {error}"))?;
    if image.texture_descriptor.format == TextureFormat::Rgba16Unorm {
        // Bevy knows no sRGB of 16 bits and would take the colours for linear. The high bytes are enough.
        image.data = image
            .data
            .map(|data| data.as_chunks::<2>().0.iter().map(|texel| texel[1]).collect());
        image.texture_descriptor.format = TextureFormat::Rgba8UnormSrgb;
    }
    Ok(image)
}

fn jpeg(bytes: Vec<u8>) -> Result<Image, String> {
    let rgba = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGBA);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), rgba);
    let unread = |error: DecodeErrors| format!("cannot be read as JPEG: {error:?}");
    decoder.decode_headers().map_err(unread)?;
    if let Some(ColorSpace::CMYK | ColorSpace::YCCK) = decoder.input_colorspace() {
        return Err("is in the four colours of printers (CMYK); save it in RGB".to_owned());
    }
    let texels = decoder.decode().map_err(unread)?;
    let (width, height) = decoder.dimensions().ok_or("cannot be read as JPEG: it has no size")?;
    let extent = Extent3d {
        width: width as u32,
        height: height as u32,
        depth_or_array_layers: 1,
    };
    let (format, usage) = (TextureFormat::Rgba8UnormSrgb, RenderAssetUsages::default());
    let image = Image::new(extent, TextureDimension::D2, texels, format, usage);
    let Some(turned @ 2..=8) = decoder.exif().and_then(|tiff| orientation(tiff)) else {
        return Ok(image);
    };
    let picture = image.try_into_dynamic().map_err(|error| error.to_string())?;
    let upright = match turned {
        2 => picture.fliph(),
        3 => picture.rotate180(),
        4 => picture.flipv(),
        5 => picture.rotate90().fliph(),
        6 => picture.rotate90(),
        7 => picture.rotate270().fliph(),
        _ => picture.rotate270(),
    };
    Ok(Image::from_dynamic(upright, true, usage))
}

/// How the camera was held: the number at tag 0x0112 of the first directory of Exif data.
fn orientation(tiff: &[u8]) -> Option<u32> {
    let number = |at: usize, bytes: usize| {
        let part = tiff.get(at..at + bytes)?;
        let append = |number: u32, byte: &u8| number << 8 | u32::from(*byte);
        Some(if tiff.starts_with(b"II") {
            part.iter().rev().fold(0, append)
        } else {
            part.iter().fold(0, append)
        })
    };
    let directory = number(4, 4)? as usize;
    let mut entries = (0..number(directory, 2)? as usize).map(|k| directory + 2 + 12 * k);
    let entry = entries.find(|&at| number(at, 2) == Some(0x0112))?;
    number(entry + 8, 2)
}
