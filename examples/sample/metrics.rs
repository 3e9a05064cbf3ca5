//! The metrics that the command line knows by name.

use bevy::{
    math::{DVec2, Vec3},
    prelude::*,
};
use bevy_field_patterns::{
    field::{DirectionField, Principal},
    sampling::{
        Metric, MetricSource, SpaceFunction,
        metric::{EigenvalueMapping, planar_ellipse},
        planar::PlanarMetric,
    },
};
use glam_matrix_extras::{SymmetricDMat2, SymmetricDMat3, SymmetricMat3};
use std::{
    f64::consts::{FRAC_PI_2, TAU},
    path::PathBuf,
    sync::Arc,
};

use super::grids::Grid;
use crate::common::mesh_file::{RawMesh, read_rows};

#[derive(Clone)]
pub enum MetricArg {
    Isotropic,
    Axis(Dir3),
    Curvature,
    Planar(Planar),
    Grid(Grid),
    File(PathBuf),
}

/// A metric that is given by a formula over the unit square; on a mesh, over the x and y extent of its bounding box.
#[derive(Debug, Clone, Copy)]
pub enum Planar {
    /// Long axes around the centre, where samples are round.
    Vortex,
    /// Long axes whose angle goes up and down.
    Wavy,
    /// Circles that grow from 1 to 8 from left to right.
    Graded,
    /// The stress under a load at the middle of the upper side: tensors, whose eigenvalues become lengths.
    Stress,
}

pub fn parse(text: &str) -> Result<MetricArg, String> {
    if let Some(path) = text.strip_prefix("file:") {
        return Ok(MetricArg::File(path.into()));
    }
    if let Some(axis) = text.strip_prefix("axis:") {
        let numbers: Result<Vec<f32>, _> = axis.split(',').map(|number| number.trim().parse::<f32>()).collect();
        return match numbers.as_deref() {
            Ok(&[x, y, z]) => Dir3::from_xyz(x, y, z).map(MetricArg::Axis).ok(),
            _ => None,
        }
        .ok_or_else(|| "an axis is three finite numbers X,Y,Z, not all 0".into());
    }
    Ok(match text {
        "iso" => MetricArg::Isotropic,
        "curvature" => MetricArg::Curvature,
        "vortex" => MetricArg::Planar(Planar::Vortex),
        "wavy" => MetricArg::Planar(Planar::Wavy),
        "graded" => MetricArg::Planar(Planar::Graded),
        "stress" => MetricArg::Planar(Planar::Stress),
        "image" => MetricArg::Grid(Grid::Image),
        "volume" => MetricArg::Grid(Grid::Volume),
        "vectors" => MetricArg::Grid(Grid::Vectors),
        "vertices" => MetricArg::Grid(Grid::Vertices),
        _ => {
            return Err(
                "expected iso, axis:X,Y,Z, curvature, vortex, wavy, graded, stress, image, volume, vectors, vertices or file:PATH".into(),
            );
        }
    })
}

/// Ratio along an axis or a curvature, where none is given.
pub const RATIO: f32 = 4.0;
/// Ratio of a vortex and of waves, where none is given.
const PLANAR_RATIO: f32 = 10.0;

impl Planar {
    /// The metric at a point of the unit square; lengths are those of the square.
    fn at(self, p: DVec2, ratio: f64) -> SymmetricDMat2 {
        match self {
            Self::Vortex => {
                let r = p - DVec2::splat(0.5);
                let ratio = 1.0 + (ratio - 1.0) * (1.0 - (-r.length_squared() / 0.06).exp());
                planar_ellipse(r.to_angle() + FRAC_PI_2, ratio.sqrt(), ratio.sqrt().recip())
            }
            Self::Wavy => {
                let angle = 0.6 * (TAU * p.x).sin() + 0.6 * (TAU * p.y).cos();
                planar_ellipse(angle, ratio.sqrt(), ratio.sqrt().recip())
            }
            Self::Graded => {
                let size = 0.25 + 1.75 * p.x.clamp(0.0, 1.0);
                planar_ellipse(0.0, size, size)
            }
            Self::Stress => {
                // The load stands a little above, where stress is finite.
                let r = p - DVec2::new(0.5, 1.1);
                let mapping = EigenvalueMapping {
                    range: Vec2::new(0.0, 3.0),
                    lengths: Vec2::new(0.3, 1.0),
                    max_ratio: ratio as f32,
                };
                mapping.planar_metric(&(SymmetricDMat2::from_outer_product(r) * (-r.y / r.length_squared().powi(2))))
            }
        }
    }
}

/// The metric of the rectangle from the origin to `sides`.
pub fn in_rectangle(
    metric: &MetricArg,
    ratio: Option<f32>,
    sides: DVec2,
) -> Result<Box<dyn Fn(DVec2) -> SymmetricDMat2 + Send + Sync>, String> {
    let along = f64::from(ratio.unwrap_or(RATIO));
    let formula = f64::from(ratio.unwrap_or(PLANAR_RATIO));
    Ok(match *metric {
        MetricArg::Isotropic => Box::new(|_| SymmetricDMat2::IDENTITY),
        MetricArg::Axis(axis) if axis.xy().length() < 1e-6 => {
            return Err("--metric axis: the axis stands on the rectangle, give it x or y".into());
        }
        MetricArg::Axis(axis) => {
            let m = planar_ellipse(f64::from(axis.xy().to_angle()), along.sqrt(), along.sqrt().recip());
            Box::new(move |_| m)
        }
        MetricArg::Planar(planar) => Box::new(move |p| planar.at(p / sides, formula)),
        MetricArg::Grid(grid) => {
            let grid = grid.bake(ratio, sides).map_err(|error| error.to_string())?;
            Box::new(move |p| grid.at(p))
        }
        MetricArg::Curvature => return Err("--metric curvature: a rectangle has none".into()),
        MetricArg::File(_) => return Err("--metric file: has one line per vertex of a mesh, not of a rectangle".into()),
    })
}

/// The metric of a mesh.
pub fn on_mesh(
    metric: &MetricArg,
    ratio: Option<f32>,
    smoothing: Option<u32>,
    mesh: &RawMesh,
) -> Result<Metric, String> {
    let along = ratio.unwrap_or(RATIO);
    let formula = f64::from(ratio.unwrap_or(PLANAR_RATIO));
    let mut result = match metric {
        MetricArg::Isotropic => Metric::default(),
        MetricArg::Axis(axis) => Metric::along(DirectionField::Axis(*axis), along),
        MetricArg::Curvature => Metric::along(
            DirectionField::PrincipalCurvature {
                direction: Principal::Minor,
                smoothing: 30,
            },
            along,
        ),
        MetricArg::Planar(planar) => {
            let (planar, bounds) = (*planar, bounds(&mesh.positions));
            Metric::new(MetricSource::Function(SpaceFunction::new(move |p| {
                let unit =
                    (p - bounds.0).xy().as_dvec2() / (bounds.1 - bounds.0).xy().as_dvec2().max(DVec2::splat(1e-30));
                in_space(&planar.at(unit, formula)).as_symmetric_mat3()
            })))
        }
        MetricArg::Grid(_) => return Err("--metric image, volume, vectors, vertices: these are for a rectangle".into()),
        MetricArg::File(path) => {
            let rows = read_rows::<6>(path, mesh.positions.len()).map_err(|error| error.to_string())?;
            let matrices: Arc<[SymmetricMat3]> = rows
                .iter()
                .map(|&[xx, yy, zz, xy, xz, yz]| SymmetricMat3::new(xx, xy, xz, yy, yz, zz))
                .collect();
            Metric {
                smoothing: 0,
                ..Metric::new(MetricSource::Vertices(matrices))
            }
        }
    };
    if let Some(smoothing) = smoothing {
        result.smoothing = smoothing;
    }
    Ok(result)
}

/// A metric of the plane, in space: along z as the geometric mean.
pub fn in_space(m: &SymmetricDMat2) -> SymmetricDMat3 {
    SymmetricDMat3::new(m.m00, m.m01, 0.0, m.m11, 0.0, m.determinant().sqrt())
}

fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    points
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), &p| {
            (min.min(p), max.max(p))
        })
}
