//! Lloyd's step on labels: every site moves to the centroid of its cell.
//!
//! In: sites and labels. Out: new sites. A cell is the part of the surface nearest to a site, in the site's own metric d_i.
//! Triangles whose corners have different labels are cut where `d_i² = d_j²`, linear along their edges, so that areas and
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
    mesh::FineMesh,
    walk::{Site, walk},
};
use crate::parallel;
use bevy::{math::Vec4, prelude::*};

/// Cells per task.
const CELLS: usize = 512;
/// The least vertices per task, and the most tasks. Tasks depend on the mesh alone, since sums depend on the tasks.
const VERTICES: usize = 4096;
const TASKS: usize = 64;
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
    let tasks = mesh.len().div_ceil(VERTICES).clamp(1, TASKS);
    let parts = parallel::collect_by(1, tasks, |task| {
        let range = |len: usize| len * task / tasks..len * (task + 1) / tasks;
        let mut part = Part::new(sites);
        for v in range(mesh.len()) {
            part.add(labels[v], mesh.flat_weights[v], mesh.positions[v], Vec4::ZERO);
        }
        for t in range(mesh.triangles.len()) {
            let vertices = mesh.triangles[t];
            let [a, b, c] = vertices.map(|v| labels[v as usize]);
            if a != b || b != c {
                part.cut(mesh, vertices, [a, b, c], mesh.flat_areas[t]);
            }
        }
        part.moments
    });
    let mut moments = vec![Vec4::ZERO; sites.len()];
    for (label, moment) in parts.into_iter().flatten() {
        moments[label as usize] += moment;
    }
    moments
}

/// The moments of those cells that one task has to do with.
struct Part<'a> {
    sites: &'a [Site],
    moments: Vec<(u32, Vec4)>,
    /// One more than where each site's moment is, or 0.
    slots: Vec<u32>,
}

impl<'a> Part<'a> {
    fn new(sites: &'a [Site]) -> Self {
        Self {
            sites,
            moments: Vec::new(),
            slots: vec![0; sites.len()],
        }
    }

    /// Adds an area at a point, and a moment about that point, to a cell.
    #[inline(always)]
    fn add(&mut self, label: u32, area: f32, about: Vec3, moment: Vec4) {
        let Some(slot) = self.slots.get_mut(label as usize) else {
            return;
        };
        if *slot == 0 {
            self.moments.push((label, Vec4::ZERO));
            *slot = self.moments.len() as u32;
        }
        let way = about - self.sites[label as usize].position;
        self.moments[*slot as usize - 1].1 += area * way.extend(1.0) + moment;
    }

    /// Moves what the cuts of a triangle move, compared with thirds.
    #[inline(always)]
    fn cut(&mut self, mesh: &FineMesh, vertices: [u32; 3], labels: [u32; 3], area: f32) {
        // The corner with a label of its own comes first.
        let ([u, v, w], [a, b, c]) = (vertices, labels);
        let ([u, v, w], [a, b, c]) = if b == c {
            ([u, v, w], [a, b, c])
        } else if c == a {
            ([v, w, u], [b, c, a])
        } else {
            ([w, u, v], [c, a, b])
        };
        let points = [u, v, w].map(|v| mesh.positions[v as usize]);
        let squares = Corners::new(points);
        let site = |label: u32| self.sites.get(label as usize);
        let (Some(first), Some(second), Some(third)) = (site(a), site(b), site(c)) else {
            return;
        };
        let (first, second) = (squares.of(first), squares.of(second));
        let [p, q, r] = points;
        let (across, along) = (q - p, r - p);
        // An area and its moment about the first corner.
        let scaled = |weights: Vec3| {
            let moment = area * (weights.y * across + weights.z * along);
            (area * weights.element_sum(), moment.extend(0.0))
        };
        if b == c {
            let (size, moment) = scaled(tip(first - second) - THIRD * Vec3::X);
            self.add(a, size, p, moment);
            self.add(b, -size, p, -moment);
        } else {
            let shares = shares([first, second, squares.of(third)]);
            for (k, label) in [a, b, c].into_iter().enumerate() {
                let (size, moment) = scaled(shares[k] - THIRD * Vec3::AXES[k]);
                self.add(label, size, p, moment);
            }
        }
    }
}

/// The corners of a triangle, coordinate by coordinate, so that all three are computed at once.
struct Corners {
    x: Vec4,
    y: Vec4,
    z: Vec4,
}

impl Corners {
    #[inline(always)]
    fn new([a, b, c]: [Vec3; 3]) -> Self {
        Self {
            x: Vec4::new(a.x, b.x, c.x, c.x),
            y: Vec4::new(a.y, b.y, c.y, c.y),
            z: Vec4::new(a.z, b.z, c.z, c.z),
        }
    }

    /// The corners' squared distances from a site, in its metric.
    #[inline(always)]
    fn of(&self, site: &Site) -> Vec3 {
        let (p, m) = (site.position, &site.metric);
        let (x, y, z) = (self.x - p.x, self.y - p.y, self.z - p.z);
        let square =
            x * (m.m00 * x + 2.0 * (m.m01 * y + m.m02 * z)) + y * (m.m11 * y + 2.0 * m.m12 * z) + m.m22 * z * z;
        square.truncate()
    }
}

/// The part of a triangle around its first corner, of which the second and the third have another label: its part of the
/// area, times the weights of the triangle's corners at its centroid. Given is how much farther the corners are from the
/// first one's site, squared, than from the other one.
#[inline(always)]
fn tip(excess: Vec3) -> Vec3 {
    let here = excess.x.min(0.0);
    // Where the cells meet on the edge to another corner.
    let cut = |there: f32| {
        if there > 0.0 {
            here / (here - there)
        } else {
            f32::from(u8::from(here < 0.0))
        }
    };
    let (s, t) = (cut(excess.y), cut(excess.z));
    s * t * Vec3::new(1.0 - THIRD * (s + t), THIRD * s, THIRD * t)
}

/// The cells' parts of a triangle whose corners all have different labels, as [`tip`] has them. Given are the squared
/// distances of the corners from the first corner's site, the second's and the third's.
#[inline]
fn shares(squares: [Vec3; 3]) -> [Vec3; 3] {
    shares_around_junction(squares).unwrap_or_else(|| {
        [[0, 1, 2], [1, 2, 0], [2, 0, 1]].map(|[own, next, last]| {
            let excess = |other: usize| squares[own] - squares[other];
            Polygon::TRIANGLE.clipped(excess(next)).clipped(excess(last)).moment()
        })
    })
}

/// [`shares`] where every corner is in its own cell and all three cells meet inside: each has a quadrangle.
#[inline]
fn shares_around_junction([f, g, h]: [Vec3; 3]) -> Option<[Vec3; 3]> {
    let (fg, gh, hf) = (f - g, g - h, h - f);
    let own = fg.x.max(gh.y).max(hf.z) < 0.0 && hf.x.min(fg.y).min(gh.z) > 0.0;
    let meeting = fg.cross(gh);
    let meeting = meeting / meeting.element_sum();
    if !(own && meeting.min_element() >= 0.0) {
        return None;
    }
    // How far it is from each corner to the border with the next one.
    let (s, t, u) = (fg.x / (fg.x - fg.y), gh.y / (gh.y - gh.z), hf.z / (hf.z - hf.x));
    // The quadrangle of a corner, the border towards the next corner, the meeting point and the border towards the last.
    let quadrangle = |to_next: f32, to_last: f32, next: f32, last: f32| {
        let (one, two) = (to_next * last, to_last * next);
        let y = THIRD * (one * (to_next + next) + two * next);
        let z = THIRD * (one * last + two * (to_last + last));
        (one + two - y - z, y, z)
    };
    let Vec3 { x, y, z } = meeting;
    let (aa, ab, ac) = quadrangle(s, 1.0 - u, y, z);
    let (bb, bc, ba) = quadrangle(t, 1.0 - s, z, x);
    let (cc, ca, cb) = quadrangle(u, 1.0 - t, x, y);
    Some([Vec3::new(aa, ab, ac), Vec3::new(ba, bb, bc), Vec3::new(ca, cb, cc)])
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
    #[inline]
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

    #[inline]
    fn push(&mut self, corner: Vec3) {
        if self.len < self.corners.len() {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    /// The part of the triangle's area, times the weights of the triangle's corners at the centroid.
    #[inline]
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
