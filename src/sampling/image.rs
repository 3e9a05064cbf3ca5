//! Metrics and importances from images.
//!
//! In: an [`Image`] of any format that can be read on the CPU, and the bounds that it is stretched over, its top at the
//! largest y. Out: linear colours, and a [`MetricGrid`] of its edges.

use super::{
    metric::{Structure, metric_of_pixels},
    planar::MetricGrid,
};
use crate::{error::PatternError, parallel};
use bevy::{
    math::{DVec2, Vec3},
    prelude::*,
};
use glam_matrix_extras::SymmetricMat2;

/// The colours of an image on the CPU: linear RGB, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Pixels {
    /// Linear colours, `size.x` per row.
    pub colors: Vec<Vec3>,
    /// Columns and rows, both at least 1.
    pub size: UVec2,
}

/// Metrics finer than this per side of an image are means over blocks of pixels.
const FINEST_GRID: u32 = 1024;

impl Pixels {
    /// Reads an image.
    ///
    /// # Errors
    /// [`Image`](PatternError::Image) where it has no pixels, where its data are on the GPU only, or in a format that
    /// cannot be read.
    pub fn new(image: &Image) -> Result<Self, PatternError> {
        let size = image.size();
        if size.x == 0 || size.y == 0 {
            return Err(PatternError::Image("it has no pixels".into()));
        }
        let mut colors = Vec::with_capacity((size.x * size.y) as usize);
        for y in 0..size.y {
            for x in 0..size.x {
                let color = image
                    .get_color_at(x, y)
                    .map_err(|error| PatternError::Image(error.to_string()))?;
                let color = color.to_linear().to_vec3();
                colors.push(if color.is_finite() { color } else { Vec3::ZERO });
            }
        }
        Ok(Self { colors, size })
    }

    /// The colour at a point of the unit square, (0, 0) bottom left; bilinear, clamped.
    pub fn at(&self, point: Vec2) -> Vec3 {
        let last = (self.size - 1).as_vec2();
        let p = (Vec2::new(point.x, 1.0 - point.y) * self.size.as_vec2() - 0.5).clamp(Vec2::ZERO, last);
        let p = if p.is_finite() { p } else { Vec2::ZERO };
        let low = p.floor();
        let t = p - low;
        let (a, b) = (low.as_uvec2(), (low.as_uvec2() + 1).min(self.size - 1));
        let pixel = |x: u32, y: u32| self.colors[(y * self.size.x + x) as usize];
        let top = pixel(a.x, a.y).lerp(pixel(b.x, a.y), t.x);
        top.lerp(pixel(a.x, b.y).lerp(pixel(b.x, b.y), t.x), t.y)
    }

    /// Linear luminance (Rec. 709).
    pub fn luminance(color: Vec3) -> f32 {
        color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }

    /// The image with means over blocks in place of pixels, so that no side is longer than `longest`.
    fn reduced(&self, longest: u32) -> Self {
        let block = self.size.max_element().div_ceil(longest.max(1));
        if block <= 1 {
            return self.clone();
        }
        let size = UVec2::new(self.size.x.div_ceil(block), self.size.y.div_ceil(block));
        let colors = parallel::collect((size.x * size.y) as usize, |i| {
            let first = UVec2::new(i as u32 % size.x, i as u32 / size.x) * block;
            let end = (first + block).min(self.size);
            let mut sum = Vec3::ZERO;
            for y in first.y..end.y {
                for x in first.x..end.x {
                    sum += self.colors[(y * self.size.x + x) as usize];
                }
            }
            sum / ((end.x - first.x) * (end.y - first.y)) as f32
        });
        Self { colors, size }
    }

    /// The metric of the image's edges over the rectangle from `min` to `max`. [`Structure::reach`] is in pixels of the
    /// image. A sample of a flat place has a radius of one pixel.
    ///
    /// # Errors
    /// [`Domain`](PatternError::Domain) where the rectangle is empty.
    pub fn metric(&self, min: DVec2, max: DVec2, structure: &Structure) -> Result<MetricGrid, PatternError> {
        let reduced = self.reduced(FINEST_GRID);
        let block = self.size.x as f32 / reduced.size.x as f32;
        let structure = Structure {
            reach: structure.reach / block,
            ..*structure
        };
        // Pixels per unit of length; y points down in the image.
        let scale = reduced.size.as_dvec2() / (max - min) * DVec2::new(1.0, -1.0);
        let metrics = metric_of_pixels(&reduced.colors, reduced.size, &structure);
        let (w, h) = (reduced.size.x as usize, reduced.size.y as usize);
        let rows = (0..h).rev().flat_map(|y| &metrics[y * w..(y + 1) * w]);
        let scaled = rows.map(|m| {
            SymmetricMat2::new(
                (m.m00 * scale.x * scale.x) as f32,
                (m.m01 * scale.x * scale.y) as f32,
                (m.m11 * scale.y * scale.y) as f32,
            )
        });
        MetricGrid::new((min, max), reduced.size, scaled.collect())
    }
}
