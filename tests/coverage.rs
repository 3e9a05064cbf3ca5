//! The closed forms of filtered profiles, against brute force.

use bevy::math::Vec2;
use bevy_field_patterns::material::coverage::*;
use std::f32::consts::TAU;

/// x in -0.5..0.5 of its period.
fn wrapped(x: f32) -> f32 {
    x - x.round()
}

/// The same filter by brute force: the mean of the unfiltered profile over the pixel's square.
fn filtered(profile: impl Fn(f32) -> f32, x: f32, w: Vec2) -> f32 {
    let n = 200;
    let side = |k: i32| (k as f32 + 0.5) / n as f32 - 0.5;
    let row = |k: i32| (0..n).map(|l| profile(x + w.x * side(k) + w.y * side(l))).sum::<f32>();
    (0..n).map(row).sum::<f32>() / (n * n) as f32
}

const WIDTHS: [Vec2; 6] = [
    Vec2::new(0.05, 0.02),
    Vec2::new(0.1, 0.3),
    Vec2::new(0.4, 0.4),
    Vec2::new(0.9, 0.3),
    Vec2::new(0.7, 1.6),
    Vec2::new(3.3, 0.4),
];

#[test]
fn closed_forms_are_the_mean_over_the_pixel() {
    for duty in [0.3, 0.8] {
        for w in WIDTHS {
            for k in 0..20 {
                let x = k as f32 / 10.0 - 1.003;
                let pulse = filtered(|x| f32::from(wrapped(x).abs() < 0.5 * duty), x, w);
                assert!((pulse - pulse_coverage(x, duty, w).value).abs() < 6e-3, "pulse {x} {w}");
                let sine = filtered(|x| 0.5 + 0.5 * (TAU * x).cos(), x, w);
                assert!((sine - sine_coverage(x, w).value).abs() < 1e-3, "sine {x} {w}");
                let saw = filtered(|x| (x + 0.25).rem_euclid(1.0), x, w);
                assert!((saw - sawtooth_coverage(x, w).value).abs() < 6e-3, "saw-tooth {x} {w}");
            }
        }
    }
}

#[test]
fn slopes_are_derivatives() {
    let h = 1e-3;
    for w in [Vec2::new(0.2, 0.1), Vec2::new(0.9, 0.6), Vec2::new(2.3, 1.2)] {
        let profiles: [&dyn Fn(f32) -> Coverage; 3] =
            [&|x| pulse_coverage(x, 0.4, w), &|x| sine_coverage(x, w), &|x| {
                sawtooth_coverage(x, w)
            }];
        for (index, profile) in profiles.iter().enumerate() {
            for k in 0..50 {
                let x = k as f32 * 0.02 + 0.003;
                let difference = (profile(x + h).value - profile(x - h).value) / (2.0 * h);
                assert!(
                    (difference - profile(x).slope).abs() < 0.1,
                    "profile {index} at {x}, {w}: {difference} {}",
                    profile(x).slope
                );
            }
        }
    }
}

#[test]
fn whole_periods_and_endless_pixels_leave_the_mean() {
    for k in 0..10 {
        let x = k as f32 / 10.0;
        for w in [Vec2::new(1.0, 0.3), Vec2::new(0.4, 3.0), Vec2::INFINITY] {
            assert!((pulse_coverage(x, 0.3, w).value - 0.3).abs() < 1e-3);
            assert!((sine_coverage(x, w).value - 0.5).abs() < 1e-3);
            assert!((sawtooth_coverage(x, w).value - 0.5).abs() < 1e-3);
        }
        // The extremes of the duty are all gap and all stripe; a close view has clean flats.
        for w in [Vec2::splat(0.2), Vec2::new(1e-3, 1e-6), Vec2::ZERO] {
            assert!(pulse_coverage(x, 0.0, w).value.abs() < 1e-5);
            assert!((pulse_coverage(x, 1.0, w).value - 1.0).abs() < 1e-5);
        }
    }
    assert!((pulse_coverage(0.1, 0.5, Vec2::new(1e-3, 1e-6)).value - 1.0).abs() < 1e-5);
}
