//! `PatternTextureMaterial`: a physically based material with an image on the two waves of a pattern.
//!
//! In: [`PatternTexture`], the style (images, travel, fade, colours, patches). Out: uniforms, two images and the three
//! shared buffers for `texture_style.wgsl`, which reads the images at (u, v) = the phases of the two waves in periods
//! (section 3.6 of Lichtenberg et al. 2018). The state (field, phases) is the entity's; a material can be shared by any
//! number of entities.

use super::{
    Focus, MAX_COLOR_STOPS, Patches, PatternDrive, ScalarChannel, ScalarColor, TextureFade, TextureHeight, Travel,
    binding::pattern_shaders,
    focus::FocusUniform,
    pattern_fragment_shader, pattern_prepass_fragment_shader,
    style::{WaveStyle, select_variant},
};
use crate::wave::{
    StyleNeeds,
    layout::{GEOMETRY_BUFFER, SURFACE_BUFFER, WAVE_BUFFER},
};
use bevy::{
    ecs::system::{SystemParamItem, lifetimeless::SRes},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline},
    prelude::*,
    render::{
        render_asset::RenderAssets,
        render_resource::{
            AddressMode, AsBindGroup, AsBindGroupError, BindGroupLayout, BindGroupLayoutEntry, FilterMode,
            MipmapFilterMode, OwnedBindingResource, RenderPipelineDescriptor, SamplerBindingType, SamplerDescriptor,
            ShaderType, SpecializedMeshPipelineError, UnpreparedBindGroup,
        },
        renderer::RenderDevice,
        storage::{GpuShaderBuffer, ShaderBuffer},
        texture::{FallbackImage, GpuImage},
    },
};

/// [`StandardMaterial`] with an image in every period cell of the entity's two waves, so the entity needs
/// [`Waves::Orthogonal`](crate::wave::Waves) or [`Waves::Cross`](crate::wave::Waves). Entities without a pattern, or whose
/// pattern is not solved yet, show the base.
///
/// Works in forward and deferred rendering, in shadow maps and in the depth, normal and motion vector prepasses, with
/// skins and morph targets.
///
/// # Pitfalls
///
/// The image's right is d, its top is n × d, and its middle is where crests of both waves cross. What is drawn must not
/// change under what the field cannot tell apart:
///
/// | waves, symmetry | what neighbours may see turned | images that fit |
/// |---|---|---|
/// | `Orthogonal`, `Vector` | nothing: arrows point along d everywhere but at branches | any |
/// | `Orthogonal`, `Line` | half a turn: right is left **and** top is bottom | those that look the same after half a turn: weaves, lenses, the letter S; not arrows, not the letter A |
/// | `Cross` | quarter turns | those that look the same after a quarter turn: tiles, crosses, pinwheels; not lines in one direction |
///
/// * Half a turn is no mirror image: the letter S fits, the letter A does not.
/// * A field that looks oriented, such as principal curvature on a tube, is a line field all the same: d may change its sign
///   from vertex to vertex. Set [`Symmetry::Vector`](crate::field::Symmetry) only where the sign is meant.
/// * Anything that moves ([`travel`](PatternTexture::travel), [`offset`](PatternTexture::offset)) needs a vector field, and is refused on others
///   with [`PatternError::NeedsVectorSymmetry`](crate::error::PatternError::NeedsVectorSymmetry).
/// * The two waves branch in different places. Near a branch of either the image fades to its mean; in a triangle that no
///   frame fits, at a singularity of the field, it is the blend of three views.
/// * The image should continue itself from right to left and from top to bottom, or be transparent or of one colour there.
pub type PatternTextureMaterial = ExtendedMaterial<StandardMaterial, PatternTexture>;

/// The style of textures; the extension of [`PatternTextureMaterial`], which says which images fit which field.
///
/// The image lies over the base colour with its alpha. It repeats and is filtered trilinearly and anisotropically, whatever
/// its own sampler is; images of one level get mip levels as soon as they are loaded
/// ([`with_mipmaps`](super::with_mipmaps)).
#[derive(Asset, Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct PatternTexture {
    /// The image in every period cell, its right along d, its top along n × d. Until it is loaded, and if it never is, Bevy
    /// does not draw the mesh. Default: white.
    pub image: Handle<Image>,
    /// Multiplies the image's colour and alpha. Default: white.
    pub tint: LinearRgba,
    /// Shift of the image along d and n × d, in periods. Needs a vector field. Default 0.
    pub offset: Vec2,
    /// How the image travels along d. Default: not at all.
    pub travel: Travel,
    /// A second image, less salient, where a scalar says so. Default: none.
    pub fade: Option<TextureFade>,
    /// Multiplies the image's colour by one that stands for a scalar. Default: none.
    pub color: Option<ScalarColor>,
    /// Takes the image for an atlas, and chooses a tile for each period cell by a scalar. Default: none.
    pub patches: Option<Patches>,
    /// What the image drives, where it is opaque. Default: the base colour.
    pub drive: PatternDrive,
    /// What the height of a bump follows. Default: alpha.
    pub height: TextureHeight,
    /// Cut out where the image is transparent, in the picture and in shadows. An opaque base gets `AlphaMode::Mask(0.5)`
    /// meanwhile. Default `false`.
    pub cutout: bool,
    /// Filter the image over the pixel. Without it every pixel shows one point of the image, which is right where a picture
    /// is supersampled already and flickers everywhere else. Default `true`.
    pub anti_aliasing: bool,
    /// Where the style applies; [`Focus::width`] means nothing here. Default: everywhere.
    pub focus: Focus,
}

impl Default for PatternTexture {
    fn default() -> Self {
        Self {
            image: Handle::default(),
            tint: LinearRgba::WHITE,
            offset: Vec2::ZERO,
            travel: Travel::REST,
            fade: None,
            color: None,
            patches: None,
            drive: PatternDrive::default(),
            height: TextureHeight::Alpha,
            cutout: false,
            anti_aliasing: true,
            focus: Focus::default(),
        }
    }
}

/// `struct TextureStyle` of `texture_style.wgsl`.
#[derive(ShaderType, Debug, Clone, Default)]
struct TextureUniform {
    color_stops: [Vec4; MAX_COLOR_STOPS],
    tint: Vec4,
    drive: Vec4,
    travel: Vec4,
    focus: FocusUniform,
    offset: Vec2,
    fade: Vec2,
    color_range: Vec2,
    tile_range: Vec2,
    tiles: UVec2,
    color_count: u32,
    scalars: u32,
    height: u32,
    filter_width: f32,
}

impl PatternTexture {
    const FADE_BY_SECOND: u32 = 1;
    const COLOR_BY_SECOND: u32 = 1 << 1;
    const TILE_BY_SECOND: u32 = 1 << 2;

    /// The first setting that means nothing on a line field, for
    /// [`PatternError::NeedsVectorSymmetry`](crate::error::PatternError::NeedsVectorSymmetry).
    pub fn requires_vector_symmetry(&self) -> Option<&'static str> {
        if self.travel.moves() {
            Some("PatternTexture::travel")
        } else if self.offset != Vec2::ZERO {
            Some("PatternTexture::offset")
        } else {
            None
        }
    }

    /// The images that the style reads.
    pub(super) fn images(&self) -> impl Iterator<Item = &Handle<Image>> {
        let quiet = self.fade.as_ref().and_then(|fade| fade.image.as_ref());
        [Some(&self.image), quiet].into_iter().flatten()
    }

    fn uniform(&self) -> TextureUniform {
        let fade = self.fade.clone().unwrap_or_default();
        let color = self.color.clone().unwrap_or_default();
        let patches = self.patches.clone().unwrap_or_default();
        let mut color_stops = [Vec4::ONE; MAX_COLOR_STOPS];
        let stops = color.map.stops();
        for (slot, stop) in color_stops.iter_mut().zip(&stops) {
            *slot = stop.to_vec4();
        }
        let scalars = [
            (fade.scalar, Self::FADE_BY_SECOND),
            (color.scalar, Self::COLOR_BY_SECOND),
            (patches.scalar, Self::TILE_BY_SECOND),
        ];
        TextureUniform {
            color_stops,
            tint: self.tint.to_vec4(),
            drive: Vec4::new(
                self.drive.base_color,
                self.drive.emissive,
                self.drive.roughness,
                self.drive.bump,
            ),
            travel: self.travel.vector(),
            focus: self.focus.uniform(),
            offset: self.offset,
            fade: Vec2::new(fade.begin, fade.end),
            color_range: Vec2::new(color.low, color.high),
            tile_range: Vec2::new(patches.low, patches.high),
            tiles: UVec2::new(patches.columns, patches.rows).max(UVec2::ONE),
            color_count: stops.len() as u32,
            scalars: scalars
                .into_iter()
                .filter(|scalar| scalar.0 == ScalarChannel::Second)
                .fold(0, |flags, scalar| flags | scalar.1),
            height: self.height as u32,
            filter_width: if self.anti_aliasing { 1.0 } else { 0.0 },
        }
    }
}

/// What the shaders bind. Apart from [`PatternTexture`], so that the shared buffers are no fields a user has to carry along.
#[derive(AsBindGroup, Clone)]
struct TextureBinding {
    #[storage(100, read_only, visibility(fragment))]
    surface: Handle<ShaderBuffer>,
    #[storage(101, read_only, visibility(fragment))]
    geometry: Handle<ShaderBuffer>,
    #[storage(102, read_only, visibility(fragment))]
    waves: Handle<ShaderBuffer>,
    #[uniform(103, visibility(fragment))]
    style: TextureUniform,
    #[texture(104, visibility(fragment))]
    #[sampler(105, visibility(fragment))]
    image: Option<Handle<Image>>,
    #[texture(106, visibility(fragment))]
    quiet: Option<Handle<Image>>,
}

/// The binding of the sampler, in place of the image's own.
const SAMPLER: u32 = 105;

/// Settings that select a variant of the shaders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PatternTextureKey {
    travel: bool,
    fade: bool,
    quiet: bool,
    color: bool,
    patches: bool,
    cutout: bool,
    bump: bool,
}

impl AsBindGroup for PatternTexture {
    type Data = PatternTextureKey;
    type Param = (
        SRes<RenderAssets<GpuImage>>,
        SRes<FallbackImage>,
        SRes<RenderAssets<GpuShaderBuffer>>,
    );

    fn label() -> &'static str {
        "pattern texture"
    }

    fn bind_group_data(&self) -> PatternTextureKey {
        PatternTextureKey {
            travel: matches!(self.travel, Travel::Speed { .. }),
            fade: self.fade.is_some(),
            quiet: self.fade.as_ref().is_some_and(|fade| fade.image.is_some()),
            color: self.color.is_some(),
            patches: self.patches.is_some(),
            cutout: self.cutout,
            bump: self.drive.bump != 0.0,
        }
    }

    fn unprepared_bind_group(
        &self,
        layout: &BindGroupLayout,
        render_device: &RenderDevice,
        param: &mut SystemParamItem<'_, '_, Self::Param>,
        force_no_bindless: bool,
    ) -> Result<UnpreparedBindGroup, AsBindGroupError> {
        let binding = TextureBinding {
            surface: SURFACE_BUFFER,
            geometry: GEOMETRY_BUFFER,
            waves: WAVE_BUFFER,
            style: self.uniform(),
            image: Some(self.image.clone()),
            quiet: self.fade.as_ref().and_then(|fade| fade.image.clone()),
        };
        let mut group = binding.unprepared_bind_group(layout, render_device, param, force_no_bindless)?;
        let sampler = render_device.create_sampler(&SamplerDescriptor {
            label: Some("pattern texture"),
            address_mode_u: AddressMode::Repeat,
            address_mode_v: AddressMode::Repeat,
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            mipmap_filter: MipmapFilterMode::Linear,
            ..default()
        });
        for (index, resource) in &mut group.bindings.0 {
            if *index == SAMPLER {
                *resource = OwnedBindingResource::Sampler(SamplerBindingType::Filtering, sampler.clone());
            }
        }
        Ok(group)
    }

    fn bind_group_layout_entries(render_device: &RenderDevice, force_no_bindless: bool) -> Vec<BindGroupLayoutEntry> {
        TextureBinding::bind_group_layout_entries(render_device, force_no_bindless)
    }
}

impl MaterialExtension for PatternTexture {
    pattern_shaders!(pattern_fragment_shader(), pattern_prepass_fragment_shader());

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let key = key.bind_group_data;
        let variants = [
            (true, "PATTERN_TEXTURE"),
            (key.cutout, "PATTERN_CUTOUT"),
            (key.bump, "PATTERN_BUMP"),
            (key.travel, "TEXTURE_COPIES"),
            (key.fade, "TEXTURE_FADE"),
            (key.quiet, "TEXTURE_QUIET"),
            (key.color, "TEXTURE_COLOR"),
            (key.patches, "TEXTURE_PATCHES"),
        ];
        select_variant(descriptor, layout, &variants)
    }
}

impl WaveStyle for PatternTexture {
    fn focus(&self) -> &Focus {
        &self.focus
    }

    fn focus_mut(&mut self) -> &mut Focus {
        &mut self.focus
    }

    fn needs(&self) -> StyleNeeds {
        StyleNeeds {
            vector: self.requires_vector_symmetry(),
            two_waves: Some("PatternTexture"),
            ..default()
        }
    }

    fn is_cutout(&self) -> bool {
        self.cutout
    }
}
