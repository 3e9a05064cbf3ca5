//! The dispatches of sweeps over the mesh: colour class by colour class, apart for patterns of one wave and of two.

use super::{Member, PLAIN, Pass, Planner, SOFT, StepUniform, Sweeps};
use crate::wave::settings::ColdStart;
use std::ops::Range;

impl Planner<'_> {
    /// Items over each colour class of the mesh, of the members with one wave and of those with two.
    fn fine_classes<'m>(&mut self, members: impl Iterator<Item = &'m Member> + Clone) -> [Vec<Range<u32>>; 2] {
        [1, 2].map(|waves| self.class_items(members.clone().filter(move |member| member.waves == waves), 0))
    }

    /// A sweep over the mesh.
    fn relax_fine(&mut self, classes: &[Vec<Range<u32>>; 2], relaxation: u32, omega: f32) {
        self.frame.sweeps += u32::from(classes.iter().any(|classes| !classes.is_empty()));
        for (kind, classes) in (0..).zip(classes) {
            self.relax(Pass::SweepFine, kind, classes, relaxation, omega);
        }
    }

    /// Soft sweeps, then plain ones. Those with fewer sweeps join for the last ones, so that all share dispatches.
    pub(super) fn sweeps(&mut self, sweeping: &[(Member, Sweeps)]) {
        for (member, sweeps) in sweeping {
            self.frame.pattern_sweeps += sweeps.soft + sweeps.plain;
            self.frame.node_sweeps += u64::from(sweeps.soft + sweeps.plain) * u64::from(member.graph.vertices);
        }
        let omega = self.settings.omega;
        self.joining(
            sweeping,
            |sweeps| sweeps.soft,
            |planner, items, first| {
                // After unit phasors the first sweep is not over-relaxed: it would overshoot.
                planner.relax_fine(items, SOFT, if first { 1.0 } else { omega });
            },
        );
        self.joining(
            sweeping,
            |sweeps| sweeps.plain,
            |planner, items, _| {
                planner.relax_fine(items, PLAIN, 1.0);
            },
        );
    }

    /// Calls `sweep` as often as the largest `count`, with the classes of those that take part, and whether one of them
    /// begins on unit phasors.
    fn joining(
        &mut self,
        sweeping: &[(Member, Sweeps)],
        count: impl Fn(&Sweeps) -> u32,
        sweep: impl Fn(&mut Self, &[Vec<Range<u32>>; 2], bool),
    ) {
        let longest = sweeping.iter().map(|(_, sweeps)| count(sweeps)).max().unwrap_or(0);
        let (mut taking_part, mut classes) = (0, <[Vec<_>; 2]>::default());
        for n in 0..longest {
            let takes_part = |sweeps: &Sweeps| n + count(sweeps) >= longest;
            let now = || sweeping.iter().filter(|(_, sweeps)| takes_part(sweeps));
            // Nobody leaves before the end.
            if now().count() != taking_part {
                taking_part = now().count();
                classes = self.fine_classes(now().map(|(member, _)| member));
            }
            let first = now().any(|(_, sweeps)| sweeps.from_unit && n + count(sweeps) == longest);
            sweep(self, &classes, first);
        }
    }

    /// The local rule: as many sweeps as allowed; entities whose energy has settled take part no more.
    pub(super) fn local(&mut self, cold: &[Member]) {
        let ColdStart::Local(rule) = &self.settings.cold_start else {
            return;
        };
        let rule = rule.clone();
        let uniform = StepUniform {
            momentum: rule.momentum,
            epsilon: rule.epsilon,
            ..StepUniform::default()
        };
        let vertices = self.partial_sums(cold, |member| member.graph.vertices);
        self.step(Pass::StartLocal, &vertices, uniform);
        let classes = self.fine_classes(cold.iter());
        let partials = self.sums_of(cold, |member| member.graph.vertices);
        for n in 0..rule.max_sweeps {
            self.frame.sweeps += u32::from(classes.iter().any(|classes| !classes.is_empty()));
            for (kind, classes) in (0..).zip(&classes) {
                let skipped = if rule.skip_last_third && n % 2 == 1 {
                    classes.len() / 3
                } else {
                    0
                };
                for items in &classes[..classes.len() - skipped] {
                    self.step_of_kind(Pass::SweepLocal, kind, items, uniform);
                }
            }
            if rule.epsilon > 0.0 {
                self.step(Pass::EnergyPartial, &vertices, uniform);
                self.step(Pass::EnergyTotal, &partials, uniform);
                self.step(Pass::Decide, &partials, uniform);
            }
        }
    }
}
