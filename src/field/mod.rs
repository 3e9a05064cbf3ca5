//! What a pattern follows: a direction and a frequency per graph vertex.
//!
//! In: a [`SurfaceGraph`](crate::surface::SurfaceGraph), the mesh's attributes and the user's components. Out: a unit
//! tangent d and a frequency f per vertex, in solver order (section 3.1 of Lichtenberg et al. 2018).
//!
//! [`directions`] and [`frequencies`] are pure functions: a server or a test calls them without an `App`. What depends on
//! more than a mesh has functions of its own: [`vortex_directions`], [`snapshot_directions`], [`tensor_directions`],
//! [`smooth_directions`], [`follow_smooth_directions`], [`follow_principal_lines`],
//! [`distance_frequency`], [`screen_frequency`], [`scalar_frequency`]; on the device these run as passes of the same names.

mod attribute;
mod buffer;
mod constraints;
mod curvature;
mod direction;
mod frequency;
mod gradient;
mod ramp;
mod scalars;
mod smooth;
mod snapshots;
mod tangent;
mod tensor;
mod vortices;

pub(crate) use attribute::{scalars as attribute_scalars, weld_scalars};
pub use buffer::FieldBuffer;
pub use constraints::{Alignment, Painted, smooth_constraints};
pub(crate) use curvature::{FOLLOWING_STEPS, check_smoothing, is_followed, own_share};
pub use curvature::{Principal, follow_principal_lines};
pub use direction::*;
pub use frequency::*;
pub use ramp::*;
pub use scalars::*;
pub use smooth::{FieldRing, SmoothField, Smoothing, follow_smooth_directions, smooth_directions};
pub use snapshots::{FieldTime, Snapshot, snapshot_directions};
pub(crate) use snapshots::{interval, welded};
pub use tangent::{align_to_previous, any_tangent, project_tangent, turn_tangent};
pub use tensor::*;
pub use vortices::*;

use tangent::unit_or_zero;
