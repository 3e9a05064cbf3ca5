//! A material that shows how far what Bevy draws is from what the pattern is solved on.

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

const SHADER: Handle<Shader> = uuid_handle!("5f0f9d0e-2b0e-4a57-8d2a-9c1d3f6f2b71");

/// Red: distance between the fragment's place in the world and the pattern's, which is relative to `place`. Green: how
/// evenly the phase moves, as share of the frequency by which its gradient is off. Blue: 1.
#[derive(Asset, AsBindGroup, TypePath, Clone)]
pub struct Probe {
    #[storage(100, read_only, visibility(fragment))]
    surface: Handle<ShaderBuffer>,
    #[storage(101, read_only, visibility(fragment))]
    geometry: Handle<ShaderBuffer>,
    #[storage(102, read_only, visibility(fragment))]
    waves: Handle<ShaderBuffer>,
    #[uniform(103)]
    place: Vec4,
}

impl Probe {
    pub fn new(place: Vec3) -> Self {
        Self {
            surface: SURFACE_BUFFER,
            geometry: GEOMETRY_BUFFER,
            waves: WAVE_BUFFER,
            place: place.extend(0.0),
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

const WGSL: &str = "
#import bevy_pbr::forward_io::VertexOutput
#import bevy_field_patterns::wave::{pattern_point, sample_wave}

@group(#{MATERIAL_BIND_GROUP}) @binding(103) var<uniform> place: vec4<f32>;

@fragment
fn fragment(
    in: VertexOutput,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(11) barycentrics: vec2<f32>,
) -> @location(0) vec4<f32> {
    let wave = sample_wave(pattern_point(pattern, barycentrics));
    if !wave.defined {
        return vec4(100.0, 0.0, 0.5, 1.0);
    }
    let apart = distance(in.world_position.xyz - place.xyz, wave.position);
    let uneven = abs(length(wave.gradient) / wave.frequency - 1.0);
    return vec4(apart, uneven, 1.0, 1.0);
}
";
