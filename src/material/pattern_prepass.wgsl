// A style of waves in shadow maps and in the depth, normal and motion vector prepasses: the steps of Bevy's `pbr_prepass.wgsl`, with
// the holes of a cut-out and the normals of a bump.

#import bevy_render::globals::Globals
#import bevy_pbr::{
    pbr_bindings,
    pbr_functions,
    pbr_fragment::pbr_input_from_standard_material,
    pbr_prepass_functions,
    pbr_types,
    prepass_io::{VertexOutput, FragmentOutput},
}
#import bevy_field_patterns::bump::bumped_normal
#import bevy_field_patterns::paint::{Paint, is_hole}
#import bevy_field_patterns::wave::pattern_point

#ifdef PATTERN_STRIPES
#import bevy_field_patterns::stripe_style::paint_pattern
#endif
#ifdef PATTERN_TEXTURE
#import bevy_field_patterns::texture_style::paint_pattern
#endif

@group(0) @binding(1) var<uniform> globals: Globals;

// What Bevy's prepass takes for modes that blend.
const BLENDED_CUTOFF: f32 = 0.05;

// As `alpha_discard` of the main pass, so that both draw the same pixels; what blends casts a shadow where it is not clear.
fn cut_out(paint: Paint, frag_coord: vec4<f32>) {
#ifdef PATTERN_CUTOUT
    let alpha_mode = pbr_bindings::material.flags & pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_RESERVED_BITS;
    let mask = alpha_mode == pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_MASK
        || alpha_mode == pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE;
    let cutoff = select(BLENDED_CUTOFF, 0.5, mask);
    if is_hole(paint, frag_coord, cutoff) {
        discard;
    }
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

    var out: FragmentOutput;
#ifdef UNCLIPPED_DEPTH_ORTHO_EMULATION
    out.frag_depth = in.unclipped_depth;
#endif
#ifdef MOTION_VECTOR_PREPASS
    out.motion_vector = pbr_prepass_functions::calculate_motion_vector(in.world_position, in.previous_world_position);
#endif
#ifdef NORMAL_PREPASS
    var normal = in.world_normal;
    if (pbr_bindings::material.flags & pbr_types::STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u {
        // The base's normal map included.
        normal = pbr_input_from_standard_material(in, is_front).N;
    }
#endif

    let paint = paint_pattern(point, in.position, in.world_position.xyz, globals.time);
    if paint.defined {
        cut_out(paint, in.position);
#ifdef NORMAL_PREPASS
#ifdef PATTERN_BUMP
        normal = bumped_normal(normal, position_dx, position_dy, paint.slope);
#endif
#endif
    }

#ifdef NORMAL_PREPASS
    out.normal = vec4(normal * 0.5 + vec3(0.5), 1.0);
#endif
    return out;
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
