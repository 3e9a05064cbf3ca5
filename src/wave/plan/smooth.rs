//! The dispatches that smooth fields: up the levels, down again with sweeps.

use super::{Member, Pass, Planner, StepUniform};

/// Sweeps on each level above the mesh; as in `field/smooth.rs`.
const LEVEL_SWEEPS: u32 = 4;

impl Planner<'_> {
    /// `members` and their numbers of sweeps over the mesh.
    pub(super) fn smooth(&mut self, members: &[(Member, u32)]) {
        // Those with more sweeps come first, so that each sweep is made by the first few.
        let mut sorted: Vec<&(Member, u32)> = members.iter().collect();
        sorted.sort_by_key(|(_, steps)| std::cmp::Reverse(*steps));
        let all: Vec<Member> = sorted.iter().map(|(member, _)| member.clone()).collect();
        let uniform = StepUniform::default();
        let depth = all.iter().map(Member::levels).max().unwrap_or(0);
        let items = self.level_items(&all, 0);
        self.step(Pass::SmoothConstrain, &items, uniform);
        for level in 1..depth {
            let items = self.items(|planner| {
                for member in all.iter().filter(|member| level < member.levels()) {
                    planner.push_items(member.record, level - 1, 0, member.nodes(level));
                }
            });
            self.step(Pass::SmoothRestrict, &items, uniform);
        }
        for level in (0..depth).rev() {
            let (top, below) = (level + 1, level + 2);
            let items = self.items(|planner| {
                for member in all.iter().filter(|member| member.levels() == top) {
                    planner.push_items(member.record, level, 0, member.nodes(level));
                }
            });
            self.step(Pass::SmoothStart, &items, uniform);
            let items = self.items(|planner| {
                for member in all.iter().filter(|member| member.levels() >= below) {
                    planner.push_items(member.record, level, 0, member.nodes(level));
                }
            });
            self.step(Pass::SmoothProlong, &items, uniform);
            let mut classes = (0, Vec::new());
            let most = sorted.first().map_or(0, |(_, steps)| *steps);
            for n in 0..if level == 0 { most } else { LEVEL_SWEEPS } {
                let taking_part = if level == 0 {
                    sorted.partition_point(|(_, steps)| *steps > n)
                } else {
                    all.len()
                };
                if classes.0 != taking_part {
                    let members = all[..taking_part].iter().filter(|member| level < member.levels());
                    classes = (taking_part, self.class_items(members, level));
                }
                for items in &classes.1 {
                    self.step(Pass::SmoothSweep, items, uniform);
                }
            }
        }
    }
}
