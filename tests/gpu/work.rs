//! What the device is asked to do in a frame, and what is told of it.

use crate::common::{self, add_mesh, app, app_with, graph, settle, shapes, update, wave};
use bevy::prelude::*;
use bevy_field_patterns::{
    prelude::*,
    wave::{
        SolverCounters, quality,
        solver::{ColdStart, LocalRule},
    },
};

#[test]
fn nonsense_settings_are_put_right() {
    let nonsense = SolverSettings {
        omega: f32::NAN,
        softness: f32::INFINITY,
        soft_sweeps: u32::MAX,
        plain_sweeps: u32::MAX,
        warm_sweeps: 0,
        warm_level_sweeps: u32::MAX,
        max_sweeps_per_frame: None,
        max_milliseconds: None,
        cold_start: ColdStart::Hierarchy { level_sweeps: u32::MAX },
    };
    let limit = SolverSettings::MAX_SWEEPS;
    let expected = SolverSettings {
        omega: SolverSettings::default().omega,
        softness: SolverSettings::default().softness,
        soft_sweeps: limit,
        plain_sweeps: limit,
        warm_sweeps: 1,
        warm_level_sweeps: limit,
        max_sweeps_per_frame: None,
        max_milliseconds: None,
        cold_start: ColdStart::Hierarchy { level_sweeps: limit },
    };
    assert_eq!(nonsense.valid(), expected);
    assert_eq!(expected.valid(), expected);
    let Err(PatternError::OutOfRange { what, .. }) = nonsense.check() else {
        panic!("{:?}", nonsense.check());
    };
    assert!(what.contains("sweeps"), "{what}");
    assert_eq!(expected.check(), Ok(()));
    let rule = |momentum, epsilon, max_sweeps| SolverSettings {
        cold_start: ColdStart::Local(LocalRule {
            momentum,
            epsilon,
            max_sweeps,
            skip_last_third: false,
        }),
        ..default()
    };
    assert_eq!(rule(f32::NAN, f32::NAN, u32::MAX).valid(), rule(0.2, 1e-3, limit));
    assert_eq!(rule(-1.0, -1.0, 0).valid(), rule(0.0, 0.0, 1));

    let mut app = app_with(SolverSettings {
        soft_sweeps: 20,
        ..nonsense
    });
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let spawn = (Mesh3d(mesh), DirectionField::Axis(Dir3::Y), Frequency::Uniform(2.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let is_good = |app: &App| {
        let (d, f, z) = wave(app, entity);
        let q = quality(&graph(app, entity), &d, &f, &z, Symmetry::Vector);
        z.iter().all(|z| z.is_finite()) && q.energy < 0.05
    };
    assert!(is_good(&app));
    assert_eq!(app.world().resource::<SolverCounters>().sweeps(), 20 + limit);
    // Settings may go wrong at any time.
    app.insert_resource(SolverSettings {
        omega: f32::NEG_INFINITY,
        warm_sweeps: u32::MAX,
        ..default()
    });
    app.world_mut().entity_mut(entity).insert(Frequency::Uniform(2.5));
    settle(&mut app);
    assert!(is_good(&app));
}

/// While a buffer is away, frames wait; then each is done after the one before it, as if none had waited.
#[test]
fn frames_that_had_to_wait_are_done_in_order() {
    use bevy::render::{RenderApp, render_asset::RenderAssets, storage::GpuShaderBuffer};
    use bevy_field_patterns::wave::layout::WAVE_BUFFER;
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let axis = |degrees: f32| DirectionField::Axis(Quat::from_rotation_z(degrees.to_radians()) * Dir3::Y);
    let spawn = (Mesh3d(mesh), axis(0.0), Symmetry::Line, Frequency::Uniform(3.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let (start, ..) = wave(&app, entity);
    fn buffers(app: &mut App) -> Mut<'_, RenderAssets<GpuShaderBuffer>> {
        app.sub_app_mut(RenderApp).world_mut().resource_mut()
    }
    let take = |app: &mut App| buffers(app).remove(&WAVE_BUFFER).expect("a buffer");
    let give_back = |app: &mut App, buffer| buffers(app).insert(&WAVE_BUFFER, buffer);

    let buffer = take(&mut app);
    for degrees in [60.0, 120.0, 180.0] {
        app.world_mut().entity_mut(entity).insert(axis(degrees));
        update(&mut app);
    }
    give_back(&mut app, buffer);
    settle(&mut app);
    let (turned, f, z) = wave(&app, entity);
    // A line that has been followed through half a turn has the other sign now, but where the axis is nearly normal.
    let reversed = turned
        .iter()
        .zip(&start)
        .filter(|(d, old)| d.dot(**old) < -0.99)
        .count();
    assert!(reversed > turned.len() / 2, "{reversed} of {}", turned.len());
    let q = quality(&graph(&app, entity), &turned, &f, &z, Symmetry::Line);
    assert!(q.energy < 0.05, "{q:?}");

    // If it takes too long, what has waited is given up and everything begins anew.
    let buffer = take(&mut app);
    for frame in 0..400 {
        app.world_mut().entity_mut(entity).insert(axis(frame as f32));
        update(&mut app);
    }
    give_back(&mut app, buffer);
    app.world_mut().entity_mut(entity).insert(axis(30.0));
    update(&mut app);
    settle(&mut app);
    let graph = graph(&app, entity);
    let (d, f, z) = wave(&app, entity);
    let twin = Quat::from_rotation_z(30.0_f32.to_radians()) * Vec3::Y;
    let along = |(d, &n): (&Vec3, &Vec3)| d.dot(bevy_field_patterns::field::project_tangent(twin, n)).abs() > 0.999;
    assert!(d.iter().zip(&graph.normals).all(along));
    let q = quality(&graph, &d, &f, &z, Symmetry::Line);
    assert!(q.energy < 0.05, "{q:?}");
}

#[test]
fn sleeps_when_nothing_changes_and_wakes_when_something_does() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let spawn = (Mesh3d(mesh), DirectionField::Axis(Dir3::Y), Frequency::Uniform(3.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let dispatches = |app: &App| app.world().resource::<SolverCounters>().dispatches();
    assert!(dispatches(&app) > 0);
    for _ in 0..3 {
        update(&mut app);
        assert_eq!(dispatches(&app), 0);
    }
    app.world_mut().entity_mut(entity).insert(Frequency::Uniform(3.1));
    update(&mut app);
    assert!(dispatches(&app) > 0);
    assert_eq!(
        app.world().resource::<SolverCounters>().sweeps(),
        SolverSettings::default().warm_sweeps
    );
    assert_eq!(app.world().get::<PatternState>(entity), Some(&PatternState::Solving));
    settle(&mut app);
    update(&mut app);
    assert_eq!(dispatches(&app), 0);
    // Writing the same value again is a change; that the material or the transform changes is none.
    app.world_mut()
        .entity_mut(entity)
        .insert(Transform::from_xyz(1.0, 2.0, 3.0));
    update(&mut app);
    assert_eq!(dispatches(&app), 0);
}

#[test]
fn dispatches_do_not_grow_with_entities() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let axis = |app: &mut App, frame: u32| {
        let mut fields = app.world_mut().query::<&mut DirectionField>();
        for (n, mut field) in fields.iter_mut(app.world_mut()).enumerate() {
            let angle = 0.02 * frame as f32 + n as f32;
            *field = DirectionField::Axis(Quat::from_rotation_z(angle) * Dir3::Y);
        }
    };
    let spawn = |app: &mut App| {
        let mesh = Mesh3d(mesh.clone());
        app.world_mut()
            .spawn((mesh, DirectionField::Axis(Dir3::Y), Frequency::Uniform(2.0)));
    };
    let frame = |app: &mut App| {
        settle(app);
        // An axis that leaps is solved from nothing.
        axis(app, 0);
        settle(app);
        axis(app, 1);
        update(app);
        app.world().resource::<SolverCounters>().dispatches()
    };
    spawn(&mut app);
    let one = frame(&mut app);
    (1..300).for_each(|_| spawn(&mut app));
    let many = frame(&mut app);
    assert!(one > 0);
    assert_eq!(one, many);
}

#[test]
fn diagnostics_tell_energy_and_branches() {
    use bevy::{
        diagnostic::DiagnosticsStore,
        render::{RenderApp, diagnostic::RenderDiagnosticsPlugin, renderer::RenderDevice, settings::WgpuFeatures},
    };
    use bevy_field_patterns::diagnostics::{BRANCHES, ENERGY, MEMORY, SWEEPS};
    let mut app = common::headless::headless_app(UVec2::splat(16)).unwrap();
    app.add_plugins((FieldPatternsPlugin, RenderDiagnosticsPlugin));
    common::headless::wait_until_ready(&mut app).unwrap();
    let mesh = add_mesh(&mut app, &shapes::torus(70, 36, 1.0, 0.4, 0.25, 5));
    let spawn = (Mesh3d(mesh), DirectionField::Axis(Dir3::Y), Frequency::Uniform(8.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    assert_eq!(
        app.world().resource::<SolverCounters>().sweeps(),
        14,
        "the frame that solves"
    );
    // Values arrive a few frames late, while the pattern sleeps.
    for _ in 0..8 {
        update(&mut app);
        common::gpu::wait(&app);
    }
    let (d, f, z) = wave(&app, entity);
    let q = quality(&graph(&app, entity), &d, &f, &z, Symmetry::Vector);
    let (energy, branches, sweeps, memory) = (ENERGY, BRANCHES, SWEEPS, MEMORY);
    let value = |path| {
        app.world()
            .resource::<DiagnosticsStore>()
            .get(path)
            .and_then(|d| d.value())
    };
    assert_eq!(value(&sweeps), Some(0.0));
    assert!(value(&memory).is_some_and(|bytes| bytes > 0.0));
    let device = app.sub_app(RenderApp).world().resource::<RenderDevice>();
    if !device.features().contains(WgpuFeatures::TIMESTAMP_QUERY) {
        assert_eq!(value(&energy), None);
        return;
    }
    let reported = value(&energy).expect("an energy");
    assert!((reported - q.energy).abs() < 1e-3 * q.energy, "{reported} {q:?}");
    assert!(
        (value(&branches).expect("branches") - q.branches as f64).abs() < 0.5,
        "{q:?}"
    );
}
