//! Patterns on surfaces that move.
//!
//! In: the pose of an entity. Out: its pose in the shared buffers whenever it has changed; all else is done on the GPU.

use super::{PatternedItem, Tools};
use crate::{
    error::PatternError,
    surface::{Surface, SurfaceGraph},
    wave::{
        arena::{PatternArena, Pool},
        layout::PoseRecord,
        pack::{PackedGraph, PatternRanges},
        pose::{Extent, PackedRig, PatternPose, Pose},
    },
};
use bevy::{math::Affine3A, prelude::*};
use std::sync::Arc;

const POSE_WORDS: u32 = (size_of::<PoseRecord>() / 4) as u32;

/// What an entity needs to be posed.
#[derive(Clone)]
pub(super) struct Rigged {
    rig: Arc<PackedRig>,
    skinned: bool,
    pose: Pose,
}

impl Rigged {
    /// That of an entity with [`PatternPose::Live`].
    pub(super) fn of(
        item: &PatternedItem,
        surface: &Surface,
        mesh: AssetId<Mesh>,
        in_world: bool,
        tools: &mut Tools,
    ) -> Result<Option<Self>, PatternError> {
        if item.pose.as_ref().is_none_or(|pose| **pose == PatternPose::Rest) {
            return Ok(None);
        }
        let graph = tools.graphs.get(&surface.graph).ok_or(PatternError::MeshDataTaken)?;
        if graph.is_cloud() {
            return Err(PatternError::LiveCloud);
        }
        let source = tools.meshes.get(mesh);
        let rig = tools.rigs.pack(surface, mesh, source, graph, &mut tools.arena)?;
        let skin = item.skin.filter(|skin| rig.skin_base != 0 && !skin.joints.is_empty());
        let transform = item.transform.map_or(Affine3A::IDENTITY, GlobalTransform::affine);
        let targets = rig.targets as usize;
        let pose = tools.skeletons.pose(skin, item.morph, transform, in_world, targets)?;
        Ok(Some(Self {
            skinned: skin.is_some(),
            rig,
            pose,
        }))
    }
}

/// How a pose differs from the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Motion {
    /// Not at all.
    None,
    /// The pattern can follow.
    Small,
    /// The pattern is solved anew.
    Jump,
}

/// A pattern's surface as it moves.
pub(super) struct Live {
    rig: Arc<PackedRig>,
    skinned: bool,
    /// Word of the surface buffer where its record lies.
    base: u32,
    /// Element of the geometry buffer where the pose lies.
    matrix_base: u32,
    /// As uploaded last.
    pose: Pose,
    /// Of the mesh at rest.
    extent: Extent,
}

impl Live {
    /// Takes an entity's memory for its pose.
    pub(super) fn new(
        rigged: Rigged,
        graph: &PackedGraph,
        ranges: &mut PatternRanges,
        arena: &mut PatternArena,
    ) -> Result<Self, PatternError> {
        let Rigged { rig, skinned, pose } = rigged;
        let (joints, targets) = (pose.matrices.len() as u32, pose.weights.len() as u32);
        let base = ranges.take(arena, Pool::Surface, POSE_WORDS)?;
        let matrix_base = ranges.take(arena, Pool::Geometry, 3 * joints + targets)?;
        let record = PoseRecord {
            joints,
            targets,
            matrix_base,
            skin_base: if skinned { rig.skin_base } else { 0 },
            target_base: rig.target_base,
            rest_base: graph.geometry.start,
            position_base: ranges.take(arena, Pool::Geometry, graph.vertices)?,
            fan_offset_base: rig.fan_offset_base,
            fan_base: rig.fan_base,
            ..PoseRecord::default()
        };
        arena.write(Pool::Surface, base, &[record]);
        Ok(Self {
            rig,
            skinned,
            base,
            matrix_base,
            pose,
            extent: Extent::default(),
        })
    }

    pub(super) fn base(&self) -> u32 {
        self.base
    }

    /// Whether another pose fits into the same memory.
    pub(super) fn fits(&self, rigged: &Rigged) -> bool {
        Arc::ptr_eq(&self.rig, &rigged.rig)
            && self.skinned == rigged.skinned
            && self.pose.matrices.len() == rigged.pose.matrices.len()
            && self.pose.weights.len() == rigged.pose.weights.len()
    }

    /// Uploads a pose if it is another one; how much it is. `reshaped`: the mesh at rest is another one.
    pub(super) fn update(
        &mut self,
        rigged: Rigged,
        reshaped: bool,
        graph: Option<&SurfaceGraph>,
        arena: &mut PatternArena,
    ) -> Motion {
        if reshaped {
            self.extent = graph.map_or(Extent::default(), |graph| Extent::of(&graph.positions));
        }
        if !reshaped && self.pose.is_near(&rigged.pose, self.extent.half) {
            return Motion::None;
        }
        let jumps = rigged.pose.jumps(&self.pose, &self.extent);
        self.pose = rigged.pose;
        arena.write(Pool::Geometry, self.matrix_base, &self.pose.elements());
        if jumps { Motion::Jump } else { Motion::Small }
    }
}
