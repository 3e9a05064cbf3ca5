//! Strokes of a tone: the theorems at the head of `hatch_strokes.rs`, on its public twin.

use bevy::math::Vec2;
use bevy_field_patterns::material::hatch_strokes::*;

const SHARES: [f32; 8] = [0.01, 0.08, 0.2, 0.35, 0.5, 0.66, 0.8, 1.0];
const FINE: Vec2 = Vec2::splat(1e-3);

fn positions() -> impl Iterator<Item = f32> {
    (0..499).map(|k| (k as f32 + 0.5) / 499.0 - 0.5)
}

fn mean(of: impl Fn(f32) -> f32) -> f32 {
    positions().map(of).sum::<f32>() / 499.0
}

#[test]
fn ink_covers_the_share_of_a_tone() {
    for share in SHARES {
        for octaves in [0.0, 0.3, 1.0, 1.9, 3.5] {
            for softness in [0.0, 0.7] {
                for w in [FINE, Vec2::new(0.1, 0.03), Vec2::new(0.7, 0.5)] {
                    let found = mean(|x| stroke_coverage(x, share, octaves, softness, w));
                    // Soft edges that meet are ink only once.
                    let met = (share * (1.0 + softness) - 1.0).max(0.0);
                    assert!(
                        found - share < 0.01 && share - found < 0.01 + 0.1 * met,
                        "{found} of {share} at {octaves} octaves, softness {softness}, {w}"
                    );
                }
            }
        }
    }
}

/// The most that a lighter tone inks and the darker one does not.
fn lost(width: f32, density: f32, zoom: f32, softness: f32, w: Vec2) -> f32 {
    let ink = |x, share: f32| {
        let octaves = (zoom + density * (share / width).log2()).clamp(0.0, MAX_OCTAVES);
        if density <= 1.0 {
            assert_eq!(octaves, octaves_of(share, width, density, zoom, MAX_OCTAVES));
        }
        stroke_coverage(x, share, octaves, softness, w)
    };
    let shares = (1..=40).map(|k| k as f32 / 40.0);
    shares
        .flat_map(|share| positions().map(move |x| ink(x, share - 1.0 / 80.0) - ink(x, share)))
        .fold(0.0, f32::max)
}

#[test]
fn a_darker_tone_keeps_the_strokes_of_a_lighter_one() {
    for width in [0.1, 0.3, 0.8] {
        for density in [0.0, 0.5, 1.0] {
            for zoom in [0.0, 0.4, 2.6] {
                for softness in [0.0, 0.5, 1.0] {
                    for w in [FINE, Vec2::new(0.06, 0.02), Vec2::new(0.4, 0.3)] {
                        let lost = lost(width, density, zoom, softness, w);
                        assert!(
                            lost < 2e-3,
                            "{lost} lost at width {width}, density {density}, zoom {zoom}, softness {softness}, {w}"
                        );
                    }
                }
            }
        }
    }
    // Strokes that multiply faster than the tone darkens grow thinner, which is why density ends at 1.
    assert!(lost(0.1, 1.5, 0.0, 0.0, FINE) > 0.5);
}

#[test]
fn nearer_by_strokes_stay_and_new_ones_come_between() {
    let drawn = |x: f32, octaves| stroke_coverage(x, 0.3, octaves, 0.0, FINE) > 0.5;
    for n in 0..5 {
        let many = f32::exp2(n as f32);
        let centers = (0..1 << n).map(|k| k as f32 / many);
        for near in [n as f32, n as f32 + 0.4, n as f32 + 1.5, 6.7] {
            assert!(centers.clone().all(|x| drawn(x, near)), "octave {n} seen at {near}");
        }
        let between = 0.5 / many;
        assert!(!drawn(between, n as f32) && drawn(between, n as f32 + 0.5));
    }
}

#[test]
fn strokes_are_the_same_for_a_phase_and_its_mirror() {
    for x in positions() {
        for octaves in [0.0, 0.7, 2.2] {
            let [here, there] = [x, -x].map(|x| stroke_coverage(x, 0.4, octaves, 0.4, Vec2::new(0.05, 0.01)));
            assert!((here - there).abs() < 1e-4, "{x}: {here} and {there}");
        }
    }
    // So they are for a phase a half period on only while there are new strokes as wide as the old ones.
    assert!((stroke_coverage(0.5, 0.4, 0.0, 0.0, FINE) - stroke_coverage(0.0, 0.4, 0.0, 0.0, FINE)).abs() > 0.9);
}

#[test]
fn crossed_strokes_ink_the_share_and_none_of_them_gets_lighter() {
    for cross_from in [0.0, 0.4, 0.9, 1.0] {
        let mut before = [0.0; 2];
        for k in 0..=100 {
            let share = k as f32 / 100.0;
            let shares = crossed_shares(share, cross_from);
            let union = 1.0 - (1.0 - shares[0]) * (1.0 - shares[1]);
            assert!((union - share).abs() < 1e-5, "{union} of {share}");
            assert!(shares[1] <= shares[0] + 1e-6 && (shares[1] == 0.0) == (share <= cross_from));
            assert!(shares[0] > before[0] - 1e-6 && shares[1] > before[1] - 1e-6);
            before = shares;
        }
    }
    // Of a cross field both are alike.
    assert_eq!(
        crossed_shares(0.36, 0.0).map(|share| (share * 100.0).round()),
        [20.0, 20.0]
    );
}
