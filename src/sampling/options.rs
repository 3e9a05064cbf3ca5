//! What planar and surface samplers are asked alike.

use bevy::prelude::*;

/// How many samples there shall be.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub enum Density {
    /// Exactly so many, 1 or more. The metric is scaled so that their ellipses fill the domain as a hexagonal packing would
    /// (the metric area is then 2√3 per sample).
    Count(u32),
    /// The paper's fill rate η, above 0: the metric is taken as it is, and samples are inserted while a triangle is covered
    /// to less than η by the ellipses of its corners (Eq. 6). 0.55 gives about the count of a hexagonal packing.
    FillRate(f32),
}

impl Default for Density {
    fn default() -> Self {
        Self::Count(1000)
    }
}

/// How long a sampler took, in milliseconds.
#[derive(Reflect, Debug, Clone, Copy, Default, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct SamplingTimes {
    /// From the call to the first complete set.
    pub initial: f32,
    /// The mean of one relaxation step; 0 where there was none.
    pub per_step: f32,
    /// The whole call.
    pub total: f32,
}
