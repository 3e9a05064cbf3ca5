//! Solves by the solver's twin, without an app.

use crate::{
    Args, Problem, median, mesh_file, milliseconds,
    report::{Motion, Wave, figures},
    turned, zoomed,
};
use bevy::{
    prelude::*,
    tasks::{AsyncComputeTaskPool, ComputeTaskPool, TaskPool},
};
use bevy_field_patterns::{
    field::directions,
    prelude::*,
    surface::{CloudOptions, SurfaceGraph},
    wave::{
        carry_wave, quality,
        solver::{Pins, Relaxation, edges, follow_cpu, solve_pinned, sweep},
    },
};
use serde_json::{Value, json};
use std::time::Instant;

pub(crate) fn solve(args: &Args, problem: &Problem) -> Result<Value, String> {
    ComputeTaskPool::get_or_init(TaskPool::default);
    AsyncComputeTaskPool::get_or_init(TaskPool::default);
    let start = Instant::now();
    let mesh_graph = || SurfaceGraph::from_triangles(&problem.raw.positions, &problem.raw.triangles, &default());
    let graph = if args.points {
        let neighbors = args.neighbors;
        let options = CloudOptions { neighbors, ..default() };
        SurfaceGraph::from_points(&problem.raw.positions, None, &default(), &options)
    } else {
        mesh_graph()
    };
    let graph = graph.map_err(|error| error.to_string())?;
    let graph_ms = milliseconds(start);
    let mesh = mesh_file::to_bevy_mesh(&problem.raw);
    let start = Instant::now();
    let field = |field: &DirectionField| {
        directions(field, problem.coupling.symmetry, 0.0, &graph, &mesh).map_err(|error| error.to_string())
    };
    let d = field(&problem.field)?;
    let field_ms = milliseconds(start);
    let f = vec![problem.frequency; graph.len()];

    let creases = match args.crease {
        Some(_) => graph.creases(CreasePhase::default().angle, false),
        None => Vec::new(),
    };
    let pins = Pins {
        vertices: &creases,
        pull: args.crease.unwrap_or(0.0),
    };
    let (mut cold, mut edge_times, mut sweep_times, mut warm_times) = (vec![], vec![], vec![], vec![]);
    let mut solution = None;
    for _ in 0..=args.repeat {
        let start = Instant::now();
        let solved = solve_pinned(&graph, &d, &f, problem.coupling, pins, &problem.settings);
        cold.push(milliseconds(start));
        let start = Instant::now();
        let (constants, sums) = edges(&graph, &d, &f, problem.coupling);
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
        follow_cpu(&graph, &d, &f, problem.coupling, &problem.settings, &mut z);
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
    let mut figures = if args.points {
        let onto = mesh_graph().map_err(|error| error.to_string())?;
        on_mesh(args, problem, (&graph, &wave), &onto, solution.sweeps)?
    } else {
        figures(args, problem, &graph, &wave, solution.sweeps)?
    };
    if !creases.is_empty() {
        figures["on_crest"] = json!(on_crest(&wave.phasors, problem.coupling.waves.count(), &creases));
    }
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
            if problem.coupling.symmetry == Symmetry::Line {
                bevy_field_patterns::field::align_to_previous(&mut d, &last);
            }
            let f = vec![zoomed(problem.frequency, args.zoom, frame); graph.len()];
            follow_cpu(&graph, &d, &f, problem.coupling, &problem.settings, &mut z);
            motion
                .energies
                .push(quality(&graph, &d, &f, &z, problem.coupling).energy);
            motion.phases.push(z.iter().map(|z| z.to_angle()).collect());
            last = d;
        }
        figures["warm"] = motion.figures(&graph.areas);
    }
    Ok(figures)
}

/// The figures of a wave on points, judged on the mesh between them: each vertex with its own point's phasor, and
/// (`carried`) with what all points near it predict.
fn on_mesh(
    args: &Args,
    problem: &Problem,
    (cloud, wave): (&SurfaceGraph, &Wave),
    onto: &SurfaceGraph,
    sweeps: u32,
) -> Result<Value, String> {
    if problem.coupling.waves.count() > 1 {
        return Err("--points is for one wave".into());
    }
    let point_of = |vertex: u32| cloud.vertex_of[vertex as usize] as usize;
    let first: Vec<usize> = onto.first_vertices().into_iter().map(point_of).collect();
    let own = Wave {
        directions: first.iter().map(|&i| wave.directions[i]).collect(),
        phasors: first.iter().map(|&i| wave.phasors[i]).collect(),
    };
    let mut figures = figures(args, problem, onto, &own, sweeps)?;
    let f = vec![problem.frequency; cloud.len()];
    let symmetry = problem.coupling.symmetry;
    let carried = carry_wave(cloud, &wave.directions, &f, &wave.phasors, symmetry, onto);
    let q = quality(
        onto,
        &carried.directions,
        &carried.frequencies,
        &carried.phasors,
        symmetry,
    );
    figures["carried"] = json!({ "energy": q.energy, "branches": q.branches });
    figures["colors"] = json!(cloud.mesh_level().colors());
    Ok(figures)
}

/// Share of the vertices on creases at which the first wave is within 0.1 periods of a crest.
fn on_crest(phasors: &[Vec2], waves: usize, creases: &[bool]) -> f64 {
    let near = |v: usize| phasors[waves * v].angle_to(Vec2::Y).abs() < 0.1 * std::f32::consts::TAU;
    let sharp: Vec<usize> = (0..creases.len()).filter(|&v| creases[v]).collect();
    sharp.iter().filter(|&&v| near(v)).count() as f64 / sharp.len().max(1) as f64
}
