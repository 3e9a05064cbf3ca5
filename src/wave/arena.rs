//! The memory of all patterns: five shared GPU buffers, of which graphs and entities own ranges.
//!
//! The main world decides who owns what and what is written; the render world owns the buffers themselves. A buffer that
//! is too small doubles, and keeps its contents.

use super::layout::{BALANCE_BUFFER, EDGE_BUFFER, GEOMETRY_BUFFER, SURFACE_BUFFER, WAVE_BUFFER};
use crate::error::PatternError;
use bevy::{
    prelude::*,
    render::{render_resource::BufferUsages, renderer::RenderDevice, storage::ShaderBuffer},
};
use bytemuck::Pod;
use range_alloc::RangeAllocator;
use std::ops::Range;

/// The shared buffers; see [`layout`](super::layout) for their elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pool {
    Surface,
    Geometry,
    Wave,
    Edges,
    Balance,
}

impl Pool {
    pub(crate) const ALL: [Self; 5] = [Self::Surface, Self::Geometry, Self::Wave, Self::Edges, Self::Balance];

    pub(crate) fn handle(self) -> Handle<ShaderBuffer> {
        match self {
            Self::Surface => SURFACE_BUFFER,
            Self::Geometry => GEOMETRY_BUFFER,
            Self::Wave => WAVE_BUFFER,
            Self::Edges => EDGE_BUFFER,
            Self::Balance => BALANCE_BUFFER,
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Surface => "pattern_surface",
            Self::Geometry => "pattern_geometry",
            Self::Wave => "pattern_wave",
            Self::Edges => "pattern_edges",
            Self::Balance => "pattern_balance",
        }
    }

    /// Bytes of one element.
    pub(crate) fn element(self) -> u64 {
        match self {
            Self::Surface | Self::Balance => 4,
            Self::Wave | Self::Edges => 8,
            Self::Geometry => 16,
        }
    }
}

/// Words at the start of the surface buffer that stay 0: the record of no pattern. The balance buffer keeps as many for
/// the report of all patterns.
pub(crate) const RESERVED: u32 = 32;
const FIRST_CAPACITY: u32 = 1 << 14;

/// Bytes to write into a shared buffer.
#[derive(Debug)]
pub(crate) struct Upload {
    pub(crate) pool: Pool,
    pub(crate) offset: u64,
    pub(crate) bytes: Vec<u8>,
}

#[derive(Debug)]
struct Space {
    ranges: RangeAllocator<u32>,
    used: u64,
}

/// How many bytes patterns take on the GPU.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PatternMemory {
    /// Bytes owned by graphs and entities.
    pub used: u64,
    /// Bytes of the shared buffers.
    pub allocated: u64,
}

/// Who owns which part of the shared buffers.
#[derive(Resource, Debug)]
pub struct PatternArena {
    spaces: [Space; 5],
    uploads: Vec<Upload>,
    max_bytes: u64,
    grown: bool,
}

impl Default for PatternArena {
    fn default() -> Self {
        let spaces = Pool::ALL.map(|_| Space {
            ranges: RangeAllocator::new(RESERVED..FIRST_CAPACITY),
            used: 0,
        });
        Self {
            spaces,
            uploads: Vec::new(),
            max_bytes: 128 << 20,
            grown: true,
        }
    }
}

impl PatternArena {
    /// Bytes used and allocated on the GPU, by solver, graphs and levels together.
    pub fn memory(&self) -> PatternMemory {
        Pool::ALL
            .iter()
            .fold(PatternMemory::default(), |sum, &pool| PatternMemory {
                used: sum.used + self.spaces[pool as usize].used * pool.element(),
                allocated: sum.allocated + self.capacity(pool),
            })
    }

    /// Bytes of a shared buffer.
    pub(crate) fn capacity(&self, pool: Pool) -> u64 {
        u64::from(self.spaces[pool as usize].ranges.initial_range().end) * pool.element()
    }

    /// A range of `len` elements; the buffer grows where it must.
    pub(crate) fn allocate(&mut self, pool: Pool, len: u32) -> Result<Range<u32>, PatternError> {
        if len == 0 {
            return Ok(0..0);
        }
        let max = u32::try_from(self.max_bytes / pool.element()).unwrap_or(u32::MAX);
        let space = &mut self.spaces[pool as usize];
        let range = match space.ranges.allocate_range(len) {
            Ok(range) => range,
            Err(_) => {
                let end = space.ranges.initial_range().end;
                let needed = u64::from(end) + u64::from(len);
                let capacity = end.saturating_mul(2).max(end.saturating_add(len)).min(max);
                if capacity > end {
                    space.ranges.grow_to(capacity);
                    self.grown = true;
                }
                space.ranges.allocate_range(len).map_err(|_| PatternError::GpuLimit {
                    limit: "max_storage_buffer_binding_size",
                    found: self.max_bytes,
                    needed: needed * pool.element(),
                })?
            }
        };
        space.used += u64::from(len);
        Ok(range)
    }

    /// Gives a range back.
    pub(crate) fn free(&mut self, pool: Pool, range: Range<u32>) {
        if !range.is_empty() {
            self.spaces[pool as usize].used -= u64::from(range.end - range.start);
            self.spaces[pool as usize].ranges.free_range(range);
        }
    }

    /// Writes `data` from element `first` on, before the next solve.
    pub(crate) fn write<T: Pod>(&mut self, pool: Pool, first: u32, data: &[T]) {
        if !data.is_empty() {
            let bytes = bytemuck::cast_slice(data).to_vec();
            self.uploads.push(Upload {
                pool,
                offset: u64::from(first) * pool.element(),
                bytes,
            });
        }
    }

    pub(crate) fn take_uploads(&mut self) -> Vec<Upload> {
        std::mem::take(&mut self.uploads)
    }
}

/// Makes the shared buffers, within the device's limits.
pub(crate) fn create_buffers(world: &mut World) {
    let limits = world.get_resource::<RenderDevice>().map(RenderDevice::limits);
    world.resource_scope(|world, mut arena: Mut<PatternArena>| {
        if let Some(limits) = limits {
            arena.max_bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        }
        arena.grown = false;
        let mut buffers = world.resource_mut::<Assets<ShaderBuffer>>();
        for pool in Pool::ALL {
            let mut buffer = ShaderBuffer::default();
            buffer.buffer_description.label = Some(pool.label());
            buffer.buffer_description.size = arena.capacity(pool);
            buffer.buffer_description.usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            // The handles' ids are constants, which always have a place.
            if buffers.insert(&pool.handle(), buffer).is_err() {
                error!("the shared pattern buffer {} could not be made", pool.label());
            }
        }
    });
}

/// Resizes the buffers of pools that have grown.
pub(crate) fn grow_buffers(
    mut arena: ResMut<PatternArena>,
    mut buffers: ResMut<Assets<ShaderBuffer>>,
    mut generation: ResMut<crate::material::BufferGeneration>,
) {
    if !arena.grown {
        return;
    }
    arena.grown = false;
    for pool in Pool::ALL {
        let capacity = arena.capacity(pool);
        let small = buffers
            .get(&pool.handle())
            .is_some_and(|buffer| buffer.buffer_description.size < capacity);
        if small && let Some(mut buffer) = buffers.get_mut(&pool.handle()) {
            buffer.resize_in_place(capacity);
        }
    }
    generation.0 += 1;
}
