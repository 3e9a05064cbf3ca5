//! What a pattern follows: a direction and a frequency per graph vertex.
//!
//! In: a [`SurfaceGraph`](crate::surface::SurfaceGraph), the mesh's attributes and the user's components. Out: a unit
//! tangent d and a frequency f per vertex, in solver order (section 3.1 of Lichtenberg et al. 2018).
//!
//! [`directions`] and [`frequencies`] are pure functions: a server or a test calls them without an `App`.

mod attribute;
mod curvature;
mod direction;
mod frequency;
mod gradient;
mod tangent;

pub(crate) use attribute::{scalars as attribute_scalars, weld_scalars};
pub use curvature::Principal;
pub use direction::*;
pub use frequency::*;
pub use tangent::*;
