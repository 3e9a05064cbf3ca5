//! The memory of patterns: shared GPU buffers, of which meshes and entities own ranges.
//!
//! In: what a room wants to keep (ranges of its [`Pool`]s) and write. Out: who owns what, and the uploads of a frame. The
//! main world decides; the render world owns the buffers themselves. A buffer that is too small doubles, and keeps its
//! contents.

use crate::error::PatternError;
use bevy::{
    prelude::*,
    render::{render_resource::BufferUsages, renderer::RenderDevice, storage::ShaderBuffer},
};
use bytemuck::Pod;
use range_alloc::RangeAllocator;
use std::ops::Range;

/// A room's shared buffers, as an enum.
pub trait Pool: Copy + Send + Sync + 'static {
    /// All of them, in the order of [`index`](Self::index).
    const ALL: &'static [Self];

    /// The place in [`ALL`](Self::ALL).
    fn index(self) -> usize;

    /// The buffer; its id is a constant, so that materials can name it by default.
    fn handle(self) -> Handle<ShaderBuffer>;

    /// The buffer's name in GPU tools.
    fn label(self) -> &'static str;

    /// Bytes of one element.
    fn element(self) -> u64;
}

/// Elements at the start of every buffer that nobody owns and that stay 0: the record of no pattern.
pub(crate) const RESERVED: u32 = 32;
const FIRST_CAPACITY: u32 = 1 << 14;

/// Bytes to write into a shared buffer.
#[derive(Debug)]
pub(crate) struct Upload<P> {
    pub(crate) pool: P,
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
    /// Bytes owned by meshes and entities.
    pub used: u64,
    /// Bytes of the shared buffers.
    pub allocated: u64,
}

/// Who owns which part of a room's shared buffers.
#[derive(Resource, Debug)]
pub struct Arena<P: Pool> {
    spaces: Vec<Space>,
    uploads: Vec<Upload<P>>,
    max_bytes: u64,
    grown: bool,
}

impl<P: Pool> Default for Arena<P> {
    fn default() -> Self {
        let space = |_: &P| Space {
            ranges: RangeAllocator::new(RESERVED..FIRST_CAPACITY),
            used: 0,
        };
        Self {
            spaces: P::ALL.iter().map(space).collect(),
            uploads: Vec::new(),
            max_bytes: 128 << 20,
            grown: true,
        }
    }
}

impl<P: Pool> Arena<P> {
    /// Bytes used and allocated on the GPU, of all buffers together.
    pub fn memory(&self) -> PatternMemory {
        P::ALL
            .iter()
            .fold(PatternMemory::default(), |sum, &pool| PatternMemory {
                used: sum.used + self.spaces[pool.index()].used * pool.element(),
                allocated: sum.allocated + self.capacity(pool),
            })
    }

    /// Bytes of a shared buffer.
    pub(crate) fn capacity(&self, pool: P) -> u64 {
        u64::from(self.spaces[pool.index()].ranges.initial_range().end) * pool.element()
    }

    /// A range of `len` elements; the buffer grows where it must.
    pub(crate) fn allocate(&mut self, pool: P, len: u32) -> Result<Range<u32>, PatternError> {
        if len == 0 {
            return Ok(0..0);
        }
        let max = u32::try_from(self.max_bytes / pool.element()).unwrap_or(u32::MAX);
        let space = &mut self.spaces[pool.index()];
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
    pub(crate) fn free(&mut self, pool: P, range: Range<u32>) {
        if !range.is_empty() {
            self.spaces[pool.index()].used -= u64::from(range.end - range.start);
            self.spaces[pool.index()].ranges.free_range(range);
        }
    }

    /// Writes `data` from element `first` on, before the next frame is drawn.
    pub(crate) fn write<T: Pod>(&mut self, pool: P, first: u32, data: &[T]) {
        if !data.is_empty() {
            let bytes = bytemuck::cast_slice(data).to_vec();
            self.uploads.push(Upload {
                pool,
                offset: u64::from(first) * pool.element(),
                bytes,
            });
        }
    }

    pub(crate) fn take_uploads(&mut self) -> Vec<Upload<P>> {
        std::mem::take(&mut self.uploads)
    }
}

/// Makes a room's shared buffers, within the device's limits.
pub(crate) fn create_buffers<P: Pool>(world: &mut World) {
    let limits = world.get_resource::<RenderDevice>().map(RenderDevice::limits);
    world.resource_scope(|world, mut arena: Mut<Arena<P>>| {
        if let Some(limits) = limits {
            arena.max_bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        }
        arena.grown = false;
        let mut buffers = world.resource_mut::<Assets<ShaderBuffer>>();
        for &pool in P::ALL {
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
pub(crate) fn grow_buffers<P: Pool>(
    mut arena: ResMut<Arena<P>>,
    mut buffers: ResMut<Assets<ShaderBuffer>>,
    mut generation: ResMut<crate::material::BufferGeneration>,
) {
    if !arena.grown {
        return;
    }
    arena.grown = false;
    for &pool in P::ALL {
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
