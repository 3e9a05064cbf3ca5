#define_import_path bevy_field_patterns::wave

// The wave under a fragment. For any material that binds the three buffers of `wave/layout.rs` and is drawn with the
// vertex shader `pattern_vertex.wgsl`:
//
//     @fragment
//     fn fragment(in: VertexOutput,
//                 @location(10) @interpolate(flat) pattern: vec2<u32>, @location(11) barycentrics: vec2<f32>) -> ... {
//         let wave = sample_wave(pattern_point(pattern, barycentrics));
//         let stripe = select(0.0, 1.0, wave.value > 0.0);
//
// Where a pattern has two waves, they make texture coordinates:
//
//     let frame = pattern_frame(point);
//     for (var piece = 0u; piece < frame.pieces; piece++) {
//         let texel = texture_point(sample_pair(frame, point, piece));
//         color += texel.weight * textureSampleGrad(image, sampler, texel.uv, texel.dx, texel.dy);
//     }
//
// tag           word offset of the entity's record in `surface`, its MeshTag; 0: no pattern
// triangle      index of the triangle in the drawn mesh
// barycentrics  weights of corners 0 and 1 (of the drawn triangle); corner 2 has the rest
// rest space    the mesh's own space, before skin, morph targets and transform; with `PatternPose::Live` as posed [length]
// Wave          fields and their units: `triangle_wave.wgsl`
//
// Do not import a function under the name of a field (`kite::phasor` and `wave.phasor`): naga_oil replaces both.

#import bevy_field_patterns::kite
#import bevy_field_patterns::kite::{
    Coupling, Frame, TAU, aligned_distance, cmul, direction_of, quarter_turns, turned_reversed, turned_wave,
}
#import bevy_field_patterns::layout::{FLAG_CROSS, FLAG_DISCS, FLAG_READY, FLAG_VECTOR, RECORD_WORDS}
#import bevy_field_patterns::triangle_pair::{
    PairCorners, Turns, WavePair, corner_turns, pair_in_triangle, pair_pieces,
}
#import bevy_field_patterns::triangle_wave::{Corners, Wave, wave_in_triangle}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var<storage, read> surface: array<u32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(101) var<storage, read> geometry: array<vec4<f32>>;
@group(#{MATERIAL_BIND_GROUP}) @binding(102) var<storage, read> waves: array<vec2<f32>>;

// A fragment's place on a pattern.
struct PatternPoint {
    tag: u32,
    triangle: u32,
    // Barycentrics and their derivatives along the screen [1/pixel].
    b: vec3<f32>,
    b_dx: vec3<f32>,
    b_dy: vec3<f32>,
}

// Takes derivatives: call it first, in uniform control flow. Barycentrics belong to one triangle, also in those pixels of
// a 2x2 quad that only help; their differences are exact, where differences of phases would jump at a flip or a wrap.
fn pattern_point(pattern: vec2<u32>, barycentrics: vec2<f32>) -> PatternPoint {
    let dx = dpdx(barycentrics);
    let dy = dpdy(barycentrics);
    return PatternPoint(
        pattern.x,
        pattern.y,
        vec3(barycentrics, 1.0 - barycentrics.x - barycentrics.y),
        vec3(dx, -dx.x - dx.y),
        vec3(dy, -dy.x - dy.y),
    );
}

// What all fragments of a triangle share of its two waves.
struct PatternFrame {
    // 1, or 3 where no frame fits all corners; 0 where there are not two waves, or none yet.
    pieces: u32,
    corners: PairCorners,
    turns: Turns,
    vector: bool,
}

// A place on a texture that lies on the two waves: u along d, v along n x d, in periods, with the crests of both in the
// middle of the image (0.5, 0.5). Where the field is turned by half a turn the image is, too.
struct TexturePoint {
    // 0..1, up to whole periods.
    uv: vec2<f32>,
    // Derivatives of uv along the screen [periods/pixel], for `textureSampleGrad`.
    dx: vec2<f32>,
    dy: vec2<f32>,
    // Share of this piece in the blend of all.
    weight: f32,
    // 0 (a branch of one of the waves) to 1.
    confidence: f32,
}

// The wave at a point, the first one where there are two. `defined` is false without a pattern, or before its first solve.
// The two waves of a cross field cannot be told apart, so that either alone ends in seams: take both (`sample_pair`).
fn sample_wave(point: PatternPoint) -> Wave {
    return sample_one(point, 0u);
}

// The wave along n x d; undefined where there is one wave only.
fn sample_second_wave(point: PatternPoint) -> Wave {
    var wave: Wave;
    if waves_of(point) == 2u {
        wave = sample_one(point, 1u);
    }
    return wave;
}

fn sample_one(point: PatternPoint, r: u32) -> Wave {
    var wave: Wave;
    if !has_pattern(point) {
        return wave;
    }
    let corners = load_corners(point, r);
    wave = wave_in_triangle(corners, is_vector(point), point.b);
    return with_footprint(wave, corners, point);
}

fn pattern_frame(point: PatternPoint) -> PatternFrame {
    var frame: PatternFrame;
    if !has_pattern(point) || waves_of(point) < 2u {
        return frame;
    }
    frame.corners = PairCorners(load_corners(point, 0u), load_corners(point, 1u));
    frame.vector = is_vector(point);
    frame.turns = corner_turns(frame.corners, Coupling(2u, frame.vector, is_cross(point)));
    frame.pieces = pair_pieces(frame.turns);
    return frame;
}

// Both waves, as one of the frame's pieces sees them.
fn sample_pair(frame: PatternFrame, point: PatternPoint, piece: u32) -> WavePair {
    var pair = pair_in_triangle(frame.corners, frame.turns, frame.vector, point.b, piece);
    pair.first = with_footprint(pair.first, frame.corners.first, point);
    pair.second = with_footprint(pair.second, frame.corners.second, point);
    return pair;
}

fn texture_point(pair: WavePair) -> TexturePoint {
    return TexturePoint(
        vec2(texture_coordinate(pair.first), texture_coordinate(pair.second)),
        vec2(pair.first.per_pixel.x, pair.second.per_pixel.x),
        vec2(pair.first.per_pixel.y, pair.second.per_pixel.y),
        pair.weight,
        min(pair.first.confidence, pair.second.confidence),
    );
}

// Phi / 2 pi, such that the crest is at 0.5.
fn texture_coordinate(wave: Wave) -> f32 {
    return fract(atan2(wave.phasor.y, wave.phasor.x) / TAU + 0.25);
}

// Adds how much of the wave a pixel covers.
fn with_footprint(given: Wave, corners: Corners, point: PatternPoint) -> Wave {
    var wave = given;
    let v = corners.position;
    let sides = mat3x3(vec3(0.0), v[1] - v[0], v[2] - v[0]);
    let dx = sides * point.b_dx;
    let dy = sides * point.b_dy;
    wave.per_pixel = vec2(dot(wave.gradient, dx), dot(wave.gradient, dy));
    // Around a branch there are points where the phase stands still, but not as far as a pixel: the slower it is than
    // d and f ask for, the more of what they ask for counts.
    let asked = wave.frequency * vec2(dot(wave.direction, dx), dot(wave.direction, dy));
    let slow = max(0.0, 1.0 - length(wave.per_pixel) / max(length(asked), 1e-20));
    wave.sides = max(abs(wave.per_pixel), slow * abs(asked));
    wave.footprint = length(wave.sides);
    return wave;
}

// The pattern's two scalars at a point (`PatternRecord::scalar_base`); 0 where it has none.
fn sample_scalars(point: PatternPoint) -> vec2<f32> {
    var sum = vec2(0.0);
    if point.tag == 0u || point.triangle >= surface[point.tag + 1u] {
        return sum;
    }
    let base = surface[point.tag + 19u];
    let triangle = surface[point.tag + 4u] + 3u * point.triangle;
    if base != 0u {
        for (var m = 0u; m < 3u; m++) {
            sum += point.b[m] * waves[base + surface[triangle + m]];
        }
    }
    return sum;
}

fn is_vector(point: PatternPoint) -> bool {
    return (surface[point.tag + 2u] & FLAG_VECTOR) != 0u;
}

// The two waves are those of a cross field: after quarter turns one is the other.
fn is_cross(point: PatternPoint) -> bool {
    return (surface[point.tag + 2u] & FLAG_CROSS) != 0u;
}

fn waves_of(point: PatternPoint) -> u32 {
    return surface[point.tag + 17u];
}

fn has_pattern(point: PatternPoint) -> bool {
    return point.tag != 0u && (surface[point.tag + 2u] & FLAG_READY) != 0u && point.triangle < surface[point.tag + 1u];
}

// What is known of wave r (0 or 1) at the corners of the point's triangle, which must have a pattern.
fn load_corners(point: PatternPoint, r: u32) -> Corners {
    let triangle = surface[point.tag + 4u] + 3u * point.triangle;
    let geometry_base = surface[point.tag + 5u];
    let field_base = surface[point.tag + 6u];
    let phasor_base = surface[point.tag + 7u];
    let count = max(waves_of(point), 1u);
    var corners: Corners;
    for (var m = 0u; m < 3u; m++) {
        let vertex = surface[triangle + m];
        let zf = waves[field_base + 2u * vertex + 1u];
        let d = vec3(waves[field_base + 2u * vertex], zf.x);
        corners.position[m] = geometry[geometry_base + 2u * vertex].xyz;
        corners.z[m] = waves[phasor_base + count * vertex + r];
        if r == 0u {
            corners.direction[m] = d;
            corners.frequency[m] = zf.y;
        } else {
            corners.direction[m] = cross(geometry[geometry_base + 2u * vertex + 1u].xyz, d);
            corners.frequency[m] = zf.y * bitcast<f32>(surface[point.tag + 18u]);
        }
    }
    if (surface[point.tag + 2u] & FLAG_DISCS) != 0u {
        return spread_disc(corners, point, surface[triangle], r);
    }
    return corners;
}

// Moves corners that are all at the vertex of a point cloud to those of the vertex's square, whose half axes are x and y.
// Their phases are what the vertex and its neighbours predict there, the nearer ones more: so squares that overlap agree.
fn spread_disc(corners: Corners, point: PatternPoint, vertex: u32, r: u32) -> Corners {
    let axes = surface[point.tag + 5u] + 2u * (surface[point.tag] + vertex);
    let x = geometry[axes].xyz;
    let y = geometry[axes + 1u].xyz;
    let even = (point.triangle & 1u) == 0u;
    var spread = corners;
    spread.position[0] += -x - y;
    spread.position[1] += select(x + y, x - y, even);
    spread.position[2] += select(y - x, x + y, even);
    spread.z = mat3x2<f32>();
    // Weights fall to 0 at this squared distance.
    let reach = 4.0 * max(dot(x, x), dot(y, y));
    spread = with_prediction(spread, point, vertex, vertex, r, reach);
    // Offset and neighbor base of the first level's record.
    let offsets = surface[point.tag + RECORD_WORDS + 1u];
    let list = surface[point.tag + RECORD_WORDS + 2u];
    let end = surface[offsets + vertex + 1u];
    for (var k = surface[offsets + vertex]; k < end; k++) {
        spread = with_prediction(spread, point, vertex, surface[list + k], r, reach);
    }
    return spread;
}

// Adds to the phasors at the corners of a vertex's square what vertex j predicts there.
fn with_prediction(corners: Corners, point: PatternPoint, vertex: u32, j: u32, r: u32, reach: f32) -> Corners {
    let cross_field = (surface[point.tag + 2u] & FLAG_CROSS) != 0u;
    let count = max(waves_of(point), 1u);
    let own = load_frame(point, vertex);
    let other = load_frame(point, j);
    let k = quarter_turns(Coupling(count, is_vector(point), cross_field), other, own);
    let m = turned_wave(k, r);
    let flip = turned_reversed(k, r);
    let place = geometry[surface[point.tag + 5u] + 2u * j].xyz;
    let d = select(direction_of(other, m), -direction_of(other, m), flip);
    let f_j = waves[surface[point.tag + 6u] + 2u * j + 1u].y * select(1.0, bitcast<f32>(surface[point.tag + 18u]), r == 1u);
    let given = waves[surface[point.tag + 7u] + count * j + m];
    let unit = given / max(length(given), 1e-14);
    let z = select(unit, kite::reversed(unit), flip);
    var sum = corners;
    for (var c = 0u; c < 3u; c++) {
        let offset = corners.position[c] - place;
        let weight = max(1.0 - dot(offset, offset) / reach, 0.0);
        let turns = 0.5 * (f_j + corners.frequency[c]) * aligned_distance(offset, d, corners.direction[c]);
        sum.z[c] += weight * weight * cmul(z, kite::phasor(turns));
    }
    return sum;
}

fn load_frame(point: PatternPoint, vertex: u32) -> Frame {
    let field = surface[point.tag + 6u] + 2u * vertex;
    let d = vec3(waves[field], waves[field + 1u].x);
    return Frame(d, cross(geometry[surface[point.tag + 5u] + 2u * vertex + 1u].xyz, d));
}
