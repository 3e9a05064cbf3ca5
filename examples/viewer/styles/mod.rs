//! What the user can set of each style, the look that follows from it, and its part of the panel.

mod hatch;
mod stripes;
mod tensor;
mod texture;

pub use hatch::HatchSettings;
pub use stripes::StripeSettings;
pub use tensor::{TensorSettings, add_stress};
pub use texture::TextureSettings;

use bevy::prelude::*;
use bevy_egui::egui::{Response, Slider, Ui};
use bevy_field_patterns::prelude::*;

/// What looks have to know of the pattern that they are drawn on.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    /// Whether the field's direction and its opposite differ.
    pub is_vector: bool,
    /// How many waves there are.
    pub waves: Waves,
    /// Width of one period in world units.
    pub period: f32,
    /// Where the style applies.
    pub focus: Focus,
}

impl Ground {
    /// The stripes to draw: all that there are.
    pub fn stripe_waves(&self) -> StripeWaves {
        if self.waves == Waves::Single {
            StripeWaves::First
        } else {
            StripeWaves::Both
        }
    }
}

/// A colour from the panel.
pub fn srgb([red, green, blue]: [u8; 3]) -> Color {
    Color::srgb_u8(red, green, blue)
}

/// How fast a pattern travels, in periods per second.
fn travel_slider(ui: &mut Ui, speed: &mut f32, can_travel: bool) -> Response {
    ui.add_enabled(can_travel, Slider::new(speed, -2.0..=2.0).text("Travel"))
        .on_disabled_hover_text("Only along vectors")
}
