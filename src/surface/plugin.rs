//! The surfaces of all meshes that carry patterns, in an app: when they are asked for, built and used.

use super::{PatternCloud, PatternWeld, SurfaceCache, SurfaceGraph, finish_surfaces, start_surfaces, watch_meshes};
use bevy::{asset::AssetEventSystems, prelude::*};

/// The meshes of an entity with a pattern.
///
/// A pattern is drawn on an un-indexed copy of the mesh, which the plugin puts into the entity's `Mesh3d`. Here is the
/// mesh it was made from: use it for picking, physics and changes of the shape. Setting `Mesh3d` again gives the entity
/// a new mesh; removing what the pattern follows (its [`DirectionField`](crate::field::DirectionField), or the
/// [`SampleSet`](crate::sampling::SampleSet) of its cells) gives it back the original.
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component)]
pub struct PatternMesh {
    /// The user's mesh.
    pub source: Handle<Mesh>,
    /// The copy that is drawn.
    pub drawn: Handle<Mesh>,
    /// The graph of the mesh.
    pub graph: Handle<SurfaceGraph>,
}

/// What happens to surfaces in `PostUpdate`, in this order.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SurfaceSystems {
    /// Builds that have come to their end are taken over; after transforms.
    Finish,
    /// Graphs and the copies to be drawn are used; before assets tell what has changed.
    Use,
    /// Changed and removed meshes are noticed; when assets have told, before rendering takes their data away.
    Watch,
    /// Graphs of new meshes are asked for, while their data are still there.
    Request,
    /// Builds are begun, and changed positions written in place.
    Start,
}

/// Keeps the [`SurfaceCache`]; added once, by whichever room comes first.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SurfacePlugin;

impl Plugin for SurfacePlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<SurfaceGraph>()
            .init_resource::<SurfaceCache>()
            .init_resource::<PatternWeld>()
            .init_resource::<PatternCloud>()
            .register_type::<PatternMesh>()
            .configure_sets(
                PostUpdate,
                (
                    (SurfaceSystems::Finish, SurfaceSystems::Use)
                        .chain()
                        .after(TransformSystems::Propagate)
                        .before(AssetEventSystems),
                    (SurfaceSystems::Watch, SurfaceSystems::Request, SurfaceSystems::Start)
                        .chain()
                        .after(AssetEventSystems),
                )
                    .run_if(resource_exists::<Assets<Mesh>>),
            )
            .add_systems(
                PostUpdate,
                (
                    finish_surfaces.in_set(SurfaceSystems::Finish),
                    watch_meshes.in_set(SurfaceSystems::Watch),
                    start_surfaces.in_set(SurfaceSystems::Start),
                ),
            );
    }
}
