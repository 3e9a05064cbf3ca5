//! Textures in the viewer: an image that fits the field, its travel, colours and patches by the model's scalar.

use bevy::prelude::*;
use bevy_egui::egui::Ui;
use bevy_field_patterns::prelude::*;
use clap::ValueEnum;

use super::{Ground, srgb, travel_slider};
use crate::panel::{choice, color, range_sliders};

/// The settings of textures.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSettings {
    /// Colour of an image that is white, sRGB.
    tint: [u8; 3],
    /// How fast the image travels, in periods per second; only along vectors. Default 0.
    speed: f32,
    /// Colours that stand for the scalar.
    map: Map,
    /// One of a minus, a dot and a plus in each period, by the scalar. Default `false`.
    patches: bool,
    /// The scalars of the first and the last colour, and of the first and the last patch. Default 0 and 1.
    range: [f32; 2],
    /// Whether the image fades to the base from the low end of the range to the high one. Default `false`.
    fade: bool,
}

impl Default for TextureSettings {
    fn default() -> Self {
        Self {
            tint: [16, 38, 92],
            speed: 0.0,
            map: Map::default(),
            patches: false,
            range: [0.0, 1.0],
            fade: false,
        }
    }
}

/// Colours for a scalar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Map {
    /// The image's own colours
    #[default]
    None,
    /// Dark violet over green to yellow
    Viridis,
    /// A rainbow
    Turbo,
    /// Blue over light grey to red
    CoolWarm,
}

impl TextureSettings {
    /// The look.
    pub fn look(&self, ground: &Ground, assets: &AssetServer) -> PatternTexture {
        let can_travel = ground.is_vector && ground.waves != Waves::Cross;
        let [low, high] = self.range;
        let map = match self.map {
            Map::None => None,
            Map::Viridis => Some(ColorMap::Viridis),
            Map::Turbo => Some(ColorMap::Turbo),
            Map::CoolWarm => Some(ColorMap::CoolWarm),
        };
        // The arrow is white.
        let is_white = can_travel && !self.patches;
        let tint = if is_white && map.is_none() {
            srgb(self.tint)
        } else {
            Color::WHITE
        };
        PatternTexture {
            image: assets.load(self.image(ground)),
            tint: tint.into(),
            travel: Travel::Periods(if can_travel { self.speed } else { 0.0 }),
            color: map.map(|map| ScalarColor {
                map,
                low,
                high,
                ..default()
            }),
            patches: self.patches.then(|| Patches {
                columns: 3,
                low,
                high,
                ..default()
            }),
            fade: self.fade.then(|| TextureFade {
                begin: low,
                end: high,
                ..default()
            }),
            focus: ground.focus,
            ..default()
        }
    }

    /// The file of an image that the field allows.
    fn image(&self, ground: &Ground) -> &'static str {
        match (self.patches, ground.waves, ground.is_vector) {
            (true, ..) => "textures/patches.png",
            (_, Waves::Cross, _) => "textures/tiles.png",
            (.., false) => "textures/weave.png",
            (.., true) => "textures/arrow.png",
        }
    }

    /// Its part of the panel.
    pub fn panel(&mut self, ui: &mut Ui, is_vector: bool) {
        travel_slider(ui, &mut self.speed, is_vector);
        color(ui, "Arrows", &mut self.tint);
        ui.label("By the scalar");
        choice(ui, "colour map", &mut self.map);
        ui.checkbox(&mut self.patches, "Patches");
        ui.checkbox(&mut self.fade, "Fade");
        range_sliders(ui, &mut self.range);
    }
}
