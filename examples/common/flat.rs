//! A camera that looks straight at a rectangle of the plane.

use bevy::{camera::ScalingMode, core_pipeline::tonemapping::Tonemapping, prelude::*};

/// Room around the rectangle, as a part of its size.
const MARGIN: f32 = 0.04;

/// Spawns a two-dimensional camera that just holds `shown`.
pub struct FlatPlugin {
    pub shown: Rect,
}

impl Plugin for FlatPlugin {
    fn build(&self, app: &mut App) {
        let (center, size) = (self.shown.center(), self.shown.size() * (1.0 + MARGIN));
        let furnish = move |mut commands: Commands| {
            commands.spawn((
                Camera2d,
                Tonemapping::None,
                Projection::Orthographic(OrthographicProjection {
                    scaling_mode: ScalingMode::AutoMin {
                        min_width: size.x,
                        min_height: size.y,
                    },
                    ..OrthographicProjection::default_2d()
                }),
                Transform::from_translation(center.extend(0.0)),
            ));
        };
        app.insert_resource(ClearColor(Color::srgb(0.93, 0.93, 0.91)))
            .add_systems(Startup, furnish);
    }
}
