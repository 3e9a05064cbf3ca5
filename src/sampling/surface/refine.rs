//! Internal refinement: edges that are long in the metric are halved until the mesh resolves the cells.
//!
//! In: a [`Domain`]. Out: the same surface and metric with more vertices. A triangle becomes two, three or four, as one,
//! two or three of its edges are halved; halves match across an edge, however many triangles share it. Because lengths are
//! measured in the metric, the refined mesh is even where cells are stretched, and small triangles stay as they are.

use super::{
    domain::{Domain, edge_square},
    form,
};
use crate::{error::PatternError, parallel, sampling::Progress, surface::order::group};

/// Marks an edge that is not halved.
const WHOLE: u32 = u32::MAX;
/// How much the length grows where halving would make too many vertices.
const COARSER: f32 = 1.2;

/// Halves edges longer than `length` (in the metric; touching samples are 2 apart), again and again. Where more than
/// `most` vertices would come of it, only longer edges are halved. The number of rounds done, each of which can be cancelled.
fn refine(domain: &mut Domain, length: f32, most: usize, progress: &Progress) -> Result<u32, PatternError> {
    let (mut length, mut rounds) = (length, 0);
    while length.is_finite() {
        progress.check()?;
        let edges = Edges::new(domain);
        let squares: Vec<f32> = parallel::collect(edges.ends.len(), |edge| {
            let [a, b] = edges.ends[edge];
            edge_square(domain, a, b)
        });
        let longer = |length: f32| squares.iter().filter(|&&s| s > length * length).count();
        while domain.positions.len() + longer(length) > most.max(domain.positions.len()) {
            length *= COARSER;
        }
        if longer(length) == 0 {
            break;
        }
        split(domain, &edges, |edge| squares[edge] > length * length);
        rounds += 1;
    }
    Ok(rounds)
}

/// [`refine`], and on until there are `least` vertices; but no more than `most`. The number of rounds done.
pub(super) fn refine_to(
    domain: &mut Domain,
    length: f32,
    least: usize,
    most: usize,
    progress: &Progress,
) -> Result<u32, PatternError> {
    let (mut length, mut rounds) = (length, refine(domain, length, most, progress)?);
    while domain.positions.len() < least.min(most) && length > f32::MIN_POSITIVE {
        length *= 0.8;
        rounds += refine(domain, length, most, progress)?;
    }
    Ok(rounds)
}

/// Halves every edge once.
pub(super) fn subdivide(domain: &mut Domain) {
    let edges = Edges::new(domain);
    split(domain, &edges, |_| true);
}

/// The edges of a domain, each once.
struct Edges {
    /// The two vertices of each edge, the smaller first.
    ends: Vec<[u32; 2]>,
    /// The edges of each triangle: from corner k to corner k + 1.
    of_triangle: Vec<[u32; 3]>,
}

impl Edges {
    fn new(domain: &Domain) -> Self {
        let sides: Vec<[u32; 2]> = domain
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        let smaller: Vec<u32> = sides.iter().map(|side| side[0]).collect();
        let (offsets, mut members) = group(&smaller, domain.positions.len());
        let mut ends: Vec<[u32; 2]> = Vec::with_capacity(sides.len() / 2);
        let mut of_side = vec![0; sides.len()];
        for range in offsets.windows(2) {
            let around = &mut members[range[0] as usize..range[1] as usize];
            around.sort_unstable_by_key(|&side| (sides[side as usize][1], side));
            for &side in &*around {
                if ends.last() != Some(&sides[side as usize]) {
                    ends.push(sides[side as usize]);
                }
                of_side[side as usize] = ends.len() as u32 - 1;
            }
        }
        let of_triangle = of_side.chunks_exact(3).map(|e| [e[0], e[1], e[2]]).collect();
        Self { ends, of_triangle }
    }
}

/// Halves the edges that are `marked`.
fn split(domain: &mut Domain, edges: &Edges, marked: impl Fn(usize) -> bool) {
    let mut middle = vec![WHOLE; edges.ends.len()];
    for (edge, &[a, b]) in edges.ends.iter().enumerate() {
        if marked(edge) {
            middle[edge] = domain.positions.len() as u32;
            domain.halved.push([a, b]);
            let (a, b) = (a as usize, b as usize);
            domain.positions.push(domain.positions[a].midpoint(domain.positions[b]));
            domain
                .metrics
                .push(form::middle(&domain.metrics[a], &domain.metrics[b]));
        }
    }
    let triangles = std::mem::take(&mut domain.triangles);
    let sources = std::mem::take(&mut domain.sources);
    for ((triangle, source), edges) in triangles.into_iter().zip(sources).zip(&edges.of_triangle) {
        let middles = edges.map(|edge| middle[edge as usize]);
        push_parts(domain, triangle, middles);
        domain.sources.resize(domain.triangles.len(), source);
    }
}

/// The parts of a triangle whose edges k, from corner k to corner k + 1, have the given middles.
fn push_parts(domain: &mut Domain, [a, b, c]: [u32; 3], middles: [u32; 3]) {
    let whole = middles.map(|m| m == WHOLE);
    match (whole, middles) {
        ([true, true, true], _) => domain.triangles.push([a, b, c]),
        ([false, false, false], [ab, bc, ca]) => {
            domain
                .triangles
                .extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        ([false, true, true], [m, ..]) => domain.triangles.extend([[a, m, c], [m, b, c]]),
        ([true, false, true], [_, m, _]) => domain.triangles.extend([[b, m, a], [m, c, a]]),
        ([true, true, false], [.., m]) => domain.triangles.extend([[c, m, b], [m, a, b]]),
        ([false, false, true], [ab, bc, _]) => push_three(domain, [a, b, c], ab, bc),
        ([true, false, false], [_, bc, ca]) => push_three(domain, [b, c, a], bc, ca),
        ([false, true, false], [ab, _, ca]) => push_three(domain, [c, a, b], ca, ab),
    }
}

/// Three parts of a triangle of which the edges ab and bc are halved; the quadrangle is cut along its shorter diagonal.
fn push_three(domain: &mut Domain, [a, b, c]: [u32; 3], ab: u32, bc: u32) {
    domain.triangles.push([ab, b, bc]);
    if edge_square(domain, a, bc) < edge_square(domain, ab, c) {
        domain.triangles.extend([[a, ab, bc], [a, bc, c]]);
    } else {
        domain.triangles.extend([[a, ab, c], [ab, bc, c]]);
    }
}
