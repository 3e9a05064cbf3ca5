// The edge pass: from directions and frequencies to the constants of every edge (Eq. 3); once per change of an input.
// Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::{FLAG_CROSS, FLAG_VECTOR, LevelRecord}
#import bevy_field_patterns::kite::{
    Coupling, Frame, aligned_distance, direction_of, phasor, quarter_turns, turned_reversed, turned_wave,
}
#import bevy_field_patterns::passes::{
    surface, geometry, wave, edges, balance, load_item, load_level, pull_of, with_flip, with_swap, WORKGROUP,
}

fn load_frame(geometry_base: u32, d: vec3<f32>, i: u32) -> Frame {
    return Frame(d, cross(geometry[geometry_base + 2u * i + 1u].xyz, d));
}

// w e^{i phase}, flip and source of every directed edge into a vertex, and 1 / sum of weights, that of a pin among them.
fn weigh_vertex(record: u32, level: LevelRecord, i: u32) {
    let flags = surface[record + 2u];
    let coupling = Coupling(level.waves, (flags & FLAG_VECTOR) != 0u, (flags & FLAG_CROSS) != 0u);
    let geometry_base = surface[record + 5u];
    let field_base = surface[record + 6u];
    var ratio = vec2(1.0, bitcast<f32>(surface[record + 18u]));
    let v_i = geometry[geometry_base + 2u * i].xyz;
    let f_i = wave[field_base + 2u * i + 1u].y;
    let frame_i = load_frame(geometry_base, vec3(wave[field_base + 2u * i], wave[field_base + 2u * i + 1u].x), i);
    var sum = vec2(0.0);
    let end = surface[level.offset_base + i + 1u];
    for (var k = surface[level.offset_base + i]; k < end; k++) {
        let j = surface[level.neighbor_base + k];
        let v = v_i - geometry[geometry_base + 2u * j].xyz;
        let f_j = wave[field_base + 2u * j + 1u].y;
        let frame_j = load_frame(geometry_base, vec3(wave[field_base + 2u * j], wave[field_base + 2u * j + 1u].x), j);
        let turns = quarter_turns(coupling, frame_j, frame_i);
        for (var r = 0u; r < level.waves; r++) {
            let m = turned_wave(turns, r);
            let flip = turned_reversed(turns, r);
            let d_j = direction_of(frame_j, m);
            let d_i = select(direction_of(frame_i, r), -direction_of(frame_i, r), flip);
            let weight = max(dot(d_i, d_j), 0.0);
            let periods = ratio[r] * 0.5 * (f_i + f_j) * aligned_distance(v, d_j, d_i);
            let constant = with_swap(weight * phasor(periods), m ^ r);
            edges[level.edge_base + level.waves * k + r] = with_flip(constant, flip);
            sum[r] += weight;
        }
    }
    for (var r = 0u; r < level.waves; r++) {
        let total = sum[r] + abs(pull_of(record, r, i));
        balance[level.balance_base + level.waves * i + r] = select(0.0, 1.0 / total, total > 0.0);
    }
}

@compute @workgroup_size(64)
fn edge_weights(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, 0u);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        weigh_vertex(item.x, level, i);
    }
}
