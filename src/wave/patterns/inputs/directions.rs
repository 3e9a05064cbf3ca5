//! The source of a pattern's directions.

use super::{Computation, Inputs, Pattern, PatternedItem, Stage, Surroundings, in_world, parameters::Parameters};
use crate::{
    error::PatternError,
    field::{
        Alignment, DirectionField, FieldRing, Principal, SmoothField, SymmetricTensor, VortexCore, VortexCores,
        VortexField, check_smoothing, directions, interval, own_share, smooth_constraints, tensors, welded,
    },
    surface::{Level, SurfaceGraph},
    wave::{
        arena::{PatternArena, Pool},
        frame::BufferCopy,
        layout::{
            DIRECTION_AXIS, DIRECTION_BUFFER, DIRECTION_CURVATURE, DIRECTION_SMOOTH, DIRECTION_SNAPSHOTS,
            DIRECTION_TANGENTS, DIRECTION_TENSOR, DIRECTION_VECTORS, DIRECTION_VORTICES,
        },
    },
};
use bevy::{
    prelude::*,
    tasks::{AsyncComputeTaskPool, block_on, poll_once},
};
use std::f32::consts::FRAC_PI_2;

/// Whether the field may change without its component.
pub(super) fn looks_around(field: &DirectionField) -> bool {
    matches!(
        field,
        DirectionField::Vortices(_) | DirectionField::Snapshots(_) | DirectionField::Buffer(_)
    )
}

/// Brings the directions up to date; whether there are any.
pub(super) fn update(
    pattern: &mut Pattern,
    item: &PatternedItem,
    stage: &Stage,
    around: &Surroundings,
    arena: &mut PatternArena,
    parameters: &mut Parameters,
) -> Result<bool, PatternError> {
    let Inputs { coupling, turn, linear } = stage.inputs;
    let symmetry = coupling.symmetry;
    if !turn.is_finite() {
        return Err(PatternError::SettingNotFinite("FieldTurn"));
    }
    let change = stage.change;
    // The values of the mesh's vertices must be made anew.
    let stale = change.all || change.attributes || item.field.is_changed();
    // What follows from positions alone, too, but for those of a pose.
    let reshaped = change.all || change.mesh || change.linear || item.field.is_changed();
    // Smoothing may continue from where it was.
    let followable = pattern.sources.followable && !(change.all || change.jump || item.field.is_changed());
    let mut axis = Vec3::ZERO;
    let mut turn = turn;
    let mut curvature = None;
    let mut new = change.moved();
    let before = pattern.record.sources;
    parameters.directions.carry(linear);
    let kind = match &*item.field {
        DirectionField::PrincipalCurvature { direction, smoothing } if stage.live => {
            check_smoothing(*smoothing)?;
            pattern.sources.task = None;
            new |= stale || pattern.sources.unfinished > 0;
            let follows = followable && (change.pose || change.mesh);
            let steps = pattern.curvature_steps(*smoothing, follows, stage.graph.len() as u32, arena)?;
            // Lines lie in one of two places after an even or an odd number of steps.
            parameters.directions.choice =
                u32::from(*direction == Principal::Minor) | (steps % 2) << 1 | u32::from(steps < *smoothing) << 2;
            parameters.directions.blend = own_share(*smoothing);
            curvature = Some(steps);
            DIRECTION_CURVATURE
        }
        DirectionField::PrincipalCurvature { direction, smoothing } => {
            parameters.directions.carry(None);
            let start = || compute_curvature(*direction, *smoothing, stage);
            let Some(vectors) = poll(pattern, DIRECTION_VECTORS, reshaped, start)? else {
                return Ok(keep(pattern, parameters));
            };
            if let Some(vectors) = vectors {
                upload(pattern, &vectors, arena)?;
                new = true;
            }
            DIRECTION_VECTORS
        }
        DirectionField::Smooth(field) => {
            let constraints = match field.align {
                Alignment::Painted(_) => {
                    pattern.sources.task = None;
                    stale
                        .then(|| smooth_constraints(field, stage.graph, stage.mesh()?))
                        .transpose()?
                }
                _ => {
                    if field.align == Alignment::Curvature {
                        parameters.directions.carry(None);
                    }
                    let start = || compute_constraints(field, stage);
                    let Some(constraints) = poll(pattern, DIRECTION_SMOOTH, reshaped, start)? else {
                        return Ok(keep(pattern, parameters));
                    };
                    constraints
                }
            };
            if let Some(constraints) = constraints {
                upload(pattern, &constraints, arena)?;
                new = true;
            }
            let nodes: usize = stage.graph.levels.iter().map(Level::len).sum();
            let sources = &mut pattern.sources;
            pattern.record.smooth_base = sources.smooth.fit(arena, Pool::Wave, 2 * nodes as u32)?;
            parameters.directions.choice =
                u32::from(field.ring == FieldRing::Four) | u32::from(field.quarter_turn) << 2;
            let same = sources.written.directions == parameters.directions;
            let changed = new || !same;
            new |= !same || sources.unfinished > 0;
            if new {
                pattern.smooth_field(field, changed, followable && same);
            }
            DIRECTION_SMOOTH
        }
        field => {
            pattern.sources.task = None;
            match field {
                DirectionField::Axis(direction) => {
                    if !direction.is_finite() {
                        return Err(PatternError::SettingNotFinite("the direction of DirectionField::Axis"));
                    }
                    axis = **direction;
                    DIRECTION_AXIS
                }
                DirectionField::Vortices(field) => {
                    let cores = vortex_cores(field, stage, around)?;
                    parameters.directions.cores = cores.len() as u32;
                    parameters.directions.base = field.base.to_array();
                    parameters.cores = cores.into_iter().map(Into::into).collect();
                    DIRECTION_VORTICES
                }
                DirectionField::Tensor(field) => {
                    parameters.directions.choice = field.eigenvector as u32;
                    new |= change.scalars;
                    if stale {
                        let tensors = tensors(field, stage.graph, stage.mesh()?)?;
                        let pair = |t: &SymmetricTensor| [t.diagonal.extend(0.0), t.off_diagonal.extend(0.0)];
                        let data: Vec<Vec4> = tensors.iter().flat_map(pair).collect();
                        let base = pattern.sources.vectors.fit(arena, Pool::Geometry, data.len() as u32)?;
                        arena.write(Pool::Geometry, base, &data);
                        pattern.record.direction_base = base;
                        new = true;
                    }
                    DIRECTION_TENSOR
                }
                DirectionField::Snapshots(snapshots) => {
                    let (k, share) = interval(snapshots, item.time.map_or(0.0, |time| time.0))?;
                    let len = stage.graph.len() as u32;
                    let base = pattern.sources.vectors.fit(arena, Pool::Geometry, 2 * len)?;
                    pattern.record.direction_base = base;
                    if stale || change.symmetry {
                        pattern.sources.held = [None; 2];
                        new = true;
                    }
                    let other = if k + 1 < snapshots.len() {
                        k + 1
                    } else {
                        k.saturating_sub(1)
                    };
                    for (place, snapshot) in [(k % 2, k), (1 - k % 2, other)] {
                        if pattern.sources.held[place] != Some(snapshot) {
                            pattern.sources.held[place] = Some(snapshot);
                            let vectors = welded(&snapshots[snapshot], symmetry, stage.graph)?;
                            arena.write(Pool::Geometry, base + place as u32 * len, &extended(vectors));
                        }
                    }
                    parameters.directions.blend = if k % 2 == 0 { share } else { 1.0 - share };
                    DIRECTION_SNAPSHOTS
                }
                DirectionField::Buffer(field) => {
                    let len = stage.graph.vertex_of.len() as u32;
                    let bytes = 16 * u64::from(len);
                    let ready = around.buffer_is_ready("DirectionField::Buffer", &field.buffer, bytes)?;
                    let missed = &mut pattern.sources.missed.directions;
                    let stale = stale || *missed;
                    *missed = stale && !ready;
                    if !ready {
                        return Ok(keep(pattern, parameters));
                    }
                    let base = pattern.sources.vectors.fit(arena, Pool::Geometry, len)?;
                    pattern.record.direction_base = base;
                    if stale || field.live {
                        let (pool, offset) = (Pool::Geometry, 16 * u64::from(base));
                        let buffer = field.buffer.id();
                        pattern.sources.due.direction_copy = Some(BufferCopy {
                            buffer,
                            pool,
                            offset,
                            bytes,
                        });
                        new = true;
                    }
                    DIRECTION_BUFFER
                }
                // Contour lines are carried along by what deforms the surface, and a gradient is across them.
                DirectionField::Gradient {
                    attribute,
                    quarter_turn,
                } if stage.live => {
                    turn -= if *quarter_turn { 0.0 } else { FRAC_PI_2 };
                    let contours = DirectionField::Gradient {
                        attribute: *attribute,
                        quarter_turn: true,
                    };
                    if stale {
                        let vectors = directions(&contours, symmetry, 0.0, stage.graph, stage.mesh()?)?;
                        upload(pattern, &extended(vectors), arena)?;
                        new = true;
                    }
                    DIRECTION_VECTORS
                }
                // A gradient is the world's; the others are vectors of the mesh, which are carried along.
                DirectionField::Gradient { .. } => {
                    parameters.directions.carry(None);
                    if stale || change.linear {
                        let world = in_space(stage);
                        let graph = world.as_ref().unwrap_or(stage.graph);
                        let vectors = directions(field, symmetry, 0.0, graph, stage.mesh()?)?;
                        upload(pattern, &extended(vectors), arena)?;
                        new = true;
                    }
                    DIRECTION_VECTORS
                }
                _ => {
                    if stale || change.symmetry {
                        let vectors = directions(field, symmetry, 0.0, stage.graph, stage.mesh()?)?;
                        upload(pattern, &extended(vectors), arena)?;
                        new = true;
                    }
                    if matches!(field, DirectionField::Tangents(_)) && linear.is_none() && !stage.live {
                        DIRECTION_TANGENTS
                    } else {
                        DIRECTION_VECTORS
                    }
                }
            }
        }
    };
    pattern.sources.curvature = curvature;
    if matches!(kind, DIRECTION_AXIS | DIRECTION_VORTICES | DIRECTION_CURVATURE) {
        pattern.sources.vectors.free(arena);
    }
    if !matches!(kind, DIRECTION_SMOOTH | DIRECTION_CURVATURE) {
        pattern.forget_lines(arena);
    }
    pattern.sources.followable &= kind == pattern.record.sources & 255;
    let record = &mut pattern.record;
    record.sources = (record.sources & !255) | kind;
    let written = &pattern.sources.written;
    if new
        || record.sources != before
        || record.turn != turn
        || record.axis != axis.to_array()
        || written.directions != parameters.directions
        || written.cores != parameters.cores
        || symmetry != pattern.symmetry()
    {
        pattern.record.turn = turn;
        pattern.record.axis = axis.to_array();
        pattern.begin_directions(symmetry);
    }
    Ok(true)
}

/// The old directions stay, with all that belongs to them, since the new ones are not there yet.
fn keep(pattern: &Pattern, parameters: &mut Parameters) -> bool {
    parameters.directions = pattern.sources.written.directions;
    parameters.cores.clone_from(&pattern.sources.written.cores);
    false
}

fn extended(vectors: Vec<Vec3>) -> Vec<Vec4> {
    vectors.into_iter().map(|v| v.extend(0.0)).collect()
}

fn upload(pattern: &mut Pattern, vectors: &[Vec4], arena: &mut PatternArena) -> Result<(), PatternError> {
    let base = pattern
        .sources
        .vectors
        .fit(arena, Pool::Geometry, vectors.len() as u32)?;
    arena.write(Pool::Geometry, base, vectors);
    pattern.record.direction_base = base;
    Ok(())
}

/// The graph in the world, for patterns that live there and are at rest.
fn in_space(stage: &Stage) -> Option<SurfaceGraph> {
    let linear = stage.inputs.linear.filter(|_| !stage.live)?;
    let (positions, normals) = in_world(stage.graph, linear);
    Some(SurfaceGraph {
        positions,
        normals,
        ..stage.graph.clone()
    })
}

/// What is computed off the main thread: `None` while the first ones or newer ones are, `Some(None)` where
/// those in use count.
fn poll(
    pattern: &mut Pattern,
    kind: u32,
    stale: bool,
    start: impl Fn() -> Computation,
) -> Result<Option<Option<Vec<Vec4>>>, PatternError> {
    let sources = &mut pattern.sources;
    if sources
        .task
        .as_ref()
        .is_some_and(|computation| computation.kind != kind)
    {
        sources.task = None;
    }
    if stale {
        // A computation that has begun is finished, so that a field that changes in every frame is seen to.
        sources.outdated |= sources.task.is_some();
        sources.task.get_or_insert_with(&start);
    }
    let Some(computation) = &mut sources.task else {
        return Ok(Some(None));
    };
    let Some(done) = block_on(poll_once(&mut computation.task)) else {
        return Ok(None);
    };
    sources.task = std::mem::take(&mut sources.outdated).then(start);
    Ok(Some(Some(done?)))
}

fn compute_constraints(field: &SmoothField, stage: &Stage) -> Computation {
    let world = in_space(stage).filter(|_| field.align == Alignment::Curvature);
    let (graph, field) = (world.unwrap_or_else(|| stage.graph.clone()), field.clone());
    let compute = async move { smooth_constraints(&field, &graph, &empty()) };
    Computation {
        kind: DIRECTION_SMOOTH,
        task: AsyncComputeTaskPool::get().spawn(compute),
    }
}

/// Stands for the mesh where a field needs none.
fn empty() -> Mesh {
    Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, default())
}

fn compute_curvature(principal: Principal, smoothing: u32, stage: &Stage) -> Computation {
    let field = DirectionField::PrincipalCurvature {
        direction: principal,
        smoothing,
    };
    let graph = in_space(stage).unwrap_or_else(|| stage.graph.clone());
    let compute = async move { directions(&field, field.default_symmetry(), 0.0, &graph, &empty()).map(extended) };
    Computation {
        kind: DIRECTION_VECTORS,
        task: AsyncComputeTaskPool::get().spawn(compute),
    }
}

/// The cores that a field follows, in the space of the pattern and in the order of their entities.
fn vortex_cores(field: &VortexField, stage: &Stage, around: &Surroundings) -> Result<Vec<VortexCore>, PatternError> {
    if !field.base.is_finite() {
        return Err(PatternError::SettingNotFinite("VortexField::base"));
    }
    let mut cores: Vec<_> = match &field.cores {
        VortexCores::All => around.cores.iter().collect(),
        VortexCores::These(entities) => entities
            .iter()
            .map(|&entity| {
                around.cores.get(entity).map_err(|_| PatternError::MissingEntity {
                    what: "DirectionField::Vortices",
                    entity,
                    lacks: "Vortex or GlobalTransform",
                })
            })
            .collect::<Result<_, _>>()?,
    };
    cores.sort_unstable_by_key(|(entity, ..)| *entity);
    let (scale, place) = (stage.scale(), |at: &GlobalTransform| stage.in_pattern(at.translation()));
    cores
        .into_iter()
        .map(|(_, vortex, at)| VortexCore::new(vortex, place(at), scale))
        .collect()
}
