//! The solver in the render world: pipelines, uploads and dispatches.
//!
//! In: the [`Frame`] of the main world. Out: phasors in the shared buffers, before any camera draws.

use super::{
    arena::Pool,
    pack::ITEM,
    patterns::Outbox,
    pending::{Merged, Pending},
    plan::{Pass, StepUniform},
};
use crate::{arena::Pool as _, error::PatternError};
use bevy::{
    asset::{embedded_asset, load_embedded_asset},
    core_pipeline::schedule::camera_driver,
    prelude::*,
    render::{
        MainWorld, Render, RenderApp, RenderStartup, RenderSystems,
        diagnostic::RecordDiagnostics,
        render_asset::RenderAssets,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, Buffer, BufferBinding,
            BufferDescriptor, BufferInitDescriptor, BufferUsages, CachedComputePipelineId, CachedPipelineState,
            ComputePassDescriptor, ComputePipelineDescriptor, PipelineCache, ShaderStages,
            binding_types::{storage_buffer_read_only_sized, storage_buffer_sized, uniform_buffer_sized},
        },
        renderer::{RenderAdapterInfo, RenderContext, RenderDevice, RenderGraph, RenderGraphSystems, RenderQueue},
        settings::WgpuFeatures,
        storage::GpuShaderBuffer,
    },
};
use std::{
    num::NonZeroU64,
    sync::{
        Arc, PoisonError, RwLock,
        atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
    },
};

/// What the main world knows of the GPU.
#[derive(Resource, Clone, Default)]
pub(crate) struct GpuStatus(Arc<Status>);

#[derive(Default)]
struct Status {
    absent: AtomicBool,
    ready: AtomicBool,
    reports: AtomicBool,
    generation: AtomicU32,
    item: AtomicU32,
    error: RwLock<Option<PatternError>>,
}

impl GpuStatus {
    /// The app renders nothing.
    pub(crate) fn is_absent(&self) -> bool {
        self.0.absent.load(Relaxed)
    }

    /// All pipelines are compiled.
    pub(crate) fn is_ready(&self) -> bool {
        self.0.ready.load(Relaxed)
    }

    /// Somebody reads diagnostics.
    pub(crate) fn reports(&self) -> bool {
        self.0.reports.load(Relaxed)
    }

    /// Nodes of one item of work. A processor that plays GPU spends more on starting a thread than on a node.
    pub(crate) fn item(&self) -> u32 {
        self.0.item.load(Relaxed).max(ITEM)
    }

    /// Counts the devices so far; what was on an earlier one is lost.
    pub(crate) fn generation(&self) -> u32 {
        self.0.generation.load(Relaxed)
    }

    /// What was on the GPU does not count any more.
    pub(super) fn begin_generation(&self) {
        self.0.generation.fetch_add(1, Relaxed);
    }

    /// Why the GPU cannot solve.
    pub(crate) fn error(&self) -> Option<PatternError> {
        self.0.error.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn set_error(&self, error: PatternError) {
        self.0
            .error
            .write()
            .unwrap_or_else(PoisonError::into_inner)
            .get_or_insert(error);
    }
}

/// Counts what the solver does; read it to see that a pattern sleeps.
#[derive(Resource, Clone, Default)]
pub struct SolverCounters(Arc<Counters>);

#[derive(Default)]
struct Counters {
    dispatches: AtomicU32,
    sweeps: AtomicU32,
}

impl SolverCounters {
    /// Dispatches of the last frame.
    pub fn dispatches(&self) -> u32 {
        self.0.dispatches.load(Relaxed)
    }

    /// Sweeps over the mesh in the last frame.
    pub fn sweeps(&self) -> u32 {
        self.0.sweeps.load(Relaxed)
    }
}

/// The dispatches of this frame, ready to be recorded.
#[derive(Resource, Default)]
struct Prepared {
    work: Merged,
    bind_group: Option<BindGroup>,
    /// The bytes of the copies between steps, and the shared buffers that get them.
    staging: Option<(Buffer, [Buffer; Pool::ALL.len()])>,
}

#[derive(Resource)]
struct Pipelines {
    layout: BindGroupLayoutDescriptor,
    ids: [CachedComputePipelineId; Pass::ALL.len()],
}

/// Bytes from one step's uniform to the next: WebGPU's largest alignment of a dynamic offset.
const STEP_STRIDE: usize = 256;

pub(crate) fn build(app: &mut App) {
    embedded_asset!(app, "passes.wgsl");
    embedded_asset!(app, "field.wgsl");
    embedded_asset!(app, "edges.wgsl");
    embedded_asset!(app, "hierarchy.wgsl");
    embedded_asset!(app, "sweep.wgsl");
    embedded_asset!(app, "measure.wgsl");
    let status = GpuStatus::default();
    status.0.absent.store(app.get_sub_app(RenderApp).is_none(), Relaxed);
    let counters = SolverCounters::default();
    app.insert_resource(status.clone()).insert_resource(counters.clone());
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
        return;
    };
    render_app
        .insert_resource(status)
        .insert_resource(counters)
        .init_resource::<Pending>()
        .init_resource::<Prepared>()
        .add_systems(RenderStartup, init_pipelines)
        .add_systems(ExtractSchedule, extract)
        .add_systems(Render, prepare.in_set(RenderSystems::PrepareBindGroups))
        .add_systems(
            RenderGraph,
            (solve, report)
                .chain()
                .in_set(RenderGraphSystems::Render)
                .before(camera_driver),
        );
}

fn init_pipelines(
    mut commands: Commands,
    assets: Res<AssetServer>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
    adapter: Res<RenderAdapterInfo>,
    status: Res<GpuStatus>,
) {
    status.0.item.store(
        if adapter.device_type == wgpu::DeviceType::Cpu {
            8 * ITEM
        } else {
            ITEM
        },
        Relaxed,
    );
    status.begin_generation();
    status.0.ready.store(false, Relaxed);
    if let Some(error) = missing_limit(&device) {
        status.set_error(error);
        return;
    }
    let storage = || storage_buffer_sized(false, None);
    let read_only = || storage_buffer_read_only_sized(false, None);
    let step = uniform_buffer_sized(true, NonZeroU64::new(size_of::<StepUniform>() as u64));
    let layout = BindGroupLayoutDescriptor::new(
        "pattern_solver",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                step,
                read_only(),
                read_only(),
                read_only(),
                storage(),
                storage(),
                storage(),
            ),
        ),
    );
    // The shaders import it by name.
    commands.insert_resource(PassLibrary(load_embedded_asset!(&*assets, "passes.wgsl")));
    let ids = Pass::ALL.map(|pass| {
        let shader = match pass {
            Pass::ProjectAxis | Pass::TakeDirections => load_embedded_asset!(&*assets, "field.wgsl"),
            Pass::EdgeWeights => load_embedded_asset!(&*assets, "edges.wgsl"),
            Pass::Align | Pass::Coarsen | Pass::StartTop | Pass::SolveSmall | Pass::Prolong | Pass::SweepCoarse => {
                load_embedded_asset!(&*assets, "hierarchy.wgsl")
            }
            Pass::SweepFine | Pass::StartLocal | Pass::SweepLocal => load_embedded_asset!(&*assets, "sweep.wgsl"),
            Pass::EnergyPartial
            | Pass::EnergyTotal
            | Pass::Decide
            | Pass::BranchesPartial
            | Pass::BranchesTotal
            | Pass::Report => load_embedded_asset!(&*assets, "measure.wgsl"),
        };
        cache.queue_compute_pipeline(ComputePipelineDescriptor {
            label: Some(pass.entry_point().into()),
            layout: vec![layout.clone()],
            shader,
            entry_point: Some(pass.entry_point().into()),
            ..default()
        })
    });
    commands.insert_resource(Pipelines { layout, ids });
}

/// Keeps the shader library loaded.
#[derive(Resource)]
struct PassLibrary(#[expect(dead_code, reason = "holding the handle is its use")] Handle<Shader>);

/// The first limit of the device that is below what the solver needs.
fn missing_limit(device: &RenderDevice) -> Option<PatternError> {
    let limits = device.limits();
    let needs: [(&'static str, u32, u32); 4] = [
        (
            "max_storage_buffers_per_shader_stage",
            limits.max_storage_buffers_per_shader_stage,
            6,
        ),
        (
            "max_compute_invocations_per_workgroup",
            limits.max_compute_invocations_per_workgroup,
            256,
        ),
        ("max_compute_workgroup_size_x", limits.max_compute_workgroup_size_x, 256),
        (
            "max_compute_workgroups_per_dimension",
            limits.max_compute_workgroups_per_dimension,
            32_768,
        ),
    ];
    needs
        .into_iter()
        .find(|(_, found, needed)| found < needed)
        .map(|(limit, found, needed)| PatternError::GpuLimit {
            limit,
            found: found.into(),
            needed: needed.into(),
        })
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
    let mut compiled = true;
    for id in pipelines.ids {
        match cache.get_compute_pipeline_state(id) {
            CachedPipelineState::Ok(_) => {}
            CachedPipelineState::Err(error) => {
                compiled = false;
                let compiling = format!("{error:?}");
                if !compiling.contains("ShaderNotLoaded") && !compiling.contains("ShaderImportNotYetAvailable") {
                    status.set_error(PatternError::Pipeline(error.to_string()));
                }
            }
            _ => compiled = false,
        }
    }
    status.0.ready.store(compiled, Relaxed);
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
    prepared.bind_group = Some(device.create_bind_group(
        "pattern_solver",
        &cache.get_bind_group_layout(&pipelines.layout),
        &BindGroupEntries::sequential((
            step,
            work.as_entire_buffer_binding(),
            gpu[Pool::Surface as usize].as_entire_buffer_binding(),
            gpu[Pool::Geometry as usize].as_entire_buffer_binding(),
            gpu[Pool::Wave as usize].as_entire_buffer_binding(),
            gpu[Pool::Edges as usize].as_entire_buffer_binding(),
            gpu[Pool::Balance as usize].as_entire_buffer_binding(),
        )),
    ));
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
) {
    let Merged {
        steps, sweeps, copies, ..
    } = &prepared.work;
    counters.0.dispatches.store(steps.len() as u32, Relaxed);
    counters.0.sweeps.store(*sweeps, Relaxed);
    let (Some(pipelines), Some(bind_group)) = (pipelines, &prepared.bind_group) else {
        return;
    };
    let diagnostics = context.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let stride = (STEP_STRIDE as u32).max(device.limits().min_uniform_buffer_offset_alignment);
    let encoder = context.command_encoder();
    let mut copies = copies.iter().peekable();
    let mut first = 0;
    loop {
        while let Some(copy) = copies.next_if(|copy| copy.before == first) {
            if let Some((staging, shared)) = &prepared.staging {
                let len = copy.bytes.end - copy.bytes.start;
                encoder.copy_buffer_to_buffer(staging, copy.bytes.start, &shared[copy.pool as usize], copy.offset, len);
            }
        }
        if first == steps.len() {
            break;
        }
        let stage = stage(steps[first].pass);
        let end = copies.peek().map_or(steps.len(), |copy| copy.before);
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
            let Some(pipeline) = cache.get_compute_pipeline(pipelines.ids[step.pass as usize]) else {
                continue;
            };
            let (x, y) = step.workgroups();
            pass.set_pipeline(pipeline);
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
    status.0.reports.store(diagnostics.is_some(), Relaxed);
    *reported |= prepared.work.steps.iter().any(|step| step.pass == Pass::Report);
    let Some(balance) = buffers.get(&Pool::Balance.handle()).filter(|_| *reported) else {
        return;
    };
    let diagnostics = diagnostics.as_deref();
    let encoder = context.command_encoder();
    diagnostics.record_f32(encoder, &balance.buffer.slice(0..4), "pattern_energy");
    diagnostics.record_f32(encoder, &balance.buffer.slice(4..8), "pattern_branches");
}

/// The name under which a pass's time is reported.
fn stage(pass: Pass) -> &'static str {
    match pass {
        Pass::ProjectAxis | Pass::TakeDirections => "pattern_field",
        Pass::EdgeWeights => "pattern_edges",
        Pass::Align | Pass::Coarsen | Pass::StartTop | Pass::SolveSmall | Pass::Prolong | Pass::SweepCoarse => {
            "pattern_hierarchy"
        }
        Pass::SweepFine
        | Pass::StartLocal
        | Pass::SweepLocal
        | Pass::EnergyPartial
        | Pass::EnergyTotal
        | Pass::Decide => "pattern_sweeps",
        Pass::BranchesPartial | Pass::BranchesTotal | Pass::Report => "pattern_report",
    }
}
