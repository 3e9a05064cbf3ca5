//! Metrics that are given at the nodes of a grid, made by the crate's own builders.

use super::metrics::{RATIO, in_space};
use bevy::{math::DVec2, mesh::PrimitiveTopology, prelude::*};
use bevy_field_patterns::{
    error::PatternError,
    sampling::{
        Metric, MetricSource,
        metric::{MetricVolume, Slice, Structure, metric_of_pixels, planar_ellipse},
        planar::MetricGrid,
        surface_metric,
    },
    surface::{SurfaceGraph, WeldOptions},
};
use glam_matrix_extras::{SymmetricDMat3, SymmetricMat2};

/// Metrics that are given at the nodes of a grid, in a rectangle.
#[derive(Debug, Clone, Copy)]
pub enum Grid {
    /// An image of rings around the lower left corner.
    Image,
    /// A slice through a volume of spherical shells.
    Volume,
    /// Vectors at the vertices of a flat mesh: a flow between two walls, fastest in the middle.
    Vectors,
    /// Metrics at the vertices of a flat mesh: three, each the strongest at its own corner.
    Vertices,
}

/// Ratio of the longest vectors, where none is given.
const VECTOR_RATIO: f32 = 5.0;
/// Nodes of a grid along each side.
const SIDE: u32 = 96;

impl Grid {
    /// The metric on a grid over the rectangle from the origin to `sides`.
    pub fn bake(self, ratio: Option<f32>, sides: DVec2) -> Result<MetricGrid, PatternError> {
        let structure = Structure {
            ratio: ratio.unwrap_or(RATIO),
            ..default()
        };
        let wave = |r: f32| 0.5 + 0.5 * (12.0 * r).sin();
        let at = |i: u32| i as f32 / (SIDE - 1) as f32;
        let bounds = (DVec2::ZERO, sides);
        match self {
            Self::Image => {
                let pixels: Vec<Vec3> = (0..SIDE * SIDE)
                    .map(|k| Vec3::splat(wave(Vec2::new(at(k % SIDE), at(k / SIDE)).length())))
                    .collect();
                let metrics = metric_of_pixels(&pixels, UVec2::splat(SIDE), &structure);
                MetricGrid::new(
                    bounds,
                    UVec2::splat(SIDE),
                    metrics.iter().map(|m| m.as_symmetric_mat2()).collect(),
                )
            }
            Self::Volume => {
                const DEPTH: u32 = 40;
                let node = |i: u32| i as f32 / (DEPTH - 1) as f32;
                let voxels: Vec<f32> = (0..DEPTH.pow(3))
                    .map(|k| {
                        let p = Vec3::new(node(k % DEPTH), node(k / DEPTH % DEPTH), node(k / DEPTH.pow(2)));
                        wave((p - 0.5).length())
                    })
                    .collect();
                let volume =
                    MetricVolume::from_scalars(Vec3::ZERO, Vec3::ONE, UVec3::splat(DEPTH), &voxels, &structure)?;
                let slice = Slice {
                    origin: Vec3::new(0.0, 0.0, 0.3),
                    u: Dir3::X,
                    v: Dir3::Y,
                };
                MetricGrid::bake(bounds, UVec2::splat(SIDE), &|p: DVec2| {
                    volume.on_slice(&slice, p / sides)
                })
            }
            Self::Vectors => on_flat_mesh(sides, |points| {
                // Faster towards the middle, up and down as it goes.
                let flow = |p: Vec2| Vec3::new(1.0, 0.6 * (6.0 * p.x).cos(), 0.0) * 4.0 * p.y * (1.0 - p.y);
                MetricSource::Vectors {
                    vectors: points.iter().map(|&p| flow(p)).collect(),
                    ratio: ratio.unwrap_or(VECTOR_RATIO),
                    full_length: 1.0,
                }
            }),
            Self::Vertices => on_flat_mesh(sides, |points| {
                let corners = [
                    (Vec2::ZERO, 0.9, 2.0, 0.7),
                    (Vec2::X, 2.3, 1.6, 0.4),
                    (Vec2::Y, 0.0, 0.5, 0.5),
                ];
                let blend = |p: Vec2| {
                    let weights = corners.map(|corner| f64::from((-6.0 * p.distance_squared(corner.0)).exp()));
                    let whole: f64 = weights.iter().sum();
                    let parts = corners.iter().zip(weights).map(|(&(_, angle, long, short), weight)| {
                        in_space(&planar_ellipse(angle, long, short)) * (weight / whole)
                    });
                    let blended = parts.fold(SymmetricDMat3::ZERO, |sum, part| sum + part);
                    blended.as_symmetric_mat3()
                };
                MetricSource::Vertices(points.iter().map(|&p| blend(p)).collect())
            }),
        }
    }
}

/// The metric at the vertices of a flat mesh over the rectangle, of what `source` makes of their places in the unit square.
fn on_flat_mesh(sides: DVec2, source: impl Fn(&[Vec2]) -> MetricSource) -> Result<MetricGrid, PatternError> {
    let points: Vec<Vec2> = (0..SIDE * SIDE)
        .map(|k| UVec2::new(k % SIDE, k / SIDE).as_vec2() / (SIDE - 1) as f32)
        .collect();
    let positions: Vec<Vec3> = points.iter().map(|&p| (p * sides.as_vec2()).extend(0.0)).collect();
    let squares = (0..SIDE * (SIDE - 1)).filter(|k| k % SIDE < SIDE - 1);
    let triangles: Vec<[u32; 3]> = squares
        .flat_map(|k| [[k, k + 1, k + SIDE + 1], [k, k + SIDE + 1, k + SIDE]])
        .collect();
    let graph = SurfaceGraph::from_triangles(&positions, &triangles, &WeldOptions::default())?;
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, default());
    let metrics = surface_metric(&Metric::new(source(&points)), &graph, &mesh)?;
    let plane = |v: &u32| {
        let m = &metrics[*v as usize];
        SymmetricMat2::new(m.m00, m.m01, m.m11)
    };
    MetricGrid::new(
        (DVec2::ZERO, sides),
        UVec2::splat(SIDE),
        graph.vertex_of.iter().map(plane).collect(),
    )
}
