//! The inputs of a pattern: directions, frequencies and, in the world's space, positions.
//!
//! In: an entity's field and frequency, and the graph. Out: uploads, as soon as something has changed. What takes long
//! (curvature) is computed off the main thread; meanwhile the old field is drawn.

use super::{Changed, Directions, Inputs, Pattern, PatternedItem, Phase, Tools};
use crate::{
    error::PatternError,
    field::{DirectionField, Frequency, Symmetry, directions, frequencies, project_tangent},
    surface::{Surface, SurfaceGraph},
    wave::{
        arena::Pool,
        layout::{FLAG_AXIS, FLAG_FOLLOW, FLAG_VECTOR},
        pack::geometry,
    },
};
use bevy::{
    math::Mat3A,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};

impl Pattern {
    /// That of the directions in use, which is not the entity's while new ones are being computed.
    pub(super) fn symmetry(&self) -> Symmetry {
        if self.record.flags & FLAG_VECTOR != 0 {
            Symmetry::Vector
        } else {
            Symmetry::Line
        }
    }

    /// Other directions come into use. They follow those before where phasors refer to these.
    pub(super) fn begin_directions(&mut self, symmetry: Symmetry) {
        if symmetry != self.symmetry() && self.phase != Phase::Waiting {
            // The phasors of lines and of vectors mean different things.
            self.phase = Phase::Cold;
        }
        self.record.flags &= !(FLAG_VECTOR | FLAG_AXIS | FLAG_FOLLOW);
        if symmetry == Symmetry::Vector {
            self.record.flags |= FLAG_VECTOR;
        }
        if matches!(self.phase, Phase::Warm(_) | Phase::Asleep) {
            self.record.flags |= FLAG_FOLLOW;
        }
    }
}

/// Computes and uploads whatever has changed of directions, frequencies and positions.
pub(super) fn update_inputs(
    pattern: &mut Pattern,
    item: &PatternedItem,
    surface: &Surface,
    inputs: Inputs,
    mesh: AssetId<Mesh>,
    tools: &mut Tools,
    fresh: bool,
) -> Result<Changed, PatternError> {
    let moved = fresh || pattern.geometry != surface.geometry || pattern.inputs.linear != inputs.linear;
    let turned = moved || item.field.is_changed() || pattern.inputs != inputs;
    let uniform = match (&*item.field, &*item.frequency) {
        (DirectionField::Axis(axis), Frequency::Uniform(f)) => Some((*axis, *f)),
        _ => None,
    };
    pattern.geometry = surface.geometry;
    pattern.inputs = inputs;
    let waits = pattern.phase == Phase::Waiting;
    if !turned && !item.frequency.is_changed() && pattern.task.is_none() && !waits {
        return Ok(Changed::Nothing);
    }
    let Some(graph) = tools.graphs.get(&surface.graph) else {
        return Ok(Changed::Waiting);
    };
    if moved && let (Some(linear), Some(first)) = (inputs.linear, pattern.ranges.geometry) {
        let (positions, normals) = in_world(graph, linear);
        tools
            .arena
            .write(Pool::Geometry, first, &geometry(graph, &positions, &normals));
    }
    if let Some((axis, frequency)) = uniform {
        check_uniform(axis, frequency, inputs.turn)?;
        pattern.task = None;
        pattern.directions.clear();
        pattern.uploaded = false;
        pattern.begin_directions(inputs.symmetry);
        pattern.record.flags |= FLAG_AXIS;
        pattern.record.axis = axis.to_array();
        pattern.record.frequency = frequency;
        pattern.record.turn = inputs.turn;
        pattern.write_record(&mut tools.arena);
        if pattern.phase == Phase::Waiting {
            pattern.phase = Phase::Cold;
        }
        return Ok(Changed::Inputs);
    }
    let slow = matches!(*item.field, DirectionField::PrincipalCurvature { .. });
    let mut new = None;
    if turned || pattern.directions.is_empty() {
        let source = tools.meshes.get(mesh).ok_or(PatternError::MeshDataTaken)?;
        if slow {
            // A computation that has begun is finished, so that a field that changes in every frame is seen to.
            pattern.outdated |= pattern.task.is_some() && turned;
            let start = || compute_directions(DirectionField::clone(&item.field), inputs, graph.clone());
            pattern.task.get_or_insert_with(start);
        } else {
            pattern.task = None;
            new = Some(Directions {
                vectors: directions_in(&item.field, inputs, graph, source)?,
                symmetry: inputs.symmetry,
            });
        }
    }
    if let Some(task) = &mut pattern.task {
        let Some(done) = block_on(poll_once(task)) else {
            return Ok(Changed::Waiting);
        };
        let start = || compute_directions(DirectionField::clone(&item.field), inputs, graph.clone());
        pattern.task = std::mem::take(&mut pattern.outdated).then(start);
        new = Some(done?);
    }
    match new {
        Some(new) => {
            pattern.begin_directions(new.symmetry);
            pattern.directions = new.vectors;
        }
        None => pattern.begin_directions(pattern.symmetry()),
    }
    pattern.write_record(&mut tools.arena);
    let source = tools.meshes.get(mesh).ok_or(PatternError::MeshDataTaken)?;
    let frequencies = frequencies(&item.frequency, graph, source)?;
    let field: Vec<Vec4> = pattern
        .directions
        .iter()
        .zip(&frequencies)
        .map(|(d, &f)| d.extend(f))
        .collect();
    tools.arena.write(Pool::Edges, pattern.ranges.edges, &field);
    pattern.uploaded = true;
    if pattern.phase == Phase::Waiting {
        pattern.phase = Phase::Cold;
    }
    Ok(Changed::Inputs)
}

/// Computes directions off the main thread.
fn compute_directions(
    field: DirectionField,
    inputs: Inputs,
    graph: SurfaceGraph,
) -> Task<Result<Directions, PatternError>> {
    AsyncComputeTaskPool::get().spawn(async move {
        let empty = Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, default());
        Ok(Directions {
            vectors: directions_in(&field, inputs, &graph, &empty)?,
            symmetry: inputs.symmetry,
        })
    })
}

/// Refuses a turn that is not finite.
pub(super) fn check_turn(turn: f32) -> Result<(), PatternError> {
    check_uniform(Dir3::Y, 0.0, turn)
}

/// Refuses an axis and a frequency that mean nothing.
pub(super) fn check_uniform(axis: Dir3, frequency: f32, turn: f32) -> Result<(), PatternError> {
    if !axis.is_finite() || !turn.is_finite() {
        Err(PatternError::NotFinite {
            what: "direction of vertex",
            index: 0,
        })
    } else if !frequency.is_finite() {
        Err(PatternError::NotFinite {
            what: "frequency of vertex",
            index: 0,
        })
    } else if frequency < 0.0 {
        Err(PatternError::NegativeFrequency(frequency))
    } else {
        Ok(())
    }
}

/// Positions and normals, carried into the world by the linear part of a transform.
fn in_world(graph: &SurfaceGraph, linear: Mat3A) -> (Vec<Vec3>, Vec<Vec3>) {
    let cofactors = linear.inverse().transpose();
    let positions = graph.positions.iter().map(|&p| linear * p);
    let normals = graph.normals.iter().map(|&n| (cofactors * n).normalize_or(n));
    (positions.collect(), normals.collect())
}

/// The directions of a field in the space of the pattern.
fn directions_in(
    field: &DirectionField,
    inputs: Inputs,
    graph: &SurfaceGraph,
    mesh: &Mesh,
) -> Result<Vec<Vec3>, PatternError> {
    let Some(linear) = inputs.linear else {
        return directions(field, inputs.symmetry, inputs.turn, graph, mesh);
    };
    let (positions, normals) = in_world(graph, linear);
    match field {
        // These are vectors of the mesh, which are carried along; the others are made from the world's positions.
        DirectionField::Attribute(_) | DirectionField::Vertices(_) | DirectionField::Tangents(_) => {
            let mut d = directions(field, inputs.symmetry, inputs.turn, graph, mesh)?;
            d.iter_mut()
                .zip(&normals)
                .for_each(|(d, &n)| *d = project_tangent(linear * *d, n));
            Ok(d)
        }
        // An axis is projected, which takes no more than normals.
        DirectionField::Axis(_) => {
            let world = SurfaceGraph {
                positions,
                normals,
                ..default()
            };
            directions(field, inputs.symmetry, inputs.turn, &world, mesh)
        }
        DirectionField::PrincipalCurvature { .. } | DirectionField::Gradient { .. } => {
            let world = SurfaceGraph {
                positions,
                normals,
                ..graph.clone()
            };
            directions(field, inputs.symmetry, inputs.turn, &world, mesh)
        }
    }
}
