//! Lloyd's step on labels: every site moves to the centroid of its cell.
//!
//! In: sites and labels. Out: new sites. A cell is the part of the surface nearest to a site, in the site's own metric d_i.
//! Triangles whose corners have different labels are cut where d_i² = d_j², linear along their edges, so that areas and
//! centroids are exact to second order on a mesh of few vertices per cell.
//!
//! For such cells the centroid is the *plain* one, weighted by the area in space: neither by M, which drifts at singularities,
//! nor by the metric area, which overdoes the grading. For let h be the distance of neighbours and s the size of the
//! ellipses, both varying slowly. A bisector lies at h/2 (1 + (h'/2 - h s'/2s) cos θ) in direction θ, so the cell's centroid
//! is off by h/2 (h'/2 - h s'/2s) + w'/w h²/16 for a weight w. It is at the site for h'/h = s'/s - w'/4w: only with a constant
//! weight the distance of neighbours follows the size.
//!
//! A triangle is first shared out in thirds, each to the cell of a corner; that is exact where the labels are the same, and
//! elsewhere a cut moves an amount of area and moment from one cell to another.

use super::{
    form,
    mesh::{FineMesh, NONE},
    walk::{Site, walk},
};
use crate::parallel;
use bevy::{math::Vec4, prelude::*};
use glam_matrix_extras::SymmetricMat3;

/// Cells per task.
const CELLS: usize = 512;
/// Triangles per task.
const TRIANGLES: usize = 8192;
/// A third of a triangle, as [`Polygon::moment`] has it.
const THIRD: f32 = 1.0 / 3.0;

/// Moves every site `relaxation` times the way to its cell's centroid, and from there to the surface. Sites without a cell
/// stay.
pub(super) fn step(mesh: &FineMesh, sites: &[Site], labels: &[u32], relaxation: f32) -> Vec<Site> {
    let moments = moments(mesh, sites, labels);
    parallel::collect_by(CELLS, sites.len(), |i| {
        let (site, moment) = (&sites[i], moments[i]);
        let centroid = moment.truncate() / moment.w;
        if moment.w > 0.0 && centroid.is_finite() {
            walk(mesh, site.triangle, site.position + relaxation * centroid)
        } else {
            *site
        }
    })
}

/// Area (w) and first moment about the site (xyz) of each cell.
fn moments(mesh: &FineMesh, sites: &[Site], labels: &[u32]) -> Vec<Vec4> {
    let mut moments = vec![Vec4::ZERO; sites.len()];
    for (v, &label) in labels.iter().enumerate() {
        if let Some(site) = sites.get(label as usize) {
            moments[label as usize] += mesh.flat_weights[v] * (mesh.positions[v] - site.position).extend(1.0);
        }
    }
    let tasks = mesh.triangles.len().div_ceil(TRIANGLES);
    let transfers = parallel::collect_by(1, tasks, |task| {
        let mut transfers = Vec::new();
        let first = task * TRIANGLES;
        for t in first..(first + TRIANGLES).min(mesh.triangles.len()) {
            push_transfers(&mut transfers, mesh, sites, labels, t);
        }
        transfers
    });
    // In the order of the triangles, whoever cut them.
    for Transfer {
        from,
        to,
        amount,
        about,
    } in transfers.into_iter().flatten()
    {
        let moved = |site: &Site| amount + (amount.w * (about - site.position)).extend(0.0);
        if let Some(site) = sites.get(to as usize) {
            moments[to as usize] += moved(site);
        }
        if let Some(site) = sites.get(from as usize) {
            moments[from as usize] -= moved(site);
        }
    }
    moments
}

/// Area and moment about a point that a cut moves from one cell to another.
#[derive(Debug, Clone, Copy)]
struct Transfer {
    from: u32,
    to: u32,
    amount: Vec4,
    about: Vec3,
}

/// What the cuts of a triangle move.
#[inline(always)]
fn push_transfers(transfers: &mut Vec<Transfer>, mesh: &FineMesh, sites: &[Site], labels: &[u32], triangle: usize) {
    let vertices = mesh.triangles[triangle];
    let [la, lb, lc] = vertices.map(|v| labels[v as usize]);
    if la == lb && lb == lc {
        return;
    }
    let corners = vertices.map(|v| mesh.positions[v as usize]);
    let mut push = |from: u32, to: u32, weights: Vec3| {
        let [a, b, c] = corners;
        let moment = weights.y * (b - a) + weights.z * (c - a);
        transfers.push(Transfer {
            from,
            to,
            amount: mesh.flat_areas[triangle] * moment.extend(weights.element_sum()),
            about: a,
        });
    };
    if la != lb && lb != lc && lc != la {
        for (k, own) in [la, lb, lc].into_iter().enumerate() {
            push(
                NONE,
                own,
                share_of_three(sites, corners, [la, lb, lc], own) - THIRD * Vec3::AXES[k],
            );
        }
    } else {
        // One corner has another label than the two others.
        let (lone, to, from) = if lb == lc {
            (0, la, lb)
        } else if lc == la {
            (1, lb, lc)
        } else {
            (2, lc, la)
        };
        push(from, to, tip(sites, corners, to, from, lone) - THIRD * Vec3::AXES[lone]);
    }
}

/// The part of a triangle around its corner `lone`, whose label differs from that of the two others: its part of the area,
/// times the weights of the triangle's corners at its centroid.
#[inline(always)]
fn tip(sites: &[Site], corners: [Vec3; 3], own: u32, other: u32, lone: usize) -> Vec3 {
    let (Some(own), Some(other)) = (sites.get(own as usize), sites.get(other as usize)) else {
        return THIRD * Vec3::AXES[lone];
    };
    let (next, last) = ((lone + 1) % 3, (lone + 2) % 3);
    let bisector = Bisector::new(own, other);
    let excess = |k: usize| bisector.excess(corners[k]);
    let here = excess(lone).min(0.0);
    // Where the cells meet on the edge to corner k.
    let cut = |k: usize| {
        let there = excess(k);
        if there > 0.0 {
            here / (here - there)
        } else {
            f32::from(u8::from(here < 0.0))
        }
    };
    let (s, t) = (cut(next), cut(last));
    let mut weights = Vec3::ZERO;
    weights[lone] = 1.0 - THIRD * (s + t);
    weights[next] = THIRD * s;
    weights[last] = THIRD * t;
    s * t * weights
}

/// A cell's part of a triangle whose corners all have different labels, as [`tip`] has it.
fn share_of_three(sites: &[Site], corners: [Vec3; 3], labels: [u32; 3], own: u32) -> Vec3 {
    let mut polygon = Polygon::TRIANGLE;
    for other in labels.into_iter().filter(|&other| other != own) {
        if let (Some(own), Some(other)) = (sites.get(own as usize), sites.get(other as usize)) {
            let bisector = Bisector::new(own, other);
            polygon = polygon.clipped(Vec3::from_array(corners.map(|x| bisector.excess(x))));
        }
    }
    polygon.moment()
}

/// The quadric on which a point is equally near to two sites: d_i² - d_j² in terms of the way from site i.
struct Bisector {
    origin: Vec3,
    quadratic: SymmetricMat3,
    linear: Vec3,
    constant: f32,
}

impl Bisector {
    #[inline(always)]
    fn new(own: &Site, other: &Site) -> Self {
        let apart = other.position - own.position;
        let gradient = form::apply(&other.metric, apart);
        Self {
            origin: own.position,
            quadratic: form::difference(&own.metric, &other.metric),
            linear: 2.0 * gradient,
            constant: -gradient.dot(apart),
        }
    }

    /// How much farther a point is from the own site, squared, than from the other one.
    #[inline(always)]
    fn excess(&self, point: Vec3) -> f32 {
        let way = point - self.origin;
        form::square(&self.quadratic, way) + self.linear.dot(way) + self.constant
    }
}

/// A part of a triangle: its corners as weights of the triangle's corners. Two cuts make five corners at most.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [Vec3; 6],
    len: usize,
}

impl Polygon {
    const TRIANGLE: Self = Self {
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

    /// The part of the triangle's area, times the weights of the triangle's corners at the centroid.
    fn moment(&self) -> Vec3 {
        let Some((&first, rest)) = self.corners[..self.len].split_first() else {
            return Vec3::ZERO;
        };
        let part = |pair: &[Vec3]| {
            let (u, v) = (pair[0] - first, pair[1] - first);
            (u.x * v.y - u.y * v.x).abs() * THIRD * (first + pair[0] + pair[1])
        };
        rest.windows(2).map(part).sum()
    }
}
