//! Frequencies that follow from a distance, from the size of a pixel, or from a scalar.
//!
//! In: a position in the space of the pattern, or a scalar. Out: stripes per unit length.

use bevy::prelude::*;

/// f(r) = f₀ + (f₁ - f₀) · clamp((r - near) / (far - near), 0, 1), r being the distance to a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DistanceRamp {
    /// The ends of the segment.
    pub segment: [Vec3; 2],
    /// The distance up to which the frequency is the near one.
    pub near: f32,
    /// The distance from which on it is the far one, above `near`.
    pub far: f32,
    /// f₀ and f₁.
    pub frequencies: [f32; 2],
}

/// The frequency at `p` of a ramp over the distance to a segment.
pub fn distance_frequency(p: Vec3, ramp: &DistanceRamp) -> f32 {
    let [a, b] = ramp.segment;
    let along = b - a;
    let length = along.length_squared();
    let share = if length > 0.0 {
        ((p - a).dot(along) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let r = p.distance(a + share * along);
    blend(ramp.frequencies, (r - ramp.near) / (ramp.far - ramp.near))
}

/// The size of a pixel as a function of the position: max(least, ⟨p, (x, y, z)⟩ + w), in the unit of length of a pattern.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelSize {
    /// Coefficients of the position and 1.
    pub plane: Vec4,
    /// The size at the camera's near plane: nothing is nearer.
    pub least: f32,
}

impl PixelSize {
    /// The size at `p`.
    pub fn at(&self, p: Vec3) -> f32 {
        self.plane.dot(p.extend(1.0)).max(self.least)
    }
}

/// The frequency at `p` of stripes with a period of `pixels`.
pub fn screen_frequency(p: Vec3, size: &PixelSize, pixels: f32) -> f32 {
    1.0 / (pixels * size.at(p))
}

/// f(s) = f₀ + (f₁ - f₀) · clamp((s - s₀) / (s₁ - s₀), 0, 1) of a scalar s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScalarRamp {
    /// s₀ and s₁, which differ.
    pub values: [f32; 2],
    /// f₀ and f₁.
    pub frequencies: [f32; 2],
}

/// The frequency at a vertex with scalar `s`.
pub fn scalar_frequency(s: f32, ramp: &ScalarRamp) -> f32 {
    let [low, high] = ramp.values;
    blend(ramp.frequencies, (s - low) / (high - low))
}

fn blend([a, b]: [f32; 2], share: f32) -> f32 {
    a + (b - a) * share.clamp(0.0, 1.0)
}
