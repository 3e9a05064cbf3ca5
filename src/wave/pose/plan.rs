//! The dispatches of surfaces that move: before all others of a frame, for these start from where vertices are.

use crate::wave::{
    frame::{Pass, StepUniform},
    plan::{Member, Planner},
};

impl Planner<'_> {
    /// Positions, normals and areas.
    pub(crate) fn pose(&mut self, posed: &[Member]) {
        self.pass_over_vertices(Pass::PoseVertices, posed);
        self.pass_over_vertices(Pass::PoseNormals, posed);
    }

    /// Lines of principal curvature; `members` and their numbers of steps of smoothing.
    pub(crate) fn curvature(&mut self, members: &[(Member, u32)]) {
        let with = |least: u32| -> Vec<Member> {
            let taking_part = members.iter().filter(|(_, steps)| *steps >= least);
            taking_part.map(|(member, _)| member.clone()).collect()
        };
        self.pass_over_vertices(Pass::Deviators, &with(0));
        let smoothed = with(1);
        let whole = self.sums_of(&smoothed, |member| member.graph.vertices);
        self.step(Pass::Limit, &whole, StepUniform::default());
        self.pass_over_vertices(Pass::Transports, &smoothed);
        let (mut items, mut count) = (0..0, 0);
        for round in 0..members.iter().map(|(_, steps)| *steps).max().unwrap_or(0) {
            let going = with(round + 1);
            if going.len() != count {
                count = going.len();
                items = self.level_items(&going, 0);
            }
            let uniform = StepUniform {
                round,
                ..StepUniform::default()
            };
            self.step(Pass::SmoothLines, &items, uniform);
        }
    }
}
