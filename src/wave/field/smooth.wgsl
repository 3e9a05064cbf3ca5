// Smoothing of a field of lines or crosses on the graph's hierarchy; once per change of what it is drawn to. The twin of
// `smooth.rs`. Glossaries in `passes.wgsl`, `cross.wgsl`.
//
// wave[smooth_base + 2 m] is u of node m, the next one what it is drawn to; m counts the nodes of all levels, finest first.

#import bevy_field_patterns::cross::{Frame, frame_at, power_of, root_of, carried_power, compatible}
#import bevy_field_patterns::deform::{carrying_map, load_carrier}
#import bevy_field_patterns::layout::LevelRecord
#import bevy_field_patterns::parameters::{parameters, CHOICE}
#import bevy_field_patterns::passes::{surface, geometry, wave, load_item, load_level, normalize_or, WORKGROUP}

// What constraints of the children count in their parent, whose edges stand for fewer than its children's.
const CHILD_WEIGHT: f32 = 0.5;

fn ring_of(record: u32) -> u32 {
    return select(2u, 4u, (surface[parameters(record) + CHOICE] & 1u) != 0u);
}

fn is_extrinsic(record: u32) -> bool {
    return (surface[parameters(record) + CHOICE] & 2u) != 0u;
}

// Where u of node i lies.
fn place(record: u32, level: LevelRecord, i: u32) -> u32 {
    let before = (level.node_base - load_level(record, 0u).node_base) / level.waves;
    return surface[record + 24u] + 2u * (before + i);
}

// A node stands where its root vertex stands.
fn node_frame(record: u32, index: u32, i: u32) -> Frame {
    var v = i;
    for (var above = index; above > 0u; above--) {
        let level = load_level(record, above - 1u);
        v = surface[level.child_base + surface[level.child_offset_base + v]];
    }
    return frame_at(geometry[surface[record + 5u] + 2u * v + 1u].xyz);
}

// What each vertex is drawn to.
@compute @workgroup_size(64)
fn smooth_constrain(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, 0u);
    let carrier = load_carrier(item.x);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let given = geometry[surface[item.x + 21u] + i];
        let c = power_of(node_frame(item.x, 0u, i), carrying_map(carrier, i) * given.xyz, ring_of(item.x));
        wave[place(item.x, level, i) + 1u] = given.w * c;
    }
}

// Items are nodes of the coarser level, item.y + 1.
@compute @workgroup_size(64)
fn smooth_restrict(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, item.y);
    let coarse = load_level(item.x, item.y + 1u);
    let ring = ring_of(item.x);
    for (var p = item.z + local; p < item.w; p += WORKGROUP) {
        let frame = node_frame(item.x, item.y + 1u, p);
        var sum = vec2(0.0);
        let end = surface[level.child_offset_base + p + 1u];
        for (var c = surface[level.child_offset_base + p]; c < end; c++) {
            let child = surface[level.child_base + c];
            let drawn = wave[place(item.x, level, child) + 1u];
            sum += carried_power(frame, drawn, node_frame(item.x, item.y, child), ring);
        }
        wave[place(item.x, coarse, p) + 1u] = CHILD_WEIGHT * sum;
    }
}

// The top of the hierarchy.
@compute @workgroup_size(64)
fn smooth_start(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, item.y);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let at = place(item.x, level, i);
        wave[at] = normalize_or(wave[at + 1u], vec2(1.0, 0.0));
    }
}

// From the parents, one level up.
@compute @workgroup_size(64)
fn smooth_prolong(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, item.y);
    let coarse = load_level(item.x, item.y + 1u);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let parent = surface[level.parent_base + i];
        let u = wave[place(item.x, coarse, parent)];
        let above = node_frame(item.x, item.y + 1u, parent);
        let carried_u = carried_power(node_frame(item.x, item.y, i), u, above, ring_of(item.x));
        wave[place(item.x, level, i)] = normalize_or(carried_u, vec2(1.0, 0.0));
    }
}

fn relaxed_intrinsic(record: u32, index: u32, level: LevelRecord, i: u32) -> vec2<f32> {
    let ring = ring_of(record);
    let frame = node_frame(record, index, i);
    let at = place(record, level, i);
    var sum = wave[at + 1u];
    let end = surface[level.offset_base + i + 1u];
    for (var k = surface[level.offset_base + i]; k < end; k++) {
        let j = surface[level.neighbor_base + k];
        sum += carried_power(frame, wave[place(record, level, j)], node_frame(record, index, j), ring);
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

fn relaxed_extrinsic(record: u32, index: u32, level: LevelRecord, i: u32) -> vec2<f32> {
    let ring = ring_of(record);
    let frame = node_frame(record, index, i);
    let at = place(record, level, i);
    var d = root_of(frame, wave[at], ring);
    var weight = 0.0;
    let end = surface[level.offset_base + i + 1u];
    for (var k = surface[level.offset_base + i]; k < end; k++) {
        let j = surface[level.neighbor_base + k];
        let other = node_frame(record, index, j);
        let d_j = root_of(other, wave[place(record, level, j)], ring);
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
    let level = load_level(item.x, item.y);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let at = place(item.x, level, i);
        if is_extrinsic(item.x) {
            wave[at] = relaxed_extrinsic(item.x, item.y, level, i);
        } else {
            wave[at] = relaxed_intrinsic(item.x, item.y, level, i);
        }
    }
}
