//! How many waves a pattern has, and how those of two neighbours belong together.
//!
//! In: the frames (d, n × d) of two vertices. Out: the quarter turns that make one look like the other, and so which wave
//! of the one continues which wave of the other, and in which sense (section 3.6 of Lichtenberg et al. 2018). The turns
//! are chosen for both waves together, which makes them reciprocal: those from j to i undo those from i to j.

use crate::{error::PatternError, field::Symmetry};
use bevy::prelude::*;

/// How many waves a pattern has. Default: one.
///
/// Two waves make texture coordinates: u grows along the field d, v along n × d.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub enum Waves {
    /// One wave, along d.
    #[default]
    Single,
    /// Two waves, along d and along n × d, which turn round together. On a line field they carry textures that look the
    /// same after half a turn, on a vector field any texture.
    Orthogonal {
        /// Frequency of the second wave over that of the first, 0.01..=100: how much longer than wide a tile is.
        ratio: f32,
    },
    /// Two waves of a cross field, which does not tell d, n × d, -d and -n × d apart: where one is led round a
    /// singularity it may come back as the other. They carry textures that look the same after a quarter turn. Has no
    /// [`Symmetry`] besides its own.
    Cross,
}

impl Waves {
    /// Two waves of the same frequency.
    pub const ORTHOGONAL: Self = Self::Orthogonal { ratio: 1.0 };

    /// Number of waves, 1 or 2.
    pub fn count(self) -> usize {
        match self {
            Self::Single => 1,
            Self::Orthogonal { .. } | Self::Cross => 2,
        }
    }

    /// Frequency of the second wave over that of the first.
    pub fn ratio(self) -> f32 {
        match self {
            Self::Orthogonal { ratio } => ratio,
            Self::Single | Self::Cross => 1.0,
        }
    }

    pub(crate) fn check(self) -> Result<(), PatternError> {
        let ratio = self.ratio();
        if (0.01..=100.0).contains(&ratio) {
            Ok(())
        } else {
            Err(PatternError::OutOfRange {
                what: "Waves::Orthogonal::ratio",
                value: ratio,
                expected: "0.01..=100",
            })
        }
    }
}

/// The waves of a pattern and what turns of the field change nothing about it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Coupling {
    /// How many waves there are.
    pub waves: Waves,
    /// Whether d and -d differ. Of no effect for [`Waves::Cross`].
    pub symmetry: Symmetry,
}

impl From<Symmetry> for Coupling {
    fn from(symmetry: Symmetry) -> Self {
        Self {
            waves: Waves::Single,
            symmetry,
        }
    }
}

/// The directions of the two waves at a vertex.
pub type Frame = [Vec3; 2];

/// (d, n × d) for the direction `d` at the unit normal `n`.
pub fn frame(d: Vec3, n: Vec3) -> Frame {
    [d, n.cross(d)]
}

impl Coupling {
    /// The quarter turns k, 0..=3, about its normal that bring the frame of `j` nearest to that of `i`, among those that
    /// leave the pattern as it is.
    pub fn quarter_turns(self, j: Frame, i: Frame) -> u32 {
        let mut c = i[0].dot(j[0]);
        if self.waves.count() == 2 {
            c += i[1].dot(j[1]);
        }
        if self.waves == Waves::Cross {
            let q = i[0].dot(j[1]) - i[1].dot(j[0]);
            if c.abs() < q.abs() {
                return if q > 0.0 { 1 } else { 3 };
            }
        } else if self.symmetry == Symmetry::Vector {
            return 0;
        }
        if c < 0.0 { 2 } else { 0 }
    }
}

/// What wave `r` (0 or 1) of a frame is after `k` quarter turns: the wave that was, and whether it is reversed.
pub fn turned(k: u32, r: usize) -> (usize, bool) {
    let q = k as usize + r;
    (q & 1, q & 2 != 0)
}
