//! How much of a frame's work is done in it.
//!
//! In: what each pattern would do, whether it is seen and how long it has waited. Out: who is served, and with how many
//! sweeps. What is seen comes first, but whoever waits long enough comes before it, so that every pattern makes progress.

use super::Pattern;
use crate::wave::{
    frame::Frame,
    settings::{ColdStart, SolverSettings},
    status::GpuStatus,
};
use bevy::{
    diagnostic::{DiagnosticPath, DiagnosticsStore},
    platform::time::Instant,
    prelude::*,
};

/// What is seen comes this many frames before what is not.
const HEAD_START: u32 = 8;
/// Sweeps that take as long as bringing directions and edge constants up to date.
pub(super) const INPUTS: u32 = 1;

/// A pattern that has something to do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Claim {
    pub(super) entity: Entity,
    pub(super) seen: bool,
    /// Frames since it was served.
    pub(super) waited: u32,
}

/// Remembers who is seen: in `PostUpdate` this is being found out anew.
pub(crate) fn note_seen(mut patterns: Query<(&ViewVisibility, &mut Pattern)>) {
    for (seen, mut pattern) in &mut patterns {
        pattern.bypass_change_detection().seen = seen.get();
    }
}

/// In the order in which they are served.
pub(super) fn in_turn(mut claims: Vec<Claim>) -> Vec<Claim> {
    let urgency = |claim: &Claim| claim.waited + if claim.seen { HEAD_START } else { 0 };
    claims.sort_by_key(|claim| std::cmp::Reverse(urgency(claim)));
    claims
}

/// Sweeps that take as long as the hierarchy of a cold start, or as all of another one, which is not split.
pub(super) fn start_cost(settings: &SolverSettings) -> u32 {
    match &settings.cold_start {
        ColdStart::Hierarchy { level_sweeps } => 3 + level_sweeps,
        ColdStart::Local(rule) => rule.max_sweeps,
        ColdStart::Merged(rule) => 2 * rule.local.max_sweeps,
    }
}

/// Sweeps that take as long as a V-cycle.
pub(super) fn cycle_cost(level_sweeps: u32) -> u32 {
    3 + level_sweeps
}

/// What is left of a frame.
#[derive(Debug)]
pub(super) struct Budget {
    sweeps: f64,
    /// Sweeps of one node each.
    node_sweeps: f64,
    /// Nobody has swept yet.
    untouched: bool,
}

impl Budget {
    pub(super) fn new(settings: &SolverSettings, pace: &Pace) -> Self {
        Self {
            sweeps: settings.max_sweeps_per_frame.map_or(f64::INFINITY, f64::from),
            node_sweeps: settings
                .max_milliseconds
                .map_or(f64::INFINITY, |ms| f64::from(ms) * pace.node_sweeps_per_ms()),
            untouched: true,
        }
    }

    /// The work of `cost` sweeps over `nodes` that cannot be split: whether there is room for it. The first of a frame is
    /// done however long it takes.
    pub(super) fn admits(&mut self, nodes: u32, cost: u32) -> bool {
        let cost = f64::from(cost);
        let fits = self.untouched || (cost <= self.sweeps && cost * f64::from(nodes) <= self.node_sweeps);
        if fits {
            self.spend(nodes, cost);
        }
        fits
    }

    /// So many of the `wanted` sweeps over `nodes` there is room for; for the first of a frame at least one.
    pub(super) fn grant(&mut self, nodes: u32, wanted: u32) -> u32 {
        let room = self.sweeps.min(self.node_sweeps / f64::from(nodes.max(1))).max(0.0);
        let least = f64::from(u32::from(self.untouched));
        let granted = f64::from(wanted).min(room.floor().max(least));
        self.untouched = false;
        self.spend(nodes, granted);
        granted as u32
    }

    fn spend(&mut self, nodes: u32, sweeps: f64) {
        self.sweeps = (self.sweeps - sweeps).max(0.0);
        self.node_sweeps = (self.node_sweeps - sweeps * f64::from(nodes)).max(0.0);
    }
}

/// How fast the GPU sweeps: measured where diagnostics tell, a guess before.
#[derive(Resource, Debug, Default)]
pub(crate) struct Pace {
    guess: f64,
    /// Fading sums over frames with sweeps.
    node_sweeps: f64,
    ms: f64,
    last: Option<Instant>,
}

/// Sweeps of a node per millisecond of Mesa's llvmpipe on two cores, and of a slow GPU.
const SOFTWARE: f64 = 5e3;
const HARDWARE: f64 = 2e5;
/// What stays of the sums from frame to frame.
const FADE: f64 = 0.9;

impl Pace {
    fn node_sweeps_per_ms(&self) -> f64 {
        if self.ms > 0.0 {
            self.node_sweeps / self.ms
        } else {
            self.guess
        }
    }

    /// Takes over what the diagnostics know of earlier frames, and what this frame is about to do.
    pub(super) fn learn(&mut self, frame: &Frame, status: &GpuStatus, diagnostics: Option<&DiagnosticsStore>) {
        self.guess = if status.is_software() { SOFTWARE } else { HARDWARE };
        if frame.node_sweeps == 0 {
            return;
        }
        self.node_sweeps = FADE * self.node_sweeps + frame.node_sweeps as f64;
        let path = DiagnosticPath::const_new("render/pattern_sweeps/elapsed_gpu");
        let measured = diagnostics.and_then(|store| store.get(&path)?.measurement());
        if let Some(measured) = measured.filter(|measured| self.last != Some(measured.time)) {
            self.last = Some(measured.time);
            self.ms = FADE * self.ms + measured.value;
        }
    }
}
