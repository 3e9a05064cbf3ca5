//! Measures what stripes cost: a screen full of `StandardMaterial` and of the same with stripes, and prints one JSON
//! object on stdout.
//!
//! ```sh
//! cargo run --release --example frame_time
//! ```
//!
//! The two are drawn in turn, with one light and no shadows, and a frame ends when the device has done its work. `ratio` is
//! that of the medians, Bevy's own share of a frame included.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line tool")]

mod common;

use bevy::{
    core_pipeline::tonemapping::Tonemapping, prelude::*, render::RenderApp, render::renderer::RenderAdapterInfo,
};
use bevy_field_patterns::prelude::*;
use common::{gpu, headless, mesh_file::to_bevy_mesh, shapes};
use serde_json::json;
use std::{process::ExitCode, time::Instant};

const SIZE: UVec2 = UVec2::new(640, 480);
/// Times that each of the two is drawn, and frames each time.
const ROUNDS: usize = 7;
const FRAMES: usize = 3;

fn main() -> ExitCode {
    match measure() {
        Ok(figures) => {
            println!("{figures:#}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn measure() -> Result<serde_json::Value, String> {
    let mut app = headless::headless_app(SIZE)?;
    app.add_plugins(FieldPatternsPlugin);
    let [empty, plain, striped] = furnish(app.world_mut());
    headless::wait_until_ready(&mut app)?;
    while app.world().get::<PatternState>(striped) != Some(&PatternState::Converged) {
        headless::update(&mut app)?;
    }
    let mut times = [const { Vec::new() }; 3];
    for _ in 0..ROUNDS {
        for (shown, times) in [empty, plain, striped].into_iter().zip(&mut times) {
            for body in [plain, striped] {
                let visibility = if body == shown {
                    Visibility::Visible
                } else {
                    Visibility::Hidden
                };
                app.world_mut().entity_mut(body).insert(visibility);
            }
            headless::update(&mut app)?;
            gpu::wait(&app);
            for _ in 0..FRAMES {
                let begin = Instant::now();
                headless::update(&mut app)?;
                gpu::wait(&app);
                times.push(1e3 * begin.elapsed().as_secs_f64());
            }
        }
    }
    let [empty, plain, striped] = times.map(median);
    let adapter = app.sub_app(RenderApp).world().resource::<RenderAdapterInfo>();
    Ok(json!({
        "adapter": adapter.name,
        "width": SIZE.x,
        "height": SIZE.y,
        "empty_ms": empty,
        "standard_ms": plain,
        "stripes_ms": striped,
        "ratio": striped / plain,
    }))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// A camera that sees nothing but a wavy sheet, in two materials; and an entity that is not there.
fn furnish(world: &mut World) -> [Entity; 3] {
    let mut sheet = shapes::plane(100, 0.2, 1);
    for p in &mut sheet.positions {
        *p *= 2.0;
        p.z += 0.05 * (4.0 * p.x).sin() * (5.0 * p.y).cos();
    }
    let mesh = world.resource_mut::<Assets<Mesh>>().add(to_bevy_mesh(&sheet));
    let base = StandardMaterial::from(Color::srgb(0.8, 0.75, 0.7));
    let plain = world.resource_mut::<Assets<StandardMaterial>>().add(base.clone());
    let striped = world.resource_mut::<Assets<StripeMaterial>>().add(StripeMaterial {
        base,
        extension: Stripes::default(),
    });
    world.spawn((
        Camera3d::default(),
        Msaa::Off,
        Tonemapping::None,
        Transform::from_xyz(0.0, 0.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    world.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let plain = world.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(plain))).id();
    let pattern = (DirectionField::Axis(Dir3::X), Frequency::Uniform(8.0));
    let striped = world.spawn((Mesh3d(mesh), MeshMaterial3d(striped), pattern)).id();
    [Entity::PLACEHOLDER, plain, striped]
}
