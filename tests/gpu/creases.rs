//! Crests on sharp features, on the device and by the twin.

use crate::common::{add_mesh, app, app_with, graph, mesh_file::RawMesh, settle, update, wave};
use bevy::prelude::*;
use bevy_field_patterns::{
    prelude::*,
    surface::SurfaceGraph,
    wave::{
        Coupling, SolverCounters,
        solver::{ColdStart, Pins, solve_pinned},
    },
};
use std::f32::consts::{FRAC_PI_2, TAU};

/// An open tube about the y axis from 0 to 2, and a floor of the same radius: folded at y = 0, with a border at y = 2.
fn beaker() -> RawMesh {
    let (around, rings, floor) = (48_u32, 40_u32, 10_u32);
    let ring = |radius: f32, y: f32| {
        (0..around).map(move |i| {
            let turn = radius * Vec2::from_angle(TAU * (i as f32 + 0.3 * (7.0 * y).sin()) / around as f32);
            Vec3::new(turn.x, y, turn.y)
        })
    };
    let mut positions = vec![Vec3::ZERO];
    positions.extend((1..floor).flat_map(|n| ring(n as f32 / floor as f32, 0.0)));
    positions.extend((0..=rings).flat_map(|n| ring(1.0, 2.0 * n as f32 / rings as f32)));
    let at = |n: u32, i: u32| 1 + n * around + i % around;
    let centre = (0..around).map(|i| [0, at(0, i), at(0, i + 1)]);
    let quads = (0..floor - 1 + rings).flat_map(|n| (0..around).map(move |i| (n, i)));
    let triangles = quads.flat_map(|(n, i)| {
        [
            [at(n, i), at(n + 1, i), at(n + 1, i + 1)],
            [at(n, i), at(n + 1, i + 1), at(n, i + 1)],
        ]
    });
    RawMesh {
        triangles: centre.chain(triangles).collect(),
        positions,
    }
}

/// Outwards on the floor, upwards on the side: stripes run along the fold.
fn outwards(raw: &RawMesh) -> DirectionField {
    let direction = |p: &Vec3| {
        let on_side = p.with_y(0.0).length() > 0.999;
        if on_side && p.y > 0.0 {
            Vec3::Y
        } else {
            p.with_y(0.0) + f32::from(on_side) * Vec3::Y
        }
    };
    DirectionField::Vertices(raw.positions.iter().map(direction).collect())
}

/// Share of the vertices for which the phase is within 0.1 periods of a crest.
fn on_crest(z: &[Vec2], waves: usize, counts: &[bool]) -> f32 {
    let near = |v: usize| {
        let off = z[waves * v].to_angle() - FRAC_PI_2;
        (off - TAU * (off / TAU).round()).abs() < 0.1 * TAU
    };
    let counted: Vec<usize> = (0..counts.len()).filter(|&v| counts[v]).collect();
    counted.iter().filter(|&&v| near(v)).count() as f32 / counted.len() as f32
}

#[test]
fn crests_lie_on_creases_as_the_twin_puts_them() {
    let raw = beaker();
    for waves in [Waves::Single, Waves::ORTHOGONAL, Waves::Cross] {
        let settings = SolverSettings {
            cold_start: ColdStart::Hierarchy { level_sweeps: 2 },
            soft_sweeps: 3,
            plain_sweeps: 2,
            ..default()
        };
        let mut app = app_with(settings.clone());
        let mesh = add_mesh(&mut app, &raw);
        let pull = CreasePhase {
            boundary: true,
            ..default()
        };
        let pattern = (Mesh3d(mesh), outwards(&raw), waves, Frequency::Uniform(3.3), pull);
        let entity = app.world_mut().spawn(pattern).id();
        settle(&mut app);
        let graph = graph(&app, entity);
        let (d, f, z) = wave(&app, entity);
        let coupling = Coupling {
            waves,
            symmetry: Symmetry::Line,
        };
        let twin = |pull: f32| {
            let pins = Pins {
                vertices: &graph.creases(35_f32.to_radians(), true),
                pull,
            };
            solve_pinned(&graph, &d, &f, coupling, pins, &settings).phasors
        };
        let distance = |a: &[Vec2], b: &[Vec2]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(
            distance(&z, &twin(3.0)) < 2e-3,
            "{waves:?}: {}",
            distance(&z, &twin(3.0))
        );
        // The comparison can fail: another weight shows, and so does a trough.
        assert!(distance(&z, &twin(1.0)) > 2e-2 && distance(&z, &twin(-2.0)) > 0.5);
    }
}

#[test]
fn creases_pull_harder_with_more_weight_and_both_ways() {
    let raw = beaker();
    let mut app = app();
    let mesh = add_mesh(&mut app, &raw);
    let entity = app
        .world_mut()
        .spawn((Mesh3d(mesh), outwards(&raw), Frequency::Uniform(3.3)))
        .id();
    settle(&mut app);
    let pinned = graph(&app, entity).creases(35_f32.to_radians(), true);
    assert_eq!(pinned.iter().filter(|&&pinned| pinned).count(), 2 * 48);
    let crest = |app: &App| on_crest(&wave(app, entity).2, 1, &pinned);
    let free = crest(&app);
    assert!(
        free < 0.9,
        "fold and border are no whole number of stripes apart: {free}"
    );
    let sleeps = |app: &mut App| {
        for _ in 0..3 {
            update(app);
            assert_eq!(app.world().resource::<SolverCounters>().dispatches(), 0);
        }
    };
    let set = |app: &mut App, phase, weight| {
        let pull = CreasePhase {
            boundary: true,
            phase,
            weight,
            ..default()
        };
        app.world_mut().entity_mut(entity).insert(pull);
        settle(app);
        sleeps(app);
        crest(app)
    };
    assert!(set(&mut app, CreaseLine::Crest, 2.0) > 0.95);
    assert!(set(&mut app, CreaseLine::Trough, 2.0) < 0.05);
    assert!(set(&mut app, CreaseLine::Crest, 2.0) > 0.95);
    // Without the pull, the wave goes back to what the field asks for.
    app.world_mut().entity_mut(entity).remove::<CreasePhase>();
    settle(&mut app);
    app.world_mut().trigger(RestartPattern { entity });
    settle(&mut app);
    sleeps(&mut app);
    assert!(crest(&app) < 0.9);

    for (angle, weight) in [
        (f32::NAN, 1.0),
        (-0.1, 1.0),
        (4.0, 1.0),
        (1.0, -1.0),
        (1.0, f32::INFINITY),
    ] {
        let wrong = CreasePhase {
            angle,
            weight,
            ..default()
        };
        app.world_mut().entity_mut(entity).insert(wrong);
        update(&mut app);
        let state = app.world().get::<PatternState>(entity);
        assert!(
            matches!(state, Some(PatternState::Failed(PatternError::OutOfRange { .. }))),
            "{angle}, {weight}: {state:?}"
        );
    }
    app.world_mut().entity_mut(entity).remove::<CreasePhase>();
    settle(&mut app);
    assert_eq!(app.world().get::<PatternState>(entity), Some(&PatternState::Converged));
}

/// More weight moves more vertices to the crest, and costs energy.
#[test]
fn weight_is_paid_with_energy() {
    let raw = beaker();
    let graph = SurfaceGraph::from_triangles(&raw.positions, &raw.triangles, &default()).unwrap();
    let mesh = crate::common::mesh_file::to_bevy_mesh(&raw);
    let d = bevy_field_patterns::field::directions(&outwards(&raw), Symmetry::Line, 0.0, &graph, &mesh).unwrap();
    let f = vec![3.3; graph.len()];
    let pinned = graph.creases(35_f32.to_radians(), true);
    let solved = |weight: f32| {
        let pins = Pins {
            vertices: &pinned,
            pull: weight,
        };
        let z = solve_pinned(&graph, &d, &f, Symmetry::Line, pins, &default()).phasors;
        let energy = bevy_field_patterns::wave::quality(&graph, &d, &f, &z, Symmetry::Line).energy;
        (on_crest(&z, 1, &pinned), energy)
    };
    let (free, half, two) = (solved(0.0), solved(0.5), solved(2.0));
    assert!(
        free.0 <= half.0 && half.0 <= two.0 && free.0 < two.0,
        "{free:?} {half:?} {two:?}"
    );
    assert!(free.1 < half.1 && half.1 < two.1, "{free:?} {half:?} {two:?}");
}
