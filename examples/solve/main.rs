//! Solves a wave on a mesh file and prints one JSON object of figures and times on stdout.
//!
//! ```sh
//! cargo run --release --example solve -- bunny.obj --field axis:0.15,1,0.1 --frequency 40 --repeat 5
//! ```
//!
//! Frequencies are per unit length of the file. The GPU solves by the plugin in an app without window or camera; `cold`
//! and `warm3` are whole frames of that app until the device is idle, so they contain Bevy's own two milliseconds or so.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line tool")]

mod common;

use bevy::{
    prelude::*,
    render::{RenderApp, diagnostic::RenderDiagnosticsPlugin, renderer::RenderAdapterInfo},
    tasks::{AsyncComputeTaskPool, ComputeTaskPool, TaskPool},
};
use bevy_field_patterns::{
    diagnostics::QualityReport,
    field::{Principal, directions},
    prelude::*,
    surface::{SurfaceGraph, WeldOptions},
    wave::{
        Pattern, PatternArena, SolverCounters,
        kite::reversed,
        layout::{BALANCE_BUFFER, WAVE_BUFFER},
        quality,
        solver::{ColdStart, LocalRule, Relaxation, edges, follow_cpu, solve_cpu, sweep},
    },
};
use clap::{Parser, ValueEnum};
use common::{
    gpu, headless,
    mesh_file::{self, RawMesh},
};
use serde_json::{Value, json};
use std::{io::Write, path::PathBuf, process::ExitCode, sync::Arc, time::Instant};

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
    /// Stripes per unit length of the file.
    #[arg(long, default_value_t = 20.0)]
    frequency: f32,
    /// The Galerkin hierarchy, or the local rule of Lichtenberg et al. 2018.
    #[arg(long, default_value = "hierarchy")]
    method: MethodArg,
    /// Soft sweeps after the hierarchy [default: 10], or the most sweeps of the local rule [default: 100].
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
    /// After the cold start, turn the axis for so many frames (needs `--field axis:…`).
    #[arg(long)]
    warm: Option<u32>,
    /// Degrees per frame about the z axis, with `--warm`.
    #[arg(long, default_value_t = 1.0, value_parser = parse_finite, allow_negative_numbers = true)]
    turn: f32,
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
enum MethodArg {
    Hierarchy,
    Local,
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
    symmetry: Symmetry,
    frequency: f32,
    settings: SolverSettings,
}

fn run(args: &Args) -> Result<Value, String> {
    let raw = mesh_file::read(&args.mesh).map_err(|error| error.to_string())?;
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
    let mut settings = SolverSettings::default();
    match args.method {
        MethodArg::Hierarchy => settings.soft_sweeps = args.sweeps.unwrap_or(settings.soft_sweeps),
        MethodArg::Local => {
            settings.cold_start = ColdStart::Local(LocalRule {
                max_sweeps: args.sweeps.unwrap_or(100),
                epsilon: args.epsilon,
                skip_last_third: args.skip_last_third,
                ..LocalRule::default()
            });
        }
    }
    let symmetry = match args.symmetry {
        SymmetryArg::Line => Symmetry::Line,
        SymmetryArg::Vector => Symmetry::Vector,
    };
    let problem = Problem {
        raw,
        field,
        symmetry,
        frequency: args.frequency,
        settings,
    };
    match args.device {
        DeviceArg::Gpu => Gpu::new(&problem)?.report(args, &problem),
        DeviceArg::Cpu => on_cpu(args, &problem),
    }
}

/// A solved wave in solver order.
struct Wave {
    directions: Vec<Vec3>,
    phasors: Vec<Vec2>,
}

/// The figures that do not depend on where the wave was solved.
fn figures(args: &Args, problem: &Problem, graph: &SurfaceGraph, wave: &Wave, sweeps: u32) -> Result<Value, String> {
    if let Some(path) = &args.phasors {
        std::fs::write(path, phasor_bytes(problem, graph, wave))
            .map_err(|error| format!("{}: {error}", path.display()))?;
    }
    let frequencies = vec![problem.frequency; graph.len()];
    let q = quality(graph, &wave.directions, &frequencies, &wave.phasors, problem.symmetry);
    Ok(json!({
        "method": match args.method { MethodArg::Hierarchy => "hierarchy", MethodArg::Local => "local" },
        "vertices": problem.raw.positions.len(),
        "triangles": problem.raw.triangles.len(),
        "components": graph.components(),
        "colors": graph.mesh_level().colors(),
        "levels": graph.levels.len(),
        "sweeps": sweeps,
        "energy": q.energy,
        "branches": q.branches,
        "odd_triangles": q.odd_triangles,
        "angle_over_5deg": q.angle_over_5deg,
        "angle_mean_deg": q.angle_mean_deg,
        "spacing_p50": q.spacing_p50,
        "spacing_p95": q.spacing_p95,
    }))
}

/// re, im per vertex of the file; each refers to the sign of the direction that the file gives.
fn phasor_bytes(problem: &Problem, graph: &SurfaceGraph, wave: &Wave) -> Vec<u8> {
    let given = match &problem.field {
        DirectionField::Tangents(given) if problem.symmetry == Symmetry::Line => Some(given),
        _ => None,
    };
    let phasor = |(i, &v): (usize, &u32)| {
        let (z, d) = (wave.phasors[v as usize], wave.directions[v as usize]);
        if given.is_some_and(|given| given[i].dot(d) < 0.0) {
            reversed(z)
        } else {
            z
        }
    };
    graph
        .vertex_of
        .iter()
        .enumerate()
        .map(phasor)
        .flat_map(|z| [z.x, z.y])
        .flat_map(f32::to_le_bytes)
        .collect()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(0.0)
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// How a wave moves from frame to frame: means over the frames after the first fifth.
struct Motion {
    phases: Vec<Vec<f32>>,
    energies: Vec<f64>,
}

impl Motion {
    fn figures(&self, areas: &[f32]) -> Value {
        let wrap = |angle: f32| angle - std::f32::consts::TAU * (angle / std::f32::consts::TAU).round();
        let frames = self.phases.len();
        let total: f64 = areas.iter().map(|&a| f64::from(a)).sum();
        let (mut change, mut jitter, mut pops, mut count) = (0.0, 0.0, 0.0, 0.0);
        for t in (frames / 5).max(2)..frames {
            let [before, last, now] = [&self.phases[t - 2], &self.phases[t - 1], &self.phases[t]];
            count += 1.0;
            for i in 0..now.len() {
                let (step, step_before) = (wrap(now[i] - last[i]), wrap(last[i] - before[i]));
                change += f64::from(step.abs()) / now.len() as f64;
                jitter += f64::from(wrap(step - step_before).abs()) / now.len() as f64;
                if step.abs() > std::f32::consts::FRAC_PI_4 {
                    pops += f64::from(areas[i]) / total;
                }
            }
        }
        let energies = &self.energies[(frames / 5).min(frames)..];
        let energy = energies.iter().sum::<f64>() / energies.len().max(1) as f64;
        let count = f64::max(count, 1.0);
        json!({ "energy": energy, "phase_change": change / count, "pops": pops / count, "jitter": jitter / count })
    }
}

/// The axis of a frame of `--warm`.
fn turned(field: &DirectionField, degrees: f32) -> DirectionField {
    match field {
        DirectionField::Axis(axis) => DirectionField::Axis(Quat::from_rotation_z(degrees.to_radians()) * *axis),
        other => other.clone(),
    }
}

fn on_cpu(args: &Args, problem: &Problem) -> Result<Value, String> {
    ComputeTaskPool::get_or_init(TaskPool::default);
    AsyncComputeTaskPool::get_or_init(TaskPool::default);
    let start = Instant::now();
    let graph = SurfaceGraph::from_triangles(&problem.raw.positions, &problem.raw.triangles, &WeldOptions::default())
        .map_err(|error| error.to_string())?;
    let graph_ms = milliseconds(start);
    let mesh = mesh_file::to_bevy_mesh(&problem.raw);
    let start = Instant::now();
    let field = |field: &DirectionField| {
        directions(field, problem.symmetry, 0.0, &graph, &mesh).map_err(|error| error.to_string())
    };
    let d = field(&problem.field)?;
    let field_ms = milliseconds(start);
    let f = vec![problem.frequency; graph.len()];

    let (mut cold, mut edge_times, mut sweep_times, mut warm_times) = (vec![], vec![], vec![], vec![]);
    let mut solution = None;
    for _ in 0..=args.repeat {
        let start = Instant::now();
        let solved = solve_cpu(&graph, &d, &f, problem.symmetry, &problem.settings);
        cold.push(milliseconds(start));
        let start = Instant::now();
        let (constants, sums) = edges(&graph, &d, &f, problem.symmetry);
        edge_times.push(milliseconds(start));
        let mut z = solved.phasors.clone();
        let soft = Relaxation::Soft {
            omega: problem.settings.omega,
            softness: problem.settings.softness,
        };
        let start = Instant::now();
        sweep(graph.mesh_level(), &constants, &sums, &mut z, soft);
        sweep_times.push(milliseconds(start));
        let start = Instant::now();
        follow_cpu(&graph, &d, &f, problem.symmetry, &problem.settings, &mut z);
        warm_times.push(milliseconds(start));
        solution = Some(solved);
    }
    let Some(solution) = solution else {
        return Err("nothing was solved".into());
    };
    let wave = Wave {
        directions: d,
        phasors: solution.phasors,
    };
    let mut figures = figures(args, problem, &graph, &wave, solution.sweeps)?;
    figures["adapter"] = json!(format!("CPU, {} threads", ComputeTaskPool::get().thread_num()));
    figures["device"] = json!("cpu");
    figures["bytes_per_vertex"] = json!(0);
    figures["ms"] = json!({
        "graph": graph_ms, "upload": 0.0, "field": field_ms, "edges": median(edge_times.split_off(1)),
        "cold": median(cold.split_off(1)), "sweep": median(sweep_times.split_off(1)),
        "warm3": median(warm_times.split_off(1)),
    });
    if let Some(frames) = args.warm {
        let (mut motion, mut z) = (
            Motion {
                phases: vec![],
                energies: vec![],
            },
            wave.phasors,
        );
        let mut last = wave.directions;
        for frame in 1..=frames {
            let mut d = field(&turned(&problem.field, args.turn * frame as f32))?;
            if problem.symmetry == Symmetry::Line {
                bevy_field_patterns::field::align_to_previous(&mut d, &last);
            }
            follow_cpu(&graph, &d, &f, problem.symmetry, &problem.settings, &mut z);
            motion
                .energies
                .push(quality(&graph, &d, &f, &z, problem.symmetry).energy);
            motion.phases.push(z.iter().map(|z| z.to_angle()).collect());
            last = d;
        }
        figures["warm"] = motion.figures(&graph.areas);
    }
    Ok(figures)
}

/// The plugin in an app of its own.
struct Gpu {
    app: App,
    entity: Entity,
    graph: Arc<SurfaceGraph>,
    graph_ms: f64,
    upload_ms: f64,
}

impl Gpu {
    fn new(problem: &Problem) -> Result<Self, String> {
        let start = Instant::now();
        SurfaceGraph::from_triangles(&problem.raw.positions, &problem.raw.triangles, &WeldOptions::default())
            .map_err(|error| error.to_string())?;
        let graph_ms = milliseconds(start);

        let mut app = headless::headless_app(UVec2::splat(16))?;
        app.add_plugins((FieldPatternsPlugin, RenderDiagnosticsPlugin))
            .insert_resource(problem.settings.clone())
            .insert_resource(QualityReport(false));
        let mesh = app
            .world_mut()
            .resource_mut::<Assets<Mesh>>()
            .add(mesh_file::to_bevy_mesh(&problem.raw));
        let pattern = (
            problem.field.clone(),
            problem.symmetry,
            Frequency::Uniform(problem.frequency),
        );
        // Pipelines first, so that the frame that solves is not the one that waits for them.
        headless::wait_until_ready(&mut app)?;
        let entity = app
            .world_mut()
            .spawn((Mesh3d(mesh), Transform::default(), pattern))
            .id();
        let mut gpu = Self {
            app,
            entity,
            graph: Arc::default(),
            graph_ms,
            upload_ms: 0.0,
        };
        let patience = Instant::now();
        loop {
            let start = Instant::now();
            gpu.frame()?;
            match gpu.app.world().get::<PatternState>(entity) {
                Some(PatternState::Converged) => break,
                Some(PatternState::Failed(error)) => return Err(error.to_string()),
                _ => gpu.upload_ms = milliseconds(start),
            }
            if patience.elapsed().as_secs() > 300 {
                return Err("the pattern was not solved within 300 s".into());
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        let world = gpu.app.world();
        let handle = world
            .get::<PatternMesh>(entity)
            .map(|meshes| meshes.graph.clone())
            .unwrap_or_default();
        let graph = world
            .resource::<Assets<SurfaceGraph>>()
            .get(&handle)
            .ok_or("the graph is gone")?;
        gpu.graph = Arc::new(graph.clone());
        Ok(gpu)
    }

    /// One frame of the app, until the device is idle.
    fn frame(&mut self) -> Result<f64, String> {
        let start = Instant::now();
        headless::update(&mut self.app)?;
        gpu::wait(&self.app);
        Ok(milliseconds(start))
    }

    fn wave(&self) -> Result<Wave, String> {
        let pattern = self
            .app
            .world()
            .get::<Pattern>(self.entity)
            .ok_or("the pattern is gone")?;
        let vertices = self.graph.len() as u64;
        let record = pattern.record();
        let read = |first: u32, len: u64| gpu::read::<f32>(&self.app, &WAVE_BUFFER, 8 * u64::from(first), 8 * len);
        let field = read(record.field_base, 2 * vertices)?;
        let phasors = read(record.phasor_base, vertices)?;
        Ok(Wave {
            directions: field.chunks_exact(4).map(|d| Vec3::new(d[0], d[1], d[2])).collect(),
            phasors: phasors.chunks_exact(2).map(|z| Vec2::new(z[0], z[1])).collect(),
        })
    }

    /// A frame that solves from nothing, and its GPU times by stage.
    fn cold(&mut self) -> Result<f64, String> {
        self.app.world_mut().trigger(RestartPattern { entity: self.entity });
        self.frame()
    }

    fn report(mut self, args: &Args, problem: &Problem) -> Result<Value, String> {
        self.cold()?;
        let cold: Result<Vec<f64>, String> = (0..args.repeat).map(|_| self.cold()).collect();
        let sweeps = self.app.world().resource::<SolverCounters>().sweeps();
        let hierarchy = gpu::stage_ms(&self.app, "pattern_hierarchy");
        let cold_sweeps = gpu::stage_ms(&self.app, "pattern_sweeps");
        let wave = self.wave()?;
        let sweeps = match args.method {
            MethodArg::Local if args.epsilon > 0.0 => self.local_sweeps()?,
            _ => sweeps,
        };
        let mut figures = figures(args, problem, &self.graph, &wave, sweeps)?;
        let memory = self.app.world().resource::<PatternArena>().memory();
        let render_world = self.app.sub_app(RenderApp).world();
        let adapter = render_world.resource::<RenderAdapterInfo>();
        figures["adapter"] = json!(adapter.name);
        figures["device"] = json!("gpu");
        figures["bytes_per_vertex"] = json!(memory.used as f64 / self.graph.len() as f64);
        figures["bytes_allocated_per_vertex"] = json!(memory.allocated as f64 / self.graph.len() as f64);
        if let Some(frames) = args.warm {
            let mut motion = Motion {
                phases: vec![],
                energies: vec![],
            };
            for frame in 1..=frames {
                self.follow(turned(&problem.field, args.turn * frame as f32))?;
                let wave = self.wave()?;
                let f = vec![problem.frequency; self.graph.len()];
                motion
                    .energies
                    .push(quality(&self.graph, &wave.directions, &f, &wave.phasors, problem.symmetry).energy);
                motion.phases.push(wave.phasors.iter().map(|z| z.to_angle()).collect());
            }
            figures["warm"] = motion.figures(&self.graph.areas);
        }
        // The field as it is, again and again: what a frame with a changed input costs.
        let warm: Result<Vec<f64>, String> = (0..=args.repeat).map(|_| self.follow(problem.field.clone())).collect();
        let stage = |name: &str| gpu::stage_ms(&self.app, name);
        let per_sweep = stage("pattern_sweeps").map(|ms| ms / f64::from(problem.settings.warm_sweeps));
        figures["ms"] = json!({
            "graph": self.graph_ms, "upload": self.upload_ms, "field": stage("pattern_field").unwrap_or(0.0),
            "edges": stage("pattern_edges"), "cold": median(cold?), "sweep": per_sweep,
            "hierarchy": hierarchy, "cold_sweeps": cold_sweeps, "warm3": median(warm?),
        });
        Ok(figures)
    }

    fn follow(&mut self, field: DirectionField) -> Result<f64, String> {
        self.app.world_mut().entity_mut(self.entity).insert(field);
        self.frame()
    }

    fn local_sweeps(&self) -> Result<u32, String> {
        let pattern = self
            .app
            .world()
            .get::<Pattern>(self.entity)
            .ok_or("the pattern is gone")?;
        // The sixth word of an entity's state counts the sweeps of the local rule.
        let offset = 4 * u64::from(pattern.record().state_base + 5);
        let words = gpu::read::<f32>(&self.app, &BALANCE_BUFFER, offset, 4)?;
        Ok(words.first().copied().unwrap_or(0.0) as u32)
    }
}
