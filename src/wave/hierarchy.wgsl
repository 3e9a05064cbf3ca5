// The Galerkin hierarchy of the cold start: up the levels aligning and coarsening, down again rotating and sweeping; and
// the V-cycle of a warm start, which does the same with phasors as they are.
// Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::LevelRecord
#import bevy_field_patterns::kite::cmul
#import bevy_field_patterns::passes::{
    step, surface, wave, edges, TURN, load_item, load_level, load_pair, find, conj, normalize_or, parent_swap, relax,
    sigma_of, source_wave, store_child, swap_of, with_swap, WORKGROUP,
}

fn align_node(level: LevelRecord, index: u32, i: u32) {
    let parent = surface[level.parent_base + i];
    let root = surface[level.child_base + surface[level.child_offset_base + parent]];
    let first = level.neighbor_base + surface[level.offset_base + i];
    let end = level.neighbor_base + surface[level.offset_base + i + 1u];
    let at = find(first, end, root);
    for (var r = 0u; r < level.waves; r++) {
        let own = level.waves * i + r;
        var z = vec2(1.0, 0.0);
        var negative = false;
        var swap = 0u;
        if at < end {
            let k = at - level.neighbor_base;
            let ab = load_pair(level, index, k, r);
            z = normalize_or(ab.xy + ab.zw, z);
            negative = dot(ab.xy, ab.xy) < dot(ab.zw, ab.zw);
            swap = r ^ source_wave(level, index, k, r);
        }
        if step.keep == 0u {
            wave[level.node_base + own] = z;
        } else if index > 0u {
            wave[level.node_base + own] = vec2(1.0, 0.0);
        }
        store_child(level, index, own, negative, swap);
    }
}

@compute @workgroup_size(64)
fn align(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, item.y);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        align_node(level, item.y, i);
    }
}

// Adds edge k into wave r of node i to the coarse edge from its source's parent: to `same` where it joins equal waves of
// the parents, to `other` where it joins different ones. Both are places of a pair (A, B) per wave.
fn add_edge(level: LevelRecord, index: u32, k: u32, i: u32, r: u32, same: u32, other: u32) {
    let own = level.waves * i + r;
    let m = source_wave(level, index, k, r);
    let source = level.waves * surface[level.neighbor_base + k] + m;
    let sigma = sigma_of(level, own);
    let z_i = conj(wave[level.node_base + own]);
    let z_j = wave[level.node_base + source];
    let ab = load_pair(level, index, k, r);
    var al = cmul(z_i, cmul(ab.xy, z_j));
    var be = cmul(z_i, cmul(ab.zw, conj(z_j)));
    if sigma < 0.0 {
        al = conj(al);
        be = conj(be);
    }
    let alike = sigma == sigma_of(level, source);
    let turned = parent_swap(level, own);
    let swap = turned ^ m ^ r ^ parent_swap(level, source);
    let q = select(same, other, swap == 1u) + 2u * (r ^ turned);
    edges[q] += select(be, al, alike);
    edges[q + 1u] += select(al, be, alike);
}

// Sums the edges between the children of p and those of each neighbour q > p into the coarse edge from q to p, and
// writes the reverse edge from p to q, whose weights are conj(A) and B. Until then that one's place is where the edges
// between different waves are summed; of the two kinds the heavier is kept.
fn coarsen_node(level: LevelRecord, index: u32, coarse: LevelRecord, p: u32) {
    let pair = 2u * level.waves;
    let first = coarse.neighbor_base + surface[coarse.offset_base + p];
    let end = coarse.neighbor_base + surface[coarse.offset_base + p + 1u];
    for (var n = first; n < end; n++) {
        if surface[n] > p {
            let here = coarse.edge_base + pair * (n - coarse.neighbor_base);
            let back = edge_back(coarse, p, surface[n]);
            for (var word = 0u; word < pair; word++) {
                edges[here + word] = vec2(0.0);
                edges[back + word] = vec2(0.0);
            }
        }
    }
    let last_child = surface[level.child_offset_base + p + 1u];
    for (var c = surface[level.child_offset_base + p]; c < last_child; c++) {
        let i = surface[level.child_base + c];
        let edge_end = surface[level.offset_base + i + 1u];
        for (var k = surface[level.offset_base + i]; k < edge_end; k++) {
            let parent = surface[level.parent_base + surface[level.neighbor_base + k]];
            if parent <= p {
                continue;
            }
            let here = coarse.edge_base + pair * (find(first, end, parent) - coarse.neighbor_base);
            var back = here;
            if level.waves == 2u {
                back = edge_back(coarse, p, parent);
            }
            for (var r = 0u; r < level.waves; r++) {
                add_edge(level, index, k, i, r, here, back);
            }
        }
    }
    for (var n = first; n < end; n++) {
        if surface[n] > p {
            let here = coarse.edge_base + pair * (n - coarse.neighbor_base);
            settle_edge(coarse.waves, here, edge_back(coarse, p, surface[n]));
        }
    }
}

// Where the weights of the edge from p to q begin.
fn edge_back(coarse: LevelRecord, p: u32, q: u32) -> u32 {
    let first = coarse.neighbor_base + surface[coarse.offset_base + q];
    let end = coarse.neighbor_base + surface[coarse.offset_base + q + 1u];
    return coarse.edge_base + 2u * coarse.waves * (find(first, end, p) - coarse.neighbor_base);
}

fn settle_edge(waves: u32, here: u32, back: u32) {
    var weight = vec2(0.0);
    for (var word = 0u; word < 2u * waves; word++) {
        weight += vec2(dot(edges[here + word], edges[here + word]), dot(edges[back + word], edges[back + word]));
    }
    let swap = select(0u, 1u, weight.y > weight.x);
    let from_place = select(here, back, swap == 1u);
    var kept: array<vec2<f32>, 4>;
    for (var word = 0u; word < 2u * waves; word++) {
        kept[word] = edges[from_place + word];
    }
    for (var r = 0u; r < waves; r++) {
        let m = r ^ swap;
        edges[here + 2u * r] = with_swap(kept[2u * r], swap);
        edges[here + 2u * r + 1u] = kept[2u * r + 1u];
        edges[back + 2u * m] = with_swap(conj(kept[2u * r]), swap);
        edges[back + 2u * m + 1u] = kept[2u * r + 1u];
    }
}

// Items are nodes of the coarser level, item.y + 1.
@compute @workgroup_size(64)
fn coarsen(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, item.y);
    let coarse = load_level(item.x, item.y + 1u);
    for (var p = item.z + local; p < item.w; p += WORKGROUP) {
        coarsen_node(level, item.y, coarse, p);
    }
}

fn prolong_node(level: LevelRecord, coarse: LevelRecord, i: u32) {
    let parent = level.waves * surface[level.parent_base + i];
    for (var r = 0u; r < level.waves; r++) {
        let own = level.waves * i + r;
        let y = wave[coarse.node_base + parent + (r ^ parent_swap(level, own))];
        wave[level.node_base + own] = cmul(wave[level.node_base + own], select(conj(y), y, sigma_of(level, own) > 0.0));
    }
}

@compute @workgroup_size(64)
fn prolong(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, item.y);
    let coarse = load_level(item.x, item.y + 1u);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        prolong_node(level, coarse, i);
    }
}

fn sweep_node(level: LevelRecord, i: u32, omega: f32) {
    let end = surface[level.offset_base + i + 1u];
    for (var r = 0u; r < level.waves; r++) {
        var t = vec2(0.0);
        for (var k = surface[level.offset_base + i]; k < end; k++) {
            let q = level.edge_base + 2u * (level.waves * k + r);
            let a = edges[q];
            let m = r ^ (swap_of(a) & (level.waves - 1u));
            let y = wave[level.node_base + level.waves * surface[level.neighbor_base + k] + m];
            t += cmul(a, y) + cmul(edges[q + 1u], conj(y));
        }
        let own = level.node_base + level.waves * i + r;
        wave[own] = relax(wave[own], t, 0.0, TURN, omega, 0.0);
    }
}

// Sweep of one colour class of a coarse level.
@compute @workgroup_size(64)
fn sweep_coarse(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, item.y);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        sweep_node(level, i, step.omega);
    }
}

// Sets every node of an item to 1: the top of a hierarchy.
@compute @workgroup_size(64)
fn start_top(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let level = load_level(item.x, item.y);
    for (var own = level.waves * item.z + local; own < level.waves * item.w; own += WORKGROUP) {
        wave[level.node_base + own] = vec2(1.0, 0.0);
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
    for (var own = local; own < top.waves * top.nodes; own += SMALL_WORKGROUP) {
        wave[top.node_base + own] = vec2(1.0, 0.0);
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
