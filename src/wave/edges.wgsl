// The edge pass: from directions and frequencies to the constants of every edge (Eq. 3); once per change of an input.
// Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::{FLAG_VECTOR, LevelRecord}
#import bevy_field_patterns::kite::{aligned_distance, phasor}
#import bevy_field_patterns::passes::{surface, geometry, wave, edges, balance, load_item, load_level, with_flip, WORKGROUP}

// w e^{i phase} and flip of every directed edge into a vertex, and 1 / sum of weights.
fn weigh_vertex(record: u32, level: LevelRecord, i: u32) {
    let vector = (surface[record + 2u] & FLAG_VECTOR) != 0u;
    let geometry_base = surface[record + 5u];
    let field_base = surface[record + 6u];
    let v_i = geometry[geometry_base + 2u * i].xyz;
    let d_i = vec3(wave[field_base + 2u * i], wave[field_base + 2u * i + 1u].x);
    let f_i = wave[field_base + 2u * i + 1u].y;
    var sum = 0.0;
    let end = surface[level.offset_base + i + 1u];
    for (var k = surface[level.offset_base + i]; k < end; k++) {
        let j = surface[level.neighbor_base + k];
        let v_j = geometry[geometry_base + 2u * j].xyz;
        let d_j = vec3(wave[field_base + 2u * j], wave[field_base + 2u * j + 1u].x);
        let f_j = wave[field_base + 2u * j + 1u].y;
        let c = dot(d_i, d_j);
        let flip = !vector && c < 0.0;
        let weight = select(max(c, 0.0), -c, flip);
        let turns = 0.5 * (f_i + f_j) * aligned_distance(v_i - v_j, d_j, select(d_i, -d_i, flip));
        edges[level.edge_base + k] = with_flip(weight * phasor(turns), flip);
        sum += weight;
    }
    balance[level.balance_base + i] = select(0.0, 1.0 / sum, sum > 0.0);
}

@compute @workgroup_size(64)
fn edge_weights(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, 0u);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        weigh_vertex(item.x, level, i);
    }
}
