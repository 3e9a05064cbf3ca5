//! How work is spread over frames and patterns.

use crate::common::{add_mesh, app_with, gpu, graph, headless, settle, shapes, update, wave};
use bevy::{prelude::*, render::diagnostic::RenderDiagnosticsPlugin};
use bevy_field_patterns::{
    diagnostics::QualityReport,
    prelude::*,
    wave::{
        SolverCounters, quality,
        solver::{ColdStart, LocalRule},
    },
};

fn with_sweeps(max: u32) -> SolverSettings {
    SolverSettings {
        max_sweeps_per_frame: Some(max),
        ..default()
    }
}

fn spawn(app: &mut App, count: usize) -> Vec<Entity> {
    let mesh = add_mesh(app, &shapes::torus(60, 30, 1.0, 0.4, 0.25, 5));
    let pattern = |n: usize| {
        (
            Mesh3d(mesh.clone()),
            DirectionField::Axis(Dir3::Y),
            Symmetry::Line,
            Frequency::Uniform(3.0 + n as f32),
        )
    };
    (0..count).map(|n| app.world_mut().spawn(pattern(n)).id()).collect()
}

fn is_converged(app: &App, entity: Entity) -> bool {
    app.world().get::<PatternState>(entity) == Some(&PatternState::Converged)
}

/// Sweeps of the last frame, and how many patterns are drawn at rest.
fn last_frame(app: &App, entities: &[Entity]) -> (u32, usize) {
    let sweeps = app.world().resource::<SolverCounters>().pattern_sweeps();
    (
        sweeps,
        entities.iter().filter(|&&entity| is_converged(app, entity)).count(),
    )
}

fn energies(app: &App, entities: &[Entity]) -> Vec<f64> {
    let energy = |&entity: &Entity| {
        let (d, f, z) = wave(app, entity);
        quality(&graph(app, entity), &d, &f, &z, Symmetry::Line).energy
    };
    entities.iter().map(energy).collect()
}

fn sleeps(app: &mut App) {
    for _ in 0..3 {
        update(app);
        assert_eq!(app.world().resource::<SolverCounters>().dispatches(), 0);
    }
}

#[test]
fn cold_starts_are_spread_and_come_out_as_good() {
    let mut free = app_with(default());
    let together = spawn(&mut free, 5);
    settle(&mut free);
    assert_eq!(
        free.world().resource::<SolverCounters>().pattern_sweeps(),
        5 * 14,
        "without a budget all is done at once"
    );
    for max in [1, 5, 40] {
        let mut app = app_with(with_sweeps(max));
        let entities = spawn(&mut app, 5);
        let (mut most, mut total, mut frames) = (0, 0, 0);
        while last_frame(&app, &entities).1 < 5 {
            update(&mut app);
            let (sweeps, _) = last_frame(&app, &entities);
            most = most.max(sweeps);
            total += sweeps;
            frames += u32::from(sweeps > 0);
            assert!(frames <= 5 * 16, "everyone comes to an end");
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        assert!(most <= max && most > 0, "{most} of {max}");
        assert_eq!(total, 5 * 14, "the same work");
        assert!(frames >= 5 * 14 / max, "{frames} frames");
        for (spread, at_once) in energies(&app, &entities).iter().zip(energies(&free, &together)) {
            assert!((spread / at_once - 1.0).abs() < 0.1, "{spread} {at_once}");
        }
        sleeps(&mut app);
    }
}

#[test]
fn changes_are_followed_within_the_budget_by_everyone() {
    let mut app = app_with(with_sweeps(4));
    let entities = spawn(&mut app, 4);
    settle(&mut app);
    let mut served = 0;
    for frame in 1..=24 {
        // All change in every frame.
        for (n, &entity) in entities.iter().enumerate() {
            let frequency = Frequency::Uniform(3.0 + n as f32 + 0.01 * frame as f32);
            app.world_mut().entity_mut(entity).insert(frequency);
        }
        update(&mut app);
        let (sweeps, _) = last_frame(&app, &entities);
        assert!((1..=4).contains(&sweeps), "{sweeps}");
        served += sweeps;
    }
    assert!(served >= 24 * 3, "the budget is used: {served}");
    for energy in energies(&app, &entities) {
        assert!(energy < 0.2, "{energy}");
    }
    settle(&mut app);
    sleeps(&mut app);
}

#[test]
fn what_is_seen_comes_first_and_the_rest_comes_as_well() {
    let mut app = app_with(with_sweeps(14));
    app.world_mut().spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 0.0, 5.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    // Until the camera knows its picture it sees nothing.
    (0..10).for_each(|_| update(&mut app));
    let entities = spawn(&mut app, 4);
    let (hidden, seen) = entities.split_at(2);
    for &entity in hidden {
        app.world_mut().entity_mut(entity).insert(Visibility::Hidden);
    }
    let mut order = Vec::new();
    for frame in 0..400 {
        update(&mut app);
        let done: Vec<Entity> = entities.iter().copied().filter(|&e| is_converged(&app, e)).collect();
        order.extend(done.into_iter().filter(|e| !order.contains(e)).collect::<Vec<_>>());
        if order.len() == 4 {
            break;
        }
        assert!(frame < 399, "{order:?}");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert!(order[..2].iter().all(|e| seen.contains(e)), "{order:?}, seen {seen:?}");

    // What is seen changes in every frame and could use all of the budget.
    app.insert_resource(with_sweeps(3));
    app.world_mut().entity_mut(hidden[0]).insert(Frequency::Uniform(7.5));
    let mut frames = 0;
    loop {
        let frequency = Frequency::Uniform(4.0 + 0.001 * frames as f32);
        app.world_mut().entity_mut(seen[0]).insert(frequency);
        update(&mut app);
        frames += 1;
        if frames > 2 && is_converged(&app, hidden[0]) {
            break;
        }
        assert!(frames < 300, "what is hidden starves");
    }
    assert!(frames > 20, "what is seen had its share: {frames}");
}

#[test]
fn time_is_a_budget_too() {
    let within = |ms| SolverSettings {
        max_milliseconds: Some(ms),
        ..default()
    };
    // Less than anything takes: one pattern sweeps once per frame.
    let mut app = app_with(within(1e-6));
    let entities = spawn(&mut app, 3);
    let mut frames = 0;
    while last_frame(&app, &entities).1 < 3 {
        update(&mut app);
        let (sweeps, _) = last_frame(&app, &entities);
        assert!(sweeps <= 1);
        frames += u32::from(sweeps > 0);
        assert!(frames <= 3 * 14);
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert_eq!(frames, 3 * 14);
    sleeps(&mut app);
    // More than enough.
    let mut app = app_with(within(1e9));
    spawn(&mut app, 3);
    settle(&mut app);
    assert_eq!(app.world().resource::<SolverCounters>().pattern_sweeps(), 3 * 14);
}

/// Where the device's clock can be read, sweeps come to fill the time that they may take, whatever was guessed at first.
#[test]
fn sweeps_are_as_many_as_time_allows() {
    let mut app = headless::headless_app(UVec2::splat(16)).expect("a device");
    app.add_plugins((FieldPatternsPlugin, RenderDiagnosticsPlugin))
        .insert_resource(QualityReport(false));
    headless::wait_until_ready(&mut app).expect("pipelines");
    let mesh = add_mesh(&mut app, &shapes::torus(200, 100, 1.0, 0.4, 0.25, 5));
    let spawn = (
        Mesh3d(mesh),
        DirectionField::Axis(Dir3::Y),
        Symmetry::Line,
        Frequency::Uniform(6.0),
    );
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let follow = |app: &mut App, milliseconds: f32| {
        app.insert_resource(SolverSettings {
            warm_sweeps: 1000,
            max_milliseconds: Some(milliseconds),
            ..default()
        });
        let (mut sweeps, mut times) = (Vec::new(), Vec::new());
        for frame in 0..60 {
            let frequency = Frequency::Uniform(6.0 + 0.001 * frame as f32);
            app.world_mut().entity_mut(entity).insert(frequency);
            update(app);
            gpu::wait(app);
            sweeps.push(app.world().resource::<SolverCounters>().pattern_sweeps());
            times.extend(gpu::stage_ms(app, "pattern_sweeps"));
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let late: Vec<f64> = sweeps[30..].iter().map(|&sweeps| f64::from(sweeps)).collect();
        (mean(&late), mean(&times[times.len() / 2..]), times.len())
    };
    let (few, short, measured) = follow(&mut app, 10.0);
    if measured == 0 {
        // The device has no clock to read.
        return;
    }
    let (many, long, _) = follow(&mut app, 40.0);
    assert!((0.3..3.0).contains(&(short / 10.0)), "{short} ms for 10, {few} sweeps");
    assert!((0.3..3.0).contains(&(long / 40.0)), "{long} ms for 40, {many} sweeps");
    assert!(many > 1.5 * few, "{many} and {few} sweeps");
}

/// The local rule is not split: patterns that do not fit into a frame together start one after the other.
#[test]
fn cold_starts_by_the_local_rule_take_turns() {
    let rule = LocalRule {
        max_sweeps: 20,
        epsilon: 0.0,
        ..default()
    };
    let settings = SolverSettings {
        cold_start: ColdStart::Local(rule),
        ..with_sweeps(30)
    };
    let mut app = app_with(settings);
    let entities = spawn(&mut app, 3);
    let mut done = Vec::new();
    for _ in 0..2000 {
        update(&mut app);
        let (_, converged) = last_frame(&app, &entities);
        if converged > 0 {
            done.push(converged);
        }
        if converged == 3 {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert_eq!(done, [1, 2, 3], "one in a frame");
}

#[test]
fn nonsense_budgets_are_put_right() {
    let put_right = |max_sweeps_per_frame, max_milliseconds| {
        let settings = SolverSettings {
            max_sweeps_per_frame,
            max_milliseconds,
            ..default()
        };
        let valid = settings.valid();
        (
            settings.check().is_ok(),
            valid.max_sweeps_per_frame,
            valid.max_milliseconds,
        )
    };
    assert_eq!(put_right(Some(0), None), (false, Some(1), None));
    assert_eq!(put_right(None, Some(-1.0)), (false, None, None));
    assert_eq!(put_right(None, Some(f32::NAN)), (false, None, None));
    assert_eq!(put_right(Some(7), Some(0.5)), (true, Some(7), Some(0.5)));
}
