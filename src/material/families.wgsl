#define_import_path bevy_field_patterns::families

// Which waves a style draws as stripes: the words of `StripeWaves`.

#import bevy_field_patterns::wave::{PatternPoint, is_cross, waves_of}

const FAMILIES_FIRST: u32 = 0u;
const FAMILIES_SECOND: u32 = 1u;
const FAMILIES_BOTH: u32 = 2u;

fn families_of(point: PatternPoint, wanted: u32) -> u32 {
    if waves_of(point) < 2u {
        return FAMILIES_FIRST;
    }
    // Either wave of a cross field alone would end where it comes back as the other.
    return select(wanted, FAMILIES_BOTH, is_cross(point));
}

// The union of two layers, each premultiplied with its share of the pixel. Where they cross, none lies above the other.
fn crossed_layers(one: vec4<f32>, one_share: f32, two: vec4<f32>, two_share: f32) -> vec4<f32> {
    return one * (1.0 - 0.5 * two_share) + two * (1.0 - 0.5 * one_share);
}

fn crossed_share(one: f32, two: f32) -> f32 {
    return one + two - one * two;
}
