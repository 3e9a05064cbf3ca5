//! Scenes of patterned meshes, what becomes of their materials, and the focus that an entity carries along.

mod common;

use bevy::{math::Affine3A, prelude::*, world_serialization::WorldAssetRoot};
use bevy_field_patterns::{material::FocusShape, prelude::*, wave::SolverCounters};
use common::{add_mesh, app, gltf, graph, settle, shapes, update, wave};
use std::f32::consts::FRAC_PI_2;

type Plain = MeshMaterial3d<StandardMaterial>;
type Striped = MeshMaterial3d<StripeMaterial>;

fn add_base(app: &mut App, color: Color) -> Handle<StandardMaterial> {
    app.world_mut().resource_mut::<Assets<StandardMaterial>>().add(color)
}

fn striped(app: &App, entity: Entity) -> &StripeMaterial {
    let handle = &app.world().get::<Striped>(entity).expect("a striped material").0;
    app.world()
        .resource::<Assets<StripeMaterial>>()
        .get(handle)
        .expect("a material")
}

fn axis_scene() -> PatternScene {
    PatternScene {
        field: DirectionField::Axis(Dir3::Y),
        frequency: Frequency::Uniform(3.0),
        ..default()
    }
}

#[test]
fn scenes_dress_their_meshes_whenever_they_come() {
    let mut app = app();
    let (white, red) = (
        add_base(&mut app, Color::WHITE),
        add_base(&mut app, Color::srgb(1.0, 0.0, 0.0)),
    );
    let ball = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let root = app
        .world_mut()
        .spawn((Transform::default(), Visibility::default(), axis_scene()))
        .id();
    let node = app
        .world_mut()
        .spawn((Transform::default(), Visibility::default(), ChildOf(root)))
        .id();
    let mesh = |app: &mut App, parent: Entity, base: &Handle<StandardMaterial>| {
        let looks = (Mesh3d(ball.clone()), MeshMaterial3d(base.clone()), Transform::default());
        app.world_mut().spawn((looks, ChildOf(parent))).id()
    };
    let [a, b, c] = [(node, &white), (root, &white), (node, &red)].map(|(parent, base)| mesh(&mut app, parent, base));
    let stranger = app
        .world_mut()
        .spawn((Mesh3d(ball.clone()), MeshMaterial3d(white.clone())))
        .id();
    settle(&mut app);

    let late = mesh(&mut app, node, &red);
    settle(&mut app);
    for part in [a, b, c, late] {
        let world = app.world();
        assert_eq!(world.get::<PatternState>(part), Some(&PatternState::Converged));
        assert_eq!(world.get::<Frequency>(part), Some(&Frequency::Uniform(3.0)));
        assert!(world.get::<Plain>(part).is_none());
    }
    let handle = |app: &App, entity: Entity| app.world().get::<Striped>(entity).map(|material| material.0.clone());
    assert_eq!(handle(&app, a), handle(&app, b), "one base, one striped material");
    assert_eq!(handle(&app, c), handle(&app, late));
    assert_ne!(handle(&app, a), handle(&app, c));
    assert_eq!(striped(&app, c).base.base_color, Color::srgb(1.0, 0.0, 0.0));
    assert!(app.world().get::<Plain>(stranger).is_some() && app.world().get::<DirectionField>(stranger).is_none());

    // A mesh that leaves the scene is as it was; a base that changes is followed.
    app.world_mut().entity_mut(b).remove::<ChildOf>();
    if let Some(mut red) = app.world_mut().resource_mut::<Assets<StandardMaterial>>().get_mut(&red) {
        red.perceptual_roughness = 0.125;
    }
    update(&mut app);
    update(&mut app);
    assert_eq!(app.world().get::<Plain>(b).map(|plain| &plain.0), Some(&white));
    assert_eq!(striped(&app, c).base.perceptual_roughness, 0.125);

    app.world_mut().entity_mut(root).remove::<PatternScene>();
    update(&mut app);
    update(&mut app);
    for (part, base) in [(a, &white), (c, &red), (late, &red)] {
        let world = app.world();
        assert_eq!(world.get::<Plain>(part).map(|plain| &plain.0), Some(base));
        assert_eq!(world.get::<Mesh3d>(part).map(|mesh| &mesh.0), Some(&ball));
        let is_bare = world.get::<Striped>(part).is_none()
            && world.get::<DirectionField>(part).is_none()
            && world.get::<Frequency>(part).is_none()
            && world.get::<PatternScenePart>(part).is_none();
        assert!(is_bare);
    }
}

#[test]
fn a_style_is_changed_without_solving_and_a_field_with_it() {
    let mut app = app();
    let base = add_base(&mut app, Color::WHITE);
    let ball = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    // The root may be the mesh itself.
    let root = app
        .world_mut()
        .spawn((Mesh3d(ball), MeshMaterial3d(base), Transform::default(), axis_scene()))
        .id();
    settle(&mut app);
    update(&mut app);

    let scene = |app: &mut App, change: fn(&mut PatternScene)| {
        change(&mut app.world_mut().get_mut::<PatternScene>(root).expect("a scene"));
    };
    scene(&mut app, |scene| scene.style.duty = 0.25);
    update(&mut app);
    assert_eq!(striped(&app, root).extension.duty, 0.25);
    assert_eq!(
        app.world().resource::<SolverCounters>().dispatches(),
        0,
        "a style is no input"
    );

    scene(&mut app, |scene| {
        scene.frequency = Frequency::Uniform(5.0);
        scene.symmetry = Some(Symmetry::Line);
        scene.field = DirectionField::Axis(Dir3::X);
    });
    settle(&mut app);
    let (directions, frequencies, _) = wave(&app, root);
    assert!(frequencies.iter().all(|&f| f == 5.0));
    let normals = graph(&app, root).normals;
    assert!(
        directions
            .iter()
            .zip(normals)
            .all(|(d, n)| d.dot(n.cross(Vec3::X)).abs() < 1e-4)
    );
    assert_eq!(app.world().get::<Symmetry>(root), Some(&Symmetry::Line));
    scene(&mut app, |scene| scene.symmetry = None);
    settle(&mut app);
    assert_eq!(app.world().get::<Symmetry>(root), None);
}

/// A scene fills in what a mesh lacks, and takes back what it gave.
#[test]
fn what_a_mesh_has_of_its_own_it_keeps() {
    let mut app = app();
    let base = add_base(&mut app, Color::WHITE);
    let ball = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let scene = PatternScene {
        turn: 0.5,
        ..axis_scene()
    };
    let root = app
        .world_mut()
        .spawn((Transform::default(), Visibility::default(), scene))
        .id();
    let looks = || (Mesh3d(ball.clone()), MeshMaterial3d(base.clone()), ChildOf(root));
    let own_field = DirectionField::Axis(Dir3::X);
    let own = (own_field.clone(), Frequency::Uniform(7.0), Symmetry::Line);
    let own = app.world_mut().spawn((looks(), own)).id();
    let own_frequency = app.world_mut().spawn((looks(), Frequency::Uniform(5.0))).id();
    let given = app.world_mut().spawn(looks()).id();
    let changed = app.world_mut().spawn(looks()).id();
    settle(&mut app);
    // What a user sets later is the user's as well.
    app.world_mut().entity_mut(changed).insert(Frequency::Uniform(9.0));
    settle(&mut app);
    let frequency = |app: &App, entity| match app.world().get::<Frequency>(entity) {
        Some(Frequency::Uniform(f)) => *f,
        other => panic!("{other:?}"),
    };
    let is_right = |app: &App, of_scene: f32| {
        let world = app.world();
        assert_eq!(world.get::<DirectionField>(own), Some(&own_field));
        assert_eq!(world.get::<Symmetry>(own), Some(&Symmetry::Line));
        assert_eq!(world.get::<DirectionField>(given), Some(&DirectionField::Axis(Dir3::Y)));
        assert_eq!(world.get::<FieldTurn>(given), Some(&FieldTurn(0.5)));
        let found = [own, own_frequency, given, changed].map(|part| frequency(app, part));
        assert_eq!(found, [7.0, 5.0, of_scene, 9.0]);
    };
    is_right(&app, 3.0);
    app.world_mut()
        .get_mut::<PatternScene>(root)
        .expect("a scene")
        .frequency = Frequency::Uniform(4.0);
    settle(&mut app);
    is_right(&app, 4.0);

    app.world_mut().entity_mut(root).remove::<PatternScene>();
    settle(&mut app);
    let world = app.world();
    assert_eq!(world.get::<DirectionField>(own), Some(&own_field));
    assert_eq!(world.get::<PatternState>(own), Some(&PatternState::Converged));
    assert_eq!(world.get::<FieldTurn>(own), None);
    for (part, kept) in [
        (own, Some(7.0)),
        (own_frequency, Some(5.0)),
        (given, None),
        (changed, Some(9.0)),
    ] {
        let kept = kept.map(Frequency::Uniform);
        assert_eq!(world.get::<Frequency>(part), kept.as_ref());
        assert_eq!(world.get::<DirectionField>(part).is_some(), part == own);
        assert!(world.get::<Plain>(part).is_some() && world.get::<Striped>(part).is_none());
    }
}

/// A square of two triangles with the attribute `_FIELD`, all (1, 2, 0), in a node that is scaled by 2.
fn write_gltf(path: &std::path::Path) {
    let positions: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let field = [[1.0_f32, 2.0, 0.0]; 4];
    let indices: [u16; 6] = [0, 1, 2, 0, 2, 3];
    let mut data: Vec<u8> = bytemuck::cast_slice(&positions).to_vec();
    data.extend_from_slice(bytemuck::cast_slice(&field));
    data.extend_from_slice(bytemuck::cast_slice(&indices));
    let buffer = path.with_extension("bin");
    std::fs::write(&buffer, &data).expect("a file");
    let gltf = serde_json::json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "scale": [2.0, 2.0, 2.0] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [0.0, 1.0, 0.0, 1.0] } }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "_FIELD": 1 }, "indices": 2, "material": 0,
        }] }],
        "buffers": [{ "uri": buffer.file_name().and_then(|name| name.to_str()), "byteLength": data.len() }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 12 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
    });
    std::fs::write(path, gltf.to_string()).expect("a file");
}

#[test]
fn a_gltf_file_brings_its_field() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    let path = folder.join("field.gltf");
    write_gltf(&path);

    let mut app = app();
    gltf::register_scene_types(&mut app);
    let scene = app
        .world()
        .resource::<AssetServer>()
        .load(GltfAssetLabel::Scene(0).from_asset(path));
    let style = PatternScene {
        field: DirectionField::Attribute(gltf::FIELD_ATTRIBUTE),
        space: PatternSpace::World,
        ..axis_scene()
    };
    app.world_mut().spawn((WorldAssetRoot(scene), style));
    let mut patterned = app.world_mut().query_filtered::<Entity, With<PatternScenePart>>();
    for _ in 0..500 {
        update(&mut app);
        if patterned.iter(app.world()).next().is_some() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    settle(&mut app);
    let part = patterned.single(app.world()).expect("one mesh");
    assert_eq!(app.world().get::<PatternState>(part), Some(&PatternState::Converged));
    assert_eq!(striped(&app, part).base.base_color, Color::linear_rgb(0.0, 1.0, 0.0));
    let (directions, ..) = wave(&app, part);
    let expected = Vec3::new(1.0, 2.0, 0.0).normalize();
    assert_eq!(directions.len(), 4);
    assert!(directions.iter().all(|d| d.distance(expected) < 1e-5), "{directions:?}");
}

/// A cut-out needs a base with a mask, for as long as it is one.
#[test]
fn a_cut_out_gives_the_mask_back() {
    let mut app = app();
    let add = |app: &mut App, alpha_mode: AlphaMode| {
        let base = StandardMaterial {
            alpha_mode,
            ..default()
        };
        let extension = Stripes {
            cutout: true,
            ..default()
        };
        app.world_mut()
            .resource_mut::<Assets<StripeMaterial>>()
            .add(StripeMaterial { base, extension })
    };
    let modes = [
        AlphaMode::Opaque,
        AlphaMode::Mask(0.5),
        AlphaMode::Blend,
        AlphaMode::Opaque,
    ];
    let materials = modes.map(|mode| add(&mut app, mode));
    let found = |app: &App| {
        let all = app.world().resource::<Assets<StripeMaterial>>();
        materials
            .clone()
            .map(|handle| all.get(&handle).expect("a material").base.alpha_mode)
    };
    let frames = |app: &mut App| (0..3).for_each(|_| update(app));
    frames(&mut app);
    let mask = AlphaMode::Mask(0.5);
    assert_eq!(found(&app), [mask, mask, AlphaMode::Blend, mask]);
    // The last one's mask is the user's own from now on.
    let change = |app: &mut App, which: usize, change: fn(&mut StripeMaterial)| {
        let mut all = app.world_mut().resource_mut::<Assets<StripeMaterial>>();
        change(&mut all.get_mut(&materials[which]).expect("a material"));
    };
    change(&mut app, 3, |material| material.base.alpha_mode = AlphaMode::Mask(0.25));
    frames(&mut app);
    for which in 0..4 {
        change(&mut app, which, |material| material.extension.cutout = false);
    }
    frames(&mut app);
    let own = AlphaMode::Mask(0.25);
    assert_eq!(found(&app), [AlphaMode::Opaque, mask, AlphaMode::Blend, own]);
    change(&mut app, 0, |material| material.extension.cutout = true);
    frames(&mut app);
    assert_eq!(found(&app)[0], mask);
}

#[test]
fn a_focus_follows_its_entity() {
    let mut app = app();
    let material = app
        .world_mut()
        .resource_mut::<Assets<StripeMaterial>>()
        .add(StripeMaterial {
            base: StandardMaterial::default(),
            extension: Stripes {
                focus: Focus {
                    border: 0.5,
                    invert: true,
                    ..default()
                },
                ..default()
            },
        });
    let parent = app.world_mut().spawn(Transform::from_scale(Vec3::splat(2.0))).id();
    let source = FocusSource::sphere(0.5, [material.clone()]);
    let ball = app
        .world_mut()
        .spawn((source, Transform::from_xyz(1.0, 0.0, 0.0), ChildOf(parent)))
        .id();
    let focus = |app: &App| {
        app.world()
            .resource::<Assets<StripeMaterial>>()
            .get(&material)
            .expect("a material")
            .extension
            .focus
    };
    update(&mut app);
    let expected = Focus {
        border: 0.5,
        invert: true,
        ..Focus::sphere(Vec3::new(2.0, 0.0, 0.0), 1.0)
    };
    assert_eq!(focus(&app), expected, "the material's own border and inversion stay");

    app.world_mut().entity_mut(ball).insert((
        FocusSource::half_space([material.clone()]),
        Transform::from_xyz(0.0, 0.0, 3.0).with_rotation(Quat::from_rotation_x(FRAC_PI_2)),
    ));
    update(&mut app);
    // It looks up from (0, 0, 6).
    let FocusShape::HalfSpace { normal, distance } = focus(&app).shape else {
        panic!("no half-space");
    };
    assert!(normal.distance(Vec3::Y) < 1e-5 && distance.abs() < 1e-5);
}

#[test]
fn a_focus_reaches_the_materials_of_a_scene() {
    let mut app = app();
    let base = add_base(&mut app, Color::WHITE);
    let ball = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let root = app
        .world_mut()
        .spawn((Mesh3d(ball), MeshMaterial3d(base), Transform::default(), axis_scene()))
        .id();
    let source = FocusSource::<Stripes> {
        scenes: vec![root],
        ..FocusSource::sphere(0.5, [])
    };
    let lamp = app.world_mut().spawn(source).id();
    settle(&mut app);
    let center = |app: &App| match striped(app, root).extension.focus.shape {
        FocusShape::Sphere { center, radius } => (center, radius),
        other => panic!("{other:?}"),
    };
    assert_eq!(center(&app), (Vec3::ZERO, 0.5));
    app.world_mut()
        .entity_mut(lamp)
        .insert(Transform::from_xyz(1.0, 2.0, 0.0));
    update(&mut app);
    assert!(center(&app).0.distance(Vec3::new(1.0, 2.0, 0.0)) < 1e-6);
    let dispatches = app.world().resource::<SolverCounters>().dispatches();
    assert_eq!(dispatches, 0, "a focus is no input");
}

/// A point is in the shape carried along exactly when it came from inside the shape.
#[test]
fn half_spaces_go_along_with_any_map() {
    let shape = FocusShape::HalfSpace {
        normal: Dir3::new(Vec3::new(1.0, 2.0, -0.5)).expect("a direction"),
        distance: 0.3,
    };
    let weight = |shape, point| Focus { shape, ..default() }.weight(point);
    // Rotation, a mirror, different scales.
    let map = Affine3A::from_scale_rotation_translation(
        Vec3::new(-2.0, 0.5, 3.0),
        Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-1.1),
        Vec3::new(4.0, -1.0, 2.0),
    );
    for k in 0..100 {
        let point = Vec3::new((k % 5) as f32, (k / 5 % 5) as f32, (k / 25) as f32) - 2.1;
        assert_eq!(
            weight(shape, point),
            weight(shape.transformed(&map), map.transform_point3(point))
        );
    }
}
