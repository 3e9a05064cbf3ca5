//! The solver's compute pipelines.
//!
//! In: a device. Out: one pipeline per kind of [`Pass`], or what the device lacks.

use super::{
    frame::{Pass, Step, StepUniform},
    pack::ITEM,
    status::GpuStatus,
};
use crate::error::PatternError;
use bevy::{
    asset::load_embedded_asset,
    prelude::*,
    render::{
        render_resource::{
            BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedComputePipelineId, CachedPipelineState,
            ComputePipelineDescriptor, PipelineCache, ShaderStages,
            binding_types::{storage_buffer_read_only_sized, storage_buffer_sized, uniform_buffer_sized},
        },
        renderer::{RenderAdapterInfo, RenderDevice},
    },
    shader::ShaderDefVal,
};
use std::num::NonZeroU64;

/// The passes, compiled or being compiled.
#[derive(Resource)]
pub(super) struct Pipelines {
    /// Of all passes, and of those that write positions and normals.
    pub(super) layouts: [BindGroupLayoutDescriptor; 2],
    /// Of each pass those of its kinds.
    ids: [Vec<CachedComputePipelineId>; Pass::ALL.len()],
}

impl Pipelines {
    /// The pipeline of a step.
    pub(super) fn id(&self, step: &Step) -> CachedComputePipelineId {
        self.ids[step.pass as usize][step.kind as usize]
    }

    /// Whether all of them can be used. What does not compile is told to the main world.
    pub(super) fn compiled(&self, cache: &PipelineCache, status: &GpuStatus) -> bool {
        let mut compiled = true;
        for &id in self.ids.iter().flatten() {
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
        compiled
    }
}

pub(super) fn init_pipelines(
    mut commands: Commands,
    assets: Res<AssetServer>,
    cache: Res<PipelineCache>,
    device: Res<RenderDevice>,
    adapter: Res<RenderAdapterInfo>,
    status: Res<GpuStatus>,
) {
    status.set_item(if adapter.device_type == wgpu::DeviceType::Cpu {
        8 * ITEM
    } else {
        ITEM
    });
    status.begin_generation();
    status.set_ready(false);
    if let Some(error) = missing_limit(&device) {
        status.set_error(error);
        return;
    }
    let storage = || storage_buffer_sized(false, None);
    let read_only = || storage_buffer_read_only_sized(false, None);
    let step = uniform_buffer_sized(true, NonZeroU64::new(size_of::<StepUniform>() as u64));
    let layouts = [("pattern_solver", read_only()), ("pattern_pose", storage())].map(|(label, geometry)| {
        let entries = (
            step,
            read_only(),
            read_only(),
            geometry,
            storage(),
            storage(),
            storage(),
        );
        BindGroupLayoutDescriptor::new(
            label,
            &BindGroupLayoutEntries::sequential(ShaderStages::COMPUTE, entries),
        )
    });
    // The shaders import it by name.
    commands.insert_resource(PassLibraries([
        load_embedded_asset!(&*assets, "passes.wgsl"),
        load_embedded_asset!(&*assets, "field/tangent.wgsl"),
        load_embedded_asset!(&*assets, "field/parameters.wgsl"),
        load_embedded_asset!(&*assets, "field/vortices.wgsl"),
        load_embedded_asset!(&*assets, "field/tensor.wgsl"),
        load_embedded_asset!(&*assets, "field/cross.wgsl"),
        load_embedded_asset!(&*assets, "pose/deform.wgsl"),
    ]));
    let ids = Pass::ALL.map(|pass| {
        let shader = match pass {
            Pass::SmoothConstrain
            | Pass::SmoothFollow
            | Pass::SmoothRestrict
            | Pass::SmoothStart
            | Pass::SmoothProlong
            | Pass::SmoothSweep => load_embedded_asset!(&*assets, "field/smooth.wgsl"),
            Pass::Directions => load_embedded_asset!(&*assets, "field/directions.wgsl"),
            Pass::Frequencies => load_embedded_asset!(&*assets, "field/frequencies.wgsl"),
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
            Pass::Carry => load_embedded_asset!(&*assets, "carry.wgsl"),
            Pass::PoseVertices | Pass::PoseNormals => load_embedded_asset!(&*assets, "pose/pose.wgsl"),
            Pass::Limit => load_embedded_asset!(&*assets, "pose/limit.wgsl"),
            Pass::Deviators | Pass::Transports | Pass::SmoothLines => {
                load_embedded_asset!(&*assets, "pose/curvature.wgsl")
            }
        };
        let queue = |kind| {
            cache.queue_compute_pipeline(ComputePipelineDescriptor {
                label: Some(pass.entry_point().into()),
                layout: vec![layouts[usize::from(pass.writes_geometry())].clone()],
                shader: shader.clone(),
                shader_defs: vec![ShaderDefVal::UInt("KIND".into(), kind)],
                entry_point: Some(pass.entry_point().into()),
                ..default()
            })
        };
        (0..pass.kinds()).map(queue).collect()
    });
    commands.insert_resource(Pipelines { layouts, ids });
}

/// Keeps the shader libraries loaded.
#[derive(Resource)]
struct PassLibraries(#[expect(dead_code, reason = "holding the handles is its use")] [Handle<Shader>; 7]);

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

/// The name under which a pass's time is reported.
pub(super) fn stage(pass: Pass) -> &'static str {
    match pass {
        Pass::Directions
        | Pass::Frequencies
        | Pass::SmoothConstrain
        | Pass::SmoothFollow
        | Pass::SmoothRestrict
        | Pass::SmoothStart
        | Pass::SmoothProlong
        | Pass::SmoothSweep
        | Pass::Deviators
        | Pass::Limit
        | Pass::Transports
        | Pass::SmoothLines => "pattern_field",
        Pass::PoseVertices | Pass::PoseNormals => "pattern_pose",
        Pass::EdgeWeights => "pattern_edges",
        Pass::Carry => "pattern_carry",
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
