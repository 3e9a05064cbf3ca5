//! The computation of an entity's samples, off the main thread.
//!
//! In: what is asked for, and what carries the samples. Out: a task that makes a [`SampleSet`].

use super::{
    AnisotropicSamples, Importance, MetricSource, Pixels, Progress, SampleSet,
    planar::{PlanarDomain, PlanarSampling, sample_plane},
    point_metric::planar_metric,
    surface::{SurfaceMethod, SurfaceRelaxer, SurfaceSampling, sample_surface},
    surface_metric,
};
use crate::{error::PatternError, surface::SurfaceGraph};
use bevy::{
    mesh::PrimitiveTopology,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task},
};
use std::sync::Arc;

/// What carries the samples.
#[derive(Clone)]
pub(super) enum Ground {
    Plane(PlanarDomain),
    Surface {
        mesh: AssetId<Mesh>,
        geometry: u32,
        graph: Arc<SurfaceGraph>,
    },
}

impl Ground {
    pub(super) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Plane(_), Self::Plane(_)) => true,
            (
                Self::Surface { mesh, geometry, .. },
                Self::Surface {
                    mesh: other_mesh,
                    geometry: other_geometry,
                    ..
                },
            ) => mesh == other_mesh && geometry == other_geometry,
            _ => false,
        }
    }
}

impl AnisotropicSamples {
    pub(super) fn images(&self) -> impl Iterator<Item = &Handle<Image>> {
        let metric = match &self.metric.source {
            MetricSource::Image { image, .. } => Some(image),
            _ => None,
        };
        let importance = match &self.metric.importance {
            Importance::Image { image, .. } => Some(image),
            _ => None,
        };
        metric.into_iter().chain(importance)
    }
}

/// Steps of relaxation after a change that samples follow.
const STEPS_TO_FOLLOW: u32 = 3;

pub(super) type SampleTask = Task<(Result<SampleSet, PatternError>, SurfaceRelaxer)>;

/// Starts to sample; `None` while an image is missing.
pub(super) fn start(
    samples: &AnisotropicSamples,
    ground: &Ground,
    set: Option<&SampleSet>,
    mut relaxer: SurfaceRelaxer,
    progress: Progress,
    meshes: &Assets<Mesh>,
    images: Option<&Assets<Image>>,
) -> Result<Option<SampleTask>, PatternError> {
    let samples = samples.clone();
    let pool = AsyncComputeTaskPool::get();
    match ground.clone() {
        Ground::Surface { mesh, graph, .. } => {
            let mesh = if samples.metric.needs_mesh() {
                meshes.get(mesh).ok_or(PatternError::MeshDataTaken)?.clone()
            } else {
                Mesh::new(PrimitiveTopology::TriangleList, default())
            };
            let before = set.filter(|set| samples.follow && set.seeds.len() == graph.triangles.len());
            let before = before.cloned();
            Ok(Some(pool.spawn(async move {
                let set = on_surface(&samples, &graph, &mesh, before.as_ref(), &mut relaxer, &progress);
                (set, relaxer)
            })))
        }
        Ground::Plane(domain) => {
            let mut pixels = Vec::new();
            for handle in samples.images() {
                match images.and_then(|images| images.get(handle)) {
                    Some(image) => pixels.push(Pixels::new(image)?),
                    None => return Ok(None),
                }
            }
            Ok(Some(pool.spawn(async move {
                (in_plane(&samples, &domain, pixels, &progress), relaxer)
            })))
        }
    }
}

/// Samples of a mesh; going on from those `before`, if any.
fn on_surface(
    samples: &AnisotropicSamples,
    graph: &SurfaceGraph,
    mesh: &Mesh,
    before: Option<&SampleSet>,
    relaxer: &mut SurfaceRelaxer,
    progress: &Progress,
) -> Result<SampleSet, PatternError> {
    let metric = surface_metric(&samples.metric, graph, mesh)?;
    let mut options = SurfaceSampling {
        density: samples.density,
        method: samples.method,
        seed: samples.seed,
        ..default()
    };
    let sampled = if let Some(before) = before {
        options.steps = samples.steps.unwrap_or(STEPS_TO_FOLLOW);
        relaxer.relax(graph, &metric, before, &options, progress)?
    } else {
        options.steps = samples.steps.unwrap_or(options.steps);
        sample_surface(graph, &metric, &options, progress)?
    };
    Ok(sampled.set)
}

/// Samples of a plane. `pixels` are those of [`AnisotropicSamples::images`].
fn in_plane(
    samples: &AnisotropicSamples,
    domain: &PlanarDomain,
    pixels: Vec<Pixels>,
    progress: &Progress,
) -> Result<SampleSet, PatternError> {
    let metric = planar_metric(&samples.metric, domain, pixels)?;
    let mut options = match samples.method {
        SurfaceMethod::Paper => PlanarSampling::paper(),
        _ => PlanarSampling::default(),
    };
    options.density = samples.density;
    options.seed = samples.seed;
    if let Some(steps) = samples.steps {
        options.steps = steps;
    }
    let set = sample_plane(domain, &metric, &options, progress)?.set();
    set.check_radii()?;
    Ok(set)
}
