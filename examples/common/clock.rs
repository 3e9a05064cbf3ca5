//! The time of what moves by itself.
//!
//! In: the command line. Out: a [`Clock`] that runs on in a window, and for a picture runs up to one moment and stops
//! there, so that patterns have followed the motion and then come to rest. The space bar stops it and sets it going.

use bevy::prelude::*;

use super::{args::OutputArgs, headless::ReadyChecks};

/// Seconds of motion.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Clock {
    pub seconds: f32,
    /// Where it stops.
    until: f32,
    running: bool,
}

impl Clock {
    /// Keeps a [`Clock`] in `app` that begins `lead` seconds before the `moment` of the picture.
    pub fn start(app: &mut App, output: &OutputArgs, moment: f32, lead: f32) {
        let still = output.screenshot.is_some();
        app.insert_resource(Self {
            seconds: if still { moment - lead } else { 0.0 },
            until: if still { moment } else { f32::INFINITY },
            running: true,
        })
        .add_systems(PreUpdate, tick);
        if let Some(mut checks) = app.world_mut().get_resource_mut::<ReadyChecks>() {
            checks.0.push(|world| {
                let clock = world.resource::<Self>();
                Ok((clock.seconds < clock.until).then(|| "the moment of the picture".into()))
            });
        }
    }
}

fn tick(mut clock: ResMut<Clock>, time: Res<Time>, keys: Res<ButtonInput<KeyCode>>) {
    if keys.just_pressed(KeyCode::Space) {
        clock.running = !clock.running;
    }
    if clock.running && clock.seconds < clock.until {
        clock.seconds = (clock.seconds + time.delta_secs()).min(clock.until);
    }
}
