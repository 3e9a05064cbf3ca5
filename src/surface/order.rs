//! Orders: linear-time sorting, grouping, and the Morton curve.
//!
//! In: keys or positions. Out: permutations of the indices 0..n. All orders are stable and hence deterministic.

use bevy::prelude::*;

/// Bits that one pass of [`argsort`] looks at.
const DIGIT: u32 = 11;
/// Bits per axis of a Morton key.
const MORTON_BITS: u32 = 16;

/// The indices of `keys` in ascending order of their keys; a stable radix sort, linear in the number of keys.
pub(crate) fn argsort(keys: &[u64]) -> Vec<u32> {
    let Some(&first) = keys.first() else {
        return Vec::new();
    };
    let differing = keys.iter().fold(0, |bits, key| bits | (key ^ first));
    let mut items: Vec<(u64, u32)> = keys.iter().copied().zip(0..).collect();
    let mut sorted = items.clone();
    for shift in (0..u64::BITS).step_by(DIGIT as usize) {
        let mask = (1 << DIGIT) - 1;
        if (differing >> shift) & mask == 0 {
            continue;
        }
        let digit = |key: u64| ((key >> shift) & mask) as usize;
        let mut next = [0_u32; 1 << DIGIT];
        for &(key, _) in &items {
            next[digit(key)] += 1;
        }
        start_of_each(&mut next);
        for &(key, index) in &items {
            let slot = &mut next[digit(key)];
            sorted[*slot as usize] = (key, index);
            *slot += 1;
        }
        std::mem::swap(&mut items, &mut sorted);
    }
    items.into_iter().map(|(_, index)| index).collect()
}

/// Items 0..n grouped by key: `members[offsets[k]..offsets[k + 1]]` are those with `keys[item] == k`, ascending.
pub(crate) fn group(keys: &[u32], groups: usize) -> (Vec<u32>, Vec<u32>) {
    let mut offsets = vec![0; groups + 1];
    for &key in keys {
        offsets[key as usize] += 1;
    }
    start_of_each(&mut offsets);
    let mut next = offsets.clone();
    let mut members = vec![0; keys.len()];
    for (&key, item) in keys.iter().zip(0..) {
        let slot = &mut next[key as usize];
        members[*slot as usize] = item;
        *slot += 1;
    }
    (offsets, members)
}

/// Turns counts into the sums of all counts before them.
pub(super) fn start_of_each(counts: &mut [u32]) {
    let mut sum = 0;
    for count in counts {
        sum += std::mem::replace(count, sum);
    }
}

/// The inverse of a permutation.
pub(crate) fn inverse(order: &[u32]) -> Vec<u32> {
    let mut rank = vec![0; order.len()];
    for (&item, i) in order.iter().zip(0..) {
        rank[item as usize] = i;
    }
    rank
}

/// The indices of `positions` along a Morton (Z-order) curve through their bounding cube, so that neighbours in space
/// are neighbours in memory.
pub(crate) fn morton_order(positions: &[Vec3]) -> Vec<u32> {
    let (min, max) = positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), &p| {
            (min.min(p), max.max(p))
        });
    // f64, since the extent of finite f32 positions need not be a finite f32.
    let min = min.as_dvec3();
    let extent = (max.as_dvec3() - min).max_element();
    let scale = if extent > 0.0 {
        f64::from((1_u32 << MORTON_BITS) - 1) / extent
    } else {
        0.0
    };
    let keys: Vec<u64> = positions
        .iter()
        .map(|p| {
            let cell = (p.as_dvec3() - min) * scale;
            spread(cell.x as u64) | spread(cell.y as u64) << 1 | spread(cell.z as u64) << 2
        })
        .collect();
    argsort(&keys)
}

/// Spreads the low 16 bits so that bit b comes to bit 3 b.
fn spread(x: u64) -> u64 {
    let x = (x | x << 16) & 0x0000_0000_ff00_00ff;
    let x = (x | x << 8) & 0x0000_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x0000_0c30_c30c_30c3;
    (x | x << 2) & 0x0000_2492_4924_9249
}
