// Sweeps over the vertices of the mesh: the coloured relaxation and the local rule. Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::LevelRecord
#import bevy_field_patterns::kite::phasor
#import bevy_field_patterns::passes::{
    step, surface, geometry, wave, edges, balance, STATE_DONE, WORKGROUP, Pins, load_item, load_level, load_pins, seen_fine,
    swap_of, relax, normalize_or, pull_of, state_base,
}

const WAVES: u32 = #{KIND}u + 1u;

// What the waves of vertex i see in sum: the first in xy, the second in zw; `at` is the mesh's level record. A crest is at
// z = i.
fn seen_sums(pins: Pins, at: LevelRecord, i: u32) -> vec4<f32> {
    var t = vec4(0.0, pull_of(pins, 0u, i), 0.0, 0.0);
#if KIND == 1
    t.w = pull_of(pins, 1u, i);
#endif
    let end = surface[at.offset_base + i + 1u];
    for (var k = surface[at.offset_base + i]; k < end; k++) {
        let source = at.node_base + WAVES * surface[at.neighbor_base + k];
        let e = edges[at.edge_base + WAVES * k];
        let z = wave[source];
#if KIND == 1
        let second_e = edges[at.edge_base + WAVES * k + 1u];
        let second_z = wave[source + 1u];
        let seen = seen_fine(e, select(z, second_z, swap_of(e) == 1u));
        let second_seen = seen_fine(second_e, select(second_z, z, swap_of(second_e) == 1u));
        t += vec4(seen, second_seen);
#else
        t += vec4(seen_fine(e, z), 0.0, 0.0);
#endif
    }
    return t;
}

// Sweep of one colour class of the mesh.
@compute @workgroup_size(64)
fn sweep_fine(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, 0u);
    let pins = load_pins(item.x);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let t = seen_sums(pins, level, i);
        for (var r = 0u; r < WAVES; r++) {
            let own = WAVES * i + r;
            let weight = abs(balance[level.balance_base + own]);
            let z = wave[level.node_base + own];
            let seen = select(t.xy, t.zw, r == 1u);
            wave[level.node_base + own] = relax(z, seen, weight, step.relaxation, step.omega, step.softness);
        }
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
    let pins = load_pins(item.x);
    let momentum = surface[item.x + 15u];
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let t = seen_sums(pins, level, i);
        for (var r = 0u; r < WAVES; r++) {
            let own = WAVES * i + r;
            let seen = select(t.xy, t.zw, r == 1u);
            let old = wave[level.node_base + own];
            wave[level.node_base + own] = normalize_or(seen + wave[momentum + own], old);
            wave[momentum + own] = step.momentum * (seen - old);
        }
    }
}
