//! The solver's CPU twin: a solve from nothing, and one sweep.

use bevy::math::{Vec2, Vec3};
use bevy_field_patterns::{
    field::{Symmetry, project_tangent},
    surface::SurfaceGraph,
    wave::kite::phasor,
    wave::solver::{Relaxation, SolverSettings, edges, hash_turns, solve_cpu, sweep},
};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

mod common;

/// The field of an axis with 12 stripes per unit length.
fn field(graph: &SurfaceGraph) -> (Vec<Vec3>, Vec<f32>) {
    let axis = Vec3::new(0.15, 1.0, 0.1).normalize();
    let directions = graph.normals.iter().map(|&n| project_tangent(axis, n)).collect();
    (directions, vec![12.0; graph.len()])
}

fn cold(c: &mut Criterion) {
    let mut group = c.benchmark_group("cold solve");
    group.sample_size(10);
    for (name, raw) in [common::torus(), common::sphere()] {
        let graph = common::graph(&raw);
        let (d, f) = field(&graph);
        group.throughput(Throughput::Elements(graph.len() as u64));
        for symmetry in [Symmetry::Line, Symmetry::Vector] {
            group.bench_function(BenchmarkId::new(name, format!("{symmetry:?}")), |b| {
                b.iter(|| black_box(solve_cpu(&graph, &d, &f, symmetry, &SolverSettings::default())));
            });
        }
    }
}

fn one_sweep(c: &mut Criterion) {
    let mut group = c.benchmark_group("sweep");
    let soft = Relaxation::Soft {
        omega: 1.6,
        softness: 0.9,
    };
    for (name, raw) in [common::torus(), common::sphere()] {
        let graph = common::graph(&raw);
        let (d, f) = field(&graph);
        let (constants, sums) = edges(&graph, &d, &f, Symmetry::Line);
        group.throughput(Throughput::Elements(graph.len() as u64));
        for (kind, relaxation) in [("plain", Relaxation::Plain), ("soft", soft)] {
            let mut z: Vec<Vec2> = (0..graph.len() as u32).map(|i| phasor(hash_turns(i))).collect();
            group.bench_function(BenchmarkId::new(name, kind), |b| {
                b.iter(|| sweep(graph.mesh_level(), &constants, &sums, black_box(&mut z), relaxation));
            });
        }
        group.bench_function(BenchmarkId::new(name, "edges"), |b| {
            b.iter(|| black_box(edges(&graph, &d, &f, Symmetry::Line)));
        });
    }
}

criterion_group!(benches, cold, one_sweep);
criterion_main!(benches);
