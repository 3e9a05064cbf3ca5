//! What is asked of a sampler, and what it says of bad input.

use crate::*;

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
