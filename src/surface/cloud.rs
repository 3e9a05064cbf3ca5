//! Point clouds: surfaces that are known by points only.
//!
//! In: points, with normals or without. Out: a [`SurfaceGraph`] whose edges lead to the nearest points, and a disc per
//! point that is drawn in place of triangles.
//!
//! Two points are neighbours where one is among the k nearest of the other and their normals do not part by more than
//! 78°: so the two sides of a thin sheet are not joined. Colours, levels and waves are those of any graph.

use super::{
    adjacency::Adjacency,
    coloring::SolverOrder,
    graph::{NO_TRIANGLE, SurfaceGraph},
    levels::coarsen,
    nearest::KdTree,
    order::{inverse, morton_order},
    planes,
    soup::check_finite,
    weld::{WeldOptions, weld},
};
use crate::{error::PatternError, parallel};
use bevy::prelude::*;
use std::f32::consts::TAU;

/// How points become a surface.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default)]
pub struct CloudOptions {
    /// Neighbours k that each point asks for, 3..=32; those that ask for it are its neighbours as well. Default 8; more
    /// bring more colours, not better waves. A value outside counts as the nearest one inside.
    pub neighbors: u32,
    /// Half the side of the square that is drawn for a point, over the mean distance of its neighbours' square packing;
    /// above 0. Default 0.85: squares of an even cloud overlap so that none sees between them. Anything else counts as
    /// the default.
    pub disc: f32,
}

impl Default for CloudOptions {
    fn default() -> Self {
        Self {
            neighbors: 8,
            disc: 0.85,
        }
    }
}

/// Points whose normals have no more than this as their product are not neighbours.
const SAME_SIDE: f32 = 0.2;

impl SurfaceGraph {
    /// The graph of a point cloud. `normals`, one per point and of any length, may be missing: they are those of planes
    /// fitted to the neighbours then, on the outer side of each connected part. Points at the same place are one.
    ///
    /// [`triangles`](Self::triangles) has two entries per point, which name nothing but its vertex: those of the square
    /// that is drawn for it, along [`discs`](Self::discs).
    ///
    /// # Errors
    /// [`NotFinite`](PatternError::NotFinite), [`WrongLength`](PatternError::WrongLength) of normals, and
    /// [`TooFewPoints`](PatternError::TooFewPoints) where fewer than three are left after welding.
    pub fn from_points(
        points: &[Vec3],
        normals: Option<&[Vec3]>,
        welding: &WeldOptions,
        options: &CloudOptions,
    ) -> Result<Self, PatternError> {
        check_finite(points)?;
        check_normals(normals, points.len())?;
        let weld = weld(points, welding);
        let welded: Vec<Vec3> = weld.first.iter().map(|&v| points[v as usize]).collect();
        if welded.len() < 3 {
            return Err(PatternError::TooFewPoints(welded.len()));
        }
        let k = options.neighbors.clamp(3, 32) as usize;
        let nearest = KdTree::new(&welded).nearest_of_all(k);
        let pairs = || {
            (0..)
                .zip(&nearest)
                .flat_map(|(i, others)| others.iter().map(move |&j| [i, j]))
        };
        let near = Adjacency::from_pairs(pairs(), welded.len());
        let normals = match normals {
            Some(given) => mean_normals(given, &weld.vertex_of, &planes::normals(&welded, &near)),
            None => planes::normals(&welded, &near),
        };
        let side = if options.disc.is_finite() && options.disc > 0.0 {
            options.disc
        } else {
            CloudOptions::default().disc
        };
        let areas: Vec<f32> = (0..welded.len())
            .map(|i| area(welded[i], near.of(i as u32).iter().map(|&j| welded[j as usize])))
            .collect();
        let same_side = |&[i, j]: &[u32; 2]| normals[i as usize].dot(normals[j as usize]) > SAME_SIDE;
        let adjacency = Adjacency::from_pairs(pairs().filter(same_side), welded.len());
        let SolverOrder { order, classes } = SolverOrder::new(&adjacency, &morton_order(&welded));
        let finest = adjacency.into_level(&order, classes);

        let rank = inverse(&order);
        let in_order = |values: &[Vec3]| order.iter().map(|&v| values[v as usize]).collect::<Vec<_>>();
        let positions = in_order(&welded);
        let normals = in_order(&normals);
        let areas: Vec<f32> = order.iter().map(|&v| areas[v as usize]).collect();
        let vertex_of: Vec<u32> = weld.vertex_of.iter().map(|&v| rank[v as usize]).collect();
        let levels = coarsen(finest, &positions, &areas);
        let discs = normals
            .iter()
            .zip(&areas)
            .map(|(&n, &area)| disc(n, side * area.sqrt()))
            .collect();
        Ok(Self {
            positions,
            normals,
            areas,
            triangles: vertex_of.iter().flat_map(|&v| [[v; 3]; 2]).collect(),
            triangles_across: vec![[NO_TRIANGLE; 3]; 2 * vertex_of.len()],
            vertex_of,
            levels,
            discs,
        })
    }

    /// Whether this is the graph of a point cloud.
    pub fn is_cloud(&self) -> bool {
        !self.discs.is_empty()
    }

    /// The corners of the square that is drawn for vertex `v` of a point cloud, counter-clockwise; its triangles are
    /// corners 0, 1, 2 and 0, 2, 3.
    pub fn disc_corners(&self, v: usize) -> [Vec3; 4] {
        let [x, y] = self.discs[v];
        [-x - y, x - y, x + y, y - x].map(|offset| self.positions[v] + offset)
    }

    /// Takes new positions of the points of a cloud, as [`update_positions`](Self::update_positions) does, and new normals
    /// where these are given. Without, they are fitted anew, each on the side where it was.
    ///
    /// # Errors
    /// [`WrongLength`](PatternError::WrongLength) and [`NotFinite`](PatternError::NotFinite); the graph is unchanged then.
    pub fn update_points(&mut self, points: &[Vec3], normals: Option<&[Vec3]>) -> Result<(), PatternError> {
        check_normals(normals, self.vertex_of.len())?;
        self.update_positions(points)?;
        if let Some(given) = normals.filter(|_| self.is_cloud()) {
            let normals = mean_normals(given, &self.vertex_of, &self.normals);
            self.set_normals(normals);
        }
        Ok(())
    }

    /// Normals, areas and discs of points that have moved. The neighbours stay.
    pub(super) fn fit_points(&mut self) {
        let level = self.mesh_level();
        let around = |i: usize| level.edges(i).map(|k| self.positions[level.neighbors[k] as usize]);
        let normal = |i: usize| {
            let n = planes::plane(self.positions[i], around(i));
            if n.dot(self.normals[i]) < 0.0 { -n } else { n }
        };
        let normals = parallel::collect(self.len(), normal);
        let area = |i: usize| match level.edges(i).is_empty() {
            true => self.areas[i],
            false => area(self.positions[i], around(i)),
        };
        let areas = parallel::collect(self.len(), area);
        for ((axes, new), old) in self.discs.iter_mut().zip(&areas).zip(&self.areas) {
            axes[0] *= (new / old.max(f32::MIN_POSITIVE)).sqrt();
        }
        self.areas = areas;
        self.set_normals(normals);
    }

    /// Discs lie across the normals; their size stays.
    fn set_normals(&mut self, normals: Vec<Vec3>) {
        for (axes, &n) in self.discs.iter_mut().zip(&normals) {
            *axes = disc(n, axes[0].length());
        }
        self.normals = normals;
    }
}

/// Refuses normals that are not one finite vector per point.
fn check_normals(normals: Option<&[Vec3]>, points: usize) -> Result<(), PatternError> {
    let Some(normals) = normals else { return Ok(()) };
    if normals.len() != points {
        return Err(PatternError::WrongLength {
            what: "normals",
            found: normals.len(),
            expected: points,
        });
    }
    match normals.iter().position(|n| !n.is_finite()) {
        Some(index) => Err(PatternError::NotFinite {
            what: "normal of vertex",
            index,
        }),
        None => Ok(()),
    }
}

/// The mean of the normals of a vertex's points, or the fitted one where it vanishes.
fn mean_normals(given: &[Vec3], vertex_of: &[u32], fitted: &[Vec3]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; fitted.len()];
    for (&n, &v) in given.iter().zip(vertex_of) {
        sums[v as usize] += n.as_dvec3().normalize_or_zero().as_vec3();
    }
    sums.iter()
        .zip(fitted)
        .map(|(sum, &fitted)| sum.try_normalize().unwrap_or(fitted))
        .collect()
}

/// The area of a point: a disc with m points evenly spread in it, besides the one in its middle, has a mean squared
/// distance of half its squared radius.
fn area(point: Vec3, around: impl Iterator<Item = Vec3>) -> f32 {
    let (sum, count) = around.fold((0.0, 0.0_f64), |(sum, count), p| {
        (sum + p.as_dvec3().distance_squared(point.as_dvec3()), count + 1.0)
    });
    (f64::from(TAU) * sum / (count * (count + 0.5)).max(1.0)).min(f64::from(f32::MAX)) as f32
}

/// The half axes of a square across a normal.
fn disc(normal: Vec3, half: f32) -> [Vec3; 2] {
    let x = normal.any_orthonormal_vector() * half;
    [x, normal.cross(x)]
}
