//! A material of your own on the shader library `bevy_field_patterns::wave`: the shader is `assets/shaders/contours.wgsl`.

mod common;

use std::process::ExitCode;

use bevy::{
    prelude::*,
    render::{render_resource::AsBindGroup, storage::ShaderBuffer},
    shader::ShaderRef,
};
use bevy_field_patterns::{
    field::Principal,
    material::{pattern_prepass_vertex_shader, pattern_vertex_shader},
    prelude::*,
    wave::layout::{GEOMETRY_BUFFER, SURFACE_BUFFER, WAVE_BUFFER},
};
use common::{args::run_plain, mesh_file::to_bevy_mesh, scene::Subject, shapes};

/// A thin bright line on every crest, over colours that turn with the direction of the field.
#[derive(Asset, AsBindGroup, TypePath, Debug, Clone)]
struct Contours {
    #[storage(100, read_only, visibility(fragment))]
    surface: Handle<ShaderBuffer>,
    #[storage(101, read_only, visibility(fragment))]
    geometry: Handle<ShaderBuffer>,
    #[storage(102, read_only, visibility(fragment))]
    waves: Handle<ShaderBuffer>,
    /// Red, green, blue of a line, and its share of a period.
    #[uniform(103, visibility(fragment))]
    line: Vec4,
}

impl Default for Contours {
    fn default() -> Self {
        Self {
            surface: SURFACE_BUFFER,
            geometry: GEOMETRY_BUFFER,
            waves: WAVE_BUFFER,
            line: Vec4::new(1.0, 0.95, 0.8, 0.2),
        }
    }
}

impl Material for Contours {
    fn vertex_shader() -> ShaderRef {
        pattern_vertex_shader()
    }

    fn prepass_vertex_shader() -> ShaderRef {
        pattern_prepass_vertex_shader()
    }

    fn fragment_shader() -> ShaderRef {
        "shaders/contours.wgsl".into()
    }
}

fn main() -> ExitCode {
    run_plain("A material of your own", |app| {
        app.add_plugins((
            FieldPatternsPlugin,
            MaterialPlugin::<Contours>::default(),
            PatternMaterialPlugin::<Contours>::default(),
        ))
        .add_systems(Startup, setup);
    })
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<Contours>>) {
    commands.spawn((
        Subject,
        Mesh3d(meshes.add(to_bevy_mesh(&shapes::knot(480, 42)))),
        MeshMaterial3d(materials.add(Contours::default())),
        DirectionField::PrincipalCurvature {
            direction: Principal::Minor,
            smoothing: 30,
        },
        Frequency::Uniform(10.0),
    ));
}
