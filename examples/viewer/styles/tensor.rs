//! A tensor's stripes in the viewer, and a tensor for meshes that have none.

use bevy::{mesh::VertexAttributeValues, prelude::*};
use bevy_egui::egui::{Slider, Ui};
use bevy_field_patterns::material::{Eigenvalue, Tensor};

use super::Ground;
use crate::{
    common::gltf::{TENSOR_DIAGONAL_ATTRIBUTE, TENSOR_OFFDIAGONAL_ATTRIBUTE},
    panel::range_sliders,
};

/// The settings of a tensor's stripes.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorSettings {
    /// The eigenvalues of the palest and the darkest colour. Default 0 and 4.
    range: [f32; 2],
    /// Eigenvalues above are alerts. Default 3.
    limit: f32,
    /// Width of a stripe at the value 0, as a share of half a period. Default 0.1.
    thin: f32,
    /// Width of a stripe at the end of the range. Default 0.9.
    thick: f32,
    /// Softness of the stripes' edges, 0 to 1. Default 0.
    softness: f32,
    /// Width in pixels of the line where alerts begin. Default 1.5.
    line: f32,
}

impl Default for TensorSettings {
    fn default() -> Self {
        Self {
            range: [0.0, 4.0],
            limit: 3.0,
            thin: 0.1,
            thick: 0.9,
            softness: 0.0,
            line: 1.5,
        }
    }
}

impl TensorSettings {
    /// The look.
    pub fn look(&self, ground: &Ground) -> Tensor {
        let [low, high] = self.range;
        let styled = |eigenvalue: Eigenvalue| Eigenvalue {
            thin: self.thin,
            thick: self.thick,
            ..eigenvalue.with_range(low, high).with_limit(self.limit)
        };
        Tensor {
            first: styled(Eigenvalue::default()),
            second: styled(Eigenvalue::SECOND),
            softness: self.softness,
            line_width: self.line,
            waves: ground.stripe_waves(),
            focus: ground.focus,
            ..default()
        }
    }

    /// Its part of the panel.
    pub fn panel(&mut self, ui: &mut Ui) {
        ui.label("Eigenvalues");
        range_sliders(ui, &mut self.range);
        ui.add(Slider::new(&mut self.limit, -5.0..=5.0).text("Limit"));
        ui.add(Slider::new(&mut self.thin, 0.0..=1.0).text("Thin"));
        ui.add(Slider::new(&mut self.thick, 0.0..=1.0).text("Thick"));
        ui.add(Slider::new(&mut self.softness, 0.0..=1.0).text("Softness"));
        ui.add(Slider::new(&mut self.line, 0.0..=6.0).text("Line"));
    }
}

/// Gives a mesh the stress of a bar along y that is pulled, and twisted about its axis: `σ_yy` = 1, and across r a shear that
/// grows from 0 on the axis to 3 where the mesh reaches farthest from it.
pub fn add_stress(mesh: &mut Mesh) {
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        return;
    };
    let reach = positions
        .iter()
        .map(|[x, _, z]| x.hypot(*z))
        .fold(f32::MIN_POSITIVE, f32::max);
    let diagonal = vec![[0.0_f32, 1.0, 0.0]; positions.len()];
    let shear = 3.0 / reach;
    let off_diagonal: Vec<[f32; 3]> = positions.iter().map(|[x, _, z]| [shear * z, -shear * x, 0.0]).collect();
    mesh.insert_attribute(TENSOR_DIAGONAL_ATTRIBUTE, diagonal);
    mesh.insert_attribute(TENSOR_OFFDIAGONAL_ATTRIBUTE, off_diagonal);
}
