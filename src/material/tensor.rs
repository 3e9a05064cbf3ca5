//! `TensorMaterial`: a tensor's first two eigenvalues as stripes along an eigenvector.
//!
//! In: [`Tensor`], the style, and the pattern's two scalars per vertex, which are the eigenvalues. Out: uniforms and the
//! three shared buffers for `tensor_style.wgsl`, which draws stripes of the first eigenvalue on the crests of the wave and those
//! of the second on its troughs: colour by value, width by magnitude, another colour beyond a limit.

use super::{
    Focus, StripeWaves,
    binding::{bind_as, pattern_shaders},
    focus::FocusUniform,
    hatch_options::apart,
    pattern_fragment_shader, pattern_prepass_fragment_shader,
    style::{WaveStyle, WaveStylePlugin, select_variant},
};
use crate::wave::{
    StyleNeeds,
    layout::{GEOMETRY_BUFFER, SURFACE_BUFFER, WAVE_BUFFER},
};
use bevy::{
    mesh::MeshVertexBufferLayoutRef,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline, MaterialPlugin},
    prelude::*,
    render::{
        render_resource::{AsBindGroup, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError},
        storage::ShaderBuffer,
    },
};

/// [`StandardMaterial`] with stripes that show two eigenvalues. Entities without a pattern, or whose pattern is not solved
/// yet, show the base.
///
/// Stripes run across the direction field: to see them run along an eigenvector, let the field be that eigenvector turned
/// by a quarter turn ([`FieldTurn`](crate::field::FieldTurn)), or draw the second of two waves.
///
/// Works in forward and deferred rendering, in shadow maps and in the depth, normal and motion vector prepasses, with
/// skins, morph targets and fog.
pub type TensorMaterial = ExtendedMaterial<StandardMaterial, Tensor>;

/// How the stripes of one eigenvalue look. Values are in the scalar's own unit.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Eigenvalue {
    /// Colour at [`Eigenvalue::low`] and below. Default: a pale green.
    pub low_color: LinearRgba,
    /// Colour at [`Eigenvalue::high`] and above. Default: a dark green.
    pub high_color: LinearRgba,
    /// The value of the one colour. Default 0.
    pub low: f32,
    /// The value of the other. Default 1.
    pub high: f32,
    /// Above this value stripes have [`Eigenvalue::alert_color`]. Default: infinity, nowhere.
    pub limit: f32,
    /// Default: purple.
    pub alert_color: LinearRgba,
    /// The absolute value at which stripes are [`Eigenvalue::thick`]. More than 0, default 1.
    pub magnitude: f32,
    /// Width of a stripe at the value 0, as a share of half a period. 0..=1, default 0.1.
    pub thin: f32,
    /// Width of a stripe at [`Eigenvalue::magnitude`] and beyond, as a share of half a period; at 1 stripes of two full
    /// eigenvalues touch. 0..=1, default 0.9.
    pub thick: f32,
}

impl Default for Eigenvalue {
    fn default() -> Self {
        Self {
            low_color: LinearRgba::rgb(0.36, 0.62, 0.32),
            high_color: LinearRgba::rgb(0.0, 0.16, 0.04),
            low: 0.0,
            high: 1.0,
            limit: f32::INFINITY,
            alert_color: LinearRgba::rgb(0.20, 0.01, 0.38),
            magnitude: 1.0,
            thin: 0.1,
            thick: 0.9,
        }
    }
}

impl Eigenvalue {
    /// The looks of a second eigenvalue: orange, magenta beyond the limit.
    pub const SECOND: Self = Self {
        low_color: LinearRgba::rgb(0.98, 0.66, 0.30),
        high_color: LinearRgba::rgb(0.75, 0.16, 0.0),
        low: 0.0,
        high: 1.0,
        limit: f32::INFINITY,
        alert_color: LinearRgba::rgb(0.80, 0.0, 0.42),
        magnitude: 1.0,
        thin: 0.1,
        thick: 0.9,
    };

    /// The range from `low` to `high` for colours, and the larger of the two magnitudes for widths.
    pub fn with_range(mut self, low: f32, high: f32) -> Self {
        (self.low, self.high) = (low, high);
        self.magnitude = low.abs().max(high.abs());
        self
    }

    /// Alerts above `limit`.
    pub fn with_limit(mut self, limit: f32) -> Self {
        self.limit = limit;
        self
    }

    fn uniform(&self) -> EigenvalueUniform {
        let range = apart(self.low, self.high);
        EigenvalueUniform {
            low_color: self.low_color.to_vec4(),
            high_color: self.high_color.to_vec4(),
            alert_color: self.alert_color.to_vec4(),
            // WGSL may take for granted that there are no infinities.
            values: Vec4::new(
                range.x,
                range.y,
                self.limit.clamp(-1e15, 1e15),
                self.magnitude.max(1e-15),
            ),
            widths: Vec2::new(self.thin, self.thick).clamp(Vec2::ZERO, Vec2::ONE),
            pad: Vec2::ZERO,
        }
    }
}

/// The style of a tensor's stripes; the extension of [`TensorMaterial`].
#[derive(Asset, Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Tensor {
    /// The pattern's first scalar, on the crests.
    pub first: Eigenvalue,
    /// The pattern's second scalar, on the troughs.
    pub second: Eigenvalue,
    /// Colour between the stripes. Default: transparent, which shows the base.
    pub gap_color: LinearRgba,
    /// Width in pixels of the line where a value passes its limit; 0: none. Default 1.5.
    pub line_width: f32,
    /// Colour of this line. Default: black.
    pub line_color: LinearRgba,
    /// Softness of the stripes' edges, 0..=1. Default 0.
    pub softness: f32,
    /// Light that the colours emit: themselves times this. 0 or more, default 0.
    pub emissive: f32,
    /// Which waves are drawn, where the pattern has two. Default: the first.
    pub waves: StripeWaves,
    /// Cut the gaps out, in the picture and in shadows. An opaque base gets `AlphaMode::Mask(0.5)` meanwhile. Default `false`.
    pub cutout: bool,
    /// Filter over the pixel. Without it every pixel shows one point of the pattern. Default `true`.
    pub anti_aliasing: bool,
    /// Where the style applies. Default: everywhere.
    pub focus: Focus,
}

impl Default for Tensor {
    fn default() -> Self {
        Self {
            first: Eigenvalue::default(),
            second: Eigenvalue::SECOND,
            gap_color: LinearRgba::NONE,
            line_width: 1.5,
            line_color: LinearRgba::BLACK,
            softness: 0.0,
            emissive: 0.0,
            waves: StripeWaves::First,
            cutout: false,
            anti_aliasing: true,
            focus: Focus::default(),
        }
    }
}

/// Draws [`TensorMaterial`].
#[derive(Debug, Clone, Copy, Default)]
pub struct TensorMaterialPlugin;

impl Plugin for TensorMaterialPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            MaterialPlugin::<TensorMaterial>::default(),
            WaveStylePlugin::<Tensor>::default(),
        ))
        .register_type::<Tensor>()
        .register_asset_reflect::<TensorMaterial>();
    }
}

/// `struct Eigenvalue` of `tensor_style.wgsl`.
#[derive(ShaderType, Debug, Clone, Copy, Default)]
struct EigenvalueUniform {
    low_color: Vec4,
    high_color: Vec4,
    alert_color: Vec4,
    values: Vec4,
    widths: Vec2,
    pad: Vec2,
}

/// `struct Tensor` of `tensor_style.wgsl`.
#[derive(ShaderType, Debug, Clone, Default)]
struct TensorUniform {
    first: EigenvalueUniform,
    second: EigenvalueUniform,
    gap_color: Vec4,
    line_color: Vec4,
    focus: FocusUniform,
    line_width: f32,
    softness: f32,
    emissive: f32,
    filter_width: f32,
}

/// What the shaders bind.
#[derive(AsBindGroup, Clone)]
struct TensorBinding {
    #[storage(100, read_only, visibility(fragment))]
    surface: Handle<ShaderBuffer>,
    #[storage(101, read_only, visibility(fragment))]
    geometry: Handle<ShaderBuffer>,
    #[storage(102, read_only, visibility(fragment))]
    waves: Handle<ShaderBuffer>,
    #[uniform(103, visibility(fragment))]
    style: TensorUniform,
}

impl Tensor {
    fn binding(&self) -> TensorBinding {
        TensorBinding {
            surface: SURFACE_BUFFER,
            geometry: GEOMETRY_BUFFER,
            waves: WAVE_BUFFER,
            style: TensorUniform {
                first: self.first.uniform(),
                second: self.second.uniform(),
                gap_color: self.gap_color.to_vec4(),
                line_color: self.line_color.to_vec4(),
                focus: self.focus.uniform(),
                line_width: self.line_width.max(0.0),
                softness: self.softness.clamp(0.0, 1.0),
                emissive: self.emissive.max(0.0),
                filter_width: if self.anti_aliasing { 1.0 } else { 0.0 },
            },
        }
    }
}

/// Settings that select a variant of the shaders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TensorKey {
    waves: StripeWaves,
    cutout: bool,
}

impl Tensor {
    fn key(&self) -> TensorKey {
        TensorKey {
            waves: self.waves,
            cutout: self.cutout,
        }
    }
}

bind_as!(Tensor => TensorBinding, TensorKey, "tensor");

impl WaveStyle for Tensor {
    fn focus(&self) -> &Focus {
        &self.focus
    }

    fn focus_mut(&mut self) -> &mut Focus {
        &mut self.focus
    }

    fn needs(&self) -> StyleNeeds {
        StyleNeeds {
            apart: self.waves.needs_apart(),
            ..default()
        }
    }

    fn is_cutout(&self) -> bool {
        self.cutout
    }
}

impl MaterialExtension for Tensor {
    pattern_shaders!(pattern_fragment_shader(), pattern_prepass_fragment_shader());

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let TensorKey { waves, cutout } = key.bind_group_data;
        let [second, both] = waves.variants();
        let variants = [(true, "PATTERN_TENSOR"), second, both, (cutout, "PATTERN_CUTOUT")];
        select_variant(descriptor, layout, &variants)
    }
}
