//! Loops over vertices, spread over Bevy's compute threads.

use bevy::tasks::{ComputeTaskPool, ParallelSliceMut};

/// Vertices per task: enough work to pay for a task, small enough to balance.
const CHUNK: usize = 8192;

/// `out[i] = f(i)` for all i. In parallel where Bevy's compute pool exists and there is enough to do.
pub(super) fn fill<T: Send>(mut out: &mut [T], f: impl Fn(usize) -> T + Send + Sync) {
    let fill_chunk = |chunk: usize, values: &mut [T]| {
        for (k, value) in values.iter_mut().enumerate() {
            *value = f(chunk * CHUNK + k);
        }
    };
    match ComputeTaskPool::try_get() {
        Some(pool) if out.len() > CHUNK && pool.thread_num() > 1 => {
            out.par_chunk_map_mut(pool, CHUNK, fill_chunk);
        }
        _ => out
            .chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(chunk, values)| fill_chunk(chunk, values)),
    }
}

/// The vector of `f(i)` for i in `0..len`.
pub(super) fn collect<T: Send + Clone + Default>(len: usize, f: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    let mut out = vec![T::default(); len];
    fill(&mut out, f);
    out
}
