//! Who takes part in the work of a frame.
//!
//! In: a pattern's phase, and what has changed. Out: its place in the lists of [`Work`], and its next phase.

use super::{Changed, Pattern, PatternedItem, Phase, Tools};
use crate::wave::{
    layout::{FLAG_AXIS, FLAG_FOLLOW, FLAG_READY},
    plan::Work,
    state::PatternState,
    status::GpuStatus,
};
use bevy::prelude::*;

impl Pattern {
    /// The GPU brings directions and edge constants up to date.
    fn push_inputs(&mut self, work: &mut Work) {
        work.posed.extend(self.posed());
        if self.record.flags & FLAG_AXIS != 0 {
            work.axis.push(self.member());
        } else if std::mem::take(&mut self.uploaded) {
            work.given.push(self.member());
        }
        work.changed.push(self.member());
    }
}

/// Frames of soft sweeps after the last change, before a pattern comes to rest.
const FRAMES_TO_REST: u32 = 10;

/// Decides what a pattern takes part in.
pub(super) fn schedule(
    item: &mut PatternedItem,
    changed: Changed,
    status: &GpuStatus,
    work: &mut Work,
    tools: &mut Tools,
    ready: &mut Vec<Entity>,
) {
    let Some(pattern) = item.pattern.as_mut() else {
        item.state.set_if_neq(PatternState::Preparing);
        return;
    };
    if !status.is_ready() || pattern.phase == Phase::Waiting {
        if !pattern.is_drawn() {
            item.state.set_if_neq(PatternState::Preparing);
        }
        if changed == Changed::Inputs && pattern.phase != Phase::Waiting {
            pattern.phase = Phase::Cold;
        }
        return;
    }
    if pattern.task.is_some() && pattern.phase == Phase::Asleep {
        // The old field is drawn until the new one is computed.
        item.state.set_if_neq(PatternState::Solving);
    }
    let member = pattern.member();
    if pattern.phase == Phase::Cold {
        pattern.push_inputs(work);
        work.cold.push(member);
        if !pattern.is_drawn() {
            ready.push(item.entity);
        }
        pattern.record.flags = (pattern.record.flags | FLAG_READY) & !FLAG_FOLLOW;
        pattern.write_record(&mut tools.arena);
        pattern.phase = Phase::Asleep;
        item.state.set_if_neq(PatternState::Converged);
    } else if changed == Changed::Inputs {
        pattern.push_inputs(work);
        work.warm.push(member);
        pattern.phase = Phase::Warm(FRAMES_TO_REST);
        item.state.set_if_neq(PatternState::Solving);
    } else if let Phase::Warm(frames) = pattern.phase {
        if frames > 0 {
            work.warm.push(member);
            pattern.phase = Phase::Warm(frames - 1);
        } else {
            work.settling.push(member);
            pattern.phase = Phase::Asleep;
            item.state.set_if_neq(PatternState::Converged);
        }
    }
}
