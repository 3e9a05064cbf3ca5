//! How even samples on a surface are.
//!
//! In: a graph, its metric and samples on it. Out: [`SampleQuality`]. The figures are taken on a refinement of at least 100
//! vertices per sample, whose labels are found over the surface, so that the sheets of a thin part do not mix.

use super::{
    domain::Domain,
    form, labels,
    mesh::{FineMesh, NONE},
    refine::refine_to,
    result,
    walk::{Site, closest_weights},
    warm,
};
use crate::{
    error::PatternError,
    sampling::{Density, Progress, SampleQuality, SampleSet},
    surface::SurfaceGraph,
};
use glam_matrix_extras::SymmetricMat3;

/// Points per sample on which the figures are taken.
const POINTS: usize = 100;
/// Edges are no longer than this, where touching samples are 2 apart.
const EDGE: f32 = 0.5;
/// The most points per sample, besides the vertices of the graph.
const MAX_POINTS: usize = 400;
/// `d_hex` where the metric area is 2√3 per sample.
const SPACING: f32 = 2.0;
/// Cells nearer to a border than this, in `d_hex`, are cut by it.
const BORDER: f32 = 1.2;

/// Figures of evenness of samples on a graph, in the metric given per vertex of the graph. The metric's scale and the
/// metrics of the samples do not matter.
///
/// # Errors
/// Those of [`sample_surface`](super::sample_surface) for the metric; [`OutOfRange`](PatternError::OutOfRange) where there
/// are no samples, [`WrongLength`](PatternError::WrongLength) where lists of the set differ in length, and
/// [`IndexOutOfRange`](PatternError::IndexOutOfRange) where a sample's triangle is none of the graph's.
pub fn surface_quality(
    graph: &SurfaceGraph,
    metrics: &[SymmetricMat3],
    samples: &SampleSet,
) -> Result<SampleQuality, PatternError> {
    check(graph, samples)?;
    let (mut domain, _) = Domain::new(graph, metrics, Density::Count(samples.len() as u32))?;
    let (least, most) = (POINTS * samples.len(), MAX_POINTS * samples.len() + graph.len());
    refine_to(&mut domain, EDGE, least, most, &Progress::default())?;
    let mesh = FineMesh::new(&domain);
    let sites = warm::located(&mesh, graph, &samples.triangles, |i| {
        let corners = graph.triangles[samples.triangles[i] as usize];
        closest_weights(samples.positions[i], corners.map(|v| graph.positions[v as usize]))
    });
    let mut cells = vec![NONE; mesh.len()];
    labels::claim(&mesh, &sites, &mut cells);
    labels::exchange(&mesh, &sites, &mut cells, usize::MAX);
    let rings = Rings::new(&mesh, &cells, sites.len());
    let mut quality = SampleQuality::default();
    neighbor_figures(&mut quality, &sites, &rings);
    cell_figures(&mut quality, &mesh, &sites, &cells, &rings);
    Ok(quality)
}

pub(super) fn check(graph: &SurfaceGraph, samples: &SampleSet) -> Result<(), PatternError> {
    if samples.is_empty() {
        return Err(PatternError::OutOfRange {
            what: "the number of samples",
            value: 0.0,
            expected: "1 or more",
        });
    }
    if samples.triangles.len() != samples.len() {
        return Err(PatternError::WrongLength {
            what: "triangles of samples",
            found: samples.triangles.len(),
            expected: samples.len(),
        });
    }
    match samples.triangles.iter().find(|&&t| t as usize >= graph.triangles.len()) {
        Some(&index) => Err(PatternError::IndexOutOfRange {
            index,
            vertices: graph.triangles.len(),
        }),
        None => Ok(()),
    }
}

/// The cells around each cell.
struct Rings {
    offsets: Vec<u32>,
    neighbors: Vec<u32>,
}

impl Rings {
    fn new(mesh: &FineMesh, cells: &[u32], sites: usize) -> Self {
        let (offsets, neighbors) = result::neighbors(mesh, cells, sites);
        Self { offsets, neighbors }
    }

    fn first(&self, i: usize) -> &[u32] {
        &self.neighbors[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// The first and the second ring, some members more than once, possibly with `i` itself.
    fn second(&self, i: usize) -> impl Iterator<Item = usize> {
        let outer = self.first(i).iter().flat_map(|&j| self.first(j as usize));
        self.first(i).iter().chain(outer).map(|&j| j as usize)
    }
}

/// Distances to the nearest sample.
fn neighbor_figures(quality: &mut SampleQuality, sites: &[Site], rings: &Rings) {
    let distance = |i: usize, j: usize| {
        let metric = form::middle(&sites[i].metric, &sites[j].metric);
        form::square(&metric, sites[j].position - sites[i].position).sqrt() / SPACING
    };
    let mut distances: Vec<f32> = (0..sites.len())
        .filter_map(|i| {
            rings
                .second(i)
                .filter(|&j| j != i)
                .map(|j| distance(i, j))
                .min_by(f32::total_cmp)
        })
        .collect();
    distances.sort_unstable_by(f32::total_cmp);
    if let Some(&least) = distances.first() {
        (quality.nn_mean, quality.nn_cv) = mean_and_cv(&distances);
        (quality.nn_min, quality.nn_p1) = (least, distances[distances.len() / 100]);
    }
}

/// Areas, holes and coverage.
fn cell_figures(quality: &mut SampleQuality, mesh: &FineMesh, sites: &[Site], cells: &[u32], rings: &Rings) {
    let mut areas = vec![0.0_f32; sites.len()];
    let (mut total, mut covered, mut overlapping) = (0.0_f64, 0.0, 0.0);
    let reach = (0.5 * SPACING).powi(2);
    for (v, &cell) in cells.iter().enumerate().filter(|(_, cell)| **cell != NONE) {
        let (i, weight, point) = (cell as usize, mesh.weights[v], mesh.positions[v]);
        let square = sites[i].square(point);
        areas[i] += weight;
        total += f64::from(weight);
        quality.hole = quality.hole.max(square.sqrt() / SPACING);
        if square < reach {
            covered += f64::from(weight);
            if rings.first(i).iter().any(|&j| sites[j as usize].square(point) < reach) {
                overlapping += f64::from(weight);
            }
        }
    }
    let at_border = at_border(mesh, sites, cells, rings);
    let inner: Vec<f32> = (0..sites.len()).filter(|&i| !at_border[i]).map(|i| areas[i]).collect();
    quality.area_cv = mean_and_cv(&inner).1;
    quality.empty_cells = labels::empty_cells(sites.len(), cells).len() as u32;
    quality.coverage = (covered / total) as f32;
    quality.overlap = (overlapping / total) as f32;
    quality.grading = grading(sites, &areas);
}

/// Samples that a border is near to.
fn at_border(mesh: &FineMesh, sites: &[Site], cells: &[u32], rings: &Rings) -> Vec<bool> {
    let mut at_border = vec![false; sites.len()];
    for v in (0..mesh.len()).filter(|&v| cells[v] != NONE && mesh.is_border(v)) {
        let i = cells[v] as usize;
        for j in std::iter::once(i).chain(rings.second(i)) {
            at_border[j] |= sites[j].square(mesh.positions[v]) < (BORDER * SPACING).powi(2);
        }
    }
    at_border
}

/// Mean area of the quarter of cells with the largest ellipses, divided by that of the quarter with the smallest.
fn grading(sites: &[Site], areas: &[f32]) -> f32 {
    let mut order: Vec<usize> = (0..sites.len()).collect();
    // The larger the determinant, the smaller the ellipse.
    let determinant = |i: usize| form::determinant(&form::wide(&sites[i].metric));
    order.sort_by(|&a, &b| determinant(b).total_cmp(&determinant(a)));
    let quarter = order.len().div_ceil(4);
    let sum = |indices: &[usize]| indices.iter().map(|&i| areas[i]).sum::<f32>();
    sum(&order[order.len() - quarter..]) / sum(&order[..quarter])
}

/// Mean, and standard deviation divided by the mean; 0 where there are no values.
fn mean_and_cv(values: &[f32]) -> (f32, f32) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / count;
    let variance = values.iter().map(|&x| (f64::from(x) - mean).powi(2)).sum::<f64>() / count;
    if mean > 0.0 {
        (mean as f32, (variance.sqrt() / mean) as f32)
    } else {
        (0.0, 0.0)
    }
}
