//! The planar sampler on one thread: the first set, a relaxation step, both together, and a slice.

use bevy::math::{DVec2, UVec2};
use bevy_field_patterns::sampling::{
    Progress,
    planar::{Insertion, MetricGrid, PlanarDomain, PlanarSampling, SliceSampler, sample_plane},
};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam_matrix_extras::SymmetricDMat2;
use std::{
    f64::consts::{FRAC_PI_2, TAU},
    hint::black_box,
    time::Duration,
};

fn of_ratio(angle: f64, ratio: f64) -> SymmetricDMat2 {
    let e = DVec2::from_angle(angle);
    SymmetricDMat2 {
        m00: e.x * e.x / ratio + e.y * e.y * ratio,
        m01: (1.0 / ratio - ratio) * e.x * e.y,
        m11: e.y * e.y / ratio + e.x * e.x * ratio,
    }
}

/// A vortex of ratio 1 in the middle, 10 at the border, on a grid.
fn vortex() -> MetricGrid {
    let metric = |p: DVec2| {
        let d = p - 0.5;
        of_ratio(
            d.to_angle() + FRAC_PI_2,
            1.0 + 9.0 * (1.0 - (-d.length_squared() / 0.06).exp()),
        )
    };
    MetricGrid::bake((DVec2::ZERO, DVec2::ONE), UVec2::splat(257), &metric).expect("a metric")
}

fn sampling(count: u32, insertion: Insertion, steps: u32) -> PlanarSampling {
    PlanarSampling {
        insertion,
        steps,
        tolerance: 0.0,
        ..PlanarSampling::count(count)
    }
}

fn planar(c: &mut Criterion) {
    let mut group = c.benchmark_group("planar");
    group.sample_size(10);
    let (domain, metric, progress) = (PlanarDomain::default(), vortex(), Progress::default());
    for count in [4_000, 100_000] {
        group.throughput(Throughput::Elements(u64::from(count)));
        for insertion in [Insertion::LargestFirst, Insertion::Fifo] {
            let sampling = sampling(count, insertion, 0);
            let name = BenchmarkId::new(format!("insertion {insertion:?}"), count);
            group.bench_function(name, |b| {
                b.iter_custom(|runs| {
                    let run = |_| sample_plane(&domain, &metric, &sampling, &progress).expect("samples");
                    (0..runs)
                        .map(run)
                        .map(|samples| milliseconds(samples.times.initial))
                        .sum()
                });
            });
        }
        let sampling = sampling(count, Insertion::LargestFirst, 10);
        group.bench_function(BenchmarkId::new("kite step", count), |b| {
            b.iter_custom(|runs| {
                let run = |_| sample_plane(&domain, &metric, &sampling, &progress).expect("samples");
                (0..runs)
                    .map(run)
                    .map(|samples| milliseconds(samples.times.per_step))
                    .sum()
            });
        });
        group.bench_function(BenchmarkId::new("set and 10 steps", count), |b| {
            b.iter(|| black_box(sample_plane(&domain, &metric, &sampling, &progress)).expect("samples"));
        });
    }
}

fn milliseconds(ms: f32) -> Duration {
    Duration::from_secs_f32(ms * 1e-3)
}

/// A wave of size and direction that travels, 5 steps per slice.
fn slices(c: &mut Criterion) {
    let mut group = c.benchmark_group("planar");
    group.sample_size(10);
    let wave = |t: f64| {
        move |p: DVec2| {
            let angle = 0.6 * (TAU * p.x + t).sin() + 0.6 * (TAU * p.y).cos();
            let size = 1.0 + 0.5 * (TAU * (p.x - 0.5 * p.y) + t).sin();
            of_ratio(angle, 4.0) * (1.0 / (size * size))
        }
    };
    let sampling = PlanarSampling::count(5000);
    let mut slices = SliceSampler::new(&PlanarDomain::default(), &wave(0.0), &sampling).expect("samples");
    let mut t = 0.0;
    group.bench_function("slice 5000", |b| {
        b.iter(|| {
            t += 0.1;
            black_box(slices.advance(&wave(t), 5)).expect("a metric")
        });
    });
}

criterion_group!(benches, planar, slices);
criterion_main!(benches);
