//! The uploads of sample sets, in the render world.
//!
//! In: what the main world wrote in a frame. Out: bytes in the shared buffers before any camera draws, as soon as the
//! buffers are large enough.

use super::layout::{CellArena, Pool};
use crate::arena::{Pool as _, Upload};
use bevy::{
    prelude::*,
    render::{
        MainWorld, Render, RenderApp, RenderStartup, RenderSystems, render_asset::RenderAssets, renderer::RenderQueue,
        storage::GpuShaderBuffer,
    },
};
use std::sync::{
    Arc,
    atomic::{AtomicU32, Ordering::Relaxed},
};

/// What the render world has not taken yet.
#[derive(Resource, Default)]
pub(super) struct Outbox {
    uploads: Vec<Upload<Pool>>,
    /// Bytes that the buffers must have.
    capacities: Vec<u64>,
}

impl Outbox {
    pub(super) fn take_from(&mut self, arena: &mut CellArena) {
        self.uploads.extend(arena.take_uploads());
        self.capacities = Pool::ALL.iter().map(|&pool| arena.capacity(pool)).collect();
    }
}

/// Uploads that wait for their buffers.
#[derive(Resource, Default)]
struct Pending(Outbox);

/// What the main world knows of the device; only there in an app that renders.
#[derive(Resource, Clone, Default)]
pub(super) struct UploadStatus(Arc<AtomicU32>);

impl UploadStatus {
    /// Counts the devices so far; what was on an earlier one is lost.
    pub(super) fn generation(&self) -> u32 {
        self.0.load(Relaxed)
    }
}

pub(super) fn build(app: &mut App) {
    let status = UploadStatus::default();
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
        return;
    };
    render_app
        .insert_resource(status.clone())
        .init_resource::<Pending>()
        .add_systems(RenderStartup, count_device)
        .add_systems(ExtractSchedule, extract)
        .add_systems(Render, upload.in_set(RenderSystems::PrepareBindGroups));
    app.insert_resource(status).init_resource::<Outbox>();
}

fn count_device(status: Res<UploadStatus>, mut pending: ResMut<Pending>) {
    status.0.fetch_add(1, Relaxed);
    pending.0.uploads.clear();
}

fn extract(mut main: ResMut<MainWorld>, mut pending: ResMut<Pending>) {
    if let Some(mut outbox) = main.get_resource_mut::<Outbox>()
        && !outbox.uploads.is_empty()
    {
        pending.0.uploads.append(&mut outbox.uploads);
        pending.0.capacities.clone_from(&outbox.capacities);
    }
}

fn upload(mut pending: ResMut<Pending>, buffers: Res<RenderAssets<GpuShaderBuffer>>, queue: Res<RenderQueue>) {
    let Outbox { uploads, capacities } = &mut pending.0;
    if uploads.is_empty() {
        return;
    }
    let gpu: Option<Vec<&GpuShaderBuffer>> = Pool::ALL.iter().map(|pool| buffers.get(&pool.handle())).collect();
    let Some(gpu) = gpu else { return };
    if gpu
        .iter()
        .zip(capacities)
        .all(|(buffer, needed)| buffer.buffer.size() >= *needed)
    {
        for upload in uploads.drain(..) {
            queue.write_buffer(&gpu[upload.pool.index()].buffer, upload.offset, &upload.bytes);
        }
    }
}
