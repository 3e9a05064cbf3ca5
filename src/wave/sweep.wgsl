// Sweeps over the vertices of the mesh: the coloured relaxation and the local rule. Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::LevelRecord
#import bevy_field_patterns::kite::phasor
#import bevy_field_patterns::passes::{
    step, surface, geometry, wave, edges, balance, STATE_DONE, WORKGROUP, load_item, load_level, seen_fine, swap_of, relax,
    normalize_or, pull_of, state_base,
}

// What wave r of vertex i sees in sum; `at` is the mesh's level record. A crest is at z = i.
fn seen_sum(record: u32, at: LevelRecord, i: u32, r: u32) -> vec2<f32> {
    var t = vec2(0.0, pull_of(record, r, i));
    let end = surface[at.offset_base + i + 1u];
    for (var k = surface[at.offset_base + i]; k < end; k++) {
        let e = edges[at.edge_base + at.waves * k + r];
        let source = at.waves * surface[at.neighbor_base + k] + (r ^ (swap_of(e) & (at.waves - 1u)));
        t += seen_fine(e, wave[at.node_base + source]);
    }
    return t;
}

// Sweep of one colour class of the mesh.
@compute @workgroup_size(64)
fn sweep_fine(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, 0u);
    for (var own = level.waves * item.z + local; own < level.waves * item.w; own += WORKGROUP) {
        let t = seen_sum(item.x, level, own / level.waves, own % level.waves);
        let weight = abs(balance[level.balance_base + own]);
        let z = wave[level.node_base + own];
        wave[level.node_base + own] = relax(z, t, weight, step.relaxation, step.omega, step.softness);
    }
}

fn hash_turns(id: u32) -> f32 {
    var x = 0u;
    for (var byte = 0u; byte < 4u; byte++) {
        x += (id >> (8u * byte)) & 255u;
        x += x << 10u;
        x ^= x >> 6u;
    }
    x += x << 3u;
    x ^= x >> 11u;
    x += x << 15u;
    return f32(x >> 8u) / 16777216.0;
}

// The start of the local rule: a phase from the mesh's own vertex id, no momentum.
@compute @workgroup_size(64)
fn start_local(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let id = bitcast<u32>(geometry[surface[item.x + 5u] + 2u * i + 1u].w);
        let waves = surface[item.x + 17u];
        for (var r = 0u; r < waves; r++) {
            wave[surface[item.x + 7u] + waves * i + r] = phasor(hash_turns(id ^ (r << 31u)));
            wave[surface[item.x + 15u] + waves * i + r] = vec2(0.0);
        }
    }
    if item.z + local == 0u && item.w > 0u {
        for (var n = 0u; n < 8u; n++) {
            balance[state_base(item.x) + n] = 0.0;
        }
    }
}

// One colour class of the local rule (Eq. 9 to 11); nothing where the entity's energy has settled.
@compute @workgroup_size(64)
fn sweep_local(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    if item.z >= item.w || balance[state_base(item.x) + STATE_DONE] > 0.0 {
        return;
    }
    let level = load_level(item.x, 0u);
    for (var own = level.waves * item.z + local; own < level.waves * item.w; own += WORKGROUP) {
        let t = seen_sum(item.x, level, own / level.waves, own % level.waves);
        let delta = surface[item.x + 15u] + own;
        let old = wave[level.node_base + own];
        wave[level.node_base + own] = normalize_or(t + wave[delta], old);
        wave[delta] = step.momentum * (t - old);
    }
}
