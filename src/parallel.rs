//! Loops over vertices or samples, spread over Bevy's compute threads.

use bevy::tasks::ComputeTaskPool;

/// Vertices per task: enough work to pay for a task, small enough to balance.
const CHUNK: usize = 8192;

/// `out[i] = f(i)` for all i. In parallel where Bevy's compute pool exists and there is enough to do.
pub(crate) fn fill<T: Send>(out: &mut [T], f: impl Fn(usize) -> T + Send + Sync) {
    fill_by(CHUNK, out, f);
}

/// [`fill`] with `size` items per task, for items that are much work each.
pub(crate) fn fill_by<T: Send>(size: usize, out: &mut [T], f: impl Fn(usize) -> T + Send + Sync) {
    let fill_chunk = |chunk: usize, values: &mut [T]| {
        for (k, value) in values.iter_mut().enumerate() {
            *value = f(chunk * size + k);
        }
    };
    let chunks = out.chunks_mut(size).enumerate();
    match ComputeTaskPool::try_get() {
        Some(pool) if chunks.len() > 1 && pool.thread_num() > 1 => {
            let fill_chunk = &fill_chunk;
            pool.scope(|scope| {
                chunks.for_each(|(chunk, values)| scope.spawn(async move { fill_chunk(chunk, values) }));
            });
        }
        _ => chunks.for_each(|(chunk, values)| fill_chunk(chunk, values)),
    }
}

/// The vector of `f(i)` for i in `0..len`.
pub(crate) fn collect<T: Send + Clone + Default>(len: usize, f: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    let mut out = vec![T::default(); len];
    fill(&mut out, f);
    out
}

/// [`collect`] with `size` items per task, for items that are much work each.
pub(crate) fn collect_by<T: Send + Clone + Default>(
    size: usize,
    len: usize,
    f: impl Fn(usize) -> T + Send + Sync,
) -> Vec<T> {
    let mut out = vec![T::default(); len];
    fill_by(size, &mut out, f);
    out
}
