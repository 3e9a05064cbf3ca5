//! What samples follow, as a user says it.
//!
//! In: a [`Metric`] and what it names: attributes of a mesh, an image, closures. Out: the metric of every vertex of a
//! surface, or of every point of a plane.

use super::metric::{EigenvalueMapping, Structure, check_metrics, ellipse, metric_of_scalars, on_surface, smooth};
use crate::{
    error::PatternError,
    field::{
        Alignment, DirectionField, Painted, Symmetry, any_tangent, attribute_scalars, directions, project_tangent,
        weld_scalars,
    },
    surface::SurfaceGraph,
};
use bevy::{mesh::MeshVertexAttribute, prelude::*};
use glam_matrix_extras::SymmetricMat3;
use std::{fmt, sync::Arc};

/// A function of a point of space: of the mesh's space on a surface, of (x, y, 0) in a plane.
#[derive(Clone)]
pub struct SpaceFunction<T>(Arc<dyn Fn(Vec3) -> T + Send + Sync>);

impl<T> SpaceFunction<T> {
    /// Takes a closure.
    pub fn new(function: impl Fn(Vec3) -> T + Send + Sync + 'static) -> Self {
        Self(Arc::new(function))
    }

    /// The value at a point.
    pub fn at(&self, point: Vec3) -> T {
        (self.0)(point)
    }
}

impl<T> fmt::Debug for SpaceFunction<T> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("SpaceFunction")
    }
}

/// The shape of samples: where the long axis lies, and how much longer it is.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub enum MetricSource {
    /// Circles.
    ///
    #[doc = include_str!("../../docs/images/metric_isotropic.svg")]
    #[default]
    Isotropic,
    /// Ellipses with their long axis along a field. On surfaces; vortices, snapshots and buffers are fields of waves only.
    ///
    #[doc = include_str!("../../docs/images/metric_field.svg")]
    Field {
        /// The field.
        field: DirectionField,
        /// Angle from the field to the long axis, in radians.
        turn: f32,
        /// Long axis over short axis, 1..=[`MAX_RATIO`](Metric::MAX_RATIO).
        ratio: f32,
    },
    /// Ellipses along vectors, longer where the vectors are longer. On surfaces.
    ///
    #[doc = include_str!("../../docs/images/metric_vectors.svg")]
    Vectors {
        /// One vector per vertex of the mesh, in the mesh's order and space. Circles where it vanishes.
        vectors: Arc<[Vec3]>,
        /// Long axis over short axis where a vector has the full length or more; 1..=[`MAX_RATIO`](Metric::MAX_RATIO).
        ratio: f32,
        /// The full length, above 0; the ratio grows linearly up to it.
        full_length: f32,
    },
    /// Ellipses along the eigenvectors of symmetric tensors (strain, stress, diffusion). On surfaces.
    ///
    #[doc = include_str!("../../docs/images/metric_tensors.svg")]
    Tensors {
        /// One tensor per vertex of the mesh, in the mesh's order and space.
        tensors: Arc<[SymmetricMat3]>,
        /// How eigenvalues become lengths.
        mapping: EigenvalueMapping,
    },
    /// Ellipses along the contour lines of a scalar. On surfaces.
    Scalars {
        /// A vertex attribute of format `Float32`.
        attribute: MeshVertexAttribute,
        /// How contours become ellipses.
        structure: Structure,
    },
    /// Ellipses along the edges of an image, which is stretched over the domain's bounds. In the plane.
    ///
    #[doc = include_str!("../../docs/images/metric_scalars.svg")]
    Image {
        /// The image; it must keep its data (`RenderAssetUsages::MAIN_WORLD`).
        image: Handle<Image>,
        /// How edges become ellipses.
        structure: Structure,
    },
    /// Metrics M of space, one per vertex of the mesh in the mesh's order; projected onto the surface (Eq. 4, 5).
    ///
    #[doc = include_str!("../../docs/images/metric_vertices.svg")]
    Vertices(Arc<[SymmetricMat3]>),
    /// A metric M of space, symmetric and positive definite, at any point: an analytic one, or a
    /// [`MetricVolume`](super::metric::MetricVolume). Projected onto the surface or the plane.
    ///
    #[doc = include_str!("../../docs/images/metric_function.svg")]
    Function(SpaceFunction<SymmetricMat3>),
}

/// How many samples there are per area, relative to other places. Above 0.
///
#[doc = include_str!("../../docs/images/metric_importance.svg")]
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub enum Importance {
    /// As many everywhere (as the metric itself says).
    #[default]
    Uniform,
    /// A vertex attribute of format `Float32`. On surfaces.
    Attribute(MeshVertexAttribute),
    /// One value per vertex of the mesh, in the mesh's order. On surfaces.
    Vertices(Arc<[f32]>),
    /// The luminance of an image, stretched over the domain's bounds: black gets `floor`, white 1. In the plane.
    Image {
        /// The image; it must keep its data.
        image: Handle<Image>,
        /// What black gets, 0..=1, at least 0.001.
        floor: f32,
    },
    /// A function of the point.
    Function(SpaceFunction<f32>),
}

/// What samples follow: shape, size and importance.
#[derive(Debug, Clone)]
pub struct Metric {
    /// The shape. Default: circles.
    pub source: MetricSource,
    /// Radius of a circle of the same area as a sample, in units of the mesh or the plane. It counts with
    /// [`Density::FillRate`](super::Density); a count scales it away. Default 1; above 0.
    pub size: f32,
    /// Where more samples are wanted. Default: nowhere.
    pub importance: Importance,
    /// Steps of log-Euclidean smoothing over the surface; one step reaches as far as the next vertices. Samplers need a
    /// metric that varies slowly; at poles of a field it never does. Default 15. Not used in the plane.
    pub smoothing: u32,
}

impl Default for Metric {
    fn default() -> Self {
        Self {
            source: MetricSource::Isotropic,
            size: 1.0,
            importance: Importance::Uniform,
            smoothing: 15,
        }
    }
}

impl Metric {
    /// The largest ratio of axes: a metric that is longer is not positive definite in single precision.
    pub const MAX_RATIO: f32 = 1000.0;

    /// A metric of a given shape, all else as by default.
    pub fn new(source: MetricSource) -> Self {
        Self { source, ..default() }
    }

    /// Ellipses with their long axis along `field`, `ratio` times as long as wide.
    pub fn along(field: DirectionField, ratio: f32) -> Self {
        Self::new(MetricSource::Field {
            field,
            turn: 0.0,
            ratio,
        })
    }

    /// Whether it reads attributes of the mesh.
    pub(super) fn needs_mesh(&self) -> bool {
        let source = match &self.source {
            MetricSource::Field { field, .. } => match field {
                DirectionField::Attribute(_) | DirectionField::Gradient { .. } | DirectionField::Tensor(_) => true,
                DirectionField::Smooth(field) => matches!(field.align, Alignment::Painted(Painted::Attribute(_))),
                _ => false,
            },
            MetricSource::Scalars { .. } => true,
            _ => false,
        };
        source || matches!(self.importance, Importance::Attribute(_))
    }
}

/// The error of a source that belongs to the other kind of domain.
pub(super) const NEEDS_SURFACE: PatternError =
    PatternError::Domain("this metric source or importance is given per vertex; it needs a mesh, not a plane");

/// The metric at each vertex of `graph`, in solver order. `mesh` is the mesh that the graph was made from.
///
/// # Errors
/// Those of [`directions`]; [`WrongLength`](PatternError::WrongLength), [`NotFinite`](PatternError::NotFinite),
/// [`NotPositive`](PatternError::NotPositive) and [`OutOfRange`](PatternError::OutOfRange) of values and options;
/// [`Domain`](PatternError::Domain) of sources that are meant for a plane.
pub fn surface_metric(metric: &Metric, graph: &SurfaceGraph, mesh: &Mesh) -> Result<Vec<SymmetricMat3>, PatternError> {
    positive("Metric::size", metric.size)?;
    let size = metric.size;
    let normals = &graph.normals;
    let mut metrics: Vec<SymmetricMat3> = match &metric.source {
        MetricSource::Isotropic => normals
            .iter()
            .map(|&n| ellipse(any_tangent(n), n, size, size))
            .collect(),
        MetricSource::Field { field, turn, ratio } => {
            check_ratio(*ratio)?;
            let (long, short) = (size * ratio.sqrt(), size / ratio.sqrt());
            directions(field, Symmetry::Line, *turn, graph, mesh)?
                .iter()
                .zip(normals)
                .map(|(&d, &n)| ellipse(project_tangent(d, n), n, long, short))
                .collect()
        }
        MetricSource::Vectors {
            vectors,
            ratio,
            full_length,
        } => {
            check_ratio(*ratio)?;
            positive("full_length", *full_length)?;
            let welded = first_copies(vectors, graph, "vectors")?;
            check_finite(vectors.iter().map(|v| v.is_finite()), "vector of vertex")?;
            welded
                .iter()
                .zip(normals)
                .map(|(&v, &n)| {
                    let tangent = v - n * n.dot(v);
                    let share = (tangent.length() / full_length).min(1.0);
                    let axis = (1.0 + (ratio - 1.0) * share).sqrt();
                    ellipse(project_tangent(v, n), n, size * axis, size / axis)
                })
                .collect()
        }
        MetricSource::Tensors { tensors, mapping } => {
            check_mapping(mapping)?;
            check_finite(tensors.iter().map(SymmetricMat3::is_finite), "tensor of vertex")?;
            let welded = first_copies(tensors, graph, "tensors")?;
            welded
                .iter()
                .zip(normals)
                .map(|(tensor, &n)| mapping.metric(tensor, n) * size.powi(-2))
                .collect()
        }
        MetricSource::Scalars { attribute, structure } => {
            check_structure(structure)?;
            let scalars = attribute_scalars(mesh, *attribute)?;
            let welded = weld_scalars(scalars, graph, "scalars", "scalar of vertex")?;
            let mut metrics = metric_of_scalars(graph, &welded, structure);
            metrics.iter_mut().for_each(|m| *m *= size.powi(-2));
            metrics
        }
        MetricSource::Vertices(given) => {
            check_metrics(given)?;
            let welded = first_copies(given, graph, "metrics")?;
            welded.iter().zip(normals).map(|(m, &n)| on_surface(m, n)).collect()
        }
        MetricSource::Function(function) => {
            let given: Vec<SymmetricMat3> = graph.positions.iter().map(|&p| function.at(p)).collect();
            check_metrics(&given)?;
            given.iter().zip(normals).map(|(m, &n)| on_surface(m, n)).collect()
        }
        MetricSource::Image { .. } => return Err(NEEDS_PLANE),
    };
    let importance = match &metric.importance {
        Importance::Uniform => None,
        Importance::Attribute(attribute) => Some(weld_scalars(
            attribute_scalars(mesh, *attribute)?,
            graph,
            "importances",
            "importance of vertex",
        )?),
        Importance::Vertices(values) => Some(weld_scalars(values, graph, "importances", "importance of vertex")?),
        Importance::Function(function) => Some(graph.positions.iter().map(|&p| function.at(p)).collect()),
        Importance::Image { .. } => return Err(NEEDS_PLANE),
    };
    if let Some(importance) = importance {
        for (m, &w) in metrics.iter_mut().zip(&importance) {
            check_importance(w)?;
            *m *= w;
        }
    }
    smooth(graph, &mut metrics, metric.smoothing.min(MOST_SMOOTHING));
    check_metrics(&metrics)?;
    Ok(metrics)
}

const NEEDS_PLANE: PatternError =
    PatternError::Domain("an image as metric or importance is stretched over a plane; it needs a PlanarDomain");

/// More steps of smoothing take long and make circles of everything.
const MOST_SMOOTHING: u32 = 10_000;

/// Per graph vertex the value of the first of its mesh vertices.
fn first_copies<T: Copy>(values: &[T], graph: &SurfaceGraph, what: &'static str) -> Result<Vec<T>, PatternError> {
    let (found, expected) = (values.len(), graph.vertex_of.len());
    if found != expected {
        return Err(PatternError::WrongLength { what, found, expected });
    }
    Ok(graph.first_vertices().iter().map(|&v| values[v as usize]).collect())
}

fn check_finite(finite: impl Iterator<Item = bool>, what: &'static str) -> Result<(), PatternError> {
    match finite.enumerate().find(|(_, finite)| !finite) {
        Some((index, _)) => Err(PatternError::NotFinite { what, index }),
        None => Ok(()),
    }
}

pub(super) fn positive(what: &'static str, value: f32) -> Result<(), PatternError> {
    within(what, value, value.is_finite() && value > 0.0, "finite and above 0")
}

fn check_ratio(ratio: f32) -> Result<(), PatternError> {
    within("ratio", ratio, (1.0..=Metric::MAX_RATIO).contains(&ratio), "1..=1000")
}

pub(super) fn check_importance(importance: f32) -> Result<(), PatternError> {
    positive("importance", importance)
}

pub(super) fn check_structure(structure: &Structure) -> Result<(), PatternError> {
    let Structure { ratio, detail, reach } = *structure;
    check_ratio(ratio)?;
    within(
        "Structure::detail",
        detail,
        detail.is_finite() && detail >= 0.0,
        "finite and 0 or more",
    )?;
    within(
        "Structure::reach",
        reach,
        reach.is_finite() && reach >= 0.0,
        "finite and 0 or more",
    )
}

fn check_mapping(mapping: &EigenvalueMapping) -> Result<(), PatternError> {
    let EigenvalueMapping {
        range,
        lengths,
        max_ratio,
    } = *mapping;
    check_ratio(max_ratio)?;
    positive("EigenvalueMapping::lengths", lengths.min_element())?;
    within("EigenvalueMapping::range", range.x, range.is_finite(), "finite")
}

fn within(what: &'static str, value: f32, inside: bool, expected: &'static str) -> Result<(), PatternError> {
    if inside {
        Ok(())
    } else {
        Err(PatternError::OutOfRange { what, value, expected })
    }
}
