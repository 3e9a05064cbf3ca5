//! Surfaces that move: vertices posed on the GPU, and what follows from where they are.
//!
//! In: a graph, the joints and morph targets of its mesh ([`Rig`]), and in every frame a [`Pose`] of each entity. Out: the
//! entity's own positions, normals and areas in the geometry buffer, and the directions of the surface as it is now: an
//! axis is projected anew, principal curvature computed anew, and vectors that were given at rest are carried along.
//!
//! | pass | twin |
//! |---|---|
//! | `pose_vertices` | [`pose_vertices`] |
//! | `pose_normals` | [`SurfaceGraph::update_positions`](crate::surface::SurfaceGraph::update_positions) |
//! | `deviators`, `limit`, `transports`, `smooth_lines` | [`directions`](crate::field::directions) of a principal curvature |
//! | `directions`, of vectors and tensors | [`deformations`] |
//!
//! Joint matrices come from the main world, a few hundred numbers per entity, not from Bevy's own buffer of them: that
//! one knows visible entities only, changes places in every frame, and is filled when it is too late to find out that
//! nothing has moved.

mod fans;
mod motion;
mod plan;
mod rig;
mod rigs;
mod twin;

pub(crate) use motion::{JOINT, MORPH_WEIGHT, Skeletons, take_over_again};
pub(crate) use rig::Extent;
pub use rig::{Pose, Rig};
pub(crate) use rigs::{PackedRig, PackedRigs};
pub use twin::{deformations, pose_vertices};

use bevy::prelude::*;

/// Whether a pattern knows that its mesh deforms, by a skin or by morph targets.
///
/// It decides on the *space* of the pattern too: with [`Live`](Self::Live) unit lengths, axes and curvature are those of
/// the surface as it is posed, in the entity's own space or, in [`PatternSpace::World`](crate::field::PatternSpace), in
/// the world's (where a scaled entity gets more stripes, as at rest).
///
/// Default: [`Rest`](Self::Rest).
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub enum PatternPose {
    /// The pattern is solved once, on the mesh as it was made, and sticks to it: stripes are stretched and bent along
    /// with the surface.
    #[default]
    Rest,
    /// The pattern keeps its spacing while the mesh deforms: stripes wander over the surface, and begin and end where it
    /// grows and shrinks. Vertices are posed on the GPU and the pattern follows in every frame in which the pose changes;
    /// while it does not, nothing is computed. It makes no difference whether the entity is seen.
    ///
    /// A pose that jumps is solved from nothing in its frame: where a joint turns by more than half a radian, goes farther than
    /// a quarter of the mesh's diagonal or grows by half, or where a weight changes by more than half. To have that for less,
    /// trigger [`RestartPattern`](crate::wave::RestartPattern).
    ///
    /// An axis and vortices are taken on the moving surface, principal curvature is computed anew, and vectors, tensors and
    /// contour lines that belong to the mesh are carried along by the deformation. Smoothing of curvature by more than six steps,
    /// and of [`DirectionField::Smooth`](crate::field::DirectionField), continues from the frame before with a few steps while
    /// the surface moves, and is completed when that rests. The mesh's data must stay in the main
    /// world, as for attributes. A point cloud cannot be posed: [`PatternError::LiveCloud`](crate::error::PatternError).
    Live,
}
