// Smoothing of a field of lines or crosses on the graph's hierarchy; once per change of what it is drawn to. The twin of
// `smooth.rs`. Glossaries in `passes.wgsl`, `cross.wgsl`.
//
// wave[smooth_base + 2 m] is u of node m, the next one what it is drawn to; m counts the nodes of all levels, finest first.
// Once directions are made, the two of a vertex hold its direction in space instead, from which the next frame continues.

#import bevy_field_patterns::cross::{Frame, frame_at, power_of, root_of, carried_power, compatible}
#import bevy_field_patterns::deform::{Carrier, carrying_map, load_carrier}
#import bevy_field_patterns::layout::LevelRecord
#import bevy_field_patterns::parameters::{parameters, CHOICE}
#import bevy_field_patterns::passes::{surface, geometry, wave, load_item, load_level, normalize_or, WORKGROUP}

// What constraints of the children count in their parent, whose edges stand for fewer than its children's.
const CHILD_WEIGHT: f32 = 0.5;

// A level of an entity's field.
struct Field {
    record: u32,
    index: u32,
    ring: u32,
    geometry_base: u32,
    // Of u of node 0.
    base: u32,
    level: LevelRecord,
}

fn load_field(record: u32, index: u32) -> Field {
    let level = load_level(record, index);
    let before = (level.node_base - load_level(record, 0u).node_base) / level.waves;
    let ring = select(2u, 4u, (surface[parameters(record) + CHOICE] & 1u) != 0u);
    return Field(record, index, ring, surface[record + 5u], surface[record + 24u] + 2u * before, level);
}

// A node stands where its root vertex stands.
fn node_frame(field: Field, i: u32) -> Frame {
    var v = i;
    for (var above = field.index; above > 0u; above--) {
        let level = load_level(field.record, above - 1u);
        v = surface[level.child_base + surface[level.child_offset_base + v]];
    }
    return frame_at(geometry[field.geometry_base + 2u * v + 1u].xyz);
}

// What a vertex is drawn to.
fn drawn_to(field: Field, carrier: Carrier, given_base: u32, frame: Frame, i: u32) -> vec2<f32> {
    let given = geometry[given_base + i];
    return given.w * power_of(frame, carrying_map(carrier, i) * given.xyz, field.ring);
}

@compute @workgroup_size(64)
fn smooth_constrain(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let field = load_field(item.x, 0u);
    let carrier = load_carrier(item.x);
    let given_base = surface[item.x + 21u];
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        wave[field.base + 2u * i + 1u] = drawn_to(field, carrier, given_base, node_frame(field, i), i);
    }
}

// Continues from the directions of the frame before.
@compute @workgroup_size(64)
fn smooth_follow(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let field = load_field(item.x, 0u);
    let carrier = load_carrier(item.x);
    let given_base = surface[item.x + 21u];
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let frame = node_frame(field, i);
        let at = field.base + 2u * i;
        let before = vec3(wave[at], wave[at + 1u].x);
        wave[at] = normalize_or(power_of(frame, before, field.ring), vec2(1.0, 0.0));
        wave[at + 1u] = drawn_to(field, carrier, given_base, frame, i);
    }
}

// Items are nodes of the coarser level, item.y + 1.
@compute @workgroup_size(64)
fn smooth_restrict(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let field = load_field(item.x, item.y);
    let level = field.level;
    let coarse = load_field(item.x, item.y + 1u);
    for (var p = item.z + local; p < item.w; p += WORKGROUP) {
        let frame = node_frame(coarse, p);
        var sum = vec2(0.0);
        let end = surface[level.child_offset_base + p + 1u];
        for (var c = surface[level.child_offset_base + p]; c < end; c++) {
            let child = surface[level.child_base + c];
            let drawn = wave[field.base + 2u * child + 1u];
            sum += carried_power(frame, drawn, node_frame(field, child), field.ring);
        }
        wave[coarse.base + 2u * p + 1u] = CHILD_WEIGHT * sum;
    }
}

// The top of the hierarchy.
@compute @workgroup_size(64)
fn smooth_start(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let field = load_field(item.x, item.y);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let at = field.base + 2u * i;
        wave[at] = normalize_or(wave[at + 1u], vec2(1.0, 0.0));
    }
}

// From the parents, one level up.
@compute @workgroup_size(64)
fn smooth_prolong(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let field = load_field(item.x, item.y);
    let coarse = load_field(item.x, item.y + 1u);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let parent = surface[field.level.parent_base + i];
        let u = wave[coarse.base + 2u * parent];
        let carried_u = carried_power(node_frame(field, i), u, node_frame(coarse, parent), field.ring);
        wave[field.base + 2u * i] = normalize_or(carried_u, vec2(1.0, 0.0));
    }
}

fn relaxed_intrinsic(field: Field, i: u32) -> vec2<f32> {
    let frame = node_frame(field, i);
    let at = field.base + 2u * i;
    var sum = wave[at + 1u];
    let end = surface[field.level.offset_base + i + 1u];
    for (var k = surface[field.level.offset_base + i]; k < end; k++) {
        let j = surface[field.level.neighbor_base + k];
        sum += carried_power(frame, wave[field.base + 2u * j], node_frame(field, j), field.ring);
    }
    return normalize_or(sum, wave[at]);
}

// Adds a direction with normal n_b to the mean d of the given weight.
fn added(d: vec3<f32>, n: vec3<f32>, b: vec3<f32>, n_b: vec3<f32>, weights: vec2<f32>, ring: u32) -> vec3<f32> {
    let pair = compatible(d, n, b, n_b, ring);
    let sum = pair.a * weights.x + pair.b * weights.y;
    let tangent = sum - n * dot(n, sum);
    let r = length(tangent);
    if r > 0.0 {
        return tangent / r;
    }
    return pair.a;
}

fn relaxed_extrinsic(field: Field, i: u32) -> vec2<f32> {
    let ring = field.ring;
    let frame = node_frame(field, i);
    let at = field.base + 2u * i;
    var d = root_of(frame, wave[at], ring);
    var weight = 0.0;
    let end = surface[field.level.offset_base + i + 1u];
    for (var k = surface[field.level.offset_base + i]; k < end; k++) {
        let j = surface[field.level.neighbor_base + k];
        let other = node_frame(field, j);
        let d_j = root_of(other, wave[field.base + 2u * j], ring);
        d = added(d, frame.n, d_j, other.n, vec2(weight, 1.0), ring);
        weight += 1.0;
    }
    let drawn = wave[at + 1u];
    let pull = length(drawn);
    if pull > 0.0 {
        d = added(d, frame.n, root_of(frame, drawn, ring), frame.n, vec2(weight, pull), ring);
    }
    return power_of(frame, d, ring);
}

// Sweep of one colour class of a level.
@compute @workgroup_size(64)
fn smooth_sweep(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let field = load_field(item.x, item.y);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
#if KIND == 1
        wave[field.base + 2u * i] = relaxed_extrinsic(field, i);
#else
        wave[field.base + 2u * i] = relaxed_intrinsic(field, i);
#endif
    }
}
