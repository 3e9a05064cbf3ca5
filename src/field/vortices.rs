//! Flow around vortex cores.
//!
//! In: cores and a base flow in the space of the pattern. Out: a unit tangent per vertex, of vector symmetry: the direction
//! of u + Σ s h(r / R) (n × (p - c)) / R, projected, over the cores with centre c, radius R and signed strength s, where
//! r = |p - c| and h is the [`Falloff`]. A core swirls about the surface's own normal n: it needs a position only, and on
//! a plane its flow is a circle around it, at speed s at the distance R.

use super::{project_tangent, turn_tangent};
use crate::{error::PatternError, parallel, surface::SurfaceGraph};
use bevy::{ecs::entity::MapEntities, prelude::*};

/// A vortex core: an entity with a `Transform`, on or near the surfaces whose [`DirectionField::Vortices`](super::DirectionField)
/// follow it. Only its position counts.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[require(Transform)]
pub struct Vortex {
    /// The speed of the flow at the distance `radius`; finite, 0 or more. Only its ratio to other speeds matters, for
    /// directions have no length. Default 1.
    pub strength: f32,
    /// Which way it turns. Default counter-clockwise.
    pub sense: Sense,
    /// The distance from the core at which the flow is fastest, in units of the world; finite, above 0. Default 0.2.
    pub radius: f32,
    /// How the flow fades farther away. Default [`Falloff::Inverse`].
    pub falloff: Falloff,
}

impl Default for Vortex {
    fn default() -> Self {
        Self {
            strength: 1.0,
            sense: Sense::default(),
            radius: 0.2,
            falloff: Falloff::default(),
        }
    }
}

/// Which way a vortex turns, seen from outside against the surface's normal.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default)]
pub enum Sense {
    /// Against the hands of a clock.
    #[default]
    CounterClockwise,
    /// With them.
    Clockwise,
}

/// The speed of a vortex at the distance ρ radii, over that at one radius. Both begin as ρ: a core is at rest.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default)]
pub enum Falloff {
    /// 2ρ / (1 + ρ²): like a free vortex far away, felt everywhere.
    #[default]
    Inverse,
    /// ρ exp((1 - ρ²) / 2): gone after three radii.
    Gaussian,
}

/// Which cores a field follows.
#[derive(Reflect, MapEntities, Debug, Clone, PartialEq, Default)]
#[reflect(Default)]
pub enum VortexCores {
    /// Every entity with a [`Vortex`].
    #[default]
    All,
    /// These entities; each must have a [`Vortex`] and a `GlobalTransform`.
    These(#[entities] Vec<Entity>),
}

/// Flow around cores that move; see [`DirectionField::Vortices`](super::DirectionField).
#[derive(Reflect, MapEntities, Debug, Clone, PartialEq, Default)]
#[reflect(Default)]
pub struct VortexField {
    /// Flow without any core, in the space of the pattern; its length is a speed, as [`Vortex::strength`]. Finite; none by
    /// default.
    pub base: Vec3,
    /// Whose swirl is added. Default: every core's.
    #[entities]
    pub cores: VortexCores,
}

/// A core in the space of a pattern.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VortexCore {
    /// Its centre.
    pub position: Vec3,
    /// Its radius, above 0.
    pub radius: f32,
    /// Its speed at one radius; below 0 clockwise.
    pub strength: f32,
    /// How it fades.
    pub falloff: Falloff,
}

impl VortexCore {
    /// A core of the world at `position` of a pattern's space, whose unit of length is `1 / scale` of the world's.
    ///
    /// # Errors
    /// [`OutOfRange`](PatternError::OutOfRange) with the number of the vortex that is, and
    /// [`NotFinite`](PatternError::NotFinite).
    pub fn new(vortex: &Vortex, position: Vec3, scale: f32) -> Result<Self, PatternError> {
        let out_of_range = |what, value, expected| Err(PatternError::OutOfRange { what, value, expected });
        if !position.is_finite() {
            return Err(PatternError::SettingNotFinite("the position of a Vortex"));
        }
        if !(vortex.strength.is_finite() && vortex.strength >= 0.0) {
            return out_of_range("Vortex::strength", vortex.strength, "finite and 0 or more");
        }
        if !(vortex.radius.is_finite() && vortex.radius > 0.0) {
            return out_of_range("Vortex::radius", vortex.radius, "finite and above 0");
        }
        let strength = match vortex.sense {
            Sense::CounterClockwise => vortex.strength,
            Sense::Clockwise => -vortex.strength,
        };
        Ok(Self {
            position,
            radius: vortex.radius * scale,
            strength,
            falloff: vortex.falloff,
        })
    }

    /// The velocity that it adds at `p`, where the unit normal is `n`.
    pub fn velocity(&self, p: Vec3, n: Vec3) -> Vec3 {
        let r = (p - self.position) / self.radius;
        let h = match self.falloff {
            Falloff::Inverse => 2.0 / (1.0 + r.length_squared()),
            Falloff::Gaussian => (0.5 - 0.5 * r.length_squared()).exp(),
        };
        self.strength * h * n.cross(r)
    }
}

/// The direction of the flow around `cores` on top of `base` at each vertex of `graph`, turned by `turn` radians. Where it
/// stands still, any tangent.
pub fn vortex_directions(cores: &[VortexCore], base: Vec3, turn: f32, graph: &SurfaceGraph) -> Vec<Vec3> {
    parallel::collect(graph.len(), |i| {
        let (p, n) = (graph.positions[i], graph.normals[i]);
        let flow = cores.iter().fold(base, |sum, core| sum + core.velocity(p, n));
        turn_tangent(project_tangent(super::unit_or_zero(flow), n), n, turn)
    })
}
