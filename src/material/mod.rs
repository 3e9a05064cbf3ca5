//! What the fragment shader draws.
use bevy::prelude::*;
/// How often the shared buffers have been made anew, which they are when they grow.
#[derive(Resource, Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BufferGeneration(pub u32);
