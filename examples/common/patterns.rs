//! What every example asks of its patterns: that they are there before a picture is taken.

use bevy::prelude::*;
use bevy_field_patterns::prelude::*;

/// A [`ReadyCheck`](super::headless::ReadyCheck): all patterns have come to rest, all samples and cells are there.
///
/// # Errors
///
/// A pattern cannot be drawn, or a mesh cannot be sampled.
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
    for state in world.query::<&SamplingState>().iter(world) {
        match state {
            SamplingState::Failed(error) => return Err(error.to_string()),
            SamplingState::Preparing | SamplingState::Sampling(_) => missing = Some("samples".to_owned()),
            SamplingState::Ready => {}
        }
    }
    for state in world.query::<&CellState>().iter(world) {
        match state {
            CellState::Failed(error) => return Err(error.to_string()),
            CellState::Preparing => missing = Some("cells".to_owned()),
            CellState::Ready => {}
        }
    }
    Ok(missing)
}
