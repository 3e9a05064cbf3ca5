//! Where patterns cannot be: small devices, meshes that are gone, no renderer, nonsense for geometry, entities that come
//! and go within a frame. Never a panic, and the rest of the app goes on.

#[path = "../common/mod.rs"]
mod common;
mod meshes;

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
