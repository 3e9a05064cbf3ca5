//! What is solved is what is drawn, pixel by pixel, also of those who share a skin and of those who have not been seen.

use crate::{
    creature::{Creature, Instance},
    probe::{self, Probe},
    stage::{Lens, Picture, Stage},
};
use bevy::{mesh::morph::MeshMorphWeights, prelude::*};
use bevy_field_patterns::prelude::*;

/// Of the pixels with a creature: how many there are, the largest distance, the mean unevenness.
fn measured(picture: &Picture) -> (usize, f32, f32) {
    let seen: Vec<Vec4> = picture.pixels.iter().copied().filter(|p| p.z > 0.25).collect();
    let apart = seen.iter().map(|p| p.x).fold(0.0, f32::max);
    let uneven = seen.iter().map(|p| p.y).sum::<f32>() / seen.len().max(1) as f32;
    (seen.len(), apart, uneven)
}

#[test]
fn what_is_solved_is_what_is_drawn() {
    let mut stage = Stage::new((
        FieldPatternsPlugin,
        MaterialPlugin::<Probe>::default(),
        PatternMaterialPlugin::<Probe>::default(),
    ));
    probe::add_shader(&mut stage.app);
    let creature = Creature::new(stage.app.world_mut());
    let places = [Vec3::ZERO, Vec3::new(40.0, 0.0, 0.0), Vec3::new(0.0, 40.0, 0.0)];
    let pattern = |pose: PatternPose| {
        let field = DirectionField::Axis(Dir3::Y);
        (field, Frequency::Uniform(5.0), pose, PatternSpace::World)
    };
    // Two instances of one mesh, each with joints of its own; the third shares those of the first, so it is drawn there,
    // but stands elsewhere.
    let mut instances: Vec<Instance> = vec![];
    for (n, place) in places.into_iter().enumerate() {
        let instance = creature.spawn(
            stage.app.world_mut(),
            Transform::from_translation(place),
            0.3 * n as f32,
        );
        let material = stage.add(Probe::new(place));
        let mut entity = stage.app.world_mut().entity_mut(instance.entity);
        // Bounds are those of the rest.
        let never_culled = bevy::camera::visibility::NoFrustumCulling;
        entity.insert((pattern(PatternPose::Live), MeshMaterial3d(material)));
        if n == 2 {
            let shared = creature.skin(&instances[0].joints);
            entity.insert((shared, never_culled, Visibility::Hidden));
        }
        instances.push(instance);
    }
    let lens = |at: Vec3| Lens {
        width: 96,
        height: 96,
        from: at + Vec3::new(0.0, 0.0, 4.0),
        to: at,
        ..default()
    };
    let settle = |stage: &mut Stage| {
        for _ in 0..200 {
            stage.app.update();
            let mut states = stage.app.world_mut().query::<&PatternState>();
            if states
                .iter(stage.app.world())
                .all(|state| *state == PatternState::Converged)
            {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        panic!("patterns did not settle");
    };
    // Only the first is seen while both move.
    let (camera, target) = stage.camera(lens(places[0]));
    stage.settle();
    settle(&mut stage);
    for step in 0..20 {
        instances[0].pose(stage.app.world_mut(), 0.05 * step as f32);
        instances[1].pose(stage.app.world_mut(), -0.04 * step as f32);
        stage.app.update();
    }
    let check = |picture: &Picture, name: &str| {
        picture.save(name);
        let (seen, apart, uneven) = measured(picture);
        assert!(seen > 300, "{name}: {seen} pixels");
        assert!(apart < 1e-3, "{name}: {apart} apart");
        assert!(uneven < 0.25, "{name}: {uneven} uneven");
    };
    check(&stage.read(&target), "first, moving");
    // The camera turns to the second, which goes on moving.
    let mut view = stage.app.world_mut().entity_mut(camera);
    view.insert(Transform::from_translation(lens(places[1]).from).looking_at(places[1], Vec3::Y));
    // Bevy has no morph weights of a mesh in the first frame in which it is seen.
    stage.app.update();
    instances[1].pose(stage.app.world_mut(), -0.8);
    check(&stage.read(&target), "second, never seen before");
    // What shares joints and was hidden is drawn where these are.
    stage
        .app
        .world_mut()
        .entity_mut(instances[0].entity)
        .insert(Visibility::Hidden);
    stage
        .app
        .world_mut()
        .entity_mut(instances[2].entity)
        .insert(Visibility::Visible);
    let mut view = stage.app.world_mut().entity_mut(camera);
    view.insert(Transform::from_translation(lens(places[0]).from).looking_at(places[0], Vec3::Y));
    instances[0].pose(stage.app.world_mut(), 0.9);
    let weights = MeshMorphWeights::Value {
        weights: vec![-0.5, 0.4],
    };
    stage.app.world_mut().entity_mut(instances[2].entity).insert(weights);
    settle(&mut stage);
    check(&stage.read(&target), "third, of the first one's joints");
    // The comparison can fail: a pattern that sticks to the rest is not solved on what is drawn.
    stage
        .app
        .world_mut()
        .entity_mut(instances[2].entity)
        .insert(PatternPose::Rest);
    settle(&mut stage);
    let (seen, apart, _) = measured(&stage.read(&target));
    assert!(seen > 300 && apart > 0.2, "{seen} pixels, {apart}");
}
