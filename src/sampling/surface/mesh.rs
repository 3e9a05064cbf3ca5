//! The mesh that samples live on: a refined [`Domain`] with what surrounds each vertex.
//!
//! In: a [`Domain`]. Out: a [`FineMesh`]: along a Morton curve, with neighbours and triangles of each vertex in CSR form
//! and metric areas.

use super::{domain::Domain, form, walk::Site};
use crate::{
    parallel,
    surface::order::{group, inverse, morton_order},
};
use bevy::prelude::*;
use glam_matrix_extras::SymmetricMat3;
use std::sync::OnceLock;

/// Marks a vertex or triangle that is none.
pub(super) const NONE: u32 = u32::MAX;

/// A refined surface with a metric.
#[derive(Debug, Default)]
pub(super) struct FineMesh {
    /// Position of each vertex.
    pub(super) positions: Vec<Vec3>,
    /// Metric of each vertex.
    pub(super) metrics: Vec<SymmetricMat3>,
    /// A third of the metric areas of the triangles around each vertex; 0 at isolated vertices.
    pub(super) weights: Vec<f32>,
    /// Vertices of each triangle.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Metric area of each triangle, in the mean metric of its corners.
    pub(super) areas: Vec<f32>,
    /// Area of each triangle as it is in space.
    pub(super) flat_areas: Vec<f32>,
    /// A third of the areas in space of the triangles around each vertex.
    pub(super) flat_weights: Vec<f32>,
    /// The graph's triangle that each triangle is a part of.
    pub(super) sources: Vec<u32>,
    /// The vertex of each vertex of the graph.
    pub(super) vertex_of: Vec<u32>,
    /// The vertex of each vertex of the domain.
    rank: Vec<u32>,
    /// Unit normal of each vertex, once asked for.
    normals: OnceLock<Vec<Vec3>>,
    face_offsets: Vec<u32>,
    faces: Vec<u32>,
    offsets: Vec<u32>,
    neighbors: Vec<u32>,
}

impl FineMesh {
    /// The mesh of a domain.
    pub(super) fn new(domain: &Domain) -> Self {
        let vertices = domain.positions.len();
        let order = morton_order(&domain.positions);
        let rank = inverse(&order);
        let first = |t: &[u32; 3]| t.iter().map(|&v| rank[v as usize]).fold(NONE, u32::min);
        let firsts: Vec<u32> = domain.triangles.iter().map(first).collect();
        let (_, by_vertex) = group(&firsts, vertices);
        let renamed = |t: u32| domain.triangles[t as usize].map(|v| rank[v as usize]);
        let mut mesh = Self {
            positions: order.iter().map(|&v| domain.positions[v as usize]).collect(),
            metrics: order.iter().map(|&v| domain.metrics[v as usize]).collect(),
            triangles: by_vertex.iter().map(|&t| renamed(t)).collect(),
            sources: by_vertex.iter().map(|&t| domain.sources[t as usize]).collect(),
            vertex_of: domain.vertex_of.iter().map(|&v| rank[v as usize]).collect(),
            rank,
            ..default()
        };
        mesh.link();
        mesh.measure();
        mesh
    }

    /// Takes positions and metrics from its domain, where these have changed.
    pub(super) fn place(&mut self, domain: &Domain) {
        for (i, &v) in self.rank.iter().enumerate() {
            self.positions[v as usize] = domain.positions[i];
            self.metrics[v as usize] = domain.metrics[i];
        }
        self.normals = OnceLock::new();
        self.measure();
    }

    /// Number of vertices.
    pub(super) fn len(&self) -> usize {
        self.positions.len()
    }

    /// The triangles around a vertex.
    #[inline(always)]
    pub(super) fn faces(&self, vertex: usize) -> &[u32] {
        &self.faces[self.face_offsets[vertex] as usize..self.face_offsets[vertex + 1] as usize]
    }

    /// The vertices that share an edge with a vertex.
    #[inline(always)]
    pub(super) fn neighbors(&self, vertex: usize) -> &[u32] {
        &self.neighbors[self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize]
    }

    /// Whether an edge at a vertex has one triangle only.
    pub(super) fn is_border(&self, vertex: usize) -> bool {
        let has = |t: u32, w: u32| self.triangles[t as usize].contains(&w);
        let alone = |&w: &u32| self.faces(vertex).iter().filter(|&&t| has(t, w)).count() == 1;
        self.neighbors(vertex).iter().any(alone)
    }

    /// Positions of a triangle's corners.
    #[inline(always)]
    pub(super) fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// The metric at a point of a triangle.
    #[inline(always)]
    pub(super) fn metric_at(&self, triangle: usize, weights: Vec3) -> SymmetricMat3 {
        form::blend(self.triangles[triangle].map(|v| &self.metrics[v as usize]), weights)
    }

    /// Unit normal of the surface at a site: the mean of the triangles around the corners of its own, weighted by area.
    pub(super) fn normal(&self, site: &Site) -> Vec3 {
        let normals = self.normals.get_or_init(|| {
            parallel::collect(self.len(), |v| {
                let sum: Vec3 = self.faces(v).iter().map(|&t| self.cross(t as usize)).sum();
                sum.normalize_or_zero()
            })
        });
        let [a, b, c] = self.triangles[site.triangle as usize].map(|v| normals[v as usize]);
        (a * site.weights.x + b * site.weights.y + c * site.weights.z)
            .try_normalize()
            .unwrap_or_else(|| self.cross(site.triangle as usize).normalize_or(Vec3::Z))
    }

    fn cross(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    /// The surface's metric area.
    pub(super) fn area(&self) -> f64 {
        self.areas.iter().map(|&a| f64::from(a)).sum()
    }

    fn link(&mut self) {
        (self.face_offsets, self.faces) = group(self.triangles.as_flattened(), self.len());
        self.faces.iter_mut().for_each(|corner| *corner /= 3);
        self.offsets = Vec::with_capacity(self.len() + 1);
        self.neighbors = Vec::with_capacity(self.faces.len() + self.len() / 8);
        self.offsets.push(0);
        let mut around: Vec<u32> = Vec::new();
        for v in 0..self.len() {
            around.clear();
            around.extend(self.faces(v).iter().flat_map(|&t| self.triangles[t as usize]));
            around.retain(|&w| w != v as u32);
            around.sort_unstable();
            around.dedup();
            self.neighbors.extend_from_slice(&around);
            self.offsets.push(self.neighbors.len() as u32);
        }
    }

    fn measure(&mut self) {
        self.areas = parallel::collect(self.triangles.len(), |t| {
            let [a, b, c] = self.corners(t);
            let metric = form::mean(self.triangles[t].map(|v| &self.metrics[v as usize]));
            0.5 * form::double_area(&metric, b - a, c - a)
        });
        self.flat_areas = parallel::collect(self.triangles.len(), |t| 0.5 * self.cross(t).length());
        self.weights = self.thirds(&self.areas);
        self.flat_weights = self.thirds(&self.flat_areas);
    }

    /// A third of the areas of the triangles around each vertex.
    fn thirds(&self, areas: &[f32]) -> Vec<f32> {
        parallel::collect(self.len(), |v| {
            self.faces(v).iter().map(|&t| areas[t as usize]).sum::<f32>() / 3.0
        })
    }
}
