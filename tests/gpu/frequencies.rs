//! Every source of frequencies against its formula, and that nothing is evaluated while nothing changes.

use crate::common::{add_mesh, app, graph, settle, shapes, update, wave};
use bevy::prelude::*;
use bevy_field_patterns::{
    field::{DistanceRamp, PixelSize, ScalarRamp, distance_frequency, scalar_frequency, screen_frequency},
    prelude::*,
    wave::SolverCounters,
};

fn place() -> Transform {
    Transform::from_xyz(1.0, -2.0, 0.5)
        .with_rotation(Quat::from_euler(EulerRot::XYZ, 0.3, 0.8, -0.4))
        .with_scale(Vec3::splat(2.0))
}

fn spawn(app: &mut App, bundle: impl Bundle) -> Entity {
    let mesh = add_mesh(app, &shapes::icosphere(4, 1.0));
    app.world_mut()
        .spawn((Mesh3d(mesh), DirectionField::Axis(Dir3::Y), place(), bundle))
        .id()
}

fn dispatches(app: &App) -> u32 {
    app.world().resource::<SolverCounters>().dispatches()
}

/// The largest relative difference between the frequencies of an entity and `f` at positions in the world.
fn difference(app: &App, entity: Entity, f: impl Fn(Vec3) -> f32) -> f32 {
    let (graph, (_, found, _)) = (graph(app, entity), wave(app, entity));
    let affine = place().compute_affine();
    let difference = |(&found, &p): (&f32, &Vec3)| (found / f(affine.transform_point3(p)) - 1.0).abs();
    let differences: Vec<f32> = found.iter().zip(&graph.positions).map(difference).collect();
    assert!(differences.iter().all(|d| d.is_finite()));
    differences.into_iter().fold(0.0, f32::max)
}

#[test]
fn distance_makes_frequencies_when_the_entity_moves_and_only_then() {
    for space in [PatternSpace::Mesh, PatternSpace::World] {
        let mut app = app();
        let at = |x: f32| Transform::from_xyz(x, -1.0, 1.0).with_rotation(Quat::from_rotation_z(1.0));
        let tool = app.world_mut().spawn(at(2.0)).id();
        let segment = Vec3::new(0.0, 1.5, 0.0);
        let frequency = |far| Frequency::DistanceTo {
            entity: tool,
            segment,
            near: 0.3,
            far,
            near_frequency: 6.0,
            far_frequency: 2.0,
        };
        let entity = spawn(&mut app, (frequency(1.1), space));
        settle(&mut app);
        // Distances have the unit of the pattern's space.
        let unit = if space == PatternSpace::Mesh { 2.0 } else { 1.0 };
        let formula = |x: f32| {
            let ramp = DistanceRamp {
                segment: [at(x).translation, at(x).transform_point(segment)],
                near: 0.3 * unit,
                far: 1.1 * unit,
                frequencies: [6.0, 2.0],
            };
            move |p: Vec3| distance_frequency(p, &ramp)
        };
        assert!(difference(&app, entity, formula(2.0)) < 1e-4);
        assert!(difference(&app, entity, formula(1.5)) > 0.1, "the comparison can fail");
        for _ in 0..3 {
            update(&mut app);
            assert_eq!(dispatches(&app), 0);
        }
        let (before, ..) = wave(&app, entity);
        app.world_mut().entity_mut(tool).insert(at(1.5));
        update(&mut app);
        assert!(dispatches(&app) > 0);
        assert!(difference(&app, entity, formula(1.5)) < 1e-4);
        assert_eq!(before, wave(&app, entity).0, "directions are left alone");
        settle(&mut app);
        update(&mut app);
        assert_eq!(dispatches(&app), 0);
        // What cannot be is an error, and mended by what can.
        let state = |app: &App| app.world().get::<PatternState>(entity).unwrap().clone();
        app.world_mut().entity_mut(entity).insert(frequency(0.2));
        update(&mut app);
        assert!(matches!(
            state(&app),
            PatternState::Failed(PatternError::OutOfRange { .. })
        ));
        app.world_mut().entity_mut(entity).insert(frequency(1.1));
        settle(&mut app);
        assert!(difference(&app, entity, formula(1.5)) < 1e-4);
        app.world_mut().despawn(tool);
        update(&mut app);
        assert!(matches!(
            state(&app),
            PatternState::Failed(PatternError::MissingEntity { .. })
        ));
    }
}

#[test]
fn the_screen_makes_frequencies_with_hysteresis() {
    for space in [PatternSpace::Mesh, PatternSpace::World] {
        let mut app = app();
        let from = |distance: f32| {
            Transform::from_translation(place().translation + distance * Vec3::new(0.6, 0.0, 0.8))
                .looking_at(place().translation, Vec3::Y)
        };
        let (fov, height) = (0.8_f32, 16.0);
        let projection = Projection::Perspective(PerspectiveProjection { fov, ..default() });
        let camera = app.world_mut().spawn((Camera3d::default(), projection, from(6.0))).id();
        let frequency = Frequency::Screen {
            camera,
            pixels: 2.0,
            hysteresis: 0.2,
        };
        let entity = spawn(&mut app, (frequency, space));
        update(&mut app);
        settle(&mut app);
        let unit = if space == PatternSpace::Mesh { 2.0 } else { 1.0 };
        let formula = |distance: f32| {
            let camera = from(distance);
            move |p: Vec3| {
                let depth = (p - camera.translation).dot(*camera.forward());
                let pixel = 2.0 * depth * (0.5 * fov).tan() / height / unit;
                let size = PixelSize {
                    plane: Vec4::W * pixel,
                    least: 0.0,
                };
                screen_frequency(p, &size, 2.0)
            }
        };
        assert!(difference(&app, entity, formula(6.0)) < 1e-3);
        assert!(difference(&app, entity, formula(5.0)) > 0.1, "the comparison can fail");
        // A small move changes nothing.
        update(&mut app);
        app.world_mut().entity_mut(camera).insert(from(5.7));
        for _ in 0..3 {
            update(&mut app);
            assert_eq!(dispatches(&app), 0);
        }
        // A large one is followed, bit by bit, up to the end.
        app.world_mut().entity_mut(camera).insert(from(4.0));
        update(&mut app);
        assert!(dispatches(&app) > 0);
        let first = difference(&app, entity, formula(4.0));
        assert!(first > 0.1, "{first}");
        let mut frames = 0;
        while dispatches(&app) > 0 {
            update(&mut app);
            frames += 1;
            assert!(frames < 100);
        }
        assert!(difference(&app, entity, formula(4.0)) < 5e-3);
        app.world_mut().despawn(camera);
        update(&mut app);
        let state = app.world().get::<PatternState>(entity).unwrap();
        assert!(
            matches!(state, PatternState::Failed(PatternError::MissingEntity { .. })),
            "{state:?}"
        );
    }
}

#[test]
fn scalars_make_frequencies() {
    let mut app = app();
    let raw = shapes::icosphere(4, 1.0);
    let scalars = |factor: f32| PatternScalars {
        second: ScalarSource::Vertices(raw.positions.iter().map(|p| factor * p.z).collect()),
        ..default()
    };
    let frequency = Frequency::Eigenvalue {
        eigenvalue: Eigenvector::Medium,
        low: -0.5,
        high: 0.8,
        low_frequency: 2.0,
        high_frequency: 5.0,
    };
    let entity = spawn(&mut app, frequency);
    settle(&mut app);
    let state = app.world().get::<PatternState>(entity);
    assert!(
        matches!(state, Some(PatternState::Failed(PatternError::NoScalars(_)))),
        "{state:?}"
    );
    let ramp = ScalarRamp {
        values: [-0.5, 0.8],
        frequencies: [2.0, 5.0],
    };
    for factor in [1.0, -1.0] {
        app.world_mut().entity_mut(entity).insert(scalars(factor));
        settle(&mut app);
        let mesh_from_world = place().compute_affine().inverse();
        let formula = |factor: f32| move |p| scalar_frequency(factor * mesh_from_world.transform_point3(p).z, &ramp);
        assert!(difference(&app, entity, formula(factor)) < 1e-4);
        assert!(
            difference(&app, entity, formula(-factor)) > 0.5,
            "the comparison can fail"
        );
        update(&mut app);
        assert_eq!(dispatches(&app), 0);
    }
}

/// Directions and frequencies are evaluated each for itself.
#[test]
fn a_change_of_one_source_leaves_the_other_alone() {
    let mut app = app();
    let raw = shapes::icosphere(4, 1.0);
    let given = |shift: f32| Frequency::Vertices(raw.positions.iter().map(|p| 4.0 + shift * p.x).collect());
    let entity = spawn(&mut app, given(1.0));
    settle(&mut app);
    assert!(
        difference(&app, entity, |p| 4.0
            + place().compute_affine().inverse().transform_point3(p).x)
            < 1e-5
    );
    let mut change = |bundle: (Option<DirectionField>, Option<Frequency>)| {
        let mut entity = app.world_mut().entity_mut(entity);
        if let Some(field) = bundle.0 {
            entity.insert(field);
        }
        if let Some(frequency) = bundle.1 {
            entity.insert(frequency);
        }
        update(&mut app);
        let count = dispatches(&app);
        settle(&mut app);
        count
    };
    let axis = |x: f32| DirectionField::Axis(Dir3::new(Vec3::new(x, 1.0, 0.0)).unwrap());
    let one = change((Some(axis(0.1)), None));
    assert_eq!(change((None, Some(given(0.5)))), one);
    assert_eq!(change((Some(axis(0.2)), Some(given(0.7)))), one + 1);
}
