//! A user's own material on the shader library `bevy_field_patterns::cells`: it shows a cell as numbers.

use bevy::{
    asset::uuid_handle,
    prelude::*,
    render::{render_resource::AsBindGroup, storage::ShaderBuffer},
    shader::{Shader, ShaderRef},
};
use bevy_field_patterns::{
    cells::layout::{CELL_BUFFER, SITE_BUFFER},
    material::pattern_vertex_shader,
};

const SHADER: Handle<Shader> = uuid_handle!("0bd1f4c7-53a6-4c4e-9a0f-3a2c1b9f7e12");

#[derive(Asset, AsBindGroup, TypePath, Clone)]
pub struct Probe {
    #[storage(100, read_only, visibility(fragment))]
    cells: Handle<ShaderBuffer>,
    #[storage(101, read_only, visibility(fragment))]
    sites: Handle<ShaderBuffer>,
    #[uniform(103)]
    mode: u32,
}

/// Sample, evaluations, triangle modulo 2048, 0.5 (the background has 1).
pub const LABEL: u32 = 0;
/// x and y of the rest position, in two parts each.
pub const POSITION: u32 = 1;
/// z of the rest position and the border distance, in two parts each.
pub const DEPTH: u32 = 2;
/// Triangle / 2048, and the normal's x, y, z.
pub const NORMAL: u32 = 3;

impl Probe {
    pub fn new(mode: u32) -> Self {
        Self {
            cells: CELL_BUFFER,
            sites: SITE_BUFFER,
            mode,
        }
    }
}

impl Material for Probe {
    fn vertex_shader() -> ShaderRef {
        pattern_vertex_shader()
    }

    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    fn enable_prepass() -> bool {
        false
    }

    fn enable_shadows() -> bool {
        false
    }
}

pub fn add_shader(app: &mut App) {
    let shader = Shader::from_wgsl(WGSL, "cell_probe.wgsl");
    app.world_mut()
        .resource_mut::<Assets<Shader>>()
        .insert(SHADER.id(), shader)
        .unwrap();
}

/// A number from two halves.
pub fn joined(high: f32, low: f32) -> f32 {
    high + low / 1024.0
}

const WGSL: &str = "
#import bevy_pbr::forward_io::VertexOutput
#import bevy_field_patterns::cells::{cell_point, find_cell}

@group(#{MATERIAL_BIND_GROUP}) @binding(103) var<uniform> mode: u32;

fn split(value: f32) -> vec2<f32> {
    let high = round(value * 512.0) / 512.0;
    return vec2(high, (value - high) * 1024.0);
}

@fragment
fn fragment(
    in: VertexOutput,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(12) rest: vec3<f32>,
) -> @location(0) vec4<f32> {
    let point = cell_point(pattern, rest);
    let cell = find_cell(point, 0.0);
    if !cell.defined {
        return vec4(-2.0);
    }
    switch mode {
        case 0u: { return vec4(f32(cell.sample), f32(cell.evaluations), f32(point.triangle % 2048u), 0.5); }
        case 1u: { return vec4(split(rest.x), split(rest.y)); }
        case 2u: { return vec4(split(rest.z), split(min(cell.border, 1.9))); }
        default: { return vec4(f32(point.triangle / 2048u), point.normal); }
    }
}
";
