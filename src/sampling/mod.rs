//! Sample sets: points that are dense, even and random-looking in an anisotropic metric.
//!
//! In: a metric M per point of a plane or a surface. Out: a [`SampleSet`]: positions, each with the ellipse that it
//! stands for, and its neighbours. Kratz et al. 2013.
//!
//! M is the metric, never its inverse: d(p, q)² = (q - p)ᵀ M (q - p). The unit ball of M, an ellipse with the semi-axes
//! 1/√λ, is one sample; samples that touch are 2 apart. On a surface M has the eigenvalue √(λ₁λ₂) along the normal.

mod image;
pub mod metric;
mod options;
pub mod planar;
mod plugin;
mod point_metric;
mod progress;
mod quality;
mod set;
mod source;
mod spectrum;
pub mod surface;
mod task;

pub use image::Pixels;
pub use options::*;
pub use plugin::*;
pub use progress::Progress;
pub use quality::SampleQuality;
pub use set::*;
pub use source::*;
pub use spectrum::{PowerSpectrum, power_spectrum};
