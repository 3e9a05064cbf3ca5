#define_import_path bevy_field_patterns::cutout

// The holes of a cut-out, alike in the picture, in prepasses and in shadow maps.
//
// solid     share of the pixel that is kept
// periods   how much of a period the pixel covers
// flags     of the StandardMaterial

#import bevy_pbr::pbr_types

// What Bevy's prepass takes for modes that blend.
const BLENDED_CUTOFF: f32 = 0.05;
const CUTOFF: f32 = 0.5;

// Where a pixel covers much of a period, an ordered dither keeps as many pixels as the stripe covers, so that holes too
// fine to be seen neither close nor open together.
fn is_hole(solid: f32, periods: f32, frag_coord: vec4<f32>, cutoff: f32) -> bool {
    let noise = fract(52.9829189 * fract(dot(floor(frag_coord.xy), vec2(0.06711056, 0.00583715))));
    let threshold = mix(cutoff, clamp(noise, 0.01, 0.99), smoothstep(0.25, 0.75, periods));
    return solid < threshold;
}

// A pixel is there or not; otherwise it blends.
fn is_masked(flags: u32) -> bool {
    let alpha_mode = flags & pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_RESERVED_BITS;
    return alpha_mode == pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE
        || alpha_mode == pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_MASK;
}

// For the main pass: discards holes, or gives what alpha is to be multiplied with.
fn cut_out(flags: u32, solid: f32, periods: f32, frag_coord: vec4<f32>) -> f32 {
    if !is_masked(flags) {
        return solid;
    }
    if is_hole(solid, periods, frag_coord, CUTOFF) {
        discard;
    }
    return 1.0;
}

// For prepasses, where what blends counts unless it is clear.
fn cut_out_prepass(flags: u32, solid: f32, periods: f32, frag_coord: vec4<f32>) {
    if is_hole(solid, periods, frag_coord, select(BLENDED_CUTOFF, CUTOFF, is_masked(flags))) {
        discard;
    }
}
