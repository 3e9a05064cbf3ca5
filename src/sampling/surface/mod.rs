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
//! | 4 | `labels`, `cells`, `holes` | Lloyd's algorithm on the mesh's vertices and cut triangles |
//! | 5 | `result` | positions on the given triangles, labels of their corners, neighbours |
//!
//! `warm` goes on from an earlier result in place of step 3, for what changes in time; it can keep what step 2 made.
//!
//! Surfaces may have borders, several components, edges with many triangles and triangles without area. The result depends
//! on the input alone, bit by bit, not on the number of threads.

mod cells;
mod darts;
mod domain;
mod flips;
mod form;
mod holes;
mod labels;
mod mesh;
mod nearest;
mod paper;
mod qem;
mod quality;
mod refine;
mod relax;
mod result;
mod triangulation;
mod walk;
mod warm;

pub use domain::MAX_SAMPLES;
pub use quality::surface_quality;
pub use warm::{SurfaceRelaxer, relax_surface};

use crate::{
    error::PatternError,
    sampling::{Density, Progress, SampleSet, SamplingTimes},
    surface::SurfaceGraph,
};
use bevy::{platform::time::Instant, prelude::*};
use domain::{Domain, Scale};
use glam_matrix_extras::SymmetricMat3;
use mesh::{FineMesh, NONE};
use paper::Target;
use relax::Centroid;
use triangulation::Triangulation;
use walk::Site;

/// How samples are placed on a surface.
#[derive(Reflect, Debug, Clone, Copy, Default, PartialEq, Eq)]
#[reflect(Default, Clone, PartialEq)]
pub enum SurfaceMethod {
    /// Darts, then Lloyd's algorithm on the vertices and cut triangles of the mesh. Knows nothing but the mesh's own
    /// adjacency, hence right on thin parts, borders and meshes of every kind.
    #[default]
    Labels,
    /// Darts, triangles between them by simplification of the mesh, Lloyd's algorithm on the metric circumcentres of the
    /// triangles with edge flips, and a few steps of [`Labels`](Self::Labels). More even after the same number of steps.
    /// Needs the crate's feature `meshopt`.
    Triangulated,
    /// The paper's way: a coarse mesh by simplification, samples inserted by fill rate, edge flips, and relaxation to the
    /// centroids of the triangles around each sample. For comparison. Needs the crate's feature `meshopt`.
    Paper,
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
const EDGE: f32 = 1.4;
/// The least vertices per sample that refinement makes, if the cap allows.
const MIN_VERTICES: usize = 14;
/// The same for samples on a triangulation, which are even enough to tell the difference.
const FINE_EDGE: f32 = 1.2;
const MIN_FINE_VERTICES: usize = 16;
/// The most vertices per sample that refinement makes.
const MAX_VERTICES: usize = 64;
/// How far a site goes towards the centroid of its cell, relative to Lloyd's algorithm.
const RELAXATION: f32 = 1.6;
/// Exchanges of labels after each step, and after the last one.
const SWEEPS: usize = 4;
const LAST_SWEEPS: usize = usize::MAX;
/// Steps on labels after those on a triangulation, whose flat triangles cut ridges.
const POLISH: u32 = 16;
/// Steps on labels after which samples are put from where they are crowded into holes: the first of all steps, and of those
/// after a triangulation.
const FILLING: [u32; 2] = [2, 5];
const FILLING_POLISH: [u32; 3] = [2, 6, 10];
/// Of the steps after a triangulation the last ones, which go no farther than the centroid.
const LAST: u32 = 2;

/// Samples on the surface of a graph, even in the metric that is given for each vertex of the graph (in solver order).
///
/// Exactly as many as [`Density::Count`] asks for. Every connected component gets at least one sample, the largest first.
/// A [`Density::FillRate`] is turned into the count that relaxed samples of this fill rate have, and the metric is taken
/// as it is.
///
/// # Errors
/// [`WrongLength`](PatternError::WrongLength), [`NotFinite`](PatternError::NotFinite) and
/// [`NotPositive`](PatternError::NotPositive) for bad metrics, [`OutOfRange`](PatternError::OutOfRange) for a count of 0 or
/// above [`MAX_SAMPLES`], a fill rate that is not above 0 and radii that single precision has no 1/r² of, [`Cancelled`](PatternError::Cancelled).
pub fn sample_surface(
    graph: &SurfaceGraph,
    metrics: &[SymmetricMat3],
    options: &SurfaceSampling,
    progress: &Progress,
) -> Result<SurfaceSamples, PatternError> {
    let start = Instant::now();
    progress.report(0.0)?;
    let job = Job {
        graph,
        metrics,
        options,
        progress,
        start,
    };
    let (mut domain, scale, refined) = job.domain()?;
    let mut relaxed = match options.method {
        SurfaceMethod::Labels => job.labels(&mut domain, scale.count)?,
        SurfaceMethod::Triangulated => job.triangulated(&mut domain, scale.count)?,
        SurfaceMethod::Paper => job.paper(&mut domain, scale.count)?,
    };
    job.finish(&mut relaxed, scale, refined)
}

/// One call of [`sample_surface`] or [`relax_surface`].
struct Job<'a> {
    graph: &'a SurfaceGraph,
    metrics: &'a [SymmetricMat3],
    options: &'a SurfaceSampling,
    progress: &'a Progress,
    start: Instant,
}

/// Samples that were placed and relaxed.
struct Relaxed {
    mesh: FineMesh,
    sites: Vec<Site>,
    labels: Vec<u32>,
    /// Milliseconds to the first set, and of all steps.
    initial: f32,
    steps: f32,
}

impl Relaxed {
    fn fill_holes(&mut self) {
        holes::fill(&self.mesh, &mut self.sites, &mut self.labels);
    }

    fn close_holes(mut self) -> Self {
        labels::exchange(&self.mesh, &self.sites, &mut self.labels, LAST_SWEEPS);
        holes::close(&self.mesh, &mut self.sites, &mut self.labels);
        self
    }
}

impl Job<'_> {
    /// The refined domain, and how often it was refined.
    fn domain(&self) -> Result<(Domain, Scale, u32), PatternError> {
        let (mut domain, scale) = Domain::new(self.graph, self.metrics, self.options.density)?;
        let (edge, least) = match self.options.method {
            SurfaceMethod::Labels => (EDGE, MIN_VERTICES),
            SurfaceMethod::Triangulated | SurfaceMethod::Paper => (FINE_EDGE, MIN_FINE_VERTICES),
        };
        let most = MAX_VERTICES * scale.count + self.graph.len();
        let refined = refine::refine_to(&mut domain, edge, least * scale.count, most, self.progress)?;
        self.progress.report(0.2)?;
        Ok((domain, scale, refined))
    }

    fn labels(&self, domain: &mut Domain, count: usize) -> Result<Relaxed, PatternError> {
        let (mesh, darts) = first_set(domain, count, self.options.seed, self.progress)?;
        let sites = darts.vertices.iter().map(|&v| Site::at_vertex(&mesh, v)).collect();
        let relaxed = self.relax_labels(self.relaxed(mesh, sites, darts.labels), RELAXATION, true)?;
        Ok(if self.options.steps > 0 {
            relaxed.close_holes()
        } else {
            relaxed
        })
    }

    /// The steps on labels; whether samples may be put elsewhere.
    fn relax_labels(&self, mut relaxed: Relaxed, relaxation: f32, fills: bool) -> Result<Relaxed, PatternError> {
        labels::exchange(&relaxed.mesh, &relaxed.sites, &mut relaxed.labels, LAST_SWEEPS);
        relaxed.initial = milliseconds(self.start);
        self.report(0.0)?;
        for step in 0..self.options.steps {
            label_step(&mut relaxed, relaxation);
            if fills && FILLING.contains(&(step + 1)) {
                relaxed.fill_holes();
            }
            self.report_step(step)?;
        }
        relaxed.steps = milliseconds(self.start) - relaxed.initial;
        Ok(relaxed)
    }

    fn triangulated(&self, domain: &mut Domain, count: usize) -> Result<Relaxed, PatternError> {
        let (mesh, darts) = first_set(domain, count, self.options.seed, self.progress)?;
        self.report(0.0)?;
        let triangles = qem::triangles_between(&mesh, &darts.vertices)?;
        let sites = darts.vertices.iter().map(|&v| Site::at_vertex(&mesh, v)).collect();
        let mut samples = Triangulation::new(&mesh, sites, &triangles);
        samples.flip_all();
        let mut relaxed = self.relax(mesh, samples, Centroid::Kite)?;
        for step in 0..POLISH {
            let relaxation = if step < POLISH - LAST { RELAXATION } else { 1.0 };
            label_step(&mut relaxed, relaxation);
            if FILLING_POLISH.contains(&(step + 1)) {
                relaxed.fill_holes();
            }
            self.progress.report(0.9 + 0.1 * step as f32 / POLISH as f32)?;
        }
        Ok(relaxed.close_holes())
    }

    fn paper(&self, domain: &mut Domain, count: usize) -> Result<Relaxed, PatternError> {
        let target = match self.options.density {
            Density::Count(_) => Target::Count(count),
            Density::FillRate(rate) => Target::Fill(rate, MAX_SAMPLES as usize),
        };
        let (mesh, darts) = first_set(domain, count, self.options.seed, self.progress)?;
        let samples = paper::triangulation(&mesh, target, &darts.vertices, self.progress)?;
        let count = if let Target::Count(count) = target {
            count
        } else {
            samples.sites.len()
        };
        let mut relaxed = self.relax(mesh, samples, Centroid::Star)?;
        // Those that found no triangle go where the largest holes are.
        if let Some(&first) = relaxed.sites.first() {
            relaxed.sites.resize(count, first);
        }
        Ok(relaxed)
    }

    /// The steps on a triangulation; then its labels.
    fn relax(&self, mesh: FineMesh, mut samples: Triangulation, centroid: Centroid) -> Result<Relaxed, PatternError> {
        let initial = milliseconds(self.start);
        self.report(0.0)?;
        for step in 0..self.options.steps {
            relax::relax(&mesh, &mut samples, centroid);
            self.report_step(step)?;
        }
        let steps = milliseconds(self.start) - initial;
        let mut labels = vec![NONE; mesh.len()];
        labels::claim(&mesh, &samples.sites, &mut labels);
        labels::exchange(&mesh, &samples.sites, &mut labels, LAST_SWEEPS);
        let mut relaxed = self.relaxed(mesh, samples.sites, labels);
        (relaxed.initial, relaxed.steps) = (initial, steps);
        Ok(relaxed)
    }

    fn relaxed(&self, mesh: FineMesh, sites: Vec<Site>, labels: Vec<u32>) -> Relaxed {
        let (initial, steps) = (0.0, 0.0);
        Relaxed {
            mesh,
            sites,
            labels,
            initial,
            steps,
        }
    }

    /// The last labels, with a cell for every sample; and the result.
    fn finish(&self, relaxed: &mut Relaxed, scale: Scale, refined: u32) -> Result<SurfaceSamples, PatternError> {
        let Relaxed {
            mesh,
            sites,
            labels,
            initial,
            steps,
        } = relaxed;
        labels::exchange(mesh, sites, labels, LAST_SWEEPS);
        labels::rescue(mesh, sites, labels);
        let set = result::sample_set(self.graph, self.metrics, scale, mesh, sites, labels);
        set.check_radii()?;
        self.progress.report(1.0)?;
        Ok(SurfaceSamples {
            set,
            times: SamplingTimes {
                initial: *initial,
                per_step: *steps / self.options.steps.max(1) as f32,
                total: milliseconds(self.start),
            },
            refined,
            vertices: mesh.len(),
        })
    }

    fn report(&self, relaxed: f32) -> Result<(), PatternError> {
        self.progress.report(0.4 + 0.5 * relaxed)
    }

    fn report_step(&self, step: u32) -> Result<(), PatternError> {
        self.report((step + 1) as f32 / self.options.steps as f32)
    }
}

/// One step of Lloyd's algorithm on the labels.
fn label_step(
    Relaxed {
        mesh, sites, labels, ..
    }: &mut Relaxed,
    relaxation: f32,
) {
    *sites = cells::step(mesh, sites, labels, relaxation);
    labels::claim(mesh, sites, labels);
    labels::exchange(mesh, sites, labels, SWEEPS);
}

/// Exactly `count` darts, on a mesh that is refined until it has room for them.
fn first_set(
    domain: &mut Domain,
    count: usize,
    seed: u64,
    progress: &Progress,
) -> Result<(FineMesh, darts::Darts), PatternError> {
    /// Each round has four times the vertices.
    const ROUNDS: usize = 4;
    let mut mesh = FineMesh::new(domain);
    let mut darts = darts::throw(&mesh, count, seed, progress)?;
    for _ in 0..ROUNDS {
        if darts.vertices.len() >= count {
            break;
        }
        refine::subdivide(domain);
        mesh = FineMesh::new(domain);
        darts = darts::throw(&mesh, count, seed, progress)?;
    }
    Ok((mesh, darts))
}

fn milliseconds(since: Instant) -> f32 {
    since.elapsed().as_secs_f32() * 1e3
}
