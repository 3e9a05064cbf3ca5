//! How even planar samples are.

use crate::*;

/// Limits of nn cv, area cv, hole, and of nn p1 from below.
fn assert_even(metric: &impl PlanarMetric, [nn_cv, area_cv, hole, p1]: [f32; 4]) {
    for seed in 0..8 {
        let sampling = PlanarSampling {
            seed,
            tolerance: 0.0,
            ..PlanarSampling::count(4000)
        };
        let q = quality(metric, &sample(metric, &sampling));
        assert!(
            q.nn_cv <= nn_cv && q.area_cv <= area_cv && q.hole <= hole && q.nn_p1 >= p1,
            "seed {seed}: {q:?}"
        );
        assert_eq!(q.empty_cells, 0);
    }
}

#[test]
fn kites_make_even_samples() {
    assert_even(&isotropic, [0.07, 0.085, 0.80, 0.74]);
    assert_even(&ratio_4, [0.07, 0.085, 0.80, 0.74]);
    assert_even(&vortex, [0.09, 0.10, 0.82, 0.74]);
}

/// Where ellipses lie across a corner, the two sides of the border share their samples.
#[test]
fn sharp_corners_are_not_crowded() {
    // The angle in the metric.
    let across = |angle: f64| {
        let ratio = 1.0 / (0.5 * angle.to_radians()).tan();
        move |_: DVec2| of_ratio(-TAU / 8.0, ratio)
    };
    for angle in [6.0, 12.0, 25.0, 45.0, 60.0] {
        let metric = across(angle);
        let q = quality(&metric, &sample(&metric, &PlanarSampling::count(4000)));
        assert!(q.nn_min > 0.45 && q.hole < 0.85, "{angle} degrees: {q:?}");
    }
    let wedge = PlanarDomain::Polygon {
        outline: vec![DVec2::ZERO, DVec2::new(1.0, -0.1), DVec2::new(1.0, 0.1)],
        holes: Vec::new(),
    };
    let samples = sample_in(&wedge, &isotropic, &PlanarSampling::count(1000));
    let q = planar_quality(&wedge, &isotropic, &samples.positions).expect("samples");
    assert!(q.nn_min > 0.45 && q.hole < 0.85, "{q:?}");
}

#[test]
fn stars_keep_their_limits() {
    let cv = |metric: fn(DVec2) -> SymmetricDMat2| quality(&metric, &sample(&metric, &star(4000, 10))).nn_cv;
    assert!(cv(isotropic) <= 0.10, "{}", cv(isotropic));
    assert!(cv(ratio_4) <= 0.105, "{}", cv(ratio_4));
    assert!(cv(vortex) <= 0.13, "{}", cv(vortex));
}

#[test]
fn grading_is_true() {
    let sampling = PlanarSampling {
        steps: 30,
        tolerance: 0.0,
        ..PlanarSampling::count(4000)
    };
    let q = quality(&graded, &sample(&graded, &sampling));
    assert!((q.grading - 1.0).abs() < 0.05, "{q:?}");
}

#[test]
fn noise_is_blue() {
    let low = |metric: fn(DVec2) -> SymmetricDMat2, steps: u32, of: SymmetricDMat2| {
        let sampling = PlanarSampling {
            steps,
            tolerance: 0.0,
            ..PlanarSampling::count(4000)
        };
        let points = sample(&metric, &sampling).positions;
        power_spectrum(&points, DVec2::ZERO, DVec2::ONE, 80).low_frequency(of)
    };
    assert!(low(isotropic, 10, SymmetricDMat2::IDENTITY) <= 0.015);
    assert!(low(ratio_4, 10, ratio_4(DVec2::ZERO)) <= 0.015);
    // It can be seen when it is not.
    assert!(low(isotropic, 0, SymmetricDMat2::IDENTITY) > 0.03);
    assert!(low(ratio_4, 10, SymmetricDMat2::IDENTITY) > 0.03);
}

#[test]
fn paper_from_end_to_end() {
    let metric = |p: DVec2| vortex(p) * 14_000.0;
    let samples = sample(&metric, &PlanarSampling::paper());
    assert_eq!(samples.scale, 1.0);
    let expected = 14_000.0 / (2.0 * 3.0_f64.sqrt());
    let ratio = samples.len() as f64 / expected;
    assert!(
        (0.9..1.4).contains(&ratio),
        "{} samples, {expected} in a hexagonal packing",
        samples.len()
    );
    let q = quality(&metric, &samples);
    assert!(q.nn_cv < 0.14 && q.empty_cells == 0, "{q:?}");
    // Twice the rate, twice the samples.
    let twice = PlanarSampling {
        density: Density::FillRate(1.1),
        ..PlanarSampling::paper()
    };
    let growth = sample(&metric, &twice).len() as f64 / samples.len() as f64;
    assert!((1.8..2.2).contains(&growth), "{growth}");
}
