//! Meshes that break, come late, lack something or are shared.

use crate::*;

#[test]
fn a_body_without_extent_is_solved_again_when_it_has_one() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let curvature = DirectionField::PrincipalCurvature {
        direction: Principal::Major,
        smoothing: 2,
    };
    for (field, scale) in [
        (DirectionField::Axis(Dir3::Y), Vec3::ZERO),
        (curvature.clone(), Vec3::ZERO),
        (DirectionField::Axis(Dir3::Y), Vec3::new(1.0, 0.0, 1.0)),
        (curvature, Vec3::new(0.0, 1.0, 0.0)),
    ] {
        let entity = app
            .world_mut()
            .spawn((
                Mesh3d(mesh.clone()),
                field,
                Frequency::Uniform(3.0),
                PatternSpace::World,
                Transform::from_scale(scale),
            ))
            .id();
        settle(&mut app);
        let (d, f, z) = wave(&app, entity);
        assert!(d.iter().all(|d| d.is_finite()) && f.iter().all(|f| f.is_finite()));
        assert!(z.iter().all(|z| z.is_finite()), "{scale}");
        app.world_mut().entity_mut(entity).insert((
            DirectionField::Axis(Dir3::Y),
            Symmetry::Vector,
            Transform::IDENTITY,
        ));
        settle(&mut app);
        app.world_mut().trigger(RestartPattern { entity });
        settle(&mut app);
        assert_solved(&app, entity);
        app.world_mut().despawn(entity);
    }
}

#[test]
fn a_live_mesh_may_break_and_mend() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let entity = app.world_mut().spawn((Mesh3d(mesh.clone()), axis())).id();
    settle(&mut app);
    let set = |app: &mut App, y: f32| {
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        let mut mesh = meshes.get_mut(&mesh).expect("the mesh");
        let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION) else {
            panic!("no positions");
        };
        positions[5][1] = y;
    };
    set(&mut app, f32::NAN);
    for _ in 0..3 {
        update(&mut app);
    }
    assert!(
        matches!(
            state(&app, entity),
            PatternState::Failed(PatternError::NotFinite { index: 5, .. })
        ),
        "{:?}",
        state(&app, entity)
    );
    set(&mut app, 1.0);
    for _ in 0..3 {
        update(&mut app);
    }
    settle(&mut app);
    assert_solved(&app, entity);
}

#[test]
fn meshes_may_be_empty_or_late() {
    let mut app = app();
    let empty = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    let no_vertex = empty
        .clone()
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, Vec::<[f32; 3]>::new());
    let [empty, no_vertex] = [empty, no_vertex].map(|mesh| app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh));
    let never = app
        .world()
        .resource::<AssetServer>()
        .load::<Mesh>("no such file.glb#Mesh0/Primitive0");
    let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let [empty, no_vertex, never, late_entity] =
        [empty, no_vertex, never, late.clone()].map(|mesh| app.world_mut().spawn((Mesh3d(mesh), axis())).id());
    for _ in 0..2000 {
        update(&mut app);
        if [empty, no_vertex]
            .iter()
            .all(|&e| state(&app, e) != PatternState::Preparing)
        {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    assert_eq!(state(&app, empty), PatternState::Failed(PatternError::NoPositions));
    assert_eq!(state(&app, no_vertex), PatternState::Failed(PatternError::NoTriangles));
    assert_eq!(state(&app, never), PatternState::Preparing);
    assert_eq!(state(&app, late_entity), PatternState::Preparing);
    app.world_mut().despawn(never);
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .insert(&late, to_bevy_mesh(&shapes::icosphere(2, 1.0)))
        .expect("a reserved place");
    settle(&mut app);
    assert_solved(&app, late_entity);
}

#[test]
fn entities_may_change_within_a_frame() {
    let mut app = app();
    let [mesh, other] = [3, 2].map(|n| add_mesh(&mut app, &shapes::icosphere(n, 1.0)));

    // Gone before anybody saw it; gone while its graph is built.
    let at_once = app.world_mut().spawn((Mesh3d(mesh.clone()), axis())).id();
    app.world_mut().despawn(at_once);
    let large = add_mesh(&mut app, &shapes::icosphere(6, 1.0));
    let soon = app.world_mut().spawn((Mesh3d(large.clone()), axis())).id();
    update(&mut app);
    app.world_mut().despawn(soon);
    update(&mut app);

    // Another mesh while the graph of the first is built.
    let changing = app.world_mut().spawn((Mesh3d(large), axis())).id();
    update(&mut app);
    app.world_mut().entity_mut(changing).insert(Mesh3d(other.clone()));
    settle(&mut app);
    assert_solved(&app, changing);
    assert_eq!(graph(&app, changing).len(), 162);
    // And another one while the first is drawn.
    app.world_mut().entity_mut(changing).insert(Mesh3d(mesh.clone()));
    settle(&mut app);
    assert_solved(&app, changing);
    assert_eq!(graph(&app, changing).len(), 642);

    // The field taken away and given back, at once and by commands.
    app.world_mut()
        .entity_mut(changing)
        .remove::<DirectionField>()
        .insert(DirectionField::Axis(Dir3::Z));
    settle(&mut app);
    assert_solved(&app, changing);
    app.world_mut()
        .commands()
        .entity(changing)
        .remove::<DirectionField>()
        .insert(DirectionField::Axis(Dir3::X));
    app.world_mut().flush();
    settle(&mut app);
    assert_solved(&app, changing);
    assert_eq!(app.world().get::<PatternMesh>(changing).expect("meshes").source, mesh);
    // And for a frame.
    app.world_mut().entity_mut(changing).remove::<DirectionField>();
    update(&mut app);
    app.world_mut()
        .entity_mut(changing)
        .insert(DirectionField::Axis(Dir3::Y));
    settle(&mut app);
    assert_solved(&app, changing);

    app.world_mut().despawn(changing);
    for _ in 0..3 {
        update(&mut app);
    }
    assert_eq!(app.world_mut().query::<&Pattern>().iter(app.world()).count(), 0);
}

#[test]
fn one_mesh_and_one_material_carry_two_fields() {
    let mut app = app();
    small_picture(&mut app);
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let material = striped(&mut app);
    let [first, second] = [Dir3::Y, Dir3::X].map(|axis| {
        app.world_mut()
            .spawn((
                Mesh3d(mesh.clone()),
                material.clone(),
                DirectionField::Axis(axis),
                Frequency::Uniform(3.0),
            ))
            .id()
    });
    settle(&mut app);
    assert_solved(&app, first);
    assert_solved(&app, second);
    let ([a, _, ..], [b, _, ..]) = (&wave(&app, first).0[..], &wave(&app, second).0[..]) else {
        panic!("no directions");
    };
    assert!(a.distance(*b) > 0.1);
    let drawn = |entity| app.world().get::<PatternMesh>(entity).expect("meshes").drawn.clone();
    assert_eq!(drawn(first), drawn(second), "the copy is shared");
    assert!(app.world().resource::<PatternArena>().memory().used > 0);
}

/// Bevy's prepasses and shadows would stop the renderer.
#[test]
fn a_mesh_without_positions_is_not_drawn() {
    let mut app = headless::headless_app(UVec2::splat(32)).expect("a device");
    app.add_plugins(FieldPatternsPlugin);
    let world = app.world_mut();
    world.spawn((
        Camera3d::default(),
        DepthPrepass,
        Msaa::Off,
        Transform::from_xyz(0.0, 0.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    world.spawn(DirectionalLight {
        shadow_maps_enabled: true,
        ..default()
    });
    let flat = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![Vec3::Z; 3]);
    let flat = Mesh3d(world.resource_mut::<Assets<Mesh>>().add(flat));
    let cells = world
        .resource_mut::<Assets<CellMaterial>>()
        .add(CellMaterial::default());
    let hatch = world
        .resource_mut::<Assets<HatchMaterial>>()
        .add(HatchMaterial::default());
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let material = striped(&mut app);
    let world = app.world_mut();
    let bad = [
        world.spawn((flat.clone(), axis(), material.clone())).id(),
        world.spawn((flat.clone(), axis(), MeshMaterial3d(hatch))).id(),
    ];
    let sampled = world
        .spawn((flat, AnisotropicSamples::default(), MeshMaterial3d(cells)))
        .id();
    let good = world.spawn((Mesh3d(mesh), axis(), material)).id();
    settle(&mut app);
    assert_solved(&app, good);
    for entity in bad {
        assert_eq!(state(&app, entity), PatternState::Failed(PatternError::NoPositions));
    }
    assert_eq!(
        app.world().get::<SamplingState>(sampled),
        Some(&SamplingState::Failed(PatternError::NoPositions))
    );
    let picture = headless::picture(&mut app).expect("a picture");
    assert!(!headless::is_blank(&picture), "the sphere is drawn");
}
