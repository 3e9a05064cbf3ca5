//! The planar sampler: theorems, quality, nasty input; all through the public API.

mod evenness;
mod input;
mod slices;

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
