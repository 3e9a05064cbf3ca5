//! Which vertices of a pattern lie on creases, for the GPU.
//!
//! In: an entity's [`CreasePhase`](crate::wave::CreasePhase) and its graph. Out: one bit per vertex in the shared buffers, and the pull in the
//! pattern's record.

use super::{Pattern, PatternedItem, Tools};
use crate::{error::PatternError, surface::Surface, wave::layout::FLAG_FOLLOW};

/// What the bits in the shared buffers were made from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Creases {
    angle: f32,
    boundary: bool,
    geometry: u32,
}

/// Brings bits and pull up to date; whether anything has changed.
pub(super) fn update_creases(
    pattern: &mut Pattern,
    item: &PatternedItem,
    surface: &Surface,
    tools: &mut Tools,
) -> Result<bool, PatternError> {
    let Some(crease) = item.crease.as_deref().copied() else {
        let had_any = pattern.record.pin_base != 0;
        if had_any {
            set_pins(pattern, 0, 0.0, tools);
        }
        return Ok(had_any);
    };
    crease.check()?;
    let creases = Creases {
        angle: crease.angle,
        boundary: crease.boundary,
        geometry: surface.geometry,
    };
    let known = pattern.record.pin_base != 0 && pattern.creases == creases;
    if known && pattern.record.pull == crease.pull() {
        return Ok(false);
    }
    let base = if known {
        pattern.record.pin_base
    } else {
        let Some(graph) = tools.graphs.get(&surface.graph) else {
            return Ok(false);
        };
        let bits: Vec<u32> = graph
            .creases(crease.angle, crease.boundary)
            .chunks(32)
            .map(|sharp| {
                (0..)
                    .zip(sharp)
                    .fold(0, |word, (bit, &sharp)| word | u32::from(sharp) << bit)
            })
            .collect();
        pattern.ranges.write_pins(&mut tools.arena, &bits)?
    };
    pattern.creases = creases;
    set_pins(pattern, base, crease.pull(), tools);
    Ok(true)
}

fn set_pins(pattern: &mut Pattern, base: u32, pull: f32, tools: &mut Tools) {
    pattern.record.pin_base = base;
    pattern.record.pull = pull;
    if pattern.is_solved() {
        // Directions that are projected again keep the signs that the phasors refer to.
        pattern.record.flags |= FLAG_FOLLOW;
    }
    pattern.write_record(&mut tools.arena);
}
