//! What the skeletons and morph weights of the world say of an entity.
//!
//! In: an entity's skin, weights and transform. Out: its [`Pose`] in the pattern's space, whether it is seen or not.

use super::Pose;
use crate::{error::PatternError, wave::Pattern};
use bevy::{
    ecs::system::SystemParam,
    math::{Affine3A, Mat3A},
    mesh::{
        MeshTag,
        morph::{MeshMorphWeights, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};

/// Name of what is wrong with a joint's transform.
pub(crate) const JOINT: &str = "transform of joint";
/// Name of what is wrong with a weight.
pub(crate) const MORPH_WEIGHT: &str = "weight of morph target";

/// Joints and weights of the world.
#[derive(SystemParam)]
pub(crate) struct Skeletons<'w, 's> {
    joints: Query<'w, 's, &'static GlobalTransform>,
    weights: Query<'w, 's, &'static MorphWeights>,
    bindposes: Option<Res<'w, Assets<SkinnedMeshInverseBindposes>>>,
}

impl Skeletons<'_, '_> {
    /// The pose of an entity at `transform`. In the world's space positions are taken relative to the entity's place,
    /// which changes no pattern; in the mesh's, back through the transform. `targets`: how many the mesh has.
    ///
    /// # Errors
    /// [`NotFinite`](PatternError::NotFinite).
    pub(crate) fn pose(
        &self,
        skin: Option<&SkinnedMesh>,
        weights: Option<&MeshMorphWeights>,
        transform: Affine3A,
        in_world: bool,
        targets: usize,
    ) -> Result<Pose, PatternError> {
        let matrices = match skin {
            Some(skin) => self.joint_matrices(skin, transform, in_world),
            None if in_world => vec![Affine3A::from_mat3(transform.matrix3.into())],
            None => vec![Affine3A::IDENTITY],
        };
        let weights = match weights {
            Some(MeshMorphWeights::Value { weights }) => weights.as_slice(),
            Some(MeshMorphWeights::Reference(entity)) => {
                self.weights.get(*entity).map_or(&[][..], MorphWeights::weights)
            }
            None => &[],
        };
        let weights = weights[..targets.min(weights.len())].to_vec();
        if let Some(index) = matrices.iter().position(|matrix| !matrix.is_finite()) {
            return Err(PatternError::NotFinite { what: JOINT, index });
        }
        if let Some(index) = weights.iter().position(|weight| !weight.is_finite()) {
            return Err(PatternError::NotFinite {
                what: MORPH_WEIGHT,
                index,
            });
        }
        Ok(Pose { matrices, weights })
    }

    /// As Bevy has them: a joint or a bind pose that is missing counts as none.
    fn joint_matrices(&self, skin: &SkinnedMesh, transform: Affine3A, in_world: bool) -> Vec<Affine3A> {
        let back = transform.matrix3.inverse();
        // An entity that is flattened has no space of its own.
        let back = if in_world || !back.is_finite() {
            Mat3A::IDENTITY
        } else {
            back
        };
        let bindposes = self.bindposes.as_ref().and_then(|all| all.get(&skin.inverse_bindposes));
        let matrix = |(index, &joint): (usize, &Entity)| {
            let bindpose = bindposes.and_then(|bindposes| bindposes.get(index));
            let world = match (bindpose, self.joints.get(joint)) {
                (Some(bindpose), Ok(joint)) => {
                    // Differences first: they are exact far from the origin.
                    let mut near = joint.affine();
                    near.translation -= transform.translation;
                    near * Affine3A::from_mat4(*bindpose)
                }
                _ => Affine3A::from_translation((-transform.translation).into()),
            };
            Affine3A {
                matrix3: back * world.matrix3,
                translation: back * world.translation,
            }
        };
        skin.joints.iter().enumerate().map(matrix).collect()
    }
}

/// Has morphed meshes drawn again as they are, in the frame after they have become visible: Bevy 0.19.1 takes such a mesh
/// over before its weights have a place on the GPU, and draws it without them until something of it changes.
pub(crate) fn take_over_again(
    changed: Query<(Entity, &ViewVisibility), (With<Pattern>, With<MeshMorphWeights>, Changed<ViewVisibility>)>,
    mut tags: Query<&mut MeshTag>,
    mut seen: Local<Vec<Entity>>,
) {
    for entity in seen.drain(..) {
        if let Ok(mut tag) = tags.get_mut(entity) {
            tag.set_changed();
        }
    }
    seen.extend(
        changed
            .iter()
            .filter(|(_, visible)| visible.get())
            .map(|(entity, _)| entity),
    );
}
