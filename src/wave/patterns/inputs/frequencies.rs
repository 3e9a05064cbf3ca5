//! The source of a pattern's frequencies.

use super::{
    Pattern, PatternedItem, Stage, Surroundings,
    parameters::{FrequencyParameters, Parameters},
    screen::{Follow, pixel_size},
};
use crate::{
    error::PatternError,
    field::{DistanceRamp, Frequency, ScalarRamp, frequencies},
    wave::{
        arena::{PatternArena, Pool},
        frame::BufferCopy,
        layout::{
            FREQUENCY_BUFFER, FREQUENCY_DISTANCE, FREQUENCY_SCALAR, FREQUENCY_SCREEN, FREQUENCY_UNIFORM,
            FREQUENCY_VERTICES,
        },
    },
};
use bevy::prelude::*;

/// Whether the frequency may change without its component.
pub(super) fn looks_around(frequency: &Frequency) -> bool {
    matches!(
        frequency,
        Frequency::DistanceTo { .. } | Frequency::Screen { .. } | Frequency::Buffer(_)
    )
}

/// Brings the frequencies up to date; whether there are any. `new_scalars`: scalars are others, or may be.
pub(super) fn update(
    pattern: &mut Pattern,
    item: &PatternedItem,
    stage: &Stage,
    around: &Surroundings,
    arena: &mut PatternArena,
    parameters: &mut Parameters,
    new_scalars: bool,
) -> Result<bool, PatternError> {
    let change = stage.change;
    let stale = change.all || change.attributes || item.frequency.is_changed();
    let before = (pattern.record.sources, pattern.record.frequency);
    let mut new = change.all;
    let kind = match &*item.frequency {
        Frequency::Uniform(f) => {
            check(*f)?;
            pattern.record.frequency = *f;
            FREQUENCY_UNIFORM
        }
        Frequency::Attribute(_) | Frequency::Vertices(_) => {
            if stale {
                let mut values = frequencies(&item.frequency, stage.graph, stage.mesh()?)?;
                values.resize(values.len().next_multiple_of(4), 0.0);
                let base = pattern
                    .sources
                    .frequencies
                    .fit(arena, Pool::Geometry, values.len() as u32 / 4)?;
                arena.write(Pool::Geometry, base, &values);
                pattern.record.frequency_base = base;
                new = true;
            }
            FREQUENCY_VERTICES
        }
        Frequency::DistanceTo { .. } => {
            let ramp = distance_ramp(&item.frequency, stage, around)?;
            parameters.frequencies = FrequencyParameters::distance(&ramp);
            new |= change.moved();
            FREQUENCY_DISTANCE
        }
        &Frequency::Screen {
            camera,
            pixels,
            hysteresis,
        } => {
            in_range("Frequency::Screen::pixels", pixels, pixels > 0.0, "finite and above 0")?;
            in_range(
                "Frequency::Screen::hysteresis",
                hysteresis,
                hysteresis >= 0.0,
                "finite and 0 or more",
            )?;
            let Some(now) = pixel_size(camera, stage, around)? else {
                parameters.frequencies = pattern.sources.written.frequencies;
                return Ok(false);
            };
            let sources = &mut pattern.sources;
            if stale {
                sources.screen = None;
            }
            let follow = sources.screen.get_or_insert_with(|| Follow::new(now, stage.graph));
            let size = follow.update(now, hysteresis, stage.inputs.linear);
            parameters.frequencies = FrequencyParameters::screen(&size, pixels);
            new |= change.moved();
            FREQUENCY_SCREEN
        }
        &Frequency::Eigenvalue {
            eigenvalue,
            low,
            high,
            low_frequency,
            high_frequency,
        } => {
            if pattern.record.scalar_base == 0 {
                return Err(PatternError::NoScalars("Frequency::Eigenvalue"));
            }
            check(low_frequency)?;
            check(high_frequency)?;
            in_range("Frequency::Eigenvalue::low", low, true, "finite")?;
            in_range("Frequency::Eigenvalue::high", high, high > low, "finite and above low")?;
            let ramp = ScalarRamp {
                values: [low, high],
                frequencies: [low_frequency, high_frequency],
            };
            parameters.frequencies = FrequencyParameters::scalar(eigenvalue as u32, &ramp);
            new |= new_scalars;
            FREQUENCY_SCALAR
        }
        Frequency::Buffer(field) => {
            let len = stage.graph.vertex_of.len() as u32;
            let bytes = 4 * u64::from(len);
            let ready = around.buffer_is_ready("Frequency::Buffer", &field.buffer, bytes)?;
            let missed = &mut pattern.sources.missed.frequencies;
            let stale = stale || *missed;
            *missed = stale && !ready;
            if !ready {
                parameters.frequencies = pattern.sources.written.frequencies;
                return Ok(false);
            }
            let base = pattern
                .sources
                .frequencies
                .fit(arena, Pool::Geometry, len.div_ceil(4))?;
            pattern.record.frequency_base = base;
            if stale || field.live {
                let (pool, offset) = (Pool::Geometry, 16 * u64::from(base));
                let buffer = field.buffer.id();
                pattern.sources.due.frequency_copy = Some(BufferCopy {
                    buffer,
                    pool,
                    offset,
                    bytes,
                });
                new = true;
            }
            FREQUENCY_BUFFER
        }
    };
    if !matches!(kind, FREQUENCY_VERTICES | FREQUENCY_BUFFER) {
        pattern.sources.frequencies.free(arena);
    }
    if kind != FREQUENCY_SCREEN {
        pattern.sources.screen = None;
    }
    let record = &mut pattern.record;
    record.sources = (record.sources & !(255 << 8)) | (kind << 8);
    if new
        || (record.sources >> 8) & 255 != (before.0 >> 8) & 255
        || record.frequency != before.1
        || pattern.sources.written.frequencies != parameters.frequencies
    {
        pattern.sources.due.frequencies = true;
    }
    Ok(true)
}

fn check(frequency: f32) -> Result<(), PatternError> {
    if !frequency.is_finite() {
        return Err(PatternError::SettingNotFinite("the frequency"));
    }
    if frequency < 0.0 {
        return Err(PatternError::NegativeFrequency(frequency));
    }
    Ok(())
}

fn in_range(what: &'static str, value: f32, is_in: bool, expected: &'static str) -> Result<(), PatternError> {
    if value.is_finite() && is_in {
        Ok(())
    } else {
        Err(PatternError::OutOfRange { what, value, expected })
    }
}

/// A `DistanceTo` in the space of the pattern, whose units its distances have.
fn distance_ramp(frequency: &Frequency, stage: &Stage, around: &Surroundings) -> Result<DistanceRamp, PatternError> {
    let &Frequency::DistanceTo {
        entity,
        segment,
        near,
        far,
        near_frequency,
        far_frequency,
    } = frequency
    else {
        return Err(PatternError::NotOfMesh("frequencies"));
    };
    check(near_frequency)?;
    check(far_frequency)?;
    in_range("Frequency::DistanceTo::near", near, near >= 0.0, "finite and 0 or more")?;
    in_range("Frequency::DistanceTo::far", far, far > near, "finite and above near")?;
    let place = around.places.get(entity).map_err(|_| PatternError::MissingEntity {
        what: "Frequency::DistanceTo",
        entity,
        lacks: "GlobalTransform",
    })?;
    let ends = [Vec3::ZERO, segment].map(|end| stage.in_pattern(place.transform_point(end)));
    if !ends[0].is_finite() || !ends[1].is_finite() {
        return Err(PatternError::NotFinite {
            what: "end of Frequency::DistanceTo::segment",
            index: usize::from(ends[0].is_finite()),
        });
    }
    Ok(DistanceRamp {
        segment: ends,
        near,
        far,
        frequencies: [near_frequency, far_frequency],
    })
}
