//! How waves are solved, and how that is going.

use bevy::{
    diagnostic::{DiagnosticPath, DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    ecs::system::SystemParam,
    prelude::*,
};
use bevy_egui::egui::{Color32, Grid, Slider, Ui};
use bevy_field_patterns::{
    diagnostics::{BRANCHES, ENERGY},
    prelude::*,
    wave::{
        Pattern, PatternArena, SolverCounters,
        solver::{ColdStart, LocalRule},
    },
};

/// Gives whether the solver is asked to start again.
pub fn solver_section(ui: &mut Ui, solver: &mut SolverSettings) -> bool {
    ui.separator();
    ui.heading("Solver");
    let restart = ui.horizontal(|ui| {
        let is_local = matches!(solver.cold_start, ColdStart::Local(_));
        let hierarchy = ui.selectable_label(!is_local, "Hierarchy");
        if hierarchy.on_hover_text("Starts from coarse to fine").clicked() {
            solver.cold_start = ColdStart::default();
        }
        let local = ui.selectable_label(is_local, "Local");
        if local
            .on_hover_text("Starts with random phases and local sweeps")
            .clicked()
        {
            solver.cold_start = ColdStart::Local(LocalRule::default());
        }
        ui.button("Restart").clicked()
    });
    ui.label("Per frame, while something changes");
    ui.add(Slider::new(&mut solver.warm_sweeps, 1..=20).text("Sweeps"));
    ui.add(Slider::new(&mut solver.warm_level_sweeps, 0..=4).text("On each level"));
    ui.label("At most, per frame");
    limit(ui, &mut solver.max_sweeps_per_frame, 20, |value| {
        Slider::new(value, 1..=200).logarithmic(true).text("Sweeps")
    });
    limit(ui, &mut solver.max_milliseconds, 2.0, |value| {
        Slider::new(value, 0.1..=20.0).logarithmic(true).text("Milliseconds")
    });
    restart.inner
}

/// A limit that may be none; `first` where it is set in.
fn limit<T: Copy>(ui: &mut Ui, limit: &mut Option<T>, first: T, slider: impl FnOnce(&mut T) -> Slider<'_>) {
    ui.horizontal(|ui| {
        let mut is_limited = limit.is_some();
        ui.checkbox(&mut is_limited, "");
        let mut value = limit.unwrap_or(first);
        ui.add_enabled(is_limited, slider(&mut value));
        *limit = is_limited.then_some(value);
    });
}

/// What the panel tells of the patterns.
#[derive(SystemParam)]
pub struct Statistics<'w, 's> {
    pub patterns: Query<'w, 's, (Entity, &'static PatternState, Option<&'static Pattern>)>,
    diagnostics: Res<'w, DiagnosticsStore>,
    counters: Res<'w, SolverCounters>,
    arena: Res<'w, PatternArena>,
}

impl Statistics<'_, '_> {
    fn measured(&self, path: &DiagnosticPath) -> Option<f64> {
        self.diagnostics.get(path)?.smoothed()
    }

    fn latest(&self, path: &DiagnosticPath) -> Option<f64> {
        self.diagnostics.get(path)?.value()
    }

    /// The state of the pattern that is furthest from rest.
    fn state(&self) -> &'static str {
        let is = |wanted: fn(&PatternState) -> bool| self.patterns.iter().any(|(_, state, _)| wanted(state));
        match () {
            () if self.patterns.is_empty() => "none",
            () if is(|state| matches!(state, PatternState::Failed(_))) => "failed",
            () if is(|state| matches!(state, PatternState::Preparing)) => "preparing",
            () if is(|state| matches!(state, PatternState::Solving)) => "solving",
            () => "converged",
        }
    }
}

/// The part of the panel that tells of the patterns.
pub fn statistics_section(ui: &mut Ui, statistics: &Statistics) {
    ui.separator();
    ui.heading("Pattern");
    let errors = statistics.patterns.iter().filter_map(|(_, state, _)| match state {
        PatternState::Failed(error) => Some(error.to_string()),
        _ => None,
    });
    if let Some(error) = errors.into_iter().next() {
        ui.colored_label(Color32::LIGHT_RED, error);
    }
    let patterns = statistics.patterns.iter().filter_map(|(.., pattern)| pattern);
    let vertices: u32 = patterns.map(|pattern| pattern.record().vertices).sum();
    let memory = statistics.arena.memory();
    let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let number =
        |value: Option<f64>, digits: usize| value.map_or("–".to_owned(), |value| format!("{value:.digits$}"));
    let lines = [
        ("State", statistics.state().to_owned()),
        ("Vertices", vertices.to_string()),
        ("Energy", number(statistics.latest(&ENERGY), 5)),
        ("Branches", number(statistics.latest(&BRANCHES), 0)),
        ("Sweeps, last frame", statistics.counters.sweeps().to_string()),
        ("Dispatches, last frame", statistics.counters.dispatches().to_string()),
        (
            "GPU memory",
            format!(
                "{:.1} of {:.1} MiB",
                mebibytes(memory.used),
                mebibytes(memory.allocated)
            ),
        ),
        (
            "Frame",
            format!(
                "{} ms",
                number(statistics.measured(&FrameTimeDiagnosticsPlugin::FRAME_TIME), 1)
            ),
        ),
    ];
    Grid::new("statistics").num_columns(2).show(ui, |ui| {
        for (name, value) in lines {
            ui.weak(name);
            ui.label(value);
            ui.end_row();
        }
    });
}
