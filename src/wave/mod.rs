//! Phases: waves whose crests are the stripes.
//!
//! In: a [`SurfaceGraph`](crate::surface::SurfaceGraph) with a direction d and a frequency f per vertex. Out: a phasor z
//! per vertex. Lichtenberg et al. 2018, section 3.

pub mod kite;
pub mod layout;
pub mod shade;
mod shaders;

pub(crate) use shaders::WaveShaderPlugin;
