//! Colours for numbers.
//!
//! In: a colour map and the range of values that it spans. Out: up to 16 colours at equal steps, between which shaders
//! interpolate in linear light, and the same colours for a legend.

use super::ScalarChannel;
use bevy::prelude::*;

/// The most colours that a map has; between them it is linear.
pub const MAX_COLOR_STOPS: usize = 16;

/// Colours from low to high.
#[derive(Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum ColorMap {
    /// Dark violet over green to yellow: even steps look even, also in grey and to the colour-blind. By S. van der Walt
    /// and N. Smith.
    #[default]
    Viridis,
    /// A rainbow without dark bands: many steps can be told apart. By A. Mikhailov.
    Turbo,
    /// Blue over light grey to red, for values of either sign around the middle of the range. By K. Moreland.
    CoolWarm,
    /// Black to white.
    Gray,
    /// Colours of your own at equal steps, of which the first [`MAX_COLOR_STOPS`] are used; none is white.
    Colors(Vec<LinearRgba>),
}

impl ColorMap {
    const VIRIDIS: [u32; 16] = [
        0x440154, 0x481a6c, 0x472f7d, 0x414487, 0x39568c, 0x31688e, 0x2a788e, 0x23888e, 0x1f988b, 0x22a884, 0x35b779,
        0x54c568, 0x7ad151, 0xa5db36, 0xd2e21b, 0xfde725,
    ];
    const TURBO: [u32; 16] = [
        0x30123b, 0x4143a7, 0x4771e9, 0x3e9bfe, 0x22c5e2, 0x1ae4b6, 0x46f884, 0x88ff4e, 0xb9f635, 0xe1dd37, 0xfaba39,
        0xfd8d27, 0xf05b12, 0xd63506, 0xaf1801, 0x7a0403,
    ];
    const COOL_WARM: [u32; 16] = [
        0x3b4cc0, 0x4f69d9, 0x6485ec, 0x7b9ff9, 0x93b5fe, 0xaac7fd, 0xc0d4f5, 0xd4dbe6, 0xe5d8d1, 0xf2cbb7, 0xf7b89c,
        0xf5a081, 0xee8468, 0xe0654f, 0xcc403a, 0xb40426,
    ];

    /// The colours at equal steps, from the low end to the high one; at least one.
    pub fn stops(&self) -> Vec<LinearRgba> {
        let table = |colors: [u32; 16]| {
            let linear = |hex: u32| {
                let [_, r, g, b] = hex.to_be_bytes();
                LinearRgba::from(Srgba::rgb_u8(r, g, b))
            };
            colors.map(linear).to_vec()
        };
        match self {
            Self::Viridis => table(Self::VIRIDIS),
            Self::Turbo => table(Self::TURBO),
            Self::CoolWarm => table(Self::COOL_WARM),
            Self::Gray => table(std::array::from_fn(|step| 0x11_1111 * step as u32)),
            Self::Colors(colors) if colors.is_empty() => vec![LinearRgba::WHITE],
            Self::Colors(colors) => colors[..colors.len().min(MAX_COLOR_STOPS)].to_vec(),
        }
    }

    /// The colour at `t`, 0..=1 from low to high; beyond, that of the end.
    pub fn color(&self, t: f32) -> LinearRgba {
        let stops = self.stops();
        let at = t.clamp(0.0, 1.0) * (stops.len() - 1) as f32;
        let stop = (at as usize).min(stops.len().saturating_sub(2));
        let next = stops[(stop + 1).min(stops.len() - 1)];
        stops[stop].mix(&next, at - stop as f32)
    }
}

/// A value and the colour that stands for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LegendEntry {
    /// The value.
    pub value: f32,
    /// Its colour.
    pub color: LinearRgba,
}

/// Colours of a pattern from one of the entity's scalars.
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct ScalarColor {
    /// The colours. Default [`ColorMap::Viridis`].
    pub map: ColorMap,
    /// Which scalar. Default: the first.
    pub scalar: ScalarChannel,
    /// The value that has the first colour. Default 0.
    pub low: f32,
    /// The value that has the last colour; may be below `low`. Default 1.
    pub high: f32,
}

impl Default for ScalarColor {
    fn default() -> Self {
        Self {
            map: ColorMap::default(),
            scalar: ScalarChannel::default(),
            low: 0.0,
            high: 1.0,
        }
    }
}

impl ScalarColor {
    /// The colour of a value: the twin of what shaders do.
    pub fn color(&self, value: f32) -> LinearRgba {
        let span = self.high - self.low;
        // As in shaders, a range without an extent is a step.
        let t = if span == 0.0 {
            f32::from(u8::from(value >= self.low))
        } else {
            (value - self.low) / span
        };
        self.map.color(t)
    }

    /// Values from low to high at equal steps, with their colours, for a legend; at least 2 `entries`.
    pub fn legend(&self, entries: usize) -> Vec<LegendEntry> {
        let last = entries.max(2) - 1;
        let entry = |k: usize| {
            let t = k as f32 / last as f32;
            LegendEntry {
                value: self.low + t * (self.high - self.low),
                color: self.map.color(t),
            }
        };
        (0..=last).map(entry).collect()
    }
}
