//! What styles implement in the same way: that they are bound, and which shaders draw them.
//!
//! A style is what a user sets; what the shaders bind is another struct, made by `binding()`, so that the shared buffers
//! are no fields that a user has to carry along.

use bevy::{mesh::MeshVertexBufferLayoutRef, prelude::*, render::render_resource::SpecializedMeshPipelineError};

/// Refuses a mesh without positions, which is then not drawn: prepasses and shadows ask for positions without looking, and
/// the pipeline that lacks them would stop the renderer.
pub(super) fn need_positions(layout: &MeshVertexBufferLayoutRef) -> Result<(), SpecializedMeshPipelineError> {
    layout.0.get_layout(&[Mesh::ATTRIBUTE_POSITION.at_shader_location(0)])?;
    Ok(())
}

/// Implements `AsBindGroup` by that of what the style binds. The style has `key()` and `binding()`.
macro_rules! bind_as {
    ($style:ty => $binding:ty, $key:ty, $label:literal) => {
        const _: () = {
            use bevy::{
                ecs::system::{SystemParamItem, lifetimeless::SRes},
                render::{
                    render_asset::RenderAssets,
                    render_resource::{AsBindGroupError, BindGroupLayout, BindGroupLayoutEntry, UnpreparedBindGroup},
                    renderer::RenderDevice,
                    storage::GpuShaderBuffer,
                    texture::{FallbackImage, GpuImage},
                },
            };

            impl AsBindGroup for $style {
                type Data = $key;
                type Param = (
                    SRes<RenderAssets<GpuImage>>,
                    SRes<FallbackImage>,
                    SRes<RenderAssets<GpuShaderBuffer>>,
                );

                fn label() -> &'static str {
                    $label
                }

                fn bind_group_data(&self) -> $key {
                    self.key()
                }

                fn unprepared_bind_group(
                    &self,
                    layout: &BindGroupLayout,
                    render_device: &RenderDevice,
                    param: &mut SystemParamItem<'_, '_, Self::Param>,
                    force_no_bindless: bool,
                ) -> Result<UnpreparedBindGroup, AsBindGroupError> {
                    self.binding()
                        .unprepared_bind_group(layout, render_device, param, force_no_bindless)
                }

                fn bind_group_layout_entries(
                    render_device: &RenderDevice,
                    force_no_bindless: bool,
                ) -> Vec<BindGroupLayoutEntry> {
                    <$binding>::bind_group_layout_entries(render_device, force_no_bindless)
                }
            }
        };
    };
}

/// The shaders of a `MaterialExtension` over a mesh with a pattern, forward and deferred; given are the fragment shaders of
/// pictures and of prepasses.
macro_rules! pattern_shaders {
    ($fragment:expr, $prepass:expr) => {
        fn vertex_shader() -> bevy::shader::ShaderRef {
            $crate::material::pattern_vertex_shader()
        }

        fn fragment_shader() -> bevy::shader::ShaderRef {
            $fragment
        }

        fn prepass_vertex_shader() -> bevy::shader::ShaderRef {
            $crate::material::pattern_prepass_vertex_shader()
        }

        fn prepass_fragment_shader() -> bevy::shader::ShaderRef {
            $prepass
        }

        fn deferred_vertex_shader() -> bevy::shader::ShaderRef {
            $crate::material::pattern_prepass_vertex_shader()
        }

        fn deferred_fragment_shader() -> bevy::shader::ShaderRef {
            $fragment
        }
    };
}

pub(super) use {bind_as, pattern_shaders};
