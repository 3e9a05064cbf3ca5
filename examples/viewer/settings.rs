//! What the user can set: from the command line and in the panel.

use std::{
    fmt::{self, Display},
    path::PathBuf,
    str::FromStr,
};

use bevy::prelude::*;
use clap::ValueEnum;

/// The settings of the pattern on the model.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct ViewerSettings {
    /// What the pattern follows.
    pub field: Field,
    /// Whether the field's direction and its opposite mean the same.
    pub symmetry: Symmetry,
    /// Stripes per diagonal of the model's bounding box, [`FREQUENCIES`](Self::FREQUENCIES). Default 40.
    pub frequency: f32,
    /// What is drawn.
    pub style: Style,
    /// Share of a period that is stripe, 0 to 1. Default 0.5.
    pub duty: f32,
    /// Softness of a stripe's edges: 0 (sharp as a pixel) to 1 (a sine). Default 0.
    pub softness: f32,
    /// Colour of the stripes, sRGB.
    pub stripe_color: [u8; 3],
    /// Colour of the gaps, sRGB.
    pub gap_color: [u8; 3],
}

impl ViewerSettings {
    /// Frequencies that the panel's slider offers.
    pub const FREQUENCIES: std::ops::RangeInclusive<f32> = 2.0..=200.0;
}

impl Default for ViewerSettings {
    fn default() -> Self {
        Self {
            field: Field::default(),
            symmetry: Field::default().symmetry(),
            frequency: 40.0,
            style: Style::default(),
            duty: 0.5,
            softness: 0.0,
            stripe_color: [16, 38, 92],
            gap_color: [242, 237, 224],
        }
    }
}

/// What the pattern follows.
#[derive(Clone, Debug, PartialEq)]
pub enum Field {
    /// One direction in the model's space, of any length but 0, projected into the surface.
    Axis(Vec3),
    /// The direction in which the surface bends least.
    Curvature,
    /// A file with one direction per vertex of the model's file.
    File(PathBuf),
}

impl Field {
    /// The symmetry that this kind of field has by nature.
    pub fn symmetry(&self) -> Symmetry {
        match self {
            Self::Axis(_) => Symmetry::Vector,
            Self::Curvature | Self::File(_) => Symmetry::Line,
        }
    }
}

impl Default for Field {
    fn default() -> Self {
        Self::Axis(Vec3::Y)
    }
}

impl FromStr for Field {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "curvature" => Ok(Self::Curvature),
            Some(("axis", axis)) => parse_axis(axis).map(Self::Axis),
            Some(("file", path)) => Ok(Self::File(path.into())),
            _ => Err("known are axis:X,Y,Z, curvature and file:FIELD.txt".into()),
        }
    }
}

fn parse_axis(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let axis = numbers
        .ok()
        .and_then(|numbers| <[f32; 3]>::try_from(numbers).ok())
        .map(Vec3::from_array);
    axis.filter(|axis| axis.try_normalize().is_some())
        .ok_or("an axis is three numbers, not all 0: axis:0,1,0".into())
}

/// Reads a frequency: finite and 0 or more.
pub fn parse_frequency(text: &str) -> Result<f32, String> {
    let frequency = text.parse().ok().filter(|f: &f32| f.is_finite() && *f >= 0.0);
    frequency.ok_or("a frequency is a number, 0 or more".into())
}

impl Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Axis(axis) => write!(f, "axis:{},{},{}", axis.x, axis.y, axis.z),
            Self::Curvature => f.write_str("curvature"),
            Self::File(path) => write!(f, "file:{}", path.display()),
        }
    }
}

/// Whether the opposite of a direction means the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Symmetry {
    /// It does: curvature, tensors.
    #[default]
    Line,
    /// It does not: flow, an axis.
    Vector,
}

/// What is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Style {
    /// Stripes in two colours
    #[default]
    Stripes,
    /// Stripes with holes between them
    Cutout,
    /// Phase of the wave
    Phase,
    /// Triangles in which stripes begin or end
    Branches,
    /// Angle between the pattern and the field
    Angle,
    /// Energy of the wave
    Energy,
    /// The model without a pattern
    Plain,
}
