//! Sliders beside the mosaic.

use bevy::prelude::*;
use bevy_egui::{
    EguiContexts, EguiPlugin, EguiPrimaryContextPass,
    egui::{Slider, Window},
};
use bevy_field_patterns::prelude::*;

use super::Wishes;

/// Adds them.
pub struct PanelPlugin;

impl Plugin for PanelPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(EguiPlugin::default())
            .add_systems(EguiPrimaryContextPass, draw);
    }
}

fn draw(mut contexts: EguiContexts, mut wishes: ResMut<Wishes>, states: Query<&SamplingState>) -> Result {
    let mut wished = *wishes;
    Window::new("Mosaic").resizable(false).show(contexts.ctx_mut()?, |ui| {
        ui.add(
            Slider::new(&mut wished.count, 100..=50_000)
                .logarithmic(true)
                .text("stones"),
        );
        ui.add(
            Slider::new(&mut wished.ratio, 1.0..=20.0)
                .logarithmic(true)
                .text("longest ratio"),
        );
        ui.add(Slider::new(&mut wished.detail, 0.0..=5.0).text("smaller at edges"));
        ui.add(Slider::new(&mut wished.importance, 0.0..=1.0).text("more where bright"));
        ui.add(Slider::new(&mut wished.joint, 0.0..=0.6).text("joints"));
        for state in &states {
            ui.label(match state {
                SamplingState::Preparing => "preparing".to_owned(),
                SamplingState::Sampling(done) => format!("laying stones: {:.0} %", 100.0 * done),
                SamplingState::Ready => "laid".to_owned(),
                SamplingState::Failed(error) => error.to_string(),
            });
        }
    });
    wishes.set_if_neq(wished);
    Ok(())
}
