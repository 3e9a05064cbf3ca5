//! An artery with an aneurysm, and the stress in its wall.
//!
//! In: sizes, an edge length. Out: a smooth surface, open at both ends, and a symmetric tensor per vertex. The wall is a
//! thin membrane under pressure p: with the radii R₁ = 1/κ₁ (along) and R₂ = 1/κ₂ (around, the smaller one), the
//! balance σ₁/R₁ + σ₂/R₂ = p/h of a shell of revolution gives σ₁ = p R₂ / 2h and σ₂ = σ₁ (2 - κ₁/κ₂): once and twice
//! p R / 2h on a tube, equal on a ball, both positive everywhere, and larger on the sac by as much as it is wider.

use bevy::prelude::*;
use glam_matrix_extras::SymmetricMat3;

use super::{
    implicit::{ball, ellipsoid, gradient, hessian, smooth_union},
    isosurface,
    mesh_file::RawMesh,
};

/// The shape of an artery that bends over the sac's neck, in units of length.
#[derive(Clone, Copy, Debug)]
pub struct Aneurysm {
    /// Of the healthy artery.
    pub radius: f32,
    /// Of the arc that the artery runs along, about the origin in the xy plane.
    pub arc: f32,
    /// Half-axes of the sac: along the artery, away from it, across.
    pub sac: Vec3,
    /// Width of the fillet between sac and artery.
    pub fillet: f32,
}

impl Default for Aneurysm {
    fn default() -> Self {
        Self {
            radius: 0.27,
            arc: 1.5,
            sac: Vec3::new(0.62, 0.78, 0.52),
            fillet: 0.45,
        }
    }
}

impl Aneurysm {
    /// Distance from the wall, negative inside.
    pub fn distance(&self, p: Vec3) -> f32 {
        let artery = Vec2::new(p.xy().length() - self.arc, p.z).length() - self.radius;
        let dome = Vec3::new(0.12, self.arc + 1.25 * self.sac.y, 0.05);
        let sac = ellipsoid(Quat::from_rotation_z(0.25) * (p - dome), Vec3::ZERO, self.sac);
        // A daughter sac, from where they rupture.
        let bleb = ball(p, dome + Vec3::new(0.4, 0.46, 0.18), 0.24);
        smooth_union(artery, smooth_union(sac, bleb, self.fillet), self.fillet)
    }

    /// The wall with edges about `edge` long, facing outwards.
    pub fn mesh(&self, edge: f32) -> RawMesh {
        let reach = 1.5 * self.arc;
        let min = Vec3::new(-reach, 0.45 * self.arc, -self.sac.z - self.radius - 0.3);
        let max = Vec3::new(reach, self.arc + 2.6 * self.sac.y + 0.6, self.sac.z + self.radius + 0.3);
        isosurface::mesh(|p| self.distance(p), min, max, edge)
    }

    /// The stress at the vertices of the wall, in units of p R / 2h of the healthy artery.
    pub fn stress(&self, mesh: &RawMesh) -> Vec<SymmetricMat3> {
        mesh.positions.iter().map(|&p| self.stress_at(p)).collect()
    }

    fn stress_at(&self, p: Vec3) -> SymmetricMat3 {
        let step = 0.06 * self.radius;
        let distance = |p: Vec3| self.distance(p);
        let slope = gradient(&distance, p, step);
        let normal = slope.normalize_or(Vec3::Y);
        let (u, v) = normal.any_orthonormal_pair();
        let second = hessian(&distance, p, step);
        let curvature = |a: Vec3, b: Vec3| a.dot(second * b) / slope.length().max(0.1);
        // The eigenvectors of the 2 × 2 shape operator.
        let (uu, uv, vv) = (curvature(u, u), curvature(u, v), curvature(v, v));
        let (mean, half) = (0.5 * (uu + vv), 0.5 * (uu - vv));
        let spread = half.hypot(uv);
        let angle = 0.5 * uv.atan2(half);
        let around = angle.cos() * u + angle.sin() * v;
        let along = normal.cross(around);
        // Where the neck is nearly flat around it is stayed by its surroundings.
        let flattest = 1.2 / self.sac.max_element();
        let kappa_around = (mean + spread).max(flattest);
        let kappa_along = (mean - spread).max(-0.3 * kappa_around);
        let stress_along = 1.0 / (kappa_around * self.radius);
        let stress_around = stress_along * (2.0 - kappa_along / kappa_around);
        outer(around, stress_around) + outer(along, stress_along)
    }
}

/// `scale` · v vᵀ.
fn outer(v: Vec3, scale: f32) -> SymmetricMat3 {
    SymmetricMat3::from_outer_product(v) * scale
}
