//! The inputs of a pattern: directions, frequencies, scalars and, in the world's space, positions.
//!
//! In: an entity's components, its graph, and what they name: other entities, the user's buffers. Out: kinds and
//! parameters of the two sources in the record, values of vertices in the shared buffers, and what the device has to
//! evaluate: directions, frequencies or both, as soon as something has changed, and only then. The two are separate: any
//! source of directions goes with any source of frequencies.
//!
//! What takes long (curvature) is computed off the main thread; meanwhile the old field is drawn.

mod directions;
mod frequencies;
mod leaps;
mod parameters;
mod scalars;
mod screen;
mod slot;
mod smoothing;
mod surroundings;

pub(crate) use surroundings::{BufferWatch, Surroundings, watch_buffers};

use super::{
    Changed, Inputs, Pattern, PatternedItem, Phase, Tools,
    live::{Motion, Rigged},
};
use crate::{
    error::PatternError,
    field::Symmetry,
    surface::{Surface, SurfaceGraph},
    wave::{
        arena::{PatternArena, Pool},
        frame::BufferCopy,
        layout::{FLAG_CROSS, FLAG_FOLLOW, FLAG_VECTOR},
        pack::geometry,
        waves::Waves,
    },
};
use bevy::{
    math::{Affine3A, Mat3A},
    prelude::*,
    tasks::Task,
};
use leaps::{leaps, linear_leaps};
use parameters::Parameters;
pub(super) use slot::Slot;
pub(super) use smoothing::DueSmoothing;

/// Where an entity's directions and frequencies come from, and what it owns of the shared buffers for them.
#[derive(Default)]
pub(super) struct Sources {
    /// Vectors or tensors that directions are made from.
    vectors: Slot,
    /// Frequencies that were given.
    frequencies: Slot,
    scalars: Slot,
    smooth: Slot,
    /// The scalars are those of a component.
    scalars_given: bool,
    parameters: Slot,
    /// As last written.
    written: Parameters,
    /// Directions, or what a smooth field is drawn to, where that takes long.
    task: Option<Computation>,
    /// The inputs have changed since the task began.
    outdated: bool,
    /// Which snapshots the two places for them hold.
    held: [Option<usize>; 2],
    screen: Option<screen::Follow>,
    /// Directions are those of principal curvature of a posed surface, after so many steps of smoothing.
    curvature: Option<u32>,
    /// The device holds lines from which smoothing can continue.
    followable: bool,
    /// Steps of smoothing that are still to be done once nothing changes.
    unfinished: u32,
    /// A change was met before the buffer with the new values was there.
    missed: Missed,
    due: Due,
}

/// What is computed off the main thread, for a kind of source.
struct Computation {
    kind: u32,
    task: Task<Result<Vec<Vec4>, PatternError>>,
}

#[derive(Default)]
struct Missed {
    directions: bool,
    frequencies: bool,
}

/// What the device has to do before the pattern is solved on.
#[derive(Default)]
pub(super) struct Due {
    /// The surface is posed.
    pub(super) pose: bool,
    /// The field is smoothed.
    pub(super) smooth: Option<DueSmoothing>,
    pub(super) directions: bool,
    pub(super) frequencies: bool,
    pub(super) direction_copy: Option<BufferCopy>,
    pub(super) frequency_copy: Option<BufferCopy>,
}

impl Sources {
    pub(super) fn free(&mut self, arena: &mut PatternArena) {
        for slot in [
            &mut self.vectors,
            &mut self.frequencies,
            &mut self.scalars,
            &mut self.smooth,
            &mut self.parameters,
        ] {
            slot.free(arena);
        }
    }

    /// The scalars are those of a component.
    pub(super) fn has_scalars(&self) -> bool {
        self.scalars_given
    }

    /// Steps of smoothing of a posed surface's principal curvature, where directions are made of that.
    pub(super) fn curvature(&self) -> Option<u32> {
        self.curvature
    }

    /// Something takes long.
    pub(super) fn is_computing(&self) -> bool {
        self.task.is_some()
    }

    /// What is due, which the caller sees to.
    pub(super) fn take_due(&mut self) -> Due {
        self.followable |= self.due.directions;
        std::mem::take(&mut self.due)
    }
}

/// What sources are evaluated on.
struct Stage<'a> {
    graph: &'a SurfaceGraph,
    mesh: Option<&'a Mesh>,
    inputs: Inputs,
    /// From the mesh to the world.
    placement: Affine3A,
    /// The surface is posed on the GPU, which carries along what belongs to the mesh.
    live: bool,
    change: Change,
}

impl Stage<'_> {
    fn mesh(&self) -> Result<&Mesh, PatternError> {
        self.mesh.ok_or(PatternError::MeshDataTaken)
    }

    /// A point of the world in the space of the pattern, where patterns of the world leave out the translation.
    fn in_pattern(&self, point: Vec3) -> Vec3 {
        if self.inputs.linear.is_some() {
            point - Vec3::from(self.placement.translation)
        } else {
            self.placement.inverse().transform_point3(point)
        }
    }

    /// Length in the pattern's space of one unit of the world.
    fn scale(&self) -> f32 {
        if self.inputs.linear.is_some() {
            1.0
        } else {
            self.placement.matrix3.determinant().abs().cbrt().recip()
        }
    }
}

/// What is other than in the frame before, besides fields and frequencies themselves.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Change {
    /// Nothing of before counts.
    all: bool,
    /// Positions of the mesh.
    mesh: bool,
    /// Positions or attributes of the mesh.
    attributes: bool,
    /// Its place in the world, where the processor follows that.
    linear: bool,
    /// Its pose, where the GPU does.
    pose: bool,
    /// The pose is a very different one.
    jump: bool,
    symmetry: bool,
    /// How many there are, or how they belong together.
    waves: bool,
    turn: bool,
    scalars: bool,
}

impl Change {
    const NONE: Self = Self {
        all: false,
        mesh: false,
        attributes: false,
        linear: false,
        pose: false,
        jump: false,
        symmetry: false,
        waves: false,
        turn: false,
        scalars: false,
    };

    /// Positions or normals are others.
    fn moved(&self) -> bool {
        self.all || self.mesh || self.linear || self.pose
    }
}

/// Whether the inputs may change without a change of the entity's own components.
pub(super) fn look_around(item: &PatternedItem) -> bool {
    directions::looks_around(&item.field) || frequencies::looks_around(&item.frequency)
}

impl Pattern {
    /// That of the directions in use, which is not the entity's while new ones are being computed.
    fn symmetry(&self) -> Symmetry {
        if self.record.flags & FLAG_VECTOR != 0 {
            Symmetry::Vector
        } else {
            Symmetry::Line
        }
    }

    /// How the waves belong together from now on.
    fn set_waves(&mut self, waves: Waves) {
        let cross = if waves == Waves::Cross { FLAG_CROSS } else { 0 };
        if cross != self.record.flags & FLAG_CROSS && self.is_solved() {
            self.phase = Phase::Cold;
        }
        self.record.flags = (self.record.flags & !FLAG_CROSS) | cross;
        self.record.ratio = waves.ratio();
    }

    fn set_symmetry(&mut self, symmetry: Symmetry) {
        self.record.flags &= !FLAG_VECTOR;
        if symmetry == Symmetry::Vector {
            self.record.flags |= FLAG_VECTOR;
        }
    }

    /// Other directions come into use. They follow those before where phasors refer to these.
    fn begin_directions(&mut self, symmetry: Symmetry) {
        if symmetry != self.symmetry() && self.phase != Phase::Waiting {
            // The phasors of lines and of vectors mean different things.
            self.phase = Phase::Cold;
        }
        self.record.flags &= !FLAG_FOLLOW;
        self.set_symmetry(symmetry);
        if self.is_solved() {
            self.record.flags |= FLAG_FOLLOW;
        }
        self.sources.due.directions = true;
    }
}

/// Brings directions, frequencies, scalars and positions up to date, as far as something has changed.
pub(super) fn update_inputs(
    pattern: &mut Pattern,
    item: &PatternedItem,
    surface: &Surface,
    inputs: Inputs,
    mesh: AssetId<Mesh>,
    rigged: Option<Rigged>,
    tools: &mut Tools,
    fresh: bool,
) -> Result<Changed, PatternError> {
    let last = std::mem::replace(&mut pattern.inputs, inputs);
    let reshaped = fresh || pattern.geometry != surface.geometry;
    let graph = tools.graphs.get(&surface.graph);
    let live = pattern.live.as_mut().zip(rigged);
    let is_live = live.is_some();
    let motion = live.map_or(Motion::None, |(live, rigged)| {
        live.update(rigged, reshaped, graph, &mut tools.arena)
    });
    let change = Change {
        all: fresh || pattern.phase == Phase::Waiting && pattern.sources.task.is_none(),
        mesh: pattern.positions != surface.positions,
        attributes: pattern.geometry != surface.geometry,
        linear: !is_live && last.linear != inputs.linear,
        pose: motion != Motion::None,
        jump: motion == Motion::Jump,
        symmetry: last.coupling.symmetry != inputs.coupling.symmetry,
        waves: last.coupling.waves != inputs.coupling.waves,
        turn: last.turn != inputs.turn,
        scalars: item
            .scalars
            .as_ref()
            .map_or(pattern.sources.scalars_given, |scalars| scalars.is_changed()),
    };
    pattern.geometry = surface.geometry;
    pattern.positions = surface.positions;
    pattern.sources.due.pose |= change.pose;
    let leapt = change.linear && linear_leaps(last.linear, inputs.linear);
    if (change.jump || leapt) && pattern.is_solved() {
        // Sweeps would not bring it back soon.
        pattern.phase = Phase::Cold;
    }
    let quiet = change == Change::NONE
        && pattern.sources.task.is_none()
        && pattern.sources.unfinished == 0
        && !(item.field.is_changed() || item.frequency.is_changed())
        && !look_around(item);
    if quiet {
        return Ok(pattern.due());
    }
    let Some(graph) = graph else {
        return Ok(Changed::Waiting);
    };
    let stage = Stage {
        graph,
        mesh: tools.meshes.get(mesh),
        inputs,
        placement: item.transform.map_or(Affine3A::IDENTITY, GlobalTransform::affine),
        live: is_live,
        change,
    };
    let before = pattern.record;
    pattern.set_waves(inputs.coupling.waves);
    pattern.sources.due.directions |= change.waves;
    if change.moved()
        && !is_live
        && let (Some(linear), Some(first)) = (inputs.linear, pattern.ranges.geometry)
    {
        let (positions, normals) = in_world(graph, linear);
        let discs: Vec<_> = graph.discs.iter().map(|axes| axes.map(|axis| linear * axis)).collect();
        tools
            .arena
            .write(Pool::Geometry, first, &geometry(graph, &positions, &normals, &discs));
    }
    let scalars = scalars::update(pattern, item, &stage, &mut tools.arena)?;
    if pattern.carrying.is_some() {
        pattern.set_symmetry(inputs.coupling.symmetry);
        if change.all || pattern.record != before {
            pattern.write_record(&mut tools.arena);
        }
        return Ok(Changed::Nothing);
    }
    let mut parameters = Parameters::default();
    let directions = directions::update(pattern, item, &stage, &tools.around, &mut tools.arena, &mut parameters)?;
    let frequencies = frequencies::update(
        pattern,
        item,
        &stage,
        &tools.around,
        &mut tools.arena,
        &mut parameters,
        scalars || pattern.sources.due.directions,
    )?;
    let new = (&pattern.record, &parameters);
    if pattern.is_solved() && leaps((&before, &pattern.sources.written), new, inputs.coupling.symmetry) {
        pattern.phase = Phase::Cold;
    }
    pattern.write_parameters(parameters, change.all, &mut tools.arena)?;
    if pattern.phase == Phase::Waiting && directions && frequencies {
        pattern.phase = Phase::Cold;
    }
    if change.all || pattern.record != before {
        pattern.write_record(&mut tools.arena);
    }
    Ok(pattern.due())
}

impl Pattern {
    fn due(&self) -> Changed {
        if self.phase == Phase::Waiting {
            Changed::Waiting
        } else if self.sources.due.pose || self.sources.due.directions || self.sources.due.frequencies {
            Changed::Inputs
        } else {
            Changed::Nothing
        }
    }

    fn write_parameters(&mut self, new: Parameters, all: bool, arena: &mut PatternArena) -> Result<(), PatternError> {
        let words = new.words();
        self.record.parameter_base = self.sources.parameters.fit(arena, Pool::Surface, words.len() as u32)?;
        if all || self.sources.written != new {
            arena.write(Pool::Surface, self.record.parameter_base, &words);
            self.sources.written = new;
        }
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
