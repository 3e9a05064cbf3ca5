//! The part of the plane that is sampled.
//!
//! In: a rectangle, or a polygon with holes. Out: its [`Ground`]: a constrained Delaunay triangulation of its corners, and
//! its border as loops of corners, the domain to their left.

use super::{
    boundary::Rail,
    metric::{ScaledMetric, det, dot},
};
use crate::error::PatternError;
use bevy::{
    math::{DVec2, UVec2},
    prelude::Component,
};
use glam_matrix_extras::SymmetricDMat2;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};
use std::ops::Range;

/// The part of the plane that is sampled. Its corners are samples wherever the count allows.
///
/// As a component it says that the entity's [`AnisotropicSamples`](crate::sampling::AnisotropicSamples) lie in the plane.
#[derive(Component, Debug, Clone, PartialEq)]
pub enum PlanarDomain {
    /// All points between two corners.
    Rectangle {
        /// The corner with the smallest coordinates.
        min: DVec2,
        /// The corner with the largest coordinates; above `min` in both.
        max: DVec2,
    },
    /// A simple polygon with holes; clockwise or not. No two of its edges may cross or touch, but for neighbours.
    Polygon {
        /// The corners of the outer border, 3 or more.
        outline: Vec<DVec2>,
        /// The corners of each hole, 3 or more, inside the outline and outside of each other.
        holes: Vec<Vec<DVec2>>,
    },
}

/// A domain that has been checked and triangulated.
pub(super) struct Ground {
    /// Corners, loop by loop.
    pub(super) points: Vec<DVec2>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The corners of each loop. The border from corner i to the next of its loop is rail i.
    pub(super) loops: Vec<Range<u32>>,
}

impl Default for PlanarDomain {
    fn default() -> Self {
        Self::Rectangle {
            min: DVec2::ZERO,
            max: DVec2::ONE,
        }
    }
}

impl PlanarDomain {
    /// An image as a domain: a rectangle in pixels, pixel (i, j) from (i, j) to (i + 1, j + 1).
    pub fn image(size: UVec2) -> Self {
        Self::Rectangle {
            min: DVec2::ZERO,
            max: size.as_dvec2(),
        }
    }

    /// The smallest and the largest coordinates of all points.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        match self {
            &Self::Rectangle { min, max } => (min, max),
            Self::Polygon { outline, .. } => outline
                .iter()
                .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), &p| {
                    (min.min(p), max.max(p))
                }),
        }
    }

    /// Whether a point lies in the domain. (On a polygon's border either answer is possible.)
    pub fn contains(&self, p: DVec2) -> bool {
        match self {
            &Self::Rectangle { min, max } => p.cmpge(min).all() && p.cmple(max).all(),
            Self::Polygon { .. } => self.crossings(p.y).filter(|&x| x > p.x).count() % 2 == 1,
        }
    }

    /// Where the horizontal line at `y` crosses the border.
    fn crossings(&self, y: f64) -> impl Iterator<Item = f64> + '_ {
        self.loops().flat_map(move |corners| {
            edges(corners)
                .filter(move |[a, b]| (a.y > y) != (b.y > y))
                .map(move |[a, b]| a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)))
        })
    }

    /// The parts of the horizontal line at `y` that lie in the domain, as pairs of x, ascending.
    pub(super) fn spans(&self, y: f64) -> Vec<[f64; 2]> {
        match self {
            Self::Rectangle { min, max } => vec![[min.x, max.x]],
            Self::Polygon { .. } => {
                let mut xs: Vec<f64> = self.crossings(y).collect();
                xs.sort_by(f64::total_cmp);
                xs.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
            }
        }
    }

    /// The squared distance in the metric `m` from `p` to the nearest point of the border.
    pub(super) fn border_distance_squared(&self, p: DVec2, m: &SymmetricDMat2) -> f64 {
        let (min, max) = self.bounds();
        let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
        let to_edge = |[a, b]: [DVec2; 2]| {
            let edge = b - a;
            let s = (dot(m, edge, p - a) / dot(m, edge, edge)).clamp(0.0, 1.0);
            let r = a + s * edge - p;
            dot(m, r, r)
        };
        match self {
            Self::Rectangle { .. } => edges(&corners).map(to_edge).fold(f64::INFINITY, f64::min),
            Self::Polygon { .. } => self.loops().flat_map(edges).map(to_edge).fold(f64::INFINITY, f64::min),
        }
    }

    fn loops(&self) -> impl Iterator<Item = &[DVec2]> {
        let (outline, holes): (&[DVec2], &[Vec<DVec2>]) = match self {
            Self::Rectangle { .. } => (&[], &[]),
            Self::Polygon { outline, holes } => (outline, holes),
        };
        std::iter::once(outline).chain(holes.iter().map(Vec::as_slice))
    }

    /// Checks the domain and triangulates it.
    pub(super) fn ground(&self) -> Result<Ground, PatternError> {
        let (min, max) = self.bounds();
        // Infinite where two points are NaN or their distance overflows.
        if !(max - min).is_finite() || self.loops().flatten().any(|p| !p.is_finite()) {
            return Err(PatternError::Domain("its points must be finite"));
        }
        if !min.cmplt(max).all() {
            return Err(PatternError::Domain("it has no area"));
        }
        match self {
            Self::Rectangle { .. } => Ok(Ground {
                points: vec![min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                loops: std::iter::once(0..4).collect(),
            }),
            Self::Polygon { outline, holes } => Ground::polygon(outline, holes, min, (max - min).max_element()),
        }
    }
}

impl Ground {
    fn polygon(outline: &[DVec2], holes: &[Vec<DVec2>], min: DVec2, extent: f64) -> Result<Self, PatternError> {
        let mut ground = Self {
            points: Vec::new(),
            triangles: Vec::new(),
            loops: Vec::new(),
        };
        let border = Self::check_loop(outline, extent)?;
        ground.add_loop(outline, border < 0.0);
        for hole in holes {
            let area = Self::check_loop(hole, extent)?;
            if !edges(outline).fold(false, |inside, edge| inside != is_left_crossing(hole[0], edge)) {
                return Err(PatternError::Domain("a hole lies outside of the outline"));
            }
            ground.add_loop(hole, area > 0.0);
        }
        let cdt = ground.constrained_delaunay(min, extent)?;
        ground.triangles = inner_triangles(&cdt)?;
        Ok(ground)
    }

    /// The signed area of a loop.
    fn check_loop(corners: &[DVec2], extent: f64) -> Result<f64, PatternError> {
        if corners.len() < 3 {
            return Err(PatternError::Domain("a border needs 3 points or more"));
        }
        let area = edges(corners)
            .map(|[a, b]| (a - corners[0]).perp_dot(b - corners[0]) / 2.0)
            .sum::<f64>();
        if area.abs() > 1e-12 * extent * extent {
            Ok(area)
        } else {
            Err(PatternError::Domain("a border encloses no area"))
        }
    }

    fn add_loop(&mut self, corners: &[DVec2], reversed: bool) {
        let first = self.points.len();
        self.points.extend(corners);
        if reversed {
            self.points[first..].reverse();
        }
        self.loops.push(first as u32..self.points.len() as u32);
    }

    /// The first and the last corner of each rail, as indices.
    fn sides(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.loops.iter().flat_map(|corners| {
            corners
                .clone()
                .map(|i| [i, if i + 1 == corners.end { corners.start } else { i + 1 }])
        })
    }

    /// First and last point of each rail.
    pub(super) fn rails(&self) -> Vec<Rail> {
        let rail = |corners: &Range<u32>, i: u32| {
            let count = corners.end - corners.start;
            let at = |k: u32| self.points[(corners.start + (i + k) % count) as usize];
            Rail {
                before: at(count - 1),
                start: at(0),
                end: at(1),
                after: at(2),
            }
        };
        let of_loop = |corners: &Range<u32>| (0..corners.len() as u32).map(|i| rail(corners, i)).collect::<Vec<_>>();
        self.loops.iter().flat_map(of_loop).collect()
    }

    fn constrained_delaunay(&self, min: DVec2, extent: f64) -> Result<Cdt, PatternError> {
        const CROSSING: PatternError = PatternError::Domain("its border crosses or touches itself");
        let mut cdt = Cdt::new();
        let mut handles = Vec::with_capacity(self.points.len());
        for (&p, i) in self.points.iter().zip(0..) {
            // Numbers that the library takes: neither huge nor tiny.
            let unit = ((p - min) / extent).map(|x| if x < 1e-30 { 0.0 } else { x });
            let corner = Corner(Point2::new(unit.x, unit.y), i);
            let handle = cdt
                .insert(corner)
                .map_err(|_| PatternError::Domain("its points must be finite"))?;
            handles.push(handle);
        }
        if cdt.num_vertices() != self.points.len() {
            return Err(CROSSING);
        }
        for [a, b] in self.sides().map(|ends| ends.map(|v| handles[v as usize])) {
            if !cdt.can_add_constraint(a, b) {
                return Err(CROSSING);
            }
            cdt.add_constraint(a, b);
            if !cdt.exists_constraint(a, b) {
                return Err(CROSSING);
            }
        }
        Ok(cdt)
    }

    /// The integral of √det M over the domain, by about `points` look-ups.
    pub(super) fn metric_area(&self, metric: &ScaledMetric, points: f64) -> Result<f64, PatternError> {
        let corners = |t: &[u32; 3]| t.map(|v| self.points[v as usize]);
        let area = |[a, b, c]: [DVec2; 3]| (b - a).perp_dot(c - a) / 2.0;
        let total: f64 = self.triangles.iter().map(|t| area(corners(t))).sum();
        let mut sum = 0.0;
        let mut index = 0;
        for [a, b, c] in self.triangles.iter().map(corners) {
            // A triangle is cut into n² equal ones, those in the middle of a row upside down by turns.
            let n = (points * area([a, b, c]) / total).sqrt().ceil().max(1.0) as u32;
            let (e, g) = ((b - a) / f64::from(n), (c - a) / f64::from(n));
            let mut densities = 0.0;
            for j in 0..n {
                for i in 0..2 * (n - j) - 1 {
                    let third = f64::from(1 + i % 2) / 3.0;
                    let p = a + (f64::from(i / 2) + third) * e + (f64::from(j) + third) * g;
                    densities += det(&metric.at(p, index)?).sqrt();
                    index += 1;
                }
            }
            sum += densities * area([a, b, c]) / f64::from(n * n);
        }
        if sum.is_finite() && sum > 0.0 {
            Ok(sum)
        } else {
            Err(PatternError::Domain("its metric area is not a positive number"))
        }
    }
}

/// A corner that knows its index.
#[derive(Clone, Copy)]
struct Corner(Point2<f64>, u32);

impl spade::HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.0
    }
}

type Cdt = ConstrainedDelaunayTriangulation<Corner>;

/// The triangles behind one border, seen from outside; those behind two are holes.
fn inner_triangles(cdt: &Cdt) -> Result<Vec<[u32; 3]>, PatternError> {
    const UNKNOWN: u32 = u32::MAX;
    let mut beyond = vec![Vec::new(); cdt.num_all_faces()];
    for edge in cdt.directed_edges() {
        beyond[edge.face().index()].push((edge.rev().face().index(), edge.is_constraint_edge()));
    }
    let mut depth = vec![UNKNOWN; beyond.len()];
    let (mut layer, mut level) = (vec![cdt.outer_face().index()], 0);
    while !layer.is_empty() {
        let mut deeper = Vec::new();
        while let Some(face) = layer.pop() {
            if depth[face] != UNKNOWN {
                continue;
            }
            depth[face] = level;
            for &(other, is_border) in &beyond[face] {
                let list = if is_border { &mut deeper } else { &mut layer };
                list.push(other);
            }
        }
        (layer, level) = (deeper, level + 1);
    }
    if depth.iter().any(|&d| d > 2) {
        return Err(PatternError::Domain("a hole lies in another hole"));
    }
    let inner = cdt.inner_faces().filter(|face| depth[face.index()] == 1);
    Ok(inner
        .map(|face| face.vertices().map(|vertex| vertex.data().1))
        .collect())
}

/// The edges of a closed loop.
fn edges(corners: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    let ends = corners.iter().cycle().skip(1);
    corners.iter().zip(ends).map(|(&a, &b)| [a, b])
}

/// Whether the ray from `p` to +x crosses an edge.
fn is_left_crossing(p: DVec2, [a, b]: [DVec2; 2]) -> bool {
    (a.y > p.y) != (b.y > p.y) && a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y)) > p.x
}
