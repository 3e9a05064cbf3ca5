//! Samples on a surface.
//!
//! In: a [`SurfaceGraph`] with a metric M per vertex. Out: [`SurfaceSamples`]: exactly as many samples as asked for, every
//! one on the surface, every one with a cell of its own. Kratz et al. 2013, section 5, and what improves on it.
//!
//! | step | file | what it does |
//! |---|---|---|
//! | 1 | `domain` | checks the metric, scales it to the count |
//! | 2 | `refine`, `mesh` | halves edges that are long in the metric |
//! | 3 | `darts` | the first set: darts in the metric, on the mesh |
//! | 4 | `labels`, `cells` | Lloyd's algorithm on the mesh's vertices and cut triangles |
//! | 5 | `result` | positions on the given triangles, labels of their corners, neighbours |
//!
//! Surfaces may have borders, several components, edges with many triangles and triangles without area. The result depends
//! on the input alone, bit by bit, not on the number of threads.

mod cells;
mod darts;
mod domain;
mod form;
mod labels;
mod mesh;
mod nearest;
mod quality;
mod refine;
mod result;
mod walk;

pub use domain::MAX_SAMPLES;
pub use quality::surface_quality;

use crate::{
    error::PatternError,
    sampling::{Density, Progress, SampleSet, SamplingTimes},
    surface::SurfaceGraph,
};
use bevy::{platform::time::Instant, prelude::*};
use domain::{Domain, Scale};
use glam_matrix_extras::SymmetricMat3;
use mesh::FineMesh;
use walk::Site;

/// How samples are placed on a surface.
#[derive(Reflect, Debug, Clone, Copy, Default, PartialEq, Eq)]
#[reflect(Default, Clone, PartialEq)]
pub enum SurfaceMethod {
    /// Darts, then Lloyd's algorithm on the vertices and cut triangles of the mesh. Knows nothing but the mesh's own
    /// adjacency, hence right on thin parts, borders and meshes of every kind.
    #[default]
    Labels,
}

/// What [`sample_surface`] is asked.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct SurfaceSampling {
    /// How many samples; 1,000 by default, [`MAX_SAMPLES`] at most.
    pub density: Density,
    /// How they are placed.
    pub method: SurfaceMethod,
    /// Relaxation steps, 10 by default. 0 leaves the first set as it is; beyond 50 little is gained.
    pub steps: u32,
    /// Two seeds make two sets; the same seed makes the same set.
    pub seed: u64,
}

impl Default for SurfaceSampling {
    fn default() -> Self {
        Self {
            density: default(),
            method: default(),
            steps: 10,
            seed: 0,
        }
    }
}

/// What [`sample_surface`] returns.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SurfaceSamples {
    /// The samples. Their triangles and seeds are those of the given graph, degenerate ones included.
    pub set: SampleSet,
    /// How long it took.
    pub times: SamplingTimes,
    /// How often edges were halved so that the mesh resolves the cells; 0 where it did.
    pub refined: u32,
    /// Vertices of the refined mesh.
    pub vertices: usize,
}

/// Halves edges longer than this before sampling, where touching samples are 2 apart.
const EDGE: f32 = 0.8;
/// The most vertices per sample that refinement makes.
const MAX_VERTICES: usize = 64;
/// How far a site goes towards the centroid of its cell, relative to Lloyd's algorithm.
const RELAXATION: f32 = 1.0;
/// Exchanges of labels after each step, and after the last one.
const SWEEPS: usize = 4;
const LAST_SWEEPS: usize = usize::MAX;

/// Samples on the surface of a graph, even in the metric that is given for each vertex of the graph (in solver order).
///
/// Exactly as many as [`Density::Count`] asks for. Every connected component gets at least one sample, the largest first.
/// A [`Density::FillRate`] is turned into the count that relaxed samples of this fill rate have, and the metric is taken
/// as it is.
///
/// # Errors
/// [`WrongLength`](PatternError::WrongLength), [`NotFinite`](PatternError::NotFinite) and
/// [`NotPositive`](PatternError::NotPositive) for bad metrics, [`OutOfRange`](PatternError::OutOfRange) for a count of 0 or
/// above [`MAX_SAMPLES`] and a fill rate that is not above 0, [`Cancelled`](PatternError::Cancelled).
pub fn sample_surface(
    graph: &SurfaceGraph,
    metrics: &[SymmetricMat3],
    options: &SurfaceSampling,
    progress: &Progress,
) -> Result<SurfaceSamples, PatternError> {
    let start = Instant::now();
    progress.report(0.0)?;
    let (mut domain, scale) = Domain::new(graph, metrics, options.density)?;
    let refined = refine::refine(&mut domain, std::env::var("EDGE").map_or(EDGE, |x| x.parse().unwrap()), MAX_VERTICES * scale.count + graph.len());
    progress.report(0.2)?;
    eprintln!("refined {}", milliseconds(start)); //DBG
    let Scale { count, .. } = scale;
    let (mesh, darts) = first_set(&mut domain, count, options.seed);
    progress.report(0.4)?;
    eprintln!("darts {}", milliseconds(start)); //DBG
    let mut sites: Vec<Site> = darts.vertices.iter().map(|&v| Site::at_vertex(&mesh, v)).collect();
    let mut labels = darts.labels;
    labels::exchange(&mesh, &sites, &mut labels, LAST_SWEEPS);
    let initial = milliseconds(start); let om: f32 = std::env::var("OM").map_or(RELAXATION, |x| x.parse().unwrap());
    for step in 0..options.steps {
        let t = Instant::now(); //DBG
        sites = cells::step(&mesh, &sites, &labels, om);
        let a = milliseconds(t); //DBG
        labels::claim(&mesh, &sites, &mut labels);
        let b = milliseconds(t); //DBG
        labels::exchange(&mesh, &sites, &mut labels, SWEEPS);
        eprintln!("step {a} claim {} exchange {}", b-a, milliseconds(t)-b); //DBG

        progress.report(0.4 + 0.5 * (step + 1) as f32 / options.steps as f32)?;
    }
    let relaxed = milliseconds(start);
    labels::exchange(&mesh, &sites, &mut labels, LAST_SWEEPS);
    labels::rescue(&mesh, &mut sites, &mut labels);
    let set = result::sample_set(graph, metrics, scale, &mesh, &sites, &labels);
    progress.report(1.0)?;
    Ok(SurfaceSamples {
        set,
        times: SamplingTimes {
            initial,
            per_step: (relaxed - initial) / options.steps.max(1) as f32,
            total: milliseconds(start),
        },
        refined,
        vertices: mesh.len(),
    })
}

/// Exactly `count` darts, on a mesh that is refined until it has room for them.
fn first_set(domain: &mut Domain, count: usize, seed: u64) -> (FineMesh, darts::Darts) {
    /// Each round has four times the vertices.
    const ROUNDS: usize = 12;
    let t = Instant::now(); //DBG
    let mut mesh = FineMesh::new(domain);
    eprintln!("finemesh {}", milliseconds(t)); //DBG
    let mut darts = darts::throw(&mesh, count, seed);
    for _ in 0..ROUNDS {
        if darts.vertices.len() >= count {
            break;
        }
        refine::subdivide(domain);
        mesh = FineMesh::new(domain);
        darts = darts::throw(&mesh, count, seed);
    }
    (mesh, darts)
}

fn milliseconds(since: Instant) -> f32 {
    since.elapsed().as_secs_f32() * 1e3
}
