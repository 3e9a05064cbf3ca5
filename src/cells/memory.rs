//! A sample set in the shared buffers.
//!
//! In: a checked set and perhaps values. Out: ranges of the shared buffers, filled. A set that replaces another one is
//! written in place where it fits, so that sampling anew costs its upload and nothing else.

use super::{
    SampleValues,
    layout::{CHECK, CellArena, CellRecord, FLAG_VALUES, Pool, Site},
};
use crate::{error::PatternError, sampling::SampleSet};
use bevy::{
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    prelude::*,
};
use std::ops::Range;

const RECORD_WORDS: u32 = (size_of::<CellRecord>() / 4) as u32;
const SITE_ELEMENTS: u32 = (size_of::<Site>() / 16) as u32;

/// An entity's samples in the shared buffers; there while it has cells.
#[derive(Component, Debug, Default)]
#[component(on_discard = release)]
pub struct CellMemory {
    record: CellRecord,
    own: Range<u32>,
    sites: Range<u32>,
    lists: Range<u32>,
    values: Range<u32>,
    /// What has changed since it was looked at last.
    pub(super) unseen: Unseen,
    /// The set could not be written; what is here is an older one.
    pub(super) stale: bool,
    /// Whether the entity had values when they were written last.
    pub(super) had_values: bool,
    /// The mesh that the samples were written for, as the plugin has put it into `Mesh3d` or `Mesh2d`.
    pub(super) drawn: Handle<Mesh>,
}

/// Inputs that are not in the buffers yet.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Unseen {
    pub(super) set: bool,
    pub(super) values: bool,
}

impl CellMemory {
    /// What the GPU knows of the samples, as uploaded last.
    pub fn record(&self) -> &CellRecord {
        &self.record
    }

    /// The entity's `MeshTag`: where the record is.
    pub fn tag(&self) -> u32 {
        self.own.start
    }

    /// Takes a place for the record, which says that there is nothing yet.
    pub(super) fn new(arena: &mut CellArena) -> Result<Self, PatternError> {
        let mut memory = Self::default();
        fit(&mut memory.own, RECORD_WORDS, Pool::Cells, arena)?;
        memory.hide(arena);
        Ok(memory)
    }

    /// Writes a set, which must have been checked.
    pub(super) fn write_set(&mut self, set: &SampleSet, arena: &mut CellArena) -> Result<(), PatternError> {
        let sites: Vec<Site> = (0..set.len())
            .map(|i| Site::new(set.positions[i], set.normals[i], set.metrics[i]))
            .collect();
        let mut lists = set.neighbor_offsets.clone();
        lists.resize(set.len() + 1, 0);
        lists.extend_from_slice(&set.neighbors);
        lists.extend_from_slice(set.seeds.as_flattened());
        fit(
            &mut self.sites,
            elements(sites.len(), SITE_ELEMENTS)?,
            Pool::Sites,
            arena,
        )?;
        fit(&mut self.lists, elements(lists.len(), 1)?, Pool::Cells, arena)?;
        let offset_base = self.lists.start;
        let neighbor_base = offset_base + set.len() as u32 + 1;
        self.record = CellRecord {
            samples: set.len() as u32,
            triangles: set.seeds.len() as u32,
            check: CHECK ^ self.tag(),
            site_base: self.sites.start,
            offset_base,
            neighbor_base,
            seed_base: neighbor_base + set.neighbors.len() as u32,
            radius: sites.iter().map(|site| site.k).sum::<f32>() / sites.len().max(1) as f32,
            ..CellRecord::default()
        };
        arena.write(Pool::Sites, self.sites.start, &sites);
        arena.write(Pool::Cells, self.lists.start, &lists);
        Ok(())
    }

    /// Writes the samples' values, or forgets them.
    pub(super) fn write_values(
        &mut self,
        values: Option<&SampleValues>,
        arena: &mut CellArena,
    ) -> Result<(), PatternError> {
        self.record.flags &= !FLAG_VALUES;
        let Some(SampleValues(values)) = values else {
            arena.free(Pool::Sites, std::mem::take(&mut self.values));
            return Ok(());
        };
        let (found, expected) = (values.len(), self.record.samples as usize);
        if found != expected {
            let what = "values of samples";
            return Err(PatternError::SampleLists { what, found, expected });
        }
        fit(&mut self.values, elements(found, 1)?, Pool::Sites, arena)?;
        let colors: Vec<Vec4> = values.iter().map(|color| color.to_vec4()).collect();
        self.record.flags |= FLAG_VALUES;
        self.record.value_base = self.values.start;
        self.record.mean_value = (colors.iter().sum::<Vec4>() / found.max(1) as f32).to_array();
        arena.write(Pool::Sites, self.values.start, &colors);
        Ok(())
    }

    /// Writes the record, after all that it speaks of.
    pub(super) fn write_record(&self, arena: &mut CellArena) {
        arena.write(Pool::Cells, self.own.start, &[self.record]);
    }

    /// Nothing is drawn until the record is written again.
    pub(super) fn hide(&self, arena: &mut CellArena) {
        arena.write(Pool::Cells, self.own.start, &[CellRecord::default()]);
    }

    pub(super) fn free(&mut self, arena: &mut CellArena) {
        for (pool, range) in [
            (Pool::Cells, &mut self.own),
            (Pool::Cells, &mut self.lists),
            (Pool::Sites, &mut self.sites),
            (Pool::Sites, &mut self.values),
        ] {
            arena.free(pool, std::mem::take(range));
        }
    }
}

/// `n` times `each`, where a buffer can be as long as that.
fn elements(n: usize, each: u32) -> Result<u32, PatternError> {
    let needed = n as u64 * u64::from(each);
    u32::try_from(needed).map_err(|_| PatternError::GpuLimit {
        limit: "max_storage_buffer_binding_size",
        found: u32::MAX.into(),
        needed,
    })
}

/// Makes a range hold `len` elements. It stays where it is unless it is too short, or much too long; one that has been too
/// short gets some room to spare, because it will be again.
fn fit(range: &mut Range<u32>, len: u32, pool: Pool, arena: &mut CellArena) -> Result<(), PatternError> {
    let have = range.end - range.start;
    if len <= have && have / 4 <= len {
        return Ok(());
    }
    let spare = if have > 0 { len / 16 } else { 0 };
    arena.free(pool, std::mem::take(range));
    *range = arena.allocate(pool, len.saturating_add(spare))?;
    Ok(())
}

fn release(mut world: DeferredWorld, context: HookContext) {
    let Some(mut memory) = world.get_mut::<CellMemory>(context.entity) else {
        return;
    };
    let mut memory = std::mem::take(&mut *memory);
    if let Some(mut arena) = world.get_resource_mut::<CellArena>() {
        memory.free(&mut arena);
    }
}
