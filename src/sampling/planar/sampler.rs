//! From a domain and a metric to samples: the steps in their order.

use super::{
    Insertion, PlanarDomain, PlanarMetric, PlanarSamples, PlanarSampling, Relaxation,
    boundary::{Lengths, Rail},
    domain::Ground,
    few::few_samples,
    insertion::Inserter,
    metric::ScaledMetric,
    random::Random,
    relaxation::Relaxer,
    triangulation::{Triangulation, Vertex},
};
use crate::{
    error::PatternError,
    sampling::{Density, Progress, SamplingTimes},
};
use bevy::{math::DVec2, platform::time::Instant};

/// Metric area of the cell of one sample in a hexagonal packing of touching unit balls.
pub(super) const HEX_AREA: f64 = 3.464_101_615_137_754_6;
/// Distance of neighbours in that packing.
pub(super) const HEX_DISTANCE: f64 = 2.0;
/// Samples that anybody may ask for.
const MOST: f64 = 16_777_216.0;
/// Where the border takes more than this part of the samples, they are too few for a triangulation.
const MOST_ON_BORDER: f64 = 0.6;
/// Look-ups that measure the domain before there are samples.
const LOOKUPS: f64 = 8192.0;
/// Samples nearer than this to a neighbour are put elsewhere.
const CROWDED: f64 = 0.5 * HEX_DISTANCE;
/// How often that is tried.
const CLEANUPS: u32 = 4;
/// How often knots of flips are looked for: a sample that was put elsewhere may tie another one.
const UNTYINGS: u32 = 16;
/// After these steps of relaxation holes are filled, where so many steps follow.
const HOLE_STEPS: [u32; 3] = [2, 4, 6];
const REST: u32 = 4;
/// Vertices, above which they are reordered during insertion.
const REORDER: usize = 8192;

/// Samples a planar domain in a metric.
///
/// The samples are as many as asked for, to the last one; the corners of the domain are among them unless the border alone
/// would take most of the count (a square with fewer than about 30). With the same input the result is the same, bit by
/// bit, on every machine with the same rounding.
///
/// # Errors
/// [`Domain`](PatternError::Domain) for a bad domain, [`OutOfRange`](PatternError::OutOfRange) for a bad option,
/// [`NotFinite`](PatternError::NotFinite) and [`NotPositive`](PatternError::NotPositive) where a metric is met that is none,
/// [`Cancelled`](PatternError::Cancelled) by `progress`.
pub fn sample_plane(
    domain: &PlanarDomain,
    metric: &impl PlanarMetric,
    sampling: &PlanarSampling,
    progress: &Progress,
) -> Result<PlanarSamples, PatternError> {
    let start = Instant::now();
    let plan = Plan::new(domain, metric, sampling)?;
    let Some(parts) = &plan.parts else {
        return few_samples(domain, &plan, sampling, progress, start);
    };
    let mut sampler = plan.insert(parts, sampling)?;
    let initial = start.elapsed();
    let (steps, rms_move) = sampler.relax(sampling, progress)?;
    let per_step = (start.elapsed() - initial).as_secs_f32() * 1e3 / steps.max(1) as f32;
    sampler.clean_up()?;
    sampler.rescale();
    progress.report(1.0)?;
    let mut samples = PlanarSamples::from_mesh(&sampler.mesh, sampler.inserter.metric.scale);
    samples.steps = steps;
    samples.rms_move = rms_move;
    samples.times = SamplingTimes {
        initial: initial.as_secs_f32() * 1e3,
        per_step,
        total: start.elapsed().as_secs_f32() * 1e3,
    };
    Ok(samples)
}

/// What is known before the first sample.
pub(super) struct Plan<'a> {
    pub(super) ground: Ground,
    pub(super) metric: ScaledMetric<'a>,
    /// How many samples there shall be, or are expected.
    pub(super) count: usize,
    /// Triangles of a larger metric area are divided: the fill rate asked for, if any.
    largest: Option<f64>,
    lengths: Lengths,
    /// Parts of each rail; none where the samples are too few for the border.
    pub(super) parts: Option<Vec<u32>>,
    /// Euclidean area of the domain's bounds.
    bounds_area: f64,
}

impl<'a> Plan<'a> {
    pub(super) fn new(
        domain: &PlanarDomain,
        metric: &'a dyn PlanarMetric,
        sampling: &PlanarSampling,
    ) -> Result<Self, PatternError> {
        sampling.check()?;
        let ground = domain.ground()?;
        let mut metric = ScaledMetric { metric, scale: 1.0 };
        let area = ground.metric_area(&metric, LOOKUPS)?;
        let (count, largest) = match sampling.density {
            Density::Count(count) => {
                metric.scale = f64::from(count) * HEX_AREA / area;
                (f64::from(count), None)
            }
            Density::FillRate(rate) => {
                let rate = f64::from(rate);
                // Triangles are halves and thirds of those above the limit: the mean is 1.7 times the rate.
                (area / HEX_AREA * rate / 0.55, Some(std::f64::consts::FRAC_PI_2 / rate))
            }
        };
        if count.is_nan() || count > MOST {
            return Err(PatternError::OutOfRange {
                what: "the number of samples",
                value: count as f32,
                expected: "1..=16777216",
            });
        }
        let cell = largest.map_or(1.0, |_| area / HEX_AREA / count);
        let lengths = Lengths::new(ground.rails(), &metric, HEX_DISTANCE * cell.sqrt())?;
        let parts = border_parts(&lengths, count, cell);
        let (min, max) = domain.bounds();
        Ok(Self {
            parts,
            ground,
            metric,
            count: (count.round() as usize).max(1),
            largest,
            lengths,
            bounds_area: (max - min).element_product(),
        })
    }

    /// The corners of the domain, as vertices of its triangulation.
    pub(super) fn corners(&self) -> Result<Triangulation, PatternError> {
        let vertex = |(index, &p): (usize, &DVec2)| {
            let m = self.metric.at(p, index)?;
            Ok(Vertex { p, m })
        };
        let vertices: Result<_, PatternError> = self.ground.points.iter().enumerate().map(vertex).collect();
        Ok(Triangulation::new(vertices?, &self.ground.triangles))
    }

    pub(super) fn inserter(&self, seed: u64) -> Inserter<'a> {
        Inserter::new(self.metric, Random(seed), self.bounds_area)
    }

    /// Inserts the samples, those of the border first.
    pub(super) fn insert(&self, parts: &[u32], sampling: &PlanarSampling) -> Result<Sampler<'a>, PatternError> {
        let mut inserter = self.inserter(sampling.seed);
        let mut mesh = self.corners()?;
        mesh.reserve(self.count);
        mesh.flip_violated();
        self.lengths
            .insert(&mut mesh, &self.ground, parts, &self.metric, &mut inserter.random)?;
        let exact = self.largest.is_none();
        let cap = if exact { self.count } else { 4 * self.count + 1024 };
        match sampling.insertion {
            Insertion::LargestFirst => {
                // In stages, so that neighbours stay near each other in memory.
                for stage in [cap / 8, cap / 4, cap / 2] {
                    if exact && stage > REORDER.max(mesh.vertices.len()) {
                        inserter.exactly(&mut mesh, stage)?;
                        mesh.reorder();
                    }
                }
                if let Some(largest) = self.largest {
                    inserter.largest_first(&mut mesh, largest, cap)?;
                }
            }
            Insertion::Fifo => {
                // A hexagonal packing would have half of this area: FIFO alone does not reach the count.
                let largest = self.largest.unwrap_or(HEX_AREA);
                inserter.fifo(&mut mesh, largest, cap)?;
            }
        }
        if exact {
            inserter.exactly(&mut mesh, self.count)?;
        }
        mesh.reorder();
        let mut sampler = Sampler {
            exact,
            mesh,
            inserter,
            rails: self.ground.rails(),
            relaxer: Relaxer::default(),
        };
        sampler.rescale();
        Ok(sampler)
    }
}

/// The number of parts of each rail for `count` samples of `density` times the area of a hexagonal cell each.
fn border_parts(lengths: &Lengths, count: f64, area: f64) -> Option<Vec<u32>> {
    let mut on_border = 0.0;
    let mut parts = Vec::new();
    for _ in 0..3 {
        // A sample on the border has half a cell.
        let cell = area * count / (count - 0.5 * on_border);
        parts = lengths.parts(HEX_DISTANCE * cell.sqrt());
        on_border = parts.iter().map(|&n| f64::from(n)).sum();
        if on_border.is_nan() || on_border > MOST_ON_BORDER * count {
            return None;
        }
    }
    Some(parts)
}

/// A triangulation of samples, and all that moves them.
pub(super) struct Sampler<'a> {
    pub(super) mesh: Triangulation,
    pub(super) inserter: Inserter<'a>,
    pub(super) rails: Vec<Rail>,
    pub(super) relaxer: Relaxer,
    /// Whether the count rules, not the metric.
    pub(super) exact: bool,
}

impl Sampler<'_> {
    /// Scales the metric so that the samples fill the domain as a hexagonal packing would, where the count rules.
    pub(super) fn rescale(&mut self) {
        let area = self.mesh.total_area();
        if self.exact && area.is_finite() && area > 0.0 {
            let factor = self.mesh.vertices.len() as f64 * HEX_AREA / area;
            self.mesh.scale(factor);
            self.inserter.metric.scale *= factor;
        }
    }

    /// One relaxation step; returns the root mean square of the moves.
    pub(super) fn step(&mut self, sampling: &PlanarSampling) -> Result<f64, PatternError> {
        self.relaxer
            .step(&mut self.mesh, &self.rails, &self.inserter.metric, sampling.relaxation)
    }

    /// All relaxation steps, or until the samples rest. Returns their number and the last move.
    pub(super) fn relax(&mut self, sampling: &PlanarSampling, progress: &Progress) -> Result<(u32, f64), PatternError> {
        let mends = sampling.relaxation == Relaxation::Kite && sampling.steps > 0;
        let (mut done, mut rms) = (0, f64::INFINITY);
        while done < sampling.steps && rms >= f64::from(sampling.tolerance) {
            done += 1;
            progress.report(done as f32 / (sampling.steps + 2) as f32)?;
            rms = self.step(sampling)?;
            if mends && HOLE_STEPS.contains(&done) && done + REST <= sampling.steps {
                self.inserter.fill_holes(&mut self.mesh)?;
            }
        }
        if mends {
            self.relaxer.close_holes(&mut self.mesh, &self.inserter.metric)?;
        }
        Ok((done, if done > 0 { rms } else { 0.0 }))
    }

    /// Puts samples that are crowded, and those of knots of flips, into the largest triangles, so that the count stays.
    pub(super) fn clean_up(&mut self) -> Result<(), PatternError> {
        for _ in 0..CLEANUPS {
            let mut misplaced = self.mesh.flip_violated();
            misplaced.extend(self.mesh.crowded(CROWDED));
            if self.put_elsewhere(&misplaced)?.is_none() {
                break;
            }
        }
        Ok(())
    }

    /// Unties knots of flips: their samples are put elsewhere. `kept` is told the former indices of the others.
    pub(super) fn untie(&mut self, mut kept: impl FnMut(Vec<u32>)) -> Result<(), PatternError> {
        for _ in 0..UNTYINGS {
            let knots = self.mesh.flip_violated();
            match self.put_elsewhere(&knots)? {
                Some(others) => kept(others),
                None => break,
            }
        }
        Ok(())
    }

    /// Takes samples out and inserts as many into the largest triangles. Returns the former indices of those left, which
    /// are the first ones, or nothing where nothing has changed.
    fn put_elsewhere(&mut self, samples: &[u32]) -> Result<Option<Vec<u32>>, PatternError> {
        let count = self.mesh.vertices.len();
        let kept = self.mesh.remove(samples);
        if kept.is_some() {
            self.mesh.flip_violated();
            self.inserter.exactly(&mut self.mesh, count)?;
            self.mesh.flip_violated();
        }
        Ok(kept)
    }
}
