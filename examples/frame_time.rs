//! Measures what stripes and cells cost: a screen full of `StandardMaterial`, of the same with stripes and of the same with
//! cells and their borders, and prints one JSON object on stdout.
//!
//! ```sh
//! cargo run --release --example frame_time
//! ```
//!
//! They are drawn in turn, with one light and no shadows, and a frame ends when the device has done its work. `ratio` (of
//! stripes) and `cells_ratio` are those of the medians, Bevy's own share of a frame included.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line tool")]

mod common;

use bevy::{
    core_pipeline::tonemapping::Tonemapping, prelude::*, render::RenderApp, render::renderer::RenderAdapterInfo,
};
use bevy_field_patterns::prelude::*;
use common::{
    gpu, headless,
    mesh_file::{RawMesh, to_bevy_mesh},
    shapes,
};
use glam_matrix_extras::SymmetricMat3;
use serde_json::json;
use spade::{DelaunayTriangulation, Point2, Triangulation};
use std::{process::ExitCode, time::Instant};

const SIZE: UVec2 = UVec2::new(640, 480);
/// Samples along a side of the sheet, of which about half are seen.
const SAMPLES_ALONG: usize = 60;
/// Times that each of the three is drawn, and frames each time.
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
    let bodies = furnish(app.world_mut())?;
    let [_, plain, striped, celled] = bodies;
    headless::wait_until_ready(&mut app)?;
    while app.world().get::<PatternState>(striped) != Some(&PatternState::Converged)
        || app.world().get::<CellState>(celled) != Some(&CellState::Ready)
    {
        headless::update(&mut app)?;
    }
    let mut times = [const { Vec::new() }; 4];
    for _ in 0..ROUNDS {
        for (shown, times) in bodies.into_iter().zip(&mut times) {
            for body in [plain, striped, celled] {
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
    let [empty, plain, striped, celled] = times.map(median);
    let adapter = app.sub_app(RenderApp).world().resource::<RenderAdapterInfo>();
    Ok(json!({
        "adapter": adapter.name,
        "width": SIZE.x,
        "height": SIZE.y,
        "empty_ms": empty,
        "standard_ms": plain,
        "stripes_ms": striped,
        "ratio": striped / plain,
        "cells_ms": celled,
        "cells_ratio": celled / plain,
    }))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Where the sheet is above a point of the plane.
fn height(p: Vec2) -> f32 {
    0.05 * (4.0 * p.x).sin() * (5.0 * p.y).cos()
}

/// Round samples on the sheet, the vertices of a jittered grid, with their Delaunay neighbours.
fn samples(sheet: &RawMesh) -> Result<SampleSet, String> {
    let spacing = 4.0 / SAMPLES_ALONG as f32;
    let grid = shapes::plane(SAMPLES_ALONG, 0.24, 2).positions;
    let grid = grid.iter().map(|p| Point2::new(2.0 * p.x, 2.0 * p.y)).collect();
    let delaunay = DelaunayTriangulation::<Point2<f32>>::bulk_load_stable(grid).map_err(|e| e.to_string())?;
    let position = |v: Point2<f32>| Vec3::new(v.x, v.y, height(Vec2::new(v.x, v.y)));
    let positions: Vec<Vec3> = delaunay.vertices().map(|v| position(v.position())).collect();
    let radius = spacing / 12_f32.powf(0.25);
    let mut set = SampleSet {
        normals: vec![Vec3::Z; positions.len()],
        metrics: vec![SymmetricMat3::IDENTITY * radius.powi(-2); positions.len()],
        positions,
        neighbor_offsets: vec![0],
        ..default()
    };
    for vertex in delaunay.vertices() {
        let mut ring: Vec<u32> = vertex.out_edges().map(|edge| edge.to().index() as u32).collect();
        ring.sort_unstable();
        set.neighbors.extend(ring);
        set.neighbor_offsets.push(set.neighbors.len() as u32);
    }
    let nearest = |p: &Vec3| {
        delaunay
            .nearest_neighbor(Point2::new(p.x, p.y))
            .map_or(0, |v| v.index() as u32)
    };
    let labels: Vec<u32> = sheet.positions.iter().map(nearest).collect();
    set.seeds = sheet.triangles.iter().map(|t| t.map(|v| labels[v as usize])).collect();
    Ok(set)
}

/// A camera that sees nothing but a wavy sheet, in three materials; and an entity that is not there.
fn furnish(world: &mut World) -> Result<[Entity; 4], String> {
    let mut sheet = shapes::plane(100, 0.2, 1);
    for p in &mut sheet.positions {
        *p *= 2.0;
        p.z = height(p.truncate());
    }
    let mesh = world.resource_mut::<Assets<Mesh>>().add(to_bevy_mesh(&sheet));
    let base = StandardMaterial::from(Color::srgb(0.8, 0.75, 0.7));
    let plain = world.resource_mut::<Assets<StandardMaterial>>().add(base.clone());
    let striped = world.resource_mut::<Assets<StripeMaterial>>().add(StripeMaterial {
        base: base.clone(),
        extension: Stripes::default(),
    });
    let celled = world.resource_mut::<Assets<CellMaterial>>().add(CellMaterial {
        base,
        extension: Cells::default(),
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
    let striped = world
        .spawn((Mesh3d(mesh.clone()), MeshMaterial3d(striped), pattern))
        .id();
    let celled = world
        .spawn((Mesh3d(mesh), MeshMaterial3d(celled), samples(&sheet)?))
        .id();
    Ok([Entity::PLACEHOLDER, plain, striped, celled])
}
