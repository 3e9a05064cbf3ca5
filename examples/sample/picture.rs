//! Draws the cells of the samples: on the mesh, or in the plane.

use bevy::prelude::*;
use bevy_field_patterns::prelude::*;
use std::process::ExitCode;

use super::{
    Drawn,
    common::{
        args::{OutputArgs, run, run_on},
        flat::FlatPlugin,
        scene::Subject,
    },
};

/// Draws into the file that `output` names.
pub fn draw(output: &OutputArgs, drawn: Drawn) -> ExitCode {
    let Drawn { set, mesh } = drawn;
    let Some(mesh) = mesh else {
        let start = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let (min, max) = set
            .positions
            .iter()
            .fold(start, |(min, max), p| (min.min(p.truncate()), max.max(p.truncate())));
        let stage = FlatPlugin {
            shown: Rect::from_corners(min, max),
        };
        return run_on(stage, "Samples", output, |app| {
            app.add_plugins(FieldPatternsPlugin);
            let mut materials = app.world_mut().resource_mut::<Assets<CellMaterial2d>>();
            let material = materials.add(CellMaterial2d::default());
            app.world_mut()
                .spawn((set, Mesh2d::default(), MeshMaterial2d(material)));
            Ok(())
        });
    };
    run("Samples", output, |app| {
        app.add_plugins(FieldPatternsPlugin);
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
        let mut materials = app.world_mut().resource_mut::<Assets<CellMaterial>>();
        let material = materials.add(CellMaterial {
            base: StandardMaterial {
                perceptual_roughness: 0.7,
                double_sided: true,
                cull_mode: None,
                ..default()
            },
            extension: Cells { bump: 0.2, ..default() },
        });
        app.world_mut()
            .spawn((Subject, set, Mesh3d(mesh), MeshMaterial3d(material)));
        Ok(())
    })
}
