//! Focus: a region of the world that limits a style.
//!
//! In: a shape in world space. Out: a uniform; `focus.wgsl` makes a weight of it, 1 in
//! focus and 0 out of it. Moving a focus changes uniforms only: nothing is solved again.

use bevy::{prelude::*, render::render_resource::ShaderType};

/// The region of a [`Focus`].
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Default)]
#[reflect(Default, Clone, PartialEq)]
#[non_exhaustive]
pub enum FocusShape {
    /// No limit: all is in focus.
    #[default]
    Everywhere,
    /// A ball.
    Sphere {
        /// Centre in world space.
        center: Vec3,
        /// Radius in world units, 0 or more.
        radius: f32,
    },
    /// The side of a plane that its normal points to.
    HalfSpace {
        /// Unit normal in world space.
        normal: Dir3,
        /// The plane's distance from the origin along the normal, in world units.
        distance: f32,
    },
}

/// A region of the world with a soft border, and what it limits.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Focus {
    /// The region. Default [`FocusShape::Everywhere`].
    pub shape: FocusShape,
    /// Width of the soft border in world units, 0 or more, centred on the shape's surface. Default 0: sharp.
    pub border: f32,
    /// What is outside of the shape is in focus instead. Default `false`.
    pub invert: bool,
    /// Nothing is cut out of focus. Default `true`.
    pub cutout: bool,
    /// Colours, glow, roughness and bumps fade out of focus. Default `true`.
    pub color: bool,
    /// Stripes grow thin out of focus: their duty is multiplied by the focus. Default `false`.
    pub width: bool,
}

impl Default for Focus {
    fn default() -> Self {
        Self {
            shape: FocusShape::Everywhere,
            border: 0.0,
            invert: false,
            cutout: true,
            color: true,
            width: false,
        }
    }
}

impl Focus {
    const SPHERE: u32 = 1;
    const HALF_SPACE: u32 = 2;
    const INVERT: u32 = 1 << 2;
    const CUTOUT: u32 = 1 << 3;
    const COLOR: u32 = 1 << 4;
    const WIDTH: u32 = 1 << 5;

    /// A ball in world space.
    pub fn sphere(center: Vec3, radius: f32) -> Self {
        Self {
            shape: FocusShape::Sphere { center, radius },
            ..default()
        }
    }

    /// The side of the plane through `point` that `normal` points to, in world space.
    pub fn half_space(point: Vec3, normal: Dir3) -> Self {
        Self {
            shape: FocusShape::HalfSpace {
                normal,
                distance: normal.dot(point),
            },
            ..default()
        }
    }

    /// How much a point of the world is in focus, 0 to 1: the twin of `focus_weight` in `focus.wgsl`.
    pub fn weight(&self, point: Vec3) -> f32 {
        let depth = match self.shape {
            FocusShape::Everywhere => return 1.0,
            FocusShape::Sphere { center, radius } => radius - point.distance(center),
            FocusShape::HalfSpace { normal, distance } => normal.dot(point) - distance,
        };
        let t = (depth / self.border.max(1e-6) + 0.5).clamp(0.0, 1.0);
        let inside = t * t * (3.0 - 2.0 * t);
        if self.invert { 1.0 - inside } else { inside }
    }

    pub(super) fn uniform(&self) -> FocusUniform {
        FocusUniform {
            region: match self.shape {
                FocusShape::Everywhere => Vec4::ZERO,
                FocusShape::Sphere { center, radius } => center.extend(radius),
                FocusShape::HalfSpace { normal, distance } => normal.extend(distance),
            },
            border: self.border.max(1e-6),
            flags: self.flags(),
        }
    }

    fn flags(&self) -> u32 {
        let shape = match self.shape {
            FocusShape::Everywhere => 0,
            FocusShape::Sphere { .. } => Self::SPHERE,
            FocusShape::HalfSpace { .. } => Self::HALF_SPACE,
        };
        let limits = [
            (self.invert, Self::INVERT),
            (self.cutout, Self::CUTOUT),
            (self.color, Self::COLOR),
            (self.width, Self::WIDTH),
        ];
        limits
            .into_iter()
            .filter(|limit| limit.0)
            .fold(shape, |flags, limit| flags | limit.1)
    }
}

/// `struct Focus` of `focus.wgsl`.
#[derive(ShaderType, Debug, Clone, Default)]
pub(super) struct FocusUniform {
    region: Vec4,
    border: f32,
    flags: u32,
}
