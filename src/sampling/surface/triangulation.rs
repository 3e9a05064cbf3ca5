//! A triangulation whose vertices are samples on a surface.
//!
//! In: sites and triangles between them, of any kind. Out: a [`Triangulation`] that can be walked from triangle to triangle.
//! An edge that has not exactly two triangles, one on each side, is a border.

use super::{
    form,
    mesh::{FineMesh, NONE},
    walk::Site,
};
use bevy::prelude::*;
use glam_matrix_extras::SymmetricMat3;

/// A triangle of samples. Neighbour k is across the edge opposite to corner k, or [`NONE`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub(super) corners: [u32; 3],
    pub(super) neighbors: [u32; 3],
}

/// Samples and the triangles between them.
#[derive(Debug, Clone, Default)]
pub(super) struct Triangulation {
    pub(super) sites: Vec<Site>,
    /// Unit normal of the surface at each site.
    pub(super) normals: Vec<Vec3>,
    pub(super) triangles: Vec<Triangle>,
    /// Whether each site is at a border, or in no triangle.
    pub(super) fixed: Vec<bool>,
}

impl Triangulation {
    /// The triangulation of sites by triangles.
    pub(super) fn new(mesh: &FineMesh, sites: Vec<Site>, triangles: &[[u32; 3]]) -> Self {
        let mut triangulation = Self {
            normals: sites.iter().map(|site| mesh.normal(site)).collect(),
            fixed: vec![true; sites.len()],
            triangles: triangles
                .iter()
                .map(|&corners| Triangle {
                    corners,
                    neighbors: [NONE; 3],
                })
                .collect(),
            sites,
        };
        triangulation.link();
        triangulation.fix_borders();
        triangulation
    }

    fn link(&mut self) {
        let mut sides: Vec<([u32; 2], u32, usize, bool)> = Vec::with_capacity(3 * self.triangles.len());
        for (t, triangle) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (triangle.corners[(k + 1) % 3], triangle.corners[(k + 2) % 3]);
                sides.push(([a.min(b), a.max(b)], t as u32, k, a < b));
            }
        }
        sides.sort_unstable();
        for edge in sides.chunk_by(|a, b| a.0 == b.0) {
            if let &[(_, t, k, up), (_, u, j, down)] = edge
                && up != down
                && t != u
            {
                self.triangles[t as usize].neighbors[k] = u;
                self.triangles[u as usize].neighbors[j] = t;
            }
        }
    }

    fn fix_borders(&mut self) {
        for triangle in &self.triangles {
            triangle.corners.iter().for_each(|&v| self.fixed[v as usize] = false);
        }
        for triangle in &self.triangles {
            for k in (0..3).filter(|&k| triangle.neighbors[k] == NONE) {
                self.fixed[triangle.corners[(k + 1) % 3] as usize] = true;
                self.fixed[triangle.corners[(k + 2) % 3] as usize] = true;
            }
        }
    }

    /// Positions of a triangle's corners.
    #[inline(always)]
    pub(super) fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle]
            .corners
            .map(|v| self.sites[v as usize].position)
    }

    /// The mean metric of a triangle's corners.
    #[inline(always)]
    pub(super) fn metric(&self, triangle: usize) -> SymmetricMat3 {
        form::mean(self.triangles[triangle].corners.map(|v| &self.sites[v as usize].metric))
    }

    /// Metric area of a triangle.
    pub(super) fn area(&self, triangle: usize) -> f32 {
        let [a, b, c] = self.corners(triangle);
        0.5 * form::double_area(&self.metric(triangle), b - a, c - a)
    }

    /// Whether a triangle looks the way of its corners' normals.
    pub(super) fn is_upright(&self, triangle: usize) -> bool {
        let [a, b, c] = self.corners(triangle);
        let normal: Vec3 = self.triangles[triangle]
            .corners
            .iter()
            .map(|&v| self.normals[v as usize])
            .sum();
        (b - a).cross(c - a).dot(normal) > 0.0
    }

    /// Puts a sample into a triangle, which becomes three. Returns the two new triangles.
    pub(super) fn insert(&mut self, triangle: u32, site: Site, normal: Vec3) -> [u32; 2] {
        let x = self.sites.len() as u32;
        self.sites.push(site);
        self.normals.push(normal);
        self.fixed.push(false);
        let Triangle {
            corners: [a, b, c],
            neighbors: [na, nb, nc],
        } = self.triangles[triangle as usize];
        let second = self.triangles.len() as u32;
        let third = second + 1;
        let made = |corners, neighbors| Triangle { corners, neighbors };
        self.triangles[triangle as usize] = made([x, b, c], [na, second, third]);
        self.triangles.push(made([x, c, a], [nb, third, triangle]));
        self.triangles.push(made([x, a, b], [nc, triangle, second]));
        self.relink(nb, triangle, second);
        self.relink(nc, triangle, third);
        [second, third]
    }

    /// Tells a triangle that its neighbour has another name.
    #[inline(always)]
    pub(super) fn relink(&mut self, triangle: u32, from: u32, to: u32) {
        if let Some(triangle) = self.triangles.get_mut(triangle as usize)
            && let Some(k) = triangle.neighbors.iter().position(|&n| n == from)
        {
            triangle.neighbors[k] = to;
        }
    }
}
