//! The figures of a solved wave.
//!
//! In: a wave, and the phases of the frames that followed. Out: JSON, and the file of phasors.

use crate::{Args, MethodArg, Problem};
use bevy::prelude::*;
use bevy_field_patterns::{
    prelude::*,
    surface::SurfaceGraph,
    wave::{kite::reversed, quality},
};
use serde_json::{Value, json};

/// A solved wave in solver order.
pub(crate) struct Wave {
    pub(crate) directions: Vec<Vec3>,
    pub(crate) phasors: Vec<Vec2>,
}

/// The figures that do not depend on where the wave was solved.
pub(crate) fn figures(
    args: &Args,
    problem: &Problem,
    graph: &SurfaceGraph,
    wave: &Wave,
    sweeps: u32,
) -> Result<Value, String> {
    if let Some(path) = &args.phasors {
        std::fs::write(path, phasor_bytes(problem, graph, wave))
            .map_err(|error| format!("{}: {error}", path.display()))?;
    }
    let frequencies = vec![problem.frequency; graph.len()];
    let q = quality(graph, &wave.directions, &frequencies, &wave.phasors, problem.coupling);
    Ok(json!({
        "method": match args.method { MethodArg::Hierarchy => "hierarchy", MethodArg::Local => "local", MethodArg::Merged => "merged" },
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

/// re, im per vertex of the file and wave; each refers to the sign of the direction that the file gives.
fn phasor_bytes(problem: &Problem, graph: &SurfaceGraph, wave: &Wave) -> Vec<u8> {
    let given = match &problem.field {
        // Only a line's sign may have been chosen otherwise.
        DirectionField::Tangents(given) if problem.coupling.symmetry == Symmetry::Line => Some(given),
        _ => None,
    };
    let waves = problem.coupling.waves.count();
    let phasors = |(i, &v): (usize, &u32)| {
        let v = v as usize;
        let reverse = given.is_some_and(|given| given[i].dot(wave.directions[v]) < 0.0);
        let own = &wave.phasors[waves * v..waves * (v + 1)];
        own.iter().map(move |&z| if reverse { reversed(z) } else { z })
    };
    graph
        .vertex_of
        .iter()
        .enumerate()
        .flat_map(phasors)
        .flat_map(|z| [z.x, z.y])
        .flat_map(f32::to_le_bytes)
        .collect()
}

/// How a wave moves from frame to frame: means over the frames after the first fifth.
pub(crate) struct Motion {
    pub(crate) phases: Vec<Vec<f32>>,
    pub(crate) energies: Vec<f64>,
}

impl Motion {
    pub(crate) fn figures(&self, areas: &[f32]) -> Value {
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
                    let waves = now.len() / areas.len();
                    pops += f64::from(areas[i / waves]) / total / waves as f64;
                }
            }
        }
        let energies = &self.energies[(frames / 5).min(frames)..];
        let energy = energies.iter().sum::<f64>() / energies.len().max(1) as f64;
        let count = f64::max(count, 1.0);
        json!({ "energy": energy, "phase_change": change / count, "pops": pops / count, "jitter": jitter / count })
    }
}
