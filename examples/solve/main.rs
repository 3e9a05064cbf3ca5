//! Solves a wave on a mesh file and prints one JSON object of figures and times on stdout.
//!
//! ```sh
//! cargo run --release --example solve -- bunny.obj --field axis:0.15,1,0.1 --frequency 40 --repeat 5
//! ```
//!
//! Frequencies are per unit length of the file. The GPU solves by the plugin in an app without window or camera; `cold`
//! and `warm3` are whole frames of that app until the device is idle, so they contain Bevy's own two milliseconds or so.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line tool")]

#[path = "../common/mod.rs"]
mod common;
mod on_cpu;
mod on_gpu;
mod report;

use bevy::prelude::*;
use bevy_field_patterns::{
    field::Principal,
    prelude::*,
    wave::{
        Coupling,
        solver::{ColdStart, LocalRule, MergedRule},
    },
};
use clap::{Parser, ValueEnum};
use common::mesh_file::{self, RawMesh};
use serde_json::Value;
use std::{io::Write, path::PathBuf, process::ExitCode, time::Instant};

/// Solves a stripe pattern on a mesh and prints its figures as JSON.
#[derive(Parser)]
struct Args {
    /// An OBJ, PLY or STL file.
    mesh: PathBuf,
    /// What the pattern follows: `axis:X,Y,Z`, `curvature`, or `file:PATH` with one line `x y z` per vertex of the mesh
    /// file, used as given.
    #[arg(long, default_value = "curvature", value_parser = parse_field)]
    field: Field,
    /// Whether d and -d are the same.
    #[arg(long, default_value = "line")]
    symmetry: SymmetryArg,
    /// One wave, two along the field and across it, or the two of a cross field.
    #[arg(long, default_value = "single")]
    waves: WavesArg,
    /// Stripes per unit length of the file.
    #[arg(long, default_value_t = 20.0)]
    frequency: f32,
    /// The Galerkin hierarchy, or the local rule of Lichtenberg et al. 2018, on the mesh only or on surfaces of merged
    /// vertices before (with `--device cpu`).
    #[arg(long, default_value = "hierarchy")]
    method: MethodArg,
    /// The most surfaces of merged vertices.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(0..=32))]
    levels: u32,
    /// Soft sweeps after the hierarchy [default: 10], or the most sweeps of the local rule on each surface [default: 100].
    #[arg(long, value_parser = clap::value_parser!(u32).range(0..=1000))]
    sweeps: Option<u32>,
    /// The local rule ends when the energy changes by less than this share in a sweep; 0: never.
    #[arg(long, default_value_t = 1e-3, value_parser = parse_finite)]
    epsilon: f32,
    /// Leave out the last third of the colours in every second sweep of the local rule.
    #[arg(long)]
    skip_last_third: bool,
    /// Where to solve.
    #[arg(long, default_value = "gpu")]
    device: DeviceArg,
    /// Solve so many times; times are medians, after one solve that does not count.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    /// After the cold start, turn the axis for so many frames, 3 or more for a motion to have a jitter (needs
    /// `--field axis:…`).
    #[arg(long, value_parser = clap::value_parser!(u32).range(3..=100_000))]
    warm: Option<u32>,
    /// Degrees per frame about the z axis, with `--warm`.
    #[arg(long, default_value_t = 1.0, value_parser = parse_finite, allow_negative_numbers = true)]
    turn: f32,
    /// Percent by which the frequency grows per frame, with `--warm`.
    #[arg(long, default_value_t = 0.0, value_parser = parse_finite, allow_negative_numbers = true)]
    zoom: f32,
    /// Sweeps per coarse level of a V-cycle in every frame, with `--warm`; 0: no V-cycle.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1000))]
    warm_levels: u32,
    /// Soft sweeps per frame, with `--warm`.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    warm_sweeps: u32,
    /// Solve on the vertices as a point cloud, and judge the wave on the mesh (with `--device cpu`).
    #[arg(long)]
    points: bool,
    /// Neighbours that each point asks for.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(3..=32))]
    neighbors: u32,
    /// Draw creases of more than 35 degrees to crests with this weight (with `--device cpu`).
    #[arg(long, value_parser = parse_finite)]
    crease: Option<f32>,
    /// Write re, im of every vertex of the file as little-endian f32.
    #[arg(long)]
    phasors: Option<PathBuf>,
}

#[derive(Clone)]
enum Field {
    Axis(Vec3),
    Curvature,
    File(PathBuf),
}

#[derive(Clone, Copy, ValueEnum)]
enum SymmetryArg {
    Line,
    Vector,
}

#[derive(Clone, Copy, ValueEnum)]
enum WavesArg {
    Single,
    Orthogonal,
    Cross,
}

#[derive(Clone, Copy, ValueEnum)]
enum MethodArg {
    Hierarchy,
    Local,
    Merged,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum DeviceArg {
    Gpu,
    Cpu,
}

fn parse_finite(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("expected a finite number".into()),
    }
}

fn parse_field(text: &str) -> Result<Field, String> {
    if text == "curvature" {
        return Ok(Field::Curvature);
    }
    if let Some(path) = text.strip_prefix("file:") {
        return Ok(Field::File(path.into()));
    }
    let Some(axis) = text.strip_prefix("axis:") else {
        return Err("expected axis:X,Y,Z, curvature or file:PATH".into());
    };
    let numbers: Result<Vec<f32>, _> = axis.split(',').map(|number| number.trim().parse::<f32>()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if Dir3::from_xyz(x, y, z).is_ok() => Ok(Field::Axis(Vec3::new(x, y, z))),
        _ => Err("an axis is three finite numbers X,Y,Z, not all 0".into()),
    }
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(figures) => {
            if let Err(error) = writeln!(std::io::stdout(), "{figures}") {
                eprintln!("solve: {error}");
                return ExitCode::from(2);
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("solve: {error}");
            ExitCode::from(2)
        }
    }
}

/// A mesh, and the field on it.
struct Problem {
    raw: RawMesh,
    field: DirectionField,
    coupling: Coupling,
    frequency: f32,
    settings: SolverSettings,
}

fn run(args: &Args) -> Result<Value, String> {
    let raw = mesh_file::read(&args.mesh).map_err(|error| error.to_string())?;
    check_size(&raw, args.frequency)?;
    let field = match &args.field {
        Field::Axis(axis) => DirectionField::Axis(Dir3::new(*axis).map_err(|error| error.to_string())?),
        Field::Curvature => DirectionField::PrincipalCurvature {
            direction: Principal::Major,
            smoothing: 30,
        },
        Field::File(path) => {
            let field = mesh_file::read_field(path, raw.positions.len()).map_err(|error| error.to_string())?;
            DirectionField::Tangents(field.into())
        }
    };
    if !args.frequency.is_finite() || args.frequency < 0.0 {
        return Err(format!(
            "the frequency {} is not a number of stripes per unit length, 0 or more",
            args.frequency
        ));
    }
    if args.warm.is_some() && !matches!(args.field, Field::Axis(_)) {
        return Err("--warm turns an axis; use it with --field axis:X,Y,Z".into());
    }
    let for_cpu = args.points || args.crease.is_some() || matches!(args.method, MethodArg::Merged);
    if for_cpu && args.device != DeviceArg::Cpu {
        return Err("--points, --crease and --method merged need --device cpu".into());
    }
    let mut settings = SolverSettings {
        warm_sweeps: args.warm_sweeps,
        warm_level_sweeps: args.warm_levels,
        ..default()
    };
    let local = LocalRule {
        max_sweeps: args.sweeps.unwrap_or(100),
        epsilon: args.epsilon,
        skip_last_third: args.skip_last_third,
        ..default()
    };
    match args.method {
        MethodArg::Hierarchy => settings.soft_sweeps = args.sweeps.unwrap_or(settings.soft_sweeps),
        MethodArg::Local => settings.cold_start = ColdStart::Local(local),
        MethodArg::Merged => {
            let levels = args.levels;
            settings.cold_start = ColdStart::Merged(MergedRule { levels, local });
        }
    }
    let symmetry = match args.symmetry {
        SymmetryArg::Line => Symmetry::Line,
        SymmetryArg::Vector => Symmetry::Vector,
    };
    let waves = match args.waves {
        WavesArg::Single => Waves::Single,
        WavesArg::Orthogonal => Waves::ORTHOGONAL,
        WavesArg::Cross => Waves::Cross,
    };
    let problem = Problem {
        raw,
        field,
        coupling: Coupling { waves, symmetry },
        frequency: args.frequency,
        settings,
    };
    match args.device {
        DeviceArg::Gpu => on_gpu::Gpu::new(&problem)?.report(args, &problem),
        DeviceArg::Cpu => on_cpu::solve(args, &problem),
    }
}

/// Refuses a mesh on which f32 can tell no phases.
fn check_size(raw: &RawMesh, frequency: f32) -> Result<(), String> {
    let corners = raw.positions.iter().fold(None, |corners, &p| {
        let (low, high) = corners.unwrap_or((p, p));
        Some((low.min(p), high.max(p)))
    });
    let Some((low, high)) = corners else { return Ok(()) };
    let size = low.as_dvec3().distance(high.as_dvec3());
    if size > LARGEST || (size > 0.0 && size < 1.0 / LARGEST) {
        return Err(format!(
            "the mesh is {size:e} across; scale it to between {:e} and {LARGEST:e}, where f32 can square lengths",
            1.0 / LARGEST
        ));
    }
    if size * f64::from(frequency) > MOST_STRIPES {
        return Err(format!(
            "{frequency} stripes per unit are {:e} across the mesh; f32 tells at most {MOST_STRIPES:e} apart",
            size * f64::from(frequency)
        ));
    }
    Ok(())
}

/// Lengths between this and its inverse have squares.
const LARGEST: f64 = 1e18;
/// f32 has 24 bits, of which a phase needs some behind the point.
const MOST_STRIPES: f64 = 1e6;

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(0.0)
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// The axis of a frame of `--warm`.
fn turned(field: &DirectionField, degrees: f32) -> DirectionField {
    match field {
        DirectionField::Axis(axis) => DirectionField::Axis(Quat::from_rotation_z(degrees.to_radians()) * *axis),
        other => other.clone(),
    }
}

/// The frequency of a frame of `--warm`.
fn zoomed(frequency: f32, percent: f32, frame: u32) -> f32 {
    frequency * (1.0 + percent / 100.0).powi(frame as i32)
}
