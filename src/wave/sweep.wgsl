// Sweeps over the vertices of the mesh: the coloured relaxation and the local rule. Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::RECORD_WORDS
#import bevy_field_patterns::kite::phasor
#import bevy_field_patterns::passes::{
    step, surface, wave, edges, balance, STATE_DONE, load_item, seen_fine, relax, normalize_or, state_base
}

// Sweep of one colour class of the mesh.
@compute @workgroup_size(64)
fn sweep_fine(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let i = item.z + local;
    if i >= item.w {
        return;
    }
    let at = item.x + RECORD_WORDS;
    let offset_base = surface[at + 1u];
    let neighbor_base = surface[at + 2u];
    let node_base = surface[at + 6u];
    let edge_base = surface[at + 7u];
    var t = vec2(0.0);
    let end = surface[offset_base + i + 1u];
    for (var k = surface[offset_base + i]; k < end; k++) {
        t += seen_fine(edges[edge_base + k], wave[node_base + surface[neighbor_base + k]]);
    }
    let weight = abs(balance[surface[at + 8u] + i]);
    let z = wave[node_base + i];
    wave[node_base + i] = relax(z, t, weight, step.relaxation, step.omega, step.softness);
}

// What vertex i sees in sum.
fn seen_sum(record: u32, i: u32) -> vec2<f32> {
    let at = record + RECORD_WORDS;
    var t = vec2(0.0);
    let end = surface[surface[at + 1u] + i + 1u];
    for (var k = surface[surface[at + 1u] + i]; k < end; k++) {
        t += seen_fine(edges[surface[at + 7u] + k], wave[surface[at + 6u] + surface[surface[at + 2u] + k]]);
    }
    return t;
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

// The start of the local rule: a phase from the vertex id, no momentum.
@compute @workgroup_size(64)
fn start_local(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let i = item.z + local;
    if i < item.w {
        wave[surface[item.x + 7u] + i] = phasor(hash_turns(i));
        wave[surface[item.x + 15u] + i] = vec2(0.0);
    }
    if i == 0u && item.w > 0u {
        for (var n = 0u; n < 8u; n++) {
            balance[state_base(item.x) + n] = 0.0;
        }
    }
}

// One colour class of the local rule (Eq. 9 to 11); nothing where the entity's energy has settled.
@compute @workgroup_size(64)
fn sweep_local(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let i = item.z + local;
    if i >= item.w || balance[state_base(item.x) + STATE_DONE] > 0.0 {
        return;
    }
    let t = seen_sum(item.x, i);
    let z = surface[item.x + 7u] + i;
    let delta = surface[item.x + 15u] + i;
    let old = wave[z];
    wave[z] = normalize_or(t + wave[delta], old);
    wave[delta] = step.momentum * (t - old);
}
