//! Metrics: how large samples are, how long, and which way they lie.
//!
//! In: directions, tensors, scalars, images or volumes. Out: a metric M per vertex of a surface or per point of a plane.
//!
//! | from | long axis | file |
//! |---|---|---|
//! | a direction field | along it | `tensor`: [`ellipse`] |
//! | a symmetric tensor field | along an eigenvector | `tensor`: [`EigenvalueMapping`] |
//! | a scalar, an image, a volume | along its contours | `structure`: [`Structure`] |
//! | a metric of space | as projected (Eq. 4, 5) | `tensor`: [`on_surface`], `volume`: [`Slice`] |

mod eigen;
mod smooth;
mod structure;
mod tensor;
mod volume;

pub use eigen::*;
pub use smooth::smooth;
pub use structure::*;
pub use tensor::*;
pub use volume::*;

use crate::error::PatternError;
use eigen::determinant;
use glam_matrix_extras::SymmetricMat3;

/// Checks that metrics are finite and positive definite.
pub(crate) fn check_metrics(metrics: &[SymmetricMat3]) -> Result<(), PatternError> {
    let what = "metric of vertex";
    match metrics.iter().position(|m| !is_metric(m)) {
        Some(index) if metrics[index].is_finite() => Err(PatternError::NotPositive { what, index }),
        Some(index) => Err(PatternError::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// Sylvester's criterion.
fn is_metric(m: &SymmetricMat3) -> bool {
    let m = m.as_symmetric_dmat3();
    let minor = m.m00 * m.m11 - m.m01 * m.m01;
    m.is_finite() && m.m00 > 0.0 && minor > 0.0 && determinant(&m) > 0.0
}
