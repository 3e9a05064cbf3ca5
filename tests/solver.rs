//! Theorems about the solver, on the CPU.

#[path = "common/mod.rs"]
mod common;

use bevy::prelude::*;
use bevy_field_patterns::{
    field::{DirectionField, Principal, Symmetry, directions},
    surface::{Level, SurfaceGraph, WeldOptions},
    wave::{
        kite::{cmul, edge_phase, phasor, reversed},
        quality,
        solver::{
            Child, ColdStart, Edges, LocalRule, MergedRule, Relaxation, SolverSettings, align, coarsen, edges, energy,
            hash_turns, normalize_or, prolong, solve_cpu, sweep, v_cycle,
        },
        {Coupling, Waves},
    },
};
use common::{mesh_file::RawMesh, shapes};

fn graph_of(raw: &RawMesh) -> SurfaceGraph {
    SurfaceGraph::from_triangles(&raw.positions, &raw.triangles, &WeldOptions::default()).unwrap()
}

fn field_of(graph: &SurfaceGraph, raw: &RawMesh, field: &DirectionField, symmetry: Symmetry) -> Vec<Vec3> {
    directions(field, symmetry, 0.0, graph, &common::mesh_file::to_bevy_mesh(raw)).unwrap()
}

fn curvature() -> DirectionField {
    DirectionField::PrincipalCurvature {
        direction: Principal::Major,
        smoothing: 30,
    }
}

fn random_signs(n: usize) -> Vec<bool> {
    (0..n as u32).map(|i| hash_turns(i.wrapping_mul(7919)) < 0.4).collect()
}

#[test]
fn kite_is_exact_for_radial_fields_and_reverses_exactly() {
    let mut worst: f32 = 0.0;
    for i in 0..10_000 {
        let unit = |k: u32| phasor(hash_turns(i * 4 + k));
        let (a, b) = (
            unit(0) * (1.0 + hash_turns(i * 4 + 2)),
            unit(1) * (1.0 + hash_turns(i * 4 + 3)),
        );
        let (v_i, v_j) = (a.extend(0.0), b.extend(0.0));
        let (d_i, d_j) = (v_i.normalize(), v_j.normalize());
        let edge = edge_phase(v_i - v_j, d_j, d_i, Symmetry::Line);
        if d_i.dot(d_j) > 0.0 {
            worst = worst.max((edge.distance - (v_i.length() - v_j.length())).abs());
        }
        let back = edge_phase(v_j - v_i, d_i, d_j, Symmetry::Line);
        let s = if edge.flip { 1.0 } else { -1.0 };
        assert_eq!(
            (back.distance, back.weight, back.flip),
            (s * edge.distance, edge.weight, edge.flip)
        );
        assert!(edge.distance.abs() <= 1.4143 * (v_i - v_j).length());
    }
    assert!(worst < 2e-6, "{worst}");
}

#[test]
fn kite_survives_degenerate_directions() {
    let e = Vec3::X;
    for (d_j, d_i) in [
        (Vec3::ZERO, Vec3::ZERO),
        (Vec3::X, Vec3::ZERO),
        (Vec3::X, Vec3::NEG_X),
        (Vec3::X, Vec3::Y),
        (Vec3::Y, Vec3::Y),
    ] {
        for symmetry in [Symmetry::Line, Symmetry::Vector] {
            let edge = edge_phase(e, d_j, d_i, symmetry);
            assert!(edge.distance.is_finite() && edge.distance.abs() <= 1.4143 && (0.0..=1.0).contains(&edge.weight));
        }
    }
    assert_eq!(edge_phase(e, Vec3::X, Vec3::NEG_X, Symmetry::Line).distance, 1.0);
    assert_eq!(edge_phase(e, Vec3::X, Vec3::NEG_X, Symmetry::Vector).weight, 0.0);
}

#[test]
fn plain_and_turning_sweeps_never_raise_the_energy() {
    let raw = shapes::torus(60, 30, 1.0, 0.4, 0.25, 1);
    let graph = graph_of(&raw);
    for (symmetry, field) in [
        (Symmetry::Line, curvature()),
        (Symmetry::Vector, DirectionField::Axis(Dir3::Y)),
    ] {
        let d = field_of(&graph, &raw, &field, symmetry);
        let f = vec![6.0; graph.len()];
        let (constants, sums) = edges(&graph, &d, &f, symmetry);
        for relaxation in [
            Relaxation::Plain,
            Relaxation::Turn { omega: 1.6 },
            Relaxation::Turn { omega: 0.5 },
        ] {
            let mut z: Vec<Vec2> = (0..graph.len() as u32).map(|i| phasor(hash_turns(i))).collect();
            let mut before = energy(graph.mesh_level(), &constants, &sums, &z);
            let start = before;
            for _ in 0..30 {
                sweep(graph.mesh_level(), &constants, &sums, &mut z, relaxation);
                let now = energy(graph.mesh_level(), &constants, &sums, &z);
                assert!(now <= before * (1.0 + 1e-6), "{relaxation:?}: {before} -> {now}");
                before = now;
            }
            assert!(before < 0.3 * start, "{relaxation:?}: {start} -> {before}");
        }
    }
}

#[test]
fn nothing_changes_when_lines_are_turned_round() {
    let raw = shapes::torus(60, 30, 1.0, 0.4, 0.25, 2);
    let graph = graph_of(&raw);
    let d = field_of(&graph, &raw, &curvature(), Symmetry::Line);
    let f: Vec<f32> = graph.positions.iter().map(|p| 5.0 + p.x).collect();
    let signs = random_signs(graph.len());
    let turned: Vec<Vec3> = d.iter().zip(&signs).map(|(&d, &s)| if s { -d } else { d }).collect();
    // Ten sweeps: what is compared is the operator, not how rounding grows over many of them.
    let settings = SolverSettings {
        soft_sweeps: 1,
        plain_sweeps: 1,
        ..default()
    };
    let a = solve_cpu(&graph, &d, &f, Symmetry::Line, &settings).phasors;
    let b = solve_cpu(&graph, &turned, &f, Symmetry::Line, &settings).phasors;
    let (qa, qb) = (
        quality(&graph, &d, &f, &a, Symmetry::Line),
        quality(&graph, &turned, &f, &b, Symmetry::Line),
    );
    // The phase of each component is free on the way (a root may be turned round), so compare gauge-free figures.
    assert!((qa.energy - qb.energy).abs() < 0.02 * qa.energy + 1e-6, "{qa:?} {qb:?}");
    let same: Vec<Vec2> = a
        .iter()
        .zip(&signs)
        .map(|(&z, &s)| if s { reversed(z) } else { z })
        .collect();
    let (ea, sums_a) = edges(&graph, &d, &f, Symmetry::Line);
    let (eb, sums_b) = edges(&graph, &turned, &f, Symmetry::Line);
    let (mut x, mut y) = (a.clone(), same);
    for _ in 0..5 {
        sweep(graph.mesh_level(), &ea, &sums_a, &mut x, Relaxation::Plain);
        sweep(graph.mesh_level(), &eb, &sums_b, &mut y, Relaxation::Plain);
    }
    for ((x, y), s) in x.iter().zip(&y).zip(&signs) {
        let x = if *s { reversed(*x) } else { *x };
        assert!(x.distance(*y) < 1e-4);
    }
}

/// A flat jittered grid with a constant direction: the exact answer is a plane wave.
#[test]
fn constant_field_on_a_plane_is_exact() {
    let raw = shapes::plane(40, 0.25, 3);
    let graph = graph_of(&raw);
    let axis = Vec3::new(0.3, 0.2, 0.9);
    let signs = random_signs(graph.len());
    let d: Vec<Vec3> = graph
        .normals
        .iter()
        .zip(&signs)
        .map(|(&n, &s)| (axis - n * n.dot(axis)).normalize() * if s { -1.0 } else { 1.0 })
        .collect();
    let f = vec![12.0; graph.len()];
    let z = solve_cpu(&graph, &d, &f, Symmetry::Line, &default()).phasors;
    let q = quality(&graph, &d, &f, &z, Symmetry::Line);
    assert!(q.energy < 1e-9, "{q:?}");
    assert_eq!((q.branches, q.odd_triangles), (0, 0));
    assert!(q.spacing_p95 < 1e-3 && q.angle_mean_deg < 0.05, "{q:?}");
    let exact = |i: usize| {
        let along = if signs[i] { -d[i] } else { d[i] };
        let z = phasor(12.0 * graph.positions[i].dot(along));
        if signs[i] { reversed(z) } else { z }
    };
    // One global phase is free.
    let frame = |i: usize, z: Vec2| if signs[i] { reversed(z) } else { z };
    let offset = cmul(frame(0, z[0]), Vec2::new(frame(0, exact(0)).x, -frame(0, exact(0)).y));
    for (i, &z) in z.iter().enumerate() {
        let error = frame(i, z).distance(cmul(frame(i, exact(i)), offset)) / std::f32::consts::TAU;
        assert!(error < 1e-4, "vertex {i} is off by {error} periods");
    }
}

#[test]
fn sphere_and_torus_reach_their_numbers() {
    let mut sphere = shapes::icosphere(5, 0.5 / 3f32.sqrt());
    // Away from the symmetries of the icosahedron.
    let turn = Quat::from_axis_angle(Vec3::new(0.3, 0.5, 0.8).normalize(), 0.77);
    sphere.positions.iter_mut().for_each(|p| *p = turn * *p);
    let graph = graph_of(&sphere);
    let axis = DirectionField::Axis(Dir3::new(Vec3::new(0.15, 1.0, 0.1)).unwrap());
    let d = field_of(&graph, &sphere, &axis, Symmetry::Line);
    for frequency in [20.0, 40.0, 80.0] {
        let f = vec![frequency; graph.len()];
        let z = solve_cpu(&graph, &d, &f, Symmetry::Line, &default()).phasors;
        let q = quality(&graph, &d, &f, &z, Symmetry::Line);
        assert!(q.energy <= 1e-4 && q.branches == 0, "f {frequency}: {q:?}");
        assert!(
            q.angle_over_5deg <= 0.002 && q.spacing_p95 <= 0.02,
            "f {frequency}: {q:?}"
        );
    }
    let size = (2.8f32 * 2.8 * 2.0 + 0.8 * 0.8).sqrt();
    let torus = shapes::torus(220, 88, 1.0 / size, 0.4 / size, 0.25, 1);
    let graph = graph_of(&torus);
    let d = field_of(&graph, &torus, &curvature(), Symmetry::Line);
    for frequency in [20.0, 40.0, 80.0] {
        let f = vec![frequency; graph.len()];
        let z = solve_cpu(&graph, &d, &f, Symmetry::Line, &default()).phasors;
        let q = quality(&graph, &d, &f, &z, Symmetry::Line);
        assert!(q.energy <= 4e-4 && q.branches == 0, "f {frequency}: {q:?}");
    }
}

#[test]
fn hierarchy_beats_the_local_rule_which_stops_by_itself() {
    let raw = shapes::torus(80, 40, 1.0, 0.4, 0.25, 4);
    let graph = graph_of(&raw);
    let d = field_of(&graph, &raw, &curvature(), Symmetry::Line);
    let f = vec![8.0; graph.len()];
    let energy_of = |settings: &SolverSettings| {
        let solution = solve_cpu(&graph, &d, &f, Symmetry::Line, settings);
        (
            quality(&graph, &d, &f, &solution.phasors, Symmetry::Line).energy,
            solution.sweeps,
        )
    };
    let local = |rule| SolverSettings {
        cold_start: ColdStart::Local(rule),
        ..default()
    };
    let (hierarchy, _) = energy_of(&default());
    let (thirty, sweeps) = energy_of(&local(LocalRule {
        max_sweeps: 30,
        epsilon: 0.0,
        ..default()
    }));
    assert_eq!(sweeps, 30);
    assert!(hierarchy < 0.5 * thirty, "{hierarchy} {thirty}");
    let (_, sweeps) = energy_of(&local(LocalRule {
        epsilon: 0.05,
        ..default()
    }));
    assert!((2..30).contains(&sweeps), "{sweeps}");
    let (skipping, _) = energy_of(&local(LocalRule {
        max_sweeps: 30,
        epsilon: 0.0,
        skip_last_third: true,
        ..default()
    }));
    assert!(skipping < 2.0 * thirty);
}

#[test]
fn solving_survives_what_has_no_answer() {
    let triangle = RawMesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
        triangles: vec![[0, 1, 2]],
    };
    let graph = graph_of(&triangle);
    assert_eq!(graph.components(), 2);
    for d in [Vec3::ZERO, Vec3::X] {
        for f in [0.0, 1e6] {
            let (d, f) = (vec![d; graph.len()], vec![f; graph.len()]);
            let z = solve_cpu(&graph, &d, &f, Symmetry::Line, &default()).phasors;
            assert!(z.iter().all(|z| z.is_finite()), "{z:?}");
        }
    }
    assert_eq!(normalize_or(Vec2::ZERO, Vec2::X), Vec2::X);
}

/// How well the phasors agree with what they see: the energy is Σw minus this.
fn coherence(level: &Level, edges: &Edges, z: &[Vec2]) -> f64 {
    let waves = edges.waves();
    (0..waves * level.len())
        .map(|node| {
            let seen = edges.seen_sum(level, node / waves, node % waves, |source| z[source]);
            f64::from(z[node].dot(seen))
        })
        .sum()
}

/// A rotation of the aggregates changes the energy of the mesh by exactly what it changes the coarse energy.
#[test]
fn coarse_energy_is_the_fine_energy() {
    let raw = shapes::torus(60, 30, 1.0, 0.4, 0.25, 6);
    let graph = graph_of(&raw);
    let d = field_of(&graph, &raw, &DirectionField::Axis(Dir3::Y), Symmetry::Vector);
    for waves in [Waves::Single, Waves::Orthogonal { ratio: 1.5 }] {
        let coupling = Coupling {
            waves,
            symmetry: Symmetry::Vector,
        };
        let (fine, _) = edges(&graph, &d, &vec![5.0; graph.len()], coupling);
        let [level, coarse, ..] = &graph.levels[..] else {
            panic!("two levels at least");
        };
        let nodes = waves.count() * level.len();
        let (mut z, mut children) = (vec![Vec2::X; nodes], vec![Child::default(); nodes]);
        align(level, &fine, &mut z, &mut children);
        assert!(
            children.iter().all(|&child| child == Child::default()),
            "nothing flips on a vector field"
        );
        let ab = coarsen(level, &fine, &z, &children, coarse);
        let coarse_nodes = waves.count() * coarse.len();
        let one = vec![Vec2::X; coarse_nodes];
        let (fine_before, coarse_before) = (coherence(level, &fine, &z), coherence(coarse, &ab, &one));
        for seed in 0..5 {
            let y: Vec<Vec2> = (0..coarse_nodes as u32)
                .map(|p| phasor(hash_turns(p * 5 + seed)))
                .collect();
            let mut rotated = z.clone();
            prolong(level, &y, &children, &mut rotated);
            let fine_change = coherence(level, &fine, &rotated) - fine_before;
            let coarse_change = coherence(coarse, &ab, &y) - coarse_before;
            assert!(
                (fine_change - coarse_change).abs() < 1e-5 * fine_before,
                "{fine_change} {coarse_change}"
            );
            assert!(coarse_change.abs() > 1e-3 * fine_before, "the comparison can fail");
        }
    }
}

/// A straight field on a flat mesh is met exactly, and its figures are zeros without a sign.
#[test]
fn a_perfect_wave_has_perfect_figures() {
    let at = |v: u32| Vec3::new((v % 9) as f32, (v / 9) as f32, 0.0);
    let cell = |c: u32| c / 8 * 9 + c % 8;
    let raw = RawMesh {
        positions: (0..81).map(at).collect(),
        triangles: (0..64)
            .map(cell)
            .flat_map(|v| [[v, v + 1, v + 10], [v, v + 10, v + 9]])
            .collect(),
    };
    let graph = graph_of(&raw);
    let d = field_of(&graph, &raw, &DirectionField::Axis(Dir3::X), Symmetry::Vector);
    let f = vec![0.2; graph.len()];
    let z = solve_cpu(&graph, &d, &f, Symmetry::Vector, &default()).phasors;
    let q = quality(&graph, &d, &f, &z, Symmetry::Vector);
    assert!(q.energy < 1e-6 && q.branches == 0, "{q:?}");
    assert_eq!((q.angle_over_5deg, q.angle_over_5deg.is_sign_positive()), (0.0, true));
}

/// Every step of a V-cycle is a descent: on a vector field, where nothing flips, it never raises the energy.
#[test]
fn v_cycle_never_raises_the_energy() {
    let raw = shapes::torus(60, 30, 1.0, 0.4, 0.25, 6);
    let graph = graph_of(&raw);
    for (symmetry, slack) in [(Symmetry::Vector, 1e-5), (Symmetry::Line, 0.02)] {
        let d = field_of(&graph, &raw, &DirectionField::Axis(Dir3::Y), symmetry);
        let (fine, sums) = edges(&graph, &d, &vec![5.0; graph.len()], symmetry);
        let energy_of = |z: &[Vec2]| energy(graph.mesh_level(), &fine, &sums, z);
        for omega in [1.0, 1.6] {
            let mut z: Vec<Vec2> = (0..graph.len() as u32).map(|i| phasor(hash_turns(i))).collect();
            let start = energy_of(&z);
            let mut before = start;
            for _ in 0..15 {
                v_cycle(&graph, &fine, 1, omega, &mut z);
                let cycled = energy_of(&z);
                assert!(
                    cycled <= before * (1.0 + slack),
                    "{symmetry:?}, {omega}: {before} -> {cycled}"
                );
                sweep(graph.mesh_level(), &fine, &sums, &mut z, Relaxation::Plain);
                before = energy_of(&z);
                assert!(before <= cycled * (1.0 + 1e-6));
            }
            // It is worth something: sweeps alone end higher.
            let mut swept: Vec<Vec2> = (0..graph.len() as u32).map(|i| phasor(hash_turns(i))).collect();
            for _ in 0..15 {
                sweep(graph.mesh_level(), &fine, &sums, &mut swept, Relaxation::Plain);
            }
            assert!(before < 0.95 * energy_of(&swept), "{before} {}", energy_of(&swept));
        }
    }
    // The check can fail: rotating aggregates at random does raise it.
    let d = field_of(&graph, &raw, &DirectionField::Axis(Dir3::Y), Symmetry::Vector);
    let (fine, sums) = edges(&graph, &d, &vec![5.0; graph.len()], Symmetry::Vector);
    let mut z = solve_cpu(&graph, &d, &vec![5.0; graph.len()], Symmetry::Vector, &default()).phasors;
    let before = energy(graph.mesh_level(), &fine, &sums, &z);
    let y: Vec<Vec2> = (0..graph.levels[1].len() as u32)
        .map(|p| phasor(hash_turns(p)))
        .collect();
    prolong(graph.mesh_level(), &y, &vec![Child::default(); graph.len()], &mut z);
    assert!(energy(graph.mesh_level(), &fine, &sums, &z) > 2.0 * before);
}

/// Merged surfaces halve, keep area and components, and bring the local rule to longer waves.
#[test]
fn merged_surfaces_help_the_local_rule() {
    let raw = shapes::torus(80, 40, 1.0, 0.4, 0.25, 4);
    let graph = graph_of(&raw);
    let surfaces = graph.merged(10);
    let mut finer = &graph;
    for surface in &surfaces {
        let n = surface.graph.len();
        assert!(n < finer.len() * 7 / 10 || n < 10, "{n} of {}", finer.len());
        assert_eq!(surface.parents.len(), finer.len());
        let mut parts = vec![0; n];
        surface.parents.iter().for_each(|&parent| parts[parent as usize] += 1);
        assert!(parts.iter().all(|&parts| parts == 1 || parts == 2));
        let area = |graph: &SurfaceGraph| graph.areas.iter().sum::<f32>();
        assert!((area(&surface.graph) / area(&graph) - 1.0).abs() < 1e-4);
        let level = finer.mesh_level();
        for i in 0..finer.len() {
            for k in level.edges(i) {
                let [a, b] = [i as u32, level.neighbors[k]].map(|v| surface.parents[v as usize]);
                let coarse = surface.graph.mesh_level();
                let row = &coarse.neighbors[coarse.edges(a as usize)];
                assert!(a == b || row.binary_search(&b).is_ok(), "edges become edges");
            }
        }
        finer = &surface.graph;
    }
    let f = vec![8.0; graph.len()];
    let solved = |symmetry, d: &[Vec3], cold_start| {
        let settings = SolverSettings {
            cold_start,
            ..default()
        };
        let z = solve_cpu(&graph, d, &f, symmetry, &settings).phasors;
        quality(&graph, d, &f, &z, symmetry).energy
    };
    for (symmetry, field) in [
        (Symmetry::Line, curvature()),
        (Symmetry::Vector, DirectionField::Axis(Dir3::Y)),
    ] {
        let d = field_of(&graph, &raw, &field, symmetry);
        let merged = |levels| {
            let local = LocalRule::default();
            solved(symmetry, &d, ColdStart::Merged(MergedRule { levels, local }))
        };
        let local = solved(symmetry, &d, ColdStart::Local(LocalRule::default()));
        // On no surface but the mesh, it is the local rule.
        assert_eq!(merged(0), local);
        assert!(merged(10) < 0.95 * local, "{symmetry:?}: {} {local}", merged(10));
        assert!(
            solved(symmetry, &d, ColdStart::default()) < 1.05 * merged(10),
            "{symmetry:?}"
        );
    }
}
