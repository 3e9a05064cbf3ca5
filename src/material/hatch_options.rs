//! What hatching can be told.

use super::{Focus, HatchMaterial, ScalarChannel};
use bevy::prelude::*;

/// What decides how dark a place is drawn.
///
/// Each source has two values: at `light` and beyond the tone is the lightest, at `dark` and beyond the darkest, between
/// them it is linear. Either may be the larger one.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum HatchTone {
    /// The same share of ink everywhere, 0..=1.
    Constant(f32),
    /// The luminance of the lit base: shadows, lamps and the base's own colour count. 1 is white on a screen without tone
    /// mapping.
    ///
    /// Such a material is drawn by the forward renderer, also where the camera's other materials are deferred: only there
    /// the light is known.
    Light {
        /// Default 0.8.
        light: f32,
        /// Default 0.
        dark: f32,
    },
    /// One of the pattern's two scalars per vertex, in their own unit.
    Scalar {
        /// Which one.
        scalar: ScalarChannel,
        /// The scalar at which the tone is the lightest.
        light: f32,
        /// The scalar at which the tone is the darkest.
        dark: f32,
    },
    /// The distance from something, in world units.
    Distance {
        /// From where.
        from: DistanceFrom,
        /// The distance at which the tone is the lightest.
        light: f32,
        /// The distance at which the tone is the darkest.
        dark: f32,
    },
}

impl HatchTone {
    /// The lit surface, from white at a luminance of 0.8 to black.
    pub const LIGHT: Self = Self::Light { light: 0.8, dark: 0.0 };

    pub(super) fn source(self) -> u32 {
        match self {
            Self::Constant(_) => 0,
            Self::Light { .. } => 1,
            Self::Scalar { scalar, .. } => 2 + scalar as u32,
            Self::Distance { from, .. } => match from {
                DistanceFrom::Camera => 4,
                DistanceFrom::Point(_) => 5,
            },
        }
    }

    /// The values of the lightest and the darkest tone, never the same.
    pub(super) fn range(self) -> Vec2 {
        let (light, dark) = match self {
            Self::Constant(_) => (0.0, 1.0),
            Self::Light { light, dark } | Self::Scalar { light, dark, .. } | Self::Distance { light, dark, .. } => {
                (light, dark)
            }
        };
        apart(light, dark)
    }
}

impl Default for HatchTone {
    fn default() -> Self {
        Self::LIGHT
    }
}

/// Two ends of a range, a little apart at least.
pub(super) fn apart(from: f32, to: f32) -> Vec2 {
    let gap = 1e-6 * from.abs().max(1.0);
    Vec2::new(from, if (to - from).abs() < gap { from + gap } else { to })
}

/// Where [`HatchTone::Distance`] is measured from.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Default, Clone, PartialEq)]
pub enum DistanceFrom {
    /// The camera that draws (the light, for its shadow map).
    #[default]
    Camera,
    /// A point of the world; a [`ToneSource`] moves it along with its entity.
    Point(Vec3),
}

/// How far apart the strokes of the tone [`HatchStrokes::width`] are.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum StrokeSpacing {
    /// One period of the wave.
    Period,
    /// At least so many pixels, and less than twice as many, where a period is wider than that: seen from near, new
    /// strokes grow between the old ones, which stay. Where a period is narrower, it is the period. More than 0.
    Pixels(f32),
    /// `Pixels(9.0)`.
    #[default]
    Automatic,
}

impl StrokeSpacing {
    pub(super) fn pixels(self) -> f32 {
        match self {
            Self::Period => 0.0,
            Self::Pixels(pixels) => pixels.max(0.1),
            Self::Automatic => 9.0,
        }
    }
}

/// How strokes are made of a tone.
///
/// The share of the area that is ink is the tone, whatever these say.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct HatchStrokes {
    /// Width of a stroke as a share of [`HatchStrokes::spacing`], at the tone that is this share of ink. 0.01..=1, default 0.25.
    pub width: f32,
    /// What a darker tone has more of: 0 wider strokes, 1 more strokes of the same width. 0..=1, default 0.6.
    pub density: f32,
    /// Distance between strokes of the tone `width`.
    pub spacing: StrokeSpacing,
    /// The share of ink from which strokes along the other direction are drawn across, where the pattern has two waves.
    /// 0..=1, default 0.4. A cross field, which does not tell its two waves apart, crosses from the beginning.
    pub cross_from: f32,
    /// Softness of the edges, 0..=1; at 1 a stroke's slopes meet in its middle. Default 0.3.
    pub softness: f32,
}

impl Default for HatchStrokes {
    fn default() -> Self {
        Self {
            width: 0.25,
            density: 0.6,
            spacing: StrokeSpacing::default(),
            cross_from: 0.4,
            softness: 0.3,
        }
    }
}

/// What makes strokes look drawn by hand. It lies on the surface (on its rest pose), not on the screen, and leaves the
/// mean share of ink as it is.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct HatchHand {
    /// How much the width of a stroke varies, as a share of it. 0..=1, default 0.35.
    pub width: f32,
    /// How much later or earlier new strokes set in, in doublings of the number of strokes; makes them end at different
    /// places. 0..=1, default 0.5.
    pub length: f32,
    /// How far a stroke strays to its sides, in distances between strokes of the tone [`HatchStrokes::width`]. 0..=0.25,
    /// default 0.05.
    pub wobble: f32,
    /// How much the ink fades, as a share of its opacity. 0..=1, default 0.25.
    pub ink: f32,
}

impl HatchHand {
    /// A ruler.
    pub const STEADY: Self = Self {
        width: 0.0,
        length: 0.0,
        wobble: 0.0,
        ink: 0.0,
    };
}

impl Default for HatchHand {
    fn default() -> Self {
        Self {
            width: 0.35,
            length: 0.5,
            wobble: 0.05,
            ink: 0.25,
        }
    }
}

/// What the dashes of an outline are counted along.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Default)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum DashAlong {
    /// The wave that changes most along the outline: dashes end on strokes.
    Wave,
    /// The axis of the mesh that the outline follows most.
    #[default]
    Position,
}

/// Lines where a smooth surface turns out of sight, as wide on the screen everywhere.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct HatchOutline {
    /// Width in pixels; 0: none. Default 0.
    pub width: f32,
    /// Length of a dash and the gap after it, in pixels: at least this and less than twice as long. 0: a solid line.
    /// Default 0.
    pub dash: f32,
    /// Share of `dash` that is gap, 0..=1. Default 0.4.
    pub gap: f32,
    /// What dashes are counted along.
    pub along: DashAlong,
}

impl HatchOutline {
    /// A solid line, `width` in pixels.
    pub fn solid(width: f32) -> Self {
        Self { width, ..default() }
    }

    /// A dashed line; `width` and the length of a dash with its gap in pixels.
    pub fn dashed(width: f32, dash: f32) -> Self {
        Self {
            width,
            dash,
            ..default()
        }
    }
}

impl Default for HatchOutline {
    fn default() -> Self {
        Self {
            width: 0.0,
            dash: 0.0,
            gap: 0.4,
            along: DashAlong::default(),
        }
    }
}

/// Pseudo-chroma-depth: what is near is red, what is far is blue, purple between.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct ChromaDepth {
    /// Depth before the camera that is red, in world units. Default 1.
    pub near: f32,
    /// Depth that is blue. Default 10.
    pub far: f32,
    /// How much of this colour the ink takes, 0..=1. Default 0.
    pub ink: f32,
    /// How much of it the paper takes, 0..=1. Default 0.
    pub paper: f32,
}

impl Default for ChromaDepth {
    fn default() -> Self {
        Self {
            near: 1.0,
            far: 10.0,
            ink: 0.0,
            paper: 0.0,
        }
    }
}

/// Distances of [`HatchTone::Distance`] are measured from this entity: its position is written to the materials' tones,
/// where they have such a tone.
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[require(Transform)]
pub struct ToneSource {
    /// The materials. Default: none.
    pub materials: Vec<Handle<HatchMaterial>>,
}

/// Writes the position to the materials where it differs.
pub(super) fn carry_tone(
    sources: Query<(&ToneSource, &GlobalTransform)>,
    mut materials: ResMut<Assets<HatchMaterial>>,
) {
    for (source, transform) in &sources {
        let here = DistanceFrom::Point(transform.translation());
        for handle in &source.materials {
            let differs = |material: &HatchMaterial| match material.extension.tone {
                HatchTone::Distance { from, .. } => from != here,
                _ => false,
            };
            if materials.get(handle).is_some_and(differs)
                && let Some(mut material) = materials.get_mut(handle)
                && let HatchTone::Distance { from, .. } = &mut material.extension.tone
            {
                *from = here;
            }
        }
    }
}

/// The style of hatching; the extension of [`HatchMaterial`].
///
/// Over paper it is an illustration of two colours; with transparent paper the strokes lie over the shaded surface. Ink and
/// paper are not lit. From afar the strokes of a tone become its share of ink.
#[derive(Asset, Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Hatch {
    /// Colour of strokes and outlines. Default: a warm black, opaque.
    pub ink: LinearRgba,
    /// Colour over the shaded surface. Default: an old white, opaque.
    pub paper: LinearRgba,
    /// What decides how dark a place is drawn. Default: light.
    pub tone: HatchTone,
    /// Share of ink of the lightest tone, 0..=1. Default 0.
    pub lightest: f32,
    /// Share of ink of the darkest tone, `lightest`..=1. Default 0.85.
    pub darkest: f32,
    /// How strokes are made of a tone.
    pub strokes: HatchStrokes,
    /// What makes strokes look drawn by hand.
    pub hand: HatchHand,
    /// Lines where the surface turns out of sight. Default: none.
    pub outline: HatchOutline,
    /// Colour by depth. Default: none.
    pub chroma_depth: ChromaDepth,
    /// Cut out what is not ink, in the picture and in shadows. An opaque base gets `AlphaMode::Mask(0.5)` meanwhile.
    ///
    /// Shadows do not know the light: with [`HatchTone::Light`] the strokes of the darkest tone are kept, and the light
    /// inks a part of them. Strokes that are spaced in pixels are spaced in those of the shadow map there. Default `false`.
    pub cutout: bool,
    /// Filter the strokes over the pixel. Without it every pixel shows one point of them. Default `true`.
    pub anti_aliasing: bool,
    /// Where the style applies; [`Focus::width`] is not used. Default: everywhere.
    pub focus: Focus,
}

impl Default for Hatch {
    fn default() -> Self {
        Self {
            ink: LinearRgba::rgb(0.012, 0.010, 0.009),
            paper: LinearRgba::rgb(0.88, 0.84, 0.74),
            tone: HatchTone::LIGHT,
            lightest: 0.0,
            darkest: 0.85,
            strokes: HatchStrokes::default(),
            hand: HatchHand::default(),
            outline: HatchOutline::default(),
            chroma_depth: ChromaDepth::default(),
            cutout: false,
            anti_aliasing: true,
            focus: Focus::default(),
        }
    }
}
