//! Real-time field-aligned patterns on any triangle mesh, as a Bevy plugin.

use bevy::app::{PluginGroup, PluginGroupBuilder};

pub mod error;
pub mod field;
pub mod material;
pub mod scene;
pub mod surface;
pub mod wave;

/// What most programs need.
pub mod prelude {
    #[doc(no_inline)]
    pub use crate::{
        FieldPatternsPlugin,
        error::PatternError,
        field::{DirectionField, FieldTurn, Frequency, PatternSpace, Symmetry},
        material::{
            DebugStyle, Focus, FocusShape, FocusSource, PatternMaterialPlugin, Profile, StripeDrive, StripeMaterial,
            Stripes,
        },
        scene::{PatternScene, PatternScenePart},
        wave::{PatternFailed, PatternMesh, PatternReady, PatternState, RestartPattern, SolverSettings},
    };
}

/// Everything: waves, the materials that draw them, and scenes of patterned meshes.
#[derive(Debug, Default, Clone, Copy)]
pub struct FieldPatternsPlugin;

impl PluginGroup for FieldPatternsPlugin {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(wave::WavePlugin)
            .add(material::StripeMaterialPlugin)
            .add(scene::PatternScenePlugin)
    }
}
