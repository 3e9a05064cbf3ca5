//! The dispatches that smooth fields: up the levels, down again with sweeps; or sweeps from where the fields were.

use super::{Member, Pass, Planner, StepUniform};

/// Sweeps on each level above the mesh; as in `field/smooth.rs`.
const LEVEL_SWEEPS: u32 = 4;

/// A field that is smoothed.
#[derive(Debug, Clone)]
pub(crate) struct Smoothed {
    pub(crate) member: Member,
    /// 0: intrinsically, 1: extrinsically.
    pub(crate) kind: u32,
    /// Over the mesh.
    pub(crate) sweeps: u32,
    /// It continues from where it was.
    pub(crate) follows: bool,
}

impl Planner<'_> {
    pub(super) fn smooth(&mut self, fields: &[Smoothed]) {
        let (following, cold): (Vec<&Smoothed>, Vec<&Smoothed>) = fields.iter().partition(|field| field.follows);
        let following_members: Vec<Member> = following.iter().map(|field| field.member.clone()).collect();
        self.pass_over_vertices(Pass::SmoothFollow, &following_members);
        self.smooth_down(&cold);
        self.smooth_sweeps(fields.iter(), 0, |field| field.sweeps);
    }

    /// From nothing, down to the mesh.
    fn smooth_down(&mut self, fields: &[&Smoothed]) {
        let all: Vec<Member> = fields.iter().map(|field| field.member.clone()).collect();
        let uniform = StepUniform::default();
        let depth = all.iter().map(Member::levels).max().unwrap_or(0);
        self.pass_over_vertices(Pass::SmoothConstrain, &all);
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
            if level > 0 {
                self.smooth_sweeps(fields.iter().copied(), level, |_| LEVEL_SWEEPS);
            }
        }
    }

    fn smooth_sweeps<'f>(
        &mut self,
        fields: impl Iterator<Item = &'f Smoothed> + Clone,
        level: usize,
        sweeps: impl Fn(&Smoothed) -> u32,
    ) {
        for kind in 0..Pass::SmoothSweep.kinds() {
            let taking_part = |field: &&Smoothed| field.kind == kind && level < field.member.levels();
            // Those with more sweeps come first, so that each sweep is made by the first few.
            let mut sorted: Vec<&Smoothed> = fields.clone().filter(taking_part).collect();
            sorted.sort_by_key(|field| std::cmp::Reverse(sweeps(field)));
            let most = sorted.first().map_or(0, |field| sweeps(field));
            let mut classes = (0, Vec::new());
            for n in 0..most {
                let count = sorted.partition_point(|field| sweeps(field) > n);
                if classes.0 != count {
                    let members = sorted[..count].iter().map(|field| &field.member);
                    classes = (count, self.class_items(members, level));
                }
                for items in &classes.1 {
                    self.step_of_kind(Pass::SmoothSweep, kind, items, StepUniform::default());
                }
            }
        }
    }
}
