//! Vortex cores that move: the pattern follows, and does not jump.

use crate::common::{add_mesh, app, graph, settle, shapes, update, wave};
use bevy::prelude::*;
use bevy_field_patterns::{
    prelude::*,
    wave::{SolverCounters, quality, solver::solve_cpu},
};

/// Two cores on a sphere, `angle` radians along their ways.
fn places(angle: f32) -> [Vec3; 2] {
    [
        Quat::from_rotation_y(angle) * Vec3::new(0.9, 0.4, 0.0).normalize(),
        Quat::from_rotation_x(-angle) * Vec3::new(-0.3, 0.1, 0.9).normalize(),
    ]
}

/// Cores move by half a percent of the bounding box's diagonal per frame.
#[test]
fn moving_cores_are_followed_without_jumps() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(5, 1.0));
    let cores = places(0.0).map(|at| {
        let vortex = Vortex {
            radius: 0.35,
            ..default()
        };
        app.world_mut().spawn((vortex, Transform::from_translation(at))).id()
    });
    let field = DirectionField::Vortices(VortexField {
        base: 0.3 * Vec3::Y,
        ..default()
    });
    let entity = app
        .world_mut()
        .spawn((Mesh3d(mesh), field, Frequency::Uniform(6.0)))
        .id();
    settle(&mut app);
    update(&mut app);
    assert_eq!(
        app.world().resource::<SolverCounters>().dispatches(),
        0,
        "cores at rest"
    );
    let graph = graph(&app, entity);
    let area: f32 = graph.areas.iter().sum();
    let diagonal = 2.0 * 3.0_f32.sqrt();
    let (mut ratios, mut jumps) = (Vec::new(), Vec::new());
    let (_, _, mut before) = wave(&app, entity);
    for frame in 1..=60 {
        // Both ways have radius 0.9 or more.
        let angle = frame as f32 * 0.005 * diagonal;
        for (core, at) in cores.into_iter().zip(places(angle)) {
            app.world_mut().entity_mut(core).insert(Transform::from_translation(at));
        }
        update(&mut app);
        let (d, f, z) = wave(&app, entity);
        let jumped = z.iter().zip(&before).zip(&graph.areas).filter(|((z, old), _)| {
            let (z, old) = (z.normalize_or(Vec2::X), old.normalize_or(Vec2::X));
            z.dot(old) < std::f32::consts::FRAC_1_SQRT_2
        });
        jumps.push(jumped.map(|(_, area)| area).sum::<f32>() / area);
        before = z.clone();
        if frame % 10 == 0 {
            let energy = |z: &[Vec2]| quality(&graph, &d, &f, z, Symmetry::Vector).energy;
            let cold = solve_cpu(&graph, &d, &f, Symmetry::Vector, &default()).phasors;
            ratios.push((energy(&z), energy(&cold)));
        }
    }
    let mean = |values: &mut dyn Iterator<Item = f64>| {
        let values: Vec<f64> = values.collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let warm = mean(&mut ratios.iter().map(|r| r.0));
    let cold = mean(&mut ratios.iter().map(|r| r.1));
    let jumping = mean(&mut jumps.iter().map(|&share| f64::from(share)));
    let found = format!("E {warm:.5} in motion, {cold:.5} cold; share that jumps {jumping:.4}");
    assert!(warm <= 2.5 * cold, "{found}: {ratios:?}");
    assert!(jumping <= 0.02, "{found}: {jumps:?}");
}

/// What moves by little is followed: the pattern remembers where it was. After a leap it is what a new one would be.
#[test]
fn what_leaps_is_solved_from_nothing() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(4, 1.0));
    let core = |x: f32| (Vortex::default(), Transform::from_xyz(x, 1.0, 0.0));
    let axis = |x: f32| DirectionField::Axis(Dir3::new(Vec3::new(x, 1.0, 0.0)).expect("a direction"));
    let vortices = DirectionField::Vortices(VortexField::default());
    type Change<'a> = &'a dyn Fn(&mut World, Entity, Entity);
    let changes: [(&str, &DirectionField, bool, Change); 9] = [
        ("axis", &axis(0.0), false, &|world, entity, _| {
            world.entity_mut(entity).insert(axis(0.2));
        }),
        ("axis", &axis(0.0), true, &|world, entity, _| {
            world.entity_mut(entity).insert(axis(1.0));
        }),
        ("turn", &axis(0.0), true, &|world, entity, _| {
            world.entity_mut(entity).insert(FieldTurn(1.0));
        }),
        ("frequency", &axis(0.0), false, &|world, entity, _| {
            world.entity_mut(entity).insert(Frequency::Uniform(6.6));
        }),
        ("frequency", &axis(0.0), true, &|world, entity, _| {
            world.entity_mut(entity).insert(Frequency::Uniform(9.0));
        }),
        ("kind", &axis(0.0), true, &|world, entity, _| {
            world.entity_mut(entity).insert(vortices.clone());
        }),
        ("core", &vortices, false, &|world, _, vortex| {
            world.entity_mut(vortex).insert(core(0.1));
        }),
        ("core", &vortices, true, &|world, _, vortex| {
            world.entity_mut(vortex).insert(core(-2.0));
        }),
        ("core", &vortices, true, &|world, _, vortex| {
            world.despawn(vortex);
        }),
    ];
    for (what, field, leaps, change) in changes {
        let pattern = (field.clone(), Symmetry::Vector, Frequency::Uniform(6.0));
        let entity = app.world_mut().spawn((Mesh3d(mesh.clone()), pattern)).id();
        let vortex = app.world_mut().spawn(core(0.0)).id();
        settle(&mut app);
        change(app.world_mut(), entity, vortex);
        settle(&mut app);
        let (d, f, z) = wave(&app, entity);
        let twin = solve_cpu(&graph(&app, entity), &d, &f, Symmetry::Vector, &default()).phasors;
        let apart: f32 = z.iter().zip(&twin).map(|(a, b)| a.distance(*b)).sum::<f32>() / z.len() as f32;
        assert_eq!(apart < 1e-3, leaps, "{what}: {apart} from a new one");
        app.world_mut().despawn(entity);
        app.world_mut().try_despawn(vortex).ok();
    }
}
