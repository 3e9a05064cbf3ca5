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
// tag           word offset of the entity's record in `surface`, its MeshTag; 0: no pattern
// triangle      index of the triangle in the drawn mesh
// barycentrics  weights of corners 0 and 1 (of the drawn triangle); corner 2 has the rest
// rest space    the mesh's own space, before skin, morph targets and transform [length]
// Wave          fields and their units: `triangle_wave.wgsl`
//
// Do not import a function under the name of a field (`kite::phasor` and `wave.phasor`): naga_oil replaces both.

#import bevy_field_patterns::layout::{FLAG_DISCS, FLAG_READY, FLAG_VECTOR}
#import bevy_field_patterns::triangle_wave::{Corners, Wave, spread_disc, wave_in_triangle}

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

// The wave at a point. `defined` is false without a pattern, or before its first solve.
fn sample_wave(point: PatternPoint) -> Wave {
    var wave: Wave;
    if !has_pattern(point) {
        return wave;
    }
    let corners = load_corners(point);
    wave = wave_in_triangle(corners, (surface[point.tag + 2u] & FLAG_VECTOR) != 0u, point.b);
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

fn has_pattern(point: PatternPoint) -> bool {
    return point.tag != 0u && (surface[point.tag + 2u] & FLAG_READY) != 0u && point.triangle < surface[point.tag + 1u];
}

// What is known at the corners of the point's triangle, which must have a pattern.
fn load_corners(point: PatternPoint) -> Corners {
    let triangle = surface[point.tag + 4u] + 3u * point.triangle;
    let geometry_base = surface[point.tag + 5u];
    let field_base = surface[point.tag + 6u];
    let phasor_base = surface[point.tag + 7u];
    var corners: Corners;
    for (var m = 0u; m < 3u; m++) {
        let vertex = surface[triangle + m];
        let zf = waves[field_base + 2u * vertex + 1u];
        corners.position[m] = geometry[geometry_base + 2u * vertex].xyz;
        corners.direction[m] = vec3(waves[field_base + 2u * vertex], zf.x);
        corners.frequency[m] = zf.y;
        corners.z[m] = waves[phasor_base + vertex];
    }
    if (surface[point.tag + 2u] & FLAG_DISCS) != 0u {
        let axes = geometry_base + 2u * surface[point.tag] + 2u * surface[triangle];
        corners = spread_disc(corners, point.triangle, geometry[axes].xyz, geometry[axes + 1u].xyz);
    }
    return corners;
}
