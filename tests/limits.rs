//! Where patterns cannot be: small devices, meshes that are gone, no renderer, nonsense for geometry, entities that come
//! and go within a frame. Never a panic, and the rest of the app goes on.

mod common;

use bevy::{
    app::PluginsState,
    asset::RenderAssetUsages,
    core_pipeline::prepass::DepthPrepass,
    mesh::{MeshPlugin, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
    render::{
        RenderPlugin,
        pipelined_rendering::PipelinedRenderingPlugin,
        settings::{WgpuLimits, WgpuSettings},
    },
    window::ExitCondition,
    winit::WinitPlugin,
};
use bevy_field_patterns::{
    field::{Principal, directions},
    prelude::*,
    surface::SurfaceGraph,
    wave::{Pattern, PatternArena, Quality, quality, solver::solve_cpu},
};
use common::{add_mesh, app, graph, headless, mesh_file::to_bevy_mesh, settle, shapes, update, wave};

fn axis() -> (DirectionField, Frequency) {
    (DirectionField::Axis(Dir3::Y), Frequency::Uniform(3.0))
}

fn state(app: &App, entity: Entity) -> PatternState {
    app.world().get::<PatternState>(entity).expect("a state").clone()
}

fn measured(app: &App, entity: Entity) -> Quality {
    let (d, f, z) = wave(app, entity);
    assert!(z.iter().all(|z| z.is_finite()), "phasors are finite");
    quality(&graph(app, entity), &d, &f, &z, Symmetry::Vector)
}

/// The pattern is drawn, at rest, and good.
fn assert_solved(app: &App, entity: Entity) {
    assert_eq!(state(app, entity), PatternState::Converged);
    let quality = measured(app, entity);
    assert!(quality.energy < 0.05, "{quality:?}");
}

/// An app on a device with less than it could offer.
fn small_app(limits: WgpuLimits) -> App {
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            .set(RenderPlugin {
                render_creation: WgpuSettings {
                    constrained_limits: Some(limits),
                    ..default()
                }
                .into(),
                synchronous_pipeline_compilation: true,
                ..default()
            })
            .disable::<WinitPlugin>()
            .disable::<PipelinedRenderingPlugin>(),
        FieldPatternsPlugin,
    ));
    app
}

fn striped(app: &mut App) -> MeshMaterial3d<StripeMaterial> {
    MeshMaterial3d(
        app.world_mut()
            .resource_mut::<Assets<StripeMaterial>>()
            .add(StripeMaterial::default()),
    )
}

fn small_picture(app: &mut App) {
    let image = Image::new_target_texture(
        16,
        16,
        bevy::render::render_resource::TextureFormat::Rgba8UnormSrgb,
        None,
    );
    let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    app.world_mut().spawn((
        Camera3d::default(),
        bevy::camera::RenderTarget::Image(target.into()),
        Msaa::Off,
        Transform::from_xyz(0.0, 0.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

/// Bevy itself does not run with few storage buffers, so this is a limit that only the solver minds.
#[test]
fn a_missing_limit_is_named_and_the_base_is_drawn() {
    let mut app = small_app(WgpuLimits {
        max_compute_workgroups_per_dimension: 16_384,
        ..default()
    });
    small_picture(&mut app);
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let material = striped(&mut app);
    let entity = app.world_mut().spawn((Mesh3d(mesh), axis(), material)).id();
    settle(&mut app);
    let PatternState::Failed(PatternError::GpuLimit { limit, found, needed }) = state(&app, entity) else {
        panic!("{:?}", state(&app, entity));
    };
    assert_eq!((limit, found), ("max_compute_workgroups_per_dimension", 16_384));
    assert!(needed > found);
    for _ in 0..5 {
        update(&mut app);
    }
}

#[test]
fn a_full_arena_is_an_error_of_one_entity() {
    let mut app = small_app(WgpuLimits {
        max_storage_buffer_binding_size: 1 << 20,
        ..default()
    });
    small_picture(&mut app);
    let [small, large] = [3, 6].map(|n| add_mesh(&mut app, &shapes::icosphere(n, 1.0)));
    let material = striped(&mut app);
    let [small, large] =
        [small, large].map(|mesh| app.world_mut().spawn((Mesh3d(mesh), axis(), material.clone())).id());
    settle(&mut app);
    let PatternState::Failed(PatternError::GpuLimit { limit, found, needed }) = state(&app, large) else {
        panic!("{:?}", state(&app, large));
    };
    assert_eq!((limit, found), ("max_storage_buffer_binding_size", 1 << 20));
    assert!(needed > found);
    assert_solved(&app, small);
    // A mesh that fits mends it.
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    app.world_mut().entity_mut(large).insert(Mesh3d(mesh));
    settle(&mut app);
    assert_solved(&app, large);
}

#[test]
fn data_of_the_render_world_can_be_used_once() {
    let mut app = app();
    let render_only = |n| {
        let mut mesh = to_bevy_mesh(&shapes::icosphere(n, 1.0));
        mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
        mesh
    };
    let add = |app: &mut App, n| app.world_mut().resource_mut::<Assets<Mesh>>().add(render_only(n));
    let early = add(&mut app, 2);
    let early = app.world_mut().spawn((Mesh3d(early), axis())).id();
    let late = add(&mut app, 3);
    for _ in 0..3 {
        update(&mut app);
    }
    let late = app.world_mut().spawn((Mesh3d(late), axis())).id();
    // This field looks at the mesh's own data after the graph was built.
    let attribute = add(&mut app, 3);
    let attribute = app
        .world_mut()
        .spawn((
            Mesh3d(attribute),
            DirectionField::Attribute(Mesh::ATTRIBUTE_NORMAL),
            Frequency::Uniform(3.0),
        ))
        .id();
    settle(&mut app);
    assert_solved(&app, early);
    assert_eq!(state(&app, late), PatternState::Failed(PatternError::MeshDataTaken));
    assert_eq!(
        state(&app, attribute),
        PatternState::Failed(PatternError::MeshDataTaken)
    );
    // What needs no data of the mesh can change further.
    app.world_mut().entity_mut(early).insert(Frequency::Uniform(5.0));
    settle(&mut app);
    assert_solved(&app, early);
    let curvature = DirectionField::PrincipalCurvature {
        direction: Principal::Major,
        smoothing: 2,
    };
    app.world_mut().entity_mut(early).insert(curvature);
    settle(&mut app);
}

/// Bevy takes such data at the end of the frame in which they are new.
#[test]
fn a_mesh_of_the_render_world_may_be_replaced() {
    let mut app = app();
    let render_only = |n, radius| {
        let mut mesh = to_bevy_mesh(&shapes::icosphere(n, radius));
        mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
        mesh
    };
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(render_only(3, 1.0));
    let entity = app.world_mut().spawn((Mesh3d(mesh.clone()), axis())).id();
    settle(&mut app);
    assert_solved(&app, entity);
    let replace = |app: &mut App, n, radius| {
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        meshes.insert(&mesh, render_only(n, radius)).expect("a place");
    };
    let wait_for = |app: &mut App, vertices: usize, radius: f32| {
        for _ in 0..1000 {
            update(app);
            let state = state(app, entity);
            assert!(!matches!(state, PatternState::Failed(_)), "{state:?}");
            let graph = graph(app, entity);
            if graph.len() == vertices && (graph.positions[0].length() - radius).abs() < 1e-3 {
                settle(app);
                return assert_solved(app, entity);
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        panic!("the mesh of {vertices} vertices was not seen");
    };
    // Other positions, another graph, and another one while that is being built.
    replace(&mut app, 3, 0.5);
    wait_for(&mut app, 642, 0.5);
    replace(&mut app, 2, 1.0);
    wait_for(&mut app, 162, 1.0);
    replace(&mut app, 6, 1.0);
    update(&mut app);
    replace(&mut app, 4, 1.0);
    wait_for(&mut app, 2562, 1.0);
    // The handle's place may be given up and taken again within a frame.
    app.world_mut().resource_mut::<Assets<Mesh>>().remove(&mesh);
    replace(&mut app, 3, 1.0);
    wait_for(&mut app, 642, 1.0);
}

#[test]
fn without_a_renderer_graphs_are_built_and_the_twin_solves() {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        MeshPlugin,
        TransformPlugin,
        FieldPatternsPlugin,
    ));
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    let mesh = add_mesh(&mut app, &shapes::torus(40, 20, 1.0, 0.4, 0.2, 1));
    let entity = app.world_mut().spawn((Mesh3d(mesh.clone()), axis())).id();
    let empty = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    let empty = app.world_mut().resource_mut::<Assets<Mesh>>().add(empty);
    let empty = app.world_mut().spawn((Mesh3d(empty), axis())).id();
    for _ in 0..1000 {
        app.update();
        if state(&app, entity) != PatternState::Preparing && state(&app, empty) != PatternState::Preparing {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert_eq!(state(&app, entity), PatternState::NoGpu);
    assert_eq!(state(&app, empty), PatternState::Failed(PatternError::NoPositions));
    let graph: SurfaceGraph = graph(&app, entity);
    let meshes = app.world().resource::<Assets<Mesh>>();
    let mesh = meshes.get(&mesh).expect("the mesh");
    let d = directions(&DirectionField::Axis(Dir3::Y), Symmetry::Vector, 0.0, &graph, mesh).expect("a field");
    let f = vec![3.0; graph.len()];
    let solution = solve_cpu(&graph, &d, &f, Symmetry::Vector, &default());
    let quality = quality(&graph, &d, &f, &solution.phasors, Symmetry::Vector);
    assert!(quality.energy < 0.05, "{quality:?}");
}

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
