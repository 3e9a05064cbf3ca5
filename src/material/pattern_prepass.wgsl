// A style of waves in shadow maps and in the depth, normal and motion vector prepasses: the steps of Bevy's
// `pbr_prepass.wgsl`, with the holes of a cut-out and the normals of a bump.

#import bevy_render::globals::Globals
#import bevy_pbr::{
    pbr_bindings,
    pbr_functions,
    pbr_prepass_functions,
    prepass_io::VertexOutput,
}
#import bevy_field_patterns::bump::bumped_normal
#import bevy_field_patterns::paint::{Paint, cut_out_prepass}
#import bevy_field_patterns::wave::pattern_point

#ifdef PATTERN_STRIPES
#import bevy_field_patterns::stripe_style::paint_pattern
#endif
#ifdef PATTERN_TEXTURE
#import bevy_field_patterns::texture_style::paint_pattern
#endif
#ifdef PATTERN_TENSOR
#import bevy_field_patterns::tensor_style::paint_pattern
#endif
#ifdef PATTERN_HATCH
#import bevy_field_patterns::hatch_style::paint_pattern
#endif

#ifdef PREPASS_FRAGMENT
#import bevy_pbr::prepass_io::FragmentOutput
#import bevy_field_patterns::pattern_output::prepass_output
#ifdef NORMAL_PREPASS
#import bevy_field_patterns::pattern_output::prepass_normal
#endif
#endif

@group(0) @binding(1) var<uniform> globals: Globals;

fn cut_out(paint: Paint, frag_coord: vec4<f32>) {
#ifdef PATTERN_CUTOUT
    cut_out_prepass(paint, pbr_bindings::material.flags, frag_coord);
#endif
}

#ifdef PREPASS_FRAGMENT
@fragment
fn fragment(
    in: VertexOutput,
    @builtin(front_facing) is_front: bool,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(11) barycentrics: vec2<f32>,
) -> FragmentOutput {
    let point = pattern_point(pattern, barycentrics);
    let position_dx = dpdx(in.world_position.xyz);
    let position_dy = dpdy(in.world_position.xyz);

#ifdef VISIBILITY_RANGE_DITHER
    pbr_functions::visibility_range_dither(in.position, in.visibility_range_dither);
#endif
    pbr_prepass_functions::prepass_alpha_discard(in);

    var normal = vec3(0.0);
#ifdef NORMAL_PREPASS
    normal = prepass_normal(in, is_front);
#endif

    let paint = paint_pattern(point, in.position, in.world_position.xyz, globals.time);
    if paint.defined {
        cut_out(paint, in.position);
#ifdef PATTERN_BUMP
        normal = bumped_normal(normal, position_dx, position_dy, paint.slope);
#endif
    }
    return prepass_output(in, normal);
}
#else
@fragment
fn fragment(
    in: VertexOutput,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(11) barycentrics: vec2<f32>,
) {
    let point = pattern_point(pattern, barycentrics);
    pbr_prepass_functions::prepass_alpha_discard(in);
#ifdef PATTERN_CUTOUT
    let paint = paint_pattern(point, in.position, in.world_position.xyz, globals.time);
    if paint.defined {
        cut_out(paint, in.position);
    }
#endif
}
#endif
