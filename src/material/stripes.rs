//! `StripeMaterial`: a physically based material whose look a wave drives.
//!
//! In: [`Stripes`], the style (colours, profile, what a stripe drives, what it cuts out). Out: uniforms, an image and the
//! three shared buffers for `stripe_style.wgsl`, which turns sin Φ and the footprint into the share of each pixel that is
//! stripe. The state (field, phases) is the entity's; a material can be shared by any number of entities.

use super::{
    Focus,
    binding::{bind_as, pattern_shaders},
    focus::FocusUniform,
    pattern_fragment_shader, pattern_prepass_fragment_shader,
    style::{WaveStyle, select_variant},
};
use crate::wave::{
    StyleNeeds,
    layout::{GEOMETRY_BUFFER, SURFACE_BUFFER, WAVE_BUFFER},
};
use bevy::{
    mesh::MeshVertexBufferLayoutRef,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline},
    prelude::*,
    render::{
        render_resource::{AsBindGroup, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError},
        storage::ShaderBuffer,
    },
};

/// [`StandardMaterial`] with stripes that follow the entity's field. Entities without a pattern, or whose pattern is not
/// solved yet, show the base.
///
/// Works in forward and deferred rendering, in shadow maps and in the depth, normal and motion vector prepasses, with
/// skins and morph targets.
pub type StripeMaterial = ExtendedMaterial<StandardMaterial, Stripes>;

/// The shape of a stripe across one period.
#[derive(Reflect, Debug, Clone, PartialEq, Eq, Default)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum Profile {
    /// A stripe that takes [`Stripes::duty`] of the period, around the crest; edges as [`Stripes::softness`] says.
    #[default]
    Square,
    /// (1 + sin Φ) / 2. Duty and softness are not used.
    Sine,
    /// An image read from left (sin Φ = -1) to right (sin Φ = 1) along its middle row, times [`Stripes::color`]. Its alpha
    /// is the stripe.
    Ramp(Handle<Image>),
    /// A ramp from gap to stripe over the period along d, with one sharp edge. Needs a vector field.
    Sawtooth,
    /// An image whose width is one period along d, starting where sin Φ = 0 and rises; read along its middle row, times
    /// [`Stripes::color`]. Its alpha is the stripe. Give it a repeating sampler. Needs a vector field.
    Periodic(Handle<Image>),
}

impl Profile {
    fn image(&self) -> Option<&Handle<Image>> {
        match self {
            Self::Ramp(image) | Self::Periodic(image) => Some(image),
            Self::Square | Self::Sine | Self::Sawtooth => None,
        }
    }
}

/// The stripes that are drawn where a pattern has two waves ([`Waves`](crate::wave::Waves)).
///
/// A cross field does not tell its two waves apart, so that one of them alone would end in seams where it comes back as the
/// other: it needs [`StripeWaves::Both`], or fails with [`PatternError::NeedsBothWaves`](crate::error::PatternError::NeedsBothWaves).
/// Where there is one wave, that one is drawn.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default, Clone, PartialEq, Hash)]
pub enum StripeWaves {
    /// Of the wave along d.
    #[default]
    First,
    /// Of the wave along n × d.
    Second,
    /// Of both: the union of their stripes.
    Both,
}

impl StripeWaves {
    /// The setting that cannot be had on a cross field.
    pub(super) fn needs_apart(self) -> Option<&'static str> {
        match self {
            Self::First => Some("StripeWaves::First"),
            Self::Second => Some("StripeWaves::Second"),
            Self::Both => None,
        }
    }

    /// Definitions for `families.wgsl`.
    pub(super) fn variants(self) -> [(bool, &'static str); 2] {
        [
            (self == Self::Second, "WAVES_SECOND"),
            (self == Self::Both, "WAVES_BOTH"),
        ]
    }
}

/// What a stripe changes on the base material.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct PatternDrive {
    /// Opacity of the colours over the base colour, 0..=1. Default 1.
    pub base_color: f32,
    /// Light that stripes and gaps emit: their colours times this, as [`StandardMaterial::emissive`]. 0 or more, default 0.
    pub emissive: f32,
    /// Added to the perceptual roughness in a stripe, -1..=1. Default 0.
    pub roughness: f32,
    /// Height of a stripe above the gap in world units, drawn by bending the normal; negative engraves. Default 0.
    pub bump: f32,
}

impl Default for PatternDrive {
    fn default() -> Self {
        Self {
            base_color: 1.0,
            emissive: 0.0,
            roughness: 0.0,
            bump: 0.0,
        }
    }
}

/// A look at the wave itself instead of stripes, unlit.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Default, Clone, PartialEq, Hash)]
#[non_exhaustive]
pub enum DebugStyle {
    /// The stripes.
    #[default]
    None,
    /// Φ as a colour wheel (vector) or sin Φ from blue over white to red (line).
    Phase,
    /// Triangles with a branch red or blue by the sign of its winding, odd triangles yellow, doubt in grey.
    Singular,
    /// The angle between ∇Φ and d, from 0 (dark violet) over 45 (green) to 90 degrees (yellow).
    Angle,
    /// The colour class of the nearest vertex in the solver.
    Colors,
    /// The energy of the triangle's edges, w (1 - cos r): 0 black, 0.5 red, 1 and more yellow.
    Energy,
}

/// The style of stripes; the extension of [`StripeMaterial`].
///
/// Colours lie over the base colour with their alpha. Far away stripes become the mean of what is drawn near, in linear
/// colour space.
#[derive(Asset, Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Stripes {
    /// Colour of the stripes. Default: a dark blue, opaque.
    pub color: LinearRgba,
    /// Colour of the gaps. Default: transparent, which shows the base.
    pub gap_color: LinearRgba,
    /// Share of a period that is stripe, 0..=1. Default 0.5.
    pub duty: f32,
    /// Softness of the edges: 0 is as sharp as a pixel, at 1 the slopes of an edge and the next meet, like a sine. Default 0.
    pub softness: f32,
    /// Shape of a stripe. Default [`Profile::Square`].
    pub profile: Profile,
    /// Which waves are drawn, where the pattern has two. Default: the first.
    pub waves: StripeWaves,
    /// Added to the phase, in periods. Needs a vector field. Default 0.
    pub phase_offset: f32,
    /// How fast the pattern travels along d, in periods per second. Needs a vector field. Default 0.
    pub phase_speed: f32,
    /// What the stripes drive. Default: the base colour.
    pub drive: PatternDrive,
    /// Cut the gaps out, in the picture and in shadows. An opaque base gets `AlphaMode::Mask(0.5)` meanwhile. Default `false`.
    pub cutout: bool,
    /// Filter the profile over the pixel. Without it every pixel shows one point of the pattern, which is right where a
    /// picture is supersampled already and flickers everywhere else. Default `true`.
    pub anti_aliasing: bool,
    /// Where the style applies. Default: everywhere.
    pub focus: Focus,
    /// Show the wave instead. Default: no.
    pub debug: DebugStyle,
}

impl Default for Stripes {
    fn default() -> Self {
        Self {
            color: LinearRgba::rgb(0.01, 0.03, 0.12),
            gap_color: LinearRgba::NONE,
            duty: 0.5,
            softness: 0.0,
            profile: Profile::Square,
            waves: StripeWaves::First,
            phase_offset: 0.0,
            phase_speed: 0.0,
            drive: PatternDrive::default(),
            cutout: false,
            anti_aliasing: true,
            focus: Focus::default(),
            debug: DebugStyle::None,
        }
    }
}

impl Stripes {
    /// The first setting that means nothing on a line field, where only sin Φ is defined, for
    /// [`PatternError::NeedsVectorSymmetry`](crate::error::PatternError::NeedsVectorSymmetry). There the shader draws
    /// square stripes instead, at rest.
    pub fn requires_vector_symmetry(&self) -> Option<&'static str> {
        match self.profile {
            Profile::Sawtooth => Some("Profile::Sawtooth"),
            Profile::Periodic(_) => Some("Profile::Periodic"),
            _ if self.phase_offset != 0.0 => Some("Stripes::phase_offset"),
            _ if self.phase_speed != 0.0 => Some("Stripes::phase_speed"),
            _ => None,
        }
    }

    fn binding(&self) -> StripesBinding {
        let profile = match self.profile {
            Profile::Square => 0,
            Profile::Sine => 1,
            Profile::Ramp(_) => 2,
            Profile::Sawtooth => 3,
            Profile::Periodic(_) => 4,
        };
        StripesBinding {
            surface: SURFACE_BUFFER,
            geometry: GEOMETRY_BUFFER,
            waves: WAVE_BUFFER,
            style: StripesUniform {
                color: self.color.to_vec4(),
                gap_color: self.gap_color.to_vec4(),
                focus: self.focus.uniform(),
                drive: Vec4::new(
                    self.drive.base_color,
                    self.drive.emissive,
                    self.drive.roughness,
                    self.drive.bump,
                ),
                duty: self.duty.clamp(0.0, 1.0),
                softness: self.softness.clamp(0.0, 1.0),
                phase_offset: self.phase_offset,
                phase_speed: self.phase_speed,
                profile,
                debug: self.debug as u32,
                filter_width: if self.anti_aliasing { 1.0 } else { 0.0 },
            },
            image: self.profile.image().cloned(),
        }
    }
}

/// `struct Stripes` of `stripe_style.wgsl`.
#[derive(ShaderType, Debug, Clone, Default)]
struct StripesUniform {
    color: Vec4,
    gap_color: Vec4,
    focus: FocusUniform,
    drive: Vec4,
    duty: f32,
    softness: f32,
    phase_offset: f32,
    phase_speed: f32,
    profile: u32,
    debug: u32,
    filter_width: f32,
}

/// What the shaders bind. Apart from [`Stripes`], so that the shared buffers are no fields a user has to carry along.
#[derive(AsBindGroup, Clone)]
struct StripesBinding {
    #[storage(100, read_only, visibility(fragment))]
    surface: Handle<ShaderBuffer>,
    #[storage(101, read_only, visibility(fragment))]
    geometry: Handle<ShaderBuffer>,
    #[storage(102, read_only, visibility(fragment))]
    waves: Handle<ShaderBuffer>,
    #[uniform(103, visibility(fragment))]
    style: StripesUniform,
    #[texture(104, visibility(fragment))]
    #[sampler(105, visibility(fragment))]
    image: Option<Handle<Image>>,
}

/// Settings that select a variant of the shaders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct StripesKey {
    waves: StripeWaves,
    image: bool,
    cutout: bool,
    bump: bool,
    debug: bool,
}

impl Stripes {
    fn key(&self) -> StripesKey {
        StripesKey {
            waves: self.waves,
            image: self.profile.image().is_some(),
            cutout: self.cutout,
            bump: self.drive.bump != 0.0,
            debug: self.debug != DebugStyle::None,
        }
    }
}

bind_as!(Stripes => StripesBinding, StripesKey, "stripes");

impl MaterialExtension for Stripes {
    pattern_shaders!(pattern_fragment_shader(), pattern_prepass_fragment_shader());

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let StripesKey {
            waves,
            image,
            cutout,
            bump,
            debug,
        } = key.bind_group_data;
        let [second, both] = waves.variants();
        let variants = [
            (true, "PATTERN_STRIPES"),
            second,
            both,
            (cutout, "PATTERN_CUTOUT"),
            (bump, "PATTERN_BUMP"),
            (image, "STRIPES_IMAGE"),
            (debug, "STRIPES_DEBUG"),
        ];
        select_variant(descriptor, layout, &variants)
    }
}

impl WaveStyle for Stripes {
    fn focus(&self) -> &Focus {
        &self.focus
    }

    fn focus_mut(&mut self) -> &mut Focus {
        &mut self.focus
    }

    fn needs(&self) -> StyleNeeds {
        StyleNeeds {
            vector: self.requires_vector_symmetry(),
            apart: self.waves.needs_apart(),
            ..default()
        }
    }

    fn is_cutout(&self) -> bool {
        self.cutout
    }
}
