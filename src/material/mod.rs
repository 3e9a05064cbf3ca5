//! What the fragment shader draws.
//!
//! In: the shared buffers of waves ([`layout`](crate::wave::layout)) or cells ([`layout`](crate::cells::layout)), found
//! through an entity's `MeshTag`, and a style. Out: pixels.
//! `cells.wgsl` finds the cell under a fragment, `cell_style.wgsl` and `cell_paint.wgsl` make a colour of it.
//! `wave.wgsl` evaluates the waves under a fragment (Eq. 13 and 14 of Lichtenberg et al. 2018). A style makes a `Paint` of
//! them (`paint.wgsl`): `stripe_style.wgsl` by a periodic profile filtered over the pixel (`coverage.wgsl`),
//! `texture_style.wgsl` by an image on two waves, `tensor_style.wgsl` by two eigenvalues, `hatch_style.wgsl` by strokes.
//! `pattern_material.wgsl` and `pattern_prepass.wgsl` put the paint of any style on a [`StandardMaterial`]. The vertex
//! shaders derive the triangle and the corner from the vertex index, so the mesh drawn must have no indices.

mod binding;
mod cell_options;
mod cells;
mod cells_2d;
mod cells_plugin;
mod color_map;
pub mod coverage;
mod focus;
mod focus_source;
mod hatch;
mod hatch_options;
pub mod hatch_strokes;
mod mipmaps;
mod numbers;
mod stripes;
mod style;
mod tensor;
mod texture;
mod texture_options;

pub use cell_options::*;
pub use cells::{CellMaterial, Cells, CellsKey};
pub use cells_2d::CellMaterial2d;
pub use cells_plugin::CellMaterialPlugin;
pub use color_map::*;
pub use focus::*;
pub use focus_source::FocusSource;
pub use hatch::{HatchKey, HatchMaterial, HatchMaterialPlugin};
pub use hatch_options::*;
pub use mipmaps::with_mipmaps;
pub use stripes::*;
pub use style::{SceneStyle, Styled};
pub use tensor::{Eigenvalue, Tensor, TensorKey, TensorMaterial, TensorMaterialPlugin};
pub use texture::{PatternTexture, PatternTextureKey, PatternTextureMaterial};
pub use texture_options::*;

use crate::wave::WaveShaderPlugin;
use bevy::{
    asset::{AssetEventSystems, AssetPath, embedded_asset},
    pbr::MaterialPlugin,
    prelude::*,
    shader::{ShaderRef, load_shader_library},
};
use std::marker::PhantomData;
use style::WaveStylePlugin;

/// How often the shared buffers have been made anew, which they are when they grow.
#[derive(Resource, Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BufferGeneration(pub u32);

/// Draws [`StripeMaterial`] and offers the shader library `bevy_field_patterns::wave`.
#[derive(Debug, Clone, Copy, Default)]
pub struct StripeMaterialPlugin;

impl Plugin for StripeMaterialPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            MaterialPlugin::<StripeMaterial>::default(),
            WaveStylePlugin::<Stripes>::default(),
        ))
        .register_type::<Stripes>()
        .register_asset_reflect::<StripeMaterial>();
    }
}

/// Draws [`PatternTextureMaterial`] and gives mip levels to its images.
#[derive(Debug, Clone, Copy, Default)]
pub struct PatternTexturePlugin;

impl Plugin for PatternTexturePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            MaterialPlugin::<PatternTextureMaterial>::default(),
            WaveStylePlugin::<PatternTexture>::default(),
        ))
        .register_type::<PatternTexture>()
        .register_asset_reflect::<PatternTextureMaterial>()
        .add_systems(PostUpdate, mipmaps::add_mipmaps.before(AssetEventSystems));
    }
}

/// For a material of your own that samples the wave: add it next to `MaterialPlugin::<M>`.
///
/// The material binds the three buffers of [`layout`](crate::wave::layout) at 100, 101 and 102 (a default of their constant
/// handles will do), uses [`pattern_vertex_shader`], and its fragment shader calls `bevy_field_patterns::wave`.
///
/// Bevy does not make a material's bind group anew when a buffer it binds is replaced. This plugin does, by touching the
/// materials in the two frames after [`BufferGeneration`] has changed: a material and a buffer of one frame are prepared in
/// no fixed order.
#[derive(Debug, Clone, Copy)]
pub struct PatternMaterialPlugin<M: Material>(PhantomData<M>);

impl<M: Material> Default for PatternMaterialPlugin<M> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<M: Material> Plugin for PatternMaterialPlugin<M> {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<PatternShaderPlugin>() {
            app.add_plugins(PatternShaderPlugin);
        }
        app.init_resource::<BufferGeneration>()
            .add_systems(PostUpdate, touch_materials::<M>.before(AssetEventSystems));
    }
}

/// The shaders that every pattern material shares.
struct PatternShaderPlugin;

impl Plugin for PatternShaderPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<WaveShaderPlugin>() {
            app.add_plugins(WaveShaderPlugin);
        }
        load_shader_library!(app, "triangle_wave.wgsl");
        load_shader_library!(app, "triangle_pair.wgsl");
        load_shader_library!(app, "wave.wgsl");
        load_shader_library!(app, "coverage.wgsl");
        load_shader_library!(app, "pattern_corner.wgsl");
        load_shader_library!(app, "bump.wgsl");
        load_shader_library!(app, "families.wgsl");
        load_shader_library!(app, "focus.wgsl");
        load_shader_library!(app, "noise.wgsl");
        load_shader_library!(app, "paint.wgsl");
        load_shader_library!(app, "quad.wgsl");
        load_shader_library!(app, "pattern_output.wgsl");
        // All styles: the material's shader names each of them, and waits for all that it names.
        load_shader_library!(app, "stripe_style.wgsl");
        load_shader_library!(app, "stripe_debug.wgsl");
        load_shader_library!(app, "texture_style.wgsl");
        load_shader_library!(app, "texture_patch.wgsl");
        load_shader_library!(app, "tensor_style.wgsl");
        load_shader_library!(app, "hatch_strokes.wgsl");
        load_shader_library!(app, "hatch_style.wgsl");
        load_shader_library!(app, "hatch_outline.wgsl");
        embedded_asset!(app, "pattern_vertex.wgsl");
        embedded_asset!(app, "pattern_prepass_vertex.wgsl");
        embedded_asset!(app, "pattern_material.wgsl");
        embedded_asset!(app, "pattern_prepass.wgsl");
    }
}

/// The vertex shader of pattern materials, for `vertex_shader()`: Bevy's own, plus (tag, triangle) at location 10, two
/// barycentrics at location 11, and the position before skin and morph targets at location 12.
pub fn pattern_vertex_shader() -> ShaderRef {
    embedded("pattern_vertex.wgsl")
}

/// The same for `prepass_vertex_shader()` and `deferred_vertex_shader()`.
pub fn pattern_prepass_vertex_shader() -> ShaderRef {
    embedded("pattern_prepass_vertex.wgsl")
}

/// Puts the paint of a style on a base, forward or deferred.
fn pattern_fragment_shader() -> ShaderRef {
    embedded("pattern_material.wgsl")
}

/// The same for prepasses and shadows.
fn pattern_prepass_fragment_shader() -> ShaderRef {
    embedded("pattern_prepass.wgsl")
}

fn embedded(file: &str) -> ShaderRef {
    AssetPath::from(format!("embedded://bevy_field_patterns/material/{file}")).into()
}

/// Marks all materials as modified in the two frames after a buffer was replaced.
fn touch_materials<M: Asset>(
    generation: Res<BufferGeneration>,
    mut seen: Local<u32>,
    mut frames: Local<u32>,
    mut materials: ResMut<Assets<M>>,
) {
    if *frames > 0 {
        *frames -= 1;
        // The iterator itself marks what it passes.
        materials.iter_mut().for_each(drop);
    }
    if *seen != generation.0 {
        *seen = generation.0;
        *frames = 2;
    }
}
