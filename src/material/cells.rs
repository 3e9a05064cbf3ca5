//! `CellMaterial`: a physically based material whose look the cells of a sample set drive.
//!
//! In: [`Cells`], the style (fill, border, texture, relief). Out: uniforms, an image and the two shared buffers for
//! `cells_material.wgsl`, which finds the cell under a fragment and its distance from the cell's border. The samples are the
//! entity's; a material can be shared by any number of entities.

use super::{
    BorderWidth, CellDebug, CellFill, CellShape, CellTexture, MAX_PALETTE, TileChoice,
    binding::{bind_as, need_positions, pattern_shaders},
};
use crate::cells::layout::{CELL_BUFFER, SITE_BUFFER};
use bevy::{
    mesh::MeshVertexBufferLayoutRef,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline},
    prelude::*,
    render::{
        render_resource::{AsBindGroup, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError},
        storage::ShaderBuffer,
    },
    shader::ShaderDefVal,
};

/// [`StandardMaterial`] with the cells of the entity's [`SampleSet`](crate::sampling::SampleSet). Entities without samples
/// show the base.
///
/// Works in forward and deferred rendering, in shadow maps and in the depth, normal and motion vector prepasses. With skins
/// and morph targets the cells stay where they are on the mesh at rest.
pub type CellMaterial = ExtendedMaterial<StandardMaterial, Cells>;

/// The style of cells; the extension of [`CellMaterial`].
///
/// Lengths that are *relative* are in mean radii of the cell's own ellipse, so that one style suits meshes of any size and
/// cells of many sizes.
/// Where cells are smaller than pixels, the mean of what is drawn near takes their place.
#[derive(Asset, Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Cells {
    /// Colour of the cells. Default: a palette of stones.
    pub fill: CellFill,
    /// Brightness that differs from cell to cell, by up to this part either way, 0..=1; of the base too. Default 0.
    pub jitter: f32,
    /// Outline of the cells. Default: the Voronoi region.
    pub shape: CellShape,
    /// Width of the border between two cells, 0 or more. Default 1.5 pixels.
    pub border_width: BorderWidth,
    /// Colour of the border, over what is there with its alpha. Default: nearly black.
    pub border_color: LinearRgba,
    /// Colour between ellipses ([`CellShape::Ellipse`]). Default: transparent, which shows the base.
    pub gap_color: LinearRgba,
    /// Radius of a cell's corners, relative, 0..=1; the border fills what is cut off. Default 0: sharp corners.
    pub rounding: f32,
    /// How far borders wander off, in mean radii of all the entity's samples; 0.16 looks like grown tissue, much more frays them. Default 0: straight.
    pub noise: f32,
    /// Wiggles of such borders per mean radius, above 0. Default 1.6.
    pub noise_scale: f32,
    /// An image in every cell. Default: none.
    pub texture: Option<CellTexture>,
    /// Height of a cell's middle over its border, relative, drawn by bending the normal; negative: dents. Default 0: flat.
    pub bump: f32,
    /// Way from the border to where that height is reached, relative, above 0. Default 0.5.
    pub bump_width: f32,
    /// Cut out the borders (of ellipses: what lies between them), in the picture and in shadows. An opaque base gets
    /// `AlphaMode::Mask(0.5)`. Default `false`.
    pub cutout: bool,
    /// Show the search for cells instead. Default: no.
    pub debug: CellDebug,
}

impl Default for Cells {
    fn default() -> Self {
        Self {
            fill: CellFill::default(),
            jitter: 0.0,
            shape: CellShape::Voronoi,
            border_width: BorderWidth::default(),
            border_color: LinearRgba::rgb(0.02, 0.015, 0.01),
            gap_color: LinearRgba::NONE,
            rounding: 0.0,
            noise: 0.0,
            noise_scale: 1.6,
            texture: None,
            bump: 0.0,
            bump_width: 0.5,
            cutout: false,
            debug: CellDebug::None,
        }
    }
}

/// `struct CellStyle` of `cell_style.wgsl`.
#[derive(ShaderType, Debug, Clone, Default)]
pub(super) struct CellsUniform {
    palette: [Vec4; MAX_PALETTE],
    mean_color: Vec4,
    border_color: Vec4,
    gap_color: Vec4,
    border_width: f32,
    border_unit: u32,
    fill_kind: u32,
    palette_len: u32,
    jitter: f32,
    rounding: f32,
    noise: f32,
    noise_scale: f32,
    bump: f32,
    bump_width: f32,
    ellipse_radius: f32,
    texture_radius: f32,
    tiles: UVec2,
    flags: u32,
    debug: u32,
}

/// Below this a length of the style would divide by nothing.
const LEAST: f32 = 1e-3;

impl Cells {
    pub(super) fn uniform(&self) -> CellsUniform {
        let colors = match &self.fill {
            CellFill::Palette(colors) => &colors[..colors.len().min(MAX_PALETTE)],
            CellFill::Base | CellFill::Values => &[],
        };
        let mut palette = [Vec4::ZERO; MAX_PALETTE];
        for (slot, color) in palette.iter_mut().zip(colors) {
            *slot = color.to_vec4();
        }
        let ellipse = match self.shape {
            CellShape::Voronoi => None,
            CellShape::Ellipse { radius } => Some(radius.max(LEAST)),
        };
        let by_value = self
            .texture
            .as_ref()
            .is_some_and(|texture| texture.choice == TileChoice::Value);
        let texture = self.texture.clone().unwrap_or_default();
        CellsUniform {
            palette,
            mean_color: palette.iter().sum::<Vec4>() / colors.len().max(1) as f32,
            border_color: self.border_color.to_vec4(),
            gap_color: self.gap_color.to_vec4(),
            border_width: self.border_width.value(),
            border_unit: match self.border_width {
                BorderWidth::Pixels(_) => 0,
                BorderWidth::World(_) => 1,
                BorderWidth::Relative(_) => 2,
            },
            fill_kind: match self.fill {
                CellFill::Palette(_) if !colors.is_empty() => 1,
                CellFill::Values => 2,
                CellFill::Base | CellFill::Palette(_) => 0,
            },
            palette_len: colors.len() as u32,
            jitter: self.jitter.clamp(0.0, 1.0),
            rounding: self.rounding.clamp(0.0, 1.0),
            noise: self.noise,
            noise_scale: self.noise_scale,
            bump: self.bump,
            bump_width: self.bump_width.max(LEAST),
            ellipse_radius: ellipse.unwrap_or(1.0),
            texture_radius: texture.radius.max(LEAST),
            tiles: UVec2::new(texture.columns, texture.rows).max(UVec2::ONE),
            flags: u32::from(ellipse.is_some()) | u32::from(by_value) << 1,
            debug: self.debug as u32,
        }
    }

    pub(super) fn image(&self) -> Option<Handle<Image>> {
        self.texture.as_ref().map(|texture| texture.image.clone())
    }

    pub(super) fn key(&self) -> CellsKey {
        CellsKey {
            texture: self.texture.is_some(),
            cutout: self.cutout,
            bump: self.bump != 0.0,
            debug: self.debug != CellDebug::None,
        }
    }
}

/// Settings that select a variant of the shaders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CellsKey {
    texture: bool,
    cutout: bool,
    bump: bool,
    debug: bool,
}

impl CellsKey {
    pub(super) fn shader_defs(self) -> impl Iterator<Item = ShaderDefVal> {
        let variants = [
            (self.texture, "CELLS_TEXTURE"),
            (self.cutout, "CELLS_CUTOUT"),
            (self.bump, "CELLS_BUMP"),
            (self.cutout || self.bump, "CELLS_SHAPE"),
            (self.debug, "CELLS_DEBUG"),
        ];
        variants
            .into_iter()
            .filter(|variant| variant.0)
            .map(|variant| variant.1.into())
    }
}

/// What the shaders bind. Apart from [`Cells`], so that the shared buffers are no fields a user has to carry along.
#[derive(AsBindGroup, Clone)]
struct CellsBinding {
    #[storage(100, read_only, visibility(fragment))]
    cells: Handle<ShaderBuffer>,
    #[storage(101, read_only, visibility(fragment))]
    sites: Handle<ShaderBuffer>,
    #[uniform(102, visibility(fragment))]
    style: CellsUniform,
    #[texture(103, visibility(fragment))]
    #[sampler(104, visibility(fragment))]
    image: Option<Handle<Image>>,
}

impl Cells {
    fn binding(&self) -> CellsBinding {
        CellsBinding {
            cells: CELL_BUFFER,
            sites: SITE_BUFFER,
            style: self.uniform(),
            image: self.image(),
        }
    }
}

bind_as!(Cells => CellsBinding, CellsKey, "cells");

impl MaterialExtension for Cells {
    pattern_shaders!(
        super::embedded("cells_material.wgsl"),
        super::embedded("cells_prepass.wgsl")
    );

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        need_positions(layout)?;
        let key = key.bind_group_data;
        if let Some(fragment) = &mut descriptor.fragment {
            fragment.shader_defs.extend(key.shader_defs());
        }
        Ok(())
    }
}

/// A cut-out needs a base that may discard, or Bevy draws shadows and prepasses without looking at the material.
pub(super) fn mask_cell_cutouts(
    mut changes: MessageReader<AssetEvent<CellMaterial>>,
    mut materials: ResMut<Assets<CellMaterial>>,
) {
    for change in changes.read() {
        let (AssetEvent::Added { id } | AssetEvent::Modified { id }) = *change else {
            continue;
        };
        let needs_mask = |m: &CellMaterial| m.extension.cutout && m.base.alpha_mode == AlphaMode::Opaque;
        if materials.get(id).is_some_and(needs_mask)
            && let Some(mut material) = materials.get_mut(id)
        {
            material.base.alpha_mode = AlphaMode::Mask(0.5);
        }
    }
}
