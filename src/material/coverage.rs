//! Periodic profiles seen through a pixel: the CPU twin of `coverage.wgsl`.
//!
//! In: a position in the period (0 at the middle of a stripe) and the footprint, the share of a period that one pixel
//! covers. Out: the share of the pixel that is stripe, and its derivative. The filter is a box as wide as the footprint,
//! taken twice: a tent, whose integral over a pulse, a sine and a saw-tooth is known in closed form. It vanishes at every
//! multiple of 1 / footprint, so from one period per pixel on nothing but the mean is left.

use std::f32::consts::{PI, TAU};

/// The share of a pixel that a stripe covers.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Coverage {
    /// 0 (gap) to 1 (stripe).
    pub value: f32,
    /// Its derivative, per period.
    pub slope: f32,
}

/// The integral of the unit tent up to `t`.
fn tent_step(t: f32) -> f32 {
    let u = 1.0 - t.abs().min(1.0);
    let half = 0.5 * u * u;
    if t > 0.0 { 1.0 - half } else { half }
}

fn tent(t: f32) -> f32 {
    (1.0 - t.abs()).max(0.0)
}

fn wrapped(x: f32) -> f32 {
    x - x.round()
}

/// The half-width of the tent that `softness` (0..=1) and the footprint `w` make together, in periods.
pub fn soft_width(softness: f32, duty: f32, w: f32) -> f32 {
    let soft = 0.5 * softness * duty.min(1.0 - duty);
    soft.hypot(w).clamp(1e-4, 1.0)
}

/// Stripes that take the share `duty` of each period, centred on x = 0, through a tent of half-width `w` (periods).
pub fn pulse_coverage(x: f32, duty: f32, w: f32) -> Coverage {
    let u = wrapped(x);
    let width = w.clamp(1e-4, 1.0);
    [-1.0, 0.0, 1.0].into_iter().fold(Coverage::default(), |sum, k| {
        let rise = (u + k + 0.5 * duty) / width;
        let fall = (u + k - 0.5 * duty) / width;
        Coverage {
            value: sum.value + tent_step(rise) - tent_step(fall),
            slope: sum.slope + (tent(rise) - tent(fall)) / width,
        }
    })
}

/// A sine with its crest at x = 0, through a tent of half-width `w` (periods).
pub fn sine_coverage(x: f32, w: f32) -> Coverage {
    let a = PI * w.min(1.0);
    let sinc = if a < 1e-3 { 1.0 } else { a.sin() / a };
    let (sin, cos) = (TAU * wrapped(x)).sin_cos();
    Coverage { value: 0.5 + 0.5 * sinc * sinc * cos, slope: -PI * sinc * sinc * sin }
}

/// A ramp from 0 to 1 that drops at x = -1/4 (where sin Φ = 0 and rises), through a tent of half-width `w` (periods).
pub fn sawtooth_coverage(x: f32, w: f32) -> Coverage {
    let u = (x + 0.25).rem_euclid(1.0);
    let width = w.clamp(1e-4, 1.0);
    [0.0, 1.0].into_iter().fold(Coverage { value: u + 1.0, slope: 1.0 }, |sum, k| Coverage {
        value: sum.value - tent_step((u - k) / width),
        slope: sum.slope - tent((u - k) / width) / width,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same filter by brute force: a tent-weighted mean of the unfiltered profile.
    fn filtered(profile: impl Fn(f32) -> f32, x: f32, w: f32) -> f32 {
        let n = 4000;
        let (mut sum, mut weights) = (0.0_f64, 0.0_f64);
        for k in 0..n {
            let t = (k as f32 + 0.5) / n as f32 * 2.0 - 1.0;
            sum += f64::from(tent(t) * profile(x + t * w));
            weights += f64::from(tent(t));
        }
        (sum / weights) as f32
    }

    #[test]
    fn closed_forms_are_the_tent_filter() {
        let duty = 0.3;
        for w in [0.05, 0.2, 0.5, 0.8, 1.0] {
            for k in 0..40 {
                let x = k as f32 / 20.0 - 1.0;
                let pulse = filtered(|x| f32::from(wrapped(x).abs() < 0.5 * duty), x, w);
                assert!((pulse - pulse_coverage(x, duty, w).value).abs() < 2e-3, "pulse {x} {w}");
                let sine = filtered(|x| 0.5 + 0.5 * (TAU * x).cos(), x, w);
                assert!((sine - sine_coverage(x, w).value).abs() < 1e-4, "sine {x} {w}");
                let saw = filtered(|x| (x + 0.25).rem_euclid(1.0), x, w);
                assert!((saw - sawtooth_coverage(x, w).value).abs() < 2e-3, "saw-tooth {x} {w}");
            }
        }
    }

    #[test]
    fn slopes_are_derivatives() {
        let h = 1e-3;
        let profiles: [&dyn Fn(f32) -> Coverage; 3] =
            [&|x| pulse_coverage(x, 0.4, 0.2), &|x| sine_coverage(x, 0.2), &|x| sawtooth_coverage(x, 0.2)];
        for (index, profile) in profiles.iter().enumerate() {
            for k in 0..50 {
                let x = k as f32 * 0.02 + 0.003;
                let difference = (profile(x + h).value - profile(x - h).value) / (2.0 * h);
                assert!((difference - profile(x).slope).abs() < 0.05, "profile {index} at {x}");
            }
        }
    }

    #[test]
    fn one_period_per_pixel_leaves_the_mean() {
        for k in 0..10 {
            let x = k as f32 / 10.0;
            for w in [1.0, 3.0, 1e6] {
                assert!((pulse_coverage(x, 0.3, w).value - 0.3).abs() < 1e-5);
                assert!((sine_coverage(x, w).value - 0.5).abs() < 1e-5);
                assert!((sawtooth_coverage(x, w).value - 0.5).abs() < 1e-5);
            }
            // The extremes of the duty are all gap and all stripe.
            assert!(pulse_coverage(x, 0.0, 0.2).value.abs() < 1e-5);
            assert!((pulse_coverage(x, 1.0, 0.2).value - 1.0).abs() < 1e-5);
        }
    }
}
