//! What examples and tests ask of the device: wait for it, read a buffer, read the times of passes.

use bevy::{
    diagnostic::{DiagnosticPath, DiagnosticsStore},
    prelude::*,
    render::{
        RenderApp,
        render_asset::RenderAssets,
        render_resource::{BufferDescriptor, BufferUsages, CommandEncoderDescriptor, MapMode, PollType},
        renderer::{RenderDevice, RenderQueue},
        storage::{GpuShaderBuffer, ShaderBuffer},
    },
};

/// Waits until the device has done all work.
pub fn wait(app: &App) {
    let device = app.sub_app(RenderApp).world().resource::<RenderDevice>();
    // An error here is the device's loss, which the next frame reports.
    let _ = device.poll(PollType::wait_indefinitely());
}

/// Reads `size` bytes of a shader buffer from `offset` on.
pub fn read<T: bytemuck::Pod>(
    app: &App,
    buffer: &Handle<ShaderBuffer>,
    offset: u64,
    size: u64,
) -> Result<Vec<T>, String> {
    let world = app.sub_app(RenderApp).world();
    let source = world
        .resource::<RenderAssets<GpuShaderBuffer>>()
        .get(buffer)
        .ok_or("the buffer is not on the device")?;
    let (device, queue) = (world.resource::<RenderDevice>(), world.resource::<RenderQueue>());
    let staging = device.create_buffer(&BufferDescriptor {
        label: Some("read"),
        size,
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(&source.buffer, offset, &staging, 0, size);
    queue.submit([encoder.finish()]);
    let slice = staging.slice(..);
    slice.map_async(MapMode::Read, |_| ());
    wait(app);
    let bytes = slice.get_mapped_range();
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}

/// GPU time of a stage in its last frame, in milliseconds, where the device can tell.
pub fn stage_ms(app: &App, stage: &str) -> Option<f64> {
    let path = DiagnosticPath::new(format!("render/{stage}/elapsed_gpu"));
    app.world().resource::<DiagnosticsStore>().get(&path)?.value()
}
