// A tensor's eigenvalues as stripes over a StandardMaterial, in the main pass and in the deferred pass.

#import bevy_pbr::{
    pbr_functions::alpha_discard,
    pbr_fragment::pbr_input_from_standard_material,
    decal::clustered::apply_decals,
}
#import bevy_field_patterns::cutout::cut_out
#import bevy_field_patterns::focus::{FOCUS_COLOR, limited}
#import bevy_field_patterns::pattern_output::pattern_output
#import bevy_field_patterns::tensor_style::{tensor, tensor_at}
#import bevy_field_patterns::wave::{pattern_point, sample_wave}

#ifdef PREPASS_PIPELINE
#import bevy_pbr::prepass_io::{VertexOutput, FragmentOutput}
#else
#import bevy_pbr::forward_io::{VertexOutput, FragmentOutput}
#endif
#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither;
#endif

@fragment
fn fragment(
    in: VertexOutput,
    @builtin(front_facing) is_front: bool,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(11) barycentrics: vec2<f32>,
) -> FragmentOutput {
    let point = pattern_point(pattern, barycentrics);

#ifdef VISIBILITY_RANGE_DITHER
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif

    var pbr = pbr_input_from_standard_material(in, is_front);
    pbr.material.base_color = alpha_discard(pbr.material, pbr.material.base_color);
    let wave = sample_wave(point);
    if wave.defined {
        let stripe = tensor_at(point, wave, in.world_position.xyz);
        let layer = stripe.layer * limited(tensor.focus, stripe.focus, FOCUS_COLOR);
        let base = pbr.material.base_color;
        pbr.material.base_color = vec4(base.rgb * (1.0 - layer.a) + layer.rgb, base.a);
        pbr.material.emissive += vec4(layer.rgb * tensor.emissive, 0.0);
#ifdef TENSOR_CUTOUT
        pbr.material.base_color.a *= cut_out(pbr.material.flags, stripe.solid, stripe.periods, in.position);
#endif
    }
    apply_decals(&pbr);
    return pattern_output(in, pbr);
}
