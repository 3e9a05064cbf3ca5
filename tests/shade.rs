//! The wave inside triangles: continuity across edges, exactness on flat fields, symmetry, and data that is broken.

use bevy::math::{Vec2, Vec3, Vec4};
use bevy_field_patterns::{
    field::Symmetry,
    wave::{
        kite::{phasor, reversed},
        layout::{FLAG_READY, FLAG_VECTOR, PatternRecord},
        shade::{Corners, PatternMemory, Wave, sample_wave, wave_in_triangle},
    },
};
use std::f32::consts::TAU;

/// A small, fixed stream of numbers in 0..1.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        ((word >> 22) ^ word) as f32 / u32::MAX as f32
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5)
    }
}

/// A surface with a wave on it, given per vertex.
struct Patterned {
    positions: Vec<Vec3>,
    triangles: Vec<[usize; 3]>,
    directions: Vec<Vec3>,
    frequencies: Vec<f32>,
    z: Vec<Vec2>,
}

impl Patterned {
    fn corners(&self, triangle: usize) -> Corners {
        let [a, b, c] = self.triangles[triangle];
        Corners {
            position: [a, b, c].map(|v| self.positions[v]),
            direction: [a, b, c].map(|v| self.directions[v]),
            frequency: Vec3::new(self.frequencies[a], self.frequencies[b], self.frequencies[c]),
            z: [a, b, c].map(|v| self.z[v]),
        }
    }
}

/// A torus of size 1 with jittered vertices; directions from a jittered axis with random signs, frequencies that vary.
fn jittered_torus(frequency: f32, symmetry: Symmetry) -> Patterned {
    let (rings, sides) = (48, 24);
    let mut noise = Noise(7);
    let mut surface = Patterned {
        positions: vec![],
        triangles: vec![],
        directions: vec![],
        frequencies: vec![],
        z: vec![],
    };
    for i in 0..rings {
        for j in 0..sides {
            let (u, v) = (i as f32 / rings as f32 * TAU, j as f32 / sides as f32 * TAU);
            let radial = Vec3::new(u.cos(), 0.0, u.sin());
            let normal = radial * v.cos() + Vec3::Y * v.sin();
            let p = 0.35 * radial + 0.15 * normal + 0.01 * noise.vector();
            let d = (Vec3::new(0.15, 1.0, 0.1) + 0.3 * noise.vector())
                .reject_from(normal)
                .normalize();
            let turned = symmetry == Symmetry::Line && noise.next() < 0.3;
            surface.positions.push(p);
            surface.directions.push(if turned { -d } else { d });
            surface.frequencies.push(frequency * (1.0 + 0.3 * p.x));
            // Nearly in phase, as after a solve, with a defect here and there.
            let z = phasor(frequency * p.dot(Vec3::new(0.15, 1.0, 0.1).normalize()) + 0.15 * noise.next());
            surface.z.push(if turned { reversed(z) } else { z });
            let at = |i: usize, j: usize| (i % rings) * sides + j % sides;
            surface.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            surface.triangles.push([at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
        }
    }
    surface
}

/// Largest jumps of sin Φ over all edges: between two orientable triangles, and where one of them is odd.
fn edge_jumps(surface: &Patterned, symmetry: Symmetry) -> (f32, f32, usize) {
    let mut sides = std::collections::HashMap::<(usize, usize), Vec<(usize, usize)>>::new();
    for (t, triangle) in surface.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            sides.entry((a.min(b), a.max(b))).or_default().push((t, k));
        }
    }
    let (mut even, mut odd, mut odd_edges) = (0.0_f32, 0.0_f32, 0);
    for ((low, _), sides) in sides {
        let [first, second] = sides[..] else { continue };
        for sample in 0..9 {
            let along = 0.05 + 0.1125 * sample as f32;
            let wave = |(t, k): (usize, usize)| {
                let from_low = if surface.triangles[t][k] == low {
                    along
                } else {
                    1.0 - along
                };
                let mut b = Vec3::ZERO;
                b[k] = 1.0 - from_low;
                b[(k + 1) % 3] = from_low;
                wave_in_triangle(&surface.corners(t), symmetry, b)
            };
            let (one, other) = (wave(first), wave(second));
            let jump = (one.value - other.value).abs();
            if one.confidence.min(other.confidence) < 0.2 {
                continue;
            }
            if one.odd || other.odd {
                odd = odd.max(jump);
                odd_edges += 1;
            } else {
                even = even.max(jump);
            }
        }
    }
    (even, odd, odd_edges)
}

#[test]
fn sine_is_continuous_across_edges() {
    for frequency in [10.0, 40.0, 300.0] {
        let allowed = 1e-6 * frequency + 1e-5;
        let (even, odd, odd_samples) = edge_jumps(&jittered_torus(frequency, Symmetry::Line), Symmetry::Line);
        assert!(even <= allowed, "f = {frequency}: jump {even}");
        assert!(odd <= allowed, "f = {frequency}: jump {odd} at odd triangles");
        assert!(
            odd_samples > 50,
            "the surface must have odd triangles, or the test shows nothing"
        );
        let (jump, _, _) = edge_jumps(&jittered_torus(frequency, Symmetry::Vector), Symmetry::Vector);
        assert!(jump <= allowed, "f = {frequency}: jump {jump} on a vector field");
    }
}

#[test]
fn continuity_test_can_fail() {
    // Φ and π - Φ have one sine, but a phasor that is not turned with its direction has another.
    let mut surface = jittered_torus(40.0, Symmetry::Line);
    let shared = surface.triangles[100][0];
    let copy = surface.positions.len();
    surface.positions.push(surface.positions[shared]);
    surface.directions.push(surface.directions[shared]);
    surface.frequencies.push(surface.frequencies[shared]);
    surface.z.push(phasor(surface.z[shared].to_angle() / TAU + 0.1));
    let before = surface.corners(100);
    surface.triangles[100][0] = copy;
    let b = Vec3::new(0.5, 0.5, 0.0);
    let jump = wave_in_triangle(&before, Symmetry::Line, b).value
        - wave_in_triangle(&surface.corners(100), Symmetry::Line, b).value;
    assert!(
        jump.abs() > 1e-3,
        "one corner out of phase must show on its edges: {jump}"
    );
}

/// A flat grid with jittered vertices and exact phases.
fn flat(phase: impl Fn(Vec3) -> f32, direction: impl Fn(Vec3) -> Vec3, frequency: f32) -> Patterned {
    let n = 9;
    let mut noise = Noise(3);
    let mut surface = Patterned {
        positions: vec![],
        triangles: vec![],
        directions: vec![],
        frequencies: vec![],
        z: vec![],
    };
    for j in 0..n {
        for i in 0..n {
            let p = Vec3::new(i as f32 + 0.4 * noise.next(), j as f32 + 0.4 * noise.next(), 0.0) / (n - 1) as f32;
            surface.positions.push(p);
            surface.directions.push(direction(p));
            surface.frequencies.push(frequency);
            surface.z.push(phasor(phase(p)));
            if i + 1 < n && j + 1 < n {
                let at = j * n + i;
                surface.triangles.push([at, at + 1, at + n]);
                surface.triangles.push([at + 1, at + n + 1, at + n]);
            }
        }
    }
    surface
}

fn samples(surface: &Patterned, symmetry: Symmetry) -> Vec<Wave> {
    let mut noise = Noise(11);
    (0..surface.triangles.len())
        .flat_map(|t| std::iter::repeat_n(t, 8))
        .map(|t| {
            let (mut u, mut v) = (noise.next(), noise.next());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            wave_in_triangle(&surface.corners(t), symmetry, Vec3::new(u, v, 1.0 - u - v))
        })
        .collect()
}

/// Distance of a wave's phase from `turns`, in periods.
fn phase_error(wave: &Wave, turns: f32) -> f32 {
    let error = wave.phasor.to_angle() / TAU - turns;
    (error - error.round()).abs()
}

#[test]
fn constant_field_is_exact() {
    let d = Vec3::new(0.8, 0.6, 0.0);
    let f = 160.0; // 20 periods per edge
    for wave in samples(&flat(|p| f * p.dot(d), |_| d, f), Symmetry::Line) {
        assert!(phase_error(&wave, f * wave.position.dot(d)) < 1e-4);
        assert!((wave.gradient - f * d).length() < 1e-2);
        assert!((wave.confidence - 1.0).abs() < 1e-4);
    }
}

#[test]
fn radial_field_is_straight_at_many_periods_per_edge() {
    let center = Vec3::new(-0.6, 0.5, 0.0);
    let f = 160.0;
    let surface = flat(|p| f * p.distance(center), |p| (p - center).normalize(), f);
    let mut errors: Vec<f32> = samples(&surface, Symmetry::Vector)
        .iter()
        .map(|wave| phase_error(wave, f * wave.position.distance(center)))
        .collect();
    errors.sort_by(f32::total_cmp);
    let p95 = errors[errors.len() * 95 / 100];
    assert!(p95 < 0.004, "p95 of the phase error: {p95} periods");
}

#[test]
fn gradient_is_the_derivative_of_the_phase() {
    let center = Vec3::new(-0.6, 0.5, 0.0);
    let surface = flat(
        |p| 20.0 * p.distance(center) + 0.02 * (40.0 * p.y).sin(),
        |p| (p - center).normalize(),
        20.0,
    );
    let h = 1e-3;
    for t in 0..surface.triangles.len() {
        let corners = surface.corners(t);
        let b = Vec3::new(0.5, 0.3, 0.2);
        for step in [Vec3::new(h, -h, 0.0), Vec3::new(0.0, h, -h)] {
            let wave = |b| wave_in_triangle(&corners, Symmetry::Vector, b);
            let (before, after) = (wave(b - 0.5 * step), wave(b + 0.5 * step));
            let turns = (after.phasor.to_angle() - before.phasor.to_angle()) / TAU;
            let predicted = wave(b).gradient.dot(after.position - before.position);
            let scale = 20.0 * (after.position - before.position).length();
            assert!(
                (turns - turns.round() - predicted).abs() < 0.05 * scale,
                "{turns} against {predicted}"
            );
        }
    }
}

#[test]
fn turning_a_direction_round_changes_nothing() {
    let surface = jittered_torus(40.0, Symmetry::Line);
    let b = Vec3::new(0.2, 0.5, 0.3);
    for t in 0..surface.triangles.len() {
        let corners = surface.corners(t);
        let wave = wave_in_triangle(&corners, Symmetry::Line, b);
        for m in 0..3 {
            let mut turned = corners;
            turned.direction[m] = -corners.direction[m];
            turned.z[m] = reversed(corners.z[m]);
            let other = wave_in_triangle(&turned, Symmetry::Line, b);
            assert_eq!(wave.odd, other.odd);
            assert!((wave.value - other.value).abs() < 2e-5);
            assert!((wave.confidence - other.confidence).abs() < 2e-5);
            // The gradient is that of Φ or of π - Φ.
            let (g, h) = (wave.gradient, other.gradient);
            assert!((g - h).length().min((g + h).length()) < 1e-2 * (1.0 + g.length()));
        }
    }
}

#[test]
fn broken_data_gives_finite_numbers() {
    let zero = Corners {
        position: [Vec3::ZERO; 3],
        direction: [Vec3::ZERO; 3],
        frequency: Vec3::ZERO,
        z: [Vec2::ZERO; 3],
    };
    let good = jittered_torus(40.0, Symmetry::Vector).corners(0);
    let cancelling = Corners {
        direction: [Vec3::X, Vec3::NEG_X, Vec3::ZERO],
        ..good
    };
    let line = Corners {
        position: [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X],
        ..good
    };
    let far = Corners {
        position: good.position.map(|p| p + Vec3::splat(1e6)),
        ..good
    };
    let no_phase = Corners {
        z: [Vec2::ZERO; 3],
        ..good
    };
    for corners in [zero, good, cancelling, line, far, no_phase] {
        for symmetry in [Symmetry::Line, Symmetry::Vector] {
            for b in [
                Vec3::X,
                Vec3::Y,
                Vec3::Z,
                Vec3::splat(1.0 / 3.0),
                Vec3::new(0.5, 0.5, 0.0),
            ] {
                let wave = wave_in_triangle(&corners, symmetry, b);
                assert!(wave.phasor.is_finite() && wave.gradient.is_finite() && wave.direction.is_finite());
                assert!(wave.value.abs() <= 1.0 + 1e-6 && (0.0..=1.0 + 1e-5).contains(&wave.confidence));
            }
        }
    }
    let half = Vec3::new(0.5, 0.5, 0.0);
    assert!(
        wave_in_triangle(&cancelling, Symmetry::Vector, half).confidence < 0.01,
        "opposed directions are no wave"
    );
    assert!(
        wave_in_triangle(&no_phase, Symmetry::Line, half).confidence < 0.01,
        "no phasors are no wave"
    );
}

#[test]
fn memory_is_read_as_laid_out() {
    let corners = jittered_torus(40.0, Symmetry::Vector).corners(5);
    let record = PatternRecord {
        vertices: 3,
        triangles: 1,
        flags: FLAG_READY | FLAG_VECTOR,
        triangle_base: 4 + (size_of::<PatternRecord>() / 4) as u32,
        geometry_base: 2,
        field_base: 4,
        phasor_base: 1,
        ..PatternRecord::default()
    };
    let mut surface = vec![0_u32; 4];
    surface.extend_from_slice(bytemuck::cast_slice(&[record]));
    surface.extend([2, 0, 1]);
    let (mut geometry, mut waves) = (vec![Vec4::ZERO; 8], vec![Vec2::ZERO; 10]);
    for (m, vertex) in [2_usize, 0, 1].into_iter().enumerate() {
        geometry[2 + 2 * vertex] = corners.position[m].extend(9.0);
        waves[4 + 2 * vertex] = corners.direction[m].truncate();
        waves[5 + 2 * vertex] = Vec2::new(corners.direction[m].z, corners.frequency[m]);
        waves[1 + vertex] = corners.z[m];
    }
    let b = Vec3::new(0.5, 0.3, 0.2);
    let memory = PatternMemory {
        surface: &surface,
        geometry: &geometry,
        wave: &waves,
    };
    assert_eq!(
        sample_wave(&memory, 4, 0, b),
        wave_in_triangle(&corners, Symmetry::Vector, b)
    );
    assert!(!sample_wave(&memory, 0, 0, b).defined, "tag 0 means no pattern");
    assert!(!sample_wave(&memory, 4, 1, b).defined, "the record has one triangle");
    assert!(!sample_wave(&memory, 1_000, 0, b).defined, "a tag behind the buffer");
    surface[4 + 2] = FLAG_VECTOR;
    let memory = PatternMemory {
        surface: &surface,
        geometry: &geometry,
        wave: &waves,
    };
    assert!(!sample_wave(&memory, 4, 0, b).defined, "not solved yet");
}
