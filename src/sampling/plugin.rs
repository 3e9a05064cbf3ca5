//! Sampling as a component: asked for on an entity, done off the main thread, done again when an input changes.
//!
//! In: [`AnisotropicSamples`] on an entity with a `Mesh3d` or a [`PlanarDomain`]. Out: its [`SampleSet`] and
//! [`SamplingState`].

use super::{
    Density, Importance, Metric, MetricSource, Pixels, Progress, SampleSet,
    planar::{PlanarDomain, PlanarSampling, sample_plane},
    source::{NEEDS_SURFACE, check_importance, check_structure, positive},
    surface::{SurfaceMethod, SurfaceRelaxer, SurfaceSampling, sample_surface},
    surface_metric,
};
use crate::{
    error::PatternError,
    sampling::metric::{on_plane, planar_ellipse},
    surface::{PatternMesh, SurfaceCache, SurfaceGraph, SurfacePlugin, SurfaceState, SurfaceSystems},
};
use bevy::{
    ecs::system::SystemParam,
    math::{DVec2, DVec3},
    mesh::PrimitiveTopology,
    platform::collections::HashSet,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};
use glam_matrix_extras::SymmetricDMat2;
use std::sync::Arc;

/// Samples every entity with [`AnisotropicSamples`].
#[derive(Debug, Clone, Copy, Default)]
pub struct SamplingPlugin;

impl Plugin for SamplingPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<SurfacePlugin>() {
            app.add_plugins(SurfacePlugin);
        }
        app.register_type::<SamplingState>()
            .add_observer(remove_samples)
            .add_systems(PostUpdate, request_surfaces.in_set(SurfaceSystems::Request))
            .add_message::<AssetEvent<Image>>()
            .configure_sets(PostUpdate, SamplingSystems.in_set(SurfaceSystems::Use))
            .add_systems(PostUpdate, update_samples.in_set(SamplingSystems));
    }
}

/// Samples that are done are taken over, and new ones begun, in `PostUpdate`.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SamplingSystems;

/// Asks for samples on the entity's mesh, or on its [`PlanarDomain`] if it has one.
///
/// They are computed off the main thread; [`SamplingState`] tells how far they are, and [`SampleSet`] holds them. They
/// are computed anew when this component, the mesh, the domain or an image changes. The same inputs and seed give the
/// same samples, bit by bit, on any number of threads.
#[derive(Component, Debug, Clone, Default)]
#[require(SamplingState)]
pub struct AnisotropicSamples {
    /// Shape, size and importance of samples. Default: circles.
    pub metric: Metric,
    /// How many. Default 1000.
    pub density: Density,
    /// How, on a mesh. In a plane, [`SurfaceMethod::Paper`] asks for
    /// [`PlanarSampling::paper`] and the others for its default.
    pub method: SurfaceMethod,
    /// Steps of relaxation; `None` for the method's own choice. More are more regular; 10 look random and even.
    pub steps: Option<u32>,
    /// Another seed gives other samples of the same kind. Default 0.
    pub seed: u64,
    /// On a mesh: go on from the samples that are there when an input changes, as long as the triangles stay the same, so
    /// that samples move instead of being drawn anew. Their steps are then 3 by default. In a plane,
    /// [`SliceSampler`](super::planar::SliceSampler) does that. Default `false`.
    pub follow: bool,
}

/// How far the samples of an entity are.
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default)]
pub enum SamplingState {
    /// The mesh or an image is being loaded, or the mesh's graph is being built.
    #[default]
    Preparing,
    /// Being computed, for the first time or anew; the part that is done, 0..=1.
    Sampling(f32),
    /// Done: [`SampleSet`] is up to date.
    Ready,
    /// There are no samples. A change of an input tries again.
    Failed(PatternError),
}

/// Sent to an entity when it has new samples.
#[derive(EntityEvent, Debug, Clone)]
pub struct SamplesReady {
    /// The entity with the [`SampleSet`].
    pub entity: Entity,
}

/// Sent to an entity when it cannot be sampled.
#[derive(EntityEvent, Debug, Clone)]
pub struct SamplesFailed {
    /// The entity without samples.
    pub entity: Entity,
    /// Why.
    pub error: PatternError,
}

/// The computation of an entity's samples.
#[derive(Component)]
struct Sampler {
    /// What the samples were made from last.
    ground: Ground,
    task: Option<SampleTask>,
    /// What samples that follow their inputs keep from one time to the next.
    relaxer: SurfaceRelaxer,
    progress: Progress,
    /// An input has changed since the task began.
    outdated: bool,
}

impl Drop for Sampler {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}

/// What carries the samples.
#[derive(Clone)]
enum Ground {
    Plane(PlanarDomain),
    Surface {
        mesh: AssetId<Mesh>,
        geometry: u32,
        graph: Arc<SurfaceGraph>,
    },
}

/// Asks for the graphs of meshes in the frame in which their data are still there.
fn request_surfaces(
    changed: Query<
        (&Mesh3d, Option<&PatternMesh>),
        (
            With<AnisotropicSamples>,
            Without<PlanarDomain>,
            Or<(Changed<Mesh3d>, Added<AnisotropicSamples>)>,
        ),
    >,
    mut cache: ResMut<SurfaceCache>,
) {
    for (mesh, meshes) in &changed {
        if meshes.is_none_or(|meshes| meshes.drawn != mesh.0) {
            cache.request(mesh.id());
        }
    }
}

/// What starting to sample needs of the world.
#[derive(SystemParam)]
struct Tools<'w, 's> {
    commands: Commands<'w, 's>,
    cache: ResMut<'w, SurfaceCache>,
    graphs: Res<'w, Assets<SurfaceGraph>>,
    meshes: Res<'w, Assets<Mesh>>,
    images: Option<Res<'w, Assets<Image>>>,
}

type Sampled<'a> = (
    Entity,
    Ref<'a, AnisotropicSamples>,
    Option<&'a Mesh3d>,
    Option<&'a PatternMesh>,
    Option<Ref<'a, PlanarDomain>>,
    Option<&'a mut Sampler>,
    Option<&'a SampleSet>,
    &'a mut SamplingState,
);

fn update_samples(mut sampled: Query<Sampled>, mut tools: Tools, mut images: MessageReader<AssetEvent<Image>>) {
    let touched: HashSet<AssetId<Image>> = images
        .read()
        .filter_map(|event| match event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    for (entity, samples, mesh, meshes, domain, sampler, set, mut state) in &mut sampled {
        let domain_changed = domain.as_ref().is_some_and(|domain| domain.is_changed());
        let ground = match ground(mesh, meshes, domain.as_deref(), sampler.as_deref(), &mut tools) {
            Ok(Some(ground)) => ground,
            Ok(None) => {
                if sampler.is_none() {
                    state.set_if_neq(SamplingState::Preparing);
                }
                continue;
            }
            Err(error) => {
                fail(entity, &mut state, &mut tools.commands, error);
                continue;
            }
        };
        let image_changed = samples.images().any(|image| touched.contains(&image.id()));
        let mut changed = samples.is_changed() || domain_changed || image_changed;
        let mut current = sampler;
        if let Some(sampler) = current.as_mut() {
            changed |= !sampler.ground.is_same(&ground);
            let Sampler {
                task,
                relaxer: kept,
                outdated,
                progress,
                ..
            } = &mut **sampler;
            if let Some(running) = task {
                *outdated |= changed;
                let Some((done, relaxer)) = block_on(poll_once(running)) else {
                    state.set_if_neq(SamplingState::Sampling(progress.done()));
                    continue;
                };
                (*task, *kept) = (None, relaxer);
                changed = std::mem::take(outdated);
                match done {
                    Ok(set) => {
                        tools.commands.entity(entity).try_insert(set);
                        tools.commands.trigger(SamplesReady { entity });
                        state.set_if_neq(SamplingState::Ready);
                    }
                    Err(error) => fail(entity, &mut state, &mut tools.commands, error),
                }
            }
        } else {
            changed = true;
        }
        if !changed {
            continue;
        }
        let progress = Progress::default();
        let relaxer = current
            .as_mut()
            .map_or_else(default, |sampler| std::mem::take(&mut sampler.relaxer));
        match start(&samples, &ground, set, relaxer, progress.clone(), &tools) {
            Ok(Some(task)) => {
                state.set_if_neq(SamplingState::Sampling(0.0));
                let new = Sampler {
                    ground,
                    task: Some(task),
                    relaxer: default(),
                    progress,
                    outdated: false,
                };
                match current {
                    Some(mut sampler) => *sampler = new,
                    None => {
                        tools.commands.entity(entity).try_insert(new);
                    }
                }
            }
            // An image is still being loaded: it will be an event.
            Ok(None) => {
                state.set_if_neq(SamplingState::Preparing);
            }
            Err(error) => {
                fail(entity, &mut state, &mut tools.commands, error);
                tools.commands.entity(entity).try_insert(Sampler {
                    ground,
                    task: None,
                    relaxer: default(),
                    progress,
                    outdated: false,
                });
            }
        }
    }
}

impl Ground {
    fn is_same(&self, other: &Self) -> bool {
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
    fn images(&self) -> impl Iterator<Item = &Handle<Image>> {
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

/// What the samples of an entity lie on; `None` while it is being prepared.
fn ground(
    mesh: Option<&Mesh3d>,
    meshes: Option<&PatternMesh>,
    domain: Option<&PlanarDomain>,
    sampler: Option<&Sampler>,
    tools: &mut Tools,
) -> Result<Option<Ground>, PatternError> {
    if let Some(domain) = domain {
        return Ok(Some(Ground::Plane(domain.clone())));
    }
    let Some(mesh) = mesh else {
        return Err(PatternError::Domain(
            "the entity has neither a Mesh3d nor a PlanarDomain",
        ));
    };
    let source = match meshes {
        Some(meshes) if meshes.drawn == mesh.0 => meshes.source.id(),
        _ => mesh.id(),
    };
    let surface = match tools.cache.request(source) {
        SurfaceState::Ready(surface) => surface,
        SurfaceState::Preparing => return Ok(None),
        SurfaceState::Failed(error) => return Err(error),
    };
    let known = sampler.and_then(|sampler| match &sampler.ground {
        Ground::Surface { mesh, geometry, graph } if *mesh == source && *geometry == surface.geometry => {
            Some(graph.clone())
        }
        _ => None,
    });
    let graph = match known {
        Some(graph) => graph,
        None => match tools.graphs.get(&surface.graph) {
            Some(graph) => Arc::new(graph.clone()),
            None => return Ok(None),
        },
    };
    Ok(Some(Ground::Surface {
        mesh: source,
        geometry: surface.geometry,
        graph,
    }))
}

/// Steps of relaxation after a change that samples follow.
const STEPS_TO_FOLLOW: u32 = 3;

type SampleTask = Task<(Result<SampleSet, PatternError>, SurfaceRelaxer)>;

/// Starts to sample; `None` while an image is missing.
fn start(
    samples: &AnisotropicSamples,
    ground: &Ground,
    set: Option<&SampleSet>,
    mut relaxer: SurfaceRelaxer,
    progress: Progress,
    tools: &Tools,
) -> Result<Option<SampleTask>, PatternError> {
    let samples = samples.clone();
    let pool = AsyncComputeTaskPool::get();
    match ground.clone() {
        Ground::Surface { mesh, graph, .. } => {
            let mesh = if samples.metric.needs_mesh() {
                tools.meshes.get(mesh).ok_or(PatternError::MeshDataTaken)?.clone()
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
                match tools.images.as_ref().and_then(|images| images.get(handle)) {
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

type PointMetric = Box<dyn Fn(DVec2) -> SymmetricDMat2 + Send + Sync>;

/// The metric at each point of a plane. `pixels` are those of [`AnisotropicSamples::images`].
fn planar_metric(metric: &Metric, domain: &PlanarDomain, pixels: Vec<Pixels>) -> Result<PointMetric, PatternError> {
    use super::planar::PlanarMetric;
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

/// Says once why an entity has no samples.
fn fail(entity: Entity, state: &mut Mut<SamplingState>, commands: &mut Commands, error: PatternError) {
    let failed = SamplingState::Failed(error.clone());
    if **state == failed {
        return;
    }
    **state = failed;
    error!("no samples on {entity}: {error}");
    commands.entity(entity).try_remove::<SampleSet>();
    commands.trigger(SamplesFailed { entity, error });
}

/// An entity that asks for no samples has none.
fn remove_samples(event: On<Remove, AnisotropicSamples>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(event.entity) {
        entity.try_remove::<(SampleSet, SamplingState, Sampler)>();
    }
}
