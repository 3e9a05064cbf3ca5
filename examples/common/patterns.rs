//! What every example asks of its patterns: that they are there before a picture is taken.

use bevy::prelude::*;
use bevy_field_patterns::prelude::*;

/// A [`ReadyCheck`](super::headless::ReadyCheck): all patterns have come to rest.
///
/// # Errors
///
/// A pattern cannot be drawn.
pub fn patterns_rest(world: &mut World) -> Result<Option<String>, String> {
    let mut missing = None;
    for state in world.query::<&PatternState>().iter(world) {
        match state {
            PatternState::Failed(error) => return Err(error.to_string()),
            PatternState::Preparing => missing = Some("patterns to be prepared".to_owned()),
            PatternState::Solving => missing = Some("patterns to be solved".to_owned()),
            PatternState::Converged | PatternState::NoGpu => {}
        }
    }
    Ok(missing)
}
