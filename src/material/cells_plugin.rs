//! Registers the materials of cells and their shaders.

use super::{
    CellMaterial, CellMaterial2d, CellTexture, Cells, PatternMaterialPlugin, PatternShaderPlugin,
    cells::mask_cell_cutouts, numbers::put_right, touch_materials,
};
use crate::cells::{DrawCells, load_layout};
use bevy::{
    asset::{AssetEventSystems, embedded_asset},
    pbr::MaterialPlugin,
    prelude::*,
    shader::load_shader_library,
    sprite_render::Material2dPlugin,
};

/// Draws [`CellMaterial`] and [`CellMaterial2d`] and offers the shader library `bevy_field_patterns::cells`.
#[derive(Debug, Clone, Copy, Default)]
pub struct CellMaterialPlugin;

impl Plugin for CellMaterialPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<PatternShaderPlugin>() {
            app.add_plugins(PatternShaderPlugin);
        }
        load_layout(app);
        load_shader_library!(app, "cells.wgsl");
        load_shader_library!(app, "cell_debug.wgsl");
        load_shader_library!(app, "cell_style.wgsl");
        load_shader_library!(app, "cell_paint.wgsl");
        embedded_asset!(app, "cells_material.wgsl");
        embedded_asset!(app, "cells_prepass.wgsl");
        embedded_asset!(app, "cells_2d.wgsl");
        app.add_plugins((
            MaterialPlugin::<CellMaterial>::default(),
            PatternMaterialPlugin::<CellMaterial>::default(),
            Material2dPlugin::<CellMaterial2d>::default(),
        ))
        .register_type::<Cells>()
        .register_type::<CellTexture>()
        .register_asset_reflect::<CellMaterial>()
        .register_asset_reflect::<CellMaterial2d>()
        .register_required_components::<MeshMaterial3d<CellMaterial>, DrawCells>()
        .register_required_components::<MeshMaterial2d<CellMaterial2d>, DrawCells>()
        // The plugin's own, of the set's triangles.
        .register_required_components::<MeshMaterial2d<CellMaterial2d>, Mesh2d>()
        .add_observer(stop_drawing::<MeshMaterial3d<CellMaterial>>)
        .add_observer(stop_drawing::<MeshMaterial2d<CellMaterial2d>>)
        .add_systems(
            PostUpdate,
            (
                (
                    mask_cell_cutouts,
                    put_right(|m: &CellMaterial| &m.extension, |m| &mut m.extension),
                    put_right(|m: &CellMaterial2d| &m.cells, |m| &mut m.cells),
                )
                    .after(AssetEventSystems),
                touch_materials::<CellMaterial2d>.before(AssetEventSystems),
            ),
        );
    }
}

fn stop_drawing<M: Component>(event: On<Remove, M>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(event.entity) {
        entity.try_remove::<DrawCells>();
    }
}
