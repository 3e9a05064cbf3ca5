//! Values that the user's own compute pass writes.

use bevy::{prelude::*, render::storage::ShaderBuffer};

/// A storage buffer on the device with one value per vertex of the mesh, in the mesh's order:
/// `vec4<f32>` (a vector of any length in the mesh's space; w is not read) for directions, `f32` for frequencies.
///
/// It is copied before directions and frequencies are evaluated, so it needs `BufferUsages::COPY_SRC`, which a
/// [`ShaderBuffer`] has by default, and exactly the size of its values. Write it before the systems of
/// [`PatternRenderSystems`](crate::wave::PatternRenderSystems) in Bevy's `RenderGraph` schedule, and what you wrote is drawn
/// in the same frame. Of the copies of a vertex at a seam the first counts. What is not finite counts as no direction and
/// as frequency 0; so does a negative frequency.
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default)]
pub struct FieldBuffer {
    /// The buffer. As long as there is none behind the handle, the pattern is being prepared. Default: none.
    pub buffer: Handle<ShaderBuffer>,
    /// Whether it is read in every frame, in which case the pattern never sleeps. Otherwise it is read when the component
    /// that names it has changed (`set_changed` will do). Default: in every frame.
    pub live: bool,
}

impl Default for FieldBuffer {
    fn default() -> Self {
        Self {
            buffer: Handle::default(),
            live: true,
        }
    }
}

impl From<Handle<ShaderBuffer>> for FieldBuffer {
    fn from(buffer: Handle<ShaderBuffer>) -> Self {
        Self { buffer, live: true }
    }
}
