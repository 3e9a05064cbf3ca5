//! Samples on surfaces: theorems, nasty meshes, nasty metrics and bad input, through the public API.

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

fn zoo() -> Vec<(String, Triangles)> {
    let cube_corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
    let cube = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let huge_and_tiny = merged(&[
        plane(40, 40),
        (
            vec![Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::X * 100.0],
            vec![[0, 2, 1]],
        ),
    ]);
    let book = |pages: u32| -> Triangles {
        let leaves = (0..pages).map(|i| Vec2::from_angle(i as f32).extend(0.5));
        (
            [Vec3::ZERO, Vec3::Z].into_iter().chain(leaves).collect(),
            (0..pages).map(|i| [0, 1, i + 2]).collect(),
        )
    };
    let moebius = grid(48, 6, [false, false], |x| {
        let (turn, half) = (x.x * TAU, x.x * PI);
        let (radius, side) = (1.0 + (x.y - 0.5) * half.cos(), x.y - 0.5);
        Vec3::new(radius * turn.cos(), radius * turn.sin(), side * half.sin())
    });
    let degenerate = (
        vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE, Vec3::X * 0.5, Vec3::X],
        vec![[0, 1, 2], [0, 1, 2], [2, 1, 0], [0, 0, 2], [0, 4, 1], [1, 5, 2]],
    );
    let needle = (vec![Vec3::ZERO, Vec3::X, Vec3::new(0.5, 1e-4, 0.0)], vec![[0, 1, 2]]);
    let islands: Vec<Triangles> = (0..40)
        .map(|i| moved(plane(1 + i % 3, 1), Vec3::X * 1.5 * i as f32))
        .collect();
    let mut zoo: Vec<(String, Triangles)> = vec![
        ("cube".into(), ((0..8).map(cube_corner).collect(), cube.to_vec())),
        ("quad".into(), plane(1, 1)),
        ("huge and tiny triangles".into(), huge_and_tiny),
        ("torus".into(), torus(30, 12)),
        ("sphere with degenerate poles".into(), sphere(24, 12)),
        (
            "tiny".into(),
            (torus(30, 12).0.iter().map(|p| *p * 1e-9).collect(), torus(30, 12).1),
        ),
        (
            "vast".into(),
            (torus(30, 12).0.iter().map(|p| *p * 1e9).collect(), torus(30, 12).1),
        ),
        ("three faces on an edge".into(), book(3)),
        ("book".into(), book(60)),
        ("moebius strip".into(), moebius),
        ("isolated vertex, zero-area and duplicate triangles".into(), degenerate),
        ("needle".into(), needle),
        (
            "two sheets".into(),
            merged(&[plane(20, 20), moved(plane(20, 20), Vec3::Z * 1e-3)]),
        ),
        ("islands".into(), merged(&islands)),
        (
            "pinched vertex".into(),
            (
                vec![Vec3::ZERO, Vec3::X, Vec3::Y, -Vec3::X, -Vec3::Y],
                vec![[0, 1, 2], [0, 3, 4]],
            ),
        ),
    ];
    zoo.extend((0..6).map(|seed| {
        let mut random = Random(seed);
        let positions = (0..60)
            .map(|_| Vec3::new(random.unit(), random.unit(), random.unit()))
            .collect();
        let triangles = (0..40 + 40 * seed)
            .map(|_| [(); 3].map(|()| random.below(60)))
            .collect();
        (format!("soup {seed}"), (positions, triangles))
    }));
    zoo
}

#[test]
fn nasty_meshes_get_exactly_their_samples() {
    for (name, mesh) in zoo() {
        let graph = graph_of(&mesh);
        for &method in METHODS {
            for count in [1, 40] {
                let name = format!("{name}, {method:?}, {count}");
                let options = SurfaceSampling {
                    steps: 4,
                    ..options(method, count)
                };
                let metric = metrics(&graph, |_, n| along(Vec3::X, n, 2.0, 1.0));
                let samples = sample(&graph, &metric, &options);
                check(&name, &graph, &samples.set, count as usize);
                let quality = surface_quality(&graph, &metric, &samples.set).expect("good samples");
                assert_eq!(quality.empty_cells, 0, "{name}: {quality:?}");
            }
        }
    }
}

#[test]
fn nasty_metrics_get_exactly_their_samples() {
    let graph = graph_of(&torus(60, 24));
    let violent = |p: Vec3, n: Vec3| {
        along(
            p,
            n,
            1.0 + 9.0 * (97.0 * p.x).sin().powi(2),
            (1.5 * (61.0 * p.y).sin()).exp(),
        )
    };
    let fields: [(&str, Vec<SymmetricMat3>); 4] = [
        ("ratio 100", metrics(&graph, |_, n| along(Vec3::Z, n, 100.0, 1.0))),
        ("singularities", metrics(&graph, |_, n| along(Vec3::Y, n, 10.0, 1.0))),
        ("violent", metrics(&graph, violent)),
        (
            "a pole",
            metrics(&graph, |p, n| along(Vec3::X, n, 1.0, 1e-3 + p.distance(Vec3::X * 1.4))),
        ),
    ];
    for (name, metric) in fields {
        for &method in METHODS {
            let samples = sample(&graph, &metric, &options(method, 500));
            check(name, &graph, &samples.set, 500);
            let quality = surface_quality(&graph, &metric, &samples.set).expect("good samples");
            assert!(quality.empty_cells <= 5, "{name}, {method:?}: {quality:?}");
        }
    }
}

#[test]
fn every_component_gets_a_sample_the_largest_first() {
    let islands: Vec<Triangles> = (0..10)
        .map(|i| {
            let (positions, triangles) = plane(3, 3);
            let scale = 1.0 + 0.1 * i as f32;
            moved(
                (positions.into_iter().map(|p| p * scale).collect(), triangles),
                Vec3::X * 3.0 * i as f32,
            )
        })
        .collect();
    let graph = graph_of(&merged(&islands));
    let island = |p: Vec3| (p.x / 3.0) as usize;
    for count in [4, 10, 37] {
        let set = sample(&graph, &isotropic(&graph), &options(SurfaceMethod::Labels, count)).set;
        check("islands", &graph, &set, count as usize);
        let mut found = [0; 10];
        set.positions.iter().for_each(|&p| found[island(p)] += 1);
        let expected = 10 - (count as usize).min(10);
        assert!(
            found[expected..].iter().all(|&n| n > 0) && found[..expected].iter().all(|&n| n == 0),
            "{found:?}"
        );
        // A cell on an island without a sample is that of the nearest one in space.
        let seed = set.seeds[graph
            .triangles
            .iter()
            .position(|t| graph.positions[t[0] as usize].x < 2.0)
            .expect("island 0")];
        assert_eq!(island(set.positions[seed[0] as usize]), expected);
    }
}

/// Cells of one sheet know nothing of the other sheet, however near it is.
#[test]
fn sheets_do_not_mix() {
    let graph = graph_of(&merged(&[plane(30, 30), moved(plane(30, 30), Vec3::Z * 1e-4)]));
    let set = sample(&graph, &isotropic(&graph), &options(SurfaceMethod::Labels, 200)).set;
    for (triangle, seeds) in graph.triangles.iter().zip(&set.seeds) {
        let z = graph.positions[triangle[0] as usize].z;
        assert!(seeds.iter().all(|&s| (set.positions[s as usize].z - z).abs() < 1e-5));
    }
    assert!((0..set.len()).all(|i| {
        set.ring(i)
            .iter()
            .all(|&j| (set.positions[j as usize].z - set.positions[i].z).abs() < 1e-5)
    }));
}

#[test]
fn a_coarse_mesh_is_refined_and_a_fine_one_is_not() {
    let refined = |u, count| {
        let graph = graph_of(&plane(u, u));
        let samples = sample(&graph, &isotropic(&graph), &options(SurfaceMethod::Labels, count));
        (samples.refined, samples.vertices)
    };
    assert_eq!(refined(100, 10), (0, 101 * 101));
    let (rounds, vertices) = refined(1, 1000);
    assert!(
        rounds > 3 && (14_000..64_100).contains(&vertices),
        "{rounds} {vertices}"
    );
}

#[test]
fn bad_input_is_an_error() {
    let graph = graph_of(&torus(20, 10));
    let good = isotropic(&graph);
    let run = |metric: &[SymmetricMat3], density| {
        let options = SurfaceSampling {
            density,
            ..Default::default()
        };
        sample_surface(&graph, metric, &options, &Progress::default()).expect_err("bad input")
    };
    let with = |m: SymmetricMat3| {
        let mut metric = good.clone();
        metric[7] = m;
        metric
    };
    let count = Density::Count(10);
    let nan = SymmetricMat3 {
        m01: f32::NAN,
        ..SymmetricMat3::IDENTITY
    };
    let saddle = SymmetricMat3::new(1.0, 2.0, 0.0, 1.0, 0.0, 1.0);
    assert!(matches!(
        run(&with(nan), count),
        PatternError::NotFinite { index: 7, .. }
    ));
    for flat in [saddle, SymmetricMat3::ZERO, SymmetricMat3::IDENTITY * -1.0] {
        assert!(matches!(
            run(&with(flat), count),
            PatternError::NotPositive { index: 7, .. }
        ));
    }
    assert!(matches!(run(&good[1..], count), PatternError::WrongLength { .. }));
    let densities = [
        Density::Count(0),
        Density::Count(MAX_SAMPLES + 1),
        Density::Count(u32::MAX),
    ];
    let rates = [0.0, -1.0, f32::NAN, f32::INFINITY, 1e30].map(Density::FillRate);
    for density in densities.into_iter().chain(rates) {
        assert!(
            matches!(run(&good, density), PatternError::OutOfRange { .. }),
            "{density:?}"
        );
    }
    let none = surface_quality(&graph, &good, &SampleSet::default());
    assert!(matches!(none, Err(PatternError::OutOfRange { .. })));
}

#[test]
fn sampling_reports_progress_and_can_be_stopped() {
    let graph = graph_of(&torus(20, 10));
    let progress = Progress::default();
    sample_surface(
        &graph,
        &isotropic(&graph),
        &options(SurfaceMethod::Labels, 50),
        &progress,
    )
    .expect("good input");
    assert_eq!(progress.done(), 1.0);
    progress.cancel();
    let stopped = sample_surface(
        &graph,
        &isotropic(&graph),
        &options(SurfaceMethod::Labels, 50),
        &progress,
    );
    assert_eq!(stopped, Err(PatternError::Cancelled));
}

/// Relaxes a set again.
fn again(
    graph: &SurfaceGraph,
    metric: &[SymmetricMat3],
    from: &SampleSet,
    options: &SurfaceSampling,
) -> Result<SurfaceSamples, PatternError> {
    relax_surface(graph, metric, from, options, &Progress::default())
}

/// Mean distance of samples of the same index, in units of the distance of neighbours in the hexagonal packing.
fn mean_move(one: &SampleSet, two: &SampleSet) -> f32 {
    let n = one.len().min(two.len());
    let moved = |i: usize| 0.5 * one.distance_squared(i, two.positions[i]).sqrt();
    (0..n).map(moved).sum::<f32>() / n as f32
}

#[test]
fn a_turned_metric_moves_samples_little() {
    let graph = graph_of(&torus(240, 90));
    let turned = |degrees: f32| {
        metrics(&graph, |_, n| {
            let around = n.cross(Vec3::Z).normalize_or(Vec3::X);
            let across = n.cross(around);
            let (sin, cos) = degrees.to_radians().sin_cos();
            along(cos * around + sin * across, n, 2.0, 1.0)
        })
    };
    let few = SurfaceSampling {
        steps: 5,
        ..options(SurfaceMethod::Labels, 1500)
    };
    let mut set = sample(&graph, &turned(0.0), &options(SurfaceMethod::Labels, 1500)).set;
    for degrees in [2.0, 4.0, 6.0] {
        let metric = turned(degrees);
        let next = again(&graph, &metric, &set, &few).expect("the same graph").set;
        check("turned", &graph, &next, 1500);
        let moved = mean_move(&set, &next);
        assert!((0.001..0.15).contains(&moved), "moved by {moved}");
        let fresh = sample(&graph, &metric, &options(SurfaceMethod::Labels, 1500)).set;
        let [next_quality, fresh_quality] =
            [&next, &fresh].map(|set| surface_quality(&graph, &metric, set).expect("good samples"));
        assert!(
            next_quality.nn_cv < 1.1 * fresh_quality.nn_cv
                && next_quality.area_cv < 1.1 * fresh_quality.area_cv
                && next_quality.hole < 1.1 * fresh_quality.hole
                && next_quality.empty_cells == 0,
            "{next_quality:?} {fresh_quality:?}"
        );
        assert!(mean_move(&set, &fresh) > 0.5, "fresh samples are others");
        set = next;
    }
}

/// Samples follow a surface that moves: where everything is scaled and turned, nothing moves on it.
#[test]
fn samples_follow_a_surface_that_moves() {
    let mesh = torus(120, 45);
    let place = |p: Vec3| 3.0 * Vec3::new(p.y, p.z, p.x) + Vec3::X;
    let moved_mesh = (mesh.0.iter().map(|&p| place(p)).collect(), mesh.1.clone());
    let (graph, other) = (graph_of(&mesh), graph_of(&moved_mesh));
    assert_eq!(graph.triangles.len(), other.triangles.len());
    let set = sample(&graph, &isotropic(&graph), &options(SurfaceMethod::Labels, 400)).set;
    let still = SurfaceSampling {
        steps: 0,
        ..options(SurfaceMethod::Labels, 400)
    };
    let next = again(&other, &isotropic(&other), &set, &still)
        .expect("the same triangles")
        .set;
    check("moved", &other, &next, 400);
    for i in 0..400 {
        assert!(next.positions[i].distance(place(set.positions[i])) < 1e-4, "{i}");
    }
}

/// What is kept from one time to the next is not seen in the result, as long as the metric is the one it was made for.
#[test]
fn a_relaxer_does_what_is_done_without_it() {
    let mesh = torus(120, 45);
    let place = |p: Vec3| 3.0 * Vec3::new(p.y, p.z, p.x) + Vec3::X;
    let moved = (mesh.0.iter().map(|&p| place(p)).collect(), mesh.1.clone());
    let [graph, moved, other] = [&mesh, &moved, &torus(100, 40)].map(graph_of);
    let few = |count| SurfaceSampling {
        steps: 3,
        ..options(SurfaceMethod::Labels, count)
    };
    let mut relaxer = SurfaceRelaxer::default();
    for (graph, count) in [
        (&graph, 900),
        (&graph, 900),
        (&moved, 900),
        (&graph, 700),
        (&other, 700),
    ] {
        let metric = isotropic(graph);
        let set = sample(graph, &metric, &options(SurfaceMethod::Labels, 800)).set;
        let kept = relaxer.relax(graph, &metric, &set, &few(count), &Progress::default());
        let new = again(graph, &metric, &set, &few(count));
        assert_eq!(kept.expect("fits").set, new.expect("fits").set);
    }
    let set = sample(&graph, &isotropic(&graph), &options(SurfaceMethod::Labels, 800)).set;
    let long = metrics(&graph, |_, n| along(Vec3::Z, n, 8.0, 1.0));
    for metric in [isotropic(&graph), long, isotropic(&graph)] {
        let relaxed = relaxer.relax(&graph, &metric, &set, &few(800), &Progress::default());
        check("kept", &graph, &relaxed.expect("fits").set, 800);
    }
    let bad = relaxer.relax(&graph, &[], &set, &few(800), &Progress::default());
    assert!(matches!(bad, Err(PatternError::WrongLength { .. })), "{bad:?}");
}

#[test]
fn a_set_is_thinned_or_filled_to_another_count() {
    let graph = graph_of(&torus(160, 60));
    let metric = metrics(&graph, |_, n| along(Vec3::Z, n, 2.0, 1.0));
    let set = sample(&graph, &metric, &options(SurfaceMethod::Labels, 800)).set;
    for count in [1, 720, 799, 801, 900, 3000] {
        let set = again(&graph, &metric, &set, &options(SurfaceMethod::Labels, count))
            .expect("fits")
            .set;
        check("another count", &graph, &set, count as usize);
        if (700..1000).contains(&count) {
            let quality = surface_quality(&graph, &metric, &set).expect("good samples");
            assert!(quality.nn_cv < 0.1 && quality.hole < 0.9, "{count}: {quality:?}");
        }
    }
    // Those that stay keep their order; the new ones come behind them.
    let still = |count| SurfaceSampling {
        steps: 0,
        ..options(SurfaceMethod::Labels, count)
    };
    let more = again(&graph, &metric, &set, &still(900)).expect("fits").set;
    assert!(
        set.positions
            .iter()
            .zip(&more.positions)
            .all(|(a, b)| a.distance(*b) < 1e-5)
    );
    let fewer = again(&graph, &metric, &set, &still(700)).expect("fits").set;
    let mut old = set.positions.iter();
    assert!(fewer.positions.iter().all(|p| old.any(|q| q.distance(*p) < 1e-5)));
}

#[test]
fn nasty_meshes_are_relaxed_again() {
    for (name, mesh) in zoo() {
        let graph = graph_of(&mesh);
        let metric = metrics(&graph, |_, n| along(Vec3::X, n, 2.0, 1.0));
        let set = sample(&graph, &metric, &options(SurfaceMethod::Labels, 40)).set;
        for count in [10, 40, 60] {
            let next = again(&graph, &metric, &set, &options(SurfaceMethod::Labels, count))
                .expect("fits")
                .set;
            check(&name, &graph, &next, count as usize);
        }
    }
}

#[test]
fn a_set_that_does_not_fit_is_an_error() {
    let graph = graph_of(&torus(20, 10));
    let metric = isotropic(&graph);
    let options = options(SurfaceMethod::Labels, 50);
    let set = sample(&graph, &metric, &options).set;
    let fails = |change: &dyn Fn(&mut SampleSet)| {
        let mut set = set.clone();
        change(&mut set);
        again(&graph, &metric, &set, &options).expect_err("it does not fit")
    };
    let other = graph_of(&torus(21, 10));
    let lists = again(&other, &isotropic(&other), &set, &options);
    assert!(matches!(lists, Err(PatternError::SampleLists { .. })), "{lists:?}");
    let short = fails(&|set| set.barycentrics.truncate(3));
    assert!(matches!(short, PatternError::SampleLists { found: 3, .. }), "{short}");
    let nan = fails(&|set| set.barycentrics[7].y = f32::NAN);
    assert!(matches!(nan, PatternError::NotFinite { index: 7, .. }), "{nan}");
    let far = fails(&|set| set.triangles[0] = u32::MAX);
    assert!(matches!(far, PatternError::IndexOutOfRange { .. }), "{far}");
    let none = fails(&|set| *set = SampleSet::default());
    assert!(matches!(none, PatternError::OutOfRange { .. }), "{none}");
}
