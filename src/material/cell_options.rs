//! What can be said about the look of cells.
//!
//! In: nothing. Out: the plain types of [`Cells`](super::Cells), and nothing that knows of the GPU.

use bevy::prelude::*;

/// What colour a cell has.
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum CellFill {
    /// The base material shows.
    Base,
    /// One of these colours, drawn by lot; the first [`MAX_PALETTE`] are used. Colours lie over the base with their alpha.
    /// An empty palette shows the base.
    Palette(Vec<LinearRgba>),
    /// The sample's own colour, from [`SampleValues`](crate::cells::SampleValues): mosaics, quantities. White without them.
    Values,
}

/// The colours of a palette that are used.
pub const MAX_PALETTE: usize = 16;

impl Default for CellFill {
    fn default() -> Self {
        let stones = [
            (0.62, 0.52, 0.40),
            (0.47, 0.36, 0.26),
            (0.72, 0.66, 0.55),
            (0.36, 0.31, 0.27),
            (0.55, 0.45, 0.38),
        ];
        Self::Palette(stones.map(|(r, g, b)| LinearRgba::rgb(r, g, b)).to_vec())
    }
}

/// The outline of a cell.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum CellShape {
    /// The whole Voronoi region.
    #[default]
    Voronoi,
    /// The sample's ellipse, cut where the next sample's region begins: a picture of the metric.
    Ellipse {
        /// Size of the ellipse; 1 is the metric's unit ball, which touches its neighbours'. Above 0.
        radius: f32,
    },
}

/// How wide a border is. It is as wide along all of a cell, however long that is.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum BorderWidth {
    /// In pixels, from wherever it is seen; of small cells no more than a third of the radius.
    Pixels(f32),
    /// In world units, on the surface as it is posed.
    World(f32),
    /// In mean radii of the cell's own ellipse, on the mesh at rest: small cells get narrow borders.
    Relative(f32),
}

impl BorderWidth {
    pub(super) fn value(self) -> f32 {
        match self {
            Self::Pixels(width) | Self::World(width) | Self::Relative(width) => width.max(0.0),
        }
    }
}

impl Default for BorderWidth {
    fn default() -> Self {
        Self::Pixels(1.5)
    }
}

/// How a cell chooses its tile of an atlas.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Default)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum TileChoice {
    /// By lot.
    #[default]
    Random,
    /// By the luminance of the sample's [value](crate::cells::SampleValues): 0 is the first tile, 1 the last.
    Value,
}

/// An image in every cell, or one of the images of an atlas, over the fill with its alpha.
#[derive(Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct CellTexture {
    /// The image. Its u axis lies along the ellipse's long axis. Until it is loaded, and if it never is, Bevy does not draw the
    /// mesh.
    pub image: Handle<Image>,
    /// Columns of the atlas, 1 or more. Default 1.
    pub columns: u32,
    /// Rows of the atlas, 1 or more. Default 1.
    pub rows: u32,
    /// Ellipse radii from the sample to the edge of the image, above 0; beyond it the edge is repeated. Cells reach 1.2 to
    /// 1.5 radii. Default 1.4.
    pub radius: f32,
    /// Which tile a cell takes. Default: by lot.
    pub choice: TileChoice,
}

impl Default for CellTexture {
    fn default() -> Self {
        Self {
            image: Handle::default(),
            columns: 1,
            rows: 1,
            radius: 1.4,
            choice: TileChoice::Random,
        }
    }
}

/// A look at the search for cells instead of the cells, unlit.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default, Clone, PartialEq, Hash)]
#[non_exhaustive]
pub enum CellDebug {
    /// The cells.
    #[default]
    None,
    /// The sample's index: its lowest byte is red, the next green, the next blue, linear, 255 being 1.
    Label,
    /// Green where the nearest of the triangle's three seeds was right, red where a neighbour was nearer.
    Seed,
    /// Grey: how many distances were evaluated, 32 being white.
    Evaluations,
    /// Whether the search is right: green where it found the nearest of all samples, red where another one is nearer (by more
    /// than rounding). Looks at every sample in every pixel, which takes long.
    Check,
}
