#define_import_path bevy_field_patterns::families

// Which waves a style draws as stripes (`StripeWaves`): the first, with WAVES_SECOND the second, with WAVES_BOTH both. The
// shader of one wave has nothing of two in it, for that costs as much again.

#import bevy_field_patterns::triangle_wave::Wave
#import bevy_field_patterns::wave::{PatternPoint, sample_second_wave, sample_wave, waves_of}

// The wave whose stripes are drawn, or the first of both; the first where there is one only.
fn drawn_wave(point: PatternPoint) -> Wave {
#ifdef WAVES_SECOND
    if waves_of(point) == 2u {
        return sample_second_wave(point);
    }
#endif
    return sample_wave(point);
}

// The union of two layers, each premultiplied with its share of the pixel. Where they cross, none lies above the other.
fn crossed_layers(one: vec4<f32>, one_share: f32, two: vec4<f32>, two_share: f32) -> vec4<f32> {
    return one * (1.0 - 0.5 * two_share) + two * (1.0 - 0.5 * one_share);
}

fn crossed_share(one: f32, two: f32) -> f32 {
    return one + two - one * two;
}
