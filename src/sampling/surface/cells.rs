//! Lloyd's step on labels: every site moves to the centroid of its cell.
//!
//! In: sites and labels. Out: new sites. A cell is the part of the surface nearest to a site, in the site's own metric d_i.
//! Triangles whose corners have different labels are cut where d_i² = d_j², linear along their edges, so that areas and
//! centroids are exact to second order on a mesh of few vertices per cell. For cells of this kind the *plain* centroid,
//! weighted by metric area, is the minimiser for a fixed cell and metric; the centroid weighted by M drifts.

use super::{
    mesh::FineMesh,
    walk::{Site, walk},
};
use crate::{parallel, surface::order::group};
use bevy::prelude::*;

/// Cells per task.
const CHUNK: usize = 256;

/// Moves every site `relaxation` times the way to its cell's centroid, and from there to the surface. Sites without a cell
/// stay.
pub(super) fn step(mesh: &FineMesh, sites: &[Site], labels: &[u32], relaxation: f32) -> Vec<Site> {
    let count = sites.len() as u32;
    let keys: Vec<u32> = labels.iter().map(|&label| label.min(count)).collect();
    let (offsets, members) = group(&keys, sites.len() + 1);
    parallel::collect_by(CHUNK, sites.len(), |i| {
        let vertices = &members[offsets[i] as usize..offsets[i + 1] as usize];
        let Some(centroid) = centroid(mesh, sites, labels, i as u32, vertices) else {
            return sites[i];
        };
        let target = sites[i].position + relaxation * centroid;
        back_to_surface(mesh, &sites[i], vertices, target)
    })
}

/// The centroid of a cell, relative to its site.
fn centroid(mesh: &FineMesh, sites: &[Site], labels: &[u32], own: u32, vertices: &[u32]) -> Option<Vec3> {
    let (mut area, mut moment) = (0.0, Vec3::ZERO);
    for &v in vertices {
        for &t in mesh.faces(v as usize) {
            let corners = mesh.triangles[t as usize];
            let corner_labels = corners.map(|c| labels[c as usize]);
            // Each triangle once, at the first of its corners that belongs to the cell.
            if corners
                .iter()
                .zip(corner_labels)
                .find(|(_, l)| *l == own)
                .map(|(c, _)| *c)
                != Some(v)
            {
                continue;
            }
            let (share, middle) = share(mesh, sites, t as usize, corner_labels, own);
            let [a, b, c] = mesh.corners(t as usize);
            area += share;
            moment += share * (a * middle.x + b * middle.y + c * middle.z - sites[own as usize].position);
        }
    }
    (area > 0.0).then(|| moment / area).filter(|c| c.is_finite())
}

/// The metric area of a cell's part of a triangle, and the weights of the triangle's corners at the part's centroid.
pub(super) fn share(mesh: &FineMesh, sites: &[Site], triangle: usize, labels: [u32; 3], own: u32) -> (f32, Vec3) {
    let mut polygon = Polygon::TRIANGLE;
    let corners = mesh.corners(triangle);
    for (k, &other) in labels.iter().enumerate() {
        let Some(site) = sites.get(other as usize) else {
            continue;
        };
        if other != own && !labels[..k].contains(&other) {
            let own = &sites[own as usize];
            polygon = polygon.clipped(Vec3::from_array(corners.map(|x| own.square(x) - site.square(x))));
        }
    }
    let (part, middle) = polygon.part_and_centroid();
    (part * mesh.areas[triangle], middle)
}

/// A part of a triangle: its corners as weights of the triangle's corners. Two cuts make five corners at most.
#[derive(Clone, Copy)]
pub(super) struct Polygon {
    corners: [Vec3; 6],
    len: usize,
}

impl Polygon {
    pub(super) const TRIANGLE: Self = Self {
        corners: [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO],
        len: 3,
    };

    /// The part where a function that is linear in the weights, with the given values at the triangle's corners, is not
    /// positive.
    fn clipped(&self, values: Vec3) -> Self {
        let mut part = Self { len: 0, ..*self };
        for k in 0..self.len {
            let (from, to) = (self.corners[k], self.corners[(k + 1) % self.len]);
            let (here, there) = (values.dot(from), values.dot(to));
            if here <= 0.0 {
                part.push(from);
            }
            if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
                part.push(from.lerp(to, here / (here - there)));
            }
        }
        part
    }

    fn push(&mut self, corner: Vec3) {
        if self.len < self.corners.len() {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    /// The part of the triangle's area, and the centroid.
    fn part_and_centroid(&self) -> (f32, Vec3) {
        let Some((&first, rest)) = self.corners[..self.len].split_first() else {
            return (0.0, Vec3::ZERO);
        };
        let (mut sum, mut moment) = (0.0, Vec3::ZERO);
        for pair in rest.windows(2) {
            let (u, v) = (pair[0] - first, pair[1] - first);
            let area = (u.x * v.y - u.y * v.x).abs();
            sum += area;
            moment += area / 3.0 * (first + pair[0] + pair[1]);
        }
        if sum > 0.0 { (sum, moment / sum) } else { (0.0, first) }
    }
}

/// The point of the surface next to `target`: from the cell's vertex that is nearest in the site's metric, a walk.
fn back_to_surface(mesh: &FineMesh, site: &Site, vertices: &[u32], target: Vec3) -> Site {
    let around = Site {
        position: target,
        ..*site
    };
    let nearest = vertices
        .iter()
        .map(|&v| (around.square(mesh.positions[v as usize]), v))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let start = nearest.map_or(site.triangle, |(_, v)| mesh.faces(v as usize)[0]);
    walk(mesh, start, target)
}
