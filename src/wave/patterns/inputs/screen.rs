//! The size of a pixel on a surface, and when a pattern follows it.
//!
//! In: a camera. Out: a size that is linear in the position. A pattern keeps the size that it was made for until the
//! camera's differs by more than the hysteresis somewhere; then it goes after the camera, a part of the way in each frame,
//! until that rests and is caught up with.

use super::{Stage, Surroundings};
use crate::{error::PatternError, field::PixelSize, surface::SurfaceGraph};
use bevy::{
    math::{Affine3A, Mat3A},
    prelude::*,
};

/// Part of the way that a frame goes.
const PACE: f32 = 0.25;
/// A relative difference that is no difference any more.
const CAUGHT_UP: f32 = 0.002;

/// What a pattern was made for, and how it gets along with the camera.
pub(super) struct Follow {
    used: PixelSize,
    /// The camera's in the frame before.
    last: PixelSize,
    following: bool,
    /// The corners of the box around the mesh, in its own space.
    corners: [Vec3; 8],
}

impl Follow {
    pub(super) fn new(now: PixelSize, graph: &SurfaceGraph) -> Self {
        let (min, max) = graph
            .positions
            .iter()
            .fold((Vec3::MAX, Vec3::MIN), |(min, max), &p| (min.min(p), max.max(p)));
        let corner = |n: usize| {
            let pick = |axis: usize| if (n >> axis) & 1 == 0 { min[axis] } else { max[axis] };
            Vec3::new(pick(0), pick(1), pick(2))
        };
        Self {
            used: now,
            last: now,
            following: false,
            corners: std::array::from_fn(corner),
        }
    }

    /// The size to use in this frame; `linear` carries the mesh into the pattern's space.
    pub(super) fn update(&mut self, now: PixelSize, hysteresis: f32, linear: Option<Mat3A>) -> PixelSize {
        let differs = |p: &Vec3| {
            let p = linear.map_or(*p, |linear| linear * *p);
            (now.at(p) / self.used.at(p) - 1.0).abs()
        };
        let difference = self.corners.iter().map(differs).fold(0.0, f32::max);
        self.following |= difference > hysteresis;
        if self.following {
            if difference < CAUGHT_UP {
                self.used = now;
                self.following = now != self.last;
            } else {
                self.used = PixelSize {
                    plane: self.used.plane.lerp(now.plane, PACE),
                    least: self.used.least + PACE * (now.least - self.used.least),
                };
            }
        }
        self.last = now;
        self.used
    }
}

/// The size of a logical pixel of a camera in the space of the pattern; `None` before the camera has drawn.
pub(super) fn pixel_size(
    camera: Entity,
    stage: &Stage,
    around: &Surroundings,
) -> Result<Option<PixelSize>, PatternError> {
    let (view, place) = around.cameras.get(camera).map_err(|_| PatternError::MissingEntity {
        what: "Frequency::Screen",
        entity: camera,
        lacks: "Camera or GlobalTransform",
    })?;
    let clip = view.clip_from_view();
    let Some(height) = view.logical_viewport_size().map(|size| size.y) else {
        return Ok(None);
    };
    if !(height > 0.0 && clip.y_axis.y > 0.0) {
        return Ok(None);
    }
    // What a point is divided by, linear in the point: the depth of a perspective, 1 of a parallel projection.
    let depth = clip.row(3);
    let per_depth = 2.0 / (height * clip.y_axis.y);
    let (world_from_pattern, scale) = match stage.inputs.linear {
        Some(_) => (Affine3A::from_translation(stage.placement.translation.into()), 1.0),
        None => (stage.placement, stage.scale()),
    };
    let view_from_pattern = place.affine().inverse() * world_from_pattern;
    let plane = Mat4::from(view_from_pattern).transpose() * depth * (per_depth * scale);
    let near = if depth.z == 0.0 { 1.0 } else { clip.w_axis.z.abs() };
    let least = (near * per_depth * scale).max(f32::MIN_POSITIVE);
    if !plane.is_finite() || !least.is_finite() {
        return Err(PatternError::SettingNotFinite("the camera's transform"));
    }
    Ok(Some(PixelSize { plane, least }))
}
