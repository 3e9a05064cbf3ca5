//! What a mesh costs before its first pattern: welding, neighbours, colours and levels; and its curvature.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Mesh, PrimitiveTopology},
};
use bevy_field_patterns::{
    field::{DirectionField, Principal, Symmetry, directions},
    surface::{SurfaceGraph, WeldOptions},
};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

mod common;

fn graph(c: &mut Criterion) {
    let mut group = c.benchmark_group("graph");
    group.sample_size(10);
    for (name, raw) in common::meshes() {
        group.throughput(Throughput::Elements(raw.positions.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(name), |b| {
            b.iter(|| {
                let graph = SurfaceGraph::from_triangles(&raw.positions, &raw.triangles, &WeldOptions::default());
                black_box(graph.expect("a good mesh"))
            });
        });
    }
}

fn curvature(c: &mut Criterion) {
    let mut group = c.benchmark_group("curvature");
    group.sample_size(10);
    let (name, raw) = common::torus();
    let graph = common::graph(&raw);
    // The field is made from the graph alone.
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    for smoothing in [0, 30] {
        let field = DirectionField::PrincipalCurvature {
            direction: Principal::Major,
            smoothing,
        };
        group.throughput(Throughput::Elements(graph.len() as u64));
        group.bench_function(BenchmarkId::new(name, smoothing), |b| {
            b.iter(|| black_box(directions(&field, Symmetry::Line, 0.0, &graph, &mesh)).expect("a field"));
        });
    }
}

criterion_group!(benches, graph, curvature);
criterion_main!(benches);
