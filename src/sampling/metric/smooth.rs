//! Smoothing of metrics over a surface.
//!
//! In: a metric per vertex. Out: one that varies slowly. The mean is taken of ln M (the log-Euclidean mean), which keeps
//! areas: the determinant of the mean is the geometric mean of the determinants, and where long axes of all directions
//! meet, the mean is a circle.

use super::tensor::{exponential, logarithm};
use crate::{parallel, surface::SurfaceGraph};
use glam_matrix_extras::SymmetricMat3;

/// Replaces each vertex's ln M by the mean of its own and its neighbours' mean, `steps` times. One step reaches as far
/// as the next vertices.
pub fn smooth(graph: &SurfaceGraph, metrics: &mut [SymmetricMat3], steps: u32) {
    if steps == 0 || metrics.len() != graph.len() {
        return;
    }
    let level = graph.mesh_level();
    let mut logs: Vec<SymmetricMat3> = parallel::collect(metrics.len(), |i| logarithm(&metrics[i]));
    let mut next = logs.clone();
    for _ in 0..steps {
        parallel::fill(&mut next, |i| {
            let edges = level.edges(i);
            if edges.is_empty() {
                return logs[i];
            }
            let weight = 0.5 / edges.len() as f32;
            level.neighbors[edges]
                .iter()
                .fold(logs[i] * 0.5, |sum, &j| sum + logs[j as usize] * weight)
        });
        std::mem::swap(&mut logs, &mut next);
    }
    parallel::fill(metrics, |i| exponential(&logs[i]));
}
