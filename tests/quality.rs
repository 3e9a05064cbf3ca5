//! The figures by which waves are compared, on waves that are known.

use bevy::prelude::*;
use bevy_field_patterns::{
    field::Symmetry,
    surface::{SurfaceGraph, WeldOptions},
    wave::{Quality, quality},
};
use std::f32::consts::TAU;

const SYMMETRIES: [Symmetry; 2] = [Symmetry::Line, Symmetry::Vector];

/// A flat, irregular sheet over 0..=1 × 0..=1 with n × n squares.
fn sheet(n: u32) -> SurfaceGraph {
    let row = n + 1;
    let positions: Vec<Vec3> = (0..row * row)
        .map(|i| {
            let (u, v) = ((i % row) as f32 / n as f32, (i / row) as f32 / n as f32);
            let sway = 0.2 / n as f32 * (17.0 * (u + 2.0 * v)).sin();
            Vec3::new(u + sway, v - sway, 0.5)
        })
        .collect();
    let triangles: Vec<[u32; 3]> = (0..n * n)
        .flat_map(|s| {
            let a = s / n * row + s % n;
            [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]]
        })
        .collect();
    SurfaceGraph::from_triangles(&positions, &triangles, &WeldOptions::default()).expect("a sheet")
}

/// Phasors of a phase that is given in radians.
fn phasors(graph: &SurfaceGraph, phase: impl Fn(Vec3) -> f32) -> Vec<Vec2> {
    graph.positions.iter().map(|&p| Vec2::from_angle(phase(p))).collect()
}

/// A repeatable sequence of random bits.
fn coins() -> impl Iterator<Item = bool> {
    std::iter::successors(Some(0x9e37_79b9_7f4a_7c15_u64), |&x| {
        let x = x ^ (x << 13);
        let x = x ^ (x >> 7);
        Some(x ^ (x << 17))
    })
    .map(|x| x >> 40 & 1 == 1)
}

/// Turns a random half of the directions round, and the phasors with them.
fn turned_round(directions: &[Vec3], phasors: &[Vec2]) -> (Vec<Vec3>, Vec<Vec2>) {
    let turn = |((&d, &z), coin): ((&Vec3, &Vec2), bool)| if coin { (-d, Vec2::new(-z.x, z.y)) } else { (d, z) };
    directions.iter().zip(phasors).zip(coins()).map(turn).unzip()
}

fn assert_close(a: Quality, b: Quality) {
    assert_eq!((a.branches, a.odd_triangles), (b.branches, b.odd_triangles));
    for (a, b) in [
        (a.energy, b.energy),
        (a.angle_over_5deg, b.angle_over_5deg),
        (a.angle_mean_deg, b.angle_mean_deg),
        (a.spacing_p50, b.spacing_p50),
        (a.spacing_p95, b.spacing_p95),
    ] {
        assert!((a - b).abs() < 1e-9, "{a} against {b}");
    }
}

#[test]
fn plane_wave_is_perfect_at_any_frequency() {
    let graph = sheet(12);
    let d = Vec3::new(0.8, 0.6, 0.0);
    let directions = vec![d; graph.len()];
    // Up to 7 periods per edge: the phase is rounded, the residual is not.
    for frequency in [0.0, 1.0, 20.0, 80.0] {
        let frequencies = vec![frequency; graph.len()];
        let wave = phasors(&graph, |p| TAU * (frequency * d.dot(p)).fract());
        let (random_directions, random_wave) = turned_round(&directions, &wave);
        let flawless = |q: Quality| {
            assert!(q.energy < 1e-9, "{q:?}");
            assert_eq!((q.branches, q.odd_triangles, q.angle_over_5deg), (0, 0, 0.0));
            assert!(q.angle_mean_deg < 0.1 && q.spacing_p95 < 1e-3, "{q:?}");
        };
        flawless(quality(&graph, &directions, &frequencies, &wave, Symmetry::Vector));
        flawless(quality(&graph, &directions, &frequencies, &wave, Symmetry::Line));
        flawless(quality(
            &graph,
            &random_directions,
            &frequencies,
            &random_wave,
            Symmetry::Line,
        ));
    }
}

#[test]
fn linear_chirp_is_perfect_on_every_edge() {
    let graph = sheet(12);
    let directions = vec![Vec3::X; graph.len()];
    let frequencies: Vec<f32> = graph.positions.iter().map(|p| 10.0 + 40.0 * p.x).collect();
    let wave = phasors(&graph, |p| TAU * (10.0 * p.x + 20.0 * p.x * p.x).fract());
    let q = quality(&graph, &directions, &frequencies, &wave, Symmetry::Vector);
    // On every edge; inside the triangles the phase is linear and the chirp is not.
    assert!(q.energy < 1e-9 && q.branches == 0, "{q:?}");
}

#[test]
fn wrong_direction_and_wrong_spacing_are_measured() {
    let graph = sheet(12);
    let directions = vec![Vec3::X; graph.len()];
    let frequencies = vec![5.0; graph.len()];
    let k = 1.1 * 5.0 * Vec2::from_angle(10_f32.to_radians());
    let wave = phasors(&graph, |p| TAU * k.dot(p.truncate()));
    for symmetry in SYMMETRIES {
        let q = quality(&graph, &directions, &frequencies, &wave, symmetry);
        assert!(
            (q.angle_mean_deg - 10.0).abs() < 1e-3 && q.angle_over_5deg > 0.999_999,
            "{q:?}"
        );
        assert!(
            (q.spacing_p50 - 0.1).abs() < 1e-4 && (q.spacing_p95 - 0.1).abs() < 1e-4,
            "{q:?}"
        );
    }
}

#[test]
fn energy_is_the_mean_over_edges() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let graph = SurfaceGraph::from_triangles(&corners, &[[0, 1, 2]], &WeldOptions::default()).expect("a triangle");
    let mut wave = vec![Vec2::X; 3];
    // A quarter of a period off at one vertex: two of the three edges have 1 - cos(90°) = 1, whatever the modulus.
    wave[1] = Vec2::new(0.0, 0.3);
    let q = quality(&graph, &[Vec3::X; 3], &[0.0; 3], &wave, Symmetry::Vector);
    assert!((q.energy - 2.0 / 3.0).abs() < 1e-12);
    assert_eq!(q.branches, 0);
}

#[test]
fn dislocation_is_one_branch() {
    let graph = sheet(20);
    let frequency = 6.0;
    let directions = vec![Vec3::X; graph.len()];
    let frequencies = vec![frequency; graph.len()];
    // Inside a triangle, away from its sides.
    let corner = |k: usize| graph.positions[graph.triangles[417][k] as usize];
    let centre = (corner(0) + corner(1) + corner(2)) / 3.0;
    for (winding, branches) in [(0.0, 0), (1.0, 1), (-1.0, 1)] {
        let wave = phasors(&graph, |p| {
            TAU * frequency * p.x + winding * (p - centre).truncate().to_angle()
        });
        for symmetry in SYMMETRIES {
            let q = quality(&graph, &directions, &frequencies, &wave, symmetry);
            assert_eq!((q.branches, q.odd_triangles), (branches, 0), "{q:?}");
        }
    }
}

#[test]
fn singularity_of_a_line_field_is_odd_and_of_a_vector_field_is_not() {
    let graph = sheet(9);
    // Half a turn around the middle.
    let directions: Vec<Vec3> = graph
        .positions
        .iter()
        .map(|p| Vec2::from_angle(0.5 * (p.truncate() - Vec2::splat(0.5)).to_angle()).extend(0.0))
        .collect();
    let wave = vec![Vec2::X; graph.len()];
    let frequencies = vec![8.0; graph.len()];
    let odd = |symmetry| quality(&graph, &directions, &frequencies, &wave, symmetry).odd_triangles;
    assert_eq!((odd(Symmetry::Line), odd(Symmetry::Vector)), (1, 0));
}

#[test]
fn sign_of_a_line_does_not_matter() {
    let graph = sheet(16);
    let swirl = |p: &Vec3| Vec2::from_angle(3.0 * p.x - 5.0 * p.y * p.y).extend(0.0);
    let directions: Vec<Vec3> = graph.positions.iter().map(swirl).collect();
    let frequencies: Vec<f32> = graph.positions.iter().map(|p| 9.0 + 4.0 * p.y).collect();
    let wave = phasors(&graph, |p| 40.0 * p.x * p.y + 11.0 * (7.0 * p.y).sin());
    let (turned, turned_wave) = turned_round(&directions, &wave);
    let before = quality(&graph, &directions, &frequencies, &wave, Symmetry::Line);
    let after = quality(&graph, &turned, &frequencies, &turned_wave, Symmetry::Line);
    assert!(before.branches > 0 && before.energy > 0.1);
    assert_close(before, after);
    // The check can fail: without the phasors the wave is another one.
    assert_ne!(before, quality(&graph, &turned, &frequencies, &wave, Symmetry::Line));
}

#[test]
fn degenerate_triangles_do_not_count() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, 2.0 * Vec3::X];
    let triangles = [[0, 1, 2], [0, 1, 3], [0, 0, 2], [1, 1, 1]];
    let graph = SurfaceGraph::from_triangles(&corners, &triangles, &WeldOptions::default()).expect("a triangle");
    let wave = phasors(&graph, |p| TAU * 0.1 * p.x);
    let q = quality(&graph, &[Vec3::X; 4], &[0.1; 4], &wave, Symmetry::Line);
    assert!(
        q.energy < 1e-12 && q.angle_mean_deg < 1e-4 && q.spacing_p95 < 1e-5,
        "{q:?}"
    );
}
