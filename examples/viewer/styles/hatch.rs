//! Hatching in the viewer.

use bevy::prelude::*;
use bevy_egui::egui::{Slider, Ui};
use bevy_field_patterns::prelude::*;
use clap::ValueEnum;

use super::Ground;
use crate::panel::choice;

/// The settings of hatching.
#[derive(Clone, Debug, PartialEq)]
pub struct HatchSettings {
    /// What makes the tone.
    tone: Tone,
    /// Share of ink of the darkest tone, 0 to 1. Default 0.85.
    darkness: f32,
    /// Width of a stroke as a share of the distance of strokes, 0.01 to 1. Default 0.25.
    stroke: f32,
    /// What a darker tone has more of: 0 wider strokes, 1 more strokes. Default 0.6.
    density: f32,
    /// Distance of strokes in pixels. Default 9.
    spacing: f32,
    /// How unsteady the hand is, as a share of the usual. 0 to 2, default 1.
    hand: f32,
    /// Width of the outline in pixels, 0 for none. Default 2.
    outline: f32,
}

impl Default for HatchSettings {
    fn default() -> Self {
        Self {
            tone: Tone::default(),
            darkness: 0.85,
            stroke: 0.25,
            density: 0.6,
            spacing: 9.0,
            hand: 1.0,
            outline: 2.0,
        }
    }
}

/// What makes a tone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Tone {
    /// The light
    #[default]
    Light,
    /// The model's scalar
    Scalar,
    /// The same everywhere
    Even,
}

impl HatchSettings {
    /// The look.
    pub fn look(&self, ground: &Ground) -> Hatch {
        let usual = HatchHand::default();
        Hatch {
            tone: match self.tone {
                Tone::Light => HatchTone::LIGHT,
                Tone::Scalar => HatchTone::Scalar {
                    scalar: ScalarChannel::First,
                    light: 0.0,
                    dark: 1.0,
                },
                Tone::Even => HatchTone::Constant(self.darkness),
            },
            darkest: self.darkness,
            strokes: HatchStrokes {
                width: self.stroke,
                density: self.density,
                spacing: StrokeSpacing::Pixels(self.spacing),
                ..default()
            },
            hand: HatchHand {
                width: (self.hand * usual.width).min(1.0),
                length: (self.hand * usual.length).min(1.0),
                wobble: self.hand * usual.wobble,
                ink: self.hand * usual.ink,
            },
            outline: HatchOutline::solid(self.outline),
            focus: ground.focus,
            ..default()
        }
    }

    /// Its part of the panel.
    pub fn panel(&mut self, ui: &mut Ui) {
        choice(ui, "tone", &mut self.tone);
        ui.add(Slider::new(&mut self.darkness, 0.0..=1.0).text("Darkest"));
        ui.add(Slider::new(&mut self.stroke, 0.01..=1.0).text("Stroke"));
        ui.add(Slider::new(&mut self.density, 0.0..=1.0).text("Density"));
        ui.add(Slider::new(&mut self.spacing, 2.0..=40.0).text("Spacing"));
        ui.add(Slider::new(&mut self.hand, 0.0..=2.0).text("Hand"));
        ui.add(Slider::new(&mut self.outline, 0.0..=8.0).text("Outline"));
    }
}
