//! The scalars of a pattern, for its styles and for frequencies that follow from them.

use super::{Pattern, PatternedItem, Stage};
use crate::{
    error::PatternError,
    field::{DirectionField, scalars},
    wave::{
        arena::{PatternArena, Pool},
        layout::SOURCE_SCALARS,
    },
};

/// Uploads scalars that have changed, makes room for those of tensors; whether they are new.
pub(super) fn update(
    pattern: &mut Pattern,
    item: &PatternedItem,
    stage: &Stage,
    arena: &mut PatternArena,
) -> Result<bool, PatternError> {
    let len = stage.graph.len() as u32;
    let (sources, record) = (&mut pattern.sources, &mut pattern.record);
    record.sources &= !SOURCE_SCALARS;
    sources.scalars_given = item.scalars.is_some();
    if let Some(given) = &item.scalars {
        record.scalar_base = sources.scalars.fit(arena, Pool::Wave, len)?;
        let stale = stage.change.all || stage.change.attributes || stage.change.scalars;
        if stale {
            arena.write(
                Pool::Wave,
                record.scalar_base,
                &scalars(given, stage.graph, stage.mesh()?)?,
            );
        }
        return Ok(stale);
    }
    if matches!(*item.field, DirectionField::Tensor(_)) {
        record.scalar_base = sources.scalars.fit(arena, Pool::Wave, len)?;
        record.sources |= SOURCE_SCALARS;
    } else {
        record.scalar_base = 0;
        sources.scalars.free(arena);
    }
    Ok(false)
}
