//! Who takes part in the work of a frame.
//!
//! In: a pattern's phase, what has changed, and how much there is room for. Out: its place in the lists of [`Work`], and
//! its next phase.

use super::{
    Changed, Pattern, PatternedItem, Phase, Tools,
    budget::{Budget, Claim, INPUTS, cycle_cost, start_cost},
    inputs::DueSmoothing,
};
use crate::wave::{
    layout::{DIRECTION_SMOOTH, FLAG_FOLLOW, FLAG_READY},
    plan::{Smoothed, Sweeps, Work},
    settings::{ColdStart, SolverSettings},
    state::PatternState,
    status::GpuStatus,
};
use bevy::prelude::*;

impl Pattern {
    /// The GPU brings directions, frequencies and edge constants up to date.
    fn push_inputs(&mut self, work: &mut Work) {
        let due = self.sources.take_due();
        if due.pose {
            work.posed.push(self.member());
        }
        work.copies.extend(due.direction_copy);
        work.copies.extend(due.frequency_copy);
        if due.directions {
            if self.record.sources & 255 == DIRECTION_SMOOTH {
                // Lines are handed on as directions, so that they are read again in any case.
                let smoothing = due.smooth.unwrap_or(DueSmoothing::NONE);
                work.smooth.push(Smoothed {
                    member: self.member(),
                    kind: smoothing.kind,
                    sweeps: smoothing.sweeps,
                    follows: smoothing.follows,
                });
            }
            let steps = self.sources.curvature();
            work.curved.extend(steps.map(|steps| (self.member(), steps)));
            work.directions.push((self.member(), self.record.sources & 255));
        }
        if due.frequencies {
            work.frequencies.push((self.member(), (self.record.sources >> 8) & 255));
        }
        work.changed.push(self.member());
        self.behind = false;
    }

    fn nodes(&self) -> u32 {
        self.record.vertices * self.record.waves
    }

    /// Does as many sweeps as there is room for, soft ones first; how many.
    fn sweep(&self, left: &mut Sweeps, budget: &mut Budget, work: &mut Work) -> u32 {
        let granted = budget.grant(self.nodes(), left.soft + left.plain);
        let soft = granted.min(left.soft);
        let plain = granted - soft;
        if granted > 0 {
            work.sweeping.push((self.member(), Sweeps { soft, plain, ..*left }));
        }
        left.soft -= soft;
        left.plain -= plain;
        left.from_unit &= soft == 0;
        granted
    }

    /// Sweeps for a frame, and then for `frames` more; whether there was room.
    fn follow(&mut self, frames: u32, settings: &SolverSettings, budget: &mut Budget, work: &mut Work) -> bool {
        let level_sweeps = settings.warm_level_sweeps;
        if level_sweeps > 0 && budget.admits(self.nodes(), cycle_cost(level_sweeps)) {
            work.cycling.push(self.member());
        }
        let mut sweeps = Sweeps {
            soft: settings.warm_sweeps,
            ..Sweeps::default()
        };
        let swept = self.sweep(&mut sweeps, budget, work) > 0;
        if swept {
            self.phase = Phase::Warm(frames);
        }
        swept
    }

    /// Does what it can of the last sweeps, and sleeps when there are none left; whether there was room.
    fn finish(&mut self, mut left: Sweeps, budget: &mut Budget, work: &mut Work) -> bool {
        let swept = self.sweep(&mut left, budget, work) > 0;
        self.phase = match left {
            Sweeps { soft: 0, plain: 0, .. } => Phase::Asleep,
            left => Phase::Sweeping(left),
        };
        swept
    }
}

/// Frames of soft sweeps after the last change, before a pattern comes to rest.
const FRAMES_TO_REST: u32 = 10;

/// Whether a pattern has something to do.
pub(super) fn claim(item: &mut PatternedItem, changed: Changed, status: &GpuStatus) -> Option<Claim> {
    let Some(pattern) = item.pattern.as_mut() else {
        item.state.set_if_neq(PatternState::Preparing);
        return None;
    };
    if !status.is_ready() || pattern.phase == Phase::Waiting {
        if !pattern.is_drawn() {
            item.state.set_if_neq(PatternState::Preparing);
        }
        if changed == Changed::Inputs && pattern.phase != Phase::Waiting {
            pattern.phase = Phase::Cold;
        }
        return None;
    }
    if changed == Changed::Inputs {
        pattern.behind = true;
    }
    if pattern.sources.is_computing() && pattern.phase == Phase::Asleep {
        // The old field is drawn until the new one is computed.
        item.state.set_if_neq(PatternState::Solving);
    }
    let busy = pattern.behind || pattern.phase != Phase::Asleep;
    busy.then(|| Claim {
        entity: item.entity,
        seen: pattern.seen,
        waited: pattern.waited,
    })
}

/// Lets a pattern do what there is room for.
pub(super) fn serve(
    item: &mut PatternedItem,
    budget: &mut Budget,
    work: &mut Work,
    tools: &mut Tools,
    ready: &mut Vec<Entity>,
) {
    let Some(pattern) = item.pattern.as_mut() else { return };
    pattern.waited += 1;
    let settings = &**tools.settings;
    let cost = match pattern.phase {
        Phase::Cold => INPUTS + start_cost(settings),
        _ if pattern.behind => INPUTS,
        _ => 0,
    };
    if cost > 0 && !budget.admits(pattern.nodes(), cost) {
        // Until it is drawn anew, what is drawn is the last that was solved.
        if pattern.is_drawn() {
            item.state.set_if_neq(PatternState::Solving);
        }
        return;
    }
    let served = match pattern.phase {
        Phase::Cold => {
            pattern.push_inputs(work);
            work.cold.push(pattern.member());
            if !pattern.is_drawn() {
                ready.push(item.entity);
            }
            pattern.record.flags = (pattern.record.flags | FLAG_READY) & !FLAG_FOLLOW;
            pattern.write_record(&mut tools.arena);
            pattern.finish(sweeps_after_start(settings), budget, work);
            true
        }
        _ if pattern.behind => {
            pattern.push_inputs(work);
            pattern.phase = Phase::Warm(FRAMES_TO_REST);
            pattern.follow(FRAMES_TO_REST, settings, budget, work);
            true
        }
        Phase::Warm(frames @ 1..) => pattern.follow(frames - 1, settings, budget, work),
        Phase::Warm(0) => {
            let plain = settings.plain_sweeps;
            pattern.finish(Sweeps { plain, ..default() }, budget, work)
        }
        Phase::Sweeping(left) => pattern.finish(left, budget, work),
        Phase::Waiting | Phase::Asleep | Phase::Carried => return,
    };
    if served {
        pattern.waited = 0;
    }
    item.state.set_if_neq(match pattern.phase {
        Phase::Asleep => PatternState::Converged,
        _ => PatternState::Solving,
    });
}

/// The sweeps on the mesh that belong to a cold start.
fn sweeps_after_start(settings: &SolverSettings) -> Sweeps {
    match settings.cold_start {
        ColdStart::Hierarchy { .. } => Sweeps {
            soft: settings.soft_sweeps,
            plain: settings.plain_sweeps,
            from_unit: true,
        },
        ColdStart::Local(_) | ColdStart::Merged(_) => Sweeps::default(),
    }
}
