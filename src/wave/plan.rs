//! From who takes part in what to the dispatches of a frame, each of which serves all entities that take part.
//!
//! In: [`Work`]. Out: a [`Frame`]. The number of dispatches depends on levels, colours and sweeps, never on the number of entities.

mod smooth;
mod sweeps;

pub(crate) use smooth::Smoothed;

use super::{
    frame::{BufferCopy, Frame, Pass, ROW, Step, StepUniform},
    pack::PackedGraph,
    settings::{ColdStart, SolverSettings},
};
use std::{ops::Range, sync::Arc};

const PLAIN: u32 = 0;
const TURN: u32 = 1;
const SOFT: u32 = 2;

/// Levels of at most this many nodes are solved by one workgroup in one dispatch.
const SMALL_LEVEL: u32 = 1024;

/// A pattern, as the plan sees it.
#[derive(Debug, Clone)]
pub(crate) struct Member {
    pub(crate) record: u32,
    /// Number of waves.
    pub(crate) waves: u32,
    pub(crate) graph: Arc<PackedGraph>,
}

impl Member {
    fn levels(&self) -> usize {
        self.graph.levels.len()
    }

    fn nodes(&self, level: usize) -> u32 {
        self.graph.levels[level].record.nodes
    }

    /// The first level from which on all levels are small; at least 1, and the number of levels where there is none.
    fn first_small(&self) -> usize {
        let large = self
            .graph
            .levels
            .iter()
            .rposition(|level| level.record.nodes > SMALL_LEVEL);
        large.map_or(1, |large| large + 1).max(1)
    }
}

/// Sweeps over a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Sweeps {
    pub(crate) soft: u32,
    /// They come after the soft ones.
    pub(crate) plain: u32,
    /// The soft ones begin on unit phasors.
    pub(crate) from_unit: bool,
}

/// Which entities take part in what, this frame.
#[derive(Debug, Default)]
pub(crate) struct Work {
    /// The surface has moved.
    pub(crate) posed: Vec<Member>,
    /// Principal curvature is that of a posed surface, with so many steps of smoothing.
    pub(crate) curved: Vec<(Member, u32)>,
    /// Fields are smoothed.
    pub(crate) smooth: Vec<Smoothed>,
    /// Directions are evaluated, from a kind of source (`DIRECTION_*`).
    pub(crate) directions: Vec<(Member, u32)>,
    /// Frequencies are evaluated, from a kind of source (`FREQUENCY_*`).
    pub(crate) frequencies: Vec<(Member, u32)>,
    /// Users' buffers that directions and frequencies come from.
    pub(crate) copies: Vec<BufferCopy>,
    /// An input changed: edge constants are made anew.
    pub(crate) changed: Vec<Member>,
    /// Start from nothing.
    pub(crate) cold: Vec<Member>,
    /// Go through a V-cycle.
    pub(crate) cycling: Vec<Member>,
    /// Sweep over the mesh, after all that.
    pub(crate) sweeping: Vec<(Member, Sweeps)>,
    /// Carry the pattern of another entity, as it is after all that.
    pub(crate) carried: Vec<Member>,
    /// Everything that is drawn, for the report; empty: no report.
    pub(crate) reported: Vec<Member>,
}

impl Work {
    /// Whether the pattern with this record is another one after the frame.
    pub(crate) fn touches(&self, record: u32) -> bool {
        let lists = [&self.posed, &self.changed, &self.cold, &self.cycling];
        let mut members = lists.into_iter().flatten();
        members.any(|member| member.record == record) || self.sweeping.iter().any(|(member, _)| member.record == record)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.posed.is_empty()
            && self.curved.is_empty()
            && self.smooth.is_empty()
            && self.directions.is_empty()
            && self.frequencies.is_empty()
            && self.changed.is_empty()
            && self.cold.is_empty()
            && self.cycling.is_empty()
            && self.sweeping.is_empty()
            && self.carried.is_empty()
            && self.reported.is_empty()
    }
}

/// The dispatches of a frame. `item`: nodes of one item of work, a multiple of 64.
pub(crate) fn plan(work: &Work, settings: &SolverSettings, item: u32, frame: &mut Frame) {
    frame.copies.extend_from_slice(&work.copies);
    let mut planner = Planner { frame, settings, item };
    planner.pose(&work.posed);
    planner.curvature(&work.curved);
    planner.smooth(&work.smooth);
    planner.pass_by_kind(Pass::Directions, &work.directions);
    planner.pass_by_kind(Pass::Frequencies, &work.frequencies);
    let changed: Vec<_> = work
        .changed
        .iter()
        .map(|member| (member.clone(), member.waves - 1))
        .collect();
    planner.pass_by_kind(Pass::EdgeWeights, &changed);
    match &settings.cold_start {
        ColdStart::Hierarchy { level_sweeps } => planner.hierarchy(&work.cold, *level_sweeps, false),
        ColdStart::Local(_) => planner.local(&work.cold),
        // The plugin's settings never say so.
        ColdStart::Merged(_) => {}
    }
    planner.hierarchy(&work.cycling, settings.warm_level_sweeps, true);
    planner.sweeps(&work.sweeping);
    planner.pass_over_vertices(Pass::Carry, &work.carried);
    planner.report(&work.reported);
}

pub(super) struct Planner<'a> {
    frame: &'a mut Frame,
    settings: &'a SolverSettings,
    item: u32,
}

impl Planner<'_> {
    /// Cuts nodes `first..end` of a record's level into items of work.
    fn push_items(&mut self, record: u32, level: usize, first: u32, end: u32) {
        let items = (first..end).step_by(self.item as usize);
        self.frame
            .items
            .extend(items.map(|at| [record, level as u32, at, end.min(at + self.item)]));
    }

    /// The items that `push` appends.
    fn items(&mut self, push: impl FnOnce(&mut Self)) -> Range<u32> {
        let first = self.frame.items.len() as u32;
        push(self);
        first..self.frame.items.len() as u32
    }

    /// Items over all nodes of a level, of the members that have it.
    pub(super) fn level_items(&mut self, members: &[Member], level: usize) -> Range<u32> {
        self.items(|planner| {
            for member in members.iter().filter(|member| level < member.levels()) {
                planner.push_items(member.record, level, 0, member.nodes(level));
            }
        })
    }

    /// Items over each colour class of a level.
    fn class_items<'m>(&mut self, members: impl Iterator<Item = &'m Member> + Clone, level: usize) -> Vec<Range<u32>> {
        let colors = members
            .clone()
            .map(|member| member.graph.levels[level].classes.len() - 1)
            .max()
            .unwrap_or(0);
        let class = |planner: &mut Self, color: usize| {
            for member in members.clone() {
                if let [first, end] = member.graph.levels[level].classes.get(color..color + 2).unwrap_or(&[])[..] {
                    planner.push_items(member.record, level, first, end);
                }
            }
        };
        (0..colors)
            .map(|color| self.items(|planner| class(planner, color)))
            .collect()
    }

    pub(super) fn step(&mut self, pass: Pass, items: &Range<u32>, uniform: StepUniform) {
        self.step_of_kind(pass, 0, items, uniform);
    }

    fn step_of_kind(&mut self, pass: Pass, kind: u32, items: &Range<u32>, uniform: StepUniform) {
        if !items.is_empty() {
            let uniform = StepUniform {
                first_item: items.start,
                item_count: items.end - items.start,
                row: ROW,
                ..uniform
            };
            self.frame.steps.push(Step { pass, kind, uniform });
        }
    }

    pub(super) fn pass_over_vertices(&mut self, pass: Pass, members: &[Member]) {
        let items = self.level_items(members, 0);
        self.step(pass, &items, StepUniform::default());
    }

    /// A pass over the vertices of members, each with its kind.
    fn pass_by_kind(&mut self, pass: Pass, members: &[(Member, u32)]) {
        for kind in 0..pass.kinds() {
            let of_kind = members.iter().filter(|(_, its)| *its == kind);
            let of_kind: Vec<Member> = of_kind.map(|(member, _)| member.clone()).collect();
            let items = self.level_items(&of_kind, 0);
            self.step_of_kind(pass, kind, &items, StepUniform::default());
        }
    }

    fn relax(&mut self, pass: Pass, kind: u32, classes: &[Range<u32>], relaxation: u32, omega: f32) {
        for items in classes {
            let uniform = StepUniform {
                relaxation,
                omega,
                softness: self.settings.softness,
                ..StepUniform::default()
            };
            self.step_of_kind(pass, kind, items, uniform);
        }
    }

    /// The Galerkin cold start, or a V-cycle, which will `keep` phasors as they are on the way up.
    fn hierarchy(&mut self, members: &[Member], level_sweeps: u32, keep: bool) {
        let uniform = StepUniform {
            level_sweeps,
            keep: keep.into(),
            omega: self.settings.omega,
            ..StepUniform::default()
        };
        let depth = members.iter().map(Member::first_small).max().unwrap_or(0);
        // Up, as far as levels are large.
        for level in 0..depth {
            let large: Vec<&Member> = members
                .iter()
                .filter(|member| level < member.first_small() && level + 1 < member.levels())
                .collect();
            let items = self.items(|planner| {
                large
                    .iter()
                    .for_each(|member| planner.push_items(member.record, level, 0, member.nodes(level)));
            });
            self.step(Pass::Align, &items, uniform);
            let items = self.items(|planner| {
                large
                    .iter()
                    .for_each(|member| planner.push_items(member.record, level, 0, member.nodes(level + 1)));
            });
            self.step(Pass::Coarsen, &items, uniform);
        }
        // The top: small levels by one workgroup, or a last level that is large since it has many components.
        let items = self.items(|planner| {
            for member in members.iter().filter(|member| member.first_small() < member.levels()) {
                planner
                    .frame
                    .items
                    .push([member.record, member.first_small() as u32, 0, 1]);
            }
        });
        self.step(Pass::SolveSmall, &items, uniform);
        let items = self.items(|planner| {
            let above_mesh = |member: &&Member| !keep || member.levels() > 1;
            for member in members
                .iter()
                .filter(|member| member.first_small() >= member.levels())
                .filter(above_mesh)
            {
                let top = member.levels() - 1;
                planner.push_items(member.record, top, 0, member.nodes(top));
            }
        });
        self.step(Pass::StartTop, &items, uniform);
        // Down again.
        for level in (0..depth).rev() {
            let large = || {
                members
                    .iter()
                    .filter(move |member| level < member.first_small().min(member.levels()))
            };
            let items = self.items(|planner| {
                for member in large().filter(|member| level + 1 < member.levels()) {
                    planner.push_items(member.record, level, 0, member.nodes(level));
                }
            });
            self.step(Pass::Prolong, &items, uniform);
            if level == 0 {
                break;
            }
            let classes = self.class_items(large(), level);
            for n in 0..level_sweeps {
                let omega = if n == 0 { 1.0 } else { self.settings.omega };
                self.relax(Pass::SweepCoarse, 0, &classes, TURN, omega);
            }
        }
    }

    /// Items (record, partial sum, first, end) over the vertices or triangles of each member.
    fn partial_sums(&mut self, members: &[Member], len: impl Fn(&Member) -> u32) -> Range<u32> {
        self.items(|planner| {
            for member in members {
                let (end, size) = (len(member), planner.item);
                let item = |n: u32| [member.record, n, n * size, end.min((n + 1) * size)];
                planner.frame.items.extend((0..end.div_ceil(size)).map(item));
            }
        })
    }

    /// One item (record, _, 0, partial sums) per member.
    pub(super) fn sums_of(&mut self, members: &[Member], len: impl Fn(&Member) -> u32) -> Range<u32> {
        let size = self.item;
        self.items(|planner| {
            planner.frame.items.extend(
                members
                    .iter()
                    .map(|member| [member.record, 0, 0, len(member).div_ceil(size)]),
            );
        })
    }

    /// Energy and branches of all patterns.
    fn report(&mut self, members: &[Member]) {
        if members.is_empty() {
            return;
        }
        let uniform = StepUniform::default();
        let vertices = self.partial_sums(members, |member| member.graph.vertices);
        self.step(Pass::EnergyPartial, &vertices, uniform);
        let sums = self.sums_of(members, |member| member.graph.vertices);
        self.step(Pass::EnergyTotal, &sums, uniform);
        let triangles = self.partial_sums(members, |member| member.graph.triangles);
        self.step(Pass::BranchesPartial, &triangles, uniform);
        let sums = self.sums_of(members, |member| member.graph.triangles);
        self.step(Pass::BranchesTotal, &sums, uniform);
        self.step(Pass::Report, &sums, uniform);
    }
}
