//! Patterns that are another entity's.
//!
//! In: an entity with [`CarriesPattern`], and the pattern of the one that it names. Out: the nearest points of each vertex, found
//! off the main thread whenever one of the two surfaces is another one, and the pass that predicts from them whenever the other
//! pattern has changed.

use super::{Pattern, PatternedItem, PatternedReadOnlyItem, Phase, Tools, inputs::Slot};
use crate::{
    error::PatternError,
    surface::{Surface, SurfaceGraph},
    wave::{
        arena::{PatternArena, Pool},
        carry::nearest_points,
        layout::FLAG_READY,
        plan::Work,
        state::PatternState,
        waves::Coupling,
    },
};
use bevy::{
    math::Mat3A,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};

/// The pattern that another entity carries.
#[derive(Clone)]
pub(super) struct Source {
    record: u32,
    pub(super) coupling: Coupling,
    /// As that of its [`Inputs`](super::Inputs).
    pub(super) linear: Option<Mat3A>,
    positions: u32,
    graph: Handle<SurfaceGraph>,
    is_solved: bool,
    state: PatternState,
}

impl Source {
    /// That of an entity, once it has a pattern.
    fn of(item: &PatternedReadOnlyItem) -> Option<Self> {
        let (pattern, meshes) = item.pattern.zip(item.meshes)?;
        Some(Self {
            record: pattern.ranges.record,
            coupling: pattern.inputs.coupling,
            linear: pattern.inputs.linear,
            positions: pattern.positions,
            graph: meshes.graph.clone(),
            is_solved: pattern.is_solved() && pattern.is_drawn(),
            state: item.state.clone(),
        })
    }
}

/// What an entity carries: `None` while the other one has no pattern yet.
pub(super) fn source(
    item: &PatternedReadOnlyItem,
    other: Option<PatternedReadOnlyItem>,
) -> Option<Result<Option<Source>, PatternError>> {
    let carries = **item.carries.as_ref()?;
    Some(match other {
        None => Err(PatternError::MissingEntity {
            what: "CarriesPattern",
            entity: carries.of,
            lacks: "DirectionField",
        }),
        Some(other) => carries
            .check(item.entity, other.carries.is_some())
            .and_then(|()| match &*other.state {
                PatternState::Failed(error) => Err(error.clone()),
                _ => Ok(Source::of(&other)),
            }),
    })
}

type Nearest = Vec<[u32; 6]>;

/// The nearest points of a pattern's vertices.
#[derive(Default)]
pub(super) struct Carrying {
    slot: Slot,
    /// The positions of the points and of the vertices that they were found for, or are being found for.
    known: Option<[u32; 2]>,
    task: Option<Task<Nearest>>,
    record: u32,
    /// There are points, and what they predict has not been asked for.
    due: bool,
}

impl Carrying {
    pub(super) fn free(&mut self, arena: &mut PatternArena) {
        self.slot.free(arena);
    }
}

impl Pattern {
    /// Brings the nearest points up to date, as far as they are there.
    pub(super) fn update_carrying(
        &mut self,
        source: &Source,
        surface: &Surface,
        tools: &mut Tools,
    ) -> Result<(), PatternError> {
        let Some(carrying) = &mut self.carrying else {
            return Ok(());
        };
        let now = [source.positions, surface.positions];
        if carrying.known != Some(now) && carrying.task.is_none() {
            let (Some(from), Some(onto)) = (tools.graphs.get(&source.graph), tools.graphs.get(&surface.graph)) else {
                return Ok(());
            };
            let (from, onto) = (from.positions.clone(), onto.positions.clone());
            carrying.known = Some(now);
            carrying.task = Some(AsyncComputeTaskPool::get().spawn(async move { nearest_points(&from, &onto) }));
        }
        let found = carrying.task.as_mut().and_then(|task| block_on(poll_once(task)));
        if let Some(nearest) = found {
            carrying.task = None;
            let words = nearest.as_flattened();
            let base = carrying
                .slot
                .fit(&mut tools.arena, Pool::Surface, 1 + words.len() as u32)?;
            tools.arena.write(Pool::Surface, base, &[source.record]);
            tools.arena.write(Pool::Surface, base + 1, words);
            carrying.record = source.record;
            carrying.due = true;
            self.record.carry_base = base;
            self.write_record(&mut tools.arena);
        } else if carrying.record != source.record && self.record.carry_base != 0 {
            tools
                .arena
                .write(Pool::Surface, self.record.carry_base, &[source.record]);
            carrying.record = source.record;
            carrying.due = true;
        }
        Ok(())
    }
}

/// Asks for what a pattern carries, where that is another one than before.
pub(super) fn serve(
    item: &mut PatternedItem,
    source: &Source,
    work: &mut Work,
    tools: &mut Tools,
    ready: &mut Vec<Entity>,
) {
    let Some(pattern) = item.pattern.as_mut() else {
        item.state.set_if_neq(PatternState::Preparing);
        return;
    };
    let moved = pattern.sources.take_due().pose;
    if moved {
        work.posed.push(pattern.member());
    }
    let member = pattern.member();
    let has_points = pattern.record.carry_base != 0;
    let drawn = pattern.is_drawn();
    let Some(carrying) = &mut pattern.carrying else { return };
    carrying.due |= !drawn || moved || work.touches(source.record);
    if !has_points || !source.is_solved {
        item.state.set_if_neq(if drawn {
            PatternState::Solving
        } else {
            PatternState::Preparing
        });
        return;
    }
    if std::mem::take(&mut carrying.due) {
        work.carried.push(member);
    }
    let busy = carrying.task.is_some();
    if !drawn {
        ready.push(item.entity);
        pattern.record.flags |= FLAG_READY;
        pattern.phase = Phase::Carried;
        pattern.write_record(&mut tools.arena);
    }
    item.state.set_if_neq(match source.state {
        PatternState::Converged if !busy => PatternState::Converged,
        _ => PatternState::Solving,
    });
}
