//! Solves by the plugin, in an app without window or camera.

use crate::{
    Args, MethodArg, Problem,
    common::{gpu, headless, mesh_file},
    median, milliseconds,
    report::{Motion, Wave, figures},
    turned, zoomed,
};
use bevy::{
    prelude::*,
    render::{RenderApp, diagnostic::RenderDiagnosticsPlugin, renderer::RenderAdapterInfo},
};
use bevy_field_patterns::{
    diagnostics::QualityReport,
    prelude::*,
    surface::{SurfaceGraph, WeldOptions},
    wave::{
        Pattern, PatternArena, SolverCounters,
        layout::{BALANCE_BUFFER, WAVE_BUFFER},
        quality,
    },
};
use serde_json::{Value, json};
use std::{sync::Arc, time::Instant};

/// The plugin in an app of its own.
pub(crate) struct Gpu {
    app: App,
    entity: Entity,
    graph: Arc<SurfaceGraph>,
    graph_ms: f64,
    upload_ms: f64,
}

impl Gpu {
    pub(crate) fn new(problem: &Problem) -> Result<Self, String> {
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
            problem.coupling.symmetry,
            problem.coupling.waves,
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
        let phasors = read(record.phasor_base, u64::from(record.waves) * vertices)?;
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

    pub(crate) fn report(mut self, args: &Args, problem: &Problem) -> Result<Value, String> {
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
                let frequency = zoomed(problem.frequency, args.zoom, frame);
                self.follow(turned(&problem.field, args.turn * frame as f32), frequency)?;
                let wave = self.wave()?;
                let f = vec![frequency; self.graph.len()];
                motion
                    .energies
                    .push(quality(&self.graph, &wave.directions, &f, &wave.phasors, problem.coupling).energy);
                motion.phases.push(wave.phasors.iter().map(|z| z.to_angle()).collect());
            }
            figures["warm"] = motion.figures(&self.graph.areas);
        }
        // What a frame with a changed input costs. The same axis again would be no change.
        let field = |n: u32| turned(&problem.field, 1e-3 * (n + 1) as f32);
        let mut follow = |n| self.follow(field(n), problem.frequency);
        let warm: Result<Vec<f64>, String> = (0..=args.repeat).map(&mut follow).collect();
        let stage = |name: &str| gpu::stage_ms(&self.app, name);
        let per_sweep = stage("pattern_sweeps").map(|ms| ms / f64::from(problem.settings.warm_sweeps));
        figures["ms"] = json!({
            "graph": self.graph_ms, "upload": self.upload_ms, "field": stage("pattern_field").unwrap_or(0.0),
            "edges": stage("pattern_edges"), "cold": median(cold?), "sweep": per_sweep,
            "hierarchy": hierarchy, "cold_sweeps": cold_sweeps, "warm3": median(warm?),
        });
        Ok(figures)
    }

    fn follow(&mut self, field: DirectionField, frequency: f32) -> Result<f64, String> {
        let inputs = (field, Frequency::Uniform(frequency));
        self.app.world_mut().entity_mut(self.entity).insert(inputs);
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
