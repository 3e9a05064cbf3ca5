//! Turns the [`ViewerSettings`] into what is drawn on each mesh of the model.

use bevy::prelude::*;

use crate::{model::Model, settings::ViewerSettings};

/// Keeps the look of the model as the settings say.
pub struct LookPlugin;

impl Plugin for LookPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Update, apply_settings);
    }
}

/// Gives the settings' colours to the model's own material.
fn apply_settings(
    settings: Res<ViewerSettings>,
    model: Query<Ref<MeshMaterial3d<StandardMaterial>>, With<Model>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for handle in &model {
        if !settings.is_changed() && !handle.is_added() {
            continue;
        }
        if let Some(mut material) = materials.get_mut(&handle.0) {
            material.base_color = srgb(settings.gap_color);
        }
    }
}

/// A colour from the panel.
fn srgb([red, green, blue]: [u8; 3]) -> Color {
    Color::srgb_u8(red, green, blue)
}
