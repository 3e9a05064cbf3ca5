//! Figures of planar samples, drawn on the CPU: the ellipses of their metrics, and their power spectrum.

use bevy::{
    asset::RenderAssetUsages,
    math::{DVec2, UVec2},
    prelude::Image,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_field_patterns::sampling::{
    metric::SymmetricEigen2,
    planar::{PlanarMetric, PlanarSamples},
    power_spectrum,
};
use std::{fmt::Write as _, path::Path};

use super::common::headless::save_png;

/// Side of a figure of ellipses, in pixels.
const WIDTH: f64 = 320.0;
/// Part of a sample's ellipse that is drawn.
const FILLED: f64 = 0.85;

/// Writes the samples' ellipses as one path of an SVG file, which documentation can include as it is.
pub fn draw_ellipses(path: &Path, samples: &PlanarSamples, sides: DVec2) -> Result<(), String> {
    let scale = WIDTH / sides.x;
    let size = sides * scale;
    let mut outline = String::new();
    for (p, m) in samples.positions.iter().zip(&samples.metrics) {
        let eigen = SymmetricEigen2::new(m);
        let [rx, ry] = [eigen.values.x, eigen.values.y].map(|value| FILLED * scale / value.sqrt());
        // The image's y axis goes down.
        let axis = DVec2::new(eigen.vectors.x_axis.x, -eigen.vectors.x_axis.y);
        let (centre, way) = (DVec2::new(p.x, sides.y - p.y) * scale, axis * rx);
        let (start, angle) = (centre - way, axis.to_angle().to_degrees());
        for sign in [1.0, -1.0] {
            let (x, y) = (2.0 * sign * way.x, 2.0 * sign * way.y);
            if sign > 0.0 {
                let _ = write!(outline, "M{:.1} {:.1}", start.x, start.y);
            }
            let _ = write!(outline, "a{rx:.1} {ry:.1} {angle:.0} 1 0 {x:.1} {y:.1}");
        }
        outline.push('z');
    }
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0}\" height=\"{1:.0}\" viewBox=\"0 0 {0:.0} {1:.0}\"><path \
         fill=\"#4477aa\" d=\"{outline}\"></path></svg>\n",
        size.x, size.y
    );
    std::fs::write(path, svg).map_err(|error| format!("{}: {error}", path.display()))
}

/// Largest frequency of a spectrum, in those of the mean spacing.
const LARGEST: f64 = 2.5;
/// The power that is drawn white; 1 is that of white noise.
const WHITE: f32 = 3.0;

/// Draws the power spectrum, stretched as the metric at the origin is: a set that is even in a constant metric then has
/// the spectrum of an isotropic one. Frequency 0 is in the middle, frequencies on the axes are those of the border.
pub fn draw_spectrum(
    path: &Path,
    samples: &PlanarSamples,
    metric: &impl PlanarMetric,
    sides: DVec2,
    size: u32,
) -> Result<(), String> {
    let m = metric.at(DVec2::ZERO);
    let eigen = SymmetricEigen2::new(&m);
    // M^(1/2): wave vectors of the stretched plane are carried back by it.
    let root = eigen.map(f64::sqrt);
    let mean =
        (2.0 / 3.0_f64.sqrt() * samples.len() as f64 / (sides.element_product() * m.determinant().sqrt())).sqrt();
    // Of the corners' frequencies the largest component.
    let rows = DVec2::new(root.m00.abs() + root.m01.abs(), root.m01.abs() + root.m11.abs());
    let farthest = LARGEST * mean * (rows * sides).max_element();
    let spectrum = power_spectrum(&samples.positions, DVec2::ZERO, sides, farthest.ceil() as u32);
    let (half, row) = (i64::from(spectrum.half), 2 * spectrum.half as usize + 1);
    let mut data = Vec::with_capacity(4 * (size * size) as usize);
    for j in 0..size {
        for i in 0..size {
            let unit = (UVec2::new(i, size - 1 - j).as_dvec2() + 0.5) / f64::from(size) * 2.0 - 1.0;
            let k = (root * (unit * LARGEST * mean) * sides).round().as_i64vec2();
            let inside = k.abs().max_element() <= half;
            let power = if inside {
                spectrum.power[(k.y + half) as usize * row + (k.x + half) as usize]
            } else {
                0.0
            };
            // Sixteen grays make a small file.
            let gray = 17 * (15.0 * (power / WHITE).clamp(0.0, 1.0).sqrt()).round() as u8;
            data.extend([gray, gray, gray, 255]);
        }
    }
    let image = Image::new(
        Extent3d {
            width: size,
            height: size,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::MAIN_WORLD,
    );
    save_png(&image, path)
}
