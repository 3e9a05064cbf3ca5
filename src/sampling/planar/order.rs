//! Orders of vertices and triangles in memory.

use super::triangulation::Vertex;
use bevy::math::DVec2;

/// Bits that one pass of [`argsort`] looks at.
const DIGIT: u32 = 11;

/// The indices of `keys` in ascending order of their keys; stable, linear in their number.
pub(super) fn argsort(keys: &[u32]) -> Vec<u32> {
    let bits = u32::BITS - keys.iter().fold(0, |all, key| all | key).leading_zeros();
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    let mut sorted = order.clone();
    for shift in (0..bits).step_by(DIGIT as usize) {
        let digit = |item: u32| ((keys[item as usize] >> shift) & ((1 << DIGIT) - 1)) as usize;
        let mut place = [0_u32; 1 << DIGIT];
        for &item in &order {
            place[digit(item)] += 1;
        }
        let mut sum = 0;
        for count in &mut place {
            sum += std::mem::replace(count, sum);
        }
        for &item in &order {
            let slot = &mut place[digit(item)];
            sorted[*slot as usize] = item;
            *slot += 1;
        }
        std::mem::swap(&mut order, &mut sorted);
    }
    order
}

/// The inverse of a permutation.
pub(super) fn inverse(order: &[u32]) -> Vec<u32> {
    let mut rank = vec![0; order.len()];
    for (&item, i) in order.iter().zip(0..) {
        rank[item as usize] = i;
    }
    rank
}

/// The indices of the vertices along a Morton (Z-order) curve of 2 × 16 bits.
pub(super) fn morton_order(vertices: &[Vertex]) -> Vec<u32> {
    let min = vertices.iter().fold(DVec2::INFINITY, |min, vertex| min.min(vertex.p));
    let max = vertices
        .iter()
        .fold(DVec2::NEG_INFINITY, |max, vertex| max.max(vertex.p));
    let cells = 65535.0 / (max - min).max_element().max(f64::MIN_POSITIVE);
    let key = |vertex: &Vertex| {
        let cell = (vertex.p - min) * cells;
        spread(cell.x as u32) | spread(cell.y as u32) << 1
    };
    argsort(&vertices.iter().map(key).collect::<Vec<u32>>())
}

/// Spreads the low 16 bits so that bit b comes to bit 2 b.
fn spread(x: u32) -> u32 {
    let x = (x | x << 8) & 0x00ff_00ff;
    let x = (x | x << 4) & 0x0f0f_0f0f;
    let x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}
