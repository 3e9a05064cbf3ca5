//! Patterns of points on a mesh, against the twin on the CPU, and what happens to them.

mod common;

use bevy::{mesh::PrimitiveTopology, prelude::*};
use bevy_field_patterns::{
    prelude::*,
    surface::SurfaceGraph,
    wave::{Coupling, Pattern, PatternArena, SolverCounters, carry_wave, quality},
};
use common::{add_mesh, app, graph, settle, shapes, update, wave};

/// The points of a torus.
fn points(app: &mut App) -> Handle<Mesh> {
    let raw = shapes::torus(120, 50, 1.0, 0.4, 0.25, 5);
    let mesh = Mesh::new(PrimitiveTopology::PointList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, raw.positions);
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// The same torus, as other triangles.
fn mesh(app: &mut App) -> Handle<Mesh> {
    add_mesh(app, &shapes::torus(140, 70, 1.0, 0.4, 0.1, 2))
}

/// A surface in the world's space of its entity.
fn in_world(mut graph: SurfaceGraph, linear: Mat3) -> SurfaceGraph {
    let cofactors = linear.inverse().transpose();
    graph.positions.iter_mut().for_each(|p| *p = linear * *p);
    graph.normals.iter_mut().for_each(|n| *n = (cofactors * *n).normalize());
    graph
}

/// The share of the mesh's vertices whose waves are not those that the twin carries onto them.
fn share_off(app: &App, from: Entity, onto: Entity, coupling: Coupling) -> f32 {
    share_off_in(app, from, onto, coupling, Mat3::IDENTITY)
}

fn share_off_in(app: &App, from: Entity, onto: Entity, coupling: Coupling, linear: Mat3) -> f32 {
    let (d, f, z) = wave(app, from);
    let [points, mesh] = [from, onto].map(|entity| in_world(graph(app, entity), linear));
    let twin = carry_wave(&points, &d, &f, &z, coupling, &mesh);
    let (d, f, z) = wave(app, onto);
    let waves = coupling.waves.count();
    let off = (0..d.len()).filter(|&i| {
        let phases = !(waves * i..waves * (i + 1)).all(|n| z[n].distance(twin.phasors[n]) < 0.02);
        !(d[i].distance(twin.directions[i]) < 1e-3 && (f[i] - twin.frequencies[i]).abs() < 1e-3) || phases
    });
    off.count() as f32 / d.len() as f32
}

/// What is carried learns of errors and their end a frame later.
fn come_to_rest(app: &mut App) {
    (0..3).for_each(|_| update(app));
    settle(app);
}

fn state(app: &App, entity: Entity) -> PatternState {
    app.world().get::<PatternState>(entity).unwrap().clone()
}

#[test]
fn patterns_of_points_are_carried_as_the_twin_says() {
    for (waves, symmetry) in [
        (Waves::Single, Symmetry::Line),
        (Waves::Single, Symmetry::Vector),
        (Waves::Orthogonal { ratio: 0.5 }, Symmetry::Line),
        (Waves::Cross, Symmetry::Line),
    ] {
        let mut app = app();
        let (points, mesh) = (points(&mut app), mesh(&mut app));
        let axis = |x| DirectionField::Axis(Dir3::new(Vec3::new(x, 1.0, 0.1)).unwrap());
        let from = (Mesh3d(points), axis(0.15), Frequency::Uniform(8.0), waves, symmetry);
        let from = app.world_mut().spawn(from).id();
        // Where the entities stand counts for nothing.
        let onto = (
            Mesh3d(mesh),
            CarriesPattern { of: from },
            Transform::from_xyz(9.0, 0.0, 1.0),
        );
        let onto = app.world_mut().spawn(onto).id();
        settle(&mut app);
        let coupling = Coupling { waves, symmetry };
        let off = share_off(&app, from, onto, coupling);
        assert!(off < 2e-3, "{coupling:?}: {off}");
        assert_eq!(state(&app, onto), PatternState::Converged);
        let record = *app.world().get::<Pattern>(onto).unwrap().record();
        assert_eq!(record.waves as usize, waves.count());
        // Nothing is computed while nothing changes.
        update(&mut app);
        assert_eq!(app.world().resource::<SolverCounters>().dispatches(), 0);
        // The points' pattern changes, and the mesh's with it in the same frame.
        let (before, ..) = wave(&app, onto);
        app.world_mut()
            .entity_mut(from)
            .insert((axis(-0.6), Frequency::Uniform(6.0)));
        update(&mut app);
        let off = share_off(&app, from, onto, coupling);
        assert!(off < 2e-3, "{coupling:?}: {off}");
        let (after, f, _) = wave(&app, onto);
        assert!(f.iter().all(|f| (f - 6.0).abs() < 1e-3));
        let moved = before.iter().zip(&after).filter(|(a, b)| a.cross(**b).length() > 0.05);
        assert!(moved.count() > before.len() / 2);
        settle(&mut app);
        if waves == Waves::Single {
            let (d, f, z) = wave(&app, onto);
            let q = quality(&graph(&app, onto), &d, &f, &z, symmetry);
            assert!(q.energy < 0.06, "{coupling:?}: {q:?}");
        }
    }
}

/// Points whose pattern lives in the world take the mesh along into their space.
#[test]
fn patterns_in_the_world_are_carried() {
    let mut app = app();
    let (points, mesh) = (points(&mut app), mesh(&mut app));
    let turned = Transform::from_scale(Vec3::splat(1.6)).with_rotation(Quat::from_rotation_x(0.5));
    let from = (
        Mesh3d(points),
        DirectionField::Axis(Dir3::Y),
        Frequency::Uniform(6.0),
        PatternSpace::World,
        turned,
    );
    let from = app.world_mut().spawn(from).id();
    let onto = app.world_mut().spawn((Mesh3d(mesh), CarriesPattern { of: from })).id();
    come_to_rest(&mut app);
    let off = |linear| share_off_in(&app, from, onto, Symmetry::Vector.into(), linear);
    let linear = Mat3::from(turned.compute_affine().matrix3);
    assert!(off(linear) < 2e-3, "{}", off(linear));
    assert!(off(Mat3::IDENTITY) > 0.2);
}

#[test]
fn what_cannot_be_carried_is_an_error_until_it_can() {
    let mut app = app();
    let (points, mesh) = (points(&mut app), mesh(&mut app));
    let nobody = app.world_mut().spawn_empty().id();
    let onto = app
        .world_mut()
        .spawn((Mesh3d(mesh.clone()), CarriesPattern { of: nobody }))
        .id();
    come_to_rest(&mut app);
    let PatternState::Failed(PatternError::MissingEntity { entity, .. }) = state(&app, onto) else {
        panic!("{:?}", state(&app, onto));
    };
    assert_eq!(entity, nobody);
    app.world_mut().entity_mut(onto).insert(CarriesPattern { of: onto });
    come_to_rest(&mut app);
    assert!(matches!(
        state(&app, onto),
        PatternState::Failed(PatternError::Carried(_))
    ));
    let from = app
        .world_mut()
        .spawn((Mesh3d(points), DirectionField::Axis(Dir3::Y), Frequency::Uniform(-1.0)))
        .id();
    app.world_mut().entity_mut(onto).insert(CarriesPattern { of: from });
    come_to_rest(&mut app);
    assert_eq!(
        state(&app, onto),
        PatternState::Failed(PatternError::NegativeFrequency(-1.0))
    );
    app.world_mut().entity_mut(from).insert(Frequency::Uniform(5.0));
    come_to_rest(&mut app);
    let coupling = Coupling::from(Symmetry::Vector);
    assert_eq!(state(&app, onto), PatternState::Converged);
    assert!(share_off(&app, from, onto, coupling) < 2e-3);
    // A chain is none.
    let third = app
        .world_mut()
        .spawn((Mesh3d(mesh.clone()), CarriesPattern { of: onto }))
        .id();
    come_to_rest(&mut app);
    assert!(matches!(
        state(&app, third),
        PatternState::Failed(PatternError::Carried(_))
    ));
    app.world_mut().despawn(third);
    // Points that are others, and a mesh that is another one.
    let shifted = shapes::torus(60, 40, 1.0, 0.4, 0.2, 3);
    let shifted = Mesh::new(PrimitiveTopology::PointList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, shifted.positions);
    let shifted = app.world_mut().resource_mut::<Assets<Mesh>>().add(shifted);
    app.world_mut().entity_mut(from).insert(Mesh3d(shifted));
    come_to_rest(&mut app);
    assert!(share_off(&app, from, onto, coupling) < 2e-3);
    let sphere = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    app.world_mut().entity_mut(onto).insert(Mesh3d(sphere));
    come_to_rest(&mut app);
    assert!(share_off(&app, from, onto, coupling) < 2e-3);
    // Without the component the mesh has a pattern of its own.
    app.world_mut().entity_mut(onto).remove::<CarriesPattern>();
    app.world_mut()
        .entity_mut(onto)
        .insert((DirectionField::Axis(Dir3::X), Frequency::Uniform(3.0)));
    come_to_rest(&mut app);
    let (_, f, _) = wave(&app, onto);
    assert!(f.iter().all(|&f| f == 3.0));
    // And the points go.
    app.world_mut().entity_mut(onto).insert(CarriesPattern { of: from });
    come_to_rest(&mut app);
    app.world_mut().despawn(from);
    come_to_rest(&mut app);
    assert!(matches!(
        state(&app, onto),
        PatternState::Failed(PatternError::MissingEntity { .. })
    ));
    app.world_mut().despawn(onto);
    (0..3).for_each(|_| update(&mut app));
    assert_eq!(app.world().resource::<PatternArena>().memory().used, 0);
}
