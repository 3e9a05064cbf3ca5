//! Solves by the solver's twin, without an app.

use crate::{
    Args, Problem, median, mesh_file, milliseconds,
    report::{Motion, Wave, figures},
    turned,
};
use bevy::{
    prelude::*,
    tasks::{AsyncComputeTaskPool, ComputeTaskPool, TaskPool},
};
use bevy_field_patterns::{
    field::directions,
    prelude::*,
    surface::{SurfaceGraph, WeldOptions},
    wave::{
        quality,
        solver::{Relaxation, edges, follow_cpu, solve_cpu, sweep},
    },
};
use serde_json::{Value, json};
use std::time::Instant;

pub(crate) fn solve(args: &Args, problem: &Problem) -> Result<Value, String> {
    ComputeTaskPool::get_or_init(TaskPool::default);
    AsyncComputeTaskPool::get_or_init(TaskPool::default);
    let start = Instant::now();
    let graph = SurfaceGraph::from_triangles(&problem.raw.positions, &problem.raw.triangles, &WeldOptions::default())
        .map_err(|error| error.to_string())?;
    let graph_ms = milliseconds(start);
    let mesh = mesh_file::to_bevy_mesh(&problem.raw);
    let start = Instant::now();
    let field = |field: &DirectionField| {
        directions(field, problem.coupling.symmetry, 0.0, &graph, &mesh).map_err(|error| error.to_string())
    };
    let d = field(&problem.field)?;
    let field_ms = milliseconds(start);
    let f = vec![problem.frequency; graph.len()];

    let (mut cold, mut edge_times, mut sweep_times, mut warm_times) = (vec![], vec![], vec![], vec![]);
    let mut solution = None;
    for _ in 0..=args.repeat {
        let start = Instant::now();
        let solved = solve_cpu(&graph, &d, &f, problem.coupling, &problem.settings);
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
            if problem.coupling.symmetry == Symmetry::Line {
                bevy_field_patterns::field::align_to_previous(&mut d, &last);
            }
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
