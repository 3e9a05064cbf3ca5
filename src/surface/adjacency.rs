//! Who is next to whom, before the nodes have their final order.
//!
//! In: triangles of welded vertices, pairs of points, or a finer level. Out: for each node the list of its neighbours, from
//! which a [`Level`] with sorted, unique neighbours is made once the order of the nodes is known; and for each triangle those
//! across its edges.

use super::{
    graph::{Level, NO_TRIANGLE},
    order::{group, inverse, start_of_each},
};

/// Lists of neighbours in any order; symmetric, without loops and duplicates.
pub(super) struct Adjacency {
    /// `offsets[i]..offsets[i + 1]` are the neighbours of node i.
    pub(super) offsets: Vec<u32>,
    pub(super) neighbors: Vec<u32>,
}

impl Adjacency {
    /// The edges of triangles, which may share them in any number.
    pub(super) fn from_triangles(triangles: &[[u32; 3]], nodes: usize) -> Self {
        let mut offsets = vec![0; nodes + 1];
        for &corner in triangles.as_flattened() {
            offsets[corner as usize] += 2;
        }
        start_of_each(&mut offsets);
        let mut next = offsets.clone();
        let mut neighbors = vec![0; offsets[nodes] as usize];
        for &[a, b, c] in triangles {
            for (corner, others) in [(a, [b, c]), (b, [c, a]), (c, [a, b])] {
                let slot = next[corner as usize] as usize;
                neighbors[slot..slot + 2].copy_from_slice(&others);
                next[corner as usize] += 2;
            }
        }
        let mut adjacency = Self { offsets, neighbors };
        adjacency.remove_duplicates();
        adjacency
    }

    /// Undirected edges, given any number of times and in any direction, without loops.
    pub(super) fn from_pairs(pairs: impl Iterator<Item = [u32; 2]> + Clone, nodes: usize) -> Self {
        let mut offsets = vec![0; nodes + 1];
        for node in pairs.clone().flatten() {
            offsets[node as usize] += 1;
        }
        start_of_each(&mut offsets);
        let mut next = offsets.clone();
        let mut neighbors = vec![0; offsets[nodes] as usize];
        for [a, b] in pairs {
            for (node, other) in [(a, b), (b, a)] {
                neighbors[next[node as usize] as usize] = other;
                next[node as usize] += 1;
            }
        }
        let mut adjacency = Self { offsets, neighbors };
        adjacency.remove_duplicates();
        adjacency
    }

    /// Keeps the first of equal neighbours of a node.
    fn remove_duplicates(&mut self) {
        // The node that last took each node as its neighbour.
        let mut taken_by = vec![u32::MAX; self.len()];
        let (mut begin, mut kept) = (0, 0);
        for (node, end) in (0..).zip(&mut self.offsets[1..]) {
            for entry in begin..*end as usize {
                let other = self.neighbors[entry];
                if std::mem::replace(&mut taken_by[other as usize], node) != node {
                    self.neighbors[kept] = other;
                    kept += 1;
                }
            }
            begin = std::mem::replace(end, kept as u32) as usize;
        }
        self.neighbors.truncate(kept);
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// The neighbours of a node.
    pub(super) fn of(&self, node: u32) -> &[u32] {
        let node = node as usize;
        &self.neighbors[self.offsets[node] as usize..self.offsets[node + 1] as usize]
    }

    /// The same graph with its nodes in `order`, with ascending neighbours.
    pub(super) fn into_level(self, order: &[u32], classes: Vec<u32>) -> Level {
        let rank = inverse(order);
        let mut level = Level {
            offsets: Vec::with_capacity(order.len() + 1),
            classes,
            ..Default::default()
        };
        level.offsets.push(0);
        let mut row = Vec::new();
        for &node in order {
            row.clear();
            row.extend(self.of(node).iter().map(|&other| rank[other as usize]));
            row.sort_unstable();
            level.neighbors.extend_from_slice(&row);
            level.offsets.push(level.neighbors.len() as u32);
        }
        level
    }
}

/// The triangle across each edge of each triangle, edge c being that from corner c to the next; [`NO_TRIANGLE`] where not
/// exactly two triangles share it.
pub(super) fn triangles_across(triangles: &[[u32; 3]], nodes: usize) -> Vec<[u32; 3]> {
    let corners = triangles.as_flattened();
    let ends = |edge: u32| {
        let (triangle, corner) = (edge / 3, edge % 3);
        let [a, b] = [corner, (corner + 1) % 3].map(|c| corners[(3 * triangle + c) as usize]);
        (a.min(b), a.max(b))
    };
    let edges = corners.len() as u32;
    let lower: Vec<u32> = (0..edges).map(|edge| ends(edge).0).collect();
    let (offsets, mut members) = group(&lower, nodes);
    let mut across = vec![[NO_TRIANGLE; 3]; triangles.len()];
    for node in offsets.windows(2) {
        let at_node = &mut members[node[0] as usize..node[1] as usize];
        at_node.sort_unstable_by_key(|&edge| (ends(edge).1, edge));
        for same in at_node.chunk_by(|&a, &b| ends(a).1 == ends(b).1) {
            let &[a, b] = same else { continue };
            let (low, high) = ends(a);
            if low != high && a / 3 != b / 3 {
                across[(a / 3) as usize][(a % 3) as usize] = b / 3;
                across[(b / 3) as usize][(b % 3) as usize] = a / 3;
            }
        }
    }
    across
}
