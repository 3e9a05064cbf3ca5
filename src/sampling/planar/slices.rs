//! Samples that follow a metric which changes: the slices of a volume, an animated image, time.
//!
//! In: a set, and slice by slice another metric. Out: the set again, as many samples as before. Samples keep their
//! identity: they move a little, and where relaxation would have to carry them far, some are taken out of crowded regions
//! and others inserted into empty ones.
//!
//! How many: each free sample has a share of the metric area, 1 on average. Along a space-filling curve the excess 1 - share
//! is summed up; wherever the sum of some twenty neighbours passes 1, one of them goes, and wherever it passes -1, one
//! comes; the rest is carried on. So errors of density that are spread over many samples are mended as well as single
//! holes, and the count stays.

use super::{
    PlanarDomain, PlanarMetric, PlanarSamples, PlanarSampling,
    boundary::{Rail, insert_on_border},
    insertion::Inserter,
    metric::{ScaledMetric, dot},
    order::morton_order,
    random::Random,
    relaxation::Relaxer,
    sampler::{HEX_AREA, HEX_DISTANCE, Plan, Sampler},
    triangulation::{Place, Triangulation, Vertex},
};
use crate::{error::PatternError, sampling::Progress};
use bevy::{math::DVec2, platform::time::Instant};

/// Samples whose excess is summed up before it is acted on.
const NEIGHBORHOOD: usize = 10;
/// Border edges whose excess is summed up before it is acted on.
const BORDER_NEIGHBORHOOD: usize = 4;
/// Excess of border samples, above which one goes.
const BORDER_DEVIATION: f64 = 0.7;

/// What the last slice took.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SliceReport {
    /// Samples that have come.
    pub inserted: usize,
    /// Samples that have gone.
    pub removed: usize,
    /// Root mean square of the way of the samples that have stayed, in metric units; neighbours are about 2 apart.
    pub rms_move: f64,
    /// Wall time in milliseconds.
    pub ms: f32,
}

/// Samples of a planar domain that follow a changing metric.
pub struct SliceSampler {
    sampling: PlanarSampling,
    mesh: Triangulation,
    rails: Vec<Rail>,
    relaxer: Relaxer,
    random: Random,
    scale: f64,
    bounds_area: f64,
    count: usize,
    tracks: Vec<Track>,
    next_id: u64,
}

/// A sample through the slices.
#[derive(Clone, Copy)]
struct Track {
    id: u64,
    /// Where it was in the slice before; NaN for a new one.
    origin: DVec2,
}

/// What shall change before relaxation.
#[derive(Default)]
struct Changes {
    /// Border edges to be halved, by their ends, with their rail.
    split: Vec<([u32; 2], u32)>,
    /// Triangles to be divided.
    divide: Vec<u32>,
    remove: Vec<u32>,
}

impl SliceSampler {
    /// The first set: as [`sample_plane`](super::sample_plane).
    ///
    /// # Errors
    /// Those of [`sample_plane`](super::sample_plane), and [`OutOfRange`](PatternError::OutOfRange) where the samples are
    /// too few to keep the domain's corners.
    pub fn new(
        domain: &PlanarDomain,
        metric: &impl PlanarMetric,
        sampling: &PlanarSampling,
    ) -> Result<Self, PatternError> {
        let plan = Plan::new(domain, metric, sampling)?;
        let Some(parts) = &plan.parts else {
            return Err(PatternError::OutOfRange {
                what: "the number of samples of a slice",
                value: plan.count as f32,
                expected: "so many that the border takes less than 60 % of them",
            });
        };
        let mut sampler = plan.insert(parts, sampling)?;
        sampler.relax(sampling, &Progress::default())?;
        sampler.clean_up()?;
        sampler.exact = true;
        sampler.rescale();
        let (min, max) = domain.bounds();
        let mut slices = Self {
            sampling: sampling.clone(),
            scale: sampler.inserter.metric.scale,
            random: sampler.inserter.random,
            count: sampler.mesh.vertices.len(),
            rails: sampler.rails,
            relaxer: sampler.relaxer,
            mesh: sampler.mesh,
            bounds_area: (max - min).element_product(),
            tracks: Vec::new(),
            next_id: 0,
        };
        slices.name_new();
        Ok(slices)
    }

    /// Follows the metric of the next slice, with so many relaxation steps (3 to 5 do where slices resemble each other).
    /// The count stays as it was, also where the density was given as a fill rate.
    ///
    /// # Errors
    /// [`NotFinite`](PatternError::NotFinite) and [`NotPositive`](PatternError::NotPositive); the samples stay as they were
    /// then.
    pub fn advance(&mut self, metric: &impl PlanarMetric, steps: u32) -> Result<SliceReport, PatternError> {
        let start = Instant::now();
        let metric = ScaledMetric {
            metric,
            scale: self.scale,
        };
        let mut sampler = Sampler {
            mesh: self.mesh.clone(),
            inserter: Inserter::new(metric, self.random.clone(), self.bounds_area),
            rails: self.rails.clone(),
            relaxer: std::mem::take(&mut self.relaxer),
            exact: true,
        };
        let mut tracks = self.tracks.clone();
        for (track, vertex) in tracks.iter_mut().zip(&self.mesh.vertices) {
            track.origin = vertex.p;
        }
        adapt(&mut sampler, self.count, &mut tracks)?;
        for step in 1..=steps {
            sampler.step(&self.sampling)?;
            if step == steps / 2 {
                // Once more: in the first round the errors are too large to be measured well.
                adapt(&mut sampler, self.count, &mut tracks)?;
            }
        }
        sampler.untie(|kept| keep(&mut tracks, &kept))?;
        sampler.rescale();
        self.scale = sampler.inserter.metric.scale;
        self.random = sampler.inserter.random;
        self.relaxer = sampler.relaxer;
        self.mesh = sampler.mesh;
        let removed = self.tracks.len() - tracks.len();
        self.tracks = tracks;
        let inserted = self.name_new();
        Ok(SliceReport {
            inserted,
            removed,
            rms_move: self.rms_move(),
            ms: start.elapsed().as_secs_f32() * 1e3,
        })
    }

    /// The samples of the current slice.
    pub fn samples(&self) -> PlanarSamples {
        PlanarSamples::from_mesh(&self.mesh, self.scale)
    }

    /// A number for each sample, that it keeps from slice to slice; those of new samples are larger than all before.
    pub fn ids(&self) -> Vec<u64> {
        self.tracks.iter().map(|track| track.id).collect()
    }

    /// Numbers the vertices without a track; returns how many they were.
    fn name_new(&mut self) -> usize {
        let missing = self.mesh.vertices.len() - self.tracks.len();
        for _ in 0..missing {
            self.tracks.push(Track {
                id: self.next_id,
                origin: DVec2::NAN,
            });
            self.next_id += 1;
        }
        missing
    }

    fn rms_move(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0_u32);
        for (track, vertex) in self.tracks.iter().zip(&self.mesh.vertices) {
            let way = vertex.p - track.origin;
            if !way.is_nan() {
                sum += dot(&vertex.m, way, way);
                count += 1;
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }
}

/// Takes the new metric, and moves samples from where they are too many to where they are too few. Tracks go with the
/// vertices; those of new ones, at the end, are missing.
fn adapt(sampler: &mut Sampler, count: usize, tracks: &mut Vec<Track>) -> Result<(), PatternError> {
    let mesh = &mut sampler.mesh;
    for (index, vertex) in mesh.vertices.iter_mut().enumerate() {
        vertex.m = sampler.inserter.metric.at(vertex.p, index)?;
    }
    sampler.rescale();
    let mesh = &mut sampler.mesh;
    mesh.flip_violated();
    let mut changes = Changes::default();
    changes.on_border(mesh, &sampler.rails);
    changes.inside(mesh, count);

    for &(ends, rail) in &changes.split {
        halve(mesh, ends, rail, &sampler.rails, &sampler.inserter.metric)?;
    }
    for &t in &changes.divide {
        sampler.inserter.insert(mesh, t, |_, _| ())?;
    }
    if let Some(kept) = mesh.remove(&changes.remove) {
        keep(tracks, &kept);
    }
    mesh.flip_violated();
    sampler.inserter.exactly(mesh, count)
}

/// The tracks of the vertices that are left; those of new ones are missing.
fn keep(tracks: &mut Vec<Track>, kept: &[u32]) {
    let old = std::mem::take(tracks);
    tracks.extend(kept.iter().filter_map(|&v| old.get(v as usize)));
}

/// Inserts a border sample in the middle of a border edge.
fn halve(
    mesh: &mut Triangulation,
    ends: [u32; 2],
    rail: u32,
    rails: &[Rail],
    metric: &ScaledMetric,
) -> Result<(), PatternError> {
    let Some(side) = mesh.border(ends[0], ends[1]) else {
        return Ok(());
    };
    let straight = &rails[rail as usize];
    let p = straight.point(straight.part(mesh.vertex(ends[0]).p.midpoint(mesh.vertex(ends[1]).p)));
    let m = metric.at(p, mesh.vertices.len())?;
    insert_on_border(mesh, side, Vertex { p, m }, rail);
    Ok(())
}

impl Changes {
    /// Border samples: along each rail the excess of border edges goes, its lack is filled.
    fn on_border(&mut self, mesh: &Triangulation, rails: &[Rail]) {
        let mut edges: Vec<Vec<([u32; 2], f64)>> = vec![Vec::new(); rails.len()];
        let mut around = vec![0.0; mesh.vertices.len()];
        let mut on_border = 0.0;
        for side in mesh.borders() {
            let ends = mesh.ends(side);
            let [a, b] = ends.map(|v| mesh.vertex(v));
            let (m, rail) = ((a.m + b.m) * 0.5, rail_of(mesh, ends, rails));
            let (edge, length) = ([a.p, b.p], dot(&m, b.p - a.p, b.p - a.p).sqrt());
            let length = length * rails[rail].density(edge, &m, HEX_DISTANCE) / rails[rail].first(edge, &m);
            edges[rail].push((ends, length));
            ends.iter().for_each(|&v| around[v as usize] += length);
            on_border += 1.0;
        }
        let count = mesh.vertices.len() as f64;
        let spacing = HEX_DISTANCE * (count / (count - 0.5 * on_border)).sqrt();
        for (mut edges, rail) in edges.into_iter().zip(0..) {
            let along = |v: u32| rails[rail as usize].part(mesh.vertex(v).p);
            edges.sort_by(|a, b| along(a.0[0]).total_cmp(&along(b.0[0])));
            let mut excess = 0.0;
            for group in edges.chunks_mut(BORDER_NEIGHBORHOOD) {
                excess += group.iter().map(|edge| 1.0 - edge.1 / spacing).sum::<f64>();
                if excess < -BORDER_DEVIATION {
                    group.sort_by(|a, b| b.1.total_cmp(&a.1));
                    let splits = ((-excess).round() as usize).min(group.len());
                    self.split
                        .extend(group.iter().take(splits).map(|&(ends, _)| (ends, rail)));
                    excess += splits as f64;
                } else if excess > BORDER_DEVIATION {
                    let mut inner: Vec<u32> = group.iter().map(|edge| edge.0[0]).collect();
                    inner.retain(|&v| mesh.places[v as usize] == Place::Rail(rail));
                    inner.sort_by(|&a, &b| around[a as usize].total_cmp(&around[b as usize]));
                    inner.truncate(excess.round() as usize);
                    excess -= inner.len() as f64;
                    self.remove.extend(inner);
                }
            }
        }
    }

    /// Free samples: the excess of each neighbourhood goes, its lack is filled; the sum keeps the `count`.
    fn inside(&mut self, mesh: &Triangulation, count: usize) {
        let shares = Shares::new(mesh);
        let free: Vec<u32> = morton_order(&mesh.vertices)
            .into_iter()
            .filter(|&v| mesh.places[v as usize] == Place::Free)
            .collect();
        let by_share = |&a: &u32, &b: &u32| shares.area[a as usize].total_cmp(&shares.area[b as usize]);
        let mut excess = 0.0;
        for group in free.chunks(NEIGHBORHOOD) {
            let mut group = group.to_vec();
            group.sort_by(by_share);
            excess += group
                .iter()
                .map(|&v| 1.0 - shares.area[v as usize] / shares.mean)
                .sum::<f64>();
            let whole = excess.trunc().clamp(-(group.len() as f64), group.len() as f64);
            excess -= whole;
            let number = whole.abs() as usize;
            if whole > 0.0 {
                self.remove.extend(group.iter().take(number));
            } else {
                self.divide
                    .extend(group.iter().rev().take(number).map(|&v| shares.largest[v as usize]));
            }
        }
        self.divide.sort_unstable();
        self.divide.dedup();
        // What is left over is taken from the most crowded.
        let after = mesh.vertices.len() + self.split.len() + self.divide.len();
        let surplus = after.saturating_sub(count).saturating_sub(self.remove.len());
        if surplus > 0 {
            let gone: std::collections::HashSet<u32> = self.remove.iter().copied().collect();
            let mut others: Vec<u32> = free.into_iter().filter(|v| !gone.contains(v)).collect();
            others.sort_by(by_share);
            self.remove.extend(others.iter().take(surplus));
        }
    }
}

/// The metric area that belongs to each vertex: a third of its triangles.
struct Shares {
    area: Vec<f64>,
    /// The largest triangle of each vertex.
    largest: Vec<u32>,
    /// Mean area of the free vertices.
    mean: f64,
}

impl Shares {
    fn new(mesh: &Triangulation) -> Self {
        let mut area = vec![0.0; mesh.vertices.len()];
        let mut largest = vec![(0.0, 0); mesh.vertices.len()];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let triangle_area = mesh.metric_area(t);
            for v in triangle.v {
                area[v as usize] += triangle_area / 3.0;
                if triangle_area > largest[v as usize].0 {
                    largest[v as usize] = (triangle_area, t as u32);
                }
            }
        }
        let free = area
            .iter()
            .zip(&mesh.places)
            .filter(|(_, place)| **place == Place::Free);
        let (sum, count) = free.fold((0.0, 0_u32), |(sum, count), (area, _)| (sum + area, count + 1));
        Self {
            area,
            largest: largest.into_iter().map(|(_, t)| t).collect(),
            mean: if sum > 0.0 { sum / f64::from(count) } else { HEX_AREA },
        }
    }
}

/// The rail that a border edge lies on.
fn rail_of(mesh: &Triangulation, ends: [u32; 2], rails: &[Rail]) -> usize {
    for v in ends {
        if let Place::Rail(r) = mesh.places[v as usize] {
            return r as usize;
        }
    }
    // Between two corners: the rail that begins at the first.
    let start = mesh.vertex(ends[0]).p;
    rails.iter().position(|rail| rail.start == start).unwrap_or(0)
}
