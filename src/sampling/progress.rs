//! How far a sampler has come, seen from another thread.

use crate::error::PatternError;
use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicU32, Ordering::Relaxed},
};

/// Shared by a sampler and whoever waits for it; clones are the same progress.
#[derive(Debug, Clone, Default)]
pub struct Progress(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    done: AtomicU32,
    cancelled: AtomicBool,
}

impl Progress {
    /// The part that is done, 0..=1.
    pub fn done(&self) -> f32 {
        f32::from_bits(self.0.done.load(Relaxed))
    }

    /// Asks the sampler to stop at the next step; it returns [`PatternError::Cancelled`].
    pub fn cancel(&self) {
        self.0.cancelled.store(true, Relaxed);
    }

    /// Says how much is done.
    ///
    /// # Errors
    /// [`PatternError::Cancelled`] where somebody has asked to stop.
    pub fn report(&self, done: f32) -> Result<(), PatternError> {
        self.0.done.store(done.to_bits(), Relaxed);
        self.check()
    }

    /// Goes on, unless somebody has asked to stop.
    ///
    /// # Errors
    /// [`PatternError::Cancelled`] where somebody has.
    pub fn check(&self) -> Result<(), PatternError> {
        if self.0.cancelled.load(Relaxed) {
            return Err(PatternError::Cancelled);
        }
        Ok(())
    }
}
