#define_import_path bevy_field_patterns::stripe_debug

// Looks at the wave itself. All colours are linear.
//
// sigma    phase advance along an edge as the phasors have it, nearest to Omega   [periods]
// Omega    phase advance along an edge as d and f ask for it                       [periods]
// winding  sum of sigma around the triangle; not 0: a stripe begins or ends there

#import bevy_field_patterns::kite::{TAU, aligned_distance}
#import bevy_field_patterns::layout::{FLAG_VECTOR}
#import bevy_field_patterns::triangle_wave::{Corners, Wave, edge_signs, oriented}
#import bevy_field_patterns::wave::{PatternPoint, load_corners, surface}

const DEBUG_PHASE: u32 = 1u;
const DEBUG_SINGULAR: u32 = 2u;
const DEBUG_ANGLE: u32 = 3u;
const DEBUG_COLORS: u32 = 4u;
const DEBUG_ENERGY: u32 = 5u;

fn debug_color(style: u32, point: PatternPoint, wave: Wave) -> vec3<f32> {
    switch style {
        case DEBUG_PHASE: { return phase_color(wave); }
        case DEBUG_SINGULAR: { return singular_color(point, wave); }
        case DEBUG_ANGLE: { return angle_color(wave); }
        case DEBUG_COLORS: { return class_color(point); }
        default: { return energy_color(point, wave); }
    }
}

fn hue(h: f32) -> vec3<f32> {
    let rgb = clamp(abs(fract(h + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, vec3(0.0), vec3(1.0));
    return rgb * rgb;
}

fn phase_color(wave: Wave) -> vec3<f32> {
    if wave.vector {
        return hue(atan2(wave.phasor.y, wave.phasor.x) / TAU);
    }
    let away = select(vec3(0.02, 0.10, 0.60), vec3(0.60, 0.03, 0.02), wave.value > 0.0);
    return mix(vec3(1.0), away, abs(wave.value));
}

// Omega and sigma - Omega of the edge from corner i to corner j, oriented alike first.
fn edge_advance(corners: Corners, i: u32, j: u32) -> vec2<f32> {
    let e = corners.position[j] - corners.position[i];
    let f = 0.5 * (corners.frequency[i] + corners.frequency[j]);
    let omega = f * aligned_distance(e, corners.direction[i], corners.direction[j]);
    let z_i = corners.z[i];
    let z_j = corners.z[j];
    let advance = atan2(z_j.y * z_i.x - z_j.x * z_i.y, dot(z_i, z_j)) / TAU - omega;
    return vec2(omega, advance - round(advance));
}

// The corners in one frame; of an odd triangle with the last edge left wrong.
fn framed_corners(point: PatternPoint) -> Corners {
    let corners = load_corners(point, 0u);
    if (surface[point.tag + 2u] & FLAG_VECTOR) != 0u {
        return corners;
    }
    let s = edge_signs(corners);
    return oriented(corners, vec3(1.0, s.x, s.z));
}

fn winding(corners: Corners) -> f32 {
    let sum = edge_advance(corners, 0u, 1u) + edge_advance(corners, 1u, 2u) + edge_advance(corners, 2u, 0u);
    return round(sum.x + sum.y);
}

fn singular_color(point: PatternPoint, wave: Wave) -> vec3<f32> {
    if wave.odd {
        return vec3(0.9, 0.7, 0.0);
    }
    let n = winding(framed_corners(point));
    if n != 0.0 {
        return select(vec3(0.05, 0.15, 0.9), vec3(0.9, 0.05, 0.05), n > 0.0);
    }
    return vec3(mix(0.15, 0.9, wave.confidence));
}

// 0 dark violet, 45 green, 90 degrees yellow.
fn angle_color(wave: Wave) -> vec3<f32> {
    let slope = length(wave.gradient);
    // d in the triangle's plane: what the gradient can follow.
    let normal = wave.normal;
    let d = wave.direction - normal * dot(normal, wave.direction);
    let c = abs(dot(wave.gradient, d)) / max(slope * length(d), 1e-20);
    let t = acos(min(c, 1.0)) / (0.25 * TAU);
    let low = mix(vec3(0.06, 0.002, 0.09), vec3(0.015, 0.28, 0.27), min(2.0 * t, 1.0));
    return mix(low, vec3(0.98, 0.80, 0.02), max(2.0 * t - 1.0, 0.0));
}

fn class_color(point: PatternPoint) -> vec3<f32> {
    let nearest = select(select(2u, 1u, point.b.y >= point.b.z), 0u, point.b.x >= max(point.b.y, point.b.z));
    let vertex = surface[surface[point.tag + 4u] + 3u * point.triangle + nearest];
    let class_base = surface[point.tag + 8u];
    let colors = surface[point.tag + 9u];
    var class_index = 0u;
    while class_index + 1u < colors && surface[class_base + class_index + 1u] <= vertex {
        class_index += 1u;
    }
    return mix(vec3(0.15), hue(f32(class_index) * 0.618034), 0.8);
}

// Mean of w (1 - cos r) over the edges. Each edge is oriented on its own, as the solver does.
fn energy_color(point: PatternPoint, wave: Wave) -> vec3<f32> {
    let corners = load_corners(point, 0u);
    let s = select(edge_signs(corners), vec3(1.0), wave.vector);
    var sum = vec2(0.0);
    for (var k = 0u; k < 3u; k++) {
        let j = (k + 1u) % 3u;
        var signs = vec3(1.0);
        signs[j] = s[k];
        let edge = oriented(corners, signs);
        let weight = max(0.0, dot(edge.direction[k], edge.direction[j]));
        sum += weight * vec2(1.0 - cos(TAU * edge_advance(edge, k, j).y), 1.0);
    }
    let energy = sum.x / max(sum.y, 1e-6);
    return mix(
        mix(vec3(0.005), vec3(0.75, 0.03, 0.01), min(2.0 * energy, 1.0)),
        vec3(1.0, 0.85, 0.1),
        clamp(2.0 * energy - 1.0, 0.0, 1.0),
    );
}
