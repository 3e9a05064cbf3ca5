//! The panel beside the model: shows and changes the [`ViewerSettings`], and tells how the solver is doing.
//!
//! The panel has a camera of its own; the studio's camera draws beside it.

use bevy::{
    camera::{CameraOutputMode, Viewport, visibility::RenderLayers},
    diagnostic::{DiagnosticPath, DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    ecs::system::SystemParam,
    prelude::*,
    render::{diagnostic::RenderDiagnosticsPlugin, render_resource::BlendState},
    window::PrimaryWindow,
};
use bevy_egui::{
    EguiContexts, EguiGlobalSettings, EguiPlugin, EguiPrimaryContextPass, PrimaryEguiContext,
    egui::{Color32, ComboBox, DragValue, Grid, LayerId, Panel, ScrollArea, Slider, Ui, UiBuilder},
};
use bevy_field_patterns::{
    diagnostics::{BRANCHES, ENERGY},
    prelude::*,
    wave::{Pattern, PatternArena, SolverCounters},
};
use bevy_panorbit_camera::PanOrbitCamera;
use clap::ValueEnum;

use crate::{
    common::scene::StudioCamera,
    model::{Model, Notice, Open},
    settings::{Field, Method, Shape, Style, ViewerSettings},
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
            if model_section(ui, model.iter().next(), notice.0.as_deref()) {
                open.write(Open::Knot);
            }
            field_section(ui, &mut edited);
            let has_gaps = model.iter().all(|model| model.material.is_some());
            style_section(ui, &mut edited, has_gaps);
            if solver_section(ui, &mut edited) {
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
        set_field(settings, Field::Axis(Vec3::Y));
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
    let is_attribute = settings.field == Field::Attribute;
    if ui.radio(is_attribute, "Attribute _FIELD").clicked() && !is_attribute {
        set_field(settings, Field::Attribute);
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

fn style_section(ui: &mut Ui, settings: &mut ViewerSettings, has_gaps: bool) {
    ui.separator();
    ui.heading("Style");
    choice(ui, "style", &mut settings.style);
    let is_vector = settings.symmetry == Symmetry::Vector;
    choice(ui, "waves", &mut settings.waves);
    match settings.style {
        Style::Hatch => hatch_section(ui, settings),
        Style::Texture => {
            ui.add_enabled(is_vector, Slider::new(&mut settings.speed, -2.0..=2.0).text("Travel"))
                .on_disabled_hover_text("Only along vectors");
        }
        _ => stripe_section(ui, settings, has_gaps),
    }
}

fn hatch_section(ui: &mut Ui, settings: &mut ViewerSettings) {
    ui.add(Slider::new(&mut settings.darkness, 0.0..=1.0).text("Darkest"));
    ui.add(Slider::new(&mut settings.stroke, 0.01..=1.0).text("Stroke"));
    ui.add(Slider::new(&mut settings.density, 0.0..=1.0).text("Density"));
    ui.add(Slider::new(&mut settings.outline, 0.0..=8.0).text("Outline"));
}

fn stripe_section(ui: &mut Ui, settings: &mut ViewerSettings, has_gaps: bool) {
    let is_vector = settings.symmetry == Symmetry::Vector;
    choice(ui, "shape", &mut settings.shape);
    if settings.shape == Shape::Sawtooth && !is_vector {
        ui.weak("A sawtooth needs vectors");
    }
    ui.add_enabled(
        settings.shape == Shape::Square,
        Slider::new(&mut settings.duty, 0.0..=1.0).text("Duty"),
    );
    ui.add_enabled(
        settings.shape == Shape::Square,
        Slider::new(&mut settings.softness, 0.0..=1.0).text("Softness"),
    );
    ui.add(Slider::new(&mut settings.bump, -0.5..=0.5).text("Bump"));
    ui.add_enabled(is_vector, Slider::new(&mut settings.speed, -2.0..=2.0).text("Travel"))
        .on_disabled_hover_text("Only along vectors");
    color(ui, "Stripes", &mut settings.stripe_color);
    if has_gaps {
        color(ui, "Gaps", &mut settings.gap_color);
    }
}

fn color(ui: &mut Ui, name: &str, color: &mut [u8; 3]) {
    ui.horizontal(|ui| {
        ui.color_edit_button_srgb(color);
        ui.label(name);
    });
}

/// A list to choose from.
fn choice<T: ValueEnum + PartialEq + Copy>(ui: &mut Ui, id: &str, chosen: &mut T) {
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

/// Gives whether the solver is asked to start again.
fn solver_section(ui: &mut Ui, settings: &mut ViewerSettings) -> bool {
    ui.separator();
    ui.heading("Solver");
    ui.horizontal(|ui| {
        ui.selectable_value(&mut settings.method, Method::Hierarchy, "Hierarchy")
            .on_hover_text("Starts from coarse to fine");
        ui.selectable_value(&mut settings.method, Method::Local, "Local")
            .on_hover_text("Starts with random phases and local sweeps");
        ui.button("Restart").clicked()
    })
    .inner
}

/// What the panel tells of the patterns.
#[derive(SystemParam)]
struct Statistics<'w, 's> {
    patterns: Query<'w, 's, (Entity, &'static PatternState, Option<&'static Pattern>)>,
    diagnostics: Res<'w, DiagnosticsStore>,
    counters: Res<'w, SolverCounters>,
    arena: Res<'w, PatternArena>,
}

impl Statistics<'_, '_> {
    fn measured(&self, path: &DiagnosticPath) -> Option<f64> {
        self.diagnostics.get(path)?.smoothed()
    }

    fn latest(&self, path: &DiagnosticPath) -> Option<f64> {
        self.diagnostics.get(path)?.value()
    }

    /// The state of the pattern that is furthest from rest.
    fn state(&self) -> &'static str {
        let is = |wanted: fn(&PatternState) -> bool| self.patterns.iter().any(|(_, state, _)| wanted(state));
        match () {
            () if self.patterns.is_empty() => "none",
            () if is(|state| matches!(state, PatternState::Failed(_))) => "failed",
            () if is(|state| matches!(state, PatternState::Preparing)) => "preparing",
            () if is(|state| matches!(state, PatternState::Solving)) => "solving",
            () => "converged",
        }
    }
}

fn statistics_section(ui: &mut Ui, statistics: &Statistics) {
    ui.separator();
    ui.heading("Pattern");
    let errors = statistics.patterns.iter().filter_map(|(_, state, _)| match state {
        PatternState::Failed(error) => Some(error.to_string()),
        _ => None,
    });
    if let Some(error) = errors.into_iter().next() {
        ui.colored_label(Color32::LIGHT_RED, error);
    }
    let patterns = statistics.patterns.iter().filter_map(|(.., pattern)| pattern);
    let vertices: u32 = patterns.map(|pattern| pattern.record().vertices).sum();
    let memory = statistics.arena.memory();
    let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let number =
        |value: Option<f64>, digits: usize| value.map_or("–".to_owned(), |value| format!("{value:.digits$}"));
    let lines = [
        ("State", statistics.state().to_owned()),
        ("Vertices", vertices.to_string()),
        ("Energy", number(statistics.latest(&ENERGY), 5)),
        ("Branches", number(statistics.latest(&BRANCHES), 0)),
        ("Sweeps, last frame", statistics.counters.sweeps().to_string()),
        ("Dispatches, last frame", statistics.counters.dispatches().to_string()),
        (
            "GPU memory",
            format!(
                "{:.1} of {:.1} MiB",
                mebibytes(memory.used),
                mebibytes(memory.allocated)
            ),
        ),
        (
            "Frame",
            format!(
                "{} ms",
                number(statistics.measured(&FrameTimeDiagnosticsPlugin::FRAME_TIME), 1)
            ),
        ),
    ];
    Grid::new("statistics").num_columns(2).show(ui, |ui| {
        for (name, value) in lines {
            ui.weak(name);
            ui.label(value);
            ui.end_row();
        }
    });
}
