#define_import_path bevy_field_patterns::paint

// What a style of waves does with a pixel, the same in every pass.
//
// flags   of the StandardMaterial

#import bevy_pbr::pbr_types

// What Bevy's prepass takes for modes that blend.
const BLENDED_CUTOFF: f32 = 0.05;
const CUTOFF: f32 = 0.5;

struct Paint {
    // There is a pattern here.
    defined: bool,
    // Colour over the base, premultiplied with its alpha.
    layer: vec4<f32>,
    // Light added to what the base emits.
    emissive: vec3<f32>,
    // Added to the perceptual roughness.
    roughness: f32,
    // Derivatives of a bump's height along the screen. [world units/pixel]
    slope: vec2<f32>,
    // Share of the pixel that a cut-out leaves.
    solid: f32,
    // How much of a period a pixel covers.
    periods: f32,
    // The layer is shown as it is, without light.
    unlit: bool,
}

fn premultiplied(color: vec4<f32>) -> vec4<f32> {
    return vec4(color.rgb * color.a, color.a);
}

// What a layer looks like on the share `solid` of a pixel that a cut-out leaves, where it looks like `gap` on the rest.
fn kept_layer(layer: vec4<f32>, gap: vec4<f32>, solid: f32) -> vec4<f32> {
    let kept = max(layer - (1.0 - solid) * gap, vec4(0.0)) / max(solid, 1e-3);
    return kept / max(kept.a, 1.0);
}

// What a cut-out keeps: the pattern. Where a pixel covers much of a period, an ordered dither keeps as many pixels as the
// pattern covers, so that holes too fine to be seen neither close nor open together.
fn is_hole(paint: Paint, frag_coord: vec4<f32>, cutoff: f32) -> bool {
    let noise = fract(52.9829189 * fract(dot(floor(frag_coord.xy), vec2(0.06711056, 0.00583715))));
    let threshold = mix(cutoff, clamp(noise, 0.01, 0.99), smoothstep(0.25, 0.75, paint.periods));
    return paint.solid < threshold;
}

// A pixel is there or not; otherwise it blends.
fn is_masked(flags: u32) -> bool {
    let alpha_mode = flags & pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_RESERVED_BITS;
    return alpha_mode == pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE
        || alpha_mode == pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_MASK;
}

// In the main pass: discards holes, or gives what alpha is to be multiplied with.
fn cut_out(paint: Paint, flags: u32, frag_coord: vec4<f32>) -> f32 {
    if !is_masked(flags) {
        return paint.solid;
    }
    if is_hole(paint, frag_coord, CUTOFF) {
        discard;
    }
    return 1.0;
}

// In prepasses, as `alpha_discard` of the main pass, so that both draw the same pixels; what blends casts a shadow where it
// is not clear.
fn cut_out_prepass(paint: Paint, flags: u32, frag_coord: vec4<f32>) {
    if is_hole(paint, frag_coord, select(BLENDED_CUTOFF, CUTOFF, is_masked(flags))) {
        discard;
    }
}
