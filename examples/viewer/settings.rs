//! What the user can set: from the command line and in the panel.

use std::{
    fmt::{self, Display},
    path::PathBuf,
    str::FromStr,
};

use bevy::prelude::*;
use bevy_field_patterns::prelude::*;
use clap::ValueEnum;

use crate::{
    common::{
        gltf::{FIELD_ATTRIBUTE, TENSOR_DIAGONAL_ATTRIBUTE, TENSOR_OFFDIAGONAL_ATTRIBUTE},
        mesh_file::read_field,
    },
    styles::{HatchSettings, StripeSettings, TensorSettings, TextureSettings},
};

/// The settings of the pattern on the model.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct ViewerSettings {
    /// What the pattern follows.
    pub field: Field,
    /// Whether the field's direction and its opposite mean the same.
    pub symmetry: Symmetry,
    /// Stripes per diagonal of the model's bounding box, [`FREQUENCIES`](Self::FREQUENCIES). Default 40.
    pub frequency: f32,
    /// Whether the pattern keeps its spacing while a skin or morph targets deform the model.
    pub pose: PatternPose,
    /// How many waves there are.
    pub waves: WaveCount,
    /// What is drawn.
    pub style: Style,
    /// Colour between stripes, sRGB; a glTF file has colours of its own.
    pub gap_color: [u8; 3],
    /// Of stripes, cut-outs and debug looks.
    pub stripes: StripeSettings,
    /// Of textures.
    pub texture: TextureSettings,
    /// Of hatching.
    pub hatch: HatchSettings,
    /// Of a tensor's stripes.
    pub tensor: TensorSettings,
    /// Where the style applies.
    pub focus: FocusSettings,
    /// How waves are solved.
    pub solver: SolverSettings,
}

impl ViewerSettings {
    /// Frequencies that the panel's slider offers.
    pub const FREQUENCIES: std::ops::RangeInclusive<f32> = 2.0..=200.0;

    /// The waves of the pattern: a texture takes two.
    pub fn waves(&self) -> Waves {
        match self.waves {
            WaveCount::One if self.style == Style::Texture => Waves::ORTHOGONAL,
            WaveCount::One => Waves::Single,
            WaveCount::Two => Waves::ORTHOGONAL,
            WaveCount::Cross => Waves::Cross,
        }
    }
}

impl Default for ViewerSettings {
    fn default() -> Self {
        Self {
            field: Field::default(),
            symmetry: Field::default().symmetry(),
            frequency: 40.0,
            pose: PatternPose::default(),
            waves: WaveCount::default(),
            style: Style::default(),
            gap_color: [242, 237, 224],
            stripes: StripeSettings::default(),
            texture: TextureSettings::default(),
            hatch: HatchSettings::default(),
            tensor: TensorSettings::default(),
            focus: FocusSettings::default(),
            solver: SolverSettings::default(),
        }
    }
}

/// A ball about the middle of the model, in which the style applies.
#[derive(Clone, Debug, PartialEq)]
pub struct FocusSettings {
    /// Radius in diagonals of the model's bounding box; from [`EVERYWHERE`](Self::EVERYWHERE) on there is no limit. Default:
    /// everywhere.
    pub radius: f32,
    /// Width of the soft border in diagonals. Default 0.05.
    pub border: f32,
    /// What is outside of the ball is in focus instead. Default `false`.
    pub invert: bool,
    /// Stripes grow thin out of focus. Default `false`.
    pub width: bool,
}

impl Default for FocusSettings {
    fn default() -> Self {
        Self {
            radius: Self::EVERYWHERE,
            border: 0.05,
            invert: false,
            width: false,
        }
    }
}

impl FocusSettings {
    /// The radius that reaches every model's ends.
    pub const EVERYWHERE: f32 = 0.6;

    /// The focus on a model.
    pub fn focus(&self, middle: Vec3, diagonal: f32) -> Focus {
        if self.radius >= Self::EVERYWHERE {
            return Focus::default();
        }
        Focus {
            border: self.border * diagonal,
            invert: self.invert,
            width: self.width,
            color: !self.width,
            ..Focus::sphere(middle, self.radius * diagonal)
        }
    }
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
    /// The major eigenvector of the attributes `_TENSOR_DIAGONAL` and `_TENSOR_OFFDIAGONAL` of a glTF file; of other files,
    /// and of the knot, that of a bar that is pulled and twisted.
    Tensor,
    /// A file with one direction per vertex of the model's file.
    File(PathBuf),
}

impl Field {
    /// The symmetry that this kind of field has by nature.
    pub fn symmetry(&self) -> Symmetry {
        match self {
            Self::Axis(_) => Symmetry::Vector,
            Self::Curvature | Self::Attribute | Self::Tensor | Self::File(_) => Symmetry::Line,
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
            Self::Tensor => Ok(DirectionField::Tensor(TensorField {
                diagonal: TENSOR_DIAGONAL_ATTRIBUTE,
                off_diagonal: TENSOR_OFFDIAGONAL_ATTRIBUTE,
                ..default()
            })),
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
            None if text == "tensor" => Ok(Self::Tensor),
            Some(("axis", axis)) => parse_axis(axis).map(Self::Axis),
            Some(("file", path)) => Ok(Self::File(path.into())),
            _ => Err("known are axis:X,Y,Z, curvature, attribute, tensor and file:FIELD.txt".into()),
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
            Self::Tensor => f.write_str("tensor"),
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
    /// Strokes of ink
    Hatch,
    /// Stripes of two eigenvalues; of the scalar, where the field is no tensor
    Tensor,
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
    /// The look of stripes that shows how the pattern is made.
    pub fn debug(self) -> DebugStyle {
        match self {
            Self::Stripes | Self::Cutout | Self::Texture | Self::Hatch | Self::Tensor | Self::Plain => DebugStyle::None,
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
