//! The wave on the disc of a point: the CPU twin of what `material/wave.wgsl` does with
//! [`FLAG_DISCS`](super::layout::FLAG_DISCS).
//!
//! In: a triangle whose three corners are one vertex of a point cloud. Out: the corners of the vertex's square, each with
//! the phase that the vertex and its neighbours predict there over the aligned distance, the nearer ones more. So discs
//! that overlap agree, also where stripes branch.

use super::{
    kite::{aligned_distance, cmul, phasor, reversed},
    layout::{FLAG_CROSS, FLAG_VECTOR, PatternRecord},
    shade::{Corners, PatternMemory},
    solver::normalize_or,
    waves::{Coupling, Frame, Waves, frame, turned},
};
use crate::field::Symmetry;
use bevy::math::{Vec2, Vec3};

/// What is known at a vertex.
struct Known {
    position: Vec3,
    frame: Frame,
    frequency: f32,
}

impl PatternMemory<'_> {
    /// Moves `corners` that are all at `vertex` to those of its square's `triangle`.
    pub(super) fn spread_disc(
        &self,
        record: &PatternRecord,
        corners: &mut Corners,
        vertex: u32,
        triangle: u32,
        wave: u32,
    ) -> Option<()> {
        let axes = (record.geometry_base + 2 * record.vertices + 2 * vertex) as usize;
        let [x, y] = self.geometry.get(axes..axes + 2)? else {
            return None;
        };
        let (x, y) = (x.truncate(), y.truncate());
        let offsets = match triangle % 2 {
            0 => [-x - y, x - y, x + y],
            _ => [-x - y, x + y, y - x],
        };
        corners.position = offsets.map(|offset| corners.position[0] + offset);
        let reach = 2.0 * x.length_squared().max(y.length_squared());
        corners.z = self.predicted(record, corners, vertex, wave, 2.0 * reach)?;
        Some(())
    }

    /// What a vertex and its neighbours predict at the corners; weights fall to 0 at the squared distance `reach`.
    fn predicted(
        &self,
        record: &PatternRecord,
        corners: &Corners,
        vertex: u32,
        wave: u32,
        reach: f32,
    ) -> Option<[Vec2; 3]> {
        let own = self.known(record, vertex)?;
        let coupling = coupling_of(record);
        let mut sums = [Vec2::ZERO; 3];
        // A graph's lists of neighbours follow its triangles and those across their sides.
        let offsets = record.triangle_base + 6 * record.triangles;
        let list = offsets + record.vertices + 1;
        let end = |n: u32| Some((list + self.surface.get((offsets + vertex + n) as usize)?) as usize);
        let neighbors = self.surface.get(end(0)?..end(1)?)?;
        for &j in [vertex].iter().chain(neighbors) {
            let other = self.known(record, j)?;
            let (m, flip) = turned(coupling.quarter_turns(other.frame, own.frame), wave as usize);
            let z = *self
                .wave
                .get((record.phasor_base + record.waves.max(1) * j + m as u32) as usize)?;
            let (d, z) = if flip {
                (-other.frame[m], reversed(z))
            } else {
                (other.frame[m], z)
            };
            let ratio = if wave == 1 { record.ratio } else { 1.0 };
            let frequency = 0.5 * ratio * (other.frequency + own.frequency);
            for (sum, p) in sums.iter_mut().zip(corners.position) {
                let offset = p - other.position;
                let weight = (1.0 - offset.length_squared() / reach).max(0.0).powi(2);
                let periods = frequency * aligned_distance(offset, d, own.frame[wave as usize]);
                *sum += weight * cmul(normalize_or(z, Vec2::X), phasor(periods));
            }
        }
        Some(sums)
    }

    fn known(&self, record: &PatternRecord, vertex: u32) -> Option<Known> {
        let geometry = |n: u32| self.geometry.get((record.geometry_base + 2 * vertex + n) as usize);
        let xy = self.wave.get((record.field_base + 2 * vertex) as usize)?;
        let zf = self.wave.get((record.field_base + 2 * vertex + 1) as usize)?;
        Some(Known {
            position: geometry(0)?.truncate(),
            frame: frame(Vec3::new(xy.x, xy.y, zf.x), geometry(1)?.truncate()),
            frequency: zf.y,
        })
    }
}

fn coupling_of(record: &PatternRecord) -> Coupling {
    let waves = match (record.waves, record.flags & FLAG_CROSS) {
        (2, 0) => Waves::Orthogonal { ratio: record.ratio },
        (2, _) => Waves::Cross,
        _ => Waves::Single,
    };
    let symmetry = match record.flags & FLAG_VECTOR {
        0 => Symmetry::Line,
        _ => Symmetry::Vector,
    };
    Coupling { waves, symmetry }
}
