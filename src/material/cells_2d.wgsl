// Cells of a planar sample set, as a 2D material: the vertex shader of Bevy's `mesh2d.wgsl` with the triangle's index and
// the position at rest, and the fragment shader of its `color_material.wgsl` with cells over the base colour.

#import bevy_sprite::{
    mesh2d_functions,
    mesh2d_view_bindings::view,
}
#import bevy_field_patterns::cell_style::{CellPaint, screen_frame, styled_point}
#import bevy_field_patterns::cell_paint::{paint_cell, is_hole}

#ifdef TONEMAP_IN_SHADER
#import bevy_core_pipeline::tonemapping
#endif
#ifdef SRGB_OUTPUT
#import bevy_render::color_operations::linear_to_srgb
#endif
#ifdef OKLAB_OUTPUT
#import bevy_render::color_operations::linear_rgb_to_oklab
#endif

struct Base {
    color: vec4<f32>,
    // Below it a fragment is discarded; 0: nothing is.
    alpha_cutoff: f32,
    // The alpha is always 1.
    opaque: u32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(105) var<uniform> base: Base;
@group(#{MATERIAL_BIND_GROUP}) @binding(106) var base_texture: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(107) var base_sampler: sampler;

struct Vertex {
    @builtin(instance_index) instance_index: u32,
    @location(0) position: vec3<f32>,
#ifdef VERTEX_UVS
    @location(2) uv: vec2<f32>,
#endif
#ifdef CELLS_TRIANGLES
    @location(10) triangle: u32,
#endif
}

struct Varyings {
    @builtin(position) position: vec4<f32>,
    @location(0) world_position: vec4<f32>,
    @location(1) uv: vec2<f32>,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(12) rest: vec3<f32>,
}

@vertex
fn vertex(in: Vertex) -> Varyings {
    var out: Varyings;
    let world_from_local = mesh2d_functions::get_world_from_local(in.instance_index);
    out.world_position = mesh2d_functions::mesh2d_position_local_to_world(world_from_local, vec4(in.position, 1.0));
    out.position = mesh2d_functions::mesh2d_position_world_to_clip(out.world_position);
#ifdef VERTEX_UVS
    out.uv = in.uv;
#endif
#ifdef CELLS_TRIANGLES
    out.pattern = vec2(mesh2d_functions::get_tag(in.instance_index), in.triangle);
#endif
    out.rest = in.position;
    return out;
}

@fragment
fn fragment(in: Varyings) -> @location(0) vec4<f32> {
    let point = styled_point(in.pattern, in.rest);
    let frame = screen_frame(in.world_position.xyz, in.position);
    var color = base.color * textureSample(base_texture, base_sampler, in.uv);
    let paint = paint_cell(point, frame);
    if paint.defined {
        color = vec4(color.rgb * paint.layer.w + paint.layer.rgb, color.a);
#ifdef CELLS_CUTOUT
        color.a *= paint.solid;
#endif
    }
    if color.a < base.alpha_cutoff {
        discard;
    }
    color.a = select(color.a, 1.0, base.opaque != 0u);
#ifdef TONEMAP_IN_SHADER
    color = tonemapping::tone_mapping(color, view.color_grading);
#endif
#ifdef SRGB_OUTPUT
    color = vec4(linear_to_srgb(color.rgb), color.a);
#endif
#ifdef OKLAB_OUTPUT
    color = vec4(linear_rgb_to_oklab(color.rgb), color.a);
#endif
    return color;
}
