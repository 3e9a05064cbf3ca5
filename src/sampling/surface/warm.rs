//! Relaxation that goes on from an earlier set, for metrics and positions that change in time.
//!
//! In: a graph with its metric, and samples of a graph with the same triangles. Out: [`SurfaceSamples`] with the same samples,
//! moved no farther than the change asks for: they begin at their barycentric coordinates, their cells grow from there, and
//! Lloyd's algorithm goes on. Where another number is wanted, the most crowded samples go, or new ones come into the
//! largest holes.

use super::{
    Job, SurfaceMethod, SurfaceSamples, SurfaceSampling,
    domain::{Domain, Scale, with_area},
    form, labels,
    mesh::{FineMesh, NONE},
    quality, result,
    walk::{Site, closest_weights},
};
use crate::{
    error::PatternError,
    sampling::{Progress, SampleSet},
    surface::{SurfaceGraph, order::group},
};
use bevy::{platform::time::Instant, prelude::*};
use glam_matrix_extras::SymmetricMat3;

/// How far a site goes towards the centroid of its cell: no farther, so that samples at rest stay there.
const RELAXATION: f32 = 1.0;

/// Samples on a surface that were relaxed before, relaxed again after a change of the metric (one per vertex, in solver
/// order), of the positions or of the wanted number.
///
/// `from` is a set of [`sample_surface`](super::sample_surface) or of this function, on a graph with the same triangles. Only
/// its triangles and barycentric coordinates matter, so that it may be of other positions. Sample i of the result is sample
/// i of `from`. Where fewer are wanted, those that stay keep their order; where more, the new ones are the last.
///
/// Of the `options` the density and the steps matter; 1 to 5 steps are enough for small changes. It is always done by
/// [`SurfaceMethod::Labels`]. Where it is done again and again, [`SurfaceRelaxer`] is faster.
///
/// # Errors
/// Those of [`sample_surface`](super::sample_surface); [`SampleLists`](PatternError::SampleLists),
/// [`WrongLength`](PatternError::WrongLength), [`IndexOutOfRange`](PatternError::IndexOutOfRange) and
/// [`NotFinite`](PatternError::NotFinite) where `from` is no set on this graph, [`OutOfRange`](PatternError::OutOfRange) where
/// it is empty.
pub fn relax_surface(
    graph: &SurfaceGraph,
    metrics: &[SymmetricMat3],
    from: &SampleSet,
    options: &SurfaceSampling,
    progress: &Progress,
) -> Result<SurfaceSamples, PatternError> {
    SurfaceRelaxer::default().relax(graph, metrics, from, options, progress)
}

/// [`relax_surface`] again and again: keeps the refined mesh, about 4 kB per sample, as long as the graph's triangles and the
/// number of samples stay and few edges have become too long in the metric.
#[derive(Debug, Default)]
pub struct SurfaceRelaxer {
    kept: Option<Ground>,
}

/// The refined mesh of a graph.
#[derive(Debug)]
struct Ground {
    triangles: Vec<[u32; 3]>,
    with_area: Vec<bool>,
    count: usize,
    domain: Domain,
    mesh: FineMesh,
    refined: u32,
}

/// Metric length of an edge that should be halved, where touching samples are 2 apart, and the share of triangles that may
/// have one.
const LONG: f32 = 2.0;
const SHARE: f32 = 0.01;

impl SurfaceRelaxer {
    /// Does what [`relax_surface`] does.
    ///
    /// # Errors
    /// Those of [`relax_surface`].
    pub fn relax(
        &mut self,
        graph: &SurfaceGraph,
        metrics: &[SymmetricMat3],
        from: &SampleSet,
        options: &SurfaceSampling,
        progress: &Progress,
    ) -> Result<SurfaceSamples, PatternError> {
        let start = Instant::now();
        progress.report(0.0)?;
        check(graph, from)?;
        let job = Job {
            graph,
            metrics,
            options: &SurfaceSampling {
                method: SurfaceMethod::Labels,
                ..*options
            },
            progress,
            start,
        };
        let (mut ground, scale) = self.ground(&job)?;
        let mesh = std::mem::take(&mut ground.mesh);
        let mut sites = located(&mesh, graph, &from.triangles, |i| from.barycentrics[i]);
        let mut labels = grown(&mesh, &sites);
        while sites.len() > scale.count {
            progress.check()?;
            thin(&mesh, &mut sites, &labels, scale.count);
            labels = grown(&mesh, &sites);
        }
        // New ones, and those that lost their place to another one, have no cell yet: they go where the largest holes are.
        sites.resize(scale.count, sites[0]);
        labels::rescue(&mesh, &mut sites, &mut labels);
        let mut relaxed = job.relax_labels(job.relaxed(mesh, sites, labels), RELAXATION, false)?;
        let samples = job.finish(&mut relaxed, scale, ground.refined)?;
        ground.mesh = relaxed.mesh;
        self.kept = Some(ground);
        Ok(samples)
    }

    /// What was kept, with the positions and metrics of the job, or else what is made anew.
    fn ground(&mut self, job: &Job) -> Result<(Ground, Scale), PatternError> {
        let with_area = with_area(job.graph);
        if let Some(mut ground) = self.kept.take()
            && ground.triangles == job.graph.triangles
            && ground.with_area == with_area
        {
            let scale = ground.domain.place(job.graph, job.metrics, job.options.density)?;
            if scale.count == ground.count && ground.domain.share_of_long(LONG) <= SHARE {
                ground.mesh.place(&ground.domain);
                return Ok((ground, scale));
            }
        }
        let (domain, scale, refined) = job.domain()?;
        let ground = Ground {
            triangles: job.graph.triangles.clone(),
            with_area,
            count: scale.count,
            mesh: FineMesh::new(&domain),
            domain,
            refined,
        };
        Ok((ground, scale))
    }
}

/// A set fits a graph with as many triangles.
fn check(graph: &SurfaceGraph, from: &SampleSet) -> Result<(), PatternError> {
    quality::check(graph, from)?;
    let lists = [
        ("seeds of triangles", from.seeds.len(), graph.triangles.len()),
        ("barycentrics", from.barycentrics.len(), from.len()),
    ];
    if let Some(&(what, found, expected)) = lists.iter().find(|(_, found, expected)| found != expected) {
        return Err(PatternError::SampleLists { what, found, expected });
    }
    match from.barycentrics.iter().position(|weights| !weights.is_finite()) {
        Some(index) => Err(PatternError::NotFinite {
            what: "barycentrics of sample",
            index,
        }),
        None => Ok(()),
    }
}

/// The sites at points of the graph's triangles: each in the nearest part of its triangle.
pub(super) fn located(
    mesh: &FineMesh,
    graph: &SurfaceGraph,
    triangles: &[u32],
    weights: impl Fn(usize) -> Vec3,
) -> Vec<Site> {
    let (offsets, parts) = group(&mesh.sources, graph.triangles.len());
    let site = |i: usize| {
        let source = triangles[i] as usize;
        let (corners, weights) = (graph.triangles[source].map(|v| mesh.vertex_of[v as usize]), weights(i));
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        let position = a * weights.x + b * weights.y + c * weights.z;
        // A triangle without area has no parts; those around its corners are next to it.
        let own = &parts[offsets[source] as usize..offsets[source + 1] as usize];
        let around = corners.iter().flat_map(|&v| mesh.faces(v as usize));
        own.iter()
            .chain(around.filter(|_| own.is_empty()))
            .map(|&t| Site::new(mesh, t, closest_weights(position, mesh.corners(t as usize))))
            .min_by(|a, b| {
                let square = |s: &Site| s.position.distance_squared(position);
                square(a).total_cmp(&square(b))
            })
            .unwrap_or_else(|| Site::at_vertex(mesh, mesh.triangles[0][0]))
    };
    (0..triangles.len()).map(site).collect()
}

/// Cells that grow from the sites until they meet.
fn grown(mesh: &FineMesh, sites: &[Site]) -> Vec<u32> {
    let mut labels = vec![NONE; mesh.len()];
    labels::claim(mesh, sites, &mut labels);
    labels::exchange(mesh, sites, &mut labels, usize::MAX);
    labels
}

/// Removes the most crowded sites, of neighbours one only, until there are no more than `count`.
fn thin(mesh: &FineMesh, sites: &mut Vec<Site>, labels: &[u32], count: usize) {
    let (offsets, neighbors) = result::neighbors(mesh, labels, sites.len());
    let ring = |i: usize| &neighbors[offsets[i] as usize..offsets[i + 1] as usize];
    let room = |i: usize| {
        let square = |j: u32| {
            let (a, b) = (&sites[i], &sites[j as usize]);
            form::square(&form::middle(&a.metric, &b.metric), b.position - a.position)
        };
        ring(i).iter().map(|&j| square(j)).fold(f32::INFINITY, f32::min)
    };
    let empty = labels::empty_cells(sites.len(), labels);
    let mut rooms: Vec<f32> = (0..sites.len()).map(room).collect();
    empty.into_iter().for_each(|i| rooms[i as usize] = 0.0);
    let mut order: Vec<usize> = (0..sites.len()).collect();
    order.sort_by(|&a, &b| rooms[a].total_cmp(&rooms[b]).then(b.cmp(&a)));
    let (mut left, mut stays, mut goes) = (sites.len(), vec![false; sites.len()], vec![false; sites.len()]);
    for i in order {
        if left > count && !stays[i] {
            (goes[i], left) = (true, left - 1);
            ring(i).iter().for_each(|&j| stays[j as usize] = true);
        }
    }
    let mut goes = goes.into_iter();
    sites.retain(|_| !goes.next().unwrap_or_default());
}
