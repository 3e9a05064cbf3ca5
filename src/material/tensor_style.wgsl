#define_import_path bevy_field_patterns::tensor_style

// From a wave and two eigenvalues to stripes of two colours. `tensor.rs` explains the settings.
//
// value     the two eigenvalues, their own unit; `slope` along the screen [unit/pixel]
// layer     colour over the base, premultiplied with its alpha
// share     share of the pixel that is stripe

#import bevy_field_patterns::coverage::{pixel_of, pulse_coverage, soft_width, step_coverage}
#import bevy_field_patterns::families::{crossed_layers, crossed_share, drawn_wave}
#import bevy_field_patterns::focus::{Focus, FOCUS_COLOR, FOCUS_CUTOUT, FOCUS_WIDTH, focus_weight, limited}
#import bevy_field_patterns::paint::{Paint, kept_layer, premultiplied}
#import bevy_field_patterns::triangle_wave::Wave
#import bevy_field_patterns::wave::{PatternPoint, pattern_frame, sample_pair, sample_scalars, waves_of}

const TAU: f32 = 6.283185307179586;

struct Eigenvalue {
    low_color: vec4<f32>,
    high_color: vec4<f32>,
    alert_color: vec4<f32>,
    // Values of the two colours; the value from which it is an alert; the magnitude of the full width.
    values: vec4<f32>,
    // Widths at magnitude 0 and at the full one, as shares of half a period.
    widths: vec2<f32>,
    pad: vec2<f32>,
}

struct Tensor {
    first: Eigenvalue,
    second: Eigenvalue,
    gap_color: vec4<f32>,
    line_color: vec4<f32>,
    focus: Focus,
    // Width of the line where an alert begins [pixels]
    line_width: f32,
    softness: f32,
    emissive: f32,
    // 1 to filter over the pixel, 0 to take one point of it [pixels]
    filter_width: f32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(103) var<uniform> tensor: Tensor;

struct TensorStripe {
    layer: vec4<f32>,
    share: f32,
    solid: f32,
    periods: f32,
    focus: f32,
}

// One eigenvalue at a fragment.
struct Reading {
    color: vec4<f32>,
    // Of the period.
    width: f32,
    // Share of the pixel that is the line where its alert begins.
    line: f32,
}

fn reading_of(style: Eigenvalue, value: f32, slope: vec2<f32>) -> Reading {
    let t = clamp((value - style.values.x) / (style.values.y - style.values.x), 0.0, 1.0);
    let thick = mix(style.widths.x, style.widths.y, clamp(abs(value) / style.values.w, 0.0, 1.0));
    // How far the alert is, in pixels: its border is as sharp as a pixel.
    let steepness = max(length(slope), 1e-15);
    let inside = (value - style.values.z) / steepness;
    let pixel = pixel_of(tensor.filter_width * abs(slope) / steepness);
    let half_line = 0.5 * tensor.line_width;
    let alert = step_coverage(inside, pixel).value;
    let line = step_coverage(inside + half_line, pixel).value - step_coverage(inside - half_line, pixel).value;
    let color = mix(premultiplied(mix(style.low_color, style.high_color, t)), premultiplied(style.alert_color), alert);
    return Reading(color, 0.5 * thick, select(0.0, line, tensor.line_width > 0.0));
}

// Stripes of the first eigenvalue on the crests, those of the second on the troughs; the same for Phi and pi - Phi.
fn family_at(wave: Wave, first: Reading, second: Reading, focus: f32) -> TensorStripe {
    let x = atan2(wave.phasor.y, wave.phasor.x) / TAU - 0.25;
    let w = tensor.filter_width * wave.sides;
    let widths = limited(tensor.focus, focus, FOCUS_WIDTH) * vec2(first.width, second.width);
    let crest = pulse_coverage(x, widths.x, soft_width(tensor.softness, widths.x, w)).value;
    let trough = pulse_coverage(x + 0.5, widths.y, soft_width(tensor.softness, widths.y, w)).value;
    // At a branch the phase means nothing: fade to the mean.
    let drawn = mix(widths, vec2(crest, trough), smoothstep(0.01, 0.08, wave.confidence));
    var out: TensorStripe;
    out.layer = first.color * drawn.x + second.color * drawn.y;
    out.share = min(drawn.x + drawn.y, 1.0);
    out.solid = min(crest + trough, 1.0);
    out.periods = 2.0 * tensor.filter_width * wave.footprint;
    return out;
}

#ifdef WAVES_BOTH
fn both_at(point: PatternPoint, first: Reading, second: Reading, focus: f32) -> TensorStripe {
    let frame = pattern_frame(point);
    var sum: TensorStripe;
    for (var piece = 0u; piece < frame.pieces; piece++) {
        let pair = sample_pair(frame, point, piece);
        let one = family_at(pair.first, first, second, focus);
        let two = family_at(pair.second, first, second, focus);
        sum.layer += pair.weight * crossed_layers(one.layer, one.share, two.layer, two.share);
        sum.share += pair.weight * crossed_share(one.share, two.share);
        sum.solid += pair.weight * crossed_share(one.solid, two.solid);
        sum.periods += pair.weight * max(one.periods, two.periods);
    }
    return sum;
}
#endif

// At a point that has a pattern; `wave` is the one that is drawn, or the first of both.
fn tensor_at(point: PatternPoint, wave: Wave, world_position: vec3<f32>) -> TensorStripe {
    let focus = focus_weight(tensor.focus, world_position);
    // Scalars are linear in the barycentrics: so are their derivatives in those of the barycentrics.
    let value = sample_scalars(point);
    let dx = sample_scalars(PatternPoint(point.tag, point.triangle, point.b_dx, point.b_dx, point.b_dy));
    let dy = sample_scalars(PatternPoint(point.tag, point.triangle, point.b_dy, point.b_dx, point.b_dy));
    let first = reading_of(tensor.first, value.x, vec2(dx.x, dy.x));
    let second = reading_of(tensor.second, value.y, vec2(dx.y, dy.y));

    var out = family_at(wave, first, second, focus);
#ifdef WAVES_BOTH
    if waves_of(point) == 2u {
        out = both_at(point, first, second, focus);
    }
#endif
    out.focus = focus;
    out.layer += premultiplied(tensor.gap_color) * (1.0 - out.share);
    let line = crossed_share(first.line, second.line);
    out.layer = mix(out.layer, premultiplied(tensor.line_color), line * tensor.line_color.a);
    out.solid = mix(1.0, crossed_share(out.solid, line), limited(tensor.focus, focus, FOCUS_CUTOUT));
#ifdef PATTERN_CUTOUT
    out.layer = kept_layer(out.layer, premultiplied(tensor.gap_color), out.solid);
#endif
    return out;
}

fn paint_pattern(point: PatternPoint, frag_coord: vec4<f32>, world_position: vec3<f32>, time: f32) -> Paint {
    var paint: Paint;
    let wave = drawn_wave(point);
    if !wave.defined {
        return paint;
    }
    let stripe = tensor_at(point, wave, world_position);
    paint.defined = true;
    paint.layer = stripe.layer * limited(tensor.focus, stripe.focus, FOCUS_COLOR);
    paint.emissive = paint.layer.rgb * tensor.emissive;
    paint.solid = stripe.solid;
    paint.periods = stripe.periods;
    return paint;
}
