// Principal curvature directions of a posed surface; the twin of `field/curvature.rs`, where the mathematics is explained.
// Glossary in `passes.wgsl`.
//
// u            deviator of the shape operator in the frame (x, n x x) of a vertex, at twice the angle of the major direction
// transport    unit complex number that takes u from an edge's source to its target
//
// Where edge constants will be, there are meanwhile: u of all vertices, u of all vertices after the next step of smoothing,
// the measure of u, the transport of each edge. The direction pass makes directions of them, and keeps lines as long as |u|,
// from which the next frame may continue.

#import bevy_field_patterns::kite::cmul
#import bevy_field_patterns::layout::LevelRecord
#import bevy_field_patterns::parameters::{number, parameters, BLEND, CHOICE}
#import bevy_field_patterns::passes::{step, surface, geometry, wave, edges, load_item, load_level, WORKGROUP}
#import bevy_field_patterns::tangent::{any_tangent, squared_line}

// As in `curvature.rs`.
const KEEP: f32 = 0.3;
const NOISE: f32 = 1e-5;
const RIDGE: f32 = 1e-6;

fn normal_of(geometry_base: u32, i: u32) -> vec3<f32> {
    return geometry[geometry_base + 2u * i + 1u].xyz;
}

fn squared(c: vec2<f32>) -> vec2<f32> {
    return vec2(c.x * c.x - c.y * c.y, 2.0 * c.x * c.y);
}

fn deviator(base: u32, level: LevelRecord, i: u32) -> vec2<f32> {
    let v = geometry[base + 2u * i];
    if !(v.w > 0.0) {
        return vec2(0.0);
    }
    let scale = inverseSqrt(v.w);
    let n = geometry[base + 2u * i + 1u].xyz;
    let x = any_tangent(n);
    let y = cross(n, x);
    // Normal equations of S (a, b) = (p, q) for the unknowns S11, S12, S22.
    var aa = 0.0;
    var ab = 0.0;
    var bb = 0.0;
    var right = vec3(0.0);
    let first = surface[level.offset_base + i];
    let end = surface[level.offset_base + i + 1u];
    for (var k = first; k < end; k++) {
        let j = surface[level.neighbor_base + k];
        let dv = (geometry[base + 2u * j].xyz - v.xyz) * scale;
        let dn = geometry[base + 2u * j + 1u].xyz - n;
        let a = dot(dv, x);
        let b = dot(dv, y);
        let p = dot(dn, x);
        let q = dot(dn, y);
        aa += a * a;
        ab += a * b;
        bb += b * b;
        right += vec3(a * p, b * p + a * q, b * q);
    }
    let trace = aa + bb;
    if !(trace > 0.0) {
        return vec2(0.0);
    }
    aa = aa / trace + RIDGE;
    bb = bb / trace + RIDGE;
    ab = ab / trace;
    right = right / trace;
    let middle = 1.0 + RIDGE;
    let off = ab * ab;
    let determinant = aa * middle * bb - (aa + bb) * off;
    let s11 = dot(vec3(middle * bb - off, -ab * bb, off), right) / determinant;
    let s12 = dot(vec3(-ab * bb, aa * bb, -aa * ab), right) / determinant;
    let s22 = dot(vec3(off, -aa * ab, aa * middle - off), right) / determinant;
    let u = vec2(0.5 * (s11 - s22), s12);
    let clear = length(u) * sqrt(trace / f32(end - first));
    return select(vec2(0.0), u * scale, clear > NOISE && clear < 1e30);
}

@compute @workgroup_size(64)
fn deviators(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, 0u);
    let base = surface[item.x + 5u];
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        edges[level.edge_base + i] = deviator(base, level, i);
    }
}

// The unit complex number that takes u to a target with normal n from a source with normal `from_n`: twice the angle by
// which the smallest rotation between the normals turns the frame.
fn transport(n: vec3<f32>, x: vec3<f32>, from_n: vec3<f32>) -> vec2<f32> {
    let from_x = any_tangent(from_n);
    let carried = from_x - dot(n, from_x) / max(1.0 + dot(n, from_n), 1e-6) * (n + from_n);
    let angle = vec2(dot(carried, x), dot(carried, cross(n, x)));
    let r = length(angle);
    return select(vec2(1.0, 0.0), squared(angle / max(r, 1e-37)), r > 1e-6);
}

@compute @workgroup_size(64)
fn transports(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, 0u);
    let base = surface[item.x + 5u];
    let measure = level.edge_base + 2u * surface[item.x];
    let median = edges[measure].x;
    let at = parameters(item.x);
    let follows = (surface[at + CHOICE] & 4u) != 0u;
    let share = number(at + BLEND);
    let smooth_base = surface[item.x + 24u];
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let n = normal_of(base, i);
        let x = any_tangent(n);
        var u = edges[level.edge_base + i];
        if median > 0.0 {
            u /= median;
            u /= max(length(u), 1.0);
        }
        if follows {
            let before = vec3(wave[smooth_base + 2u * i], wave[smooth_base + 2u * i + 1u].x);
            u = mix(squared_line(before, x, n), u, share);
        }
        edges[level.edge_base + i] = u;
        let end = surface[level.offset_base + i + 1u];
        for (var k = surface[level.offset_base + i]; k < end; k++) {
            edges[measure + 1u + k] = transport(n, x, normal_of(base, surface[level.neighbor_base + k]));
        }
    }
}

@compute @workgroup_size(64)
fn smooth_lines(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, 0u);
    let vertices = surface[item.x];
    let odd = step.round % 2u;
    let from_u = level.edge_base + odd * vertices;
    let to_u = level.edge_base + (1u - odd) * vertices;
    let turns = level.edge_base + 2u * vertices + 1u;
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        var sum = vec2(0.0);
        let first = surface[level.offset_base + i];
        let end = surface[level.offset_base + i + 1u];
        for (var k = first; k < end; k++) {
            sum += cmul(edges[turns + k], edges[from_u + surface[level.neighbor_base + k]]);
        }
        edges[to_u + i] = KEEP * edges[from_u + i] + (1.0 - KEEP) / f32(max(end - first, 1u)) * sum;
    }
}
