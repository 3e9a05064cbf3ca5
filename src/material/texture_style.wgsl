#define_import_path bevy_field_patterns::texture_style

// From two waves to an image on them. `texture.rs` explains the settings.
//
// u, v    phases of the waves along d and n x d [periods]; crests of both cross in the middle of the image
// texel   a colour premultiplied with its alpha
// copy    the image as it travels; at a constant speed there are two, which fade into each other
// quiet   the second image, which takes the place of the first where a scalar says so

#import bevy_field_patterns::focus::{Focus, focus_weight, limited, FOCUS_COLOR, FOCUS_CUTOUT}
#import bevy_field_patterns::paint::{Paint, kept_layer, premultiplied}
#import bevy_field_patterns::quad::quad_shared
#import bevy_field_patterns::wave::{
    PatternPoint, TexturePoint, pattern_frame, sample_pair, sample_scalars, texture_point,
}
#ifdef TEXTURE_PATCHES
#import bevy_field_patterns::texture_patch::cell_middle
#endif

const FADE_BY_SECOND: u32 = 1u;
const COLOR_BY_SECOND: u32 = 2u;
const TILE_BY_SECOND: u32 = 4u;
const HEIGHT_LUMINANCE: u32 = 1u;
const LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
// Samples along each side of a pixel: more than one, for what a texture unit filters is no parallelogram.
const MIN_TAPS: f32 = 4.0;
const MAX_TAPS: f32 = 8.0;
// How wide each is asked to be, as a share of its part of the pixel: 1 / sqrt(3). A box a wide has the variance a^2/12. A
// level whose texels are s wide is a box and a tent, s^2/12 + s^2/6: as much where s = a / sqrt(3).
const TAP_WIDTH: f32 = 0.577;
const MAX_PIECES: u32 = 3u;
// Behind the smallest level of any image.
const LAST_LEVEL: f32 = 16.0;

struct TextureStyle {
    color_stops: array<vec4<f32>, 16>,
    tint: vec4<f32>,
    // Opacity over the base colour, emission, roughness, height of the bump.
    drive: vec4<f32>,
    // Periods per second; speed [length/s], frequency around which [periods/length], cycle [s].
    travel: vec4<f32>,
    focus: Focus,
    // [periods]
    offset: vec2<f32>,
    // The values at which something begins and ends.
    fade: vec2<f32>,
    color_range: vec2<f32>,
    tile_range: vec2<f32>,
    tiles: vec2<u32>,
    color_count: u32,
    // Who is told by the second scalar.
    scalars: u32,
    height: u32,
    // 1 to filter the image over the pixel, 0 to take one point of it [pixels]
    filter_width: f32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(103) var<uniform> style: TextureStyle;
@group(#{MATERIAL_BIND_GROUP}) @binding(104) var loud_image: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(105) var image_sampler: sampler;
@group(#{MATERIAL_BIND_GROUP}) @binding(106) var quiet_image: texture_2d<f32>;

// What to read: the place in the image (its v downwards), and how it moves along the screen [images/pixel].
struct Reading {
    uv: vec2<f32>,
    dx: vec2<f32>,
    dy: vec2<f32>,
    // Of the atlas.
    tile: u32,
    quiet: bool,
}

fn scalar_of(scalars: vec2<f32>, second: u32) -> f32 {
    return select(scalars.x, scalars.y, (style.scalars & second) != 0u);
}

// Where a scalar lies in a range, 0 to 1.
fn share_of(range: vec2<f32>, scalar: f32) -> f32 {
    let span = range.y - range.x;
    if span == 0.0 {
        return select(0.0, 1.0, scalar >= range.x);
    }
    return clamp((scalar - range.x) / span, 0.0, 1.0);
}

#ifdef TEXTURE_PATCHES
// A texel of the atlas. Filters must not reach into the next tile.
fn loud_texel(reading: Reading, uv: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
    let grid = vec2<f32>(style.tiles);
    // No smaller level than the one where a tile is a texel.
    let a = dx / max(1.0, length(dx));
    let b = dy / max(1.0, length(dy));
    let margin = min(0.5 * (abs(a) + abs(b)) + 0.5 * grid / vec2<f32>(textureDimensions(loud_image)), vec2(0.5));
    let inside = clamp(fract(uv), margin, 1.0 - margin);
    let at = vec2(f32(reading.tile % style.tiles.x), f32(reading.tile / style.tiles.x)) + inside;
    return premultiplied(textureSampleGrad(loud_image, image_sampler, at / grid, a / grid, b / grid));
}
#else
fn loud_texel(reading: Reading, uv: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
    return premultiplied(textureSampleGrad(loud_image, image_sampler, uv, dx, dy));
}
#endif

fn texel(reading: Reading, uv: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
#ifdef TEXTURE_QUIET
    if reading.quiet {
        return premultiplied(textureSampleGrad(quiet_image, image_sampler, uv, dx, dy));
    }
#endif
    return loud_texel(reading, uv, dx, dy);
}

// The mean over the pixel, which is a parallelogram of the image: of samples that lie in it as a grid, each as wide as a part
// of the grid. Many where the parallelogram is long and narrow: not left to anisotropic samplers, of which some take
// gradients of their own.
fn filtered(reading: Reading) -> vec4<f32> {
    let lengths = vec2(length(reading.dx), length(reading.dy));
    let area = abs(reading.dx.x * reading.dy.y - reading.dx.y * reading.dy.x);
    let narrow = area / max(max(lengths.x, lengths.y), 1e-20);
    let taps = vec2<u32>(clamp(ceil(2.0 * lengths / max(narrow, 1e-20)), vec2(MIN_TAPS), vec2(MAX_TAPS)));
    let part = 1.0 / vec2<f32>(taps);
    let dx = part.x * reading.dx;
    let dy = part.y * reading.dy;
    var sum = vec4(0.0);
    for (var k = 0u; k < taps.x * taps.y; k++) {
        let at = (vec2(f32(k % taps.x), f32(k / taps.x)) + 0.5) - 0.5 * vec2<f32>(taps);
        sum += texel(reading, reading.uv + at.x * dx + at.y * dy, TAP_WIDTH * dx, TAP_WIDTH * dy);
    }
    return sum * part.x * part.y;
}

// The mean over the image, or over a tile of it.
fn mean_texel(reading: Reading) -> vec4<f32> {
#ifdef TEXTURE_PATCHES
    if !reading.quiet {
        return loud_texel(reading, vec2(0.5), vec2(1.0, 0.0), vec2(0.0, 1.0));
    }
#endif
    if reading.quiet {
        return premultiplied(textureSampleLevel(quiet_image, image_sampler, vec2(0.5), LAST_LEVEL));
    }
    return premultiplied(textureSampleLevel(loud_image, image_sampler, vec2(0.5), LAST_LEVEL));
}

// Both images as they are mixed at a value of the fade.
fn shown(reading: Reading, quiet: f32, certain: f32) -> vec4<f32> {
    var sum = vec4(0.0);
    if quiet < 1.0 {
        sum += (1.0 - quiet) * mix(mean_texel(reading), filtered(reading), certain);
    }
#ifdef TEXTURE_QUIET
    if quiet > 0.0 {
        var other = reading;
        other.quiet = true;
        sum += quiet * mix(mean_texel(other), filtered(other), certain);
    }
#endif
    return sum;
}

#ifdef PATTERN_BUMP
fn height_of(color: vec4<f32>) -> f32 {
    return select(color.a, dot(color.rgb, LUMINANCE), style.height == HEIGHT_LUMINANCE);
}

// How the height moves along the screen [1/pixel].
fn height_slope(reading: Reading) -> vec2<f32> {
    let x = 0.5 * reading.dx;
    let y = 0.5 * reading.dy;
    return vec2(
        height_of(texel(reading, reading.uv + x, reading.dx, reading.dy))
            - height_of(texel(reading, reading.uv - x, reading.dx, reading.dy)),
        height_of(texel(reading, reading.uv + y, reading.dx, reading.dy))
            - height_of(texel(reading, reading.uv - y, reading.dx, reading.dy)),
    );
}
#endif

// Shift along d [periods] and weight of a copy.
fn copy_of(index: u32, frequency: f32, time: f32) -> vec2<f32> {
#ifdef TEXTURE_COPIES
    let cycle = style.travel.w;
    let part = fract(time / cycle + 0.5 * f32(index));
    let steady = fract(style.travel.z * style.travel.y * time);
    let shift = steady + (frequency - style.travel.z) * style.travel.y * (part - 0.5) * cycle;
    return vec2(shift, 1.0 - abs(2.0 * part - 1.0));
#else
    return vec2(fract(style.travel.x * time), 1.0);
#endif
}

#ifdef TEXTURE_COPIES
const COPIES: u32 = 2u;
#else
const COPIES: u32 = 1u;
#endif

// The tile for the cell that a point lies in.
fn tile_at(point: PatternPoint, scalars: vec2<f32>, shift: vec2<f32>, footprint: f32) -> u32 {
#ifdef TEXTURE_PATCHES
    var seen = scalars;
    // What is smaller than a pixel has no middle to walk to.
    if footprint < 1.0 {
        seen = sample_scalars(cell_middle(point, 0.5 + shift));
    }
    let count = style.tiles.x * style.tiles.y;
    let pick = share_of(style.tile_range, scalar_of(seen, TILE_BY_SECOND)) * f32(count);
    return min(u32(pick), count - 1u);
#else
    return 0u;
#endif
}

#ifdef TEXTURE_COLOR
fn scalar_color(scalars: vec2<f32>) -> vec4<f32> {
    let at = share_of(style.color_range, scalar_of(scalars, COLOR_BY_SECOND)) * f32(style.color_count - 1u);
    let stop = min(u32(at), style.color_count - 1u);
    return mix(style.color_stops[stop], style.color_stops[min(stop + 1u, style.color_count - 1u)], at - f32(stop));
}
#endif

fn paint_pattern(point: PatternPoint, frag_coord: vec4<f32>, world_position: vec3<f32>, time: f32) -> Paint {
    var paint: Paint;
    let frame = pattern_frame(point);
    let scalars = sample_scalars(point);
    var quiet = 0.0;
#ifdef TEXTURE_FADE
    quiet = smoothstep(0.0, 1.0, share_of(style.fade, scalar_of(scalars, FADE_BY_SECOND)));
#endif

    var color = vec4(0.0);
    var slope = vec2(0.0);
    for (var piece = 0u; piece < MAX_PIECES; piece++) {
        let there = piece < frame.pieces;
        var place: TexturePoint;
        var frequency = 0.0;
        if there {
            let pair = sample_pair(frame, point, piece);
            place = texture_point(pair);
            frequency = pair.first.frequency;
        }
        // In uniform control flow, for it takes derivatives.
        let gradient = quad_shared(vec4(place.dx, place.dy), there, frag_coord);
        if !there {
            continue;
        }
        let footprint = max(length(place.dx), length(place.dy));
        paint.periods += place.weight * style.filter_width * footprint;
        // At a branch the phases mean nothing: fade to the mean.
        let certain = smoothstep(0.05, 0.3, place.confidence);
        for (var copy = 0u; copy < COPIES; copy++) {
            let travelled = copy_of(copy, frequency, time);
            let shift = select(vec2(0.0), vec2(travelled.x, 0.0) + style.offset, frame.vector);
            // The rows of an image go down.
            let uv = vec2(place.uv.x - shift.x, 1.0 - place.uv.y + shift.y);
            let reading = Reading(
                fract(uv),
                style.filter_width * gradient.xy * vec2(1.0, -1.0),
                style.filter_width * gradient.zw * vec2(1.0, -1.0),
                tile_at(point, scalars, shift, footprint),
                false,
            );
            let weight = place.weight * travelled.y;
            color += weight * shown(reading, quiet, certain);
#ifdef PATTERN_BUMP
            slope += weight * (1.0 - quiet) * certain * height_slope(reading);
#endif
        }
    }

    let focus = focus_weight(style.focus, world_position);
    let strength = limited(style.focus, focus, FOCUS_COLOR);
    paint.defined = frame.pieces > 0u;
    paint.solid = mix(1.0, color.a, limited(style.focus, focus, FOCUS_CUTOUT));
#ifdef PATTERN_CUTOUT
    color = kept_layer(color, vec4(0.0), paint.solid);
#endif
    paint.roughness = color.a * strength * style.drive.z;
    paint.slope = slope * strength * style.drive.w;
    var tint = style.tint;
#ifdef TEXTURE_COLOR
    tint *= scalar_color(scalars);
#endif
    let layer = vec4(color.rgb * tint.rgb, color.a) * tint.a * strength;
    paint.layer = layer * style.drive.x;
    paint.emissive = layer.rgb * style.drive.y;
    return paint;
}
