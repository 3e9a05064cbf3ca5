//! What a pattern follows: a direction and a frequency per graph vertex.
//!
//! In: a [`SurfaceGraph`](crate::surface::SurfaceGraph), the mesh's attributes and the user's components. Out: a unit
//! tangent d and a frequency f per vertex, in solver order (section 3.1 of Lichtenberg et al. 2018).

mod direction;

pub use direction::*;
