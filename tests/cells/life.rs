//! What entities own and are told: memory, errors, changes.

use super::*;
use bevy_field_patterns::{
    cells::{CellMemory, SampleValues, layout::CELL_BUFFER},
    prelude::PatternError,
    surface::PatternMesh,
};
use sets::triangulated;

fn labels() -> CellMaterial {
    CellMaterial {
        base: StandardMaterial::default(),
        extension: Cells {
            debug: CellDebug::Label,
            ..default()
        },
    }
}

/// The label under the middle of a pixel of the square-on view.
fn at(picture: &Picture, x: usize, y: usize) -> usize {
    let p = (255.0 * picture.at(x, y).truncate()).round();
    p.x as usize + 256 * p.y as usize
}

fn place(x: usize, y: usize, width: usize) -> Vec3 {
    let to = |n: usize| (n as f32 + 0.5) / width as f32 * 2.0 - 1.0;
    Vec3::new(to(x), -to(y), 0.0)
}

/// Whether the picture shows a set; at most one pixel in fifty may be on the line.
fn shows(picture: &Picture, set: &SampleSet) -> bool {
    let width = picture.width;
    let wrong = (0..width * width)
        .filter(|k| at(picture, k % width, k / width) != nearest(set, place(k % width, k / width, width)))
        .count();
    wrong * 50 <= width * width
}

#[test]
fn entities_own_what_they_show() {
    let stage = &mut cell_stage();
    let before = used(stage);
    sets_are_shown_shared_and_replaced(stage);
    mistakes_are_told(stage);
    changes_wait_for_their_mesh(stage);
    removal_restores(stage);
    assert_eq!(used(stage), before, "all memory is given back");
    many_entities_grow_the_buffers(stage);
    planar_sets_have_meshes(stage);
    stage.app.update();
    assert_eq!(used(stage), before, "all memory is given back");
}

/// Two entities share a material and a mesh; one's set is replaced, in place where it fits.
fn sets_are_shown_shared_and_replaced(stage: &mut Stage) {
    let (one, mesh) = on_square(60, FIELDS[1].1, 24);
    let mut other = sets::planar(60, FIELDS[0].1, 200, 2, 99);
    sets::seed(&mut other, &mesh.positions, &mesh.triangles);
    let mut larger = sets::planar(200, FIELDS[0].1, 200, 2, 5);
    sets::seed(&mut larger, &mesh.positions, &mesh.triangles);
    let mesh = stage.add(to_bevy_mesh(&mesh));
    let material = stage.add(labels());
    let first = spawn(stage, &mesh, &one, &material);
    let second = spawn(stage, &mesh, &other, &material);
    stage
        .app
        .world_mut()
        .entity_mut(second)
        .insert(Transform::from_xyz(10.0, 0.0, 0.0));
    let view = |x: f32| Lens {
        from: Vec3::new(x, 0.0, 3.0),
        to: Vec3::new(x, 0.0, 0.0),
        ..square_on(48)
    };
    let (left, right) = (stage.picture(view(0.0)), stage.picture(view(10.0)));
    assert!(shows(&left, &one) && shows(&right, &other), "each shows its own set");
    assert!(!shows(&left, &other), "the sets differ");

    let tag = stage.app.world().get::<MeshTag>(first).unwrap().0;
    let sites = stage.app.world().get::<CellMemory>(first).unwrap().record().site_base;
    stage.app.world_mut().entity_mut(first).insert(other.clone());
    assert!(shows(&stage.picture(view(0.0)), &other), "the picture follows the set");
    let memory = stage.app.world().get::<CellMemory>(first).unwrap();
    assert_eq!(
        (memory.tag(), memory.record().site_base),
        (tag, sites),
        "written in place"
    );

    stage.app.world_mut().entity_mut(first).insert(larger.clone());
    assert!(shows(&stage.picture(view(0.0)), &larger), "a larger set");
    assert_eq!(stage.app.world().get::<MeshTag>(first).unwrap().0, tag);
    assert!(shows(&stage.picture(view(10.0)), &other), "the neighbour is unharmed");

    stage.app.world_mut().entity_mut(first).insert(SampleSet::default());
    let base = stage.picture(view(0.0));
    assert!(base.contrast() < 1e-3, "an empty set shows the base");
    stage.app.world_mut().entity_mut(first).insert(one.clone());
    assert!(shows(&stage.picture(view(0.0)), &one), "and cells again");
    stage.clear([first, second]);
}

/// Wrong lists, wrong meshes and taken tags are errors, and cells are back once they are mended.
fn mistakes_are_told(stage: &mut Stage) {
    let (set, mesh) = on_square(60, FIELDS[0].1, 24);
    let mesh = stage.add(to_bevy_mesh(&mesh));
    let material = stage.add(labels());
    let mut broken: Vec<(SampleSet, &str)> = vec![];
    let mut with = |name, change: fn(&mut SampleSet)| {
        let mut set = set.clone();
        change(&mut set);
        broken.push((set, name));
    };
    with("fewer seeds", |set| set.seeds.truncate(5));
    with("a seed that is no sample", |set| set.seeds[3][1] = 60);
    with("a neighbour that is no sample", |set| set.neighbors[3] = 1 << 30);
    with("offsets that fall", |set| set.neighbor_offsets[3] = 100_000);
    with("fewer metrics", |set| set.metrics.truncate(59));
    with("a position that is none", |set| set.positions[7].y = f32::NAN);
    with("a metric that is none", |set| set.metrics[7].m11 = -1.0);
    let entity = spawn(stage, &mesh, &set, &material);
    for (bad, name) in broken {
        stage.app.world_mut().entity_mut(entity).insert(bad);
        stage.app.update();
        stage.app.update();
        assert!(
            matches!(state(stage, entity), CellState::Failed(_)),
            "{name}: {:?}",
            state(stage, entity)
        );
        let picture = stage.picture(square_on(24));
        assert!(picture.contrast() < 1e-3, "{name}: the base is drawn");
        stage.app.world_mut().entity_mut(entity).insert(set.clone());
        assert!(shows(&stage.picture(square_on(24)), &set), "{name}: mended");
        assert_eq!(state(stage, entity), CellState::Ready);
    }
    let values = SampleValues(vec![LinearRgba::RED; 59]);
    stage.app.world_mut().entity_mut(entity).insert(values);
    settle(stage);
    assert!(matches!(
        state(stage, entity),
        CellState::Failed(PatternError::SampleLists {
            found: 59,
            expected: 60,
            ..
        })
    ));
    stage.app.world_mut().entity_mut(entity).remove::<SampleValues>();
    assert!(shows(&stage.picture(square_on(24)), &set), "without values");

    stage.app.world_mut().entity_mut(entity).insert(MeshTag(5));
    settle(stage);
    assert_eq!(state(stage, entity), CellState::Failed(PatternError::MeshTagTaken));
    stage.app.world_mut().entity_mut(entity).remove::<MeshTag>();
    assert!(shows(&stage.picture(square_on(24)), &set), "with its own tag again");

    stage
        .app
        .world_mut()
        .entity_mut(entity)
        .insert(DirectionField::Axis(Dir3::X));
    settle(stage);
    assert_eq!(state(stage, entity), CellState::Failed(PatternError::TwoPatterns));
    stage.clear([entity]);

    let tagged = stage
        .app
        .world_mut()
        .spawn((
            Mesh3d(mesh.clone()),
            MeshMaterial3d(material.clone()),
            MeshTag(77),
            set.clone(),
        ))
        .id();
    settle(stage);
    assert_eq!(state(stage, tagged), CellState::Failed(PatternError::MeshTagTaken));
    assert!(
        stage.picture(square_on(24)).contrast() < 1e-3,
        "somebody else's tag is no record"
    );
    stage.clear([tagged]);
}

/// What changes while nothing can be drawn is seen later, and no mesh shows the cells of another one.
fn changes_wait_for_their_mesh(stage: &mut Stage) {
    let (one, mesh) = on_square(60, FIELDS[0].1, 24);
    let mut two = sets::planar(60, FIELDS[1].1, 200, 2, 99);
    sets::seed(&mut two, &mesh.positions, &mesh.triangles);
    let (three, coarse) = on_square(60, FIELDS[1].1, 12);
    let (mesh, coarse) = (stage.add(to_bevy_mesh(&mesh)), stage.add(to_bevy_mesh(&coarse)));
    let material = stage.add(labels());
    let parts = (MeshMaterial3d(material), one.clone());
    let entity = stage.app.world_mut().spawn(parts).id();
    settle(stage);
    assert_eq!(state(stage, entity), CellState::Failed(PatternError::NoMesh));
    stage.app.world_mut().entity_mut(entity).insert(Mesh3d(mesh));
    assert!(shows(&stage.picture(square_on(24)), &one), "a mesh that comes later");

    stage.app.world_mut().entity_mut(entity).insert(MeshTag(5));
    settle(stage);
    stage.app.world_mut().entity_mut(entity).insert(two.clone());
    settle(stage);
    stage.app.world_mut().entity_mut(entity).remove::<MeshTag>();
    assert!(shows(&stage.picture(square_on(24)), &two), "a set of bad times");

    // Another mesh, which is being sampled.
    let swap = (Mesh3d(coarse), SamplingState::Sampling(0.5));
    stage.app.world_mut().entity_mut(entity).insert(swap);
    for _ in 0..30 {
        stage.app.update();
        assert_eq!(state(stage, entity), CellState::Preparing);
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    assert!(stage.picture(square_on(24)).contrast() < 1e-3, "the base meanwhile");
    let sampled = (three.clone(), SamplingState::Ready);
    stage.app.world_mut().entity_mut(entity).insert(sampled);
    assert!(shows(&stage.picture(square_on(24)), &three), "the other mesh's own");
    stage.clear([entity]);
}

/// Without samples, or without the material, the entity is as it was.
fn removal_restores(stage: &mut Stage) {
    let (set, mesh) = on_square(60, FIELDS[0].1, 24);
    let mesh = stage.add(to_bevy_mesh(&mesh));
    let material = stage.add(labels());
    let removals: [fn(&mut EntityWorldMut); 2] = [
        |entity| {
            entity.remove::<SampleSet>();
        },
        |entity| {
            entity.remove::<MeshMaterial3d<CellMaterial>>();
        },
    ];
    for remove in removals {
        let entity = spawn(stage, &mesh, &set, &material);
        assert_ne!(stage.app.world().get::<Mesh3d>(entity).unwrap().0, mesh);
        // A clone has cells of its own.
        let clone = stage.app.world_mut().entity_mut(entity).clone_and_spawn();
        settle(stage);
        assert_eq!(state(stage, clone), CellState::Ready);
        let tags = [entity, clone].map(|e| stage.app.world().get::<MeshTag>(e).unwrap().0);
        assert_ne!(tags[0], tags[1]);
        stage.clear([clone]);
        remove(&mut stage.app.world_mut().entity_mut(entity));
        stage.app.update();
        let entity_ref = stage.app.world().entity(entity);
        assert_eq!(entity_ref.get::<Mesh3d>().unwrap().0, mesh);
        assert!(!entity_ref.contains::<MeshTag>() && !entity_ref.contains::<PatternMesh>());
        assert!(!entity_ref.contains::<CellMemory>() && !entity_ref.contains::<CellState>());
        stage.clear([entity]);
    }
}

/// The buffers grow while an entity is drawn, which stays right; what is despawned makes room.
fn many_entities_grow_the_buffers(stage: &mut Stage) {
    let (set, mesh) = on_square(60, FIELDS[1].1, 24);
    let mesh = stage.add(to_bevy_mesh(&mesh));
    let material = stage.add(labels());
    let first = spawn(stage, &mesh, &set, &material);
    let each = used(stage);
    let size = |stage: &Stage| stage.app.world().resource::<CellArena>().memory().allocated;
    let small = size(stage);
    let many: Vec<Entity> = (1..300)
        .map(|k| {
            let at = Transform::from_xyz(3.0 * k as f32, 0.0, 0.0);
            let parts = (Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), set.clone(), at);
            stage.app.world_mut().spawn(parts).id()
        })
        .collect();
    settle(stage);
    assert_eq!(used(stage), 300 * each);
    assert!(size(stage) > 2 * small, "the buffers have grown");
    assert!(shows(&stage.picture(square_on(48)), &set), "the first is unharmed");
    let last = Lens {
        from: Vec3::new(897.0, 0.0, 3.0),
        to: Vec3::new(897.0, 0.0, 0.0),
        ..square_on(48)
    };
    assert!(shows(&stage.picture(last), &set), "the last is there");
    let words = common::gpu::read::<u32>(&stage.app, &CELL_BUFFER, 0, 64).unwrap();
    assert_eq!(words[0], 0, "the record of no cells");
    let large = size(stage);
    stage.clear(many);
    stage.app.update();
    assert_eq!(used(stage), each);
    let again: Vec<Entity> = (0..200)
        .map(|_| {
            let parts = (Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), set.clone());
            stage.app.world_mut().spawn(parts).id()
        })
        .collect();
    settle(stage);
    assert_eq!(size(stage), large, "ranges are used again");
    stage.clear(again);
    stage.clear([first]);
}

/// A planar set is its own mesh: in 2D by the plugin, in space by hand.
fn planar_sets_have_meshes(stage: &mut Stage) {
    let set = triangulated(80, 3);
    let material = stage.add(labels());
    let mesh = stage.add(planar_mesh(&set));
    let entity = spawn(stage, &mesh, &set, &material);
    assert_eq!(state(stage, entity), CellState::Ready);
    assert!(shows(&stage.picture(square_on(64)), &set));
    stage.clear([entity]);

    let material = stage.add(CellMaterial2d {
        cells: labels().extension,
        ..default()
    });
    let parts = (MeshMaterial2d(material), set.clone());
    let entity = stage.app.world_mut().spawn(parts).id();
    settle(stage);
    let picture = picture_2d(stage, 64);
    picture.save("planar labels");
    assert!(shows(&picture, &set), "in 2D");
    let other = triangulated(150, 8);
    stage.app.world_mut().entity_mut(entity).insert(other.clone());
    assert!(shows(&picture_2d(stage, 64), &other), "another set");
    stage.app.world_mut().entity_mut(entity).remove::<SampleSet>();
    stage.app.update();
    assert_eq!(stage.app.world().get::<Mesh2d>(entity).unwrap().0, Handle::default());
    stage.clear([entity]);
}
