//! Time-resolved vectors.
//!
//! In: vectors per vertex of the mesh at a number of times, and a time. Out: a unit tangent per vertex: the two snapshots
//! around the time, blended as vectors or as lines, then projected.

use super::{Symmetry, any_tangent, attribute, project_tangent, tangent, turn_tangent, unit_or_zero};
use crate::{error::PatternError, parallel, surface::SurfaceGraph};
use bevy::prelude::*;
use std::sync::Arc;

/// The vectors of one time; see [`DirectionField::Snapshots`](super::DirectionField).
#[derive(Reflect, Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// When, in the unit of [`FieldTime`]; finite, later than the snapshot before.
    pub time: f32,
    /// One vector of any length per vertex of the mesh, in the mesh's order and space. Longer ones weigh more between two
    /// times. Copies of a vertex at a seam are averaged.
    pub vectors: Arc<[Vec3]>,
}

/// The time that [`DirectionField::Snapshots`](super::DirectionField) show, in the unit of [`Snapshot::time`], finite.
/// Before the first snapshot and after the last one, that one is shown. Default 0.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq, Default, Deref, DerefMut)]
#[reflect(Component, Default)]
pub struct FieldTime(pub f32);

/// The number of the snapshot at or before a time, and how far it is to the next one, 0..1.
///
/// # Errors
/// [`Snapshots`](PatternError::Snapshots) where there are none or their times do not ascend,
/// [`NotFinite`](PatternError::NotFinite) of the time.
pub(crate) fn interval(snapshots: &[Snapshot], time: f32) -> Result<(usize, f32), PatternError> {
    if !time.is_finite() {
        return Err(PatternError::SettingNotFinite("FieldTime"));
    }
    let Some(last) = snapshots.len().checked_sub(1) else {
        return Err(PatternError::Snapshots("there are none"));
    };
    let ascend = snapshots.array_windows().all(|[a, b]: &[Snapshot; 2]| a.time < b.time);
    if !ascend || !snapshots[0].time.is_finite() || !snapshots[last].time.is_finite() {
        return Err(PatternError::Snapshots("their times must be finite and ascend"));
    }
    let after = snapshots.partition_point(|snapshot| snapshot.time <= time);
    if after == 0 || after > last {
        return Ok((after.min(last), 0.0));
    }
    let (a, b) = (snapshots[after - 1].time, snapshots[after].time);
    Ok((after - 1, (time - a) / (b - a)))
}

/// The vectors of a snapshot at the graph's vertices: means over the copies, of lines with the sign of the first copy.
pub(crate) fn welded(snapshot: &Snapshot, symmetry: Symmetry, graph: &SurfaceGraph) -> Result<Vec<Vec3>, PatternError> {
    let means = match symmetry {
        Symmetry::Vector => attribute::weld_means(&snapshot.vectors, graph, "snapshot", "vector of vertex")?,
        Symmetry::Line => attribute::weld_aligned(&snapshot.vectors, graph, "snapshot", "vector of vertex")?,
    };
    Ok(means.into_iter().map(|mean| mean.as_vec3()).collect())
}

/// The direction at each vertex of `graph` at a `time`: the blend of the two snapshots around it, turned by `turn` radians.
///
/// # Errors
/// [`Snapshots`](PatternError::Snapshots), [`NotFinite`](PatternError::NotFinite),
/// [`WrongLength`](PatternError::WrongLength).
pub fn snapshot_directions(
    snapshots: &[Snapshot],
    time: f32,
    symmetry: Symmetry,
    turn: f32,
    graph: &SurfaceGraph,
) -> Result<Vec<Vec3>, PatternError> {
    let (k, share) = interval(snapshots, time)?;
    let before = welded(&snapshots[k], symmetry, graph)?;
    let after = welded(&snapshots[(k + 1).min(snapshots.len() - 1)], symmetry, graph)?;
    Ok(parallel::collect(graph.len(), |i| {
        let n = graph.normals[i];
        turn_tangent(blended(before[i], after[i], share, symmetry, n), n, turn)
    }))
}

/// The tangent between a and b, as vectors or as lines.
fn blended(a: Vec3, b: Vec3, share: f32, symmetry: Symmetry, n: Vec3) -> Vec3 {
    match symmetry {
        Symmetry::Vector => project_tangent(unit_or_zero(a.lerp(b, share)), n),
        Symmetry::Line => {
            let x = any_tangent(n);
            let line = |v: Vec3| {
                let c = Vec2::new(v.dot(x), v.dot(n.cross(x)));
                // A vector along the normal has no line; its rounding noise must not become one.
                if c.length() > 1e-6 * v.length() {
                    tangent::squared(c) / c.length()
                } else {
                    Vec2::ZERO
                }
            };
            let sum = line(a).lerp(line(b), share);
            let d = tangent::line_of(sum, x, n);
            if d.dot(if share < 0.5 { a } else { b }) < 0.0 {
                -d
            } else {
                d
            }
        }
    }
}
