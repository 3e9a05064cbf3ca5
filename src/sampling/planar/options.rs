//! What the planar sampler is asked for.

use super::{Insertion, Relaxation};
use crate::{error::PatternError, sampling::Density};

/// How a planar domain is sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanarSampling {
    /// How many samples; default 1000.
    pub density: Density,
    /// Order of insertion; default the largest triangle first.
    pub insertion: Insertion,
    /// How samples are relaxed; default by kites.
    pub relaxation: Relaxation,
    /// Relaxation steps; default 10: even, without visible order. 0 leaves the samples where they were inserted; after
    /// some hundred they become regular.
    pub steps: u32,
    /// Shifts the first place of every sample at random, by up to 15 % of a distance on the border and 12 % of the corners'
    /// weights inside. Other seeds make other sets of the same quality. Default 0.
    pub seed: u64,
    /// Relaxation stops when the root mean square of the moves falls below this, in metric units (neighbours are about 2
    /// apart), 0 or more; 0 never stops. Default 0.02.
    pub tolerance: f32,
}

impl Default for PlanarSampling {
    fn default() -> Self {
        Self {
            density: Density::default(),
            insertion: Insertion::default(),
            relaxation: Relaxation::default(),
            steps: 10,
            seed: 0,
            tolerance: 0.02,
        }
    }
}

impl PlanarSampling {
    /// So many samples, and the defaults.
    pub fn count(count: u32) -> Self {
        Self {
            density: Density::Count(count),
            ..Self::default()
        }
    }

    /// The paper from end to end: a fill rate of 0.55 of the metric as given, insertion first in, first out, and the star
    /// relaxation. (The flips are by the summed metric here too: with the paper's own test they need not end.)
    pub fn paper() -> Self {
        Self {
            density: Density::FillRate(0.55),
            insertion: Insertion::Fifo,
            relaxation: Relaxation::Star,
            ..Self::default()
        }
    }

    /// Whether all options are in their ranges.
    pub(super) fn check(&self) -> Result<(), PatternError> {
        let fail = |what, value, expected| Err(PatternError::OutOfRange { what, value, expected });
        match self.density {
            Density::Count(0) => return fail("the number of samples", 0.0, "1 or more"),
            Density::FillRate(rate) if !(rate > 0.0 && rate.is_finite()) => {
                return fail("the fill rate", rate, "above 0");
            }
            _ => {}
        }
        if self.tolerance >= 0.0 {
            Ok(())
        } else {
            fail("the tolerance", self.tolerance, "0 or more")
        }
    }
}
