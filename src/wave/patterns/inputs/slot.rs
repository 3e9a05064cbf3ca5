//! A range of a shared buffer that is as long as what it holds.

use crate::{
    error::PatternError,
    wave::arena::{PatternArena, Pool},
};
use std::ops::Range;

/// Owned memory, or none.
#[derive(Debug, Default)]
pub(in crate::wave::patterns) struct Slot(Option<(Pool, Range<u32>)>);

impl Slot {
    /// The first of `len` elements; memory of another length is exchanged, and its content lost.
    pub(in crate::wave::patterns) fn fit(
        &mut self,
        arena: &mut PatternArena,
        pool: Pool,
        len: u32,
    ) -> Result<u32, PatternError> {
        if let Some((of, range)) = &self.0
            && *of == pool
            && range.end - range.start == len
        {
            return Ok(range.start);
        }
        self.free(arena);
        let range = arena.allocate(pool, len)?;
        let first = range.start;
        self.0 = Some((pool, range));
        Ok(first)
    }

    pub(in crate::wave::patterns) fn free(&mut self, arena: &mut PatternArena) {
        if let Some((pool, range)) = self.0.take() {
            arena.free(pool, range);
        }
    }
}
