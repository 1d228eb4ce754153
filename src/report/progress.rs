//! How long work tells how far it is, and is told to stop.

use std::sync::atomic::{AtomicBool, Ordering};

/// What a measurement is watched by. Shared by reference: telling must be cheap, and may come from any thread.
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
