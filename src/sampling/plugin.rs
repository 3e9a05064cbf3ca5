//! Sampling as a component: asked for on an entity, done off the main thread, done again when an input changes.
//!
//! In: [`AnisotropicSamples`] on an entity with a `Mesh3d` or a [`PlanarDomain`]. Out: its [`SampleSet`] and
//! [`SamplingState`].

use super::{
    Density, Metric, Progress, SampleSet,
    planar::PlanarDomain,
    surface::{SurfaceMethod, SurfaceRelaxer},
    task::{Ground, SampleTask, start},
};
use crate::{
    error::PatternError,
    surface::{PatternMesh, SurfaceCache, SurfaceGraph, SurfacePlugin, SurfaceState, SurfaceSystems},
};
use bevy::{
    ecs::system::SystemParam,
    platform::collections::HashSet,
    prelude::*,
    tasks::{block_on, poll_once},
};
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
    /// [`PlanarSampling::paper`](super::planar::PlanarSampling::paper) and the others for its default.
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
        match start(
            &samples,
            &ground,
            set,
            relaxer,
            progress.clone(),
            &tools.meshes,
            tools.images.as_deref(),
        ) {
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
