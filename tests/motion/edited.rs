//! Meshes whose positions are edited on the CPU in every frame.

use crate::{
    common::{app, graph, mesh_file::to_bevy_mesh, settle, shapes, update, wave},
    creature::{geometry, posed_graph},
};
use bevy::{mesh::VertexAttributeValues, prelude::*};
use bevy_field_patterns::{
    prelude::*,
    surface::SurfaceGraph,
    wave::{Pattern, quality},
};

/// A flag in the wind, `time` in radians.
fn waved(rest: &[Vec3], time: f32) -> Vec<[f32; 3]> {
    let wave = |p: &Vec3| [p.x, p.y, 0.25 * (p.x + 1.0) * (4.0 * p.x - time).sin()];
    rest.iter().map(wave).collect()
}

#[test]
fn an_edited_mesh_keeps_its_graph_and_is_followed() {
    for pose in [PatternPose::Rest, PatternPose::Live] {
        let mut app = app();
        let raw = shapes::plane(40, 0.2, 3);
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(to_bevy_mesh(&raw));
        let spawn = (
            Mesh3d(mesh.clone()),
            DirectionField::Axis(Dir3::X),
            Frequency::Uniform(6.0),
            pose,
        );
        let entity = app.world_mut().spawn(spawn).id();
        settle(&mut app);
        let before: SurfaceGraph = graph(&app, entity);
        let record = *app.world().get::<Pattern>(entity).unwrap().record();
        let set = |app: &mut App, positions: Vec<[f32; 3]>| {
            let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
            let mut mesh = meshes.get_mut(&mesh).unwrap();
            let attribute = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION).unwrap();
            *attribute = VertexAttributeValues::Float32x3(positions);
        };
        for frame in 0..30 {
            set(&mut app, waved(&raw.positions, 0.1 * frame as f32));
            update(&mut app);
        }
        // What was set in one frame is on the device in the next.
        update(&mut app);
        let (positions, _, normals) = geometry(&app, entity);
        let expected = waved(&raw.positions, 2.9);
        let after = graph(&app, entity);
        let ids = after.first_vertices();
        let off = positions
            .iter()
            .zip(&ids)
            .map(|(p, &v)| p.distance(expected[v as usize].into()));
        assert!(off.fold(0.0, f32::max) < 1e-5, "{pose:?}");
        let twin = posed_graph(&app, entity);
        let off = normals.iter().zip(&twin.normals).map(|(a, b)| a.distance(*b));
        assert!(off.fold(0.0, f32::max) < 1e-4, "{pose:?}");
        assert_eq!(before.levels, after.levels);
        assert_eq!(
            app.world().get::<Pattern>(entity).unwrap().record().field_base,
            record.field_base
        );
        settle(&mut app);
        let (d, f, z) = wave(&app, entity);
        let q = quality(&twin, &d, &f, &z, Symmetry::Vector);
        assert!(q.energy < 0.05, "{pose:?}: {q:?}");
    }
}
