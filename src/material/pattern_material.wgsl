// A style of waves over a StandardMaterial, in the main pass and in the deferred pass: the steps of Bevy's `pbr.wgsl` with
// one more, `apply_paint`, between the material's textures and its lighting. `PATTERN_*` selects the style.

#import bevy_pbr::{
    pbr_types::{PbrInput, STANDARD_MATERIAL_FLAGS_UNLIT_BIT},
    pbr_functions::alpha_discard,
    pbr_fragment::pbr_input_from_standard_material,
    decal::clustered::apply_decals,
}
#import bevy_field_patterns::bump::bumped_normal
#import bevy_field_patterns::paint::{Paint, cut_out}
#import bevy_field_patterns::pattern_output::pattern_output
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

#ifdef PREPASS_PIPELINE
#import bevy_render::globals::Globals
#import bevy_pbr::prepass_io::{VertexOutput, FragmentOutput}
@group(0) @binding(1) var<uniform> globals: Globals;
#else
#import bevy_pbr::{
    mesh_view_bindings::globals,
    forward_io::{VertexOutput, FragmentOutput},
}
#endif

#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither;
#endif

// Where the world moves along the screen; taken in uniform control flow. [world units/pixel]
struct ScreenFrame {
    dx: vec3<f32>,
    dy: vec3<f32>,
}

fn apply_paint(pbr: ptr<function, PbrInput>, paint: Paint, frame: ScreenFrame) {
    let material = &(*pbr).material;

#ifdef PATTERN_CUTOUT
    (*material).base_color.a *= cut_out(paint, (*material).flags, (*pbr).frag_coord);
#endif

    let base = (*material).base_color;
    (*material).base_color = vec4(base.rgb * (1.0 - paint.layer.a) + paint.layer.rgb, base.a);
    (*material).emissive += vec4(paint.emissive, 0.0);
    (*material).perceptual_roughness = clamp((*material).perceptual_roughness + paint.roughness, 0.045, 1.0);

#ifdef PATTERN_BUMP
    // The normal prepass has bent its normals already, where they are read back.
#ifndef LOAD_PREPASS_NORMALS
    (*pbr).N = bumped_normal((*pbr).N, frame.dx, frame.dy, paint.slope);
    (*pbr).clearcoat_N = bumped_normal((*pbr).clearcoat_N, frame.dx, frame.dy, paint.slope);
#endif
#endif

    if paint.unlit {
        (*material).flags |= STANDARD_MATERIAL_FLAGS_UNLIT_BIT;
    }
}

@fragment
fn fragment(
    in: VertexOutput,
    @builtin(front_facing) is_front: bool,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(11) barycentrics: vec2<f32>,
) -> FragmentOutput {
    let point = pattern_point(pattern, barycentrics);
    let frame = ScreenFrame(dpdx(in.world_position.xyz), dpdy(in.world_position.xyz));

#ifdef VISIBILITY_RANGE_DITHER
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif

    var pbr = pbr_input_from_standard_material(in, is_front);
    pbr.material.base_color = alpha_discard(pbr.material, pbr.material.base_color);
    let paint = paint_pattern(point, in.position, pbr.world_position.xyz, globals.time);
    if paint.defined {
        apply_paint(&pbr, paint, frame);
    }
    apply_decals(&pbr);
    return pattern_output(in, pbr);
}
