//! Real-time field-aligned patterns on any triangle mesh, as a Bevy plugin.

use bevy::app::{PluginGroup, PluginGroupBuilder};

pub mod error;
pub mod field;
pub mod material;
pub mod surface;
pub mod wave;

/// What most programs need.
pub mod prelude {
    #[doc(no_inline)]
    pub use crate::{
        FieldPatternsPlugin,
        error::PatternError,
        field::{DirectionField, FieldTurn, Frequency, PatternSpace, Symmetry},
        material::{DebugStyle, Focus, PatternMaterialPlugin, Profile, StripeDrive, StripeMaterial, Stripes},
        wave::{PatternFailed, PatternMesh, PatternReady, PatternState, RestartPattern, SolverSettings},
    };
}

/// Everything: waves, and the materials that draw them.
#[derive(Debug, Default, Clone, Copy)]
pub struct FieldPatternsPlugin;

impl PluginGroup for FieldPatternsPlugin {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(wave::WavePlugin)
            .add(material::StripeMaterialPlugin)
    }
}
