//! The panel beside the model: shows and changes the [`ViewerSettings`], and tells how the solver is doing.
//!
//! The panel has a camera of its own; the studio's camera draws beside it.

mod field;
mod solver;

use bevy::{
    camera::{CameraOutputMode, Viewport, visibility::RenderLayers},
    diagnostic::FrameTimeDiagnosticsPlugin,
    prelude::*,
    render::{diagnostic::RenderDiagnosticsPlugin, render_resource::BlendState},
    window::PrimaryWindow,
};
use bevy_egui::{
    EguiContexts, EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass, PrimaryEguiContext,
    egui::{Color32, ComboBox, LayerId, Panel, ScrollArea, Slider, Ui, UiBuilder},
};
use bevy_field_patterns::prelude::*;
use bevy_panorbit_camera::PanOrbitCamera;
use clap::ValueEnum;
use field::field_section;
use solver::{Statistics, solver_section, statistics_section};

use crate::{
    common::scene::StudioCamera,
    model::{Model, Notice, Open},
    settings::{FocusSettings, Style, ViewerSettings},
};

/// Width of the panel at first, in logical pixels.
const WIDTH: f32 = 240.0;

/// Adds the panel.
pub struct PanelPlugin;

impl Plugin for PanelPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            EguiPlugin::default(),
            FrameTimeDiagnosticsPlugin::default(),
            RenderDiagnosticsPlugin,
        ))
        .add_systems(Startup, add_camera)
        .add_systems(EguiPrimaryContextPass, draw);
    }
}

fn add_camera(mut commands: Commands, mut egui: ResMut<EguiGlobalSettings>) {
    egui.auto_create_primary_context = false;
    commands.spawn((
        PrimaryEguiContext,
        Camera2d,
        // Nothing but the panel.
        RenderLayers::none(),
        Camera {
            order: 1,
            output_mode: CameraOutputMode::Write {
                blend_state: Some(BlendState::ALPHA_BLENDING),
                clear_color: ClearColorConfig::None,
            },
            clear_color: ClearColorConfig::Custom(Color::NONE),
            ..default()
        },
    ));
}

fn draw(
    mut contexts: EguiContexts,
    mut settings: ResMut<ViewerSettings>,
    model: Query<&Model>,
    notice: Res<Notice>,
    statistics: Statistics,
    mut open: MessageWriter<Open>,
    window: Single<&Window, With<PrimaryWindow>>,
    camera: Single<(&mut Camera, Option<&mut PanOrbitCamera>), With<StudioCamera>>,
    mut commands: Commands,
) -> Result {
    let context = contexts.ctx_mut()?;
    let whole = UiBuilder::new()
        .layer_id(LayerId::background())
        .max_rect(context.viewport_rect());
    let mut root = Ui::new(context.clone(), "window".into(), whole);
    // Comparing keeps change detection quiet while nothing is changed.
    let mut edited = settings.clone();
    let panel = Panel::left("settings").default_size(WIDTH).show(&mut root, |ui| {
        ScrollArea::vertical().show(ui, |ui| {
            if let Some(request) = model_section(ui, model.iter().next(), notice.0.as_deref()) {
                open.write(request);
            }
            field_section(ui, &mut edited);
            let has_gaps = model.iter().all(|model| model.material.is_some());
            style_section(ui, &mut edited, has_gaps);
            focus_section(ui, &mut edited.focus);
            if solver_section(ui, &mut edited.solver) {
                for (entity, ..) in &statistics.patterns {
                    commands.trigger(RestartPattern { entity });
                }
            }
            statistics_section(ui, &statistics);
        });
    });
    settings.set_if_neq(edited);

    let (mut camera, orbit) = camera.into_inner();
    if let Some(mut orbit) = orbit {
        orbit.enabled = !context.egui_wants_pointer_input();
    }
    let left = (panel.response.rect.width() * window.scale_factor()) as u32;
    let size = window.physical_size();
    // In a window narrower than the panel there is nothing beside it.
    let viewport = (left < size.x && size.y > 0).then(|| Viewport {
        physical_position: UVec2::new(left, 0),
        physical_size: UVec2::new(size.x - left, size.y),
        ..default()
    });
    camera.is_active = viewport.is_some();
    if viewport.is_some() {
        camera.viewport = viewport;
    }
    Ok(())
}

/// Gives the model that is asked for.
fn model_section(ui: &mut Ui, model: Option<&Model>, notice: Option<&str>) -> Option<Open> {
    ui.heading("Model");
    if let Some(model) = model {
        ui.label(&model.name);
        if let Some(vertices) = model.vertices {
            ui.weak(format!("{vertices} vertices"));
        }
    }
    if let Some(notice) = notice {
        ui.colored_label(Color32::LIGHT_RED, notice);
    }
    let asked = ui.horizontal(|ui| {
        let models = [
            ("Knot", Open::Knot),
            ("Artery", Open::Scene("models/aneurysm.glb".into())),
            ("Creature", Open::Scene("models/creature.glb".into())),
        ];
        models
            .into_iter()
            .find_map(|(name, open)| ui.button(name).clicked().then_some(open))
    });
    ui.weak("Drop an OBJ, PLY, STL, glTF or GLB file onto the window; a .txt file is a field.");
    asked.inner
}

fn style_section(ui: &mut Ui, settings: &mut ViewerSettings, has_gaps: bool) {
    ui.separator();
    ui.heading("Style");
    choice(ui, "style", &mut settings.style);
    choice(ui, "waves", &mut settings.waves);
    let is_vector = settings.symmetry == Symmetry::Vector;
    match settings.style {
        Style::Texture => settings.texture.panel(ui, is_vector),
        Style::Hatch => settings.hatch.panel(ui),
        Style::Tensor => settings.tensor.panel(ui),
        _ => settings.stripes.panel(ui, is_vector),
    }
    if has_gaps {
        color(ui, "Surface", &mut settings.gap_color);
    }
}

fn focus_section(ui: &mut Ui, focus: &mut FocusSettings) {
    ui.separator();
    ui.heading("Focus");
    let radius = Slider::new(&mut focus.radius, 0.0..=FocusSettings::EVERYWHERE);
    ui.add(radius.text("Radius")).on_hover_text("All the way: everywhere");
    let is_limited = focus.radius < FocusSettings::EVERYWHERE;
    ui.add_enabled_ui(is_limited, |ui| {
        ui.add(Slider::new(&mut focus.border, 0.0..=0.3).text("Border"));
        ui.checkbox(&mut focus.invert, "Outside");
        ui.checkbox(&mut focus.width, "Thin stripes out of focus");
    });
}

/// A colour to choose.
pub fn color(ui: &mut Ui, name: &str, color: &mut [u8; 3]) {
    ui.horizontal(|ui| {
        ui.color_edit_button_srgb(color);
        ui.label(name);
    });
}

/// The two ends of a range of values.
pub fn range_sliders(ui: &mut Ui, [low, high]: &mut [f32; 2]) {
    ui.add(Slider::new(low, -5.0..=5.0).text("From"));
    ui.add(Slider::new(high, -5.0..=5.0).text("To"));
}

/// A list to choose from.
pub fn choice<T: ValueEnum + PartialEq + Copy>(ui: &mut Ui, id: &str, chosen: &mut T) {
    let name = |value: T| {
        value
            .to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned())
    };
    ComboBox::from_id_salt(id)
        .selected_text(name(*chosen))
        .show_ui(ui, |ui| {
            for &value in T::value_variants() {
                ui.selectable_value(chosen, value, name(value));
            }
        });
}
