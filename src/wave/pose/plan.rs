//! The dispatches that pose vertices, before all others of a frame.

use crate::wave::{
    frame::{Pass, StepUniform},
    plan::{Member, Planner},
};

/// A pattern on a surface that moves, in a frame in which it has moved.
#[derive(Debug, Clone)]
pub(crate) struct Posed {
    pub(crate) member: Member,
    /// Steps of smoothing, where the directions are those of principal curvature.
    pub(crate) curvature: Option<u32>,
    /// The directions are made from those at rest.
    pub(crate) carried: bool,
}

impl Planner<'_> {
    /// Positions, normals, and directions that follow from them.
    pub(crate) fn pose(&mut self, posed: &[Posed]) {
        let of = |takes_part: &dyn Fn(&Posed) -> bool| -> Vec<Member> {
            let members = posed.iter().filter(|posed| takes_part(posed));
            members.map(|posed| posed.member.clone()).collect()
        };
        let all = of(&|_| true);
        self.pass_over_vertices(Pass::PoseVertices, &all);
        self.pass_over_vertices(Pass::PoseNormals, &all);
        self.pass_over_vertices(Pass::CarryDirections, &of(&|posed| posed.carried));

        let steps = |posed: &Posed| posed.curvature.unwrap_or(0);
        self.pass_over_vertices(Pass::Deviators, &of(&|posed| posed.curvature.is_some()));
        let smoothed = of(&|posed| steps(posed) > 0);
        let whole = self.sums_of(&smoothed, |member| member.graph.vertices);
        self.step(Pass::Limit, &whole, StepUniform::default());
        self.pass_over_vertices(Pass::Transports, &smoothed);
        let mut items = 0..0;
        let mut members = usize::MAX;
        for round in 0..posed.iter().map(steps).max().unwrap_or(0) {
            let going = of(&|posed| steps(posed) > round);
            if going.len() != members {
                members = going.len();
                items = self.level_items(&going, 0);
            }
            let uniform = StepUniform {
                round,
                ..StepUniform::default()
            };
            self.step(Pass::SmoothLines, &items, uniform);
        }
        self.pass_over_vertices(Pass::CurvatureDirections, &of(&|posed| posed.curvature.is_some()));
    }
}
