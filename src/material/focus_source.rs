//! A focus that an entity carries along.
//!
//! In: a [`FocusSource`] and the entity's `GlobalTransform`. Out: the region of the [`Focus`](super::Focus) of the
//! materials and the scenes it names, in world space. Uniforms change, nothing is solved again.

use super::{FocusShape, SceneStyle, Stripes, Styled};
use bevy::{math::Affine3A, prelude::*};

/// The region of focus of materials of one style moves, turns and scales with this entity.
///
/// Border, inversion and what the focus limits are each material's own. Of two sources of one material, one wins. The
/// materials of a [`StyledScene`](crate::scene::StyledScene) are the scene's own: name the scene instead. An entity can
/// carry a source for each style.
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[require(Transform)]
pub struct FocusSource<S: SceneStyle = Stripes> {
    /// The region in the entity's own space. Default [`FocusShape::Everywhere`].
    pub shape: FocusShape,
    /// The materials whose focus it sets. Default: none.
    pub materials: Vec<Handle<Styled<S>>>,
    /// The entities with a [`StyledScene`](crate::scene::StyledScene) whose style's focus it sets. Default: none.
    #[entities]
    pub scenes: Vec<Entity>,
}

impl<S: SceneStyle> FocusSource<S> {
    /// A ball of `radius` (in the entity's own unit, 0 or more) about the entity's origin.
    pub fn sphere(radius: f32, materials: impl IntoIterator<Item = Handle<Styled<S>>>) -> Self {
        Self {
            shape: FocusShape::Sphere {
                center: Vec3::ZERO,
                radius,
            },
            materials: materials.into_iter().collect(),
            scenes: Vec::new(),
        }
    }

    /// All that lies before the entity: the side of the plane through it that its forward direction (-z) points to.
    pub fn half_space(materials: impl IntoIterator<Item = Handle<Styled<S>>>) -> Self {
        Self {
            shape: FocusShape::HalfSpace {
                normal: Dir3::NEG_Z,
                distance: 0.0,
            },
            materials: materials.into_iter().collect(),
            scenes: Vec::new(),
        }
    }
}

impl FocusShape {
    /// The shape carried along by a map. A ball stays a ball: its radius grows as the cube root of the volume. A plane is
    /// exact; a map that flattens leaves its normal.
    pub fn transformed(&self, map: &Affine3A) -> Self {
        match *self {
            Self::Everywhere => Self::Everywhere,
            Self::Sphere { center, radius } => {
                let volume = map.matrix3.determinant().abs();
                Self::Sphere {
                    center: map.transform_point3(center),
                    radius: radius * volume.cbrt(),
                }
            }
            Self::HalfSpace { normal, distance } => {
                let point = map.transform_point3(distance * normal);
                let carried = map.matrix3.inverse().transpose() * *normal;
                let normal = Dir3::new(carried).unwrap_or(normal);
                Self::HalfSpace {
                    normal,
                    distance: normal.dot(point),
                }
            }
        }
    }
}

/// Writes the region to the materials where it differs.
pub(super) fn carry_focus<S: SceneStyle>(
    sources: Query<(&FocusSource<S>, &GlobalTransform)>,
    mut materials: ResMut<Assets<Styled<S>>>,
) {
    for (source, transform) in &sources {
        let shape = source.shape.transformed(&transform.affine());
        for handle in &source.materials {
            let differs = |material: &Styled<S>| material.extension.focus().shape != shape;
            if materials.get(handle).is_some_and(differs)
                && let Some(mut material) = materials.get_mut(handle)
            {
                material.extension.focus_mut().shape = shape;
            }
        }
    }
}
