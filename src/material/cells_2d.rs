//! `CellMaterial2d`: the cells of a planar sample set, as a 2D material.
//!
//! In: [`Cells`] and a base colour or image. Out: uniforms, images and the two shared buffers for `cells_2d.wgsl`.

use super::{Cells, CellsKey, binding::bind_as, cells::CellsUniform};
use crate::cells::{
    ATTRIBUTE_TRIANGLE,
    layout::{CELL_BUFFER, SITE_BUFFER},
};
use bevy::{
    mesh::MeshVertexBufferLayoutRef,
    prelude::*,
    render::{
        render_resource::{AsBindGroup, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError},
        storage::ShaderBuffer,
    },
    shader::ShaderRef,
    sprite_render::{AlphaMode2d, Material2d, Material2dKey},
};

/// A 2D material with the cells of the entity's planar [`SampleSet`](crate::sampling::SampleSet).
///
/// The plugin makes the entity's `Mesh2d` of the set's own triangles ([`planar_mesh`](crate::cells::planar_mesh)); its UV
/// covers the set's bounds.
#[derive(Asset, Reflect, Debug, Clone, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct CellMaterial2d {
    /// Colour of the base, times the texture. Default: white.
    pub color: Color,
    /// Image of the base, over the set's bounds. Default: none.
    pub texture: Option<Handle<Image>>,
    /// What the base's alpha means. Default: nothing, all is opaque.
    pub alpha_mode: AlphaMode2d,
    /// The style of the cells.
    pub cells: Cells,
}

impl Default for CellMaterial2d {
    fn default() -> Self {
        Self {
            color: Color::WHITE,
            texture: None,
            alpha_mode: AlphaMode2d::Opaque,
            cells: Cells::default(),
        }
    }
}

impl CellMaterial2d {
    fn cutoff(&self) -> f32 {
        match self.alpha_mode() {
            AlphaMode2d::Mask(cutoff) => cutoff,
            AlphaMode2d::Opaque | AlphaMode2d::Blend => 0.0,
        }
    }
}

/// `struct Base` of `cells_2d.wgsl`.
#[derive(ShaderType, Debug, Clone, Default)]
struct BaseUniform {
    color: Vec4,
    alpha_cutoff: f32,
    opaque: u32,
}

/// What the shaders bind: as [`Cells`], and the base.
#[derive(AsBindGroup, Clone)]
struct Binding {
    #[storage(100, read_only, visibility(fragment))]
    cells: Handle<ShaderBuffer>,
    #[storage(101, read_only, visibility(fragment))]
    sites: Handle<ShaderBuffer>,
    #[uniform(102, visibility(fragment))]
    style: CellsUniform,
    #[texture(103, visibility(fragment))]
    #[sampler(104, visibility(fragment))]
    image: Option<Handle<Image>>,
    #[uniform(105, visibility(fragment))]
    base: BaseUniform,
    #[texture(106, visibility(fragment))]
    #[sampler(107, visibility(fragment))]
    texture: Option<Handle<Image>>,
}

impl CellMaterial2d {
    fn key(&self) -> CellsKey {
        self.cells.key()
    }

    fn binding(&self) -> Binding {
        Binding {
            cells: CELL_BUFFER,
            sites: SITE_BUFFER,
            style: self.cells.uniform(),
            image: self.cells.image(),
            base: BaseUniform {
                color: self.color.to_linear().to_vec4(),
                alpha_cutoff: self.cutoff(),
                opaque: u32::from(self.alpha_mode() != AlphaMode2d::Blend),
            },
            texture: self.texture.clone(),
        }
    }
}

bind_as!(CellMaterial2d => Binding, CellsKey, "cells_2d");

impl Material2d for CellMaterial2d {
    fn vertex_shader() -> ShaderRef {
        super::embedded("cells_2d.wgsl")
    }

    fn fragment_shader() -> ShaderRef {
        super::embedded("cells_2d.wgsl")
    }

    fn alpha_mode(&self) -> AlphaMode2d {
        match self.alpha_mode {
            AlphaMode2d::Opaque if self.cells.cutout => AlphaMode2d::Mask(0.5),
            mode => mode,
        }
    }

    fn specialize(
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: Material2dKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        // Any other mesh shows the base.
        if layout.0.contains(ATTRIBUTE_TRIANGLE.id) {
            let triangles = layout.0.get_layout(&[ATTRIBUTE_TRIANGLE.at_shader_location(10)])?;
            if let Some(buffer) = descriptor.vertex.buffers.first_mut() {
                buffer.attributes.extend(triangles.attributes);
            }
            descriptor.vertex.shader_defs.push("CELLS_TRIANGLES".into());
        }
        if let Some(fragment) = &mut descriptor.fragment {
            fragment.shader_defs.extend(key.bind_group_data.shader_defs());
        }
        Ok(())
    }
}
