//! The planar sampler: theorems, quality, nasty input; all through the public API.

use bevy::math::{DVec2, UVec2};
use bevy_field_patterns::{
    error::PatternError,
    sampling::{
        Density, Progress, SampleQuality, SampleSet,
        planar::{
            Insertion, MetricGrid, PlanarDomain, PlanarMetric, PlanarSamples, PlanarSampling, Relaxation, SliceSampler,
            planar_quality, sample_plane,
        },
        power_spectrum,
    },
};
use glam_matrix_extras::{SymmetricDMat2, SymmetricMat2};
use spade::{DelaunayTriangulation, Point2, Triangulation};
use std::{
    collections::{BTreeSet, HashMap},
    f64::consts::{FRAC_PI_2, TAU},
};

/// The metric whose unit ball has the semi-axes `long` at `angle`, and `short`.
fn ellipse(angle: f64, long: f64, short: f64) -> SymmetricDMat2 {
    let (e, l, s) = (DVec2::from_angle(angle), long.powi(-2), short.powi(-2));
    SymmetricDMat2 {
        m00: l * e.x * e.x + s * e.y * e.y,
        m01: (l - s) * e.x * e.y,
        m11: l * e.y * e.y + s * e.x * e.x,
    }
}

fn of_ratio(angle: f64, ratio: f64) -> SymmetricDMat2 {
    ellipse(angle, ratio.sqrt(), 1.0 / ratio.sqrt())
}

fn isotropic(_: DVec2) -> SymmetricDMat2 {
    SymmetricDMat2::IDENTITY
}

fn ratio_4(_: DVec2) -> SymmetricDMat2 {
    of_ratio(0.5, 4.0)
}

fn vortex(p: DVec2) -> SymmetricDMat2 {
    let d = p - 0.5;
    of_ratio(
        d.to_angle() + FRAC_PI_2,
        1.0 + 9.0 * (1.0 - (-d.length_squared() / 0.06).exp()),
    )
}

fn wavy(ratio: f64) -> impl PlanarMetric {
    move |p: DVec2| of_ratio(0.6 * (TAU * p.x).sin() + 0.6 * (TAU * p.y).cos(), ratio)
}

fn graded(p: DVec2) -> SymmetricDMat2 {
    let size = 0.25 + 1.75 * p.x;
    ellipse(0.0, size, size)
}

fn sample(metric: &impl PlanarMetric, sampling: &PlanarSampling) -> PlanarSamples {
    sample_in(&PlanarDomain::default(), metric, sampling)
}

fn sample_in(domain: &PlanarDomain, metric: &impl PlanarMetric, sampling: &PlanarSampling) -> PlanarSamples {
    sample_plane(domain, metric, sampling, &Progress::default()).expect("a good domain and metric")
}

fn error(domain: &PlanarDomain, metric: &impl PlanarMetric, sampling: &PlanarSampling) -> PatternError {
    sample_plane(domain, metric, sampling, &Progress::default()).expect_err("bad input")
}

fn quality(metric: &impl PlanarMetric, samples: &PlanarSamples) -> SampleQuality {
    planar_quality(&PlanarDomain::default(), metric, &samples.positions).expect("samples")
}

/// The star and some steps.
fn star(count: u32, steps: u32) -> PlanarSampling {
    PlanarSampling {
        relaxation: Relaxation::Star,
        steps,
        ..PlanarSampling::count(count)
    }
}

/// A rhomboid with a dent and two holes.
fn polygon() -> PlanarDomain {
    let points = |list: &[(f64, f64)]| list.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
    PlanarDomain::Polygon {
        outline: points(&[(0.0, 0.0), (0.0, 2.0), (2.0, 3.5), (3.0, 2.0), (4.0, 2.5), (4.0, -0.5)]),
        holes: vec![
            points(&[(1.0, 1.0), (2.0, 1.0), (1.5, 2.0)]),
            points(&[(3.0, 0.5), (3.5, 0.5), (3.5, 1.0), (3.0, 1.0)]),
        ],
    }
}

/// Twice the area of each triangle.
fn double_areas(samples: &PlanarSamples) -> impl Iterator<Item = f64> {
    samples.triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|v| samples.positions[v as usize]);
        (b - a).perp_dot(c - a)
    })
}

/// The angle at `a` between `b` and `c`, in the metric `m`.
fn angle(m: SymmetricDMat2, a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (v, w) = (b - a, c - a);
    (v.dot(m * w) / (v.dot(m * v) * w.dot(m * w)).sqrt())
        .clamp(-1.0, 1.0)
        .acos()
}

/// By how much opposite angles sum to more than π in the summed metric, at the worst edge.
fn worst_violation(samples: &PlanarSamples) -> f64 {
    let mut opposite: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
    for &[a, b, c] in &samples.triangles {
        for (u, v, apex) in [(a, b, c), (b, c, a), (c, a, b)] {
            opposite.entry([u.min(v), u.max(v)]).or_default().push(apex);
        }
    }
    let mut worst = f64::NEG_INFINITY;
    for (&[b, c], apexes) in &opposite {
        let &[a, d] = apexes.as_slice() else {
            assert_eq!(apexes.len(), 1, "an edge has one triangle or two");
            continue;
        };
        let m = [a, b, c, d]
            .iter()
            .fold(SymmetricDMat2::ZERO, |m, &v| m + samples.metrics[v as usize]);
        let [a, b, c, d] = [a, b, c, d].map(|v| samples.positions[v as usize]);
        worst = worst.max(angle(m, a, b, c) + angle(m, d, b, c) - std::f64::consts::PI);
    }
    worst
}

/// The triangles fill the unit square, none is turned over, and no edge is violated.
fn assert_sound(samples: &PlanarSamples) {
    assert!(
        double_areas(samples).all(|area| area > 0.0),
        "a triangle is turned over"
    );
    let area: f64 = double_areas(samples).sum::<f64>() / 2.0;
    assert!(
        (area - 1.0).abs() < 1e-9,
        "the triangles cover {area} of the unit square"
    );
    assert!(
        worst_violation(samples) < 1e-6,
        "an edge is violated by {}",
        worst_violation(samples)
    );
}

#[test]
fn flips_end_and_no_triangle_is_turned_over() {
    for relaxation in [Relaxation::Kite, Relaxation::Star] {
        let sampling = PlanarSampling {
            relaxation,
            tolerance: 0.0,
            ..PlanarSampling::count(2000)
        };
        assert_sound(&sample(&isotropic, &sampling));
        assert_sound(&sample(&ratio_4, &sampling));
        assert_sound(&sample(&vortex, &sampling));
        assert_sound(&sample(&graded, &sampling));
        assert_sound(&sample(&wavy(10.0), &sampling));
    }
}

fn edges(triangles: impl IntoIterator<Item = [u32; 3]>) -> BTreeSet<[u32; 2]> {
    let sides = triangles.into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    sides.map(|[a, b]| [a.min(b), a.max(b)]).collect()
}

/// The Delaunay triangulation by another program.
fn delaunay(points: impl Iterator<Item = DVec2>) -> BTreeSet<[u32; 2]> {
    let points = points.map(|p| Point2::new(p.x, p.y)).collect();
    let mesh = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(points).expect("finite points");
    edges(
        mesh.inner_faces()
            .map(|face| face.vertices().map(|vertex| vertex.index() as u32)),
    )
}

#[test]
fn isotropic_triangulation_is_delaunay() {
    let samples = sample(&isotropic, &PlanarSampling::count(3000));
    assert_eq!(
        edges(samples.triangles.iter().copied()),
        delaunay(samples.positions.iter().copied())
    );
}

/// A metric M is the plane stretched by √M. The stretched square is no square: so the same polygon is sampled twice.
#[test]
fn constant_metric_is_the_stretched_plane() {
    let stretch = |p: DVec2| DVec2::new(2.0 * p.x, 0.5 * p.y);
    let (outline, holes) = match polygon() {
        PlanarDomain::Polygon { outline, holes } => (outline, holes),
        PlanarDomain::Rectangle { .. } => unreachable!(),
    };
    let stretched = PlanarDomain::Polygon {
        outline: outline.iter().copied().map(stretch).collect(),
        holes: holes
            .iter()
            .map(|hole| hole.iter().copied().map(stretch).collect())
            .collect(),
    };
    let metric = |_: DVec2| SymmetricDMat2 {
        m00: 4.0,
        m01: 0.0,
        m11: 0.25,
    };
    let plain = sample_in(&stretched, &isotropic, &PlanarSampling::count(1500));
    let anisotropic = sample_in(&polygon(), &metric, &PlanarSampling::count(1500));
    let distance = |p: DVec2, others: &[DVec2]| others.iter().map(|&q| p.distance(q)).fold(f64::INFINITY, f64::min);
    let to_others: Vec<f64> = anisotropic
        .positions
        .iter()
        .map(|&p| distance(stretch(p), &plain.positions))
        .collect();
    // The first triangles of the two differ, and with them everything; what must agree is the quality.
    assert!(to_others.iter().all(|d| *d < 0.2));
    let [a, b] = [
        planar_quality(&stretched, &isotropic, &plain.positions).expect("samples"),
        planar_quality(&polygon(), &metric, &anisotropic.positions).expect("samples"),
    ];
    assert!(
        (a.nn_mean - b.nn_mean).abs() < 0.01 && (a.area_cv - b.area_cv).abs() < 0.012,
        "{a:?} {b:?}"
    );
    // And the triangulation is exactly that of the stretched points, but for slivers at the border.
    let square = sample(&metric, &PlanarSampling::count(3000));
    let expected = delaunay(square.positions.iter().copied().map(stretch));
    assert_eq!(edges(square.triangles.iter().copied()), expected);
}

#[test]
fn count_is_exact() {
    for count in [1, 2, 3, 4, 5, 7, 12, 20, 31, 40, 64, 100, 777, 5000] {
        for domain in [PlanarDomain::default(), polygon()] {
            let samples = sample_in(&domain, &wavy(4.0), &PlanarSampling::count(count));
            assert_eq!(samples.len(), count as usize);
            assert!(samples.positions.iter().all(|&p| p.is_finite()));
            assert_eq!(
                BTreeSet::from_iter(samples.positions.iter().map(|p| p.to_array().map(f64::to_bits))).len(),
                samples.len()
            );
            assert_is_a_set(&samples.set());
        }
    }
    let fifo = PlanarSampling {
        insertion: Insertion::Fifo,
        ..PlanarSampling::count(3210)
    };
    assert_eq!(sample(&vortex, &fifo).len(), 3210);
    // One sample of a square lies in its middle.
    let one = sample(&isotropic, &PlanarSampling::count(1));
    assert!(one.positions[0].distance(DVec2::splat(0.5)) < 1e-9);
}

/// What a set promises: lists of the same length, symmetric rings, samples in their triangles.
fn assert_is_a_set(set: &SampleSet) {
    let n = set.len();
    assert!(
        [
            set.normals.len(),
            set.metrics.len(),
            set.triangles.len(),
            set.barycentrics.len()
        ]
        .iter()
        .all(|&l| l == n)
    );
    assert_eq!(set.neighbor_offsets.len(), n + 1);
    for i in 0..n {
        let ring = set.ring(i);
        assert!(ring.is_sorted_by(|a, b| a < b), "ascending, without repetition");
        assert!(
            ring.iter()
                .all(|&j| j as usize != i && set.ring(j as usize).contains(&(i as u32)))
        );
        assert!(n == 1 || !ring.is_empty());
        let corners = set.seeds[set.triangles[i] as usize].map(|v| set.positions[v as usize]);
        let b = set.barycentrics[i];
        let p = b.x * corners[0] + b.y * corners[1] + b.z * corners[2];
        assert!(p.distance(set.positions[i]) < 1e-5);
        let m = set.metrics[i];
        let normal = m.m22 - (m.m00 * m.m11 - m.m01 * m.m01).sqrt();
        assert!(
            normal.abs() < 1e-3 * m.m22,
            "the eigenvalue along the normal is the geometric mean"
        );
    }
}

#[test]
fn the_unit_ball_is_one_sample() {
    let samples = sample(&graded, &PlanarSampling::count(4000));
    let area: f64 = samples
        .triangles
        .iter()
        .zip(double_areas(&samples))
        .map(|(triangle, double_area)| {
            let root = |v: u32| samples.metrics[v as usize].determinant().sqrt();
            double_area / 2.0 * triangle.iter().map(|&v| root(v)).sum::<f64>() / 3.0
        })
        .sum();
    let per_sample = area / samples.len() as f64;
    assert!((per_sample / (2.0 * 3.0_f64.sqrt()) - 1.0).abs() < 0.01, "{per_sample}");
    // Samples' metrics are the user's, scaled.
    for (p, m) in samples.positions.iter().zip(&samples.metrics) {
        assert!((graded(*p).m00 * samples.scale / m.m00 - 1.0).abs() < 1e-9);
    }
}

#[test]
fn same_seed_same_samples() {
    let with = |seed| PlanarSampling {
        seed,
        ..PlanarSampling::count(1000)
    };
    for count in [5, 1000] {
        let of = |seed| {
            sample(
                &vortex,
                &PlanarSampling {
                    density: Density::Count(count),
                    ..with(seed)
                },
            )
            .positions
        };
        assert_eq!(of(7), of(7));
        assert_ne!(of(7), of(8));
    }
}

#[test]
fn polygon_with_holes() {
    let samples = sample_in(&polygon(), &ratio_4, &PlanarSampling::count(3000));
    let PlanarDomain::Polygon { outline, holes } = polygon() else {
        unreachable!()
    };
    for corner in outline.iter().chain(holes.iter().flatten()) {
        assert!(samples.positions.contains(corner), "{corner} is lost");
    }
    let inside = |p: &DVec2| polygon().contains(*p);
    assert!(
        samples
            .positions
            .iter()
            .zip(&samples.boundary)
            .all(|(p, &boundary)| boundary || inside(p))
    );
    // No triangle reaches over a hole or a dent: together they have the polygon's area.
    let loop_area = |corners: &[DVec2]| {
        let next = corners.iter().cycle().skip(1);
        (corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>() / 2.0).abs()
    };
    let expected = loop_area(&outline) - holes.iter().map(|hole| loop_area(hole)).sum::<f64>();
    let area = double_areas(&samples).sum::<f64>() / 2.0;
    assert!((area - expected).abs() < 1e-9, "{area} {expected}");
    let quality = planar_quality(&polygon(), &ratio_4, &samples.positions).expect("samples");
    assert!(
        quality.nn_cv < 0.085 && quality.area_cv < 0.09 && quality.hole < 0.9 && quality.empty_cells == 0,
        "{quality:?}"
    );
}

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

/// A wave of size and direction that travels, a vortex that wanders, a wave of size alone.
#[test]
fn slices_follow_a_changing_metric() {
    follow(|t| {
        move |p: DVec2| {
            let angle = 0.6 * (TAU * p.x + t).sin() + 0.6 * (TAU * p.y).cos();
            let size = 1.0 + 0.5 * (TAU * (p.x - 0.5 * p.y) + t).sin();
            ellipse(angle, 2.0 * size, 0.5 * size)
        }
    });
    follow(|t| move |p: DVec2| vortex(p - 0.2 * DVec2::from_angle(t)));
    follow(|t| {
        move |p: DVec2| {
            let size = 1.0 + 0.6 * (TAU * p.x + 2.0 * t).sin() * (4.0 * p.y - t).cos();
            ellipse(0.0, size, size)
        }
    });
}

fn follow<M: PlanarMetric>(at: impl Fn(f64) -> M) {
    let domain = PlanarDomain::default();
    let sampling = PlanarSampling::count(5000);
    let mut slices = SliceSampler::new(&domain, &at(0.0), &sampling).expect("a good metric");
    let mut before: HashMap<u64, DVec2> = slices.ids().into_iter().zip(slices.samples().positions).collect();
    for slice in 1..=10 {
        let metric = at(0.1 * f64::from(slice));
        let report = slices.advance(&metric, 5).expect("a good metric");
        let samples = slices.samples();
        assert_sound(&samples);
        assert!(samples.len().abs_diff(5000) <= 50, "{} samples", samples.len());
        // The samples that stay are the same, and are near to where they were.
        let ids = slices.ids();
        let now: HashMap<u64, DVec2> = ids.iter().copied().zip(samples.positions.iter().copied()).collect();
        assert_eq!(now.len(), samples.len());
        let stayed = ids.iter().filter(|id| before.contains_key(id)).count();
        assert_eq!((stayed + report.inserted, stayed + report.removed), (5000, 5000));
        assert!(stayed > 4400 && report.rms_move < 0.5, "{report:?}");
        before = now;
        if slice % 3 != 1 {
            continue;
        }
        let [followed, fresh] = [
            quality(&metric, &samples),
            quality(&metric, &sample(&metric, &sampling)),
        ];
        assert!(
            followed.area_cv <= 1.1 * fresh.area_cv,
            "slice {slice}: {followed:?}, fresh {fresh:?}"
        );
    }
}

#[test]
fn slices_refuse_bad_input() {
    let domain = PlanarDomain::default();
    let few = SliceSampler::new(&domain, &isotropic, &PlanarSampling::count(3));
    assert!(matches!(few.err(), Some(PatternError::OutOfRange { .. })));
    let mut slices = SliceSampler::new(&domain, &isotropic, &PlanarSampling::count(300)).expect("a good metric");
    let before = slices.samples();
    let bad = |p: DVec2| isotropic(p) * if p.x > 0.5 { -1.0 } else { 1.0 };
    assert!(matches!(slices.advance(&bad, 5), Err(PatternError::NotPositive { .. })));
    assert_eq!(slices.samples(), before);
    // A world that changes altogether.
    slices.advance(&wavy(10.0), 30).expect("a good metric");
    assert_sound(&slices.samples());
    assert_eq!(slices.samples().len(), 300);
}

/// Where so few samples see a metric that jumps, flips of single edges would go round in a circle.
#[test]
fn flips_end_where_the_metric_jumps() {
    for seed in 0..4 {
        for (count, ratio) in [(100, 10.0), (300, 30.0), (1000, 100.0)] {
            let sampling = PlanarSampling {
                seed,
                ..PlanarSampling::count(count)
            };
            let mut slices = SliceSampler::new(&PlanarDomain::default(), &isotropic, &sampling).expect("a good metric");
            for metric in [wavy(ratio), wavy(1.0), wavy(ratio)] {
                slices.advance(&metric, 3).expect("a good metric");
                assert_sound(&slices.samples());
                let samples = slices.ids().into_iter().collect::<BTreeSet<u64>>().len();
                assert_eq!((samples, slices.samples().len()), (count as usize, count as usize));
            }
        }
    }
}
