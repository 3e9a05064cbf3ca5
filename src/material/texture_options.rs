//! What can be said about the look of textures on two waves.
//!
//! In: nothing. Out: the plain types of [`PatternTexture`](super::PatternTexture), and nothing that knows of the GPU.

use bevy::prelude::*;

/// One of the two scalars per vertex that styles may show.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default, Clone, PartialEq, Hash)]
pub enum ScalarChannel {
    /// The first one.
    #[default]
    First,
    /// The second one.
    Second,
}

/// How a texture travels along d. Anything but rest needs a vector field.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Travel {
    /// By so many periods per second everywhere, backwards where below 0: faster where the frequency is lower, because
    /// periods are longer there. The texture keeps its shape.
    Periods(f32),
    /// By so many unit lengths of the mesh at rest per second, whatever the frequency.
    ///
    /// At a point of frequency f that is a phase speed of f · `speed` periods per second. Where f differs from place to
    /// place the phases would be sheared more and more. So two copies of the texture are sheared for one `cycle` each, half
    /// a cycle apart, and fade into each other; each is whole in the middle of its cycle, and is not seen when it begins
    /// anew.
    /// Where f = `around` both are the same and nothing fades.
    Speed {
        /// Unit lengths per second.
        speed: f32,
        /// The frequency [periods per unit length] where the texture keeps its shape: that of the entity where it is
        /// uniform, or about the mean. 0 or more.
        around: f32,
        /// Seconds until a copy begins anew, above 0: long ones shear more, short ones fade more. 2 suits most.
        cycle: f32,
    },
}

impl Travel {
    /// Nothing moves.
    pub const REST: Self = Self::Periods(0.0);

    /// The shifts in periods along d and the weights of the two copies after `time` seconds at a point of the given
    /// `frequency` [periods per unit length]: the twin of `copy_of` in `texture_style.wgsl`.
    pub fn copies(self, frequency: f32, time: f32) -> [(f32, f32); 2] {
        match self {
            Self::Periods(speed) => [((speed * time).rem_euclid(1.0), 1.0), (0.0, 0.0)],
            Self::Speed { speed, around, cycle } => [0.0, 0.5].map(|lead| {
                let part = (time / cycle.max(Self::LEAST_CYCLE) + lead).rem_euclid(1.0);
                let local = (part - 0.5) * cycle.max(Self::LEAST_CYCLE);
                let shift = (around * speed * time).rem_euclid(1.0) + (frequency - around) * speed * local;
                (shift, 1.0 - (2.0 * part - 1.0).abs())
            }),
        }
    }

    /// Seconds below which a cycle would be a flicker.
    const LEAST_CYCLE: f32 = 0.05;

    /// Periods per second, speed, frequency and cycle.
    pub(super) fn vector(self) -> Vec4 {
        match self {
            Self::Periods(speed) => Vec4::new(speed, 0.0, 0.0, 0.0),
            Self::Speed { speed, around, cycle } => Vec4::new(0.0, speed, around, cycle.max(Self::LEAST_CYCLE)),
        }
    }

    pub(super) fn moves(self) -> bool {
        match self {
            Self::Periods(speed) | Self::Speed { speed, .. } => speed != 0.0,
        }
    }
}

impl Default for Travel {
    fn default() -> Self {
        Self::REST
    }
}

/// A second image, less salient, that takes the place of the first where a scalar says so.
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct TextureFade {
    /// The other image; `None` fades to nothing, which shows the base. Default `None`.
    pub image: Option<Handle<Image>>,
    /// Which scalar. Default: the first.
    pub scalar: ScalarChannel,
    /// The value at which the other image begins to show. Default 0.
    pub begin: f32,
    /// The value at which only the other image shows; may be below `begin`. Default 1.
    pub end: f32,
}

impl Default for TextureFade {
    fn default() -> Self {
        Self {
            image: None,
            scalar: ScalarChannel::First,
            begin: 0.0,
            end: 1.0,
        }
    }
}

/// Takes the image for an atlas: a grid of tiles, of which each period cell shows one.
///
/// The tile is chosen by the scalar in the middle of the cell, so it is the same over the cell: the fragment shader walks
/// there, from triangle to triangle, however large or small cells are. At a branch, where cells have no middle, every point
/// goes by its own scalar, and a cell may show parts of two tiles.
///
/// Tiles do not continue each other, so their edges should be transparent or of one colour.
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Patches {
    /// Columns of the atlas, 1 or more. Default 1.
    pub columns: u32,
    /// Rows of the atlas, 1 or more. Default 1.
    pub rows: u32,
    /// Which scalar. Default: the first.
    pub scalar: ScalarChannel,
    /// Where the range of the first tile begins, which also stands for all that is below. Default 0.
    pub low: f32,
    /// Where the range of the last tile ends, which also stands for all that is above. Default 1. Tiles, row by row, have
    /// equal shares of the range.
    pub high: f32,
}

impl Default for Patches {
    fn default() -> Self {
        Self {
            columns: 1,
            rows: 1,
            scalar: ScalarChannel::First,
            low: 0.0,
            high: 1.0,
        }
    }
}

impl Patches {
    /// The tile that stands for a scalar, as `tile_at` of `texture_style.wgsl` chooses it. A range without an extent is a
    /// step from the first tile to the last.
    pub fn tile(&self, scalar: f32) -> u32 {
        let count = self.columns.max(1).saturating_mul(self.rows.max(1));
        let span = self.high - self.low;
        let t = if span == 0.0 {
            f32::from(u8::from(scalar >= self.low))
        } else {
            (scalar - self.low) / span
        };
        ((t * count as f32).max(0.0) as u32).min(count - 1)
    }
}

/// What a texture's bump is high by.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default, Clone, PartialEq, Hash)]
#[non_exhaustive]
pub enum TextureHeight {
    /// The image's alpha: what is opaque stands out.
    #[default]
    Alpha,
    /// The image's luminance: what is bright stands out.
    Luminance,
}
