//! What the two worlds tell each other of the GPU, besides frames.

use super::pack::ITEM;
use crate::error::PatternError;
use bevy::prelude::*;
use std::sync::{
    Arc, PoisonError, RwLock,
    atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
};

/// What the main world knows of the GPU.
#[derive(Resource, Clone, Default)]
pub(crate) struct GpuStatus(Arc<Status>);

#[derive(Default)]
struct Status {
    absent: AtomicBool,
    ready: AtomicBool,
    reports: AtomicBool,
    generation: AtomicU32,
    item: AtomicU32,
    error: RwLock<Option<PatternError>>,
}

impl GpuStatus {
    /// The app renders nothing.
    pub(crate) fn is_absent(&self) -> bool {
        self.0.absent.load(Relaxed)
    }

    /// All pipelines are compiled.
    pub(crate) fn is_ready(&self) -> bool {
        self.0.ready.load(Relaxed)
    }

    /// Somebody reads diagnostics.
    pub(crate) fn reports(&self) -> bool {
        self.0.reports.load(Relaxed)
    }

    /// Nodes of one item of work. A processor that plays GPU spends more on starting a thread than on a node.
    pub(crate) fn item(&self) -> u32 {
        self.0.item.load(Relaxed).max(ITEM)
    }

    /// A processor plays GPU.
    pub(crate) fn is_software(&self) -> bool {
        self.item() > ITEM
    }

    /// Counts the devices so far; what was on an earlier one is lost.
    pub(crate) fn generation(&self) -> u32 {
        self.0.generation.load(Relaxed)
    }

    /// What was on the GPU does not count any more.
    pub(super) fn begin_generation(&self) {
        self.0.generation.fetch_add(1, Relaxed);
    }

    /// Why the GPU cannot solve.
    pub(crate) fn error(&self) -> Option<PatternError> {
        self.0.error.read().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn set_absent(&self, absent: bool) {
        self.0.absent.store(absent, Relaxed);
    }

    pub(super) fn set_ready(&self, ready: bool) {
        self.0.ready.store(ready, Relaxed);
    }

    pub(super) fn set_reports(&self, reports: bool) {
        self.0.reports.store(reports, Relaxed);
    }

    pub(super) fn set_item(&self, item: u32) {
        self.0.item.store(item, Relaxed);
    }

    pub(super) fn set_error(&self, error: PatternError) {
        self.0
            .error
            .write()
            .unwrap_or_else(PoisonError::into_inner)
            .get_or_insert(error);
    }
}

/// Counts what the solver does; read it to see that a pattern sleeps.
#[derive(Resource, Clone, Default)]
pub struct SolverCounters(Arc<Counters>);

#[derive(Default)]
struct Counters {
    dispatches: AtomicU32,
    sweeps: AtomicU32,
    pattern_sweeps: AtomicU32,
}

impl SolverCounters {
    /// Dispatches of the last frame.
    pub fn dispatches(&self) -> u32 {
        self.0.dispatches.load(Relaxed)
    }

    /// Sweeps over the mesh in the last frame.
    pub fn sweeps(&self) -> u32 {
        self.0.sweeps.load(Relaxed)
    }

    /// The same, each counted once per pattern that took part: what
    /// [`max_sweeps_per_frame`](super::SolverSettings::max_sweeps_per_frame) limits. The local rule's do not count.
    pub fn pattern_sweeps(&self) -> u32 {
        self.0.pattern_sweeps.load(Relaxed)
    }

    pub(super) fn set(&self, dispatches: u32, sweeps: u32, pattern_sweeps: u32) {
        self.0.dispatches.store(dispatches, Relaxed);
        self.0.sweeps.store(sweeps, Relaxed);
        self.0.pattern_sweeps.store(pattern_sweeps, Relaxed);
    }
}
