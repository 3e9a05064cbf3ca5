//! What the user can set: from the command line and in the panel.

use std::{
    fmt::{self, Display},
    path::PathBuf,
    str::FromStr,
};

use bevy::prelude::*;
use bevy_field_patterns::{
    field::Principal,
    prelude::*,
    wave::solver::{ColdStart, LocalRule},
};
use clap::ValueEnum;

use crate::common::{gltf::FIELD_ATTRIBUTE, mesh_file::read_field};

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
    /// Shape of a stripe across its period.
    pub shape: Shape,
    /// Colour of the stripes, sRGB.
    pub stripe_color: [u8; 3],
    /// Colour of the gaps, sRGB; a glTF file has colours of its own.
    pub gap_color: [u8; 3],
    /// Height of a stripe above the gap, in periods; negative engraves. Default 0.
    pub bump: f32,
    /// How fast the pattern travels, in periods per second; only along vectors. Default 0.
    pub speed: f32,
    /// How many waves there are.
    pub waves: WaveCount,
    /// Share of ink of the darkest hatching, 0 to 1. Default 0.85.
    pub darkness: f32,
    /// Width of a hatching stroke as a share of the distance of strokes, 0.01 to 1. Default 0.25.
    pub stroke: f32,
    /// What darker hatching has more of: 0 wider strokes, 1 more strokes. Default 0.6.
    pub density: f32,
    /// Width of the hatching's outline in pixels, 0 for none. Default 2.
    pub outline: f32,
    /// How the solver starts.
    pub method: Method,
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
            shape: Shape::default(),
            stripe_color: [16, 38, 92],
            gap_color: [242, 237, 224],
            bump: 0.0,
            speed: 0.0,
            waves: WaveCount::default(),
            darkness: 0.85,
            stroke: 0.25,
            density: 0.6,
            outline: 2.0,
            method: Method::default(),
        }
    }
}

impl ViewerSettings {
    /// The look of the stripes, where one period is `period` world units wide.
    pub fn stripes(&self, period: f32) -> Stripes {
        // What needs the phase itself is left out where a field of lines does not have one.
        let is_vector = self.symmetry == Symmetry::Vector;
        Stripes {
            color: srgb(self.stripe_color).into(),
            duty: self.duty,
            softness: self.softness,
            profile: match self.shape {
                Shape::Sine => Profile::Sine,
                Shape::Sawtooth if is_vector => Profile::Sawtooth,
                Shape::Sawtooth | Shape::Square => Profile::Square,
            },
            phase_speed: if is_vector { self.speed } else { 0.0 },
            drive: PatternDrive {
                bump: self.bump * period,
                ..default()
            },
            cutout: self.style == Style::Cutout,
            debug: self.style.debug(),
            ..default()
        }
    }
}

impl ViewerSettings {
    /// The waves of the pattern: a texture takes two.
    pub fn waves(&self) -> Waves {
        match self.waves {
            WaveCount::One if self.style == Style::Texture => Waves::ORTHOGONAL,
            WaveCount::One => Waves::Single,
            WaveCount::Two => Waves::ORTHOGONAL,
            WaveCount::Cross => Waves::Cross,
        }
    }

    /// The file of an image that the field allows.
    fn image(&self) -> &'static str {
        match (self.waves(), self.symmetry) {
            (Waves::Cross, _) => "textures/tiles.png",
            (_, Symmetry::Line) => "textures/weave.png",
            (_, Symmetry::Vector) => "textures/arrow.png",
        }
    }

    /// The look of a texture.
    pub fn texture(&self, assets: &AssetServer) -> PatternTexture {
        let moves = self.symmetry == Symmetry::Vector && self.waves() != Waves::Cross;
        // The arrow is white.
        let tint = if moves { srgb(self.stripe_color) } else { Color::WHITE };
        PatternTexture {
            image: assets.load(self.image()),
            tint: tint.into(),
            travel: Travel::Periods(if moves { self.speed } else { 0.0 }),
            ..default()
        }
    }

    /// The look of hatching.
    pub fn hatch(&self) -> Hatch {
        Hatch {
            darkest: self.darkness,
            strokes: HatchStrokes {
                width: self.stroke,
                density: self.density,
                ..default()
            },
            outline: HatchOutline::solid(self.outline),
            ..default()
        }
    }
}

/// A colour from the panel.
pub fn srgb([red, green, blue]: [u8; 3]) -> Color {
    Color::srgb_u8(red, green, blue)
}

/// What the pattern follows.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Field {
    /// One direction in the model's space, of any length but 0, projected into the surface.
    Axis(Vec3),
    /// The direction in which the surface bends least.
    #[default]
    Curvature,
    /// The vertex attribute `_FIELD` of a glTF file.
    Attribute,
    /// A file with one direction per vertex of the model's file.
    File(PathBuf),
}

impl Field {
    /// The symmetry that this kind of field has by nature.
    pub fn symmetry(&self) -> Symmetry {
        match self {
            Self::Axis(_) => Symmetry::Vector,
            Self::Curvature | Self::Attribute | Self::File(_) => Symmetry::Line,
        }
    }

    /// The field on a model, whose file has `vertices` vertices.
    pub fn direction(&self, vertices: Option<usize>) -> Result<DirectionField, String> {
        match self {
            Self::Axis(axis) => Dir3::new(*axis)
                .map(DirectionField::Axis)
                .map_err(|error| format!("{self} is no direction: {error}")),
            Self::Curvature => Ok(DirectionField::PrincipalCurvature {
                direction: Principal::Minor,
                smoothing: 30,
            }),
            Self::Attribute => Ok(DirectionField::Attribute(FIELD_ATTRIBUTE)),
            Self::File(path) => {
                let vertices = vertices.ok_or("a field file belongs to an OBJ, PLY or STL file")?;
                let field = read_field(path, vertices).map_err(|error| error.to_string())?;
                Ok(DirectionField::Vertices(field.into()))
            }
        }
    }
}

impl FromStr for Field {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "curvature" => Ok(Self::Curvature),
            None if text == "attribute" => Ok(Self::Attribute),
            Some(("axis", axis)) => parse_axis(axis).map(Self::Axis),
            Some(("file", path)) => Ok(Self::File(path.into())),
            _ => Err("known are axis:X,Y,Z, curvature, attribute and file:FIELD.txt".into()),
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
            Self::Attribute => f.write_str("attribute"),
            Self::File(path) => write!(f, "file:{}", path.display()),
        }
    }
}

/// What is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Style {
    /// Stripes in two colours
    #[default]
    Stripes,
    /// Stripes with holes between them
    Cutout,
    /// An image on two waves
    Texture,
    /// Strokes of ink by the light
    Hatch,
    /// Phase of the wave
    Phase,
    /// Triangles in which stripes begin or end
    Branches,
    /// Angle between the pattern and the field
    Angle,
    /// Energy of the wave
    Energy,
    /// Classes of vertices that the solver updates at once
    Classes,
    /// The model without a pattern
    Plain,
}

impl Style {
    fn debug(self) -> DebugStyle {
        match self {
            Self::Stripes | Self::Cutout | Self::Texture | Self::Hatch | Self::Plain => DebugStyle::None,
            Self::Phase => DebugStyle::Phase,
            Self::Branches => DebugStyle::Singular,
            Self::Angle => DebugStyle::Angle,
            Self::Energy => DebugStyle::Energy,
            Self::Classes => DebugStyle::Colors,
        }
    }
}

/// How many waves there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum WaveCount {
    /// One along the field (two under a texture)
    #[default]
    One,
    /// One along the field and one across
    Two,
    /// The two of a cross field
    Cross,
}

/// Shape of a stripe across its period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Shape {
    /// One colour between two edges
    #[default]
    Square,
    /// A sine
    Sine,
    /// A ramp with one edge; only along vectors
    Sawtooth,
}

/// How the solver starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// From coarse to fine
    #[default]
    Hierarchy,
    /// Local sweeps from a random start
    Local,
}

impl Method {
    /// The solver's name for it.
    pub fn cold_start(self) -> ColdStart {
        match self {
            Self::Hierarchy => ColdStart::default(),
            Self::Local => ColdStart::Local(LocalRule::default()),
        }
    }
}
