//! Every pass against its twin, and each comparison shown able to fail.

use crate::{
    common::{add_mesh, app, gpu, graph, mesh_file::to_bevy_mesh, settle, shapes, update, wave},
    creature::{Creature, geometry, posed_graph},
};
use bevy::{
    mesh::{MeshVertexAttribute, VertexFormat, morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
};
use bevy_field_patterns::{
    field::{Principal, directions, project_tangent},
    prelude::*,
    surface::SurfaceGraph,
    wave::{
        Pattern,
        layout::GEOMETRY_BUFFER,
        pose::{Pose, Rig, deformations, pose_vertices},
        quality,
        solver::solve_cpu,
    },
};
use std::sync::Arc;

const PLACE: Transform = Transform {
    translation: Vec3::new(30.0, -2.0, 7.0),
    rotation: Quat::from_xyzw(0.0, 0.6, 0.0, 0.8),
    scale: Vec3::new(1.5, 1.5, 1.5),
};

fn farthest(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn vertices_are_posed_as_bevy_draws_them() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    for (skinned, space) in [
        (true, PatternSpace::Mesh),
        (true, PatternSpace::World),
        (false, PatternSpace::Mesh),
        (false, PatternSpace::World),
    ] {
        let instance = creature.spawn(app.world_mut(), PLACE, 0.7);
        let pattern = (
            DirectionField::Axis(Dir3::Y),
            Frequency::Uniform(3.0),
            PatternPose::Live,
            space,
        );
        let mut entity = app.world_mut().entity_mut(instance.entity);
        entity.insert(pattern);
        if !skinned {
            entity.remove::<SkinnedMesh>();
        }
        settle(&mut app);
        let first = geometry(&app, instance.entity).0;
        instance.pose(app.world_mut(), 1.0);
        update(&mut app);
        let (posed, ..) = geometry(&app, instance.entity);
        let transform = app.world().get::<GlobalTransform>(instance.entity).unwrap().affine();
        let to_pattern = match space {
            PatternSpace::World => bevy::math::Affine3A::from_translation((-transform.translation).into()),
            PatternSpace::Mesh => transform.inverse(),
        };
        let drawn = creature.drawn(app.world(), &instance);
        let ids = graph(&app, instance.entity).first_vertices();
        let expected: Vec<Vec3> = ids
            .iter()
            .map(|&v| to_pattern.transform_point3(drawn[v as usize]))
            .collect();
        let (apart, moved) = (farthest(&posed, &expected), farthest(&first, &expected));
        assert!(apart < 2e-5 && moved > 0.05, "{skinned} {space:?}: {apart}, {moved}");
        app.world_mut().despawn(instance.root);
        update(&mut app);
    }
}

/// The twin is no copy of the formula in these tests: it goes over welded vertices and matrices of the pattern's space.
#[test]
fn the_twin_poses_vertices_as_the_device_does() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    let instance = creature.spawn(app.world_mut(), Transform::IDENTITY, 0.8);
    let pattern = (
        DirectionField::Axis(Dir3::Y),
        Frequency::Uniform(3.0),
        PatternPose::Live,
    );
    app.world_mut().entity_mut(instance.entity).insert(pattern);
    settle(&mut app);
    let graph = graph(&app, instance.entity);
    let mesh = app
        .world()
        .resource::<Assets<Mesh>>()
        .get(&creature.mesh)
        .unwrap()
        .clone();
    let rig = Rig::from_mesh(&mesh, &graph).unwrap();
    let (posed, ..) = geometry(&app, instance.entity);
    let world = app.world();
    let skin = world.get::<SkinnedMesh>(instance.entity).unwrap();
    let bindposes = world.resource::<Assets<bevy::mesh::skinning::SkinnedMeshInverseBindposes>>();
    let bindposes = bindposes.get(&skin.inverse_bindposes).unwrap();
    let joints = skin.joints.iter().zip(bindposes.iter());
    let Some(MeshMorphWeights::Value { weights }) = world.get::<MeshMorphWeights>(instance.entity) else {
        panic!("no weights");
    };
    let pose = Pose {
        matrices: joints
            .map(|(&joint, bind)| {
                world.get::<GlobalTransform>(joint).unwrap().affine() * bevy::math::Affine3A::from_mat4(*bind)
            })
            .collect(),
        weights: weights.clone(),
    };
    let apart = farthest(&posed, &pose_vertices(&graph, &rig, &pose));
    assert!(apart < 1e-5, "{apart}");
    let still = farthest(&graph.positions, &pose_vertices(&graph, &rig, &Pose::rest()));
    assert!(still < 1e-6, "{still}");
}

#[test]
fn normals_and_areas_are_those_of_the_twin() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    // Units of length may be small and large.
    for scale in [1e-12, 1.0, 1e12] {
        let at = Transform::from_scale(Vec3::splat(scale));
        let instance = creature.spawn(app.world_mut(), at, 1.0);
        let pattern = (
            DirectionField::Axis(Dir3::Y),
            Frequency::Uniform(3.0 / scale),
            PatternPose::Live,
            PatternSpace::World,
        );
        app.world_mut().entity_mut(instance.entity).insert(pattern);
        settle(&mut app);
        let (rest, posed) = (graph(&app, instance.entity), posed_graph(&app, instance.entity));
        let (_, areas, normals) = geometry(&app, instance.entity);
        let off = farthest(&normals, &posed.normals);
        let relative = |twin: &[f32], unit: f32| {
            let ratios = areas.iter().zip(twin).map(|(a, b)| (a / (b * unit) - 1.0).abs());
            ratios.fold(0.0, f32::max)
        };
        let area_off = relative(&posed.areas, 1.0);
        assert!(off < 2e-5 && area_off < 1e-4, "normals {off}, areas {area_off}");
        // Those of the mesh at rest are others.
        assert!(farthest(&normals, &rest.normals) > 0.3 && relative(&rest.areas, scale * scale) > 0.3);
        app.world_mut().despawn(instance.root);
        update(&mut app);
    }
}

/// Per vertex: the sine of the angle between lines.
fn line_angles(a: &[Vec3], b: &[Vec3]) -> Vec<f32> {
    let mut angles: Vec<f32> = a.iter().zip(b).map(|(a, b)| a.cross(*b).length()).collect();
    angles.sort_unstable_by(f32::total_cmp);
    angles
}

#[test]
fn curvature_directions_are_those_of_the_twin() {
    let mut app = app();
    let small = Creature::new(app.world_mut());
    let large = Creature::of_size(app.world_mut(), 260, 130);
    for (creature, direction, smoothing, turn) in [
        (&small, Principal::Major, 0, 0.0),
        (&small, Principal::Minor, 1, 0.3),
        (&small, Principal::Major, 30, 0.0),
        (&large, Principal::Major, 7, 0.0),
    ] {
        let field = DirectionField::PrincipalCurvature { direction, smoothing };
        let instance = creature.spawn(app.world_mut(), Transform::IDENTITY, 0.2);
        let pattern = (
            field.clone(),
            FieldTurn(turn),
            Frequency::Uniform(3.0),
            PatternPose::Live,
        );
        app.world_mut().entity_mut(instance.entity).insert(pattern);
        settle(&mut app);
        let (before, ..) = wave(&app, instance.entity);
        instance.pose(app.world_mut(), 1.0);
        update(&mut app);
        let (d, f, _) = wave(&app, instance.entity);
        let posed = posed_graph(&app, instance.entity);
        let empty = Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, default());
        let twin = directions(&field, Symmetry::Line, turn, &posed, &empty).unwrap();
        let angles = line_angles(&d, &twin);
        let (most, worst) = (angles[angles.len() * 99 / 100], angles[angles.len() - 1]);
        assert!(most < 1e-3, "{direction:?}, {smoothing} steps: {most} {worst}");
        assert!(f.iter().all(|&f| f == 3.0));
        // They are tangents, and others than those before.
        assert!(d.iter().zip(&posed.normals).all(|(d, n)| d.dot(*n).abs() < 1e-4));
        let moved = line_angles(&d, &before);
        assert!(moved[moved.len() / 2] > 0.05);
        // One step more or less shows.
        let other = DirectionField::PrincipalCurvature {
            direction,
            smoothing: smoothing + 1,
        };
        let other = directions(&other, Symmetry::Line, turn, &posed, &empty).unwrap();
        let other = line_angles(&d, &other);
        assert!(other[other.len() * 99 / 100] > 3.0 * most);
        app.world_mut().despawn(instance.root);
        update(&mut app);
    }
}

#[test]
fn given_directions_are_carried_along() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    let instance = creature.spawn(app.world_mut(), PLACE, 0.0);
    let vertices = shapes::torus(70, 35, 1.0, 0.4, 0.2, 5).positions;
    let given: Arc<[Vec3]> = vertices.iter().map(|p| Vec3::new(p.y, 1.0, p.z - p.x)).collect();
    let field = DirectionField::Vertices(given);
    let frequencies: Arc<[f32]> = vertices.iter().map(|p| 3.0 + p.x).collect();
    let pattern = (
        field.clone(),
        Symmetry::Vector,
        Frequency::Vertices(frequencies),
        PatternPose::Live,
    );
    app.world_mut().entity_mut(instance.entity).insert(pattern);
    settle(&mut app);
    instance.pose(app.world_mut(), 1.0);
    update(&mut app);
    let (d, f, _) = wave(&app, instance.entity);
    let (rest, posed) = (graph(&app, instance.entity), posed_graph(&app, instance.entity));
    let empty = Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, default());
    let at_rest = directions(&field, Symmetry::Vector, 0.0, &rest, &empty).unwrap();
    let maps = deformations(&rest, &posed);
    let carry = |i: usize| project_tangent((maps[i] * at_rest[i]).normalize_or_zero(), posed.normals[i]);
    let carried: Vec<Vec3> = (0..d.len()).map(carry).collect();
    let apart = farthest(&d, &carried);
    assert!(apart < 1e-3, "{apart}");
    let only_projected: Vec<Vec3> = at_rest
        .iter()
        .zip(&posed.normals)
        .map(|(&d, &n)| project_tangent(d, n))
        .collect();
    assert!(farthest(&d, &only_projected) > 0.5);
    let worst = f
        .iter()
        .zip(&rest.positions)
        .map(|(f, p)| (f - 3.0 - p.x).abs())
        .fold(0.0, f32::max);
    assert!(worst < 1e-5, "{worst}");
}

/// A linear map takes tangents to their images, contour lines too; a gradient goes across these.
#[test]
fn linear_maps_carry_tangents_and_gradients() {
    const HEIGHT: MeshVertexAttribute = MeshVertexAttribute::new("Height", 0x7e57_0001, VertexFormat::Float32);
    let mut app = app();
    let raw = shapes::icosphere(4, 1.0);
    let gradient = Vec3::new(1.0, 0.3, -0.5);
    let heights: Vec<f32> = raw.positions.iter().map(|p| p.dot(gradient)).collect();
    let mesh = to_bevy_mesh(&raw).with_inserted_attribute(HEIGHT, heights);
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let place = Transform::from_scale(Vec3::new(1.0, 3.0, 0.6)).with_rotation(Quat::from_rotation_x(0.8));
    let linear = place.compute_affine().matrix3;
    for quarter_turn in [false, true] {
        let field = DirectionField::Gradient {
            attribute: HEIGHT,
            quarter_turn,
        };
        let spawn = (
            Mesh3d(mesh.clone()),
            field,
            Frequency::Uniform(3.0),
            PatternPose::Live,
            PatternSpace::World,
            place,
        );
        let entity = app.world_mut().spawn(spawn).id();
        settle(&mut app);
        let (d, ..) = wave(&app, entity);
        let posed = posed_graph(&app, entity);
        let at_world = |n: Vec3| {
            let ascent = linear.inverse().transpose() * gradient;
            let across = project_tangent(ascent.normalize(), n);
            if quarter_turn { n.cross(across) } else { across }
        };
        let mut off: Vec<f32> = d
            .iter()
            .zip(&posed.normals)
            .map(|(d, &n)| d.distance(at_world(n)))
            .collect();
        off.sort_unstable_by(f32::total_cmp);
        // A sphere is no plane: edges bend, and the ends of its gradient are singular.
        let most = off[off.len() * 95 / 100];
        assert!(most < 0.05, "{quarter_turn}: {most}");
        app.world_mut().despawn(entity);
        update(&mut app);
    }
}

/// Stripes keep their spacing on a surface that stretches with `Live`, and stretch along with `Rest`.
#[test]
fn live_patterns_keep_their_spacing() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    for (pose, keeps) in [(PatternPose::Live, true), (PatternPose::Rest, false)] {
        let instance = creature.spawn(app.world_mut(), Transform::IDENTITY, 0.0);
        let pattern = (DirectionField::Axis(Dir3::Y), Frequency::Uniform(6.0), pose);
        app.world_mut().entity_mut(instance.entity).insert(pattern);
        settle(&mut app);
        for step in 1..=20 {
            instance.pose(app.world_mut(), step as f32 / 20.0);
            update(&mut app);
        }
        settle(&mut app);
        let drawn = creature.drawn(app.world(), &instance);
        let mut posed: SurfaceGraph = graph(&app, instance.entity);
        posed.update_positions(&drawn).unwrap();
        let (d, f, z) = wave(&app, instance.entity);
        let q = quality(&posed, &d, &f, &z, Symmetry::Vector);
        let cold = solve_cpu(&posed, &d, &f, Symmetry::Vector, &default());
        let best = quality(&posed, &d, &f, &cold.phasors, Symmetry::Vector).energy;
        assert_eq!(q.energy < 1.5 * best, keeps, "{pose:?}: {q:?}, {best}");
        app.world_mut().despawn(instance.root);
        update(&mut app);
    }
}

/// What the pattern reads of a vertex besides where it is goes along.
#[test]
fn ids_stay() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let spawn = (Mesh3d(mesh), DirectionField::Axis(Dir3::Y), PatternPose::Live);
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let record = *app.world().get::<Pattern>(entity).unwrap().record();
    let first = 16 * u64::from(record.geometry_base);
    let words = gpu::read::<u32>(&app, &GEOMETRY_BUFFER, first, 32 * u64::from(record.vertices)).unwrap();
    let ids: Vec<u32> = words.as_chunks::<8>().0.iter().map(|v| v[7]).collect();
    assert_eq!(ids, graph(&app, entity).first_vertices());
}
