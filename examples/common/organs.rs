//! Organs inside an organ: a liver with a tumour and the tree of its portal vein.
//!
//! In: an edge length, a seed. Out: three closed surfaces that do not touch, the hull around the others. About 2.4 units
//! wide.

use bevy::prelude::*;

use super::{
    implicit::{ball, ellipsoid, smooth_union},
    isosurface,
    mesh_file::RawMesh,
    vessel_tree::{Growth, VesselTree},
};

/// What lies inside what.
pub struct Organs {
    /// The liver.
    pub hull: RawMesh,
    /// A tumour in its right lobe.
    pub tumour: RawMesh,
    /// The portal vein, which enters from below.
    pub vessels: RawMesh,
    /// The middle of the tumour.
    pub target: Vec3,
}

/// Where the tumour lies.
const TUMOUR: Vec3 = Vec3::new(-0.52, 0.12, 0.2);

impl Organs {
    /// Hull and vessels with edges of about `edge` and half of that.
    pub fn generate(edge: f32, seed: u64) -> Self {
        let growth = Growth {
            root: Vec3::new(0.12, -0.62, 0.0),
            towards: Vec3::new(-0.25, 1.0, 0.0),
            radius: 0.085,
            thinnest: 0.022,
            length: 0.42,
            seed,
        };
        let room = |p: Vec3| (liver(p) + 0.06).max(0.07 - tumour(p));
        let reach = Vec3::new(1.5, 0.95, 0.8);
        let small = Vec3::splat(0.4);
        Self {
            hull: isosurface::mesh(liver, -reach, reach, edge),
            tumour: isosurface::mesh(tumour, TUMOUR - small, TUMOUR + small, 0.8 * edge),
            vessels: VesselTree::grow(&growth, room).mesh(0.5 * edge),
            target: TUMOUR,
        }
    }
}

/// Two lobes, the right one (at -x, seen from the front) much larger, hollow from below.
fn liver(p: Vec3) -> f32 {
    let right = ellipsoid(p, Vec3::new(-0.42, 0.0, 0.0), Vec3::new(0.78, 0.66, 0.52));
    let left = ellipsoid(
        Quat::from_rotation_z(0.28) * (p - Vec3::new(0.48, 0.2, 0.06)),
        Vec3::ZERO,
        Vec3::new(0.78, 0.32, 0.36),
    );
    let body = smooth_union(right, left, 0.45);
    // The stomach lies below the left lobe.
    let hollow = ball(p, Vec3::new(0.75, -0.95, 0.1), 0.75);
    -smooth_union(-body, hollow, 0.25)
}

/// A knobbly ball.
fn tumour(p: Vec3) -> f32 {
    let q = 16.0 * (p - TUMOUR);
    let knobs = 0.018 * (q.x.sin() * (q.y + 1.0).sin() + (q.y * 0.8).cos() * (q.z * 1.1).sin());
    (ball(p, TUMOUR, 0.2) + knobs) / 1.3
}
