//! Progress of long work, and its cancellation.

use std::sync::atomic::{AtomicBool, Ordering};

/// Progress and cancellation of a measurement. `tell` must be cheap, and may be called from any thread.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    /// Set from outside when the work should end soon; what was finished by then is kept.
    pub cancel: &'a AtomicBool,
    /// Told what is being done, and how much of the whole is done, in [0, 1].
    pub tell: &'a (dyn Fn(&str, f64) + Sync),
}

impl Progress<'_> {
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}
