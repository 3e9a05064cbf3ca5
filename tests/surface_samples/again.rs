//! Samples that are relaxed again after a change.

use crate::{zoo::zoo, *};

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
