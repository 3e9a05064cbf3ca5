// Hatching in shadow maps and in the depth, normal and motion vector prepasses: the holes of a cut-out.

#import bevy_pbr::{
    pbr_bindings,
    pbr_functions,
    pbr_prepass_functions,
    prepass_io::VertexOutput,
}
#import bevy_field_patterns::cutout::cut_out_prepass
#import bevy_field_patterns::hatch_style::{Place, drawing_at, place_of}
#import bevy_field_patterns::wave::{PatternPoint, pattern_point, sample_wave}

#ifdef PREPASS_FRAGMENT
#import bevy_pbr::prepass_io::FragmentOutput
#import bevy_field_patterns::pattern_output::prepass_output
#ifdef NORMAL_PREPASS
#import bevy_field_patterns::pattern_output::prepass_normal
#endif
#endif

fn cut_holes(point: PatternPoint, place: Place, frag_coord: vec4<f32>) {
#ifdef HATCH_CUTOUT
    let wave = sample_wave(point);
    if wave.defined {
#ifdef HATCH_LIGHT
        let lit = false;
#else
        let lit = true;
#endif
        let drawing = drawing_at(point, wave, place, 0.0, lit);
        cut_out_prepass(pbr_bindings::material.flags, drawing.solid, drawing.periods, frag_coord);
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
    @location(12) rest: vec3<f32>,
) -> FragmentOutput {
    let point = pattern_point(pattern, barycentrics);
    let place = place_of(in.world_position.xyz, rest);
#ifdef VISIBILITY_RANGE_DITHER
    pbr_functions::visibility_range_dither(in.position, in.visibility_range_dither);
#endif
    pbr_prepass_functions::prepass_alpha_discard(in);
    var normal = vec3(0.0);
#ifdef NORMAL_PREPASS
    normal = prepass_normal(in, is_front);
#endif
    cut_holes(point, place, in.position);
    return prepass_output(in, normal);
}
#else
@fragment
fn fragment(
    in: VertexOutput,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(11) barycentrics: vec2<f32>,
    @location(12) rest: vec3<f32>,
) {
    let point = pattern_point(pattern, barycentrics);
    let place = place_of(in.world_position.xyz, rest);
    pbr_prepass_functions::prepass_alpha_discard(in);
    cut_holes(point, place, in.position);
}
#endif
