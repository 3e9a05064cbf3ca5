//! Samples a mesh file or a rectangle and prints one JSON object of figures and times on stdout.
//!
//! ```sh
//! cargo run --example sample -- bunny.obj --metric axis:0,1,0 --ratio 4 --count 10000
//! cargo run --example sample -- rect:1x1 --metric vortex --count 4000 --screenshot vortex.png
//! ```
//!
//! Everything runs without an app; with `--screenshot` the cells are drawn as well.

#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    unreachable_pub,
    reason = "a command line tool of several modules"
)]

#[path = "../common/mod.rs"]
mod common;

mod grids;
mod metrics;
mod picture;
mod plots;

use bevy::{
    math::DVec2,
    prelude::*,
    tasks::{ComputeTaskPool, TaskPool},
};
use bevy_field_patterns::{
    sampling::{
        Density, Progress, SampleQuality, SampleSet, SamplingTimes,
        planar::{Insertion, PlanarDomain, PlanarSampling, Relaxation, planar_quality, sample_plane},
        surface::{SurfaceMethod, SurfaceSampling, sample_surface, surface_quality},
        surface_metric,
    },
    surface::{SurfaceGraph, WeldOptions},
};
use clap::{Parser, ValueEnum};
use common::{args::OutputArgs, mesh_file};
use metrics::MetricArg;
use serde_json::{Value, json};
use std::{io::Write, path::PathBuf, process::ExitCode, time::Instant};

/// Samples a mesh or a rectangle and prints figures as JSON.
#[derive(Parser)]
struct Args {
    /// An OBJ, PLY or STL file, or `rect:WxH` for a rectangle from (0, 0) to (W, H).
    #[arg(value_parser = parse_ground)]
    ground: Ground,
    /// What samples follow: `iso`, `axis:X,Y,Z`, `curvature` (meshes), `vortex`, `wavy`, `graded`, `stress`, `image`,
    /// `volume`, `vectors` and `vertices` (rectangles), or `file:PATH` with one line `xx yy zz xy xz yz` of M per vertex of the mesh file, used as given.
    #[arg(long, default_value = "iso", value_parser = metrics::parse)]
    metric: MetricArg,
    /// Long axis over short axis of a sample, 1 or more [default: 4 along an axis or curvature, 10 of a vortex and waves]
    #[arg(long, value_parser = parse_ratio)]
    ratio: Option<f32>,
    /// Number of samples.
    #[arg(long, default_value_t = 4000, value_parser = clap::value_parser!(u32).range(1..))]
    count: u32,
    /// Fill rate η in place of a number: the metric is then taken as it is (a circle has radius 1).
    #[arg(long, conflicts_with = "count")]
    fill: Option<f32>,
    /// `labels` (default), `triangulated` or `paper` on meshes; `kite` (default), `star` or `paper` in a rectangle.
    #[arg(long)]
    method: Option<Method>,
    /// Steps of relaxation.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    steps: u32,
    /// Another seed gives other samples.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Steps of log-Euclidean smoothing of the metric over a mesh [default: 15, and 0 for a file]
    #[arg(long, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    smoothing: Option<u32>,
    /// Draw the samples' ellipses into an SVG file (in a rectangle).
    #[arg(long, value_name = "FILE")]
    ellipses: Option<PathBuf>,
    /// Draw the samples' power spectrum into a PNG file, undoing the stretch of a constant metric (in a rectangle).
    #[arg(long, value_name = "FILE")]
    spectrum: Option<PathBuf>,
    /// Write one line `x y z` per sample.
    #[arg(long, value_name = "FILE")]
    points: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Clone)]
enum Ground {
    Mesh(PathBuf),
    Rectangle(DVec2),
}

#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum Method {
    Labels,
    Triangulated,
    Paper,
    Kite,
    Star,
}

impl Method {
    fn name(self) -> String {
        format!("{self:?}").to_lowercase()
    }
}

fn parse_ground(text: &str) -> Result<Ground, String> {
    let Some(sides) = text.strip_prefix("rect:") else {
        return Ok(Ground::Mesh(text.into()));
    };
    let side = |text: &str| text.parse::<f64>().ok().filter(|side| side.is_finite() && *side > 0.0);
    sides
        .split_once(['x', 'X'])
        .and_then(|(w, h)| Some(Ground::Rectangle(DVec2::new(side(w)?, side(h)?))))
        .ok_or_else(|| "write a rectangle as rect:2x1, both sides above 0".into())
}

fn parse_ratio(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(ratio) if (1.0..=1000.0).contains(&ratio) => Ok(ratio),
        _ => Err("expected a number from 1 to 1000".into()),
    }
}

fn main() -> ExitCode {
    let args = Args::parse();
    ComputeTaskPool::get_or_init(TaskPool::new);
    let outcome = sample(&args).and_then(|(figures, drawn)| {
        writeln!(std::io::stdout(), "{figures}").map_err(|error| error.to_string())?;
        Ok(drawn)
    });
    match outcome {
        Ok(drawn) if args.output.screenshot.is_some() => picture::draw(&args.output, drawn),
        Ok(_) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

/// What a picture shows.
struct Drawn {
    set: SampleSet,
    /// The mesh that was sampled; `None` in a plane.
    mesh: Option<Mesh>,
}

fn sample(args: &Args) -> Result<(Value, Drawn), String> {
    match &args.ground {
        Ground::Mesh(path) => sample_mesh(args, path),
        Ground::Rectangle(sides) => sample_rectangle(args, *sides),
    }
}

fn density(args: &Args) -> Density {
    args.fill.map_or(Density::Count(args.count), Density::FillRate)
}

fn sample_mesh(args: &Args, path: &PathBuf) -> Result<(Value, Drawn), String> {
    let method = args.method.unwrap_or(Method::Labels);
    let surface_method = match method {
        Method::Labels => SurfaceMethod::Labels,
        Method::Triangulated => SurfaceMethod::Triangulated,
        Method::Paper => SurfaceMethod::Paper,
        Method::Kite | Method::Star => {
            return Err(format!("--method {}: this method is for a rectangle", method.name()));
        }
    };
    if args.ellipses.is_some() || args.spectrum.is_some() {
        return Err("--ellipses, --spectrum: these are for a rectangle".into());
    }
    let raw = mesh_file::read(path).map_err(|error| error.to_string())?;
    let mesh = mesh_file::to_bevy_mesh(&raw);
    let start = Instant::now();
    let graph = SurfaceGraph::from_triangles(&raw.positions, &raw.triangles, &WeldOptions::default())
        .map_err(|error| format!("{}: {error}", path.display()))?;
    let graph_ms = start.elapsed();
    let metric = metrics::on_mesh(&args.metric, args.ratio, args.smoothing, &raw)?;
    let start = Instant::now();
    let metrics = surface_metric(&metric, &graph, &mesh).map_err(|error| error.to_string())?;
    let metric_ms = start.elapsed();
    let options = SurfaceSampling {
        density: density(args),
        method: surface_method,
        steps: args.steps,
        seed: args.seed,
    };
    let start = Instant::now();
    let samples =
        sample_surface(&graph, &metrics, &options, &Progress::default()).map_err(|error| error.to_string())?;
    let total = start.elapsed() + graph_ms + metric_ms;
    write_points(args, &samples.set.positions)?;
    let quality = surface_quality(&graph, &metrics, &samples.set).map_err(|error| error.to_string())?;
    let ms = times(
        &samples.times,
        graph_ms.as_secs_f32(),
        metric_ms.as_secs_f32(),
        total.as_secs_f32(),
    );
    Ok((
        figures(method, &samples.set, &quality, ms),
        Drawn {
            set: samples.set,
            mesh: Some(mesh),
        },
    ))
}

/// Side of a spectrum in pixels.
const SPECTRUM: u32 = 256;

fn sample_rectangle(args: &Args, sides: DVec2) -> Result<(Value, Drawn), String> {
    let method = args.method.unwrap_or(Method::Kite);
    let mut options = match method {
        Method::Kite => PlanarSampling::default(),
        Method::Star => PlanarSampling {
            relaxation: Relaxation::Star,
            insertion: Insertion::LargestFirst,
            ..default()
        },
        Method::Paper => PlanarSampling::paper(),
        Method::Labels | Method::Triangulated => {
            return Err(format!("--method {}: this method is for a mesh", method.name()));
        }
    };
    options.density = density(args);
    options.steps = args.steps;
    options.seed = args.seed;
    let domain = PlanarDomain::Rectangle {
        min: DVec2::ZERO,
        max: sides,
    };
    let metric = metrics::in_rectangle(&args.metric, args.ratio, sides)?;
    let start = Instant::now();
    let samples = sample_plane(&domain, &metric, &options, &Progress::default()).map_err(|error| error.to_string())?;
    let total = start.elapsed();
    let positions: Vec<Vec3> = samples.positions.iter().map(|p| p.extend(0.0).as_vec3()).collect();
    write_points(args, &positions)?;
    if let Some(path) = &args.ellipses {
        plots::draw_ellipses(path, &samples, sides)?;
    }
    if let Some(path) = &args.spectrum {
        plots::draw_spectrum(path, &samples, &metric, sides, SPECTRUM)?;
    }
    let quality = planar_quality(&domain, &metric, &samples.positions).map_err(|error| error.to_string())?;
    let ms = times(&samples.times, 0.0, 0.0, total.as_secs_f32());
    let set = samples.set();
    Ok((figures(method, &set, &quality, ms), Drawn { set, mesh: None }))
}

fn times(times: &SamplingTimes, graph: f32, metric: f32, total: f32) -> Value {
    json!({
        "graph": rounded(1e3 * graph),
        "metric": rounded(1e3 * metric),
        "initial": rounded(times.initial),
        "per_step": rounded(times.per_step),
        "total": rounded(1e3 * total),
    })
}

fn figures(method: Method, set: &SampleSet, quality: &SampleQuality, ms: Value) -> Value {
    json!({
        "method": method.name(),
        "samples": set.len(),
        "ms": ms,
        "nn_min": rounded(quality.nn_min),
        "nn_p1": rounded(quality.nn_p1),
        "nn_mean": rounded(quality.nn_mean),
        "nn_cv": rounded(quality.nn_cv),
        "area_cv": rounded(quality.area_cv),
        "hole": rounded(quality.hole),
        "empty_cells": quality.empty_cells,
        "coverage": rounded(quality.coverage),
        "overlap": rounded(quality.overlap),
    })
}

/// Four decimals; more are noise.
fn rounded(value: f32) -> Value {
    json!((f64::from(value) * 1e4).round() / 1e4)
}

fn write_points(args: &Args, positions: &[Vec3]) -> Result<(), String> {
    let Some(path) = &args.points else { return Ok(()) };
    let lines: String = positions.iter().map(|p| format!("{} {} {}\n", p.x, p.y, p.z)).collect();
    std::fs::write(path, lines).map_err(|error| format!("{}: {error}", path.display()))
}
