//! The metric of a component in a plane.
//!
//! In: a [`Metric`], a domain, the pixels of its images. Out: a function of the point.

use super::{
    Importance, Metric, MetricSource, Pixels,
    metric::{on_plane, planar_ellipse},
    planar::{PlanarDomain, PlanarMetric},
    source::{NEEDS_SURFACE, check_importance, check_structure, positive},
};
use crate::error::PatternError;
use bevy::{
    math::{DVec2, DVec3},
    prelude::*,
};
use glam_matrix_extras::SymmetricDMat2;

/// A metric at each point of a plane.
pub(super) type PointMetric = Box<dyn Fn(DVec2) -> SymmetricDMat2 + Send + Sync>;

/// The metric at each point of a plane. `pixels` are those of [`AnisotropicSamples::images`].
pub(super) fn planar_metric(
    metric: &Metric,
    domain: &PlanarDomain,
    pixels: Vec<Pixels>,
) -> Result<PointMetric, PatternError> {
    positive("Metric::size", metric.size)?;
    let size = f64::from(metric.size);
    let (min, max) = domain.bounds();
    let mut pixels = pixels.into_iter();
    let shape: PointMetric = match &metric.source {
        MetricSource::Isotropic => {
            let m = planar_ellipse(0.0, size, size);
            Box::new(move |_| m)
        }
        MetricSource::Image { structure, .. } => {
            check_structure(structure)?;
            let Some(image) = pixels.next() else {
                return Err(NEEDS_SURFACE);
            };
            let grid = image.metric(min, max, structure)?;
            Box::new(move |p| grid.at(p) * size.powi(-2))
        }
        MetricSource::Function(function) => {
            let function = function.clone();
            Box::new(move |p| {
                let m = function.at(p.extend(0.0).as_vec3());
                on_plane(&m.as_symmetric_dmat3(), DVec3::X, DVec3::Y)
            })
        }
        _ => return Err(NEEDS_SURFACE),
    };
    Ok(match &metric.importance {
        Importance::Uniform => shape,
        Importance::Function(function) => {
            let function = function.clone();
            Box::new(move |p| shape(p) * f64::from(function.at(p.extend(0.0).as_vec3())))
        }
        Importance::Image { floor, .. } => {
            let floor = floor.clamp(1e-3, 1.0);
            check_importance(floor)?;
            let Some(image) = pixels.next() else {
                return Err(NEEDS_SURFACE);
            };
            Box::new(move |p| {
                let bright = Pixels::luminance(image.at(((p - min) / (max - min)).as_vec2()));
                shape(p) * f64::from(floor.lerp(1.0, bright.clamp(0.0, 1.0)))
            })
        }
        Importance::Attribute(_) | Importance::Vertices(_) => return Err(NEEDS_SURFACE),
    })
}
