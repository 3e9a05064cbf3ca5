//! Registers the shader libraries that the solver and the materials share: `kite.wgsl` and `layout.wgsl`.

use bevy::{
    prelude::*,
    shader::{ShaderLoader, load_shader_library},
};

/// Adds the import paths `bevy_field_patterns::kite` and `bevy_field_patterns::layout`; added once, by whoever comes first.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct WaveShaderPlugin;

impl Plugin for WaveShaderPlugin {
    fn build(&self, app: &mut App) {
        // An app that renders nothing has no shaders, but libraries of them are named all the same.
        if !app.world().contains_resource::<Assets<Shader>>() {
            app.init_asset::<Shader>().init_asset_loader::<ShaderLoader>();
        }
        load_shader_library!(app, "kite.wgsl");
        load_shader_library!(app, "layout.wgsl");
    }
}
