//! Two waves on one surface: theorems about their operator, and exactness of the texture coordinates they make.

#[path = "common/mod.rs"]
mod common;

use bevy::prelude::*;
use bevy_field_patterns::{
    field::directions,
    prelude::*,
    surface::{SurfaceGraph, WeldOptions},
    wave::{
        Coupling,
        kite::{self, phasor, reversed},
        shade::Corners,
        shade_pair::{PairCorners, pair_in_triangle},
        solver::{edges, energy, hash_turns, solve_cpu},
    },
};
use common::{mesh_file::RawMesh, shapes};

const CROSS: Coupling = Coupling {
    waves: Waves::Cross,
    symmetry: Symmetry::Line,
};

fn orthogonal(symmetry: Symmetry, ratio: f32) -> Coupling {
    Coupling {
        waves: Waves::Orthogonal { ratio },
        symmetry,
    }
}

fn graph_of(raw: &RawMesh) -> SurfaceGraph {
    SurfaceGraph::from_triangles(&raw.positions, &raw.triangles, &WeldOptions::default()).unwrap()
}

/// A field on a sphere that is smooth as a cross on the cube it is swollen from, with singularities of a quarter turn at
/// the corners.
fn cube_field() -> (SurfaceGraph, Vec<Vec3>) {
    let graph = graph_of(&shapes::icosphere(4, 1.0));
    let along = |n: &Vec3| {
        let a = n.abs();
        let edge = match () {
            () if a.x >= a.y && a.x >= a.z => Vec3::Y,
            () if a.y >= a.z => Vec3::Z,
            () => Vec3::X,
        };
        edge.reject_from(*n).normalize()
    };
    let d = graph.normals.iter().map(along).collect();
    (graph, d)
}

/// What the operator says of a frame that is turned by so many quarter turns, and its phasors with it.
fn turn(d: Vec3, n: Vec3, z: [Vec2; 2], quarters: usize) -> (Vec3, [Vec2; 2]) {
    (0..quarters).fold((d, z), |(d, z), _| (n.cross(d), [z[1], reversed(z[0])]))
}

#[test]
fn two_waves_of_a_vector_field_are_two_single_waves() {
    let raw = shapes::torus(60, 30, 1.0, 0.4, 0.25, 3);
    let graph = graph_of(&raw);
    let axis = DirectionField::Axis(Dir3::Y);
    let mesh = common::mesh_file::to_bevy_mesh(&raw);
    let d = directions(&axis, Symmetry::Vector, 0.0, &graph, &mesh).unwrap();
    let across: Vec<Vec3> = d.iter().zip(&graph.normals).map(|(d, n)| n.cross(*d)).collect();
    let f: Vec<f32> = graph.positions.iter().map(|p| 5.0 + p.x).collect();
    let doubled: Vec<f32> = f.iter().map(|f| 2.0 * f).collect();
    // Few sweeps: what is compared is the operator, not how rounding grows over many of them.
    let settings = SolverSettings {
        soft_sweeps: 1,
        plain_sweeps: 1,
        ..default()
    };
    let both = solve_cpu(&graph, &d, &f, orthogonal(Symmetry::Vector, 2.0), &settings).phasors;
    let first = solve_cpu(&graph, &d, &f, Symmetry::Vector, &settings).phasors;
    let second = solve_cpu(&graph, &across, &doubled, Symmetry::Vector, &settings).phasors;
    for v in 0..graph.len() {
        assert!(both[2 * v].distance(first[v]) < 1e-3);
        assert!(both[2 * v + 1].distance(second[v]) < 1e-3);
    }
}

#[test]
fn quarter_turns_of_the_frames_change_nothing_about_a_cross_field() {
    let (graph, d) = cube_field();
    let f = vec![6.0; graph.len()];
    let quarters: Vec<usize> = (0..graph.len() as u32)
        .map(|v| (4.0 * hash_turns(v.wrapping_mul(7919))) as usize % 4)
        .collect();
    let turned: Vec<Vec3> = (0..graph.len())
        .map(|v| turn(d[v], graph.normals[v], [Vec2::X; 2], quarters[v]).0)
        .collect();
    let carried = |z: &[Vec2]| -> Vec<Vec2> {
        (0..graph.len())
            .flat_map(|v| turn(d[v], graph.normals[v], [z[2 * v], z[2 * v + 1]], quarters[v]).1)
            .collect()
    };
    let measure = |d: &[Vec3], coupling: Coupling, z: &[Vec2]| {
        let (constants, sums) = edges(&graph, d, &f, coupling);
        energy(graph.mesh_level(), &constants, &sums, z)
    };
    let z = solve_cpu(&graph, &d, &f, CROSS, &default()).phasors;
    let (before, after) = (measure(&d, CROSS, &z), measure(&turned, CROSS, &carried(&z)));
    assert!(before < 0.03, "{before}");
    assert!((before - after).abs() < 1e-5, "{before} {after}");
    // Solved anew, too.
    let again = solve_cpu(&graph, &turned, &f, CROSS, &default()).phasors;
    let again = measure(&turned, CROSS, &again);
    assert!(again < 1.2 * before, "{before} {again}");
    // Two waves that are not linked do not survive it.
    let lines = orthogonal(Symmetry::Line, 1.0);
    let apart = solve_cpu(&graph, &turned, &f, lines, &default()).phasors;
    let apart = measure(&turned, lines, &apart);
    assert!(apart > 1.2 * before, "{before} {apart}");
}

#[test]
fn quarter_turns_are_reciprocal() {
    let unit = |k: u32| Vec3::new(hash_turns(k) - 0.5, hash_turns(k + 1) - 0.5, hash_turns(k + 2) - 0.5).normalize();
    for k in 0..1000 {
        let frame = |k: u32| {
            let (n, v) = (unit(6 * k), unit(6 * k + 3));
            bevy_field_patterns::wave::frame(v.reject_from(n).normalize(), n)
        };
        let (i, j) = (frame(2 * k), frame(2 * k + 1));
        for coupling in [CROSS, orthogonal(Symmetry::Line, 1.0), Symmetry::Line.into()] {
            let (there, back) = (coupling.quarter_turns(j, i), coupling.quarter_turns(i, j));
            assert_eq!((there + back) % 4, 0, "{coupling:?}");
        }
    }
}

fn shape(uv: Vec2) -> Vec2 {
    uv - Vec2::splat(0.5)
}

/// Textures that half turns or quarter turns leave alone look the same from both sides of every edge.
#[test]
fn textures_of_the_right_symmetry_have_no_seams() {
    let (graph, d) = cube_field();
    let f = vec![6.0; graph.len()];

    // Half turns leave the first alone, quarter turns the second; the third has no symmetry.
    let half = |uv: Vec2| (shape(uv).x * 5.0).cos() + shape(uv).x * shape(uv).y;
    let quarter = |uv: Vec2| (shape(uv).x * 5.0).cos() + (shape(uv).y * 5.0).cos();
    let none = |uv: Vec2| shape(uv).x;
    type Texture = dyn Fn(Vec2) -> f32;
    let jump = |coupling: Coupling, d: &[Vec3], texture: &Texture| {
        let z = solve_cpu(&graph, d, &f, coupling, &default()).phasors;
        let corners = |triangle: [u32; 3]| -> PairCorners {
            let v = triangle.map(|v| v as usize);
            [0, 1].map(|r| Corners {
                position: v.map(|v| graph.positions[v]),
                direction: v.map(|v| if r == 0 { d[v] } else { graph.normals[v].cross(d[v]) }),
                frequency: Vec3::from_array(v.map(|v| f[v])),
                z: v.map(|v| z[2 * v + r]),
            })
        };
        let mut sides = std::collections::HashMap::<(u32, u32), Vec<([u32; 3], usize)>>::new();
        for &triangle in &graph.triangles {
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                sides.entry((a.min(b), a.max(b))).or_default().push((triangle, k));
            }
        }
        let (mut worst, mut odd) = (0.0_f32, 0);
        for ((low, _), sides) in sides {
            let [one, other] = sides[..] else { continue };
            for along in [0.15_f32, 0.4, 0.8] {
                let look = |(triangle, k): ([u32; 3], usize)| {
                    let t = if triangle[k] == low { along } else { 1.0 - along };
                    let mut b = Vec3::ZERO;
                    b[k] = 1.0 - t;
                    b[(k + 1) % 3] = t;
                    let pieces = pair_in_triangle(&corners(triangle), coupling, b);
                    let sure = pieces
                        .iter()
                        .filter(|piece| piece.weight > 1e-3)
                        .all(|piece| piece.waves.iter().all(|wave| wave.confidence > 0.2));
                    // The texture is continuous inside a tile only.
                    let uv = pieces.iter().max_by(|a, b| a.weight.total_cmp(&b.weight)).unwrap().uv();
                    let inside = shape(uv).abs().max_element() < 0.49;
                    let value: f32 = pieces.iter().map(|piece| piece.weight * texture(piece.uv())).sum();
                    (sure && inside, value, pieces.len() > 1)
                };
                let (a, b) = (look(one), look(other));
                if a.0 && b.0 {
                    worst = worst.max((a.1 - b.1).abs());
                    odd += usize::from(a.2 || b.2);
                }
            }
        }
        (worst, odd)
    };
    let turned: Vec<Vec3> = (0..graph.len())
        .map(|v| turn(d[v], graph.normals[v], [Vec2::X; 2], v * 7 % 4).0)
        .collect();
    let lines = orthogonal(Symmetry::Line, 1.0);
    assert!(jump(lines, &d, &half).0 < 1e-3);
    assert!(jump(lines, &d, &none).0 > 0.1, "the test can fail");
    let (worst, odd) = jump(CROSS, &turned, &quarter);
    assert!(worst < 1e-3 && odd > 0, "{worst} {odd}");
    assert!(jump(CROSS, &turned, &half).0 > 0.1, "the test can fail");
}

/// With vector symmetry an arrow drawn along u points with the field, not against it, wherever the wave is sure.
#[test]
fn arrows_point_with_a_vector_field() {
    let raw = shapes::torus(60, 30, 1.0, 0.4, 0.25, 6);
    let graph = graph_of(&raw);
    let mesh = common::mesh_file::to_bevy_mesh(&raw);
    let axis = DirectionField::Axis(Dir3::Y);
    let d = directions(&axis, Symmetry::Vector, 0.0, &graph, &mesh).unwrap();
    let f = vec![6.0; graph.len()];
    let coupling = orthogonal(Symmetry::Vector, 1.0);
    let z = solve_cpu(&graph, &d, &f, coupling, &default()).phasors;
    // A stripe begins or ends here.
    let winds = |v: [usize; 3], r: usize, z: &[Vec2]| {
        let turns: f32 = (0..3)
            .map(|c| {
                let (i, j) = (v[(c + 1) % 3], v[c]);
                let direction = |v: usize| if r == 0 { d[v] } else { graph.normals[v].cross(d[v]) };
                let step = graph.positions[i] - graph.positions[j];
                let asked = 6.0 * kite::aligned_distance(step, direction(j), direction(i));
                let found = (z[2 * i + r].to_angle() - z[2 * j + r].to_angle()) / std::f32::consts::TAU;
                asked + (found - asked) - (found - asked).round()
            })
            .sum();
        turns.round() != 0.0
    };
    let against = |z: &[Vec2]| {
        let (mut sure, mut against) = (0, 0);
        for &triangle in &graph.triangles {
            let v = triangle.map(|v| v as usize);
            // Nor where the field itself turns within a triangle, as it does where the axis is normal to the surface.
            let straight = v.map(|v| d[v]).iter().sum::<Vec3>().length() > 2.7;
            if !straight || (0..2).any(|r| winds(v, r, z)) {
                continue;
            }
            let corners = [0, 1].map(|r| Corners {
                position: v.map(|v| graph.positions[v]),
                direction: v.map(|v| if r == 0 { d[v] } else { graph.normals[v].cross(d[v]) }),
                frequency: Vec3::splat(6.0),
                z: v.map(|v| z[2 * v + r]),
            });
            for wave in pair_in_triangle(&corners, coupling, Vec3::splat(1.0 / 3.0))[0].waves {
                sure += usize::from(wave.confidence > 0.8);
                against += usize::from(wave.confidence > 0.8 && wave.gradient.dot(wave.direction) <= 0.0);
            }
        }
        (sure, against)
    };
    let (sure, wrong) = against(&z);
    assert!(sure > graph.triangles.len() && wrong == 0, "{wrong} of {sure}");
    // Phases that run backwards are found.
    let backwards: Vec<Vec2> = z.iter().map(|&z| reversed(z)).collect();
    assert!(against(&backwards).1 > 0 || against(&backwards).0 < sure / 4);
}

/// Bent surfaces without curvature: what is right is known in closed form.
#[test]
fn texture_coordinates_are_exact_on_planes_and_cylinders() {
    // Along a cylinder of 64 sides the arc becomes a chord.
    let (sides, rings) = (64, 24);
    let cylinder = |k: u32| {
        let angle = (k % sides) as f32 / sides as f32 * std::f32::consts::TAU;
        Vec3::new(angle.cos(), 0.08 * (k / sides) as f32, angle.sin())
    };
    let at = |i: u32, j: u32| i * sides + j % sides;
    let quads = (0..rings - 1).flat_map(|i| (0..sides).map(move |j| (i, j)));
    let raw = RawMesh {
        positions: (0..sides * rings).map(cylinder).collect(),
        triangles: quads
            .flat_map(|(i, j)| {
                [
                    [at(i, j), at(i + 1, j), at(i, j + 1)],
                    [at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)],
                ]
            })
            .collect(),
    };
    let graph = graph_of(&raw);
    let d: Vec<Vec3> = graph
        .normals
        .iter()
        .map(|n| Vec3::Y.reject_from(*n).normalize())
        .collect();
    // 12 tiles around, on a perimeter of 64 chords.
    let perimeter = sides as f32 * 2.0 * (std::f32::consts::PI / sides as f32).sin();
    let ratio = 0.5;
    let f = vec![12.0 / perimeter / ratio; graph.len()];
    let z = solve_cpu(&graph, &d, &f, orthogonal(Symmetry::Vector, ratio), &default()).phasors;
    let phase = |v: usize, r: usize| z[2 * v + r].to_angle() / std::f32::consts::TAU;
    let off = |turns: f32| (turns - turns.round()).abs();
    let (mut along, mut around) = (0.0_f32, 0.0_f32);
    for v in 1..graph.len() {
        let (p, q) = (graph.positions[v], graph.positions[0]);
        along = along.max(off(phase(v, 0) - phase(0, 0) - f[0] * (p.y - q.y)));
        // n × d points against the angle from x to z.
        let arc = (p.z.atan2(p.x) - q.z.atan2(q.x)) / std::f32::consts::TAU;
        let off = off(phase(v, 1) - phase(0, 1) - 12.0 * arc).min(off(phase(v, 1) - phase(0, 1) + 12.0 * arc));
        around = around.max(off);
    }
    assert!(along < 2e-3, "{along}");
    assert!(around < 0.02, "{around}");
}

#[test]
fn a_phasor_stays_with_its_direction() {
    let n = Vec3::Z;
    let (d, z) = turn(Vec3::X, n, [phasor(0.1), phasor(0.3)], 2);
    assert!(d.distance(Vec3::NEG_X) < 1e-6);
    assert!(z[0].distance(reversed(phasor(0.1))) < 1e-6 && z[1].distance(reversed(phasor(0.3))) < 1e-6);
}
