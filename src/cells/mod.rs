//! Cells: the anisotropic Voronoi regions of a sample set, on the GPU.
//!
//! In: an entity with a [`SampleSet`] and a material that draws cells. Out: the set in the shared buffers of [`layout`],
//! found through the entity's `MeshTag`, and the un-indexed mesh that fragment shaders need. Kratz et al. 2013, section 6:
//! a point belongs to the sample that is nearest in the sample's own metric.
//!
//! [`CellPlugin`] does, every frame, in `PostUpdate`: checks sets that are new or changed, writes them in place where they
//! fit, gives planar sets a mesh of their own, and says in [`CellState`] what became of it. Nothing that stays the same is
//! looked at. [`label`] and [`border`] are the CPU's twins of the shader.

pub mod layout;
mod memory;
mod mosaic;
mod planar;
mod state;
mod twin;
mod update;
mod upload;

pub use layout::CellArena;
pub use memory::CellMemory;
pub use mosaic::mesh_uvs;
pub use planar::{ATTRIBUTE_TRIANGLE, planar_mesh, planar_uvs};
pub use state::{CellState, DrawCells, SampleValues, check_samples};
pub use twin::{MAX_ROUNDS, border, label};

use crate::{
    arena::{create_buffers, grow_buffers},
    sampling::{SampleSet, SamplingSystems},
    surface::{SurfacePlugin, SurfaceSystems},
};
use bevy::{prelude::*, render::storage::ShaderBuffer, shader::load_shader_library};
use layout::Pool;

/// Adds the import path `bevy_field_patterns::cell_layout`.
pub(crate) fn load_layout(app: &mut App) {
    load_shader_library!(app, "layout.wgsl");
}

/// Keeps the samples of all entities with a [`SampleSet`] and [`DrawCells`] on the GPU.
#[derive(Debug, Default, Clone, Copy)]
pub struct CellPlugin;

impl Plugin for CellPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<SurfacePlugin>() {
            app.add_plugins(SurfacePlugin);
        }
        upload::build(app);
        app.init_resource::<CellArena>()
            .init_resource::<crate::material::BufferGeneration>()
            .register_type::<CellState>()
            .register_type::<SampleValues>()
            .register_type::<DrawCells>()
            .add_observer(update::remove_cells::<SampleSet>)
            .add_observer(update::remove_cells::<DrawCells>)
            .add_systems(
                PostUpdate,
                (
                    update::request_surfaces.in_set(SurfaceSystems::Request),
                    (update::give_state, update::update_cells, grow_buffers::<Pool>)
                        .chain()
                        .in_set(SurfaceSystems::Use)
                        .after(SamplingSystems)
                        .run_if(resource_exists::<upload::UploadStatus>),
                ),
            );
    }

    fn finish(&self, app: &mut App) {
        if app.world().contains_resource::<Assets<ShaderBuffer>>() {
            create_buffers::<Pool>(app.world_mut());
        }
    }
}
