//! Samples on surfaces: theorems, nasty meshes, nasty metrics and bad input, through the public API.

mod again;
mod input;
mod zoo;

use bevy::{
    math::{Vec2, Vec3},
    tasks::{ComputeTaskPool, TaskPoolBuilder},
};
use bevy_field_patterns::{
    error::PatternError,
    sampling::{
        Density, Progress, SampleSet,
        metric::smooth,
        surface::{
            MAX_SAMPLES, SurfaceMethod, SurfaceRelaxer, SurfaceSamples, SurfaceSampling, relax_surface, sample_surface,
            surface_quality,
        },
    },
    surface::{SurfaceGraph, WeldOptions},
};
use glam_matrix_extras::SymmetricMat3;
use std::f32::consts::{PI, TAU};

type Triangles = (Vec<Vec3>, Vec<[u32; 3]>);

/// The methods that this build has.
const METHODS: &[SurfaceMethod] = if cfg!(feature = "meshopt") {
    &[SurfaceMethod::Labels, SurfaceMethod::Triangulated, SurfaceMethod::Paper]
} else {
    &[SurfaceMethod::Labels]
};

fn graph_of((positions, triangles): &Triangles) -> SurfaceGraph {
    let weld = WeldOptions {
        tolerance: 0.0,
        rounding: 0.0,
    };
    SurfaceGraph::from_triangles(positions, triangles, &weld).expect("a good mesh")
}

/// A grid of u x v quads, closed where it wraps.
fn grid(u: u32, v: u32, wrap: [bool; 2], point: impl Fn(Vec2) -> Vec3) -> Triangles {
    let [columns, rows] = [u + u32::from(!wrap[0]), v + u32::from(!wrap[1])];
    let at = |i: u32, j: u32| point(Vec2::new(i as f32 / u as f32, j as f32 / v as f32));
    let positions = (0..rows)
        .flat_map(|j| (0..columns).map(move |i| (i, j)))
        .map(|(i, j)| at(i, j))
        .collect();
    let name = |i: u32, j: u32| (j % rows) * columns + i % columns;
    let quads = (0..v).flat_map(|j| (0..u).map(move |i| (i, j)));
    let triangles = quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i, j + 1), name(i + 1, j + 1)];
            [[a, b, c], [b, d, c]]
        })
        .collect();
    (positions, triangles)
}

fn torus(u: u32, v: u32) -> Triangles {
    grid(u, v, [true, true], |x| {
        let (a, b) = (x.x * TAU, x.y * TAU);
        let r = 1.0 + 0.4 * b.cos();
        Vec3::new(r * a.cos(), r * a.sin(), 0.4 * b.sin())
    })
}

fn plane(u: u32, v: u32) -> Triangles {
    grid(u, v, [false, false], |x| x.extend(0.0))
}

fn sphere(u: u32, v: u32) -> Triangles {
    grid(u, v, [true, false], |x| {
        let (a, b) = (x.x * TAU, (x.y - 0.5) * PI);
        Vec3::new(b.cos() * a.cos(), b.cos() * a.sin(), b.sin())
    })
}

fn merged(parts: &[Triangles]) -> Triangles {
    let mut all: Triangles = (vec![], vec![]);
    for (positions, triangles) in parts {
        let first = all.0.len() as u32;
        all.0.extend(positions);
        all.1.extend(triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

fn moved((positions, triangles): Triangles, by: Vec3) -> Triangles {
    (positions.into_iter().map(|p| p + by).collect(), triangles)
}

/// A small deterministic generator.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn below(&mut self, n: u32) -> u32 {
        (self.unit() * n as f32) as u32
    }
}

/// Semi-axes along and across the tangential part of an axis, and their geometric mean along the normal.
fn along(axis: Vec3, normal: Vec3, ratio: f32, size: f32) -> SymmetricMat3 {
    let tangent = (axis - normal * axis.dot(normal)).try_normalize();
    let long = tangent.unwrap_or_else(|| normal.any_orthonormal_vector());
    let short = normal.cross(long);
    let outer = |v: Vec3, k: f32| SymmetricMat3::from_outer_product(v) * k;
    let scale = 1.0 / (size * size);
    outer(long, scale / ratio) + outer(short, scale * ratio) + outer(normal, scale)
}

fn metrics(graph: &SurfaceGraph, f: impl Fn(Vec3, Vec3) -> SymmetricMat3) -> Vec<SymmetricMat3> {
    graph
        .positions
        .iter()
        .zip(&graph.normals)
        .map(|(&p, &n)| f(p, n))
        .collect()
}

fn isotropic(graph: &SurfaceGraph) -> Vec<SymmetricMat3> {
    metrics(graph, |_, _| SymmetricMat3::IDENTITY)
}

fn options(method: SurfaceMethod, count: u32) -> SurfaceSampling {
    SurfaceSampling {
        density: Density::Count(count),
        method,
        ..Default::default()
    }
}

fn sample(graph: &SurfaceGraph, metrics: &[SymmetricMat3], options: &SurfaceSampling) -> SurfaceSamples {
    sample_surface(graph, metrics, options, &Progress::default()).expect("good input")
}

/// Everything that is true of every sample set on a surface.
#[track_caller]
fn check(name: &str, graph: &SurfaceGraph, set: &SampleSet, count: usize) {
    let n = set.len();
    assert_eq!(n, count, "{name}: count");
    for len in [
        set.normals.len(),
        set.metrics.len(),
        set.triangles.len(),
        set.barycentrics.len(),
    ] {
        assert_eq!(len, n, "{name}: lengths");
    }
    let extent = graph
        .positions
        .iter()
        .fold(0.0_f32, |e, p| e.max(p.abs().max_element()));
    for i in 0..n {
        let weights = set.barycentrics[i];
        assert!(
            weights.min_element() >= 0.0 && (weights.element_sum() - 1.0).abs() < 1e-5,
            "{name}: {weights}"
        );
        let [a, b, c] = graph.triangles[set.triangles[i] as usize].map(|v| graph.positions[v as usize]);
        let point = a * weights.x + b * weights.y + c * weights.z;
        assert!(
            point.distance(set.positions[i]) <= 1e-5 * extent,
            "{name}: sample {i} is off the surface"
        );
        assert!(
            set.normals[i].is_normalized() && set.metrics[i].is_finite(),
            "{name}: sample {i}"
        );
    }
    assert_eq!(set.seeds.len(), graph.triangles.len(), "{name}: seeds");
    assert!(
        set.seeds.as_flattened().iter().all(|&s| (s as usize) < n),
        "{name}: seeds in range"
    );
    assert_eq!(set.neighbor_offsets.len(), n + 1, "{name}: offsets");
    for i in 0..n {
        let ring = set.ring(i);
        assert!(
            ring.is_sorted_by(|a, b| a < b) && !ring.contains(&(i as u32)),
            "{name}: ring {i}"
        );
        let symmetric = ring.iter().all(|&j| set.ring(j as usize).contains(&(i as u32)));
        assert!(symmetric, "{name}: neighbours of {i}");
    }
}

#[test]
fn every_method_meets_its_marks_of_evenness() {
    let graph = graph_of(&torus(240, 90));
    let metric = metrics(&graph, |_, n| along(Vec3::Z, n, 2.0, 1.0));
    for &method in METHODS {
        let samples = sample(&graph, &metric, &options(method, 1500));
        check("torus", &graph, &samples.set, 1500);
        let quality = surface_quality(&graph, &metric, &samples.set).expect("good samples");
        let [nn_cv, area_cv, hole] = match method {
            SurfaceMethod::Labels => [0.075, 0.10, 0.78],
            SurfaceMethod::Triangulated => [0.065, 0.085, 0.75],
            SurfaceMethod::Paper => [0.125, 0.17, 1.3],
        };
        let good = quality.nn_cv <= nn_cv && quality.area_cv <= area_cv && quality.hole <= hole;
        assert!(good && quality.empty_cells == 0, "{method:?}: {quality:?}");
        // What a packing of unit ellipses of this count covers, whatever the method.
        assert!(
            quality.coverage > 0.8 && quality.overlap < 0.09,
            "{method:?}: {quality:?}"
        );
    }
}

/// At notches parts of cells are cut off from their samples; no hole hides there.
#[test]
fn torn_surfaces_have_no_holes() {
    let (positions, triangles) = torus(160, 60);
    let is_torn = |quad: usize| {
        let (i, j) = (quad % 160, quad / 160);
        quad * 7919 % 97 < 2 || (i % 16 < 5 && j % 12 < 4)
    };
    let torn = triangles.into_iter().enumerate().filter(|(t, _)| !is_torn(t / 2));
    let graph = graph_of(&(positions, torn.map(|(_, triangle)| triangle).collect()));
    let mut metric = metrics(&graph, |_, n| along(Vec3::Z, n, 4.0, 1.0));
    smooth(&graph, &mut metric, 15);
    for (&method, hole) in METHODS.iter().zip([0.78, 0.75]) {
        for seed in 0..3 {
            let options = SurfaceSampling {
                seed,
                ..options(method, 1500)
            };
            let samples = sample(&graph, &metric, &options);
            let quality = surface_quality(&graph, &metric, &samples.set).expect("good samples");
            assert!(quality.hole <= hole, "{method:?}, seed {seed}: {quality:?}");
        }
    }
}

/// Without the feature two methods say what they lack, and nothing else is done in their place.
#[cfg(not(feature = "meshopt"))]
#[test]
fn without_meshopt_only_labels_are_there() {
    let graph = graph_of(&torus(24, 9));
    for method in [SurfaceMethod::Triangulated, SurfaceMethod::Paper] {
        let result = sample_surface(&graph, &isotropic(&graph), &options(method, 50), &Progress::default());
        assert_eq!(result.err(), Some(PatternError::MissingFeature("meshopt")));
    }
    let samples = sample(&graph, &isotropic(&graph), &options(SurfaceMethod::Labels, 50));
    assert_eq!(samples.set.len(), 50);
}

#[test]
fn darts_alone_are_less_even_than_relaxed_samples() {
    let graph = graph_of(&torus(120, 45));
    let metric = isotropic(&graph);
    let cv = |steps| {
        let options = SurfaceSampling {
            steps,
            ..options(SurfaceMethod::Labels, 400)
        };
        let samples = sample(&graph, &metric, &options);
        surface_quality(&graph, &metric, &samples.set)
            .expect("good samples")
            .area_cv
    };
    assert!(cv(10) < 0.7 * cv(0));
}

/// Smaller ellipses stand closer, in proportion to their area.
#[test]
fn density_follows_the_metric() {
    let graph = graph_of(&plane(120, 120));
    let metric = metrics(&graph, |p, n| along(Vec3::X, n, 1.0, 0.25 + 1.75 * p.x));
    let samples = sample(&graph, &metric, &options(SurfaceMethod::Labels, 1000));
    let quality = surface_quality(&graph, &metric, &samples.set).expect("good samples");
    assert!((quality.grading - 1.0).abs() < 0.08, "{quality:?}");
    let left = samples.set.positions.iter().filter(|p| p.x < 0.2).count();
    assert!(left > 400, "{left} of 1000 in the fifth with the smallest ellipses");
}

/// Samples of the hexagonal packing have metric area 2√3, whatever the scale of the metric that was given.
#[test]
fn the_metric_is_scaled_to_the_count() {
    let graph = graph_of(&plane(40, 40));
    for size in [1e-6, 1.0, 1e6] {
        let metric = metrics(&graph, |_, n| along(Vec3::X, n, 3.0, size));
        let set = sample(&graph, &metric, &options(SurfaceMethod::Labels, 200)).set;
        for m in &set.metrics {
            let area = (m.m00 * m.m11 - m.m01 * m.m01).sqrt();
            assert!((area / (200.0 * 12.0_f32.sqrt()) - 1.0).abs() < 1e-3, "{area}");
        }
    }
}

#[test]
fn a_fill_rate_gives_the_count_of_the_metric_as_it_is() {
    let graph = graph_of(&plane(40, 40));
    let metric = metrics(&graph, |_, n| along(Vec3::X, n, 2.0, 0.02));
    for &method in METHODS {
        let options = SurfaceSampling {
            density: Density::FillRate(0.55),
            ..options(method, 0)
        };
        let set = sample(&graph, &metric, &options).set;
        let ideal = 1.0 / (0.02_f32.powi(2) * 12.0_f32.sqrt());
        let ratio = set.len() as f32 / ideal;
        assert!((0.85..1.3).contains(&ratio), "{method:?}: {ratio}");
        assert!((set.metrics[0].m00 / metric[0].m00 - 1.0).abs() < 1e-4);
    }
}

#[test]
fn many_steps_open_no_holes() {
    let graph = graph_of(&torus(160, 60));
    let metric = metrics(&graph, |p, n| {
        let ratio = 1.0 + 9.0 * (0.5 + 0.5 * (9.0 * p.y).sin());
        along(Vec3::new(-p.z, 0.3 * p.x, p.x), n, ratio, 1.0 + 0.5 * (8.0 * p.x).cos())
    });
    let options = SurfaceSampling {
        steps: 50,
        ..options(SurfaceMethod::Labels, 800)
    };
    let set = sample(&graph, &metric, &options).set;
    let quality = surface_quality(&graph, &metric, &set).expect("good samples");
    assert!(quality.hole <= 0.95 && quality.empty_cells == 0, "{quality:?}");
}

/// One thread while there is no pool, then as many as the pool has.
#[test]
fn a_seed_makes_the_same_samples_with_any_number_of_threads() {
    let graph = graph_of(&sphere(160, 80));
    let metric = metrics(&graph, |_, n| along(Vec3::X, n, 3.0, 1.0));
    let run = |method, seed| {
        sample(
            &graph,
            &metric,
            &SurfaceSampling {
                seed,
                ..options(method, 900)
            },
        )
        .set
    };
    let alone: Vec<SampleSet> = METHODS.iter().map(|&method| run(method, 1)).collect();
    assert_ne!(alone[0], run(SurfaceMethod::Labels, 2), "another seed, other samples");
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
    for (&method, alone) in METHODS.iter().zip(&alone) {
        assert!(*alone == run(method, 1), "{method:?} depends on the threads");
    }
}

/// Greedy descent over the neighbours, from any corner's label, finds the nearest sample of almost every point.
#[test]
fn seeds_and_neighbors_lead_to_the_nearest_sample() {
    let graph = graph_of(&torus(160, 60));
    let metric = metrics(&graph, |_, n| along(Vec3::Z, n, 2.0, 1.0));
    let set = sample(&graph, &metric, &options(SurfaceMethod::Labels, 500)).set;
    let (mut random, mut wrong) = (Random(1), 0);
    for _ in 0..20_000 {
        let t = random.below(graph.triangles.len() as u32) as usize;
        let (u, v) = (random.unit(), random.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let [a, b, c] = graph.triangles[t].map(|v| graph.positions[v as usize]);
        let point = a + u * (b - a) + v * (c - a);
        let near = |&i: &u32, &j: &u32| {
            let square = |i: u32| set.distance_squared(i as usize, point);
            square(i).total_cmp(&square(j))
        };
        let mut here = *set.seeds[t].iter().min_by(|a, b| near(a, b)).expect("three");
        while let Some(&next) = set
            .ring(here as usize)
            .iter()
            .min_by(|a, b| near(a, b))
            .filter(|n| near(n, &here).is_lt())
        {
            here = next;
        }
        let best = (0..set.len() as u32).min_by(|a, b| near(a, b)).expect("samples");
        wrong += u32::from(best != here);
    }
    assert!(wrong <= 10, "{wrong} of 20,000");
}
