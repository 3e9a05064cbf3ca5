//! The given surface and metric, checked and brought to a common scale.
//!
//! In: a [`SurfaceGraph`], a metric per vertex and a [`Density`]. Out: a [`Domain`]: positions in a unit frame, metrics in
//! that frame with touching samples 2 apart, the triangles that have an area, and the number of samples.

use super::form;
use crate::{
    error::PatternError,
    parallel,
    sampling::Density,
    surface::{
        SurfaceGraph,
        geometry::double_area,
        order::{group, inverse, morton_order},
    },
};
use bevy::{math::DVec3, prelude::*};
use glam_matrix_extras::SymmetricMat3;

/// The most samples of one call; the refined mesh of so many needs about 4 GB.
pub const MAX_SAMPLES: u32 = 1_000_000;
/// Metric area of one sample of a hexagonal packing of unit ellipses.
pub(super) const SAMPLE_AREA: f64 = 3.464_101_615_137_754_6;
/// The fill rate that gives the count of a hexagonal packing.
const HEXAGONAL_FILL: f64 = 0.55;

/// A surface with a metric, ready to be refined. Vertices and triangles are along a Morton curve.
#[derive(Debug, Clone, Default)]
pub(super) struct Domain {
    /// Positions in a frame in which the surface has extent 1.
    pub(super) positions: Vec<Vec3>,
    /// Metric of each vertex in that frame.
    pub(super) metrics: Vec<SymmetricMat3>,
    /// Triangles that have an area.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The graph's triangle that each triangle is a part of.
    pub(super) sources: Vec<u32>,
    /// The vertex of each vertex of the graph.
    pub(super) vertex_of: Vec<u32>,
    /// The ends of the edge that each vertex halves, of those vertices that are not the graph's.
    pub(super) halved: Vec<[u32; 2]>,
}

/// What links the domain to the user's units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// Number of samples.
    pub(super) count: usize,
    /// Factor from the user's metrics to those of the result.
    pub(super) metric: f64,
}

impl Domain {
    /// The domain of a graph.
    pub(super) fn new(
        graph: &SurfaceGraph,
        metrics: &[SymmetricMat3],
        density: Density,
    ) -> Result<(Self, Scale), PatternError> {
        let order = morton_order(&graph.positions);
        let vertex_of = inverse(&order);
        let first_vertices: Vec<u32> = graph.triangles.iter().map(|t| first_of(t, &vertex_of)).collect();
        let (_, by_vertex) = group(&first_vertices, graph.len());
        let with_area = with_area(graph);
        let sources: Vec<u32> = by_vertex.into_iter().filter(|&t| with_area[t as usize]).collect();
        let mut domain = Self {
            positions: vec![Vec3::ZERO; graph.len()],
            metrics: vec![SymmetricMat3::ZERO; graph.len()],
            triangles: sources
                .iter()
                .map(|&t| graph.triangles[t as usize].map(|v| vertex_of[v as usize]))
                .collect(),
            sources,
            vertex_of,
            halved: Vec::new(),
        };
        let scale = domain.place(graph, metrics, density)?;
        Ok((domain, scale))
    }

    /// Takes positions and metrics from the graph, or from another one with the same triangles; vertices that halve edges
    /// stay in the middle.
    pub(super) fn place(
        &mut self,
        graph: &SurfaceGraph,
        metrics: &[SymmetricMat3],
        density: Density,
    ) -> Result<Scale, PatternError> {
        check(graph, metrics)?;
        let scale = scale(density, metric_area(graph, metrics))?;
        let (center, extent) = frame(graph);
        let factor = scale.metric * extent * extent;
        for (v, &i) in self.vertex_of.iter().enumerate() {
            let metric = scaled(&metrics[v], factor);
            if !metric.is_finite() {
                return Err(not_finite(v));
            }
            self.metrics[i as usize] = metric;
            self.positions[i as usize] = ((graph.positions[v].as_dvec3() - center) / extent).as_vec3();
        }
        for (i, &[a, b]) in (graph.len()..).zip(&self.halved) {
            self.positions[i] = self.positions[a as usize].midpoint(self.positions[b as usize]);
            self.metrics[i] = form::middle(&self.metrics[a as usize], &self.metrics[b as usize]);
        }
        Ok(scale)
    }

    /// The share of triangles with an edge that is longer in the metric.
    pub(super) fn share_of_long(&self, length: f32) -> f32 {
        let is_long = parallel::collect(self.triangles.len(), |t| {
            let [a, b, c] = self.triangles[t];
            [[a, b], [b, c], [c, a]]
                .iter()
                .any(|&[a, b]| edge_square(self, a, b) > length * length)
        });
        is_long.iter().filter(|long| **long).count() as f32 / is_long.len().max(1) as f32
    }
}

/// The graph has triangles; every metric is finite and positive definite.
fn check(graph: &SurfaceGraph, metrics: &[SymmetricMat3]) -> Result<(), PatternError> {
    if graph.is_cloud() {
        return Err(PatternError::Topology("PointList".into()));
    }
    let (found, expected) = (metrics.len(), graph.len());
    if found != expected {
        let what = "metrics";
        return Err(PatternError::WrongLength { what, found, expected });
    }
    if let Some(index) = metrics.iter().position(|m| !m.is_finite()) {
        return Err(not_finite(index));
    }
    match metrics.iter().position(|m| !is_positive(m)) {
        Some(index) => Err(PatternError::NotPositive {
            what: "metric of vertex",
            index,
        }),
        None => Ok(()),
    }
}

fn not_finite(index: usize) -> PatternError {
    let what = "metric of vertex";
    PatternError::NotFinite { what, index }
}

/// Sylvester's criterion.
fn is_positive(m: &SymmetricMat3) -> bool {
    let m = form::wide(m);
    let minor = m.m00 * m.m11 - m.m01 * m.m01;
    m.m00 > 0.0 && minor > 0.0 && form::determinant(&m) > 0.0
}

/// A metric times a factor; both may be far outside f32 as long as the product is not.
pub(super) fn scaled(m: &SymmetricMat3, factor: f64) -> SymmetricMat3 {
    let times = |x: f32| (f64::from(x) * factor) as f32;
    SymmetricMat3 {
        m00: times(m.m00),
        m01: times(m.m01),
        m02: times(m.m02),
        m11: times(m.m11),
        m12: times(m.m12),
        m22: times(m.m22),
    }
}

/// The sum of the triangles' metric areas, each in the mean metric of its corners; in f64, for units of any size.
pub(super) fn metric_area(graph: &SurfaceGraph, metrics: &[SymmetricMat3]) -> f64 {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| graph.positions[v as usize].as_dvec3());
        let [ma, mb, mc] = t.map(|v| form::wide(&metrics[v as usize]));
        let m = (ma + mb + mc) * (1.0 / 3.0);
        let (u, v) = (b - a, c - a);
        let (mu, mv) = (m * u, m * v);
        0.5 * (mu.dot(u) * mv.dot(v) - mu.dot(v).powi(2)).max(0.0).sqrt()
    };
    let areas = parallel::collect(graph.triangles.len(), |t| area(&graph.triangles[t]));
    areas.into_iter().sum()
}

/// Count of samples and factor of the metric.
fn scale(density: Density, area: f64) -> Result<Scale, PatternError> {
    let (count, metric) = match density {
        Density::Count(count) => (f64::from(count), f64::from(count) * SAMPLE_AREA / area),
        Density::FillRate(rate) if !(rate > 0.0 && rate.is_finite()) => {
            return Err(PatternError::OutOfRange {
                what: "the fill rate",
                value: rate,
                expected: "above 0",
            });
        }
        Density::FillRate(rate) => {
            let count = area / SAMPLE_AREA * f64::from(rate) / HEXAGONAL_FILL;
            (count.round().max(1.0), 1.0)
        }
    };
    if !(1.0..=f64::from(MAX_SAMPLES)).contains(&count) {
        return Err(PatternError::OutOfRange {
            what: "the number of samples",
            value: count as f32,
            expected: "1 to 1,000,000",
        });
    }
    let count = count as usize;
    Ok(Scale { count, metric })
}

/// Centre and largest extent of the surface's bounding box.
fn frame(graph: &SurfaceGraph) -> (DVec3, f64) {
    let (min, max) = graph
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| {
            (min.min(p.as_dvec3()), max.max(p.as_dvec3()))
        });
    ((min + max) * 0.5, (max - min).max_element())
}

fn first_of(triangle: &[u32; 3], rank: &[u32]) -> u32 {
    let [a, b, c] = triangle.map(|v| rank[v as usize]);
    a.min(b).min(c)
}

/// Which triangles of a graph have an area.
pub(super) fn with_area(graph: &SurfaceGraph) -> Vec<bool> {
    parallel::collect(graph.triangles.len(), |t| {
        double_area(graph.triangles[t].map(|v| graph.positions[v as usize])).is_some()
    })
}

/// Metric length of the edge between two vertices, squared, in the mean of their metrics.
pub(super) fn edge_square(domain: &Domain, a: u32, b: u32) -> f32 {
    let (a, b) = (a as usize, b as usize);
    let edge = domain.positions[b] - domain.positions[a];
    0.5 * (form::square(&domain.metrics[a], edge) + form::square(&domain.metrics[b], edge))
}
