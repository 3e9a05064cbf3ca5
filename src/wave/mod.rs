//! Phases: waves whose crests are the stripes.
//!
//! In: a [`SurfaceGraph`](crate::surface::SurfaceGraph) with a direction d and a frequency f per vertex. Out: a phasor z
//! per vertex, complex, whose modulus tells how sure it is. Lichtenberg et al. 2018, section 3.
//!
//! [`WavePlugin`] does, every frame, in `PostUpdate`:
//! 1. patterns: allocate ranges of the shared buffers ([`PatternArena`]), compute directions and frequencies that have
//!    changed, decide who starts, follows, comes to rest or sleeps;
//! 2. plan: one list of dispatches for all patterns;
//! 3. meshes, for the next frame: build or update the graph of every mesh that carries a pattern ([`SurfaceCache`](crate::surface::SurfaceCache));
//!
//! and in the render world, before the first camera: upload and dispatch.

mod arena;
mod carry;
mod crease;
mod edges;
mod frame;
mod hierarchy;
pub mod kite;
pub mod layout;
mod local_rule;
mod merged;
mod pack;
mod patterns;
mod pending;
mod pipelines;
mod plan;
pub mod pose;
mod quality;
mod render;
mod settings;
pub mod shade;
mod shade_disc;
pub mod shade_pair;
pub mod shade_patch;
mod shaders;
pub mod solver;
mod state;
mod status;
mod waves;

pub use crate::{arena::PatternMemory, surface::PatternMesh};
pub use arena::PatternArena;
pub use carry::{CarriedWave, CarriesPattern, carry_wave};
pub use crease::{CreaseLine, CreasePhase};
pub use patterns::Pattern;
pub use quality::{Quality, quality};
pub use render::PatternRenderSystems;
pub(crate) use shaders::WaveShaderPlugin;
pub use solver::SolverSettings;
pub use state::*;
pub use status::SolverCounters;
pub use waves::{Coupling, Frame, Waves, frame, turned};

use crate::{
    arena::{create_buffers, grow_buffers},
    field::{DirectionField, FieldTime, Frequency, PatternScalars, Vortex},
    surface::{SurfacePlugin, SurfaceSystems},
};
use bevy::{
    camera::{CameraUpdateSystems, visibility::VisibilitySystems},
    prelude::*,
    render::storage::ShaderBuffer,
};

/// Solves waves for all entities with a [`DirectionField`].
#[derive(Debug, Default, Clone, Copy)]
pub struct WavePlugin;

/// When patterns are updated, in `PostUpdate`: after transforms, before assets tell what has changed.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PatternSystems;

impl Plugin for WavePlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<WaveShaderPlugin>() {
            app.add_plugins(WaveShaderPlugin);
        }
        if !app.is_plugin_added::<SurfacePlugin>() {
            app.add_plugins(SurfacePlugin);
        }
        app.init_resource::<PatternArena>()
            .init_resource::<patterns::PackedGraphs>()
            .init_resource::<pose::PackedRigs>()
            .init_resource::<patterns::Outbox>()
            .init_resource::<patterns::Pace>()
            .init_resource::<SolverSettings>()
            .init_resource::<settings::ValidSettings>()
            .init_resource::<crate::diagnostics::QualityReport>()
            .init_resource::<crate::material::BufferGeneration>()
            .register_type::<CarriesPattern>()
            .register_type::<CreasePhase>()
            .register_type::<PatternState>()
            .register_type::<pose::PatternPose>()
            .register_type::<SolverSettings>()
            .register_type::<Waves>()
            .register_type::<Vortex>()
            .register_type::<FieldTime>()
            .register_type::<PatternScalars>()
            .register_required_components::<DirectionField, PatternState>()
            .register_required_components::<DirectionField, Frequency>()
            .add_observer(patterns::restart)
            .add_observer(patterns::remove_pattern)
            .add_observer(patterns::remove_drawn)
            .add_observer(patterns::restore_frequency);
        let update = (
            settings::check_settings,
            patterns::update_patterns
                .run_if(patterns::renders)
                .after(CameraUpdateSystems)
                // It forgets what was seen in the frame before.
                .before(VisibilitySystems::VisibilityPropagate),
            patterns::update_graphs.run_if(not(patterns::renders)),
            grow_buffers::<arena::Pool>.run_if(resource_exists::<Assets<ShaderBuffer>>),
        );
        app.configure_sets(PostUpdate, PatternSystems.in_set(SurfaceSystems::Use))
            .add_systems(
                PostUpdate,
                (
                    update.chain().in_set(PatternSystems),
                    patterns::request_surfaces.in_set(SurfaceSystems::Request),
                ),
            )
            .add_systems(Last, (patterns::note_seen, pose::take_over_again));
        render::build(app);
    }

    fn finish(&self, app: &mut App) {
        if app.world().contains_resource::<Assets<ShaderBuffer>>() {
            create_buffers::<arena::Pool>(app.world_mut());
        }
    }
}
