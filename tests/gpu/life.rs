//! The life of patterns: entities, meshes and memory come, change and go.

use crate::{
    common::{self, add_mesh, app, graph, settle, shapes, update, wave},
    curvature,
};
use bevy::{mesh::VertexAttributeValues, prelude::*};
use bevy_field_patterns::{
    prelude::*,
    wave::{Pattern, PatternArena, layout::FLAG_READY, quality, solver::solve_cpu},
};
use std::sync::Arc;

#[test]
fn three_hundred_entities_come_and_go() {
    let mut app = app();
    let meshes: Vec<_> = [2, 3].map(|n| add_mesh(&mut app, &shapes::icosphere(n, 1.0))).into();
    let mut random = 12345u32;
    let mut next = |n: usize| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 8) as usize % n
    };
    let mut alive: Vec<Entity> = Vec::new();
    let mut after_first = None;
    for round in 0..3 {
        while alive.len() < 300 {
            let axis = Dir3::new(Vec3::new(next(9) as f32 - 4.0, 1.0, next(9) as f32 - 4.0)).unwrap();
            let mesh = Mesh3d(meshes[next(2)].clone());
            alive.push(
                app.world_mut()
                    .spawn((mesh, DirectionField::Axis(axis), Frequency::Uniform(2.0)))
                    .id(),
            );
        }
        settle(&mut app);
        // No two patterns share memory.
        let mut ranges: Vec<(u32, u32)> = Vec::new();
        let mut patterns = app.world_mut().query::<&Pattern>();
        for pattern in patterns.iter(app.world()) {
            let record = pattern.record();
            ranges.push((record.field_base, record.delta_base));
        }
        assert_eq!(ranges.len(), 300);
        ranges.sort_unstable();
        assert!(ranges.windows(2).all(|pair| pair[0].1 <= pair[1].0));
        // And each is what a lone one is.
        for _ in 0..5 {
            let entity = alive[next(300)];
            let (d, f, z) = wave(&app, entity);
            let twin = solve_cpu(&graph(&app, entity), &d, &f, Symmetry::Vector, &default()).phasors;
            let worst = z.iter().zip(&twin).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            assert!(worst < 1e-2, "round {round}: {worst}");
        }
        let allocated = app.world().resource::<PatternArena>().memory().allocated;
        assert!(*after_first.get_or_insert(allocated) * 2 >= allocated, "memory leaks");
        for _ in 0..200 {
            let entity = alive.swap_remove(next(alive.len()));
            app.world_mut().despawn(entity);
        }
    }
    let before = app.world().resource::<PatternArena>().memory().used;
    alive.drain(..).for_each(|entity| {
        app.world_mut().despawn(entity);
    });
    drop(meshes);
    update(&mut app);
    update(&mut app);
    update(&mut app);
    let memory = app.world().resource::<PatternArena>().memory();
    assert!(before > 0 && memory.used == 0, "{memory:?}");
}

#[test]
fn growth_keeps_phases() {
    let mut app = app();
    let small = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let large = add_mesh(&mut app, &shapes::icosphere(6, 1.0));
    let axis = || (DirectionField::Axis(Dir3::Y), Frequency::Uniform(3.0));
    let first = app.world_mut().spawn((Mesh3d(small), axis())).id();
    settle(&mut app);
    let (_, _, before) = wave(&app, first);
    let allocated = app.world().resource::<PatternArena>().memory().allocated;
    app.world_mut().spawn((Mesh3d(large), axis()));
    settle(&mut app);
    assert!(app.world().resource::<PatternArena>().memory().allocated > allocated);
    let (_, _, after) = wave(&app, first);
    assert_eq!(before, after);
}

#[test]
fn changed_positions_keep_the_graph_and_changed_indices_do_not() {
    let mut app = app();
    let raw = shapes::icosphere(3, 1.0);
    let mesh = add_mesh(&mut app, &raw);
    let spawn = (
        Mesh3d(mesh.clone()),
        DirectionField::Axis(Dir3::Y),
        Frequency::Uniform(3.0),
    );
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let before = graph(&app, entity);
    let record = *app.world().get::<Pattern>(entity).unwrap().record();
    {
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        let mut mesh = meshes.get_mut(&mesh).unwrap();
        let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION) else {
            panic!("no positions");
        };
        positions.iter_mut().for_each(|p| p[1] *= 2.0);
    }
    for _ in 0..4 {
        update(&mut app);
    }
    settle(&mut app);
    let after = graph(&app, entity);
    assert_eq!(before.levels, after.levels);
    assert!((after.positions[0].y - 2.0 * before.positions[0].y).abs() < 1e-6);
    assert_eq!(
        app.world().get::<Pattern>(entity).unwrap().record().field_base,
        record.field_base
    );
    let (d, f, z) = wave(&app, entity);
    let q = quality(&after, &d, &f, &z, Symmetry::Vector);
    assert!(q.energy < 0.02, "{q:?}");

    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap() =
        common::mesh_file::to_bevy_mesh(&shapes::icosphere(2, 1.0));
    for _ in 0..4 {
        update(&mut app);
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    settle(&mut app);
    assert_eq!(graph(&app, entity).len(), shapes::icosphere(2, 1.0).positions.len());
}

#[test]
fn bad_input_is_an_error_on_the_entity_and_good_input_mends_it() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let axis = DirectionField::Axis(Dir3::Y);
    let entity = app
        .world_mut()
        .spawn((Mesh3d(mesh.clone()), axis.clone(), Frequency::Uniform(-1.0)))
        .id();
    let short = DirectionField::Vertices(Arc::from(vec![Vec3::X; 3]));
    let other = app
        .world_mut()
        .spawn((Mesh3d(mesh.clone()), short, Frequency::Uniform(1.0)))
        .id();
    let tagged = app.world_mut().spawn((Mesh3d(mesh), axis, bevy::mesh::MeshTag(7))).id();
    let lines = Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default());
    let lines = app.world_mut().resource_mut::<Assets<Mesh>>().add(lines);
    let lines = app.world_mut().spawn((Mesh3d(lines), DirectionField::default())).id();
    settle(&mut app);
    let state = |app: &App, entity| app.world().get::<PatternState>(entity).unwrap().clone();
    assert_eq!(
        state(&app, entity),
        PatternState::Failed(PatternError::NegativeFrequency(-1.0))
    );
    let PatternState::Failed(PatternError::WrongLength { found: 3, .. }) = state(&app, other) else {
        panic!("{:?}", state(&app, other));
    };
    assert_eq!(state(&app, tagged), PatternState::Failed(PatternError::MeshTagTaken));
    let PatternState::Failed(PatternError::Topology(_)) = state(&app, lines) else {
        panic!("{:?}", state(&app, lines));
    };
    app.world_mut().entity_mut(entity).insert(Frequency::Uniform(f32::NAN));
    update(&mut app);
    assert!(matches!(
        state(&app, entity),
        PatternState::Failed(PatternError::SettingNotFinite(_))
    ));
    app.world_mut().entity_mut(entity).insert(Frequency::Uniform(2.0));
    settle(&mut app);
    assert_eq!(state(&app, entity), PatternState::Converged);
}

#[test]
fn removing_the_field_gives_the_mesh_back() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let entity = app
        .world_mut()
        .spawn((Mesh3d(mesh.clone()), DirectionField::Axis(Dir3::Y)))
        .id();
    settle(&mut app);
    assert_ne!(app.world().get::<Mesh3d>(entity).unwrap().0, mesh);
    assert_eq!(app.world().get::<PatternMesh>(entity).unwrap().source, mesh);
    app.world_mut().entity_mut(entity).remove::<DirectionField>();
    update(&mut app);
    let entity = app.world().entity(entity);
    assert_eq!(entity.get::<Mesh3d>().unwrap().0, mesh);
    assert!(!entity.contains::<Pattern>() && !entity.contains::<bevy::mesh::MeshTag>());
}

#[test]
fn a_mesh_and_a_field_that_change_in_every_frame_are_seen_to() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(4, 1.0));
    let spawn = (
        Mesh3d(mesh.clone()),
        curvature(),
        Frequency::Uniform(3.0),
        PatternSpace::World,
    );
    let entity = app.world_mut().spawn(spawn).id();
    let mut frames = 0;
    let is_drawn = |app: &App| {
        let pattern = app.world().get::<Pattern>(entity);
        pattern.is_some_and(|pattern| pattern.record().flags & FLAG_READY != 0)
    };
    while !is_drawn(&app) {
        frames += 1;
        assert!(frames < 1000, "no pattern after {frames} frames");
        let turned = Transform::from_rotation(Quat::from_rotation_y(0.01 * frames as f32));
        app.world_mut().entity_mut(entity).insert(turned);
        {
            let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
            let mut mesh = meshes.get_mut(&mesh).unwrap();
            if let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION) {
                positions.iter_mut().for_each(|p| p[1] *= 1.001);
            }
        }
        update(&mut app);
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

#[test]
fn a_cloned_pattern_is_a_pattern_of_its_own() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let entity = app
        .world_mut()
        .spawn((Mesh3d(mesh), DirectionField::Axis(Dir3::Y)))
        .id();
    settle(&mut app);
    let clone = app.world_mut().entity_mut(entity).clone_and_spawn();
    update(&mut app);
    settle(&mut app);
    let record = |app: &App, entity| *app.world().get::<Pattern>(entity).expect("a pattern").record();
    assert_eq!(app.world().get::<PatternState>(clone), Some(&PatternState::Converged));
    assert_ne!(record(&app, entity).field_base, record(&app, clone).field_base);
    assert_eq!(graph(&app, entity).len(), graph(&app, clone).len());
}

#[test]
fn a_mesh_that_is_kept_keeps_no_gpu_memory() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    for _ in 0..2 {
        let spawn = (Mesh3d(mesh.clone()), DirectionField::Axis(Dir3::Y));
        let entity = app.world_mut().spawn(spawn).id();
        settle(&mut app);
        assert!(app.world().resource::<PatternArena>().memory().used > 0);
        app.world_mut().despawn(entity);
        update(&mut app);
        update(&mut app);
        assert_eq!(app.world().resource::<PatternArena>().memory().used, 0);
    }
}

/// In the world a pattern keeps its width when its entity gets another parent, of another size.
#[test]
fn another_parent_is_another_size() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(4, 1.0));
    let [one, two] = [1.0, 2.0].map(|size| app.world_mut().spawn(Transform::from_scale(Vec3::splat(size))).id());
    let mut child = |parent| {
        let pattern = (
            DirectionField::Axis(Dir3::Y),
            Frequency::Uniform(3.0),
            PatternSpace::World,
        );
        app.world_mut()
            .spawn((Mesh3d(mesh.clone()), pattern, ChildOf(parent)))
            .id()
    };
    let [moved, born] = [child(one), child(two)];
    settle(&mut app);
    let energy = |app: &App, entity, size: f32| {
        let (d, f, z) = wave(app, entity);
        let mut graph = graph(app, entity);
        graph.positions.iter_mut().for_each(|p| *p *= size);
        quality(&graph, &d, &f, &z, Symmetry::Vector).energy
    };
    let (before, wanted) = (energy(&app, moved, 1.0), energy(&app, born, 2.0));
    assert!(
        energy(&app, moved, 2.0) > 10.0 * before.max(wanted),
        "the comparison can fail"
    );
    app.world_mut().entity_mut(moved).insert(ChildOf(two));
    settle(&mut app);
    let after = energy(&app, moved, 2.0);
    assert!(after < 1.5 * wanted, "{after} instead of {wanted}");
}
