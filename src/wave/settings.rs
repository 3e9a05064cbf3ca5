//! How waves are solved: what a user can set, and what of it counts.
//!
//! In: [`SolverSettings`], with any numbers. Out: settings in range, which neither make a phasor that is not a number nor
//! keep a GPU busy for longer than its driver waits.

use crate::error::PatternError;
use bevy::prelude::*;

/// How waves are solved. The defaults are good; all numbers are sweeps over all vertices unless said otherwise.
///
/// A value outside its range counts as the nearest one inside, one that is not finite as the default; the plugin says so
/// once in the log.
#[derive(Resource, Reflect, Debug, Clone, PartialEq)]
#[reflect(Resource, Default)]
pub struct SolverSettings {
    /// How a pattern starts when nothing is known. Default: [`ColdStart::Hierarchy`].
    pub cold_start: ColdStart,
    /// Soft sweeps on the mesh after the hierarchy, 0..=[`MAX_SWEEPS`](Self::MAX_SWEEPS). Default 10.
    pub soft_sweeps: u32,
    /// Plain sweeps that end every solve; they never raise the energy. 0..=[`MAX_SWEEPS`](Self::MAX_SWEEPS), default 4.
    pub plain_sweeps: u32,
    /// Soft sweeps per frame while an input changes, 1..=[`MAX_SWEEPS`](Self::MAX_SWEEPS). Default 3; 1 follows slowly, 10
    /// is nearly converged.
    pub warm_sweeps: u32,
    /// Sweeps on each coarse level before the soft sweeps of a changed input: a V-cycle, 0..=[`MAX_SWEEPS`](Self::MAX_SWEEPS).
    /// It moves whole stretches of the pattern at once, smoothly: less energy, above all while frequencies change, for more
    /// motion. Default 0: none; 1 or 2 are enough.
    pub warm_level_sweeps: u32,
    /// Over-relaxation ω of soft sweeps and of the hierarchy's levels, 0.1..=1.95; below 1 it is under-relaxation. Default
    /// 1.6.
    pub omega: f32,
    /// Exponent p of z ← z |z|^(p-1) in soft sweeps, 0..=1: 0 keeps unit phasors, 1 is linear. Default 0.9.
    pub softness: f32,
    /// At most so many sweeps in a frame, 1 or more, a sweep of each of two patterns counting as two. What is left is done in
    /// the next frames: first what is seen, but nothing waits for ever. A cold start, which begins with the hierarchy, counts
    /// as `4 + level_sweeps` besides its sweeps, a change of inputs as one; the first pattern of a frame is served however
    /// much it counts. Default `None`: all is done at once.
    pub max_sweeps_per_frame: Option<u32>,
    /// At most so many milliseconds of the GPU in a frame, above 0, by an estimate: sweeps take as long as they did in earlier
    /// frames, where Bevy's `RenderDiagnosticsPlugin` measures that, or else as long as on a slow GPU. Otherwise as
    /// [`max_sweeps_per_frame`](Self::max_sweeps_per_frame). Default `None`.
    pub max_milliseconds: Option<f32>,
}

/// How a pattern starts when nothing is known.
#[derive(Reflect, Debug, Clone, PartialEq)]
pub enum ColdStart {
    /// The Galerkin hierarchy: no random numbers, long waves come out right at once.
    Hierarchy {
        /// Sweeps on each coarse level, 0..=[`MAX_SWEEPS`](SolverSettings::MAX_SWEEPS); the soft sweeps take over on the
        /// mesh. Default 4.
        level_sweeps: u32,
    },
    /// The local rule as Lichtenberg et al. 2018 print it (section 3.3): random phases from a hash of the vertex id,
    /// then coloured sweeps with momentum. Slow to find long waves; selectable for comparison. A budget does not split it: as many
    /// patterns start in a frame as fit into that whole, and one in any case.
    Local(LocalRule),
    /// The same rule on ever finer surfaces of merged vertices, as the paper's section 3.4 has it. Between the other two in
    /// quality; only good where field and frequency are smooth; for comparison. Only [`solve_cpu`](super::solver::solve_cpu)
    /// has it: the plugin says so in the log, and starts by the default.
    Merged(MergedRule),
}

/// Parameters of [`ColdStart::Merged`].
#[derive(Reflect, Debug, Clone, PartialEq)]
pub struct MergedRule {
    /// At most so many surfaces above the mesh, each with about half the vertices of the one before; 0..=32, default 10.
    pub levels: u32,
    /// The rule on each surface; it ends on each for itself.
    pub local: LocalRule,
}

impl Default for MergedRule {
    fn default() -> Self {
        Self {
            levels: 10,
            local: LocalRule::default(),
        }
    }
}

/// Parameters of [`ColdStart::Local`].
#[derive(Reflect, Debug, Clone, PartialEq)]
pub struct LocalRule {
    /// Momentum s_m of Eq. 10, 0..=1. Default 0.2.
    pub momentum: f32,
    /// Ends when |E_before - E| / E_before of one sweep falls below this (Eq. 12), 0..=1. Default 1e-3; 0 never ends early.
    pub epsilon: f32,
    /// At most this many sweeps, 1..=[`MAX_SWEEPS`](SolverSettings::MAX_SWEEPS). Default 100.
    pub max_sweeps: u32,
    /// Leave out the last third of the colours in every second sweep.
    pub skip_last_third: bool,
}

impl Default for LocalRule {
    fn default() -> Self {
        Self {
            momentum: 0.2,
            epsilon: 1e-3,
            max_sweeps: 100,
            skip_last_third: false,
        }
    }
}

impl Default for ColdStart {
    fn default() -> Self {
        Self::Hierarchy { level_sweeps: 4 }
    }
}

impl Default for SolverSettings {
    fn default() -> Self {
        Self {
            cold_start: ColdStart::default(),
            soft_sweeps: 10,
            plain_sweeps: 4,
            warm_sweeps: 3,
            warm_level_sweeps: 0,
            omega: 1.6,
            softness: 0.9,
            max_sweeps_per_frame: None,
            max_milliseconds: None,
        }
    }
}

impl SolverSettings {
    /// The most sweeps of one kind: all of them are done in one frame.
    pub const MAX_SWEEPS: u32 = 1000;

    /// Whether every value is in its range.
    ///
    /// # Errors
    /// [`OutOfRange`](PatternError::OutOfRange) with the first value that is not.
    pub fn check(&self) -> Result<(), PatternError> {
        self.clone().put_right().map_or(Ok(()), Err)
    }

    /// The nearest settings that are in range.
    pub fn valid(&self) -> Self {
        let mut valid = self.clone();
        valid.put_right();
        valid
    }

    /// Makes every value valid; the first that was not.
    fn put_right(&mut self) -> Option<PatternError> {
        let default = Self::default();
        let mut errors = [
            sweeps("SolverSettings::soft_sweeps", &mut self.soft_sweeps, 0),
            sweeps("SolverSettings::plain_sweeps", &mut self.plain_sweeps, 0),
            sweeps("SolverSettings::warm_sweeps", &mut self.warm_sweeps, 1),
            sweeps("SolverSettings::warm_level_sweeps", &mut self.warm_level_sweeps, 0),
            real(
                "SolverSettings::omega",
                &mut self.omega,
                default.omega,
                (0.1, 1.95),
                "0.1..=1.95",
            ),
            real(
                "SolverSettings::softness",
                &mut self.softness,
                default.softness,
                (0.0, 1.0),
                "0..=1",
            ),
            self.cold_start.put_right(),
            self.put_budget_right(),
        ];
        errors.iter_mut().find_map(Option::take)
    }
}

impl SolverSettings {
    /// Sweeps are at least 1; what is no time is no limit.
    fn put_budget_right(&mut self) -> Option<PatternError> {
        if self.max_sweeps_per_frame == Some(0) {
            self.max_sweeps_per_frame = Some(1);
            return Some(PatternError::OutOfRange {
                what: "SolverSettings::max_sweeps_per_frame",
                value: 0.0,
                expected: "1 or more",
            });
        }
        let wrong = self.max_milliseconds.filter(|&ms| !(ms > 0.0 && ms.is_finite()))?;
        self.max_milliseconds = None;
        Some(PatternError::OutOfRange {
            what: "SolverSettings::max_milliseconds",
            value: wrong,
            expected: "above 0",
        })
    }
}

impl ColdStart {
    fn put_right(&mut self) -> Option<PatternError> {
        match self {
            Self::Hierarchy { level_sweeps } => sweeps("ColdStart::Hierarchy::level_sweeps", level_sweeps, 0),
            Self::Local(rule) => rule.put_right(),
            Self::Merged(rule) => {
                let given = rule.levels;
                rule.levels = given.min(32);
                let levels = (rule.levels != given).then_some(PatternError::OutOfRange {
                    what: "MergedRule::levels",
                    value: given as f32,
                    expected: "0..=32",
                });
                let local = rule.local.put_right();
                levels.or(local)
            }
        }
    }
}

impl LocalRule {
    fn put_right(&mut self) -> Option<PatternError> {
        let default = Self::default();
        let mut errors = [
            sweeps("LocalRule::max_sweeps", &mut self.max_sweeps, 1),
            real(
                "LocalRule::momentum",
                &mut self.momentum,
                default.momentum,
                (0.0, 1.0),
                "0..=1",
            ),
            real(
                "LocalRule::epsilon",
                &mut self.epsilon,
                default.epsilon,
                (0.0, 1.0),
                "0..=1",
            ),
        ];
        errors.iter_mut().find_map(Option::take)
    }
}

fn sweeps(what: &'static str, value: &mut u32, least: u32) -> Option<PatternError> {
    let given = *value;
    *value = given.clamp(least, SolverSettings::MAX_SWEEPS);
    (*value != given).then_some(PatternError::OutOfRange {
        what,
        value: given as f32,
        expected: if least == 0 {
            "0..=1000 sweeps"
        } else {
            "1..=1000 sweeps"
        },
    })
}

fn real(
    what: &'static str,
    value: &mut f32,
    default: f32,
    (least, most): (f32, f32),
    expected: &'static str,
) -> Option<PatternError> {
    let given = *value;
    *value = if given.is_finite() {
        given.clamp(least, most)
    } else {
        default
    };
    (*value != given).then_some(PatternError::OutOfRange {
        what,
        value: given,
        expected,
    })
}

/// The settings that count.
#[derive(Resource, Default, Deref)]
pub(crate) struct ValidSettings(SolverSettings);

/// Takes changed settings over, and says once what is wrong with them.
pub(crate) fn check_settings(
    given: Option<Res<SolverSettings>>,
    mut valid: ResMut<ValidSettings>,
    mut said: Local<String>,
) {
    let Some(given) = given.filter(DetectChanges::is_changed) else {
        return;
    };
    valid.0 = given.valid();
    let mut wrong = given.check().err().map(|error| error.to_string()).unwrap_or_default();
    if matches!(given.cold_start, ColdStart::Merged(_)) {
        valid.0.cold_start = ColdStart::default();
        wrong = "ColdStart::Merged is for solve_cpu; the GPU has no surfaces of merged vertices".into();
    }
    if !wrong.is_empty() && wrong != *said {
        error!("{wrong}; the nearest valid value, or the default, is used instead");
    }
    *said = wrong;
}
