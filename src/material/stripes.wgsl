// Stripes over a StandardMaterial, in the main pass and in the deferred pass: the steps of Bevy's `pbr.wgsl` with one more,
// `apply_stripe`, between the material's textures and its lighting.

#import bevy_pbr::{
    pbr_types::{PbrInput, STANDARD_MATERIAL_FLAGS_UNLIT_BIT},
    pbr_functions::alpha_discard,
    pbr_fragment::pbr_input_from_standard_material,
    decal::clustered::apply_decals,
}
#import bevy_field_patterns::bump::bumped_normal
#import bevy_field_patterns::cutout::cut_out
#import bevy_field_patterns::focus::{FOCUS_COLOR, limited}
#import bevy_field_patterns::pattern_output::pattern_output
#import bevy_field_patterns::stripe_style::{stripes, stripe_at}
#import bevy_field_patterns::triangle_wave::Wave
#import bevy_field_patterns::wave::{PatternPoint, pattern_point, sample_wave}

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

#ifdef STRIPES_DEBUG
#import bevy_field_patterns::stripe_debug::debug_color
#endif
#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither;
#endif

// Where the world moves along the screen; taken in uniform control flow. [world units/pixel]
struct ScreenFrame {
    dx: vec3<f32>,
    dy: vec3<f32>,
}

fn apply_stripe(pbr: ptr<function, PbrInput>, point: PatternPoint, wave: Wave, frame: ScreenFrame) {
    let stripe = stripe_at(point, wave, (*pbr).world_position.xyz, globals.time);
    let strength = limited(stripes.focus, stripe.focus, FOCUS_COLOR);
    let material = &(*pbr).material;

#ifdef STRIPES_CUTOUT
    (*material).base_color.a *= cut_out((*material).flags, stripe.solid, stripe.periods, (*pbr).frag_coord);
#endif

    let over = stripe.layer * strength * stripes.drive.x;
    let base = (*material).base_color;
    (*material).base_color = vec4(base.rgb * (1.0 - over.a) + over.rgb, base.a);
    (*material).emissive += vec4(stripe.layer.rgb * strength * stripes.drive.y, 0.0);
    (*material).perceptual_roughness =
        clamp((*material).perceptual_roughness + stripe.coverage * strength * stripes.drive.z, 0.045, 1.0);

#ifdef STRIPES_BUMP
    // The normal prepass has bent its normals already, where they are read back.
#ifndef LOAD_PREPASS_NORMALS
    let slope = stripe.slope * strength * stripes.drive.w;
    (*pbr).N = bumped_normal((*pbr).N, frame.dx, frame.dy, slope);
    (*pbr).clearcoat_N = bumped_normal((*pbr).clearcoat_N, frame.dx, frame.dy, slope);
#endif
#endif

#ifdef STRIPES_DEBUG
    (*material).base_color = vec4(debug_color(stripes.debug, point, wave), base.a);
    (*material).flags |= STANDARD_MATERIAL_FLAGS_UNLIT_BIT;
#endif
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
    let wave = sample_wave(point);
    if wave.defined {
        apply_stripe(&pbr, point, wave, frame);
    }
    apply_decals(&pbr);
    return pattern_output(in, pbr);
}
