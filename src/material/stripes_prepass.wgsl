// Stripes in shadow maps and in the depth, normal and motion vector prepasses: the steps of Bevy's `pbr_prepass.wgsl`, with
// the holes of a cut-out and the normals of a bump.

#import bevy_render::globals::Globals
#import bevy_pbr::{
    pbr_bindings,
    pbr_functions,
    pbr_prepass_functions,
    prepass_io::VertexOutput,
}
#import bevy_field_patterns::bump::bumped_normal
#import bevy_field_patterns::cutout::cut_out_prepass
#import bevy_field_patterns::focus::{FOCUS_COLOR, limited}
#import bevy_field_patterns::stripe_style::{Stripe, stripes, stripe_at}
#import bevy_field_patterns::wave::{PatternPoint, pattern_point, sample_wave}

#ifdef PREPASS_FRAGMENT
#import bevy_pbr::prepass_io::FragmentOutput
#import bevy_field_patterns::pattern_output::prepass_output
#ifdef NORMAL_PREPASS
#import bevy_field_patterns::pattern_output::prepass_normal
#endif
#endif

@group(0) @binding(1) var<uniform> globals: Globals;

fn cut_out(stripe: Stripe, frag_coord: vec4<f32>) {
#ifdef STRIPES_CUTOUT
    cut_out_prepass(pbr_bindings::material.flags, stripe.solid, stripe.periods, frag_coord);
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
    let wave = sample_wave(point);
    if wave.defined {
        let stripe = stripe_at(point, wave, in.world_position.xyz, globals.time);
        cut_out(stripe, in.position);
#ifdef STRIPES_BUMP
        let slope = stripe.slope * limited(stripes.focus, stripe.focus, FOCUS_COLOR) * stripes.drive.w;
        normal = bumped_normal(normal, position_dx, position_dy, slope);
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
#ifdef STRIPES_CUTOUT
    let wave = sample_wave(point);
    if wave.defined {
        cut_out(stripe_at(point, wave, in.world_position.xyz, globals.time), in.position);
    }
#endif
}
#endif
