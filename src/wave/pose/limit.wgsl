// The measure of deviators: their median modulus, that of the curved ones where most are flat; the twin of `limit` in
// `field/curvature.rs`. One workgroup per entity. Moduli are sorted into bins by their leading bits, then those of the
// median's bin by the next bits, and so on: the result is exact.

#import bevy_field_patterns::passes::{surface, edges, load_item, load_level}

const THREADS: u32 = 256u;
const BINS: u32 = 2048u;
// As in `curvature.rs`.
const SAMPLES: u32 = 16384u;

var<workgroup> bins: array<atomic<u32>, 2048>;
var<workgroup> sums: array<u32, 256>;
var<workgroup> zeros: atomic<u32>;
// Leading bits of the median so far, and how many moduli of that beginning are below it.
var<workgroup> prefix: u32;
var<workgroup> rank: u32;

// Puts the bin of the median behind `prefix`.
fn choose_bin(first: bool, count: u32) {
    var below = rank;
    if first {
        let flat = atomicLoad(&zeros);
        let middle = count / 2u;
        below = select((count - flat) / 2u, middle - min(flat, middle), middle >= flat);
    }
    var run = 0u;
    while run < THREADS - 1u && below >= sums[run] {
        below -= sums[run];
        run += 1u;
    }
    var bin = run * (BINS / THREADS);
    let last = bin + BINS / THREADS - 1u;
    while bin < last && below >= atomicLoad(&bins[bin]) {
        below -= atomicLoad(&bins[bin]);
        bin += 1u;
    }
    prefix = prefix * BINS + bin;
    rank = below;
}

@compute @workgroup_size(256)
fn limit(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let vertices = select(0u, surface[item.x], item.w > 0u);
    let lines = load_level(item.x, 0u).edge_base;
    let stride = max((vertices + SAMPLES - 1u) / SAMPLES, 1u);
    let count = (vertices + stride - 1u) / stride;
    if local == 0u {
        prefix = 0u;
        rank = 0u;
        atomicStore(&zeros, 0u);
    }
    // 31 bits, the sign is none: the first round sees 9 of them, the others 11.
    for (var round = 0u; round < 3u; round++) {
        let shift = 22u - 11u * round;
        for (var bin = local; bin < BINS; bin += THREADS) {
            atomicStore(&bins[bin], 0u);
        }
        workgroupBarrier();
        for (var n = local; n < count; n += THREADS) {
            let bits = bitcast<u32>(length(edges[lines + n * stride]));
            if bits == 0u {
                atomicAdd(&zeros, select(0u, 1u, round == 0u));
            } else if round == 0u || (bits >> (shift + 11u)) == prefix {
                atomicAdd(&bins[(bits >> shift) & (BINS - 1u)], 1u);
            }
        }
        workgroupBarrier();
        var sum = 0u;
        for (var bin = 0u; bin < BINS / THREADS; bin++) {
            sum += atomicLoad(&bins[local * (BINS / THREADS) + bin]);
        }
        sums[local] = sum;
        workgroupBarrier();
        if local == 0u {
            choose_bin(round == 0u, count);
        }
        workgroupBarrier();
    }
    if local == 0u && item.w > 0u {
        let flat = atomicLoad(&zeros) == count;
        edges[lines + 2u * vertices] = vec2(select(bitcast<f32>(prefix), 0.0, flat), 0.0);
    }
}
