//! A tree of blood vessels that grows into a room without touching itself.
//!
//! In: where and how wide it begins, how thin it may get, a room as a signed distance, a seed. Out: a smooth closed
//! surface, and at any point the direction in which the blood flows. Radii and angles at a fork follow Murray's law (the
//! cubes of the radii add up); of several ways to turn a fork the one with most room is taken.

use bevy::prelude::*;
use std::f32::consts::TAU;

use super::{
    implicit::{Tube, smooth_union},
    isosurface,
    mesh_file::RawMesh,
    shapes::Random,
};

/// How a tree grows.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    /// The root.
    pub root: Vec3,
    /// Which way the trunk goes.
    pub towards: Vec3,
    /// Radius of the trunk.
    pub radius: f32,
    /// Branches thinner than this do not grow.
    pub thinnest: f32,
    /// Length of the trunk; branches get shorter as they get thinner.
    pub length: f32,
    /// Which tree.
    pub seed: u64,
}

impl Default for Growth {
    fn default() -> Self {
        Self {
            root: Vec3::new(0.1, -1.25, 0.0),
            towards: Vec3::new(-0.1, 1.0, 0.0),
            radius: 0.12,
            thinnest: 0.022,
            length: 0.5,
            seed: 1,
        }
    }
}

/// A tree of tubes.
#[derive(Clone, Debug)]
pub struct VesselTree {
    tubes: Vec<Tube>,
}

impl Default for VesselTree {
    /// A tree about 2.5 units high, in a room like an egg.
    fn default() -> Self {
        Self::grow(&Growth::default(), |p| (p / Vec3::new(1.3, 1.2, 0.9)).length() - 1.0)
    }
}

/// A branch that is yet to grow.
struct Bud {
    from: Vec3,
    towards: Vec3,
    radius: f32,
    /// The side that the fork before lay in.
    side: Vec3,
    parent: Option<usize>,
}

impl VesselTree {
    /// Grows a tree where `room` is negative, thick branches first.
    pub fn grow(growth: &Growth, room: impl Fn(Vec3) -> f32) -> Self {
        let mut random = Random(growth.seed);
        let mut tubes: Vec<Tube> = Vec::new();
        let towards = growth.towards.normalize();
        let mut buds = vec![Bud {
            from: growth.root,
            towards,
            radius: growth.radius,
            side: towards.any_orthonormal_vector(),
            parent: None,
        }];
        while let Some(thickest) = (0..buds.len()).max_by(|&a, &b| buds[a].radius.total_cmp(&buds[b].radius)) {
            let bud = buds.swap_remove(thickest);
            let Some(tube) = sprout(growth, &bud, &tubes, &room, &mut random) else {
                continue;
            };
            buds.extend(fork(&tube, bud.side, tubes.len(), growth.thinnest, &mut random));
            tubes.push(tube);
        }
        Self { tubes }
    }

    /// The number of branches.
    pub fn branches(&self) -> usize {
        self.tubes.len()
    }

    /// Distance from the wall, negative inside.
    pub fn distance(&self, p: Vec3) -> f32 {
        let mut distance = f32::INFINITY;
        for tube in &self.tubes {
            // Thick branches come first: a fork's fillet is as wide as the thinner branch.
            let blend = 0.8 * tube.points()[0].w;
            if tube.at_least(p) < distance + blend {
                distance = match distance {
                    f32::INFINITY => tube.distance(p).0,
                    _ => smooth_union(distance, tube.distance(p).0, blend),
                };
            }
        }
        distance
    }

    /// The direction of the flow, away from the root: that of the branches nearby, of length 1 or less.
    pub fn flow(&self, p: Vec3) -> Vec3 {
        const REACH: f32 = 0.03;
        let near: Vec<_> = self.tubes.iter().map(|tube| tube.distance(p)).collect();
        let nearest = near.iter().map(|(d, _)| *d).fold(f32::INFINITY, f32::min);
        let (sum, weights) = near.iter().fold((Vec3::ZERO, 0.0), |(sum, weights), (d, along)| {
            let weight = ((nearest - d) / REACH).exp();
            (sum + weight * along, weights + weight)
        });
        sum / weights
    }

    /// The wall with edges about `edge` long; half the thinnest radius shows every branch.
    pub fn mesh(&self, edge: f32) -> RawMesh {
        let points = || self.tubes.iter().flat_map(Tube::points);
        let room = |p: &Vec4| p.w + 3.0 * edge;
        let min = points().map(|p| p.xyz() - room(p)).fold(Vec3::INFINITY, Vec3::min);
        let max = points().map(|p| p.xyz() + room(p)).fold(Vec3::NEG_INFINITY, Vec3::max);
        isosurface::mesh(|p| self.distance(p), min, max, edge)
    }
}

/// The branch with most room around it, shorter where there is little; `None` where there is none.
fn sprout(
    growth: &Growth,
    bud: &Bud,
    tubes: &[Tube],
    room: &impl Fn(Vec3) -> f32,
    random: &mut Random,
) -> Option<Tube> {
    let length = growth.length * (bud.radius / growth.radius).powf(0.5) * (1.0 + 0.15 * random.signed());
    [1.0, 0.75, 0.55].into_iter().find_map(|share| {
        let ways = (0..40).map(|i| {
            let spread = 0.25 + 0.02 * i as f32;
            let way = (bud.towards + spread * random.direction()).normalize();
            let tube = branch(bud, way, share * length, random);
            let clearance = clearance(&tube, tubes, bud.parent, room);
            // Enough is enough: from there on straight is better than free.
            (
                clearance.min(3.0 * bud.radius) - 0.5 * spread * bud.radius,
                clearance,
                tube,
            )
        });
        let (_, clearance, tube) = ways.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (clearance > 0.8 * bud.radius || bud.parent.is_none()).then_some(tube)
    })
}

/// A branch that leaves as its bud points, ends as `way` points, and winds a little.
fn branch(bud: &Bud, way: Vec3, length: f32, random: &mut Random) -> Tube {
    const POINTS: u8 = 14;
    let to = bud.from + length * (0.4 * bud.towards + 0.6 * way);
    let side = way.any_orthonormal_vector();
    let winding = 0.05 * length * (random.signed() * side + random.signed() * way.cross(side));
    let point = |i: u8| {
        let t = f32::from(i) / f32::from(POINTS - 1);
        // A cubic from tangent to tangent.
        let (s, u) = (t * t * (3.0 - 2.0 * t), t * (1.0 - t));
        let tangents = length * (u * (1.0 - t) * bud.towards - u * t * way);
        let p = bud.from.lerp(to, s) + tangents + winding * (TAU * t).sin() * u * 4.0;
        p.extend(bud.radius * (1.0 - 0.08 * t))
    };
    Tube::new((0..POINTS).map(point).collect())
}

/// How far the outer half of a branch is from all others and from the walls of the room.
fn clearance(tube: &Tube, others: &[Tube], parent: Option<usize>, room: &impl Fn(Vec3) -> f32) -> f32 {
    let half = &tube.points()[tube.points().len() / 2..];
    half.iter()
        .map(|p| {
            let from_others = others
                .iter()
                .enumerate()
                .filter(|(i, _)| Some(*i) != parent)
                .map(|(_, other)| other.distance(p.xyz()).0);
            from_others.fold(-room(p.xyz()), f32::min) - p.w
        })
        .fold(f32::INFINITY, f32::min)
}

/// The two buds at the end of a branch, unless they would be too thin.
fn fork(tube: &Tube, side: Vec3, parent: usize, thinnest: f32, random: &mut Random) -> Vec<Bud> {
    let &[.., before, end] = tube.points() else {
        return Vec::new();
    };
    let along = (end - before).xyz().normalize_or_zero();
    // The plane of a fork is across the last one's, more or less.
    let turn = Quat::from_axis_angle(along, 0.25 * TAU + 0.5 * random.signed());
    let side = (turn * side.reject_from(along)).normalize_or(along.any_orthonormal_vector());
    let share = 0.5 + 0.24 * random.unit();
    let radii = [share, 1.0 - share].map(|share| end.w * share.cbrt());
    [(0, side), (1, -side)]
        .into_iter()
        .filter(|&(i, _)| radii[i] >= thinnest)
        .map(|(i, side)| {
            let (own, other) = (radii[i], radii[1 - i]);
            let cosine = (end.w.powi(4) + own.powi(4) - other.powi(4)) / (2.0 * (end.w * own).powi(2));
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
            Bud {
                from: end.xyz(),
                towards: (cosine * along + sine * side).normalize(),
                radius: own,
                side,
                parent: Some(parent),
            }
        })
        .collect()
}
