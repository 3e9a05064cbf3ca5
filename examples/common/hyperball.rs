//! A ball of struts with many holes, and a smooth cross-field on it.
//!
//! In: sizes, a twist, an edge length. Out: a smooth closed surface of genus 17, and a direction per vertex that is good
//! up to quarter turns. The struts are the edges of a four-dimensional cube: a cube in a cube, joined corner to corner,
//! turned the more the farther out.

use bevy::prelude::*;
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_4};

use super::{
    implicit::{gradient, hessian, limb, melt},
    isosurface,
    mesh_file::RawMesh,
};

/// The shape, in units of length.
#[derive(Clone, Copy, Debug)]
pub struct Hyperball {
    /// Corners of the outer cube from the middle.
    pub outer: f32,
    /// Corners of the inner cube from the middle.
    pub inner: f32,
    /// Radius of the struts at the outer cube; they thin towards the inner one.
    pub strut: f32,
    /// How far the outer cube is turned against the inner one, in radians.
    pub twist: f32,
}

impl Default for Hyperball {
    fn default() -> Self {
        Self {
            outer: 1.0,
            inner: 0.42,
            strut: 0.115,
            twist: FRAC_PI_4,
        }
    }
}

impl Hyperball {
    /// Genus of the surface: 32 struts between 16 corners.
    pub const GENUS: i64 = 17;

    /// Distance from the surface, negative inside.
    pub fn distance(&self, p: Vec3) -> f32 {
        let turn = self.twist * (p.length() - self.inner) / (self.outer - self.inner);
        let p = Quat::from_rotation_y(-turn) * p;
        // All octants are the same.
        let p = p.abs();
        melt(self.struts(p), 0.3 * self.strut) / (1.0 + 0.7 * self.twist.abs())
    }

    /// Distances from the struts of the first octant: halves of the cubes' edges, bent onto balls, and what joins them.
    fn struts(&self, p: Vec3) -> impl Iterator<Item = f32> + Clone {
        let thin = 0.75 * self.strut;
        let corner = |size: f32| Vec3::splat(size / 3.0_f32.sqrt());
        let edges = [(self.outer, self.strut), (self.inner, thin)]
            .into_iter()
            .flat_map(move |(size, radius)| {
                [p, p.yzx(), p.zxy()].map(|p| {
                    let (across, outwards) = ((p.y - p.z) * FRAC_1_SQRT_2, (p.y + p.z) * FRAC_1_SQRT_2);
                    let on_arc = p.x * 2.0_f32.sqrt() < outwards;
                    let from_axis = if on_arc {
                        Vec2::new(p.x.hypot(outwards) - size, across).length()
                    } else {
                        p.distance(corner(size))
                    };
                    from_axis - radius
                })
            });
        edges.chain([limb(
            p,
            corner(self.inner).extend(thin),
            corner(self.outer).extend(self.strut),
        )])
    }

    /// The surface with edges about `edge` long.
    pub fn mesh(&self, edge: f32) -> RawMesh {
        let reach = Vec3::splat(self.outer + 2.0 * self.strut);
        isosurface::mesh(|p| self.distance(p), -reach, reach, edge)
    }

    /// A direction per vertex of `mesh`, smooth up to quarter turns: along the curvature where that is clear.
    pub fn cross_field(&self, mesh: &RawMesh) -> Vec<Vec3> {
        const SWEEPS: usize = 60;
        let distance = |p: Vec3| self.distance(p);
        let step = 0.1 * self.strut;
        let normals: Vec<Vec3> = mesh
            .positions
            .iter()
            .map(|&p| gradient(&distance, p, step).normalize_or(Vec3::Y))
            .collect();
        let bends: Vec<(Vec3, f32)> = mesh
            .positions
            .iter()
            .zip(&normals)
            .map(|(&p, &normal)| bend(normal, hessian(&distance, p, step)))
            .collect();
        smooth_crosses(mesh, &normals, &bends, SWEEPS)
    }
}

/// The direction of the larger curvature, and how much larger it is than the other one, 0 to 1.
fn bend(normal: Vec3, second: Mat3) -> (Vec3, f32) {
    let (u, v) = normal.any_orthonormal_pair();
    let (uu, uv, vv) = (u.dot(second * u), u.dot(second * v), v.dot(second * v));
    let (half, spread) = (0.5 * (uu - vv), (0.5 * (uu - vv)).hypot(uv));
    let angle = 0.5 * uv.atan2(half);
    (
        angle.cos() * u + angle.sin() * v,
        spread / (0.5 * (uu + vv)).abs().max(spread).max(1e-6),
    )
}

/// Makes directions smooth up to quarter turns: each becomes the mean of its neighbours' (of their four, the nearest)
/// and its own first direction, the more of that the surer it is (second value, 0 to 1).
pub fn smooth_crosses(mesh: &RawMesh, normals: &[Vec3], first: &[(Vec3, f32)], sweeps: usize) -> Vec<Vec3> {
    let mut neighbours = vec![Vec::new(); mesh.positions.len()];
    for &[a, b, c] in &mesh.triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            neighbours[a as usize].push(b as usize);
        }
    }
    let mut crosses: Vec<Vec3> = first.iter().map(|(d, _)| *d).collect();
    for _ in 0..sweeps {
        for i in 0..crosses.len() {
            let own = crosses[i];
            let nearest = |d: Vec3, normal: Vec3| {
                let turned = normal.cross(d);
                [d, turned, -d, -turned]
                    .into_iter()
                    .max_by(|a, b| a.dot(own).total_cmp(&b.dot(own)))
                    .unwrap_or(d)
            };
            let kept = first[i].1 * first[i].1 * nearest(first[i].0, normals[i]);
            let sum: Vec3 = neighbours[i].iter().map(|&j| nearest(crosses[j], normals[j])).sum();
            crosses[i] = (sum + kept).reject_from_normalized(normals[i]).normalize_or(own);
        }
    }
    crosses
}
