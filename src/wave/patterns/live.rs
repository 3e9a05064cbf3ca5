//! Patterns on surfaces that move.
//!
//! In: an entity's pose, field and frequency. Out: its pose in the shared buffers whenever it has changed, and once what its
//! directions are made from. All else is done on the GPU.

use super::{
    Changed, Inputs, Pattern, PatternedItem, Phase, Tools,
    inputs::{check_turn, check_uniform},
};
use crate::{
    error::PatternError,
    field::{DirectionField, Frequency, Principal, directions, frequencies},
    surface::{Surface, SurfaceGraph},
    wave::{
        arena::{PatternArena, Pool},
        layout::{FLAG_AXIS, POSE_AXIS, POSE_MINOR, PoseRecord},
        pack::{PackedGraph, PatternRanges},
        pose::{PackedRig, PatternPose, Pose, Posed},
    },
};
use bevy::{math::Affine3A, prelude::*};
use std::{f32::consts::FRAC_PI_2, sync::Arc};

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
        let Some(graph) = tools.graphs.get(&surface.graph) else {
            return Err(PatternError::MeshDataTaken);
        };
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

/// A pattern's surface as it moves.
pub(super) struct Live {
    rig: Arc<PackedRig>,
    record: PoseRecord,
    /// Word of the surface buffer where the record lies.
    base: u32,
    /// As uploaded last.
    pose: Pose,
    /// Half the diagonal of the mesh.
    size: f32,
    curvature: bool,
}

impl Live {
    /// Takes an entity's ranges for its pose.
    pub(super) fn new(
        rigged: Rigged,
        graph: &PackedGraph,
        ranges: &mut PatternRanges,
        arena: &mut PatternArena,
    ) -> Result<Self, PatternError> {
        let Rigged { rig, skinned, pose } = rigged;
        let (joints, targets) = (pose.matrices.len() as u32, pose.weights.len() as u32);
        let base = ranges.take(arena, Pool::Surface, POSE_WORDS + 12 * joints + targets)?;
        let record = PoseRecord {
            joints,
            targets,
            skin_base: if skinned { rig.skin_base } else { 0 },
            target_base: rig.target_base,
            rest_base: graph.geometry.start,
            corner_offset_base: rig.corner_offset_base,
            corner_base: rig.corner_base,
            field_base: ranges.take(arena, Pool::Wave, 2 * graph.vertices)?,
            ..PoseRecord::default()
        };
        Ok(Self {
            rig,
            record,
            base,
            pose,
            size: 0.0,
            curvature: false,
        })
    }

    pub(super) fn base(&self) -> u32 {
        self.base
    }

    /// Whether another pose fits into the same memory.
    pub(super) fn fits(&self, rigged: &Rigged) -> bool {
        Arc::ptr_eq(&self.rig, &rigged.rig)
            && (self.record.skin_base != 0) == rigged.skinned
            && self.pose.matrices.len() == rigged.pose.matrices.len()
            && self.pose.weights.len() == rigged.pose.weights.len()
    }
}

impl Pattern {
    /// Its part in what the GPU does for surfaces that have moved.
    pub(super) fn posed(&self) -> Option<Posed> {
        let live = self.live.as_ref()?;
        Some(Posed {
            member: self.member(),
            curvature: live.curvature.then_some(live.record.smoothing),
            carried: !live.curvature && self.record.flags & FLAG_AXIS == 0,
        })
    }
}

/// Uploads the pose if it has changed, and what directions are made from if that has.
pub(super) fn update_live(
    pattern: &mut Pattern,
    item: &PatternedItem,
    surface: &Surface,
    inputs: Inputs,
    mesh: AssetId<Mesh>,
    tools: &mut Tools,
    Rigged { pose, .. }: Rigged,
    fresh: bool,
) -> Result<Changed, PatternError> {
    let Some(live) = pattern.live.as_mut() else {
        return Ok(Changed::Nothing);
    };
    let Some(graph) = tools.graphs.get(&surface.graph) else {
        return Ok(Changed::Waiting);
    };
    let reshaped = fresh || pattern.geometry != surface.geometry;
    let refielded = reshaped
        || pattern.phase == Phase::Waiting
        || pattern.inputs != inputs
        || item.field.is_changed()
        || item.frequency.is_changed();
    if reshaped {
        live.size = half_diagonal(&graph.positions);
    }
    let moved = reshaped || !live.pose.is_near(&pose, live.size);
    pattern.geometry = surface.geometry;
    pattern.inputs = inputs;
    if !moved && !refielded {
        return Ok(Changed::Nothing);
    }
    if moved {
        live.pose = pose;
        let words = live.pose.words();
        tools.arena.write(Pool::Surface, live.base + POSE_WORDS, &words);
    }
    if refielded {
        let source = tools.meshes.get(mesh);
        update_field(pattern, item, inputs, graph, source, &mut tools.arena)?;
    } else {
        let axis = pattern.record.flags & FLAG_AXIS;
        pattern.begin_directions(pattern.symmetry());
        pattern.record.flags |= axis;
    }
    pattern.write_record(&mut tools.arena);
    if pattern.phase == Phase::Waiting {
        pattern.phase = Phase::Cold;
    }
    Ok(Changed::Inputs)
}

/// Tells the GPU what directions are made from.
fn update_field(
    pattern: &mut Pattern,
    item: &PatternedItem,
    inputs: Inputs,
    graph: &SurfaceGraph,
    mesh: Option<&Mesh>,
    arena: &mut PatternArena,
) -> Result<(), PatternError> {
    let (field, symmetry) = (&*item.field, inputs.symmetry);
    check_turn(inputs.turn)?;
    let mut turn = inputs.turn;
    let (mut flags, mut axis, mut smoothing) = (0, None, None);
    let mut at_rest = Vec::new();
    if let DirectionField::Axis(direction) = *field {
        check_uniform(direction, 0.0, inputs.turn)?;
        axis = Some(direction);
    }
    let uniform = match (axis, &*item.frequency) {
        (Some(axis), Frequency::Uniform(f)) => {
            check_uniform(axis, *f, inputs.turn)?;
            Some(*f)
        }
        _ => None,
    };
    if uniform.is_none() {
        let source = mesh.ok_or(PatternError::MeshDataTaken)?;
        let given = match field {
            DirectionField::Axis(axis) => {
                flags |= POSE_AXIS;
                vec![**axis; graph.len()]
            }
            DirectionField::PrincipalCurvature {
                direction,
                smoothing: steps,
            } => {
                smoothing = Some(*steps);
                flags |= if *direction == Principal::Minor { POSE_MINOR } else { 0 };
                vec![Vec3::ZERO; graph.len()]
            }
            // Contour lines are carried along by a deformation; the gradient is across them.
            DirectionField::Gradient {
                attribute,
                quarter_turn,
            } => {
                turn -= if *quarter_turn { 0.0 } else { FRAC_PI_2 };
                let contours = DirectionField::Gradient {
                    attribute: *attribute,
                    quarter_turn: true,
                };
                directions(&contours, symmetry, 0.0, graph, source)?
            }
            _ => directions(field, symmetry, 0.0, graph, source)?,
        };
        let frequencies = frequencies(&item.frequency, graph, source)?;
        at_rest = given.iter().zip(&frequencies).map(|(d, &f)| d.extend(f)).collect();
    }
    let Some(live) = pattern.live.as_mut() else {
        return Ok(());
    };
    live.curvature = smoothing.is_some();
    live.record.smoothing = smoothing.unwrap_or(0);
    live.record.flags = flags;
    arena.write(Pool::Surface, live.base, &[live.record]);
    arena.write(Pool::Wave, live.record.field_base, &at_rest);
    pattern.begin_directions(symmetry);
    pattern.record.turn = turn;
    if let (Some(axis), Some(frequency)) = (axis, uniform) {
        pattern.record.flags |= FLAG_AXIS;
        pattern.record.axis = axis.to_array();
        pattern.record.frequency = frequency;
    }
    Ok(())
}

fn half_diagonal(positions: &[Vec3]) -> f32 {
    let (low, high) = positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| {
            (low.min(p), high.max(p))
        });
    0.5 * (high - low).length()
}
