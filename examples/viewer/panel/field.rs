//! What the pattern follows, how dense it is, and what it does while the model moves.

use bevy::prelude::*;
use bevy_egui::egui::{DragValue, Slider, Ui};
use bevy_field_patterns::prelude::*;

use crate::settings::{Field, ViewerSettings};

/// The part of the panel for the field.
pub fn field_section(ui: &mut Ui, settings: &mut ViewerSettings) {
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
    let is_tensor = settings.field == Field::Tensor;
    if ui.radio(is_tensor, "Tensor").clicked() && !is_tensor {
        set_field(settings, Field::Tensor);
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
    ui.label("While the model moves");
    ui.horizontal(|ui| {
        ui.selectable_value(&mut settings.pose, PatternPose::Rest, "Stick")
            .on_hover_text("The pattern is stretched with the surface");
        ui.selectable_value(&mut settings.pose, PatternPose::Live, "Keep spacing")
            .on_hover_text("Stripes wander over the surface");
    });
}

fn set_field(settings: &mut ViewerSettings, field: Field) {
    settings.symmetry = field.symmetry();
    settings.field = field;
}
