//! Frames of the main world that the GPU has not done yet.
//!
//! In: one [`Frame`] of uploads and steps per frame of the main world. Out: all of them as one list of steps, each with
//! the uploads that must come between it and the step before. A frame waits where a shared buffer is still being made;
//! mostly none does.

use super::{
    arena::Pool,
    frame::{BufferCopy, Frame, Step},
    status::GpuStatus,
};
use bevy::prelude::*;
use std::ops::Range;

/// More frames than this wait for nothing that will come soon.
const MOST_FRAMES: usize = 64;

/// The frames that wait, in their order.
#[derive(Resource, Default)]
pub(super) struct Pending(Vec<Frame>);

/// Bytes of [`Merged::staged`] that a shared buffer gets before a step.
#[derive(Debug)]
pub(super) struct StagedCopy {
    /// Index of the step; their number, for what comes after the last one.
    pub(super) before: usize,
    pub(super) pool: Pool,
    pub(super) offset: u64,
    pub(super) bytes: Range<u64>,
}

/// Frames as one.
#[derive(Debug, Default)]
pub(super) struct Merged {
    pub(super) items: Vec<[u32; 4]>,
    pub(super) steps: Vec<Step>,
    pub(super) sweeps: u32,
    pub(super) pattern_sweeps: u32,
    pub(super) staged: Vec<u8>,
    /// Ascending in `before`.
    pub(super) copies: Vec<StagedCopy>,
    /// Copies of users' buffers, each before a step; ascending.
    pub(super) taken: Vec<(usize, BufferCopy)>,
}

impl Pending {
    /// Takes a frame in. If too much is waiting, all of it is given up, and the main world told to begin anew as after
    /// the loss of a device.
    pub(super) fn push(&mut self, frame: Frame, status: &GpuStatus) {
        self.forget_lost(status);
        // A frame of generation 0 was made before there was a device to lose.
        if frame.generation != 0 && frame.generation != status.generation() {
            return;
        }
        let capacity: u64 = frame.capacities.iter().sum();
        self.0.push(frame);
        let waiting: u64 = self.0.iter().map(Frame::bytes).sum();
        if self.0.len() > MOST_FRAMES || (self.0.len() > 2 && waiting > 4 * capacity) {
            self.0.clear();
            status.begin_generation();
        }
    }

    /// Drops what was meant for memory that is lost.
    fn forget_lost(&mut self, status: &GpuStatus) {
        let generation = status.generation();
        self.0.retain(|frame| [0, generation].contains(&frame.generation));
    }

    /// Bytes that the shared buffers must have, if anything waits.
    pub(super) fn capacities(&self) -> Option<&[u64]> {
        self.0.last().map(|frame| frame.capacities.as_slice())
    }

    pub(super) fn has_steps(&self) -> bool {
        self.0.iter().any(|frame| !frame.steps.is_empty())
    }

    /// All frames, one after the other. `write` gets the uploads that come before all steps; what is uploaded between
    /// steps is staged, for a queue writes before it computes.
    pub(super) fn merge(&mut self, mut write: impl FnMut(Pool, u64, &[u8])) -> Merged {
        let mut merged = Merged::default();
        for frame in self.0.drain(..) {
            for upload in frame.uploads {
                if merged.steps.is_empty() {
                    write(upload.pool, upload.offset, &upload.bytes);
                    continue;
                }
                let start = merged.staged.len() as u64;
                merged.staged.extend_from_slice(&upload.bytes);
                merged.copies.push(StagedCopy {
                    before: merged.steps.len(),
                    pool: upload.pool,
                    offset: upload.offset,
                    bytes: start..merged.staged.len() as u64,
                });
            }
            let before = merged.steps.len();
            merged.taken.extend(frame.copies.into_iter().map(|copy| (before, copy)));
            let first = merged.items.len() as u32;
            merged.items.extend_from_slice(&frame.items);
            merged.sweeps += frame.sweeps;
            merged.pattern_sweeps += frame.pattern_sweeps;
            merged.steps.extend(frame.steps.into_iter().map(|mut step| {
                step.uniform.first_item += first;
                step
            }));
        }
        merged
    }
}
