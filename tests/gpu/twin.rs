//! Every pass of the solver against its twin on the CPU.

use crate::{
    common::{add_mesh, app, app_with, graph, settle, shapes, update, wave},
    curvature,
};
use bevy::prelude::*;
use bevy_field_patterns::{
    prelude::*,
    wave::{
        Coupling, quality,
        solver::{ColdStart, LocalRule, follow_cpu, solve_cpu},
    },
};

/// The largest distance between the phasors of the device and those of the twin, on the same directions.
fn distance_to_twin(gpu: &SolverSettings, cpu: &SolverSettings, coupling: Coupling) -> f32 {
    let mut app = app_with(gpu.clone());
    let mesh = add_mesh(&mut app, &shapes::torus(70, 36, 1.0, 0.4, 0.25, 5));
    let entity = app
        .world_mut()
        .spawn((
            Mesh3d(mesh),
            curvature(),
            coupling.symmetry,
            coupling.waves,
            Frequency::Uniform(6.0),
        ))
        .id();
    settle(&mut app);
    let (d, f, z) = wave(&app, entity);
    let twin = solve_cpu(&graph(&app, entity), &d, &f, coupling, cpu).phasors;
    assert_eq!(z.len(), twin.len());
    z.iter().zip(&twin).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn every_pass_agrees_with_its_twin() {
    let hierarchy = |level_sweeps| ColdStart::Hierarchy { level_sweeps };
    let none = SolverSettings {
        cold_start: hierarchy(0),
        soft_sweeps: 0,
        plain_sweeps: 0,
        ..default()
    };
    let local = LocalRule {
        max_sweeps: 3,
        epsilon: 0.0,
        ..default()
    };
    let cases = [
        ("edges, alignment, coarsening, rotation", none.clone()),
        (
            "sweeps on the levels",
            SolverSettings {
                cold_start: hierarchy(2),
                ..none.clone()
            },
        ),
        (
            "soft sweeps",
            SolverSettings {
                soft_sweeps: 2,
                ..none.clone()
            },
        ),
        (
            "plain sweeps",
            SolverSettings {
                plain_sweeps: 2,
                ..none.clone()
            },
        ),
        (
            "local rule",
            SolverSettings {
                cold_start: ColdStart::Local(local),
                ..none.clone()
            },
        ),
    ];
    let coupling = |waves, symmetry| Coupling { waves, symmetry };
    let couplings = [
        coupling(Waves::Single, Symmetry::Line),
        coupling(Waves::Single, Symmetry::Vector),
        coupling(Waves::Orthogonal { ratio: 1.5 }, Symmetry::Line),
        coupling(Waves::Cross, Symmetry::Line),
    ];
    for coupling in couplings {
        for (name, settings) in &cases {
            let distance = distance_to_twin(settings, settings, coupling);
            assert!(distance < 2e-3, "{name}, {coupling:?}: {distance}");
        }
    }
    // The comparison can fail: one sweep more shows.
    let more = SolverSettings {
        plain_sweeps: 3,
        ..none.clone()
    };
    let distance = distance_to_twin(&cases[3].1, &more, couplings[0]);
    assert!(distance > 2e-2, "{distance}");
}

/// A cross field that any of its four arms stands for, and the waves that are linked by quarter turns.
#[test]
fn crosses_are_smoothed_and_solved_as_by_the_twin() {
    let settings = SolverSettings {
        soft_sweeps: 2,
        plain_sweeps: 0,
        ..default()
    };
    let mut app = app_with(settings.clone());
    let mesh = add_mesh(&mut app, &shapes::torus(70, 36, 1.0, 0.4, 0.25, 5));
    let field = SmoothField {
        ring: FieldRing::Four,
        ..default()
    };
    let spawn = (
        Mesh3d(mesh),
        DirectionField::Smooth(field),
        Waves::Cross,
        Frequency::Uniform(4.0),
    );
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let (d, f, z) = wave(&app, entity);
    let graph = graph(&app, entity);
    let distance = |waves, soft_sweeps| {
        let coupling = Coupling {
            waves,
            symmetry: Symmetry::Line,
        };
        let settings = SolverSettings {
            soft_sweeps,
            ..settings.clone()
        };
        let twin = solve_cpu(&graph, &d, &f, coupling, &settings).phasors;
        let mut off: Vec<f32> = z.iter().zip(&twin).map(|(a, b)| a.distance(*b)).collect();
        off.sort_unstable_by(f32::total_cmp);
        off[off.len() * 99 / 100]
    };
    // Arms that fit equally well may be taken either way.
    assert!(distance(Waves::Cross, 2) < 2e-3, "{}", distance(Waves::Cross, 2));
    assert!(distance(Waves::Cross, 3) > 2e-2);
    assert!(distance(Waves::ORTHOGONAL, 2) > 0.1);
}

#[test]
fn axis_is_projected_on_the_device_as_by_the_twin() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let axis = Dir3::new(Vec3::new(0.2, 1.0, -0.3)).unwrap();
    let spawn = (
        Mesh3d(mesh),
        DirectionField::Axis(axis),
        FieldTurn(0.4),
        Frequency::Uniform(3.0),
    );
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let graph = graph(&app, entity);
    let (d, f, _) = wave(&app, entity);
    assert!(f.iter().all(|&f| f == 3.0));
    for (d, &n) in d.iter().zip(&graph.normals) {
        let twin =
            bevy_field_patterns::field::turn_tangent(bevy_field_patterns::field::project_tangent(*axis, n), n, 0.4);
        assert!(d.distance(twin) < 1e-5, "{d} {twin}");
    }
}

#[test]
fn world_space_counts_stripes_per_unit_of_the_world() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::torus(70, 36, 1.0, 0.4, 0.25, 5));
    let spawn = (
        Mesh3d(mesh),
        DirectionField::Axis(Dir3::Y),
        Frequency::Uniform(3.0),
        PatternSpace::World,
        Transform::from_scale(Vec3::new(2.0, 3.0, 2.0)),
    );
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let mut scaled = graph(&app, entity);
    scaled.positions.iter_mut().for_each(|p| *p *= Vec3::new(2.0, 3.0, 2.0));
    let (d, f, z) = wave(&app, entity);
    let in_world = quality(&scaled, &d, &f, &z, Symmetry::Vector);
    let in_mesh = quality(&graph(&app, entity), &d, &f, &z, Symmetry::Vector);
    assert!(
        in_world.energy < 0.05 && in_mesh.energy > 3.0 * in_world.energy,
        "{in_world:?} {in_mesh:?}"
    );
}

/// A change of the frequency, followed with and without a V-cycle, against the twin.
#[test]
fn v_cycle_agrees_with_its_twin() {
    for waves in [Waves::Single, Waves::ORTHOGONAL, Waves::Cross] {
        let settings = SolverSettings {
            warm_level_sweeps: 2,
            warm_sweeps: 1,
            ..default()
        };
        let mut app = app_with(settings.clone());
        let mesh = add_mesh(&mut app, &shapes::torus(70, 36, 1.0, 0.4, 0.25, 5));
        let entity = app
            .world_mut()
            .spawn((Mesh3d(mesh), curvature(), waves, Frequency::Uniform(6.0)))
            .id();
        settle(&mut app);
        let (_, _, before) = wave(&app, entity);
        app.world_mut().entity_mut(entity).insert(Frequency::Uniform(6.2));
        update(&mut app);
        let (d, f, z) = wave(&app, entity);
        assert!(f.iter().all(|&f| f == 6.2));
        let coupling = Coupling {
            waves,
            symmetry: Symmetry::Line,
        };
        let distance = |settings: &SolverSettings| {
            let mut twin = before.clone();
            follow_cpu(&graph(&app, entity), &d, &f, coupling, settings, &mut twin);
            z.iter().zip(&twin).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
        };
        assert!(distance(&settings) < 2e-3, "{waves:?}: {}", distance(&settings));
        // The comparison can fail: without the cycle it is another wave.
        let without = SolverSettings {
            warm_level_sweeps: 0,
            ..settings.clone()
        };
        assert!(distance(&without) > 2e-2, "{waves:?}: {}", distance(&without));
    }
}
