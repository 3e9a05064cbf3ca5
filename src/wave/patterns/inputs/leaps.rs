//! Whether a field or a frequency has leapt, so that the pattern had better be solved from nothing.
//!
//! In: what a pattern was solved on, and what it is to be solved on. Out: yes or no. A few sweeps per frame follow what
//! changes by little; after a leap they would take many frames in which nothing fits, and end with more energy.

use super::parameters::{CoreParameters, Parameters};
use crate::{
    field::Symmetry,
    wave::layout::{DIRECTION_AXIS, FREQUENCY_UNIFORM, PatternRecord},
};
use bevy::math::{Mat3A, Vec3};

/// Radians by which an axis or all directions may turn in a frame.
const TURN: f32 = 0.5;
/// The factor by which all frequencies may grow or shrink in a frame.
const GROWTH: f32 = 1.25;

/// The change of a transform's axes in a frame, as a part of their lengths.
const MOTION: f32 = 0.25;

/// Directions, frequencies and their parameters of a pattern.
type Sources<'a> = (&'a PatternRecord, &'a Parameters);

/// Of values per vertex nothing is known here: they are taken for such that change smoothly.
pub(super) fn leaps((old, before): Sources, (new, now): Sources, symmetry: Symmetry) -> bool {
    let kinds = |record: &PatternRecord| record.sources & 0xffff;
    kinds(old) != kinds(new)
        || (old.turn - new.turn).abs() > TURN
        || new.sources & 0xff == DIRECTION_AXIS && axis_leaps(old.axis, new.axis, symmetry)
        || new.sources >> 8 & 0xff == FREQUENCY_UNIFORM && grows(old.frequency, new.frequency)
        || cores_leap(&before.cores, &now.cores)
}

/// An entity's linear part, where its pattern lives in the world.
pub(super) fn linear_leaps(old: Option<Mat3A>, new: Option<Mat3A>) -> bool {
    let (Some(old), Some(new)) = (old, new) else {
        return false;
    };
    let motion = new * old.inverse() - Mat3A::IDENTITY;
    let change = (0..3).map(|k| motion.col(k).length()).fold(0.0, f32::max);
    // Where it was flat, its motion is no number.
    !motion.is_finite() || change > MOTION
}

fn axis_leaps(old: [f32; 3], new: [f32; 3], symmetry: Symmetry) -> bool {
    let [old, new] = [old, new].map(Vec3::from_array);
    let angle = old.angle_between(new);
    let angle = match symmetry {
        Symmetry::Vector => angle,
        Symmetry::Line => angle.min(std::f32::consts::PI - angle),
    };
    angle > TURN
}

/// From or to 0 as well.
fn grows(old: f32, new: f32) -> bool {
    old.max(new) > GROWTH * old.min(new)
}

/// Cores come, go, turn the other way or move by more than their radius.
fn cores_leap(old: &[CoreParameters], new: &[CoreParameters]) -> bool {
    old.len() != new.len() || old.iter().zip(new).any(|(old, new)| new.leaps(old))
}
