//! Signs of lines and what they refer to, while fields and symmetries change.

use crate::common::{add_mesh, app, graph, settle, shapes, update, wave};
use bevy::prelude::*;
use bevy_field_patterns::{
    field::Principal,
    prelude::*,
    surface::SurfaceGraph,
    wave::{Pattern, layout::FLAG_VECTOR, quality, solver::solve_cpu},
};

/// Lines keep the sign that their phasor refers to while the axis turns right round.
#[test]
fn a_turning_line_field_keeps_its_signs() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(4, 1.0));
    let field = |frame: u32| DirectionField::Axis(Quat::from_rotation_z((frame as f32 * 6.0).to_radians()) * Dir3::Y);
    let spawn = (Mesh3d(mesh), field(0), Symmetry::Line, Frequency::Uniform(4.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let (mut last, f, _) = wave(&app, entity);
    for frame in 1..=30 {
        app.world_mut().entity_mut(entity).insert(field(frame));
        update(&mut app);
        let (d, _, _) = wave(&app, entity);
        let reversed = d.iter().zip(&last).filter(|(d, last)| d.dot(**last) < 0.0).count();
        assert_eq!(reversed, 0, "frame {frame}");
        last = d;
    }
    settle(&mut app);
    let graph = graph(&app, entity);
    let (d, _, z) = wave(&app, entity);
    let q = quality(&graph, &d, &f, &z, Symmetry::Line);
    assert!(q.energy < 0.05, "{q:?}");
}

/// The pattern of old directions is that of the old symmetry, for as long as new ones are being computed.
#[test]
fn a_symmetry_changes_together_with_its_directions() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::torus(140, 72, 1.0, 0.4, 0.25, 5));
    let curvature = |smoothing| DirectionField::PrincipalCurvature {
        direction: Principal::Major,
        smoothing,
    };
    let spawn = (Mesh3d(mesh), curvature(999), Symmetry::Line, Frequency::Uniform(6.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let (before, ..) = wave(&app, entity);
    app.world_mut()
        .entity_mut(entity)
        .insert((curvature(1000), Symmetry::Vector, FieldTurn(0.8)));
    let mut waited = 0;
    loop {
        update(&mut app);
        let is_vector = app.world().get::<Pattern>(entity).unwrap().record().flags & FLAG_VECTOR != 0;
        let (now, ..) = wave(&app, entity);
        let turned = now.iter().zip(&before).all(|(d, old)| d.dot(*old) < 0.9);
        assert_eq!(is_vector, turned, "after {waited} frames");
        if turned {
            break;
        }
        waited += 1;
        assert!(waited < 10_000);
        assert_eq!(app.world().get::<PatternState>(entity), Some(&PatternState::Solving));
    }
    assert!(waited > 0, "the computation is too fast to see anything");
    settle(&mut app);
    let (d, f, z) = wave(&app, entity);
    let twin = solve_cpu(&graph(&app, entity), &d, &f, Symmetry::Vector, &default()).phasors;
    let worst = z.iter().zip(&twin).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(worst < 1e-2, "{worst}");
}

/// The device knows the signs of a line field that it has followed; directions of the processor take them over.
#[test]
fn directions_that_are_uploaded_keep_the_signs_before() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(4, 1.0));
    let graph =
        SurfaceGraph::from_mesh(app.world().resource::<Assets<Mesh>>().get(&mesh).unwrap(), &default()).unwrap();
    let axis = |step: u32| Quat::from_rotation_z((step as f32 * 17.0).to_radians()) * Vec3::Y;
    let projected = |step, v: u32| bevy_field_patterns::field::project_tangent(axis(step), graph.normals[v as usize]);
    let field = |step, sign: f32| {
        let given = graph.vertex_of.iter().map(|&v| sign * projected(step, v));
        DirectionField::Tangents(given.collect())
    };
    let spawn = (Mesh3d(mesh), field(0, 1.0), Symmetry::Line, Frequency::Uniform(4.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    for step in 1..=10 {
        app.world_mut().entity_mut(entity).insert(field(step, 1.0));
        update(&mut app);
    }
    settle(&mut app);
    let (before, ..) = wave(&app, entity);
    // The axis has come past many normals, where its projections have the other sign by now.
    let reversed = |d: &[Vec3]| d.iter().zip(&before).filter(|(d, old)| d.dot(**old) < 0.0).count();
    let as_given: Vec<Vec3> = (0..graph.len() as u32).map(|v| projected(10, v)).collect();
    assert!(reversed(&as_given) > 20, "the test shows nothing");
    for sign in [-1.0, 1.0] {
        app.world_mut().entity_mut(entity).insert(field(10, sign));
        update(&mut app);
        let (now, ..) = wave(&app, entity);
        assert_eq!(reversed(&now), 0);
        assert!(now.iter().zip(&before).all(|(d, old)| d.distance(*old) < 1e-4));
    }
}
