//! A four-legged creature: body, skeleton, weights and morph targets.
//!
//! In: an edge length. Out: a smooth closed surface in the rest pose (standing, facing +z, the ground at y = 0, about 2
//! units long), up to four joints per vertex with weights, displacements for breathing and for perking up the ears, and the
//! direction along the nearest limb. [`creature_walk`](super::creature_walk) moves it.

use bevy::prelude::*;

use super::{
    implicit::{ellipsoid, limb, smooth_union},
    isosurface,
    mesh_file::{RawMesh, smooth_normals},
};

/// A joint of the skeleton. Its own axes are the world's in the rest pose.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    pub name: &'static str,
    /// `None`: the root. Parents come before their children.
    pub parent: Option<usize>,
    /// In the rest pose.
    pub position: Vec3,
    /// Where the limb that it moves ends.
    pub end: Vec3,
    /// Of that limb, at the joint and at its end.
    pub radii: Vec2,
}

const fn joint(name: &'static str, parent: usize, position: [f32; 3], end: [f32; 3], radii: [f32; 2]) -> Joint {
    Joint {
        name,
        parent: if parent == usize::MAX { None } else { Some(parent) },
        position: Vec3::from_array(position),
        end: Vec3::from_array(end),
        radii: Vec2::from_array(radii),
    }
}

/// The skeleton: spine from back to front, tail, head with ears, four legs of three joints each.
#[rustfmt::skip]
pub const SKELETON: [Joint; 22] = [
    joint("pelvis", usize::MAX, [0.0, 0.98, -0.50], [0.0, 0.96, -0.22], [0.235, 0.25]),
    joint("spine", 0, [0.0, 0.96, -0.22], [0.0, 0.95, 0.12], [0.25, 0.27]),
    joint("chest", 1, [0.0, 0.95, 0.12], [0.0, 1.00, 0.42], [0.275, 0.255]),
    joint("neck", 2, [0.0, 1.04, 0.46], [0.0, 1.36, 0.76], [0.215, 0.165]),
    joint("head", 3, [0.0, 1.42, 0.82], [0.0, 1.30, 1.13], [0.205, 0.115]),
    joint("ear.left", 4, [0.115, 1.57, 0.77], [0.19, 1.74, 0.73], [0.078, 0.034]),
    joint("ear.right", 4, [-0.115, 1.57, 0.77], [-0.19, 1.74, 0.73], [0.078, 0.034]),
    joint("tail.1", 0, [0.0, 1.06, -0.66], [0.0, 1.07, -0.93], [0.095, 0.072]),
    joint("tail.2", 7, [0.0, 1.07, -0.93], [0.0, 1.17, -1.16], [0.072, 0.066]),
    joint("tail.3", 8, [0.0, 1.17, -1.16], [0.0, 1.38, -1.32], [0.066, 0.06]),
    joint("foreleg.left.1", 2, [0.15, 0.90, 0.38], [0.17, 0.55, 0.33], [0.135, 0.095]),
    joint("foreleg.left.2", 10, [0.17, 0.55, 0.33], [0.17, 0.15, 0.38], [0.092, 0.070]),
    joint("foreleg.left.3", 11, [0.17, 0.13, 0.38], [0.17, 0.072, 0.48], [0.070, 0.072]),
    joint("foreleg.right.1", 2, [-0.15, 0.90, 0.38], [-0.17, 0.55, 0.33], [0.135, 0.095]),
    joint("foreleg.right.2", 13, [-0.17, 0.55, 0.33], [-0.17, 0.15, 0.38], [0.092, 0.070]),
    joint("foreleg.right.3", 14, [-0.17, 0.13, 0.38], [-0.17, 0.072, 0.48], [0.070, 0.072]),
    joint("hindleg.left.1", 0, [0.15, 0.92, -0.50], [0.18, 0.56, -0.42], [0.165, 0.110]),
    joint("hindleg.left.2", 16, [0.18, 0.56, -0.42], [0.18, 0.19, -0.60], [0.100, 0.066]),
    joint("hindleg.left.3", 17, [0.18, 0.16, -0.61], [0.18, 0.074, -0.49], [0.068, 0.074]),
    joint("hindleg.right.1", 0, [-0.15, 0.92, -0.50], [-0.18, 0.56, -0.42], [0.165, 0.110]),
    joint("hindleg.right.2", 19, [-0.18, 0.56, -0.42], [-0.18, 0.19, -0.60], [0.100, 0.066]),
    joint("hindleg.right.3", 20, [-0.18, 0.16, -0.61], [-0.18, 0.074, -0.49], [0.068, 0.074]),
];

/// The names of the morph targets.
pub const MORPHS: [&str; 2] = ["breathe", "ears"];

/// The creature's surface and what moves it.
#[derive(Clone, Debug)]
pub struct Creature {
    /// The rest pose.
    pub mesh: RawMesh,
    /// Indices into [`SKELETON`] per vertex; those of weight 0 are 0.
    pub joints: Vec<[u16; 4]>,
    /// How much each of the four moves the vertex; they add up to 1.
    pub weights: Vec<[f32; 4]>,
    /// Displacement per vertex of each of the [`MORPHS`].
    pub morphs: [Vec<Vec3>; 2],
    /// The direction along the limbs per vertex: towards the nose on the trunk, downwards on legs.
    pub along: Vec<Vec3>,
}

impl Creature {
    /// Generates the creature with edges about `edge` long; the ears ask for 0.03 or less.
    pub fn generate(edge: f32) -> Self {
        let mesh = isosurface::mesh(body, Vec3::new(-0.55, -0.1, -1.5), Vec3::new(0.55, 1.9, 1.4), edge);
        let (joints, weights) = mesh.positions.iter().map(|&p| skin(p)).unzip();
        let breathe = |p: &Vec3| {
            // The ribs: sideways and down, most in the middle of the chest.
            let from = (*p - Vec3::new(0.0, 0.93, 0.08)) / Vec3::new(0.45, 0.42, 0.5);
            let share = (1.0 - from.length_squared()).max(0.0).powi(2);
            share * 0.16 * Vec3::new(p.x, 0.7 * (p.y - 1.05).min(0.0), 0.0) / 0.27
        };
        let ears = |p: &Vec3| {
            let share = ((p.y - 1.56) / 0.17).clamp(0.0, 1.0) * f32::from(p.z < 1.0 && p.z > 0.5);
            share * share * Vec3::new(-0.07 * p.x.signum(), 0.11, 0.05)
        };
        Self {
            joints,
            weights,
            morphs: [
                mesh.positions.iter().map(breathe).collect(),
                mesh.positions.iter().map(ears).collect(),
            ],
            along: mesh.positions.iter().map(|&p| along(p)).collect(),
            mesh,
        }
    }

    /// How each of the [`MORPHS`] changes the normals.
    pub fn morph_turns(&self) -> [Vec<Vec3>; MORPHS.len()] {
        let rest = smooth_normals(&self.mesh);
        self.morphs.each_ref().map(|moves| {
            let mut moved = self.mesh.clone();
            moved.positions.iter_mut().zip(moves).for_each(|(p, by)| *p += by);
            smooth_normals(&moved)
                .iter()
                .zip(&rest)
                .map(|(to, from)| to - from)
                .collect()
        })
    }
}

/// Distance from a joint's limb.
fn distance_from(joint: &Joint, p: Vec3) -> f32 {
    limb(p, joint.position.extend(joint.radii.x), joint.end.extend(joint.radii.y))
}

/// Distance from the skin, negative inside.
fn body(p: Vec3) -> f32 {
    // The creature is the same on both sides.
    let p = Vec3::new(p.x.abs(), p.y, p.z);
    let left = SKELETON.iter().filter(|joint| !joint.name.contains("right"));
    let limbs = left.fold(f32::INFINITY, |distance, joint| {
        let blend = 0.9 * joint.radii.min_element().clamp(0.05, 0.16);
        match distance {
            f32::INFINITY => distance_from(joint, p),
            _ => smooth_union(distance, distance_from(joint, p), blend),
        }
    });
    let belly = ellipsoid(p, Vec3::new(0.0, 0.90, 0.0), Vec3::new(0.25, 0.25, 0.5));
    let nose = ellipsoid(p, Vec3::new(0.0, 1.345, 1.235), Vec3::new(0.055, 0.04, 0.035));
    smooth_union(smooth_union(limbs, belly, 0.12), nose, 0.03)
}

/// The four limbs that move a point most: each the less the farther it is than the nearest one.
fn skin(p: Vec3) -> ([u16; 4], [f32; 4]) {
    const REACH: f32 = 0.035;
    let distances = SKELETON.each_ref().map(|joint| distance_from(joint, p));
    let nearest = distances.iter().copied().fold(f32::INFINITY, f32::min);
    let mut order: Vec<usize> = (0..SKELETON.len()).collect();
    order.sort_by(|&a, &b| distances[a].total_cmp(&distances[b]));
    let mut weights = [0, 1, 2, 3].map(|i| ((nearest - distances[order[i]]) / REACH).exp());
    let sum: f32 = weights.iter().sum();
    // What is next to nothing is nothing.
    weights = weights.map(|weight| if weight < 0.01 * sum { 0.0 } else { weight });
    let sum: f32 = weights.iter().sum();
    let joints = [0, 1, 2, 3].map(|i| if weights[i] > 0.0 { order[i] as u16 } else { 0 });
    (joints, weights.map(|weight| weight / sum))
}

/// The direction of the limbs near a point.
fn along(p: Vec3) -> Vec3 {
    const REACH: f32 = 0.06;
    let near = SKELETON
        .each_ref()
        .map(|joint| (distance_from(joint, p), (joint.end - joint.position).normalize()));
    let nearest = near.iter().map(|(d, _)| *d).fold(f32::INFINITY, f32::min);
    let sum: Vec3 = near.iter().map(|(d, way)| ((nearest - d) / REACH).exp() * way).sum();
    sum.normalize_or(Vec3::Z)
}
