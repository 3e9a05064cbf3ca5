//! What patterns cost and how good they are, as Bevy diagnostics.
//!
//! [`PatternDiagnosticsPlugin`] publishes counts of the main world. Energies and branches are summed on the GPU, and GPU
//! times are taken, only while somebody adds Bevy's `RenderDiagnosticsPlugin`, and on devices that can query timestamps;
//! their paths are listed here as well.

use crate::wave::{PatternArena, SolverCounters};
use bevy::{
    diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic},
    prelude::*,
};

/// Weighted mean of 1 - cos of the phase by which edges are off, over all patterns: 0 is perfect, 1 is random. Of
/// the last frame that solved.
pub const ENERGY: DiagnosticPath = DiagnosticPath::const_new("render/pattern_energy");
/// Triangles in which a stripe begins or ends, over all patterns. Of the last frame that solved.
pub const BRANCHES: DiagnosticPath = DiagnosticPath::const_new("render/pattern_branches");
/// GPU time of projecting axes, in milliseconds.
pub const FIELD_TIME: DiagnosticPath = DiagnosticPath::const_new("render/pattern_field/elapsed_gpu");
/// GPU time of the edge pass, in milliseconds.
pub const EDGE_TIME: DiagnosticPath = DiagnosticPath::const_new("render/pattern_edges/elapsed_gpu");
/// GPU time of the hierarchy of cold starts, in milliseconds.
pub const HIERARCHY_TIME: DiagnosticPath = DiagnosticPath::const_new("render/pattern_hierarchy/elapsed_gpu");
/// GPU time of sweeps over the mesh, in milliseconds.
pub const SWEEP_TIME: DiagnosticPath = DiagnosticPath::const_new("render/pattern_sweeps/elapsed_gpu");

/// Dispatches of the last frame: 0 while all patterns sleep.
pub const DISPATCHES: DiagnosticPath = DiagnosticPath::const_new("pattern/dispatches");
/// Sweeps over the mesh in the last frame.
pub const SWEEPS: DiagnosticPath = DiagnosticPath::const_new("pattern/sweeps");
/// Bytes of GPU memory owned by patterns and their graphs.
pub const MEMORY: DiagnosticPath = DiagnosticPath::const_new("pattern/memory");

/// Whether [`ENERGY`] and [`BRANCHES`] are measured where they can be. Default: yes; it costs about as much as two sweeps
/// in each frame that solves.
#[derive(Resource, Debug, Clone, Copy, PartialEq, Eq)]
pub struct QualityReport(pub bool);

impl Default for QualityReport {
    fn default() -> Self {
        Self(true)
    }
}

/// Publishes [`DISPATCHES`], [`SWEEPS`] and [`MEMORY`].
#[derive(Debug, Default, Clone, Copy)]
pub struct PatternDiagnosticsPlugin;

impl Plugin for PatternDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        app.register_diagnostic(Diagnostic::new(DISPATCHES))
            .register_diagnostic(Diagnostic::new(SWEEPS))
            .register_diagnostic(Diagnostic::new(MEMORY).with_suffix(" bytes"))
            .add_systems(Last, measure);
    }
}

fn measure(mut diagnostics: Diagnostics, counters: Res<SolverCounters>, arena: Res<PatternArena>) {
    diagnostics.add_measurement(&DISPATCHES, || f64::from(counters.dispatches()));
    diagnostics.add_measurement(&SWEEPS, || f64::from(counters.sweeps()));
    diagnostics.add_measurement(&MEMORY, || arena.memory().used as f64);
}
