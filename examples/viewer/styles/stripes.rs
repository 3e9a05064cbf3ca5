//! Stripes in the viewer.

use bevy::prelude::*;
use bevy_egui::egui::{Slider, Ui};
use bevy_field_patterns::prelude::*;
use clap::ValueEnum;

use super::{Ground, srgb, travel_slider};
use crate::{
    panel::{choice, color},
    settings::Style,
};

/// The settings of stripes.
#[derive(Clone, Debug, PartialEq)]
pub struct StripeSettings {
    /// Share of a period that is stripe, 0 to 1. Default 0.5.
    duty: f32,
    /// Softness of a stripe's edges: 0 (sharp as a pixel) to 1 (a sine). Default 0.
    softness: f32,
    /// Shape of a stripe across its period.
    shape: Shape,
    /// Colour of the stripes, sRGB.
    color: [u8; 3],
    /// Height of a stripe above the gap, in periods; negative engraves. Default 0.
    bump: f32,
    /// How fast the pattern travels, in periods per second; only along vectors. Default 0.
    speed: f32,
}

impl Default for StripeSettings {
    fn default() -> Self {
        Self {
            duty: 0.5,
            softness: 0.0,
            shape: Shape::default(),
            color: [16, 38, 92],
            bump: 0.0,
            speed: 0.0,
        }
    }
}

/// Shape of a stripe across its period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Shape {
    /// One colour between two edges
    #[default]
    Square,
    /// A sine
    Sine,
    /// A ramp with one edge; only along vectors
    Sawtooth,
}

impl StripeSettings {
    /// The look; what needs the phase itself is left out where a field of lines does not have one.
    pub fn look(&self, ground: &Ground, style: Style) -> Stripes {
        Stripes {
            waves: ground.stripe_waves(),
            color: srgb(self.color).into(),
            duty: self.duty,
            softness: self.softness,
            profile: match self.shape {
                Shape::Sine => Profile::Sine,
                Shape::Sawtooth if ground.is_vector => Profile::Sawtooth,
                Shape::Sawtooth | Shape::Square => Profile::Square,
            },
            phase_speed: if ground.is_vector { self.speed } else { 0.0 },
            drive: PatternDrive {
                bump: self.bump * ground.period,
                ..default()
            },
            cutout: style == Style::Cutout,
            debug: style.debug(),
            focus: ground.focus,
            ..default()
        }
    }

    /// Its part of the panel.
    pub fn panel(&mut self, ui: &mut Ui, is_vector: bool) {
        choice(ui, "shape", &mut self.shape);
        if self.shape == Shape::Sawtooth && !is_vector {
            ui.weak("A sawtooth needs vectors");
        }
        let is_square = self.shape == Shape::Square;
        ui.add_enabled(is_square, Slider::new(&mut self.duty, 0.0..=1.0).text("Duty"));
        ui.add_enabled(is_square, Slider::new(&mut self.softness, 0.0..=1.0).text("Softness"));
        ui.add(Slider::new(&mut self.bump, -0.5..=0.5).text("Bump"));
        travel_slider(ui, &mut self.speed, is_vector);
        color(ui, "Stripes", &mut self.color);
    }
}
