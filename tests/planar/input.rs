//! Metrics, domains and numbers that are hard or wrong.

use crate::*;

#[test]
fn violent_metrics() {
    let sampling = PlanarSampling::count(2000);
    // Ratio 100, turning.
    let needles = sample(&wavy(100.0), &sampling);
    assert_eq!(needles.len(), 2000);
    assert!(double_areas(&needles).all(|area| area > 0.0));
    assert_is_a_set(&needles.set());
    // Another one for each hundredth of the square.
    let noise = |p: DVec2| {
        let cell = (p * 100.0).floor();
        let random = (cell.x * 12.9898 + cell.y * 78.233).sin() * 43758.5453;
        let random = random - random.floor();
        ellipse(TAU * random, 1.0 + 9.0 * random, 0.1 + random)
    };
    let samples = sample(&noise, &sampling);
    assert_eq!(samples.len(), 2000);
    assert!(double_areas(&samples).all(|area| area > 0.0));
    // A jump of 1:400 in density: so many more on one side.
    let jump = |p: DVec2| SymmetricDMat2::IDENTITY * if p.x < 0.5 { 1.0 } else { 400.0 };
    let samples = sample(&jump, &sampling);
    let dense = samples.positions.iter().filter(|p| p.x > 0.5).count();
    assert!((1900..2000).contains(&dense), "{dense}");
    // A singularity in the middle, whose metric area is finite.
    let pole = |p: DVec2| SymmetricDMat2::IDENTITY / (p - 0.5).length();
    let samples = sample(&pole, &sampling);
    let near = samples
        .positions
        .iter()
        .filter(|p| p.distance(DVec2::splat(0.5)) < 0.1)
        .count();
    let share = near as f64 / samples.len() as f64;
    // 2π r / ∫ 1/|p| = 0.628 / 3.5255 of the samples.
    assert!(
        (share / (0.2 * std::f64::consts::PI / 3.5255) - 1.0).abs() < 0.1,
        "{share}"
    );
}

#[test]
fn any_unit_will_do() {
    let samples = sample(&ratio_4, &PlanarSampling::count(500));
    for unit in [1e-30, 1e30] {
        let domain = PlanarDomain::Rectangle {
            min: DVec2::ZERO,
            max: DVec2::splat(unit),
        };
        let metric = |p: DVec2| ratio_4(p) * 1e20;
        let other = sample_in(&domain, &metric, &PlanarSampling::count(500));
        let q = planar_quality(&domain, &metric, &other.positions).expect("samples");
        assert!((q.nn_mean - quality(&ratio_4, &samples).nn_mean).abs() < 0.02, "{q:?}");
    }
}

#[test]
fn bad_input_is_an_error() {
    let one = PlanarSampling::count(1000);
    let square = PlanarDomain::default();
    let not_finite = |p: DVec2| isotropic(p) * if p.x > 0.9 { f64::NAN } else { 1.0 };
    assert!(matches!(
        error(&square, &not_finite, &one),
        PatternError::NotFinite { .. }
    ));
    let infinite = |p: DVec2| isotropic(p) * if p.x > 0.9 { f64::INFINITY } else { 1.0 };
    assert!(matches!(
        error(&square, &infinite, &one),
        PatternError::NotFinite { .. }
    ));
    let flat = |p: DVec2| ellipse(0.0, 1.0, 1.0) * if p.y < 0.1 { 0.0 } else { 1.0 };
    assert!(matches!(error(&square, &flat, &one), PatternError::NotPositive { .. }));
    let saddle = |_: DVec2| SymmetricDMat2 {
        m00: 1.0,
        m01: 2.0,
        m11: 1.0,
    };
    assert!(matches!(
        error(&square, &saddle, &one),
        PatternError::NotPositive { .. }
    ));

    for density in [
        Density::Count(0),
        Density::Count(u32::MAX),
        Density::FillRate(0.0),
        Density::FillRate(f32::NAN),
    ] {
        let sampling = PlanarSampling { density, ..one.clone() };
        assert!(
            matches!(error(&square, &isotropic, &sampling), PatternError::OutOfRange { .. }),
            "{density:?}"
        );
    }
    let dense = |p: DVec2| isotropic(p) * 1e12;
    assert!(matches!(
        error(&square, &dense, &PlanarSampling::paper()),
        PatternError::OutOfRange { .. }
    ));
    let tolerance = PlanarSampling {
        tolerance: f32::NAN,
        ..one.clone()
    };
    assert!(matches!(
        error(&square, &isotropic, &tolerance),
        PatternError::OutOfRange { .. }
    ));

    let progress = Progress::default();
    progress.cancel();
    assert_eq!(
        sample_plane(&square, &isotropic, &one, &progress),
        Err(PatternError::Cancelled)
    );
}

#[test]
fn bad_domains_are_errors() {
    let points = |list: &[[f64; 2]]| list.iter().map(|&p| DVec2::from_array(p)).collect::<Vec<DVec2>>();
    let square = points(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
    let hole = points(&[[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [1.0, 3.0]]);
    let shifted = |by: f64| hole.iter().map(|&p| p + by).collect::<Vec<DVec2>>();
    let inner: Vec<DVec2> = hole.iter().map(|&p| 0.25 * (p - 2.0) + 2.0).collect();
    let polygon = |outline: &[DVec2], holes: &[&Vec<DVec2>]| PlanarDomain::Polygon {
        outline: outline.to_vec(),
        holes: holes.iter().map(|&hole| hole.clone()).collect(),
    };
    let rectangle = |x: f64, y: f64| PlanarDomain::Rectangle {
        min: DVec2::ZERO,
        max: DVec2::new(x, y),
    };
    let bad = [
        rectangle(0.0, 1.0),
        rectangle(-1.0, 1.0),
        rectangle(f64::NAN, 1.0),
        rectangle(f64::INFINITY, 1.0),
        polygon(&square[..2], &[]),
        polygon(&[], &[]),
        polygon(&points(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]), &[]),
        polygon(&points(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.5]]), &[]),
        polygon(&points(&[[0.0, 0.0], [1.0, f64::NAN], [1.0, 1.0]]), &[]),
        polygon(&square, &[&shifted(10.0)]),
        polygon(&square, &[&shifted(1.5)]),
        polygon(&square, &[&shifted(1.0)]),
        polygon(&square, &[&hole, &inner]),
        polygon(&square, &[&hole, &hole]),
        polygon(&square, &[&hole[..2].to_vec()]),
        polygon(&[square.as_slice(), &square[..1]].concat(), &[]),
    ];
    for domain in bad {
        let error = error(&domain, &isotropic, &PlanarSampling::count(100));
        assert!(matches!(error, PatternError::Domain(_)), "{domain:?}: {error:?}");
    }
    // And those are none.
    sample_in(&polygon(&square, &[&hole]), &isotropic, &PlanarSampling::count(100));
    let clockwise: Vec<DVec2> = square.iter().rev().copied().collect();
    sample_in(&polygon(&clockwise, &[]), &isotropic, &PlanarSampling::count(100));
}

/// More corners than samples.
#[test]
fn a_traced_outline() {
    let circle = (0..2000)
        .map(|i| DVec2::from_angle(TAU * f64::from(i) / 2000.0) * 3.0)
        .collect();
    let domain = PlanarDomain::Polygon {
        outline: circle,
        holes: Vec::new(),
    };
    for count in [1, 2, 50, 500] {
        let samples = sample_in(&domain, &isotropic, &PlanarSampling::count(count));
        assert_eq!(samples.len(), count as usize);
        assert!(samples.positions.iter().all(|&p| domain.contains(p)));
        assert_is_a_set(&samples.set());
        let q = planar_quality(&domain, &isotropic, &samples.positions).expect("samples");
        assert!(q.empty_cells == 0 && q.hole < 1.1, "{q:?}");
    }
}

#[test]
fn grid_of_metrics() {
    let bounds = (DVec2::new(-1.0, 0.0), DVec2::new(1.0, 3.0));
    let linear = |p: DVec2| SymmetricDMat2 {
        m00: 4.0 + p.x,
        m01: 0.25 * p.y,
        m11: 5.0 - p.y,
    };
    let grid = MetricGrid::bake(bounds, UVec2::new(5, 4), &linear).expect("a metric");
    let near = |a: SymmetricDMat2, b: SymmetricDMat2| {
        (a.m00 - b.m00).abs() + (a.m01 - b.m01).abs() + (a.m11 - b.m11).abs() < 1e-6
    };
    for p in [[0.3, 1.234], [-1.0, 0.0], [1.0, 3.0], [0.99, 0.01]].map(DVec2::from_array) {
        assert!(near(grid.at(p), linear(p)), "{p}");
    }
    assert!(near(grid.at(DVec2::new(7.0, -2.0)), linear(DVec2::new(1.0, 0.0))));
    let one = SymmetricMat2::IDENTITY;
    assert!(near(
        MetricGrid::new(bounds, UVec2::ONE, vec![one])
            .expect("one node")
            .at(DVec2::ZERO),
        SymmetricDMat2::IDENTITY
    ));
    let new = |size, values: Vec<SymmetricMat2>| MetricGrid::new(bounds, size, values);
    assert!(matches!(
        new(UVec2::new(2, 1), vec![one]),
        Err(PatternError::WrongLength { .. })
    ));
    assert!(matches!(new(UVec2::ZERO, vec![]), Err(PatternError::Domain(_))));
    assert!(matches!(
        new(UVec2::ONE, vec![one * f32::NAN]),
        Err(PatternError::NotFinite { .. })
    ));
    assert!(matches!(
        new(UVec2::ONE, vec![one * -1.0]),
        Err(PatternError::NotPositive { index: 0, .. })
    ));
}
