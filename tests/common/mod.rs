//! An app without a window, with patterns on meshes made by formula, and a look into the device's memory.
#![allow(
    dead_code,
    unreachable_pub,
    reason = "each test compiles this module for itself and uses a part of it"
)]

#[path = "../../examples/common/gltf.rs"]
pub mod gltf;
#[path = "../../examples/common/gpu.rs"]
pub mod gpu;
#[path = "../../examples/common/headless.rs"]
pub mod headless;
#[path = "../../examples/common/mesh_file/mod.rs"]
pub mod mesh_file;
#[path = "../../examples/common/shapes.rs"]
pub mod shapes;

use bevy::prelude::*;
use bevy_field_patterns::{
    prelude::*,
    surface::SurfaceGraph,
    wave::{Pattern, layout::WAVE_BUFFER},
};
use mesh_file::RawMesh;

/// An app with the plugin, its pipelines compiled.
pub fn app() -> App {
    app_with(SolverSettings::default())
}

pub fn app_with(settings: SolverSettings) -> App {
    let mut app = headless::headless_app(UVec2::splat(16)).expect("a device");
    app.add_plugins(FieldPatternsPlugin).insert_resource(settings);
    headless::wait_until_ready(&mut app).expect("pipelines");
    app
}

pub fn add_mesh(app: &mut App, raw: &RawMesh) -> Handle<Mesh> {
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .add(mesh_file::to_bevy_mesh(raw))
}

pub fn update(app: &mut App) {
    headless::update(app).expect("a frame");
}

/// Updates until no pattern is being prepared or solved.
pub fn settle(app: &mut App) {
    for _ in 0..2000 {
        update(app);
        let mut states = app.world_mut().query::<&PatternState>();
        let busy = |state: &PatternState| matches!(state, PatternState::Preparing | PatternState::Solving);
        if !states.iter(app.world()).any(busy) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("patterns did not settle");
}

pub fn graph(app: &App, entity: Entity) -> SurfaceGraph {
    let handle = &app.world().get::<PatternMesh>(entity).expect("a pattern").graph;
    app.world()
        .resource::<Assets<SurfaceGraph>>()
        .get(handle)
        .expect("a graph")
        .clone()
}

/// Directions, frequencies and phasors (those of all waves) of an entity, read back.
pub fn wave(app: &App, entity: Entity) -> (Vec<Vec3>, Vec<f32>, Vec<Vec2>) {
    let record = *app.world().get::<Pattern>(entity).expect("a pattern").record();
    let read = |first: u32, len: u32| {
        gpu::read::<f32>(app, &WAVE_BUFFER, 8 * u64::from(first), 8 * u64::from(len)).expect("the wave buffer")
    };
    let field = read(record.field_base, 2 * record.vertices);
    let phasors = read(record.phasor_base, record.waves * record.vertices);
    (
        field.chunks_exact(4).map(|d| Vec3::new(d[0], d[1], d[2])).collect(),
        field.chunks_exact(4).map(|d| d[3]).collect(),
        phasors.chunks_exact(2).map(|z| Vec2::new(z[0], z[1])).collect(),
    )
}

/// The share of vertices where two fields are more than a degree apart, as vectors, as lines or as crosses.
pub fn share_off(a: &[Vec3], b: &[Vec3], graph: &SurfaceGraph, symmetry: u32) -> f32 {
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(b).zip(&graph.normals).filter(|((a, b), n)| {
        let (cos, sin) = (a.dot(**b), a.dot(n.cross(**b)));
        let fits = match symmetry {
            1 => cos,
            2 => cos.abs(),
            _ => cos.abs().max(sin.abs()),
        };
        fits.is_nan() || fits < 1.0_f32.to_radians().cos()
    });
    off.count() as f32 / a.len() as f32
}
