//! Smoothing that goes on from frame to frame.
//!
//! In: what has changed for a field that is smoothed. Out: whether it starts from nothing or continues from the lines of the frame
//! before, which the device keeps, and by how many steps; and how many are left for when nothing changes.

use super::Pattern;
use crate::{
    error::PatternError,
    field::{FOLLOWING_STEPS, SmoothField, Smoothing, is_followed},
    wave::{
        arena::{PatternArena, Pool},
        layout::{DIRECTION_CURVATURE, DIRECTION_SMOOTH},
    },
};

/// Sweeps over the mesh by which a smoothed field follows what has changed in a frame.
const FOLLOWING_SWEEPS: u32 = 4;

/// How a field is smoothed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::wave::patterns) struct DueSmoothing {
    /// 0: intrinsically, 1: extrinsically.
    pub(in crate::wave::patterns) kind: u32,
    /// Over the mesh.
    pub(in crate::wave::patterns) sweeps: u32,
    /// From where the field was.
    pub(in crate::wave::patterns) follows: bool,
}

impl DueSmoothing {
    /// The field stays as it was.
    pub(in crate::wave::patterns) const NONE: Self = Self {
        kind: 0,
        sweeps: 0,
        follows: true,
    };
}

impl Pattern {
    /// Steps by which principal curvature of a posed surface of so many vertices is smoothed in this frame: a few where it
    /// follows, and `smoothing` from nothing otherwise.
    pub(super) fn curvature_steps(
        &mut self,
        smoothing: u32,
        follows: bool,
        vertices: u32,
        arena: &mut PatternArena,
    ) -> Result<u32, PatternError> {
        self.sources.unfinished = 0;
        if !is_followed(smoothing) {
            self.forget_lines(arena);
            return Ok(smoothing);
        }
        let kept = self.record.smooth_base != 0 && self.record.sources & 255 == DIRECTION_CURVATURE;
        self.sources.followable &= kept;
        self.record.smooth_base = self.sources.smooth.fit(arena, Pool::Wave, 2 * vertices)?;
        if !(kept && follows) {
            return Ok(smoothing);
        }
        self.sources.unfinished = smoothing;
        Ok(FOLLOWING_STEPS)
    }

    /// Asks for sweeps of a smoothed field. `changed`: there is more than what was left to be done; `follows`: it may
    /// continue from where it was.
    pub(super) fn smooth_field(&mut self, field: &SmoothField, changed: bool, follows: bool) {
        let sources = &mut self.sources;
        let from_nothing = sources.due.smooth.is_some_and(|due| !due.follows);
        let follows = follows && !from_nothing && self.record.sources & 255 == DIRECTION_SMOOTH;
        let left = if changed { field.steps } else { sources.unfinished };
        let sweeps = if follows {
            left.min(FOLLOWING_SWEEPS)
        } else {
            field.steps
        };
        sources.unfinished = if follows { left - sweeps } else { 0 };
        sources.due.smooth = Some(DueSmoothing {
            kind: u32::from(field.smoothing == Smoothing::Extrinsic),
            sweeps,
            follows,
        });
    }

    /// Gives back the memory of the lines that smoothing continues from.
    pub(super) fn forget_lines(&mut self, arena: &mut PatternArena) {
        self.sources.smooth.free(arena);
        self.sources.followable = false;
        self.sources.unfinished = 0;
        self.record.smooth_base = 0;
    }
}
