//! A blood vessel with an aneurysm, and the shear stress of an analytic flow on its wall.
//!
//! In: sizes, a time. Out: a tube open at both ends, and a tangent vector per vertex, of modulus about 1 where the vessel
//! is healthy. The flow slows down where the vessel widens (the wall shear stress of a Poiseuille flow falls with the
//! third power of the radius), winds a little around the vessel, and turns back at the dome of the sac.

use bevy::math::Vec3;
use std::f32::consts::TAU;

use super::mesh_file::RawMesh;

/// The shape of a vessel, in units of length.
#[derive(Clone, Copy, Debug)]
pub struct Vessel {
    /// From end to end along x.
    pub length: f32,
    /// Of the healthy vessel.
    pub radius: f32,
    /// How far the vessel swings to either side.
    pub bend: f32,
    /// How much wider than the vessel the sac is, in radii.
    pub bulge: f32,
    /// Rings of vertices along the vessel, 3 or more.
    pub along: usize,
    /// Vertices per ring, 3 or more.
    pub around: usize,
}

impl Default for Vessel {
    fn default() -> Self {
        Self {
            length: 4.0,
            radius: 0.4,
            bend: 0.25,
            bulge: 1.5,
            along: 160,
            around: 96,
        }
    }
}

impl Vessel {
    /// The wall, facing outwards.
    pub fn mesh(&self) -> RawMesh {
        let positions = self.parameters().map(|(s, angle)| self.point(s, angle)).collect();
        let vertex = |i: usize, j: usize| (i * self.around + j % self.around) as u32;
        let quads = (0..self.along - 1).flat_map(|i| (0..self.around).map(move |j| (i, j)));
        let triangles = quads
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
                [[a, c, b], [a, d, c]]
            })
            .collect();
        RawMesh { positions, triangles }
    }

    /// The wall shear stress at every vertex, `phase` (in periods) after the heart has begun to beat.
    pub fn wall_shear_stress(&self, phase: f32) -> Vec<Vec3> {
        // Blood pulses: it is fast for a third of the time and slow, but never at rest, for the remainder.
        let pulse = 0.55 + 0.45 * (TAU * phase).sin() + 0.15 * (2.0 * TAU * phase).cos();
        self.parameters()
            .map(|(s, angle)| {
                let along = self.slope(s, angle, 1e-3, 0.0);
                let around = self.slope(s, angle, 0.0, 1e-3);
                let sac = self.sac(s, angle);
                let widening = 1.0 + self.bulge * sac;
                // Against the flow in the inner half of the sac.
                let forward = (1.0 - 2.2 * sac) / widening.powi(2);
                let winding = 0.18 + 0.55 * sac * (1.0 - sac) * angle.sin().signum();
                along * forward * pulse + around * winding / widening
            })
            .collect()
    }

    /// Position along the vessel in 0..=1 and angle around it, of each vertex.
    fn parameters(&self) -> impl Iterator<Item = (f32, f32)> + use<> {
        let Self { along, around, .. } = *self;
        (0..along).flat_map(move |i| {
            let s = i as f32 / (along - 1) as f32;
            (0..around).map(move |j| (s, TAU * j as f32 / around as f32))
        })
    }

    /// A point of the wall.
    fn point(&self, s: f32, angle: f32) -> Vec3 {
        let centre = self.centre(s);
        let tangent = (self.centre(s + 1e-3) - self.centre(s - 1e-3)).normalize();
        let side = Vec3::Z;
        let up = side.cross(tangent);
        let radius = self.radius * (1.0 + self.bulge * self.sac(s, angle));
        centre + radius * (angle.cos() * up + angle.sin() * side)
    }

    fn centre(&self, s: f32) -> Vec3 {
        Vec3::new(self.length * (s - 0.5), self.bend * (TAU * s).sin(), 0.0)
    }

    /// 1 at the dome of the sac, 0 far from it.
    fn sac(&self, s: f32, angle: f32) -> f32 {
        let from_middle = self.length * (s - 0.5) / (1.4 * self.radius);
        (-from_middle * from_middle).exp() * (0.5 + 0.5 * angle.cos()).powi(2)
    }

    /// The unit tangent of the wall towards larger s or angle.
    fn slope(&self, s: f32, angle: f32, ds: f32, dangle: f32) -> Vec3 {
        (self.point(s + ds, angle + dangle) - self.point(s - ds, angle - dangle)).normalize_or_zero()
    }
}
