//! What fields and frequencies name besides their own mesh: other entities, and buffers on the device.

use crate::{error::PatternError, field::Vortex};
use bevy::{
    ecs::system::SystemParam,
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::BufferUsages,
        storage::{GpuShaderBuffer, ShaderBuffer},
    },
};
use std::sync::{Arc, Mutex, PoisonError};

/// All that a source may look at.
#[derive(SystemParam)]
pub(crate) struct Surroundings<'w, 's> {
    pub(super) places: Query<'w, 's, &'static GlobalTransform>,
    pub(super) cores: Query<'w, 's, (Entity, &'static Vortex, &'static GlobalTransform)>,
    pub(super) cameras: Query<'w, 's, (&'static Camera, &'static GlobalTransform)>,
    buffers: Res<'w, BufferWatch>,
}

impl Surroundings<'_, '_> {
    /// Whether a user's buffer can be copied; `false` while it is not on the device yet.
    pub(super) fn buffer_is_ready(
        &self,
        what: &'static str,
        buffer: &Handle<ShaderBuffer>,
        needed: u64,
    ) -> Result<bool, PatternError> {
        match self.buffers.look(buffer.id()) {
            None => Ok(false),
            Some(found) if !found.usage.contains(BufferUsages::COPY_SRC) => Err(PatternError::BufferUsage(what)),
            Some(Found { size: found, .. }) if found != needed => Err(PatternError::BufferSize { what, found, needed }),
            Some(_) => Ok(true),
        }
    }
}

/// A buffer on the device.
#[derive(Debug, Clone, Copy)]
struct Found {
    size: u64,
    usage: BufferUsages,
}

#[derive(Debug, Default)]
struct Watched {
    asked: bool,
    found: Option<Found>,
}

/// The sizes and usages of users' buffers, which only the render world knows.
#[derive(Resource, Clone, Default)]
pub(crate) struct BufferWatch(Arc<Mutex<HashMap<AssetId<ShaderBuffer>, Watched>>>);

impl BufferWatch {
    /// What was known of a buffer in the frame before; from now on it is looked for.
    fn look(&self, buffer: AssetId<ShaderBuffer>) -> Option<Found> {
        let mut watched = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let watched = watched.entry(buffer).or_default();
        watched.asked = true;
        watched.found
    }
}

/// Looks for the buffers that were asked for, in the render world.
pub(crate) fn watch_buffers(watch: Res<BufferWatch>, buffers: Res<RenderAssets<GpuShaderBuffer>>) {
    let mut watched = watch.0.lock().unwrap_or_else(PoisonError::into_inner);
    watched.retain(|&id, watched| {
        watched.found = buffers.get(id).map(|gpu| Found {
            size: gpu.buffer.size(),
            usage: gpu.buffer.usage(),
        });
        std::mem::take(&mut watched.asked)
    });
}
