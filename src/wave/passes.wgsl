#define_import_path bevy_field_patterns::passes

// What all solve passes share: the buffers, the work of a workgroup, and edges as the solver keeps them.
// Each pass is the twin of a function of the same name in `solver.rs`, where the mathematics is explained.
//
// z        phasor of a vertex; of a coarse node: y, the rotation of all its children        [complex, |z| <= 1]
// E        w e^{i phase} of a directed edge, from its source j to its target i               [complex]
// A, B     weights of a coarse edge: the target sees A y + B conj(y)                         [complex]
// sigma    +1 or -1: a child turns by y or by conj(y)
// swap     an edge's source, or a child's parent, is the other wave of a cross field
// node     a vertex of a level; the waves of node n are numbers waves * n + r of every list of phasors, weights and
//          balances. i, j, p, q are nodes, `own` and `source` such numbers.
// item     (record, level, first node, end node): the work of one workgroup; in sums over the mesh the second is the
//          number of the partial sum
//
// What is the same for all vertices of an entity is loaded before the loop over them; compilers do not move loads out of it.
//
// One dispatch serves the nodes of many entities; `items` says which. Nodes of one dispatch are never neighbours where
// it matters (sweeps go colour class by colour class).

#import bevy_field_patterns::layout::{FLAG_CROSS, RECORD_WORDS, LEVEL_WORDS, LevelRecord}
#import bevy_field_patterns::kite::{cmul, reversed}

const PLAIN: u32 = 0u;
const TURN: u32 = 1u;
const SOFT: u32 = 2u;

// Below this a phasor says nothing.
const NOTHING: f32 = 1e-14;

// Threads of a workgroup; an item may have more nodes than that.
const WORKGROUP: u32 = 64u;

struct Step {
    // Items of this dispatch: items[first_item .. first_item + item_count].
    first_item: u32,
    item_count: u32,
    // Workgroups per row of a dispatch in two dimensions.
    row: u32,
    // PLAIN, TURN or SOFT.
    relaxation: u32,
    // Over-relaxation 1..2.
    omega: f32,
    // Exponent p of soft sweeps, 0..1.
    softness: f32,
    // Sweeps per level of the hierarchy.
    level_sweeps: u32,
    // Momentum s_m of the local rule.
    momentum: f32,
    // The local rule ends below this relative change of the energy; 0: never.
    epsilon: f32,
    // 1: a V-cycle: phasors stay as they are while children are joined to their parents.
    keep: u32,
    // Number of a step that is repeated.
    round: u32,
    pad_c: u32,
}

// What the solver knows of an entity, in `balance` from `state_base` on; partial sums follow.
const STATE_OFF: u32 = 0u;       // sum of w (1 - cos r) over the directed edges
const STATE_WEIGHT: u32 = 1u;    // sum of w
const STATE_BRANCHES: u32 = 2u;
const STATE_BEFORE: u32 = 3u;    // energy before the last sweep of the local rule
const STATE_DONE: u32 = 4u;      // 1: the local rule has ended
const STATE_SWEEPS: u32 = 5u;    // sweeps of the local rule
const STATE_WORDS: u32 = 8u;

@group(0) @binding(0) var<uniform> step: Step;
@group(0) @binding(1) var<storage, read> items: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> surface: array<u32>;
@group(0) @binding(3) var<storage, read> geometry: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> wave: array<vec2<f32>>;
@group(0) @binding(5) var<storage, read_write> edges: array<vec2<f32>>;
@group(0) @binding(6) var<storage, read_write> balance: array<f32>;

fn load_level(record: u32, level: u32) -> LevelRecord {
    let at = record + RECORD_WORDS + level * LEVEL_WORDS;
    return LevelRecord(
        surface[at], surface[at + 1u], surface[at + 2u], surface[at + 3u], surface[at + 4u],
        surface[at + 5u], surface[at + 6u], surface[at + 7u], surface[at + 8u], surface[at + 9u], surface[at + 10u], surface[at + 11u],
    );
}

fn state_base(record: u32) -> u32 {
    return surface[record + 16u];
}

// What draws vertices of a pattern to crests (below 0: to troughs).
struct Pins {
    // Of a bit per vertex; 0: none is drawn.
    base: u32,
    pull: f32,
    // Both waves are.
    both: bool,
}

fn load_pins(record: u32) -> Pins {
    let both = (surface[record + 2u] & FLAG_CROSS) != 0u;
    return Pins(surface[record + 30u], bitcast<f32>(surface[record + 31u]), both);
}

// How much wave r of vertex i is drawn.
fn pull_of(pins: Pins, r: u32, i: u32) -> f32 {
    if pins.base == 0u || (r == 1u && !pins.both) {
        return 0.0;
    }
    let pinned = ((surface[pins.base + i / 32u] >> (i % 32u)) & 1u) == 1u;
    return select(0.0, pins.pull, pinned);
}

// The item of this workgroup; an empty one behind the last.
fn load_item(group: vec3<u32>) -> vec4<u32> {
    let n = group.y * step.row + group.x;
    if n >= step.item_count {
        return vec4(0u);
    }
    return items[step.first_item + n];
}

fn conj(z: vec2<f32>) -> vec2<f32> {
    return vec2(z.x, -z.y);
}

fn normalize_or(z: vec2<f32>, fallback: vec2<f32>) -> vec2<f32> {
    let r = length(z);
    if r > NOTHING {
        return z / r;
    }
    return fallback;
}

fn flips(e: vec2<f32>) -> bool {
    return (bitcast<u32>(e.x) & 1u) == 1u;
}

fn with_flip(e: vec2<f32>, flip: bool) -> vec2<f32> {
    return vec2(bitcast<f32>((bitcast<u32>(e.x) & 0xfffffffeu) | select(0u, 1u, flip)), e.y);
}

fn swap_of(e: vec2<f32>) -> u32 {
    return bitcast<u32>(e.y) & 1u;
}

fn with_swap(e: vec2<f32>, swap: u32) -> vec2<f32> {
    return vec2(e.x, bitcast<f32>((bitcast<u32>(e.y) & 0xfffffffeu) | swap));
}

// The wave of the source that wave r of the target sees over edge k.
fn source_wave(level: LevelRecord, index: u32, k: u32, r: u32) -> u32 {
    if level.waves == 1u {
        return r;
    }
    let n = level.waves * k + r;
    return r ^ swap_of(edges[level.edge_base + select(2u * n, n, index == 0u)]);
}

// What the target sees over edge constant `e` of the mesh.
fn seen_fine(e: vec2<f32>, z: vec2<f32>) -> vec2<f32> {
    let seen = cmul(e, z);
    return select(seen, reversed(seen), flips(e));
}

// (A, B) of edge k, as wave r of its target sees it.
fn load_pair(level: LevelRecord, index: u32, k: u32, r: u32) -> vec4<f32> {
    let n = level.waves * k + r;
    if index == 0u {
        let e = edges[level.edge_base + n];
        if flips(e) {
            return vec4(0.0, 0.0, reversed(e));
        }
        return vec4(e, 0.0, 0.0);
    }
    return vec4(edges[level.edge_base + 2u * n], edges[level.edge_base + 2u * n + 1u]);
}

// Position of `value` in the ascending surface[first .. end]; end where it is missing.
fn find(first: u32, end: u32, value: u32) -> u32 {
    var low = first;
    var high = end;
    while low < high {
        let middle = (low + high) / 2u;
        if surface[middle] < value {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return select(end, low, low < end && surface[min(low, end - 1u)] == value);
}

fn relax(z: vec2<f32>, t: vec2<f32>, weight: f32, relaxation: u32, omega: f32, softness: f32) -> vec2<f32> {
    let r = length(t);
    if relaxation == SOFT {
        if weight == 0.0 {
            return z;
        }
        let u = (1.0 - omega) * z + omega * (t * weight);
        let modulus = length(u);
        if modulus > NOTHING {
            return u * pow(modulus, softness - 1.0);
        }
        return z;
    }
    if r <= NOTHING {
        return z;
    }
    let unit = t / r;
    if relaxation == PLAIN {
        return unit;
    }
    let u = normalize_or(unit + (omega - 1.0) * (unit - z), unit);
    return select(u, unit, dot(u, unit) < dot(z, unit));
}

fn sigma_of(level: LevelRecord, own: u32) -> f32 {
    return select(1.0, -1.0, (bitcast<u32>(balance[level.balance_base + own]) & 0x80000000u) != 0u);
}

fn parent_swap(level: LevelRecord, own: u32) -> u32 {
    return bitcast<u32>(balance[level.balance_base + own]) & (level.waves - 1u);
}

// How a wave follows its parent is kept in the sign bit (sigma) and the lowest bit (swap) of its balance. On the mesh the
// modulus stays; coarse levels need none.
fn store_child(level: LevelRecord, index: u32, own: u32, negative: bool, swap: u32) {
    var bits = select(0x3f800000u, bitcast<u32>(balance[level.balance_base + own]), index == 0u);
    bits &= select(0x7fffffffu, 0x7ffffffeu, level.waves == 2u);
    balance[level.balance_base + own] = bitcast<f32>(bits | select(0u, 0x80000000u, negative) | swap);
}
