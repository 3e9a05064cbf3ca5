//! Smooth fields of lines and of crosses.
//!
//! In: per vertex a direction that the field is drawn to, with a weight. Out: a unit tangent per vertex. The unknown of a
//! vertex is the complex number u = cis(N θ), θ being the angle of the field in the vertex's frame (x, n × x), and N its
//! symmetry: 2 for lines, 4 for crosses. The graph's own hierarchy is climbed with the constraints (a node stands where its
//! root vertex stands), solved at the top, and descended with sweeps, colour class by colour class:
//!
//! * intrinsic: u ← Σ (u of the neighbours, carried over by the smallest rotation between the normals) + c, normalised;
//! * extrinsic: each neighbour's d in space, turned by the multiple of a turn / N that fits best, is added, projected and
//!   normalised, as Jakob et al. 2015 do (*Instant Field-Aligned Meshes*, doi:10.1145/2816795.2818078). It sees how the
//!   surface bends: such fields turn towards creases and ridges by themselves.
//!
//! Where the surface moves or the constraints change, sweeps over the mesh continue from the field as it was.

use super::{Alignment, any_tangent, tangent, turn_tangent};
use crate::{
    error::PatternError,
    parallel,
    surface::{Level, SurfaceGraph},
};
use bevy::prelude::*;

/// Sweeps on each level above the mesh.
const LEVEL_SWEEPS: u32 = 4;
/// Normals that are more opposite than this cosine say nothing of each other.
const OPPOSITE: f32 = -0.99;
/// What constraints of the children count in their parent, whose edges stand for fewer than its children's.
const CHILD_WEIGHT: f32 = 0.5;

/// The symmetry of a smoothed field.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default)]
pub enum FieldRing {
    /// Lines: d and -d are the same.
    #[default]
    Two,
    /// Crosses: d, n × d and their opposites are the same. Any of the four is handed on, so that waves have to take quarter
    /// turns for the same as well.
    Four,
}

/// How the directions of two vertices are compared.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default)]
pub enum Smoothing {
    /// Within the surface: how this lies in space does not matter.
    #[default]
    Intrinsic,
    /// In space: the field follows ridges and creases by itself.
    Extrinsic,
}

/// The smoothest field that runs where it must; see [`DirectionField::Smooth`](super::DirectionField).
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default)]
pub struct SmoothField {
    /// Lines or crosses. Default: lines.
    pub ring: FieldRing,
    /// How directions are compared. Default: intrinsic.
    pub smoothing: Smoothing,
    /// What the field is drawn to. Default: principal curvature.
    pub align: Alignment,
    /// How strongly, relative to the neighbours of a vertex, each of which counts 1; finite, 0 or more. Default 1; 100 is
    /// next to fixed.
    pub weight: f32,
    /// Sweeps over the mesh, after those on coarser levels; 1..=1000. Default 20.
    pub steps: u32,
    /// Smooth and align t = n × d, along which the stripes run, in place of d. For stripes that should run along creases,
    /// extrinsically, or along what [`align`](Self::align) names.
    pub quarter_turn: bool,
}

impl Default for SmoothField {
    fn default() -> Self {
        Self {
            ring: FieldRing::default(),
            smoothing: Smoothing::default(),
            align: Alignment::default(),
            weight: 1.0,
            steps: 20,
            quarter_turn: false,
        }
    }
}

impl SmoothField {
    /// The most steps.
    pub const MAX_STEPS: u32 = 1000;

    /// Whether the numbers are in range.
    ///
    /// # Errors
    /// [`OutOfRange`](PatternError::OutOfRange).
    pub fn check(&self) -> Result<(), PatternError> {
        let out_of_range = |what, value, expected| Err(PatternError::OutOfRange { what, value, expected });
        if !(self.weight.is_finite() && self.weight >= 0.0) {
            return out_of_range("SmoothField::weight", self.weight, "finite and 0 or more");
        }
        if !(1..=Self::MAX_STEPS).contains(&self.steps) {
            return out_of_range("SmoothField::steps", self.steps as f32, "1..=1000");
        }
        self.align.check()
    }
}

/// The tangent plane of a node.
#[derive(Debug, Clone, Copy, Default)]
struct Frame {
    x: Vec3,
    n: Vec3,
}

impl Frame {
    fn y(&self) -> Vec3 {
        self.n.cross(self.x)
    }

    /// u of the tangent part of v; zero where v is normal.
    fn power_of(&self, v: Vec3, ring: FieldRing) -> Vec2 {
        let c = Vec2::new(v.dot(self.x), v.dot(self.y()));
        if c.length() > 1e-6 * v.length() {
            power(c.normalize(), ring)
        } else {
            Vec2::ZERO
        }
    }

    /// A direction with this u; x where it is zero.
    fn root_of(&self, u: Vec2, ring: FieldRing) -> Vec3 {
        let angle = match ring {
            FieldRing::Two => 0.5 * u.to_angle(),
            FieldRing::Four => 0.25 * u.to_angle(),
        };
        self.x * angle.cos() + self.y() * angle.sin()
    }

    /// u of the frame `from`, in this one.
    fn carried(&self, u: Vec2, from: &Self, ring: FieldRing) -> Vec2 {
        let c = from.n.dot(self.n);
        if c < OPPOSITE {
            return Vec2::ZERO;
        }
        let w = from.n.cross(self.n);
        let x = from.x + w.cross(from.x) + w.cross(w.cross(from.x)) / (1.0 + c);
        power(Vec2::new(x.dot(self.x), x.dot(self.y())), ring).rotate(u)
    }
}

fn power(c: Vec2, ring: FieldRing) -> Vec2 {
    match ring {
        FieldRing::Two => tangent::squared(c),
        FieldRing::Four => tangent::squared(tangent::squared(c)),
    }
}

/// The representatives of two directions that fit best.
fn compatible(a: Vec3, n_a: Vec3, b: Vec3, n_b: Vec3, ring: FieldRing) -> (Vec3, Vec3) {
    let signed = |a: Vec3, b: Vec3| (a, if a.dot(b) < 0.0 { -b } else { b });
    match ring {
        FieldRing::Two => signed(a, b),
        FieldRing::Four => {
            let (turned_a, turned_b) = (n_a.cross(a), n_b.cross(b));
            let mut best = signed(a, b);
            for (a, b) in [(a, turned_b), (turned_a, b), (turned_a, turned_b)] {
                let pair = signed(a, b);
                if pair.0.dot(pair.1) > best.0.dot(best.1) {
                    best = pair;
                }
            }
            best
        }
    }
}

/// The field at each vertex of `graph`: unit tangents in solver order, turned by `turn` radians. `constraints` are those of
/// [`smooth_constraints`](super::smooth_constraints): a direction per vertex, and its weight.
pub fn smooth_directions(field: &SmoothField, constraints: &[Vec4], turn: f32, graph: &SurfaceGraph) -> Vec<Vec3> {
    let ring = field.ring;
    let frames = frames(graph);
    // Up: what each node is drawn to.
    let mut drawn = vec![powers(constraints, &frames[0], ring)];
    for level in 1..graph.levels.len() {
        let below = &graph.levels[level - 1];
        let sum = |p: usize| {
            let children = below.child_offsets[p] as usize..below.child_offsets[p + 1] as usize;
            let carried = |&child: &u32| {
                let (frame, child) = (&frames[level][p], child as usize);
                frame.carried(drawn[level - 1][child], &frames[level - 1][child], ring)
            };
            CHILD_WEIGHT * below.children[children].iter().map(carried).sum::<Vec2>()
        };
        let above = (0..graph.levels[level].len()).map(sum).collect();
        drawn.push(above);
    }
    // Down.
    let mut u: Vec<Vec2> = Vec::new();
    for (n, level) in graph.levels.iter().enumerate().rev() {
        u = if n + 1 == graph.levels.len() {
            drawn[n].iter().map(|c| c.normalize_or(Vec2::X)).collect()
        } else {
            let child = |i: usize| {
                let parent = level.parents[i] as usize;
                frames[n][i]
                    .carried(u[parent], &frames[n + 1][parent], ring)
                    .normalize_or(Vec2::X)
            };
            (0..level.len()).map(child).collect()
        };
        let sweeps = if n == 0 { field.steps } else { LEVEL_SWEEPS };
        (0..sweeps).for_each(|_| sweep(field, level, &frames[n], &drawn[n], &mut u));
    }
    unit_tangents(field, &u, &frames[0], turn)
}

/// [`smooth_directions`] after `sweeps` sweeps over the mesh that start from `previous`: the field as it was before the
/// surface moved or the constraints changed a little, neither turned nor [`quarter_turn`](SmoothField::quarter_turn)ed.
pub fn follow_smooth_directions(
    field: &SmoothField,
    constraints: &[Vec4],
    previous: &[Vec3],
    sweeps: u32,
    turn: f32,
    graph: &SurfaceGraph,
) -> Vec<Vec3> {
    let frames = &frames(graph)[0];
    let drawn = powers(constraints, frames, field.ring);
    let mut u = parallel::collect(graph.len(), |i| {
        frames[i].power_of(previous[i], field.ring).normalize_or(Vec2::X)
    });
    (0..sweeps).for_each(|_| sweep(field, graph.mesh_level(), frames, &drawn, &mut u));
    unit_tangents(field, &u, frames, turn)
}

/// What each vertex is drawn to.
fn powers(constraints: &[Vec4], frames: &[Frame], ring: FieldRing) -> Vec<Vec2> {
    parallel::collect(frames.len(), |i| {
        constraints[i].w * frames[i].power_of(constraints[i].truncate(), ring)
    })
}

/// Brings every node in line with its neighbours and what it is drawn to, colour class by colour class.
fn sweep(field: &SmoothField, level: &Level, frames: &[Frame], drawn: &[Vec2], u: &mut [Vec2]) {
    for i in 0..level.len() {
        // Nodes are in the order of their colours.
        let neighbors = level.edges(i).map(|k| level.neighbors[k] as usize);
        let neighbors = neighbors.map(|j| (u[j], &frames[j]));
        u[i] = match field.smoothing {
            Smoothing::Intrinsic => relaxed_intrinsic(u[i], drawn[i], &frames[i], neighbors, field.ring),
            Smoothing::Extrinsic => relaxed_extrinsic(u[i], drawn[i], &frames[i], neighbors, field.ring),
        };
    }
}

fn unit_tangents(field: &SmoothField, u: &[Vec2], frames: &[Frame], turn: f32) -> Vec<Vec3> {
    parallel::collect(u.len(), |i| {
        let n = frames[i].n;
        let d = frames[i].root_of(u[i], field.ring);
        let d = if field.quarter_turn { d.cross(n) } else { d };
        turn_tangent(d, n, turn)
    })
}

fn relaxed_intrinsic<'a>(
    u: Vec2,
    drawn: Vec2,
    frame: &Frame,
    neighbors: impl Iterator<Item = (Vec2, &'a Frame)>,
    ring: FieldRing,
) -> Vec2 {
    let sum = neighbors.fold(drawn, |sum, (u, from)| sum + frame.carried(u, from, ring));
    sum.normalize_or(u)
}

fn relaxed_extrinsic<'a>(
    u: Vec2,
    drawn: Vec2,
    frame: &Frame,
    neighbors: impl Iterator<Item = (Vec2, &'a Frame)>,
    ring: FieldRing,
) -> Vec2 {
    let mut d = frame.root_of(u, ring);
    let mut weight = 0.0;
    let mut add = |other: Vec3, n: Vec3, w: f32| {
        let (a, b) = compatible(d, frame.n, other, n, ring);
        let sum = a * weight + b * w;
        d = (sum - frame.n * frame.n.dot(sum)).normalize_or(a);
        weight += w;
    };
    for (u, of) in neighbors {
        add(of.root_of(u, ring), of.n, 1.0);
    }
    let pull = drawn.length();
    if pull > 0.0 {
        add(frame.root_of(drawn, ring), frame.n, pull);
    }
    frame.power_of(d, ring)
}

/// The frames of all nodes of all levels: a node has that of its root vertex.
fn frames(graph: &SurfaceGraph) -> Vec<Vec<Frame>> {
    let frame = |i: usize| Frame {
        x: any_tangent(graph.normals[i]),
        n: graph.normals[i],
    };
    let mut frames = vec![parallel::collect(graph.len(), frame)];
    for below in &graph.levels[..graph.levels.len().saturating_sub(1)] {
        let roots = below.child_offsets[..below.child_offsets.len() - 1].iter();
        let last = &frames[frames.len() - 1];
        let next = roots
            .map(|&first| last[below.children[first as usize] as usize])
            .collect();
        frames.push(next);
    }
    frames
}
