// How good the waves are: energy and branches, by tree reduction. Glossary in `passes.wgsl`.
//
// r        residual of an edge: how far its source, seen from its target, is off              [rad]
// off      w (1 - cos r) of a directed edge = |w z_i - seen|^2 / 2w, without cancellation
// branch   a triangle around which the phase winds

#import bevy_field_patterns::layout::{FLAG_CROSS, FLAG_VECTOR, LevelRecord}
#import bevy_field_patterns::kite::{
    Coupling, Frame, TAU, aligned_distance, direction_of, quarter_turns, reversed, turned_reversed, turned_wave,
}
#import bevy_field_patterns::passes::{
    step, items, surface, geometry, wave, edges, balance, load_item, load_level, normalize_or, seen_fine, state_base, swap_of,
    STATE_OFF, STATE_WEIGHT, STATE_BRANCHES, STATE_BEFORE, STATE_DONE, STATE_SWEEPS, STATE_WORDS, WORKGROUP,
}

var<workgroup> sums: array<vec2<f32>, 64>;

// The sum of `value` over the workgroup, valid in thread 0.
fn workgroup_sum(value: vec2<f32>, local: u32) -> vec2<f32> {
    sums[local] = value;
    workgroupBarrier();
    for (var half = 32u; half > 0u; half /= 2u) {
        if local < half {
            sums[local] += sums[local + half];
        }
        workgroupBarrier();
    }
    return sums[0];
}

// Sums of off and of w over the edges into wave r of vertex i; `at` is the mesh's level record.
fn vertex_energy(at: LevelRecord, i: u32, r: u32) -> vec2<f32> {
    let one = vec2(1.0, 0.0);
    let z = normalize_or(wave[at.node_base + at.waves * i + r], one);
    var sum = vec2(0.0);
    let end = surface[at.offset_base + i + 1u];
    for (var k = surface[at.offset_base + i]; k < end; k++) {
        let e = edges[at.edge_base + at.waves * k + r];
        let source = at.waves * surface[at.neighbor_base + k] + (r ^ (swap_of(e) & (at.waves - 1u)));
        let seen = seen_fine(e, normalize_or(wave[at.node_base + source], one));
        let w = length(seen);
        if w > 0.0 {
            let off = w * z - seen;
            sum += vec2(dot(off, off) / (2.0 * w), w);
        }
    }
    return sum;
}

// Per item (record, partial, first vertex, end): its sums of off and of w.
@compute @workgroup_size(64)
fn energy_partial(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, 0u);
    var sum = vec2(0.0);
    for (var own = level.waves * item.z + local; own < level.waves * item.w; own += WORKGROUP) {
        sum += vertex_energy(level, own / level.waves, own % level.waves);
    }
    sum = workgroup_sum(sum, local);
    if local == 0u && item.z < item.w {
        let partial = state_base(item.x) + STATE_WORDS + 2u * item.y;
        balance[partial] = sum.x;
        balance[partial + 1u] = sum.y;
    }
}

// Per item (record, _, first partial, end of partials) the sum of pairs; the energy of the entity.
@compute @workgroup_size(64)
fn energy_total(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let state = state_base(item.x);
    var sum = vec2(0.0);
    for (var n = item.z + local; n < item.w; n += 64u) {
        sum += vec2(balance[state + STATE_WORDS + 2u * n], balance[state + STATE_WORDS + 2u * n + 1u]);
    }
    sum = workgroup_sum(sum, local);
    if local == 0u && item.z < item.w {
        balance[state + STATE_OFF] = sum.x;
        balance[state + STATE_WEIGHT] = sum.y;
    }
}

// Per item (record, _, 0, 1): ends the local rule where the energy no longer changes (Eq. 12).
@compute @workgroup_size(1)
fn decide(@builtin(workgroup_id) group: vec3<u32>) {
    let item = load_item(group);
    let state = state_base(item.x);
    if item.w == 0u || balance[state + STATE_DONE] > 0.0 {
        return;
    }
    let energy = balance[state + STATE_OFF] / max(balance[state + STATE_WEIGHT], 1e-30);
    let before = balance[state + STATE_BEFORE];
    balance[state + STATE_SWEEPS] += 1.0;
    if balance[state + STATE_SWEEPS] > 1.0 && abs(before - energy) < step.epsilon * before {
        balance[state + STATE_DONE] = 1.0;
    }
    balance[state + STATE_BEFORE] = energy;
}

fn wrapped(angle: f32) -> f32 {
    return angle - TAU * round(angle / TAU);
}

// The number of waves that wind around triangle t: stripes of theirs begin or end in it. 0 for triangles whose corners
// cannot be turned alike.
fn windings(record: u32, t: u32) -> f32 {
    let flags = surface[record + 2u];
    let waves = surface[record + 17u];
    let coupling = Coupling(waves, (flags & FLAG_VECTOR) != 0u, (flags & FLAG_CROSS) != 0u);
    let corner = surface[record + 4u] + 3u * t;
    let v = vec3(surface[corner], surface[corner + 1u], surface[corner + 2u]);
    if v.x == v.y || v.y == v.z || v.z == v.x {
        return 0.0;
    }
    var p: array<vec3<f32>, 3>;
    var f: array<f32, 3>;
    var frames: array<Frame, 3>;
    var turns: array<u32, 3>;
    for (var c = 0u; c < 3u; c++) {
        p[c] = geometry[surface[record + 5u] + 2u * v[c]].xyz;
        let field = surface[record + 6u] + 2u * v[c];
        let d = vec3(wave[field], wave[field + 1u].x);
        frames[c] = Frame(d, cross(geometry[surface[record + 5u] + 2u * v[c] + 1u].xyz, d));
        f[c] = wave[field + 1u].y;
        turns[c] = quarter_turns(coupling, frames[c], frames[0]);
    }
    if ((turns[1] + quarter_turns(coupling, frames[2], frames[1]) - turns[2]) & 3u) != 0u {
        return 0.0;
    }
    var count = 0.0;
    for (var r = 0u; r < waves; r++) {
        var d: array<vec3<f32>, 3>;
        var z: array<vec2<f32>, 3>;
        for (var c = 0u; c < 3u; c++) {
            let m = turned_wave(turns[c], r);
            d[c] = direction_of(frames[c], m);
            z[c] = wave[surface[record + 7u] + waves * v[c] + m];
            if turned_reversed(turns[c], r) {
                d[c] = -d[c];
                z[c] = reversed(z[c]);
            }
        }
        let ratio = select(1.0, bitcast<f32>(surface[record + 18u]), r == 1u);
        var around = 0.0;
        for (var c = 0u; c < 3u; c++) {
            let next = (c + 1u) % 3u;
            let omega = TAU * ratio * 0.5 * (f[c] + f[next]) * aligned_distance(p[next] - p[c], d[c], d[next]);
            around += omega + wrapped(atan2(z[next].y, z[next].x) - atan2(z[c].y, z[c].x) - omega);
        }
        count += select(0.0, 1.0, abs(around) > 0.5 * TAU);
    }
    return count;
}

// Per item (record, partial, first triangle, end): its number of branches.
@compute @workgroup_size(64)
fn branches_partial(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    var count = 0.0;
    for (var t = item.z + local; t < item.w; t += WORKGROUP) {
        count += windings(item.x, t);
    }
    let sum = workgroup_sum(vec2(count, 0.0), local);
    if local == 0u && item.z < item.w {
        balance[state_base(item.x) + STATE_WORDS + item.y] = sum.x;
    }
}

// Per item (record, _, first partial, end): the number of branches of the entity.
@compute @workgroup_size(64)
fn branches_total(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let state = state_base(item.x);
    var sum = 0.0;
    for (var n = item.z + local; n < item.w; n += 64u) {
        sum += balance[state + STATE_WORDS + n];
    }
    let total = workgroup_sum(vec2(sum, 0.0), local).x;
    if local == 0u && item.z < item.w {
        balance[state + STATE_BRANCHES] = total;
    }
}

// Over all items of the step (one per entity): energy and branches of all patterns, in balance[0] and balance[1].
@compute @workgroup_size(64)
fn report(@builtin(local_invocation_index) local: u32) {
    var energy = vec2(0.0);
    var branches = 0.0;
    for (var n = local; n < step.item_count; n += 64u) {
        let state = state_base(items[step.first_item + n].x);
        energy += vec2(balance[state + STATE_OFF], balance[state + STATE_WEIGHT]);
        branches += balance[state + STATE_BRANCHES];
    }
    energy = workgroup_sum(energy, local);
    workgroupBarrier();
    branches = workgroup_sum(vec2(branches, 0.0), local).x;
    if local == 0u {
        balance[0] = energy.x / max(energy.y, 1e-30);
        balance[1] = branches;
    }
}
