#define_import_path bevy_field_patterns::triangle_wave

// The wave inside a triangle (Eq. 13 and 14 of Lichtenberg et al. 2018); the twin of `wave/shade.rs`. Pure functions.
//
// v_m, d_m, f_m, z_m  position [length], unit direction, frequency [periods/length], phasor at corner m
// b                   barycentrics of the point P, sum 1
// s                   signs +1/-1 that turn the corners to point alike (a line field has no sign of its own)
// Phi                 the phase; Wave.phasor = cis(Phi), Wave.gradient = grad(Phi) / 2 pi [periods/length]

#import bevy_field_patterns::kite

const TINY: f32 = 1e-37;
const MIN_EDGE_WEIGHT: f32 = 1e-9;

struct Corners {
    position: mat3x3<f32>,
    direction: mat3x3<f32>,
    frequency: vec3<f32>,
    z: mat3x2<f32>,
}

struct Wave {
    // There is a pattern here.
    defined: bool,
    // The phase is defined, not only its sine.
    vector: bool,
    // The corners cannot be turned to point alike.
    odd: bool,
    // sin(Phi), continuous across edges for both symmetries.
    value: f32,
    // cis(Phi), modulus 1; of a line field in this triangle's frame (the neighbour may see pi - Phi).
    phasor: vec2<f32>,
    // How well the corners agree: 0 (a branch) to 1.
    confidence: f32,
    // grad(Phi) / 2 pi in the triangle's plane, in the space of `position` [periods/length].
    gradient: vec3<f32>,
    // Unit direction, oriented as the phase is.
    direction: vec3<f32>,
    // [periods/length]
    frequency: f32,
    // In the space that the pattern is solved in: at rest, or as posed with `PatternPose::Live` [length].
    position: vec3<f32>,
    // Unit normal of the triangle; zero if it has no area.
    normal: vec3<f32>,
    // Derivatives of Phi / 2 pi along the screen [periods/pixel]; filled by `sample_wave`.
    per_pixel: vec2<f32>,
    // How far the phase moves along the two sides of a pixel, and along its gradient: how much of a period a pixel
    // covers [periods/pixel]; filled by `sample_wave`.
    sides: vec2<f32>,
    footprint: f32,
}

fn wave_in_triangle(corners: Corners, vector: bool, b: vec3<f32>) -> Wave {
    let s = edge_signs(corners);
    var wave: Wave;
    if vector {
        wave = corner_sum(corners, b, b, barycentric_gradients(corners));
        wave.vector = true;
    } else if s.x * s.y * s.z > 0.0 {
        wave = corner_sum(oriented(corners, vec3(1.0, s.x, s.z)), b, b, barycentric_gradients(corners));
    } else {
        wave = odd_wave(corners, b, s);
    }
    wave.defined = true;
    wave.position = corners.position[0] + offset(corners, 0u, b);
    wave.normal = triangle_normal(corners);
    return wave;
}

// Signs of <d_0, d_1>, <d_1, d_2>, <d_2, d_0>.
fn edge_signs(corners: Corners) -> vec3<f32> {
    let d = corners.direction;
    let c = vec3(dot(d[0], d[1]), dot(d[1], d[2]), dot(d[2], d[0]));
    return select(vec3(1.0), vec3(-1.0), c < vec3(0.0));
}

fn oriented(corners: Corners, s: vec3<f32>) -> Corners {
    var turned = corners;
    for (var m = 0u; m < 3u; m++) {
        if s[m] < 0.0 {
            turned.direction[m] = -corners.direction[m];
            turned.z[m] = kite::reversed(corners.z[m]);
        }
    }
    return turned;
}

// P - v_m from differences of corners: exact far from the origin. [length]
fn offset(corners: Corners, m: u32, b: vec3<f32>) -> vec3<f32> {
    let v = corners.position;
    let origin = v[m];
    return mat3x3(v[0] - origin, v[1] - origin, v[2] - origin) * b;
}

fn triangle_normal(corners: Corners) -> vec3<f32> {
    let v = corners.position;
    let normal = cross(v[1] - v[0], v[2] - v[0]);
    return normal / max(length(normal), TINY);
}

// grad(b_m) as columns; zero for a triangle without an area. [1/length]
fn barycentric_gradients(corners: Corners) -> mat3x3<f32> {
    let v = corners.position;
    let normal = cross(v[1] - v[0], v[2] - v[0]);
    let n = normal / max(dot(normal, normal), TINY);
    return mat3x3(cross(n, v[2] - v[1]), cross(n, v[0] - v[2]), cross(n, v[1] - v[0]));
}

// The phasor sum of corners that are oriented alike; `weight` is how much each counts.
fn corner_sum(corners: Corners, weight: vec3<f32>, b: vec3<f32>, weight_gradient: mat3x3<f32>) -> Wave {
    let d_sum = corners.direction * weight;
    let d_length = length(d_sum);
    let direction = d_sum / max(d_length, TINY);
    let frequency = dot(weight, corners.frequency);
    var sum = vec2(0.0);
    var slope_re = vec3(0.0);
    var slope_im = vec3(0.0);
    for (var m = 0u; m < 3u; m++) {
        let distance = kite::aligned_distance(offset(corners, m, b), corners.direction[m], direction);
        let z = corners.z[m] / max(length(corners.z[m]), TINY);
        let prediction = kite::cmul(z, kite::phasor(0.5 * (corners.frequency[m] + frequency) * distance));
        sum += weight[m] * prediction;
        slope_re += prediction.x * weight_gradient[m];
        slope_im += prediction.y * weight_gradient[m];
    }
    let modulus = length(sum);
    let unit = select(vec2(1.0, 0.0), sum / max(modulus, TINY), modulus > TINY);
    // Each prediction turns by 2 pi f d, and the weights shift between predictions that do not agree.
    let disagreement = (unit.x * slope_im - unit.y * slope_re) / (kite::TAU * max(modulus, 1e-4));
    var wave: Wave;
    wave.value = unit.y;
    wave.phasor = unit;
    // Where the directions of a vector field cancel, no phase is any better than another.
    wave.confidence = modulus * smoothstep(0.05, 0.15, d_length);
    wave.gradient = frequency * in_plane(direction, weight_gradient) + disagreement;
    wave.direction = direction;
    wave.frequency = frequency;
    return wave;
}

// The part of d in the triangle's plane; d itself if there is no plane.
fn in_plane(d: vec3<f32>, gradients: mat3x3<f32>) -> vec3<f32> {
    let normal = cross(gradients[0], gradients[1]);
    return d - normal * (dot(normal, d) / max(dot(normal, normal), TINY));
}

// The waves of the three edges, blended by b_i b_j.
fn odd_wave(corners: Corners, b: vec3<f32>, s: vec3<f32>) -> Wave {
    let inside = max(b, vec3(MIN_EDGE_WEIGHT));
    let product = inside * inside.yzx;
    let share = product / (product.x + product.y + product.z);
    var ends = array<vec3<f32>, 3>(vec3(1.0, 1.0, 0.0), vec3(0.0, 1.0, 1.0), vec3(1.0, 0.0, 1.0));
    var turn = array<vec3<f32>, 3>(vec3(1.0, s.x, 1.0), vec3(1.0, 1.0, s.y), vec3(1.0, 1.0, s.z));
    var blend: Wave;
    blend.odd = true;
    for (var k = 0u; k < 3u; k++) {
        let weight = inside * ends[k];
        let edge = corner_sum(oriented(corners, turn[k]), weight / dot(weight, vec3(1.0)), b, mat3x3<f32>());
        blend = add_share(blend, edge, share[k]);
    }
    return blended(blend);
}

// Adds a wave that knows one edge only to a blend of three. Phi and pi - Phi are the same here: the one with cos >= 0 is
// taken, so that gradients can be added.
fn add_share(sum: Wave, edge: Wave, share: f32) -> Wave {
    let fold = select(1.0, -1.0, edge.phasor.x < 0.0);
    var blend = sum;
    blend.value += share * edge.value;
    blend.confidence += share * edge.confidence;
    blend.gradient += share * fold * edge.gradient;
    blend.direction += share * fold * edge.direction;
    blend.frequency += share * edge.frequency;
    return blend;
}

fn blended(sum: Wave) -> Wave {
    var blend = sum;
    blend.phasor = vec2(sqrt(max(0.0, 1.0 - blend.value * blend.value)), blend.value);
    return blend;
}
