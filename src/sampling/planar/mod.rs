//! Sampling of the plane.
//!
//! In: a [`PlanarDomain`] and a [`PlanarMetric`]. Out: [`PlanarSamples`], or a [`SliceSampler`] that follows a metric which
//! changes. The steps (Kratz et al. 2013, section 4):
//!
//! | step | equation | file |
//! |---|---|---|
//! | check the domain, triangulate its corners | - | `domain` |
//! | samples on the border, even in the metric | 10 | `boundary` |
//! | insert where the fill rate is least | 6 | `insertion` |
//! | flip edges by the summed metric | 2 | `flips` |
//! | move to the centroids of the cells | 7 | `relaxation` |
//! | put what is crowded where holes are | - | `holes` |
//! | take away what is crowded | - | `removal` |
//!
//! All on one thread: a set of a few thousand samples takes some ten milliseconds.

mod boundary;
mod domain;
mod few;
mod flips;
mod holes;
mod insertion;
mod metric;
mod options;
mod order;
mod quality;
mod random;
mod raster;
mod relaxation;
mod removal;
mod sampler;
mod samples;
mod slices;
mod triangulation;

pub use domain::PlanarDomain;
pub use insertion::Insertion;
pub use metric::{MetricGrid, PlanarMetric};
pub use options::PlanarSampling;
pub use quality::planar_quality;
pub use relaxation::Relaxation;
pub use sampler::sample_plane;
pub use samples::PlanarSamples;
pub use slices::{SliceReport, SliceSampler};
