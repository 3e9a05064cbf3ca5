// Hatching over a StandardMaterial, in the main pass and in the deferred pass. Forward, the drawing lies over the lit
// surface, whose light may be the tone. Deferred, where no light is known yet, it is what the surface emits.

#import bevy_pbr::{
    pbr_types::STANDARD_MATERIAL_FLAGS_UNLIT_BIT,
    pbr_functions::alpha_discard,
    pbr_fragment::pbr_input_from_standard_material,
    decal::clustered::apply_decals,
}
#import bevy_field_patterns::focus::{FOCUS_COLOR, limited}
#import bevy_field_patterns::hatch_style::{drawing_at, hatch, place_of, view_depth}
#import bevy_field_patterns::paint::{Paint, cut_out}
#import bevy_field_patterns::pattern_output::pattern_output
#import bevy_field_patterns::wave::{pattern_point, sample_wave}

#ifdef PREPASS_PIPELINE
#import bevy_pbr::prepass_io::{VertexOutput, FragmentOutput}
#else
#import bevy_pbr::forward_io::{VertexOutput, FragmentOutput}
#import bevy_field_patterns::pattern_output::{color_output, lit_color}
#endif
#ifdef HATCH_OUTLINE
#import bevy_field_patterns::hatch_outline::{contour_of, outline_ink}
#endif
#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither;
#endif

const LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
const NEAR = vec3(1.0, 0.02, 0.02);
const FAR = vec3(0.02, 0.05, 1.0);

// By depth: red comes forward, blue lies back.
fn chroma_depth(color: vec3<f32>, amount: f32, world: vec3<f32>) -> vec3<f32> {
    let t = clamp((view_depth(world) - hatch.chroma.x) / (hatch.chroma.y - hatch.chroma.x), 0.0, 1.0);
    return mix(color, mix(NEAR, FAR, t), amount);
}

// Ink over paper over the surface, premultiplied with what it hides of the surface.
fn drawn_layer(ink_share: f32, world: vec3<f32>, strength: f32) -> vec4<f32> {
    let paper = hatch.paper.a * strength;
    let ink = hatch.ink.a * ink_share * strength;
    let paper_color = chroma_depth(hatch.paper.rgb, hatch.chroma.w, world);
    let ink_color = chroma_depth(hatch.ink.rgb, hatch.chroma.z, world);
    return vec4(paper_color * paper * (1.0 - ink) + ink_color * ink, 1.0 - (1.0 - paper) * (1.0 - ink));
}

@fragment
fn fragment(
    in: VertexOutput,
    @builtin(front_facing) is_front: bool,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(11) barycentrics: vec2<f32>,
    @location(12) rest: vec3<f32>,
) -> FragmentOutput {
    let point = pattern_point(pattern, barycentrics);
    let place = place_of(point, in.world_position.xyz);

#ifdef VISIBILITY_RANGE_DITHER
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif

    var pbr = pbr_input_from_standard_material(in, is_front);
    pbr.material.base_color = alpha_discard(pbr.material, pbr.material.base_color);
#ifdef HATCH_OUTLINE
    let facing = select(-1.0, 1.0, is_front) * dot(normalize(in.world_normal), pbr.V);
    let contour = contour_of(facing, rest);
#endif
    apply_decals(&pbr);

    let wave = sample_wave(point);
    if !wave.defined {
        return pattern_output(in, pbr);
    }
    var color = pbr.material.base_color;
#ifdef HATCH_LIT
#ifndef PREPASS_PIPELINE
    color = lit_color(pbr);
#endif
#endif
    let luminance = dot(color.rgb, LUMINANCE);
    let drawing = drawing_at(point, wave, place, luminance, true);
#ifdef PATTERN_CUTOUT
    var paint: Paint;
    paint.solid = drawing.solid;
    paint.periods = drawing.periods;
    pbr.material.base_color.a *= cut_out(paint, pbr.material.flags, in.position);
#endif
    var ink = drawing.ink;
#ifdef HATCH_OUTLINE
    let outline = outline_ink(contour, point, wave);
    ink = ink + outline - ink * outline;
#endif
    let layer = drawn_layer(ink, place.world, limited(hatch.focus, drawing.focus, FOCUS_COLOR));

#ifdef PREPASS_PIPELINE
    let material = &pbr.material;
    let seen = 1.0 - layer.a;
    let drawn = vec4(layer.rgb, 0.0);
    let base = vec4((*material).base_color.rgb * seen, (*material).base_color.a);
    let unlit = ((*material).flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) != 0u;
    (*material).base_color = select(base, base + drawn, unlit);
    (*material).reflectance *= seen;
    (*material).emissive = vec4((*material).emissive.rgb * seen, 0.0) + drawn;
    return pattern_output(in, pbr);
#else
    return color_output(in, pbr, vec4(color.rgb * (1.0 - layer.a) + layer.rgb, pbr.material.base_color.a));
#endif
}
