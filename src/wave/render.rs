//! The solver in the render world: pipelines, uploads and dispatches.
//!
//! In: the [`Frame`] of the main world. Out: phasors in the shared buffers, before any camera draws.

use super::{
    arena::Pool,
    frame::{Pass, StepUniform},
    patterns::{BufferWatch, Outbox, watch_buffers},
    pending::{Merged, Pending},
    pipelines::{Pipelines, init_pipelines, stage},
    status::{GpuStatus, SolverCounters},
};
use crate::arena::Pool as _;
use bevy::{
    asset::embedded_asset,
    core_pipeline::schedule::camera_driver,
    prelude::*,
    render::{
        MainWorld, Render, RenderApp, RenderStartup, RenderSystems,
        diagnostic::RecordDiagnostics,
        render_asset::RenderAssets,
        render_resource::{
            BindGroup, BindGroupEntries, Buffer, BufferBinding, BufferDescriptor, BufferInitDescriptor, BufferUsages,
            ComputePassDescriptor, PipelineCache,
        },
        renderer::{RenderContext, RenderDevice, RenderGraph, RenderGraphSystems, RenderQueue},
        settings::WgpuFeatures,
        storage::GpuShaderBuffer,
    },
};
use std::num::NonZeroU64;

/// The dispatches of this frame, ready to be recorded.
#[derive(Resource, Default)]
struct Prepared {
    work: Merged,
    /// One for each of the pipelines' layouts.
    bind_groups: Option<[BindGroup; 2]>,
    /// The bytes of the copies between steps, and the shared buffers that get them.
    staging: Option<(Buffer, [Buffer; Pool::ALL.len()])>,
}

/// Bytes from one step's uniform to the next: WebGPU's largest alignment of a dynamic offset.
const STEP_STRIDE: usize = 256;

/// Where patterns are solved: in Bevy's `RenderGraph` schedule, before any camera draws. A pass of your own that writes a
/// [`FieldBuffer`](crate::field::FieldBuffer) comes before it:
/// `my_pass.in_set(RenderGraphSystems::Render).before(PatternRenderSystems)`.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PatternRenderSystems;

pub(crate) fn build(app: &mut App) {
    embedded_asset!(app, "passes.wgsl");
    embedded_asset!(app, "field/tangent.wgsl");
    embedded_asset!(app, "field/parameters.wgsl");
    embedded_asset!(app, "field/vortices.wgsl");
    embedded_asset!(app, "field/tensor.wgsl");
    embedded_asset!(app, "field/cross.wgsl");
    embedded_asset!(app, "field/smooth.wgsl");
    embedded_asset!(app, "field/directions.wgsl");
    embedded_asset!(app, "field/frequencies.wgsl");
    embedded_asset!(app, "pose/deform.wgsl");
    embedded_asset!(app, "pose/pose.wgsl");
    embedded_asset!(app, "pose/limit.wgsl");
    embedded_asset!(app, "pose/curvature.wgsl");
    embedded_asset!(app, "edges.wgsl");
    embedded_asset!(app, "hierarchy.wgsl");
    embedded_asset!(app, "sweep.wgsl");
    embedded_asset!(app, "measure.wgsl");
    embedded_asset!(app, "carry.wgsl");
    let status = GpuStatus::default();
    status.set_absent(app.get_sub_app(RenderApp).is_none());
    let counters = SolverCounters::default();
    let watch = BufferWatch::default();
    app.insert_resource(status.clone())
        .insert_resource(counters.clone())
        .insert_resource(watch.clone());
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
        return;
    };
    render_app
        .insert_resource(status)
        .insert_resource(counters)
        .insert_resource(watch)
        .init_resource::<Pending>()
        .init_resource::<Prepared>()
        .add_systems(RenderStartup, init_pipelines)
        .add_systems(ExtractSchedule, extract)
        .add_systems(
            Render,
            (watch_buffers, prepare).in_set(RenderSystems::PrepareBindGroups),
        )
        .add_systems(
            RenderGraph,
            (solve, report)
                .chain()
                .in_set(RenderGraphSystems::Render)
                .in_set(PatternRenderSystems)
                .before(camera_driver),
        );
}

fn extract(mut main: ResMut<MainWorld>, mut pending: ResMut<Pending>, status: Res<GpuStatus>) {
    let Some(mut outbox) = main.get_resource_mut::<Outbox>() else {
        return;
    };
    if !outbox.0.is_empty() {
        pending.push(std::mem::take(&mut outbox.0), &status);
    }
}

/// Uploads what the main world wrote and binds the shared buffers, as soon as all of them are large enough.
fn prepare(
    mut pending: ResMut<Pending>,
    mut prepared: ResMut<Prepared>,
    pipelines: Option<Res<Pipelines>>,
    cache: Res<PipelineCache>,
    buffers: Res<RenderAssets<GpuShaderBuffer>>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    status: Res<GpuStatus>,
) {
    *prepared = Prepared::default();
    let Some(pipelines) = pipelines else { return };
    let compiled = pipelines.compiled(&cache, &status);
    status.set_ready(compiled);
    let Some(needed) = pending.capacities() else { return };
    let Some(gpu) = shared_buffers(&buffers) else { return };
    let large = gpu.iter().zip(needed).all(|(buffer, &needed)| buffer.size() >= needed);
    if !large || (pending.has_steps() && !compiled) {
        return;
    }
    prepared.work = pending.merge(|pool, offset, bytes| queue.write_buffer(&gpu[pool as usize], offset, bytes));
    let Merged {
        steps, items, staged, ..
    } = &prepared.work;
    if steps.is_empty() {
        return;
    }
    let stride = STEP_STRIDE.max(device.limits().min_uniform_buffer_offset_alignment as usize);
    let mut uniforms = vec![0u8; stride * steps.len()];
    for (slot, step) in uniforms.chunks_mut(stride).zip(steps) {
        slot[..size_of::<StepUniform>()].copy_from_slice(bytemuck::bytes_of(&step.uniform));
    }
    let uniforms = device.create_buffer_with_data(&BufferInitDescriptor {
        label: Some("pattern_steps"),
        contents: &uniforms,
        usage: BufferUsages::UNIFORM,
    });
    let work = device.create_buffer(&BufferDescriptor {
        label: Some("pattern_items"),
        size: size_of_val(&**items) as u64,
        usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&work, 0, bytemuck::cast_slice(items));
    let staging = (!staged.is_empty()).then(|| {
        device.create_buffer_with_data(&BufferInitDescriptor {
            label: Some("pattern_staging"),
            contents: staged,
            usage: BufferUsages::COPY_SRC,
        })
    });
    let step = BufferBinding {
        buffer: &uniforms,
        offset: 0,
        size: NonZeroU64::new(size_of::<StepUniform>() as u64),
    };
    let bind_group = |layout| {
        device.create_bind_group(
            "pattern_solver",
            &cache.get_bind_group_layout(layout),
            &BindGroupEntries::sequential((
                step.clone(),
                work.as_entire_buffer_binding(),
                gpu[Pool::Surface as usize].as_entire_buffer_binding(),
                gpu[Pool::Geometry as usize].as_entire_buffer_binding(),
                gpu[Pool::Wave as usize].as_entire_buffer_binding(),
                gpu[Pool::Edges as usize].as_entire_buffer_binding(),
                gpu[Pool::Balance as usize].as_entire_buffer_binding(),
            )),
        )
    };
    prepared.bind_groups = Some(pipelines.layouts.each_ref().map(bind_group));
    prepared.staging = staging.map(|staging| (staging, gpu));
}

/// The shared buffers in the order of [`Pool::ALL`], once all are there.
fn shared_buffers(buffers: &RenderAssets<GpuShaderBuffer>) -> Option<[Buffer; Pool::ALL.len()]> {
    let found: Option<Vec<Buffer>> = Pool::ALL
        .iter()
        .map(|pool| buffers.get(&pool.handle()).map(|buffer| buffer.buffer.clone()))
        .collect();
    found?.try_into().ok()
}

/// Records the dispatches: one compute pass per run of equal stages, so that diagnostics can tell their times. What frames
/// that had to wait have uploaded comes between those of the frame before and their own.
fn solve(
    mut context: RenderContext,
    prepared: Res<Prepared>,
    pipelines: Option<Res<Pipelines>>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
    counters: Res<SolverCounters>,
    buffers: Res<RenderAssets<GpuShaderBuffer>>,
) {
    let Merged {
        steps,
        sweeps,
        pattern_sweeps,
        copies,
        taken,
        ..
    } = &prepared.work;
    counters.set(steps.len() as u32, *sweeps, *pattern_sweeps);
    let (Some(pipelines), Some(bind_groups)) = (pipelines, &prepared.bind_groups) else {
        return;
    };
    let diagnostics = context.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let stride = (STEP_STRIDE as u32).max(device.limits().min_uniform_buffer_offset_alignment);
    let encoder = context.command_encoder();
    let mut copies = copies.iter().peekable();
    let mut taken = taken.iter().peekable();
    let mut first = 0;
    loop {
        while let Some(copy) = copies.next_if(|copy| copy.before == first) {
            if let Some((staging, shared)) = &prepared.staging {
                let len = copy.bytes.end - copy.bytes.start;
                encoder.copy_buffer_to_buffer(staging, copy.bytes.start, &shared[copy.pool as usize], copy.offset, len);
            }
        }
        while let Some((_, copy)) = taken.next_if(|(before, _)| *before == first) {
            let shared = buffers.get(&copy.pool.handle());
            // The main world has looked at it a frame ago.
            let unchanged = |user: &&GpuShaderBuffer| {
                user.buffer.size() == copy.bytes && user.buffer.usage().contains(BufferUsages::COPY_SRC)
            };
            if let (Some(user), Some(shared)) = (buffers.get(copy.buffer).filter(unchanged), shared) {
                encoder.copy_buffer_to_buffer(&user.buffer, 0, &shared.buffer, copy.offset, copy.bytes);
            }
        }
        if first == steps.len() {
            break;
        }
        let stage = stage(steps[first].pass);
        let end = copies.peek().map_or(steps.len(), |copy| copy.before);
        let end = taken.peek().map_or(end, |(before, _)| end.min(*before));
        let len = steps[first..end]
            .iter()
            .take_while(|step| self::stage(step.pass) == stage)
            .count();
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some(stage),
            ..default()
        });
        let span = diagnostics.pass_span(&mut pass, stage);
        for (n, step) in steps.iter().enumerate().skip(first).take(len) {
            let Some(pipeline) = cache.get_compute_pipeline(pipelines.id(step)) else {
                continue;
            };
            let (x, y) = step.workgroups();
            pass.set_pipeline(pipeline);
            let bind_group = &bind_groups[usize::from(step.pass.writes_geometry())];
            pass.set_bind_group(0, bind_group, &[n as u32 * stride]);
            pass.dispatch_workgroups(x, y, 1);
        }
        span.end(&mut pass);
        drop(pass);
        first += len;
    }
}

/// Publishes the last report as diagnostics, in every frame: Bevy keeps the values of one frame only.
fn report(
    mut context: RenderContext,
    prepared: Res<Prepared>,
    buffers: Res<RenderAssets<GpuShaderBuffer>>,
    device: Res<RenderDevice>,
    status: Res<GpuStatus>,
    mut reported: Local<bool>,
) {
    // Without queries of its own, Bevy's recorder reads values from buffers that it has not mapped, and panics.
    let queries = WgpuFeatures::TIMESTAMP_QUERY | WgpuFeatures::PIPELINE_STATISTICS_QUERY;
    let diagnostics = context
        .diagnostic_recorder()
        .filter(|_| device.features().intersects(queries));
    status.set_reports(diagnostics.is_some());
    *reported |= prepared.work.steps.iter().any(|step| step.pass == Pass::Report);
    let Some(balance) = buffers.get(&Pool::Balance.handle()).filter(|_| *reported) else {
        return;
    };
    let diagnostics = diagnostics.as_deref();
    let encoder = context.command_encoder();
    diagnostics.record_f32(encoder, &balance.buffer.slice(0..4), "pattern_energy");
    diagnostics.record_f32(encoder, &balance.buffer.slice(4..8), "pattern_branches");
}
