// The edge pass: from directions and frequencies to the constants of every edge (Eq. 3); once per change of an input.
// Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::{FLAG_CROSS, FLAG_VECTOR, LevelRecord}
#import bevy_field_patterns::kite::{
    Coupling, Frame, aligned_distance, direction_of, phasor, quarter_turns, turned_reversed, turned_wave,
}
#import bevy_field_patterns::passes::{
    surface, geometry, wave, edges, balance, Pins, load_item, load_level, load_pins, pull_of, with_flip, with_swap, WORKGROUP,
}

const WAVES: u32 = #{KIND}u + 1u;

// What the edge pass knows of an entity.
struct Inputs {
    coupling: Coupling,
    // Frequency of each wave over that of the first.
    ratio: vec2<f32>,
    geometry_base: u32,
    field_base: u32,
    pins: Pins,
}

fn load_inputs(record: u32) -> Inputs {
    let flags = surface[record + 2u];
    return Inputs(
        Coupling(WAVES, (flags & FLAG_VECTOR) != 0u, WAVES == 2u && (flags & FLAG_CROSS) != 0u),
        vec2(1.0, bitcast<f32>(surface[record + 18u])),
        surface[record + 5u],
        surface[record + 6u],
        load_pins(record),
    );
}

// Where a vertex is, its frame and its frequency.
struct Vertex {
    position: vec3<f32>,
    frame: Frame,
    frequency: f32,
}

fn load_vertex(inputs: Inputs, i: u32) -> Vertex {
    let position = geometry[inputs.geometry_base + 2u * i].xyz;
    let xy = wave[inputs.field_base + 2u * i];
    let zf = wave[inputs.field_base + 2u * i + 1u];
    let d = vec3(xy, zf.x);
#if KIND == 1
    let frame = Frame(d, cross(geometry[inputs.geometry_base + 2u * i + 1u].xyz, d));
#else
    let frame = Frame(d, d);
#endif
    return Vertex(position, frame, zf.y);
}

// w e^{i phase}, flip and source of every directed edge into a vertex, and 1 / sum of weights, that of a pin among them.
fn weigh_vertex(inputs: Inputs, level: LevelRecord, i: u32) {
    let target_vertex = load_vertex(inputs, i);
    var sum = vec2(0.0);
    let end = surface[level.offset_base + i + 1u];
    for (var k = surface[level.offset_base + i]; k < end; k++) {
        let source = load_vertex(inputs, surface[level.neighbor_base + k]);
        let v = target_vertex.position - source.position;
        let frequency = 0.5 * (target_vertex.frequency + source.frequency);
        let turns = quarter_turns(inputs.coupling, source.frame, target_vertex.frame);
        for (var r = 0u; r < WAVES; r++) {
            let m = select(turned_wave(turns, r), 0u, WAVES == 1u);
            let flip = turned_reversed(turns, r);
            let d_j = direction_of(source.frame, m);
            let d_r = direction_of(target_vertex.frame, r);
            let d_i = select(d_r, -d_r, flip);
            let weight = max(dot(d_i, d_j), 0.0);
            let periods = inputs.ratio[r] * frequency * aligned_distance(v, d_j, d_i);
            let constant = with_swap(weight * phasor(periods), m ^ r);
            edges[level.edge_base + WAVES * k + r] = with_flip(constant, flip);
            sum[r] += weight;
        }
    }
    for (var r = 0u; r < WAVES; r++) {
        let total = sum[r] + abs(pull_of(inputs.pins, r, i));
        balance[level.balance_base + WAVES * i + r] = select(0.0, 1.0 / total, total > 0.0);
    }
}

@compute @workgroup_size(64)
fn edge_weights(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, 0u);
    let inputs = load_inputs(item.x);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        weigh_vertex(inputs, level, i);
    }
}
