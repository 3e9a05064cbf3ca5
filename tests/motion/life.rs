//! When surfaces move, when they rest, and what comes and goes meanwhile.

use crate::{
    common::{add_mesh, app, settle, shapes, update, wave},
    creature::{Creature, Instance, geometry, posed_graph, state},
};
use bevy::{mesh::morph::MeshMorphWeights, prelude::*};
use bevy_field_patterns::{
    field::Principal,
    prelude::*,
    wave::{Pattern, PatternArena, SolverCounters, layout::FLAG_READY, quality, solver::solve_cpu},
};

fn live() -> impl Bundle {
    (
        DirectionField::Axis(Dir3::Y),
        Frequency::Uniform(5.0),
        PatternPose::Live,
    )
}

fn dispatches(app: &App) -> u32 {
    app.world().resource::<SolverCounters>().dispatches()
}

#[test]
fn a_surface_that_rests_costs_nothing() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    let instance = creature.spawn(app.world_mut(), Transform::from_xyz(3.0, 0.0, 1.0), 0.5);
    app.world_mut().entity_mut(instance.entity).insert(live());
    let settle = |app: &mut App| {
        settle(app);
        update(app);
        assert_eq!(dispatches(app), 0);
    };
    settle(&mut app);
    // A joint moves, and comes to rest.
    instance.pose(app.world_mut(), 0.6);
    update(&mut app);
    assert!(dispatches(&app) > 0);
    assert_eq!(state(&app, instance.entity), PatternState::Solving);
    settle(&mut app);
    // The pose is written again, but is the same.
    instance.pose(app.world_mut(), 0.6);
    update(&mut app);
    assert_eq!(dispatches(&app), 0);
    // All of it walks and turns in the world; the surface is the same in its own space.
    for step in 1..=20 {
        let walk = Transform::from_xyz(3.0 + 0.37 * step as f32, 0.1, 1.0);
        let walk = walk.with_rotation(Quat::from_rotation_y(0.3 * step as f32));
        app.world_mut().entity_mut(instance.root).insert(walk);
        update(&mut app);
        assert_eq!(dispatches(&app), 0, "step {step}");
    }
    // In the world's space walking changes nothing, turning does.
    app.world_mut().entity_mut(instance.entity).insert(PatternSpace::World);
    settle(&mut app);
    let at = *app.world().get::<Transform>(instance.root).unwrap();
    app.world_mut()
        .entity_mut(instance.root)
        .insert(at.with_translation(Vec3::new(-5.0, 2.0, 0.0)));
    update(&mut app);
    assert_eq!(dispatches(&app), 0);
    app.world_mut()
        .entity_mut(instance.root)
        .insert(at.with_rotation(Quat::from_rotation_y(7.0)));
    update(&mut app);
    assert!(dispatches(&app) > 0);
    settle(&mut app);
    // A weight is a pose as well.
    let weights = MeshMorphWeights::Value {
        weights: vec![0.1, 0.0],
    };
    app.world_mut().entity_mut(instance.entity).insert(weights);
    update(&mut app);
    assert!(dispatches(&app) > 0);
}

#[test]
fn slow_motion_is_followed() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    let instance = creature.spawn(app.world_mut(), Transform::IDENTITY, 0.5);
    app.world_mut().entity_mut(instance.entity).insert(live());
    settle(&mut app);
    let (before, ..) = geometry(&app, instance.entity);
    for step in 1..=200 {
        instance.pose(app.world_mut(), 0.5 + 2e-6 * step as f32);
        update(&mut app);
    }
    let (after, ..) = geometry(&app, instance.entity);
    let drawn = creature.drawn(app.world(), &instance);
    let ids = crate::common::graph(&app, instance.entity).first_vertices();
    let off = |positions: &[Vec3]| {
        let off = positions.iter().zip(&ids).map(|(p, &v)| p.distance(drawn[v as usize]));
        off.fold(0.0, f32::max)
    };
    assert!(
        off(&after) < 4e-5 && off(&before) > 1e-4,
        "{} {}",
        off(&after),
        off(&before)
    );
}

#[test]
fn nothing_is_left_of_what_is_gone() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    let spawn = |app: &mut App, n: u32| -> Vec<Instance> {
        let spawn = |k: u32| {
            let instance = creature.spawn(
                app.world_mut(),
                Transform::from_xyz(3.0 * k as f32, 0.0, 0.0),
                0.1 * k as f32,
            );
            app.world_mut().entity_mut(instance.entity).insert(live());
            instance
        };
        (0..n).map(spawn).collect()
    };
    let used = |app: &App| app.world().resource::<PatternArena>().memory().used;
    let instances = spawn(&mut app, 5);
    settle(&mut app);
    let five = used(&app);
    for instance in &instances[1..] {
        app.world_mut().despawn(instance.root);
    }
    settle(&mut app);
    let one = used(&app);
    let more = spawn(&mut app, 4);
    settle(&mut app);
    assert_eq!(used(&app), five);
    for instance in more {
        app.world_mut().despawn(instance.root);
    }
    // The last one stops to be posed: its rig goes, its pattern stays.
    app.world_mut()
        .entity_mut(instances[0].entity)
        .insert(PatternPose::Rest);
    settle(&mut app);
    update(&mut app);
    update(&mut app);
    assert!(used(&app) < one && used(&app) > 0);
    let (rest, ..) = geometry(&app, instances[0].entity);
    assert_eq!(rest, crate::common::graph(&app, instances[0].entity).positions);
    app.world_mut().despawn(instances[0].root);
    for _ in 0..3 {
        update(&mut app);
    }
    assert_eq!(used(&app), 0);
}

/// Patterns that start, follow, and are given another mesh, another field or another way to be posed.
#[test]
fn a_live_pattern_is_never_that_of_something_else() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    let instance = creature.spawn(app.world_mut(), Transform::IDENTITY, 0.5);
    app.world_mut().entity_mut(instance.entity).insert(live());
    settle(&mut app);
    let entity = instance.entity;
    let is_good = |app: &App, symmetry: Symmetry| {
        let (d, f, z) = wave(app, entity);
        let posed = posed_graph(app, entity);
        let cold = solve_cpu(&posed, &d, &f, symmetry, &default()).phasors;
        let [energy, best] = [&z, &cold].map(|z| quality(&posed, &d, &f, z, symmetry).energy);
        energy < 1.5 * best
    };
    assert!(is_good(&app, Symmetry::Vector));
    let curvature = DirectionField::PrincipalCurvature {
        direction: Principal::Minor,
        smoothing: 10,
    };
    app.world_mut().entity_mut(entity).insert((curvature, Symmetry::Line));
    settle(&mut app);
    assert!(is_good(&app, Symmetry::Line));
    for step in 0..10 {
        instance.pose(app.world_mut(), 0.5 + 0.03 * step as f32);
        update(&mut app);
    }
    settle(&mut app);
    assert!(is_good(&app, Symmetry::Line));
    // Another mesh, without joints: while it is prepared, nothing is drawn of the old pattern.
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    app.world_mut().entity_mut(entity).insert(Mesh3d(mesh.clone()));
    update(&mut app);
    let record = *app.world().get::<Pattern>(entity).unwrap().record();
    assert_eq!(record.flags & FLAG_READY, 0);
    settle(&mut app);
    assert!(is_good(&app, Symmetry::Line));
    let (positions, ..) = geometry(&app, entity);
    assert!(positions.iter().all(|p| (p.length() - 1.0).abs() < 1e-5));
    // And back.
    app.world_mut().entity_mut(entity).insert(Mesh3d(creature.mesh.clone()));
    settle(&mut app);
    assert!(is_good(&app, Symmetry::Line));
    assert_eq!(geometry(&app, entity).0.len(), 70 * 35);
}

#[test]
fn a_pose_that_is_none_is_an_error_until_it_is_one() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    let instance = creature.spawn(app.world_mut(), Transform::IDENTITY, 0.5);
    let entity = instance.entity;
    app.world_mut().entity_mut(entity).insert(live());
    settle(&mut app);
    let broken = Transform::from_xyz(f32::NAN, 0.0, 0.0);
    app.world_mut().entity_mut(instance.joints[1]).insert(broken);
    update(&mut app);
    let PatternState::Failed(PatternError::NotFinite { index: 1, .. }) = state(&app, entity) else {
        panic!("{:?}", state(&app, entity));
    };
    update(&mut app);
    instance.pose(app.world_mut(), 0.6);
    settle(&mut app);
    assert_eq!(state(&app, entity), PatternState::Converged);
    let weights = MeshMorphWeights::Value {
        weights: vec![f32::INFINITY],
    };
    app.world_mut().entity_mut(entity).insert(weights);
    update(&mut app);
    assert!(matches!(state(&app, entity), PatternState::Failed(_)));
    instance.pose(app.world_mut(), 0.2);
    settle(&mut app);
    assert_eq!(state(&app, entity), PatternState::Converged);
    // Joints may go before their skin, an entity may be flattened, weights may be too many or refer to nobody.
    app.world_mut().despawn(instance.joints[2]);
    let many = MeshMorphWeights::Value { weights: vec![0.1; 9] };
    app.world_mut()
        .entity_mut(entity)
        .insert((many, Transform::from_scale(Vec3::ZERO)));
    settle(&mut app);
    let nobody = app.world_mut().spawn_empty().id();
    app.world_mut()
        .entity_mut(entity)
        .insert(MeshMorphWeights::Reference(nobody));
    settle(&mut app);
    assert_eq!(state(&app, entity), PatternState::Converged);
    assert!(geometry(&app, entity).0.iter().all(|p| p.is_finite()));
}
