#define_import_path bevy_field_patterns::pattern_output

// How the fragment shader of a pattern over a StandardMaterial ends: the last steps of Bevy's `pbr.wgsl` and
// `pbr_prepass.wgsl`. Forward and deferred shaders call `pattern_output`, prepass shaders `prepass_output`.

#import bevy_pbr::pbr_types
#import bevy_pbr::pbr_types::{PbrInput, STANDARD_MATERIAL_FLAGS_UNLIT_BIT}

#ifdef PREPASS_PIPELINE
#ifdef PREPASS_FRAGMENT
#import bevy_pbr::{
    pbr_bindings,
    pbr_deferred_functions::deferred_output,
    pbr_fragment::pbr_input_from_standard_material,
    pbr_prepass_functions,
    prepass_io::{VertexOutput, FragmentOutput},
}
#endif
#else
#import bevy_pbr::{
    forward_io::{VertexOutput, FragmentOutput},
    pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing},
}
#ifdef OIT_ENABLED
#import bevy_core_pipeline::oit::oit_draw
#endif
#endif

#ifdef PREPASS_PIPELINE
#ifdef PREPASS_FRAGMENT
#ifdef DEFERRED_PREPASS
fn pattern_output(in: VertexOutput, pbr: PbrInput) -> FragmentOutput {
    return deferred_output(in, pbr);
}
#endif

#ifdef NORMAL_PREPASS
// The base's normal, its normal map included.
fn prepass_normal(in: VertexOutput, is_front: bool) -> vec3<f32> {
    if (pbr_bindings::material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) != 0u {
        return in.world_normal;
    }
    return pbr_input_from_standard_material(in, is_front).N;
}
#endif

fn prepass_output(in: VertexOutput, normal: vec3<f32>) -> FragmentOutput {
    var out: FragmentOutput;
#ifdef UNCLIPPED_DEPTH_ORTHO_EMULATION
    out.frag_depth = in.unclipped_depth;
#endif
#ifdef MOTION_VECTOR_PREPASS
    out.motion_vector = pbr_prepass_functions::calculate_motion_vector(in.world_position, in.previous_world_position);
#endif
#ifdef NORMAL_PREPASS
    out.normal = vec4(normal * 0.5 + vec3(0.5), 1.0);
#endif
    return out;
}
#endif
#else
fn lit_color(pbr: PbrInput) -> vec4<f32> {
    if (pbr.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u {
        return apply_pbr_lighting(pbr);
    }
    return pbr.material.base_color;
}

// A colour that is lit already.
fn color_output(in: VertexOutput, pbr: PbrInput, color: vec4<f32>) -> FragmentOutput {
    var out: FragmentOutput;
    out.color = main_pass_post_lighting_processing(pbr, color);
#ifdef OIT_ENABLED
    let alpha_mode = pbr.material.flags & pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_RESERVED_BITS;
    if alpha_mode != pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE {
        oit_draw(in.position, out.color);
        discard;
    }
#endif
    return out;
}

fn pattern_output(in: VertexOutput, pbr: PbrInput) -> FragmentOutput {
    return color_output(in, pbr, lit_color(pbr));
}
#endif
