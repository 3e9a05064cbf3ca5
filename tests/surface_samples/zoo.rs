//! Meshes and metrics that are hard.

use crate::*;

pub(crate) fn zoo() -> Vec<(String, Triangles)> {
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
