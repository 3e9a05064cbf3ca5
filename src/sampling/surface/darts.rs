//! The first set: darts thrown at the mesh, exactly so many.
//!
//! In: a [`FineMesh`], a count and a seed. Out: vertices, about a Poisson disk set in the metric. Vertices come in random
//! order, weighted by their metric area; one is taken if no dart is nearer than a radius, in the mean of the two metrics,
//! on a way over the mesh. The radius shrinks from round to round until there are enough. Every component gets a dart, the
//! largest ones first.

use super::{
    mesh::{FineMesh, NONE},
    walk::components,
};
use crate::{
    error::PatternError,
    sampling::{Progress, surface::form},
    surface::order::inverse,
};

/// The first radius, relative to the distance of neighbours in the hexagonal packing.
const FIRST_RADIUS: f32 = 0.95;
/// How the radius shrinks; slower at first, where most darts are thrown.
const SHRINK: [f32; 2] = [0.9, 0.85];
/// Below this part of the first radius every vertex that is no dart is taken.
const LAST_RADIUS: f32 = 1e-3;
/// After so many vertices somebody may stop it.
const VERTICES_PER_CHECK: usize = 8192;

/// Darts, and for each vertex the dart whose disk covers it, or [`NONE`].
pub(super) struct Darts {
    pub(super) vertices: Vec<u32>,
    pub(super) labels: Vec<u32>,
}

/// Throws `count` darts; fewer only where the mesh has fewer vertices at different places.
pub(super) fn throw(mesh: &FineMesh, count: usize, seed: u64, progress: &Progress) -> Result<Darts, PatternError> {
    let order = random_order(mesh, seed);
    let spacing = (2.0 / 3.0_f64.sqrt() * mesh.area() / count as f64).sqrt() as f32;
    let mut board = Board::new(mesh, FIRST_RADIUS * spacing);
    for vertex in first_of_components(mesh, &order).into_iter().take(count) {
        board.throw(vertex);
    }
    for round in 0.. {
        for some in order.chunks(VERTICES_PER_CHECK) {
            progress.check()?;
            for &vertex in some {
                if board.darts.len() < count && !board.is_covered(vertex) {
                    board.throw(vertex);
                }
            }
        }
        if board.darts.len() >= count || board.radius == 0.0 {
            break;
        }
        board.radius *= if round < 2 { SHRINK[0] } else { SHRINK[1] };
        if board.radius.is_nan() || board.radius < LAST_RADIUS * spacing {
            board.radius = 0.0;
        }
    }
    Ok(board.sorted())
}

struct Board<'a> {
    mesh: &'a FineMesh,
    radius: f32,
    darts: Vec<u32>,
    /// The nearest dart of each vertex and its squared distance, as far as disks reach.
    labels: Vec<u32>,
    squares: Vec<f32>,
    /// The last dart whose disk was spread to each vertex.
    seen: Vec<u32>,
    queue: Vec<u32>,
}

impl<'a> Board<'a> {
    fn new(mesh: &'a FineMesh, radius: f32) -> Self {
        Self {
            mesh,
            radius,
            darts: Vec::new(),
            labels: vec![NONE; mesh.len()],
            squares: vec![f32::INFINITY; mesh.len()],
            seen: vec![NONE; mesh.len()],
            queue: Vec::new(),
        }
    }

    /// Distances below the current radius are known: disks were spread with radii that were no smaller.
    fn is_covered(&self, vertex: u32) -> bool {
        self.squares[vertex as usize] <= self.radius * self.radius
    }

    fn throw(&mut self, vertex: u32) {
        let dart = self.darts.len() as u32;
        self.darts.push(vertex);
        let (position, metric) = (self.mesh.positions[vertex as usize], self.mesh.metrics[vertex as usize]);
        self.reach(vertex, dart, 0.0);
        self.queue.push(vertex);
        while let Some(v) = self.queue.pop() {
            for &w in self.mesh.neighbors(v as usize) {
                let i = w as usize;
                if self.seen[i] == dart {
                    continue;
                }
                let way = self.mesh.positions[i] - position;
                let square = 0.5 * (form::square(&metric, way) + form::square(&self.mesh.metrics[i], way));
                self.seen[i] = dart;
                if square < self.radius * self.radius {
                    self.reach(w, dart, square);
                    self.queue.push(w);
                }
            }
        }
    }

    /// The darts in the order of their vertices, so that those near in space are near in memory.
    fn sorted(self) -> Darts {
        let mut order: Vec<u32> = (0..self.darts.len() as u32).collect();
        order.sort_unstable_by_key(|&dart| self.darts[dart as usize]);
        let rank = inverse(&order);
        let renamed = |dart: u32| rank.get(dart as usize).copied().unwrap_or(NONE);
        Darts {
            vertices: order.iter().map(|&dart| self.darts[dart as usize]).collect(),
            labels: self.labels.into_iter().map(renamed).collect(),
        }
    }

    fn reach(&mut self, vertex: u32, dart: u32, square: f32) {
        let i = vertex as usize;
        self.seen[i] = dart;
        if square < self.squares[i] {
            self.squares[i] = square;
            self.labels[i] = dart;
        }
    }
}

/// Vertices that have an area, in random order: a vertex of weight w comes at the time of the first event of a Poisson
/// process of rate w.
fn random_order(mesh: &FineMesh, seed: u64) -> Vec<u32> {
    let mut keys: Vec<u64> = (0..mesh.len())
        .filter(|&v| !mesh.faces(v).is_empty())
        .map(|v| {
            let unit = (hash(seed ^ hash(v as u64)) >> 40) as f32 / (1 << 24) as f32;
            let time = -(1.0 - unit).ln() / mesh.weights[v].max(f32::MIN_POSITIVE);
            // The bits of floats that are not negative are in their order.
            u64::from(time.abs().to_bits()) << 32 | v as u64
        })
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|key| key as u32).collect()
}

/// Mixes the bits of a number (`SplitMix64`).
pub(super) fn hash(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

/// The first vertex of each component in a given order; the largest component's first.
fn first_of_components(mesh: &FineMesh, order: &[u32]) -> Vec<u32> {
    let (component, areas) = components(mesh);
    let mut first = vec![NONE; areas.len()];
    for &v in order.iter().rev() {
        first[component[v as usize] as usize] = v;
    }
    let mut largest: Vec<usize> = (0..areas.len()).collect();
    largest.sort_by(|&a, &b| areas[b].total_cmp(&areas[a]));
    largest.into_iter().map(|c| first[c]).collect()
}
