//! Looks at a mesh with a pattern that follows a field on it, and lets every setting be changed while it runs.
//!
//! ```sh
//! cargo run --example viewer -- model.obj --field curvature --frequency 60
//! cargo run --example viewer -- --screenshot picture.png --size 1280x720
//! ```
//!
//! Files (OBJ, PLY, STL, glTF, GLB) can be dropped onto the window; a `.txt` file is a field with one direction per vertex
//! of the model. Without a file there is a knot.
#![allow(unreachable_pub, reason = "modules of one program")]

#[path = "../common/mod.rs"]
mod common;
mod look;
mod model;
mod panel;
mod settings;
mod styles;

use std::{path::PathBuf, process::ExitCode};

use bevy::prelude::*;
use clap::Parser;
use common::args::{OutputArgs, run};
use model::{ModelPlugin, Open};
use settings::{Field, Style, ViewerSettings, WaveCount};

/// Shows a mesh with a pattern that follows a tangent field.
#[derive(Parser)]
#[command(name = "viewer")]
struct Cli {
    /// OBJ, PLY, STL, glTF or GLB file; a built-in knot without it
    mesh: Option<PathBuf>,
    /// What the pattern follows: `axis:X,Y,Z` (a direction), curvature (of least bending), attribute (_FIELD of a glTF
    /// file), tensor (`_TENSOR_DIAGONAL` and `_TENSOR_OFFDIAGONAL` of a glTF file; a twisted bar's elsewhere), or
    /// `file:FIELD.txt` (one line "x y z" per vertex)
    #[arg(long, default_value_t = Field::default())]
    field: Field,
    /// Stripes per diagonal of the model's bounding box
    #[arg(long, value_name = "F", default_value_t = ViewerSettings::default().frequency, value_parser = settings::parse_frequency)]
    frequency: f32,
    /// What is drawn
    #[arg(long, value_enum, default_value_t = Style::default())]
    style: Style,
    /// How many waves the pattern has
    #[arg(long, value_enum, default_value_t = WaveCount::default())]
    waves: WaveCount,
    #[command(flatten)]
    output: OutputArgs,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    run("Field patterns", &cli.output, |app| {
        let open = cli.mesh.as_deref().map_or(Ok(Open::Knot), Open::file)?;
        app.insert_resource(ViewerSettings {
            symmetry: cli.field.symmetry(),
            field: cli.field.clone(),
            frequency: cli.frequency,
            style: cli.style,
            waves: cli.waves,
            ..default()
        })
        .add_plugins((ModelPlugin { open }, look::LookPlugin));
        if cli.output.screenshot.is_none() {
            app.add_plugins(panel::PanelPlugin);
        }
        Ok(())
    })
}
