//! The panel beside the model: shows and changes the [`ViewerSettings`].
//!
//! The panel has a camera of its own; the studio's camera draws beside it.

use bevy::{
    camera::{CameraOutputMode, Viewport, visibility::RenderLayers},
    diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    prelude::*,
    render::render_resource::BlendState,
    window::PrimaryWindow,
};
use bevy_egui::{
    EguiContexts, EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass, PrimaryEguiContext,
    egui::{Color32, ComboBox, DragValue, LayerId, Panel, ScrollArea, Slider, Ui, UiBuilder},
};
use bevy_panorbit_camera::PanOrbitCamera;
use clap::ValueEnum;

use crate::{
    common::scene::StudioCamera,
    model::{Model, Notice, Open},
    settings::{Field, Style, Symmetry, ViewerSettings},
};

/// Width of the panel at first, in logical pixels.
const WIDTH: f32 = 240.0;

/// Adds the panel.
pub struct PanelPlugin;

impl Plugin for PanelPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((EguiPlugin::default(), FrameTimeDiagnosticsPlugin::default()))
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
    diagnostics: Res<DiagnosticsStore>,
    mut open: MessageWriter<Open>,
    window: Single<&Window, With<PrimaryWindow>>,
    camera: Single<(&mut Camera, Option<&mut PanOrbitCamera>), With<StudioCamera>>,
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
            if model_section(ui, model.iter().next(), notice.0.as_deref()) {
                open.write(Open::Knot);
            }
            field_section(ui, &mut edited);
            style_section(ui, &mut edited);
            ui.separator();
            let fps = diagnostics
                .get(&FrameTimeDiagnosticsPlugin::FPS)
                .and_then(|fps| fps.smoothed());
            ui.weak(fps.map_or_else(String::new, |fps| format!("{fps:.0} frames per second")));
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

/// Gives whether the built-in model is asked for.
fn model_section(ui: &mut Ui, model: Option<&Model>, notice: Option<&str>) -> bool {
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
    let asked = ui.button("Knot").clicked();
    ui.weak("Drop an OBJ, PLY, STL, glTF or GLB file onto the window; a .txt file is a field.");
    asked
}

fn field_section(ui: &mut Ui, settings: &mut ViewerSettings) {
    ui.separator();
    ui.heading("Field");
    let is_axis = matches!(settings.field, Field::Axis(_));
    if ui.radio(is_axis, "Axis").clicked() && !is_axis {
        set_field(settings, Field::default());
    }
    if let Field::Axis(axis) = &mut settings.field {
        ui.horizontal(|ui| {
            let mut edited = *axis;
            for (name, value) in ["x ", "y ", "z "].into_iter().zip(edited.as_mut()) {
                ui.add(
                    DragValue::new(value)
                        .prefix(name)
                        .speed(0.01)
                        .range(-1.0..=1.0)
                        .max_decimals(2),
                );
            }
            // The zero vector is no direction.
            if edited.try_normalize().is_some() {
                *axis = edited;
            }
        });
    }
    let is_curvature = settings.field == Field::Curvature;
    if ui.radio(is_curvature, "Curvature").clicked() && !is_curvature {
        set_field(settings, Field::Curvature);
    }
    if let Field::File(path) = &settings.field {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let _ = ui.radio(true, name);
    }
    ui.horizontal(|ui| {
        ui.selectable_value(&mut settings.symmetry, Symmetry::Line, "Line")
            .on_hover_text("A direction and its opposite mean the same");
        ui.selectable_value(&mut settings.symmetry, Symmetry::Vector, "Vector")
            .on_hover_text("A direction and its opposite differ");
    });
    ui.label("Stripes per diagonal");
    ui.add(
        Slider::new(&mut settings.frequency, ViewerSettings::FREQUENCIES)
            .logarithmic(true)
            .max_decimals(1),
    );
}

fn set_field(settings: &mut ViewerSettings, field: Field) {
    settings.symmetry = field.symmetry();
    settings.field = field;
}

fn style_section(ui: &mut Ui, settings: &mut ViewerSettings) {
    ui.separator();
    ui.heading("Style");
    let name = |style: Style| {
        style
            .to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned())
    };
    ComboBox::from_id_salt("style")
        .selected_text(name(settings.style))
        .show_ui(ui, |ui| {
            for &style in Style::value_variants() {
                ui.selectable_value(&mut settings.style, style, name(style));
            }
        });
    ui.add(Slider::new(&mut settings.duty, 0.0..=1.0).text("Duty"));
    ui.add(Slider::new(&mut settings.softness, 0.0..=1.0).text("Softness"));
    for (color, name) in [
        (&mut settings.stripe_color, "Stripes"),
        (&mut settings.gap_color, "Gaps"),
    ] {
        ui.horizontal(|ui| {
            ui.color_edit_button_srgb(color);
            ui.label(name);
        });
    }
}
