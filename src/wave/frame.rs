//! What the GPU does in a frame: uploads, and a list of dispatches.
//!
//! [`plan`](super::plan) makes it in the main world, [`render`](super::render) records it in the render world.

use super::{
    arena::Pool,
    layout::{DIRECTION_KINDS, FREQUENCY_KINDS},
};
use crate::arena::Upload;
use bevy::{asset::AssetId, render::storage::ShaderBuffer};
use bytemuck::{Pod, Zeroable};

/// The compute passes; each is an entry point of the same name, and a pipeline for each of its kinds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Pass {
    /// Directions, from wherever they come.
    Directions,
    /// Frequencies, from wherever they come.
    Frequencies,
    /// Edge constants.
    EdgeWeights,
    /// Children's signs and phases against their root.
    Align,
    /// Coarse weights.
    Coarsen,
    /// Sets a top level to 1.
    StartTop,
    /// All small levels of an entity.
    SolveSmall,
    /// Rotates children.
    Prolong,
    /// One colour of the mesh.
    SweepFine,
    /// One colour of a coarse level.
    SweepCoarse,
    /// Hashed phases.
    StartLocal,
    /// One colour of the local rule.
    SweepLocal,
    /// Energy per item.
    EnergyPartial,
    /// Energy per entity.
    EnergyTotal,
    /// End of the local rule.
    Decide,
    /// Branches per item.
    BranchesPartial,
    /// Branches per entity.
    BranchesTotal,
    /// Energy and branches of all patterns.
    Report,
    /// What smoothed fields are drawn to, at the vertices.
    SmoothConstrain,
    /// The same, and smoothed fields as they were.
    SmoothFollow,
    /// What they are drawn to on a coarser level.
    SmoothRestrict,
    /// The top level of smoothed fields.
    SmoothStart,
    /// From a coarser level of smoothed fields.
    SmoothProlong,
    /// One colour of a level of smoothed fields.
    SmoothSweep,
    /// Positions by joints and morph targets.
    PoseVertices,
    /// Normals and areas of posed positions.
    PoseNormals,
    /// Deviators of the shape operator.
    Deviators,
    /// Their measure, per entity.
    Limit,
    /// What takes them along edges.
    Transports,
    /// A step of smoothing.
    SmoothLines,
    /// Another entity's pattern.
    Carry,
}

impl Pass {
    /// All passes, in the order of their discriminants.
    pub(crate) const ALL: [Self; 31] = [
        Self::Directions,
        Self::Frequencies,
        Self::EdgeWeights,
        Self::Align,
        Self::Coarsen,
        Self::StartTop,
        Self::SolveSmall,
        Self::Prolong,
        Self::SweepFine,
        Self::SweepCoarse,
        Self::StartLocal,
        Self::SweepLocal,
        Self::EnergyPartial,
        Self::EnergyTotal,
        Self::Decide,
        Self::BranchesPartial,
        Self::BranchesTotal,
        Self::Report,
        Self::SmoothConstrain,
        Self::SmoothFollow,
        Self::SmoothRestrict,
        Self::SmoothStart,
        Self::SmoothProlong,
        Self::SmoothSweep,
        Self::PoseVertices,
        Self::PoseNormals,
        Self::Deviators,
        Self::Limit,
        Self::Transports,
        Self::SmoothLines,
        Self::Carry,
    ];

    /// Name of the entry point.
    pub(crate) fn entry_point(self) -> &'static str {
        match self {
            Self::Directions => "directions",
            Self::Frequencies => "frequencies",
            Self::EdgeWeights => "edge_weights",
            Self::Align => "align",
            Self::Coarsen => "coarsen",
            Self::StartTop => "start_top",
            Self::SolveSmall => "solve_small",
            Self::Prolong => "prolong",
            Self::SweepFine => "sweep_fine",
            Self::SweepCoarse => "sweep_coarse",
            Self::StartLocal => "start_local",
            Self::SweepLocal => "sweep_local",
            Self::EnergyPartial => "energy_partial",
            Self::EnergyTotal => "energy_total",
            Self::Decide => "decide",
            Self::BranchesPartial => "branches_partial",
            Self::BranchesTotal => "branches_total",
            Self::Report => "report",
            Self::SmoothConstrain => "smooth_constrain",
            Self::SmoothFollow => "smooth_follow",
            Self::SmoothRestrict => "smooth_restrict",
            Self::SmoothStart => "smooth_start",
            Self::SmoothProlong => "smooth_prolong",
            Self::SmoothSweep => "smooth_sweep",
            Self::PoseVertices => "pose_vertices",
            Self::PoseNormals => "pose_normals",
            Self::Deviators => "deviators",
            Self::Limit => "limit",
            Self::Transports => "transports",
            Self::SmoothLines => "smooth_lines",
            Self::Carry => "carry",
        }
    }

    /// Number of its kinds. Each is a pipeline of its own, with the kind as `KIND` in the shader, so that a vertex loads nothing
    /// that it has no use for: for directions and frequencies where they come from, for edges and sweeps one less than the
    /// number of waves, for sweeps of smoothed fields intrinsic and extrinsic ones.
    pub(crate) fn kinds(self) -> u32 {
        match self {
            Self::Directions => DIRECTION_KINDS,
            Self::Frequencies => FREQUENCY_KINDS,
            Self::EdgeWeights | Self::SweepFine | Self::SweepLocal | Self::SmoothSweep => 2,
            _ => 1,
        }
    }

    /// Whether it writes the buffer of positions and normals, which all others read only.
    pub(crate) fn writes_geometry(self) -> bool {
        matches!(self, Self::PoseVertices | Self::PoseNormals)
    }
}

/// `Step` of `passes.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
pub(crate) struct StepUniform {
    pub(crate) first_item: u32,
    pub(crate) item_count: u32,
    pub(crate) row: u32,
    pub(crate) relaxation: u32,
    pub(crate) omega: f32,
    pub(crate) softness: f32,
    pub(crate) level_sweeps: u32,
    pub(crate) momentum: f32,
    pub(crate) epsilon: f32,
    /// 1: phasors stay as they are while children are joined to their parents.
    pub(crate) keep: u32,
    pub(crate) round: u32,
    pub(crate) pad: u32,
}

/// Workgroups per row: below WebGPU's 65,535 per dimension.
pub(super) const ROW: u32 = 32_768;

/// One dispatch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(crate) pass: Pass,
    /// Of the pass's [`kinds`](Pass::kinds).
    pub(crate) kind: u32,
    pub(crate) uniform: StepUniform,
}

impl Step {
    pub(crate) fn workgroups(&self) -> (u32, u32) {
        match self.pass {
            Pass::Report => (1, 1),
            _ => (self.uniform.item_count.min(ROW), self.uniform.item_count.div_ceil(ROW)),
        }
    }
}

/// The content of a user's buffer, which goes to a shared one before the steps of its frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BufferCopy {
    pub(crate) buffer: AssetId<ShaderBuffer>,
    pub(crate) pool: Pool,
    /// Bytes into the shared buffer.
    pub(crate) offset: u64,
    /// All of the user's buffer.
    pub(crate) bytes: u64,
}

/// All that the GPU does for patterns in one frame.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    /// The generation of the device that it was made for.
    pub(crate) generation: u32,
    /// Bytes that the shared buffers must have.
    pub(crate) capacities: Vec<u64>,
    pub(crate) uploads: Vec<Upload<Pool>>,
    pub(crate) copies: Vec<BufferCopy>,
    /// (record, level, first node, end node).
    pub(crate) items: Vec<[u32; 4]>,
    pub(crate) steps: Vec<Step>,
    /// Sweeps over the mesh.
    pub(crate) sweeps: u32,
    /// The same, each counted once per pattern that takes part.
    pub(crate) pattern_sweeps: u32,
    /// The same, each counted once per vertex.
    pub(crate) node_sweeps: u64,
}

impl Frame {
    pub(crate) fn is_empty(&self) -> bool {
        self.uploads.is_empty() && self.steps.is_empty()
    }

    /// Bytes that it takes while it waits, of the things that can be many.
    pub(crate) fn bytes(&self) -> u64 {
        let uploads: usize = self.uploads.iter().map(|upload| upload.bytes.len()).sum();
        (uploads + size_of_val(&*self.items) + size_of_val(&*self.steps)) as u64
    }
}
