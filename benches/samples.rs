//! What samples on a surface cost: the first set, a step, and the whole call.

use bevy::{
    math::Vec3,
    tasks::{ComputeTaskPool, TaskPool},
};
use bevy_field_patterns::{
    sampling::{
        Density, Progress,
        surface::{SurfaceMethod, SurfaceSampling, sample_surface},
    },
    surface::SurfaceGraph,
};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam_matrix_extras::SymmetricMat3;
use std::hint::black_box;

mod common;

/// Samples on each mesh.
const COUNT: u32 = 10_000;

/// Ellipses of ratio 4, long around the y axis.
fn metric(graph: &SurfaceGraph) -> Vec<SymmetricMat3> {
    let outer = |v: Vec3, k: f32| SymmetricMat3::from_outer_product(v) * k;
    graph
        .normals
        .iter()
        .map(|&normal| {
            let long = normal
                .cross(Vec3::Y)
                .try_normalize()
                .unwrap_or_else(|| normal.any_orthonormal_vector());
            outer(long, 0.25) + outer(normal.cross(long), 4.0) + outer(normal, 1.0)
        })
        .collect()
}

fn surface(c: &mut Criterion) {
    ComputeTaskPool::get_or_init(TaskPool::default);
    let mut group = c.benchmark_group("samples");
    group.sample_size(10);
    let (name, raw) = common::sphere();
    let graph = common::graph(&raw);
    let metric = metric(&graph);
    for method in [SurfaceMethod::Labels, SurfaceMethod::Triangulated, SurfaceMethod::Paper] {
        if method != SurfaceMethod::Labels && !cfg!(feature = "meshopt") {
            continue;
        }
        for steps in [0, 10] {
            let density = Density::Count(COUNT);
            let options = SurfaceSampling {
                density,
                method,
                steps,
                seed: 1,
            };
            group.throughput(Throughput::Elements(u64::from(COUNT)));
            group.bench_function(BenchmarkId::new(format!("{name} {method:?}"), steps), |b| {
                b.iter(|| {
                    let samples = sample_surface(&graph, &metric, &options, &Progress::default());
                    black_box(samples.expect("good input"))
                });
            });
        }
    }
}

criterion_group!(benches, surface);
criterion_main!(benches);
