//! A user's own material on the shader library: it shows the wave as numbers.

use bevy::{
    asset::uuid_handle,
    prelude::*,
    render::{render_resource::AsBindGroup, storage::ShaderBuffer},
    shader::{Shader, ShaderRef},
};
use bevy_field_patterns::{
    material::pattern_vertex_shader,
    wave::layout::{GEOMETRY_BUFFER, SURFACE_BUFFER, WAVE_BUFFER},
};

const SHADER: Handle<Shader> = uuid_handle!("0bd1f4c7-53a6-4c4e-9a0f-3a2c1b9f7e11");

/// Numbers of a wave: see `fragment`.
#[derive(Asset, AsBindGroup, TypePath, Clone)]
pub struct Probe {
    #[storage(100, read_only, visibility(fragment))]
    surface: Handle<ShaderBuffer>,
    #[storage(101, read_only, visibility(fragment))]
    geometry: Handle<ShaderBuffer>,
    #[storage(102, read_only, visibility(fragment))]
    waves: Handle<ShaderBuffer>,
    #[uniform(103)]
    mode: u32,
}

/// sin Φ in two parts, confidence, 1 if odd.
pub const VALUE: u32 = 0;
/// Barycentrics 0 and 1, in two parts each.
pub const BARYCENTRICS: u32 = 1;
/// Triangle index, tag modulo 1024, footprint, one half (the background has 1).
pub const TRIANGLE: u32 = 2;
/// Texture coordinates u and v of the first piece, in two parts each.
pub const TEXTURE: u32 = 3;
/// Rest position of the middle of the fragment's period cell: x and y, in two parts each.
pub const MIDDLE_XY: u32 = 4;
/// Its z, in two parts, then 0 and one half.
pub const MIDDLE_Z: u32 = 5;

impl Probe {
    pub fn new(mode: u32) -> Self {
        Self {
            surface: SURFACE_BUFFER,
            geometry: GEOMETRY_BUFFER,
            waves: WAVE_BUFFER,
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
    let shader = Shader::from_wgsl(WGSL, "probe.wgsl");
    app.world_mut()
        .resource_mut::<Assets<Shader>>()
        .insert(SHADER.id(), shader)
        .unwrap();
}

/// A number from two halves: eight bits before, eleven after.
pub fn joined(high: f32, low: f32) -> f32 {
    high + low / 256.0
}

const WGSL: &str = "
#import bevy_pbr::forward_io::VertexOutput
#import bevy_field_patterns::texture_patch::cell_middle
#import bevy_field_patterns::wave::{pattern_frame, pattern_point, sample_pair, sample_wave, texture_point}

@group(#{MATERIAL_BIND_GROUP}) @binding(103) var<uniform> mode: u32;

fn split(value: f32) -> vec2<f32> {
    let high = round(value * 256.0) / 256.0;
    return vec2(high, (value - high) * 256.0);
}

@fragment
fn fragment(
    in: VertexOutput,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(11) barycentrics: vec2<f32>,
) -> @location(0) vec4<f32> {
    let point = pattern_point(pattern, barycentrics);
    let wave = sample_wave(point);
    if !wave.defined {
        return vec4(-2.0);
    }
    if mode == 0u {
        return vec4(split(wave.value), wave.confidence, f32(wave.odd));
    }
    if mode == 1u {
        return vec4(split(point.b.x), split(point.b.y));
    }
    if mode == 3u {
        let frame = pattern_frame(point);
        let texel = texture_point(sample_pair(frame, point, 0u));
        return select(vec4(-2.0), vec4(split(texel.uv.x), split(texel.uv.y)), frame.pieces > 0u);
    }
    if mode == 4u || mode == 5u {
        if pattern_frame(point).pieces == 0u {
            return vec4(-2.0);
        }
        let middle = sample_wave(cell_middle(point, vec2(0.5))).position;
        return select(vec4(split(middle.z), 0.0, 0.5), vec4(split(middle.x), split(middle.y)), mode == 4u);
    }
    return vec4(f32(point.triangle), f32(point.tag % 1024u), wave.footprint, 0.5);
}
";
