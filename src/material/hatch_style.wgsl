#define_import_path bevy_field_patterns::hatch_style

// From a tone to ink. `hatch_options.rs` explains the settings.
//
// tone      0 (lightest) to 1 (darkest)
// share     share of the area that is ink
// ink       share of the pixel that is ink
// zoom      doublings of the number of strokes per period that the distance of the view asks for

#import bevy_pbr::mesh_view_bindings::view
#import bevy_field_patterns::families::crossed_share
#import bevy_field_patterns::focus::{Focus, FOCUS_CUTOUT, focus_weight, limited}
#import bevy_field_patterns::hatch_strokes::{MAX_OCTAVES, crossed_shares, octaves_of, stroke_coverage}
#import bevy_field_patterns::noise::smooth_noise
#import bevy_field_patterns::paint::Paint
#import bevy_field_patterns::triangle_wave::Wave
#import bevy_field_patterns::wave::{
    PatternPoint, has_pattern, is_cross, load_corners, pattern_frame, sample_pair, sample_scalars, sample_wave,
}

const TAU: f32 = 6.283185307179586;

const TONE_SCALAR_0: u32 = 2u;
const TONE_SCALAR_1: u32 = 3u;
const TONE_CAMERA: u32 = 4u;
const TONE_POINT: u32 = 5u;

// Waves of the hand's noise per distance between strokes, in a frame that no mesh is aligned with.
const HAND_FREQUENCY: f32 = 0.4;
const HAND_FRAME = mat3x3(
    vec3(0.684, 0.513, -0.519),
    vec3(-0.303, 0.848, 0.435),
    vec3(0.663, -0.140, 0.735),
);
// Strokes that are spaced in pixels do not come closer than this share of their spacing.
const CLOSEST: f32 = 0.33;

struct Hatch {
    ink: vec4<f32>,
    paper: vec4<f32>,
    // Values of tone 0 and 1; shares of ink of tone 0 and 1.
    tone: vec4<f32>,
    // Where distances are measured from; opacity of the ink's noise.
    origin: vec4<f32>,
    // Width, density, distance between strokes [pixels; 0: one per period], the share from which strokes cross.
    strokes: vec4<f32>,
    // Width, length [octaves], wobble [distances between strokes], softness.
    hand: vec4<f32>,
    // Width [pixels], length of a dash and the gap after it [pixels; 0: solid], share of the gap, kind.
    outline: vec4<f32>,
    // Near and far [world units], how much of it ink and paper take.
    chroma: vec4<f32>,
    focus: Focus,
    source: u32,
    // 1 to filter strokes over the pixel, 0 to take one point of it [pixels]
    filter_width: f32,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(103) var<uniform> hatch: Hatch;

// A fragment's place in the world.
struct Place {
    world: vec3<f32>,
    // Rest length per world length.
    rest_scale: f32,
}

struct Drawing {
    ink: f32,
    // Share of the pixel that a cut-out leaves, and how much of the distance between two strokes it covers.
    solid: f32,
    periods: f32,
    focus: f32,
}

// Doublings that the distance of the view asks for, and those that it allows.
struct Zoom {
    octaves: f32,
    most: f32,
}

// What the hand adds, tied to the surface.
struct Hand {
    share: f32,
    octaves: f32,
    wobble: vec3<f32>,
    opacity: f32,
}

// Takes derivatives: call it in uniform control flow.
fn place_of(point: PatternPoint, world: vec3<f32>) -> Place {
    let dx = dpdx(world);
    let dy = dpdy(world);
    let size = sqrt(dot(dx, dx) + dot(dy, dy));
    return Place(world, rest_size(point) / max(size, 1e-30));
}

// How much of the surface at rest a pixel covers. [rest length]
fn rest_size(point: PatternPoint) -> f32 {
    if !has_pattern(point) {
        return 0.0;
    }
    let corners = load_corners(point, 0u).position;
    let origin = corners[0];
    let sides = mat3x3(vec3(0.0), corners[1] - origin, corners[2] - origin);
    let dx = sides * point.b_dx;
    let dy = sides * point.b_dy;
    return sqrt(dot(dx, dx) + dot(dy, dy));
}

// How far the camera's depth reaches, and the size of a pixel there. [world units]
fn view_depth(world: vec3<f32>) -> f32 {
    return -(view.view_from_world * vec4(world, 1.0)).z;
}

fn pixel_size(world: vec3<f32>) -> f32 {
    let w = (view.clip_from_world * vec4(world, 1.0)).w;
    return 2.0 * w / (view.clip_from_view[1][1] * view.viewport.w);
}

fn tone_value(point: PatternPoint, world: vec3<f32>, luminance: f32) -> f32 {
    switch hatch.source {
        case TONE_SCALAR_0: { return sample_scalars(point).x; }
        case TONE_SCALAR_1: { return sample_scalars(point).y; }
        case TONE_CAMERA: { return distance(view.world_position, world); }
        case TONE_POINT: { return distance(hatch.origin.xyz, world); }
        default: { return luminance; }
    }
}

fn share_of(value: f32) -> f32 {
    let t = (value - hatch.tone.x) / (hatch.tone.y - hatch.tone.x);
    return mix(hatch.tone.z, hatch.tone.w, clamp(t, 0.0, 1.0));
}

fn hand_at(wave: Wave, zoom: f32) -> Hand {
    let octave = log2(max(wave.frequency, 1e-20)) + zoom;
    let whole = floor(octave);
    let t = octave - whole;
    let p = HAND_FREQUENCY * exp2(whole) * (HAND_FRAME * wave.position);
    let blend = mix(smooth_noise(p), smooth_noise(2.0 * p), t) / sqrt(1.0 - 2.0 * t * (1.0 - t));
    // Too fine to be seen: its mean.
    let seen = 1.0 - smoothstep(0.8, 2.5, wave.footprint * exp2(zoom));
    let noise = seen * clamp(blend, vec4(-1.0), vec4(1.0));
    return Hand(
        1.0 + hatch.hand.x * noise.w,
        hatch.hand.y * noise.x,
        hatch.hand.z * exp2(-zoom) * noise.xyz,
        1.0 - hatch.origin.w * (0.5 + 0.5 * noise.z),
    );
}

fn zoom_at(wave: Wave, place: Place) -> Zoom {
    if hatch.strokes.z <= 0.0 {
        return Zoom(0.0, MAX_OCTAVES);
    }
    let spacing = max(wave.frequency * place.rest_scale * pixel_size(place.world) * hatch.strokes.z, 1e-20);
    return Zoom(max(0.0, -log2(spacing)), max(0.0, -log2(spacing * CLOSEST)));
}

// One family of strokes.
fn strokes_of(wave: Wave, share: f32, zoom: Zoom, hand: Hand) -> f32 {
    if share <= 0.0 {
        return 0.0;
    }
    let asked = clamp(share * hand.share, 0.0, 1.0);
    let octaves = octaves_of(asked, hatch.strokes.x, hatch.strokes.y, zoom.octaves + hand.octaves, zoom.most);
    let x = atan2(wave.phasor.y, wave.phasor.x) / TAU - 0.25 + dot(hand.wobble, wave.direction);
    let drawn = stroke_coverage(x, asked * tapered(wave), octaves, hatch.hand.w, hatch.filter_width * wave.sides);
    // At a branch the phase means nothing.
    return mix(asked, drawn, smoothstep(0.01, 0.08, wave.confidence));
}

// Around a branch the phase turns too fast or too slowly: strokes end there in a point.
fn tapered(wave: Wave) -> f32 {
    let d = wave.direction - wave.normal * dot(wave.normal, wave.direction);
    let strain = length(wave.gradient - wave.frequency * d) / max(wave.frequency, 1e-20);
    return 1.0 - smoothstep(0.4, 1.2, strain);
}

struct Crossed {
    ink: f32,
    opacity: f32,
    periods: f32,
}

// All families at a tone.
fn ink_at(point: PatternPoint, wave: Wave, place: Place, share: f32) -> Crossed {
    let frame = pattern_frame(point);
    // One wave of a cross field alone is no wave: its corners may be of different waves.
    var first = wave;
    if frame.pieces > 0u {
        first = sample_pair(frame, point, 0u).first;
    }
    let zoom = zoom_at(first, place);
    let hand = hand_at(first, zoom.octaves);
    let asked = min(share / (1.0 - 0.5 * hatch.origin.w), 1.0);
    let periods = hatch.filter_width * first.footprint * exp2(zoom.octaves);
    if frame.pieces == 0u {
        return Crossed(strokes_of(first, asked, zoom, hand), hand.opacity, periods);
    }
    // Of a cross field nobody knows which wave is the first one.
    let shares = crossed_shares(asked, select(hatch.strokes.w, 0.0, is_cross(point)));
    var ink = 0.0;
    for (var piece = 0u; piece < frame.pieces; piece++) {
        let pair = sample_pair(frame, point, piece);
        let one = strokes_of(pair.first, shares.x, zoom, hand);
        let two = strokes_of(pair.second, shares.y, zoom, hand);
        ink += pair.weight * crossed_share(one, two);
    }
    return Crossed(ink, hand.opacity, periods);
}

// `luminance` is that of the lit base, where the tone is light; `lit` is false where the light is not known.
fn drawing_at(point: PatternPoint, wave: Wave, place: Place, luminance: f32, lit: bool) -> Drawing {
    let focus = focus_weight(hatch.focus, place.world);
    var out = Drawing(0.0, 1.0, 0.0, focus);
    if lit {
        let drawn = ink_at(point, wave, place, share_of(tone_value(point, place.world, luminance)));
        out.ink = drawn.ink;
        out.solid = drawn.ink;
        out.periods = drawn.periods;
        out.ink *= drawn.opacity;
    }
#ifdef PATTERN_CUTOUT
#ifdef HATCH_LIGHT
    // Shadows and prepasses do not know the light: what the darkest tone inks is kept, and of it the light inks a part.
    let darkest = ink_at(point, wave, place, hatch.tone.w);
    out.solid = darkest.ink;
    out.periods = darkest.periods;
#endif
    out.ink = min(out.ink / max(out.solid, 1e-3), 1.0);
    out.solid = mix(1.0, out.solid, limited(hatch.focus, focus, FOCUS_CUTOUT));
#endif
    return out;
}

// What prepasses and shadow maps see of a drawing.
fn paint_pattern(point: PatternPoint, frag_coord: vec4<f32>, world_position: vec3<f32>, time: f32) -> Paint {
    let place = place_of(point, world_position);
    let wave = sample_wave(point);
#ifdef HATCH_LIGHT
    let lit = false;
#else
    let lit = true;
#endif
    var paint: Paint;
    paint.defined = wave.defined;
    if wave.defined {
        let drawing = drawing_at(point, wave, place, 0.0, lit);
        paint.solid = drawing.solid;
        paint.periods = drawing.periods;
    }
    return paint;
}
