//! Periodic profiles seen through a pixel: the CPU twin of `coverage.wgsl`.
//!
//! In: a position in the period (0 at the middle of a stripe) and w, how far the phase moves along the two sides of a
//! pixel. Out: the share of the pixel that is stripe, and its derivative. Inside a pixel the phase is linear, so the mean
//! over the pixel's square is the profile through two boxes, one per side: a trapezoid, whose integral over a pulse, a
//! sine and a saw-tooth is known in closed form. That is what supersampling converges to.

use bevy::math::{Vec2, Vec4};
use std::f32::consts::{PI, TAU};

/// The share of a pixel that a stripe covers.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Coverage {
    /// 0 (gap) to 1 (stripe).
    pub value: f32,
    /// Its derivative, per period.
    pub slope: f32,
}

/// Behind this nothing but the mean is left.
const MAX_PERIODS: f32 = 64.0;
/// The signs of a second difference over the trapezoid's four corners.
const CORNERS: Vec4 = Vec4::new(1.0, -1.0, -1.0, 1.0);

/// The trapezoid: reach of its foot and of its top, and the product of the boxes' widths.
struct Pixel {
    foot: f32,
    top: f32,
    area: f32,
}

impl Pixel {
    fn new(w: Vec2) -> Self {
        let a = w.max_element().clamp(1e-4, MAX_PERIODS);
        // A tenth does not show, and keeps the differences below exact.
        let b = w.min_element().clamp(0.1 * a, MAX_PERIODS);
        Self {
            foot: 0.5 * (a + b),
            top: 0.5 * (a - b),
            area: a * b,
        }
    }

    /// The trapezoid's corners, seen from x.
    fn corners(&self, x: f32) -> Vec4 {
        x + Vec4::new(self.foot, self.top, -self.top, -self.foot)
    }

    fn signs(&self) -> Vec4 {
        CORNERS / self.area
    }
}

/// A step from 0 to 1 at t = 0, through the trapezoid.
fn step_coverage(t: f32, pixel: &Pixel) -> Coverage {
    let at = t.clamp(-pixel.foot, pixel.foot);
    let r = pixel.corners(at).max(Vec4::ZERO);
    Coverage {
        value: 0.5 * pixel.signs().dot(r * r),
        slope: pixel.signs().dot(r),
    }
}

fn wrapped(x: f32) -> f32 {
    x - x.round()
}

/// Two boxes as wide as `softness` (0..=1) asks for, next to those of the pixel, in periods. At softness 1 the stripe's
/// slopes meet.
pub fn soft_width(softness: f32, duty: f32, w: Vec2) -> Vec2 {
    let soft = 0.5 * softness * duty.min(1.0 - duty);
    Vec2::new(soft.hypot(w.x), soft.hypot(w.y))
}

/// Stripes that take the share `duty` of each period, centred on x = 0; w in periods per pixel.
pub fn pulse_coverage(x: f32, duty: f32, w: Vec2) -> Coverage {
    let pixel = Pixel::new(w);
    let u = wrapped(x);
    let h = 0.5 * duty;
    if pixel.foot > 0.5 {
        // More than two edges are in reach: differences of the second integral of the profile less its mean.
        let beyond = pixel.corners(u);
        let at = beyond - beyond.round();
        let inside = at.clamp(Vec4::splat(-h), Vec4::splat(h));
        let integral = at * at * (1.0 - duty) - (at - inside) * (at - inside);
        return Coverage {
            value: duty + 0.5 * pixel.signs().dot(integral),
            slope: pixel.signs().dot(inside - duty * at),
        };
    }
    let v = u.abs();
    let [near, far, next] = [h - v, h + v, h + v - 1.0].map(|t| step_coverage(t, &pixel));
    Coverage {
        value: near.value + far.value + next.value - 1.0,
        slope: u.signum() * (far.slope + next.slope - near.slope),
    }
}

/// The share of a wave's first harmonic that passes the filter.
fn harmonic_passed(w: Vec2) -> f32 {
    let sinc = |w: f32| {
        let a = PI * w.min(MAX_PERIODS);
        if a < 1e-3 { 1.0 } else { a.sin() / a }
    };
    sinc(w.x) * sinc(w.y)
}

/// A sine with its crest at x = 0; w in periods per pixel.
pub fn sine_coverage(x: f32, w: Vec2) -> Coverage {
    let passed = harmonic_passed(w);
    let (sin, cos) = (TAU * wrapped(x)).sin_cos();
    Coverage {
        value: 0.5 + 0.5 * passed * cos,
        slope: -PI * passed * sin,
    }
}

/// A ramp from 0 to 1 that drops at x = -1/4 (where sin Φ = 0 and rises); w in periods per pixel.
pub fn sawtooth_coverage(x: f32, w: Vec2) -> Coverage {
    let pixel = Pixel::new(w);
    let u = (x + 0.25).rem_euclid(1.0);
    if pixel.foot > 0.5 {
        let at = pixel.corners(u).map(|at| at.rem_euclid(1.0));
        let integral = at * (at * (at / 6.0 - 0.25) + 1.0 / 12.0);
        return Coverage {
            value: 0.5 + pixel.signs().dot(integral),
            slope: pixel.signs().dot(0.5 * at * (at - 1.0)),
        };
    }
    let [drop, next] = [u, u - 1.0].map(|t| step_coverage(t, &pixel));
    Coverage {
        value: u + 1.0 - drop.value - next.value,
        slope: 1.0 - drop.slope - next.slope,
    }
}
