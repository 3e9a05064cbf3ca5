#define_import_path bevy_field_patterns::stripe_style

// From a wave to what a stripe does with a pixel. `stripes.rs` explains the settings.
//
// turns      phase [periods]
// coverage   share of the pixel that is stripe; its derivatives along the screen [1/pixel]
// layer      colour over the base, premultiplied with its alpha
// focus      1 where the style applies, 0 where not

#import bevy_field_patterns::families::{crossed_layers, crossed_share, drawn_wave}
#import bevy_field_patterns::focus::{Focus, focus_weight, limited, FOCUS_COLOR, FOCUS_CUTOUT, FOCUS_WIDTH}
#import bevy_field_patterns::paint::{Paint, kept_layer, premultiplied}
#import bevy_field_patterns::triangle_wave::Wave
#import bevy_field_patterns::wave::{PatternPoint, pattern_frame, sample_pair, waves_of}
#import bevy_field_patterns::coverage::{Coverage, soft_width, pulse_coverage, sine_coverage, sawtooth_coverage}
#ifdef STRIPES_DEBUG
#import bevy_field_patterns::stripe_debug::debug_color
#endif

const TAU: f32 = 6.283185307179586;

const PROFILE_SQUARE: u32 = 0u;
const PROFILE_SINE: u32 = 1u;
const PROFILE_RAMP: u32 = 2u;
const PROFILE_SAWTOOTH: u32 = 3u;
const PROFILE_PERIODIC: u32 = 4u;

struct Stripes {
    color: vec4<f32>,
    gap_color: vec4<f32>,
    focus: Focus,
    // Opacity over the base colour, emission, roughness, height of the bump.
    drive: vec4<f32>,
    duty: f32,
    softness: f32,
    phase_offset: f32,
    phase_speed: f32,
    profile: u32,
    debug: u32,
    // 1 to filter the profile over the pixel, 0 to take one point of it [pixels]
    filter_width: f32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(103) var<uniform> stripes: Stripes;
@group(#{MATERIAL_BIND_GROUP}) @binding(104) var profile_image: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(105) var profile_sampler: sampler;

struct Stripe {
    layer: vec4<f32>,
    coverage: f32,
    // Of a bump, 0 to 1, and its derivatives along the screen [1/pixel].
    height: f32,
    slope: vec2<f32>,
    // Share of the pixel that a cut-out leaves.
    solid: f32,
    // How much of a period a pixel covers.
    periods: f32,
    focus: f32,
}

// Profiles that need the phase itself are square on a line field.
fn profile_of(wave: Wave) -> u32 {
    let needs_phase = stripes.profile == PROFILE_SAWTOOTH || stripes.profile == PROFILE_PERIODIC;
    return select(stripes.profile, PROFILE_SQUARE, needs_phase && !wave.vector);
}

// The phase, travelling in time where it is defined. [periods]
fn turns_of(wave: Wave, time: f32) -> f32 {
    let turns = atan2(wave.phasor.y, wave.phasor.x) / TAU;
    return select(turns, turns + fract(stripes.phase_offset - fract(stripes.phase_speed * time)), wave.vector);
}

fn profile_coverage(profile: u32, turns: f32, duty: f32, width: vec2<f32>) -> Coverage {
    let crest = turns - 0.25;
    switch profile {
        case PROFILE_SINE, PROFILE_RAMP: { return sine_coverage(crest, width); }
        case PROFILE_SAWTOOTH, PROFILE_PERIODIC: { return sawtooth_coverage(crest, width); }
        default: { return pulse_coverage(crest, duty, soft_width(stripes.softness, duty, width)); }
    }
}

fn mean_coverage(profile: u32, duty: f32) -> f32 {
    return select(0.5, duty, profile == PROFILE_SQUARE);
}

#ifdef STRIPES_IMAGE
// The image through the pixel: the mean of equal steps over the footprint, over one period at most, where equal steps
// give the mean of the image.
fn image_color(profile: u32, turns: f32, width: f32) -> vec4<f32> {
    let steps = select(16, 4, width < 0.1);
    var sum = vec4(0.0);
    for (var k = 0; k < steps; k++) {
        let t = turns + min(width, 1.0) * ((f32(k) + 0.5) / f32(steps) - 0.5);
        let u = select(t, 0.5 + 0.5 * sin(TAU * t), profile == PROFILE_RAMP);
        let texel = textureSampleLevel(profile_image, profile_sampler, vec2(u, 0.5), 0.0);
        sum += vec4(texel.rgb * texel.a, texel.a);
    }
    return sum / f32(steps) * vec4(stripes.color.rgb, 1.0) * stripes.color.a;
}
#endif

// One family of stripes, without the gaps.
fn family_at(wave: Wave, focus: f32, time: f32) -> Stripe {
    var out: Stripe;
    let profile = profile_of(wave);
    let turns = turns_of(wave, time);
    let width = stripes.filter_width * wave.sides;
    let periods = stripes.filter_width * wave.footprint;
    let duty = stripes.duty * limited(stripes.focus, focus, FOCUS_WIDTH);
    // At a branch the phase means nothing: fade to the mean. Close to it the footprint blurs by itself, as much as the
    // distance of the view needs; a wide fade would be seen as a spot.
    let certain = smoothstep(0.01, 0.08, wave.confidence);

    let sharp = profile_coverage(profile, turns, duty, width);
    out.periods = periods;
    out.coverage = mix(mean_coverage(profile, duty), sharp.value, certain);
    out.solid = sharp.value;
    out.layer = premultiplied(stripes.color) * out.coverage;
#ifdef STRIPES_IMAGE
    if profile == stripes.profile {
        out.layer = image_color(profile, turns, mix(1.0, periods, certain));
        out.coverage = out.layer.a;
        out.solid = out.layer.a;
    }
#endif

    // A bump needs a slope to be seen: its edges are bevelled, however sharp the colours are.
    let bevelled = profile_coverage(profile, turns, duty, max(width, vec2(0.25 * min(duty, 1.0 - duty))));
    // Its fade at a branch is wide, or the tip of a stripe would be a needle.
    out.height = bevelled.value;
    out.slope = bevelled.slope * smoothstep(0.05, 0.3, wave.confidence) * wave.per_pixel;
    return out;
}

#ifdef WAVES_BOTH
// The union of two families, as all pieces of a triangle see it.
fn crossed_at(point: PatternPoint, focus: f32, time: f32) -> Stripe {
    let frame = pattern_frame(point);
    var sum: Stripe;
    for (var piece = 0u; piece < frame.pieces; piece++) {
        let pair = sample_pair(frame, point, piece);
        let one = family_at(pair.first, focus, time);
        let two = family_at(pair.second, focus, time);
        sum.coverage += pair.weight * crossed_share(one.coverage, two.coverage);
        sum.solid += pair.weight * crossed_share(one.solid, two.solid);
        sum.layer += pair.weight * crossed_layers(one.layer, one.coverage, two.layer, two.coverage);
        sum.slope += pair.weight * (one.slope * (1.0 - two.height) + two.slope * (1.0 - one.height));
        sum.periods += pair.weight * max(one.periods, two.periods);
    }
    return sum;
}
#endif

// At a point that has a pattern; `wave` is the one that is drawn, or the first of both.
fn stripe_at(point: PatternPoint, wave: Wave, world_position: vec3<f32>, time: f32) -> Stripe {
    let focus = focus_weight(stripes.focus, world_position);
    var out = family_at(wave, focus, time);
#ifdef WAVES_BOTH
    if waves_of(point) == 2u {
        out = crossed_at(point, focus, time);
    }
#endif
    out.focus = focus;
    out.layer += premultiplied(stripes.gap_color) * (1.0 - out.coverage);
    out.solid = mix(1.0, out.solid, limited(stripes.focus, focus, FOCUS_CUTOUT));
#ifdef PATTERN_CUTOUT
    out.layer = kept_layer(out.layer, premultiplied(stripes.gap_color), out.solid);
    out.coverage = min(out.coverage / max(out.solid, 1e-3), 1.0);
#endif
    return out;
}

fn paint_pattern(point: PatternPoint, frag_coord: vec4<f32>, world_position: vec3<f32>, time: f32) -> Paint {
    var paint: Paint;
    let wave = drawn_wave(point);
    if !wave.defined {
        return paint;
    }
    let stripe = stripe_at(point, wave, world_position, time);
    let strength = limited(stripes.focus, stripe.focus, FOCUS_COLOR);
    paint.defined = true;
    paint.layer = stripe.layer * strength * stripes.drive.x;
    paint.emissive = stripe.layer.rgb * strength * stripes.drive.y;
    paint.roughness = stripe.coverage * strength * stripes.drive.z;
    paint.slope = stripe.slope * strength * stripes.drive.w;
    paint.solid = stripe.solid;
    paint.periods = stripe.periods;
#ifdef STRIPES_DEBUG
    paint.layer = vec4(debug_color(stripes.debug, point, wave), 1.0);
    paint.unlit = true;
#endif
    return paint;
}
