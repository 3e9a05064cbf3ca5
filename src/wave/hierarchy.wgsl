// The Galerkin hierarchy of the cold start: up the levels aligning and coarsening, down again rotating and sweeping.
// Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::LevelRecord
#import bevy_field_patterns::kite::cmul
#import bevy_field_patterns::passes::{
    step, surface, wave, edges, TURN, load_item, load_level, load_pair, find, conj, normalize_or, relax, sigma_of,
    store_sigma, WORKGROUP,
}

fn align_node(level: LevelRecord, index: u32, i: u32) {
    let parent = surface[level.parent_base + i];
    let root = surface[level.child_base + surface[level.child_offset_base + parent]];
    var z = vec2(1.0, 0.0);
    var negative = false;
    let first = level.neighbor_base + surface[level.offset_base + i];
    let end = level.neighbor_base + surface[level.offset_base + i + 1u];
    let at = find(first, end, root);
    if at < end {
        let ab = load_pair(level, index, at - level.neighbor_base);
        z = normalize_or(ab.xy + ab.zw, z);
        negative = dot(ab.xy, ab.xy) < dot(ab.zw, ab.zw);
    }
    wave[level.node_base + i] = z;
    store_sigma(level, i, negative);
}

@compute @workgroup_size(64)
fn align(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        align_node(load_level(item.x, item.y), item.y, i);
    }
}

// Sums the edges between the children of p and those of each neighbour q > p into the coarse edge from q to p, and
// writes the reverse edge from p to q, whose weights are conj(A) and B.
fn coarsen_node(level: LevelRecord, index: u32, coarse: LevelRecord, p: u32) {
    let first = coarse.neighbor_base + surface[coarse.offset_base + p];
    let end = coarse.neighbor_base + surface[coarse.offset_base + p + 1u];
    for (var n = first; n < end; n++) {
        if surface[n] > p {
            let q = coarse.edge_base + 2u * (n - coarse.neighbor_base);
            edges[q] = vec2(0.0);
            edges[q + 1u] = vec2(0.0);
        }
    }
    let last_child = surface[level.child_offset_base + p + 1u];
    for (var c = surface[level.child_offset_base + p]; c < last_child; c++) {
        let i = surface[level.child_base + c];
        let z_i = conj(wave[level.node_base + i]);
        let sigma_i = sigma_of(level, i);
        let edge_end = surface[level.offset_base + i + 1u];
        for (var k = surface[level.offset_base + i]; k < edge_end; k++) {
            let j = surface[level.neighbor_base + k];
            let parent = surface[level.parent_base + j];
            if parent <= p {
                continue;
            }
            let at = find(first, end, parent);
            let z_j = wave[level.node_base + j];
            let ab = load_pair(level, index, k);
            var al = cmul(z_i, cmul(ab.xy, z_j));
            var be = cmul(z_i, cmul(ab.zw, conj(z_j)));
            if sigma_i < 0.0 {
                al = conj(al);
                be = conj(be);
            }
            let q = coarse.edge_base + 2u * (at - coarse.neighbor_base);
            let same = sigma_i == sigma_of(level, j);
            edges[q] += select(be, al, same);
            edges[q + 1u] += select(al, be, same);
        }
    }
    for (var n = first; n < end; n++) {
        let q = surface[n];
        if q > p {
            let other_first = coarse.neighbor_base + surface[coarse.offset_base + q];
            let other_end = coarse.neighbor_base + surface[coarse.offset_base + q + 1u];
            let back = coarse.edge_base + 2u * (find(other_first, other_end, p) - coarse.neighbor_base);
            let here = coarse.edge_base + 2u * (n - coarse.neighbor_base);
            edges[back] = conj(edges[here]);
            edges[back + 1u] = edges[here + 1u];
        }
    }
}

// Items are nodes of the coarser level, item.y + 1.
@compute @workgroup_size(64)
fn coarsen(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var p = item.z + local; p < item.w; p += WORKGROUP) {
        coarsen_node(load_level(item.x, item.y), item.y, load_level(item.x, item.y + 1u), p);
    }
}

fn prolong_node(level: LevelRecord, coarse: LevelRecord, i: u32) {
    let y = wave[coarse.node_base + surface[level.parent_base + i]];
    let z = wave[level.node_base + i];
    wave[level.node_base + i] = cmul(z, select(conj(y), y, sigma_of(level, i) > 0.0));
}

@compute @workgroup_size(64)
fn prolong(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        prolong_node(load_level(item.x, item.y), load_level(item.x, item.y + 1u), i);
    }
}

fn sweep_node(level: LevelRecord, i: u32, omega: f32) {
    var t = vec2(0.0);
    let end = surface[level.offset_base + i + 1u];
    for (var k = surface[level.offset_base + i]; k < end; k++) {
        let y = wave[level.node_base + surface[level.neighbor_base + k]];
        let q = level.edge_base + 2u * k;
        t += cmul(edges[q], y) + cmul(edges[q + 1u], conj(y));
    }
    wave[level.node_base + i] = relax(wave[level.node_base + i], t, 0.0, TURN, omega, 0.0);
}

// Sweep of one colour class of a coarse level.
@compute @workgroup_size(64)
fn sweep_coarse(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        sweep_node(load_level(item.x, item.y), i, step.omega);
    }
}

// Sets every node of an item to 1: the top of a hierarchy.
@compute @workgroup_size(64)
fn start_top(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        wave[load_level(item.x, item.y).node_base + i] = vec2(1.0, 0.0);
    }
}

const SMALL_WORKGROUP: u32 = 256u;
var<workgroup> shared_item: vec4<u32>;
var<workgroup> shared_count: u32;

// All levels from item.y up to the top and down again, by one workgroup: what is small is not worth its dispatches.
@compute @workgroup_size(256)
fn solve_small(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    if local == 0u {
        shared_item = load_item(group);
        shared_count = surface[shared_item.x + 3u];
    }
    let item = workgroupUniformLoad(&shared_item);
    let levels = workgroupUniformLoad(&shared_count);
    if item.w == 0u {
        return;
    }
    for (var index = item.y; index + 1u < levels; index++) {
        let level = load_level(item.x, index);
        let coarse = load_level(item.x, index + 1u);
        for (var i = local; i < level.nodes; i += SMALL_WORKGROUP) {
            align_node(level, index, i);
        }
        storageBarrier();
        for (var p = local; p < coarse.nodes; p += SMALL_WORKGROUP) {
            coarsen_node(level, index, coarse, p);
        }
        storageBarrier();
    }
    let top = load_level(item.x, levels - 1u);
    for (var i = local; i < top.nodes; i += SMALL_WORKGROUP) {
        wave[top.node_base + i] = vec2(1.0, 0.0);
    }
    storageBarrier();
    for (var above = levels; above > item.y; above--) {
        let index = above - 1u;
        let level = load_level(item.x, index);
        if above < levels {
            let coarse = load_level(item.x, above);
            for (var i = local; i < level.nodes; i += SMALL_WORKGROUP) {
                prolong_node(level, coarse, i);
            }
            storageBarrier();
        }
        if local == 0u {
            shared_count = level.colors;
        }
        let colors = workgroupUniformLoad(&shared_count);
        for (var n = 0u; n < step.level_sweeps; n++) {
            for (var color = 0u; color < colors; color++) {
                let end = surface[level.class_base + color + 1u];
                for (var i = surface[level.class_base + color] + local; i < end; i += SMALL_WORKGROUP) {
                    sweep_node(level, i, select(step.omega, 1.0, n == 0u));
                }
                storageBarrier();
            }
        }
    }
}
