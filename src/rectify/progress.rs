//! How far a rectification has come, for whoever waits for it, and a way to end it early.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};

named! {
    /// What is being done, in this order.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord)]
    pub enum Stage {
        /// Meshes are analysed and the tree is built, before rectification begins.
        #[default]
        Meshes = "meshes",
        /// Which faces other surfaces touch.
        Contacts = "contacts",
        /// Rays vote about whole objects.
        Votes = "votes",
        /// Touched faces are divided.
        Cells = "cells",
    }
}

impl Stage {
    pub const ALL: [Self; 4] = [Self::Meshes, Self::Contacts, Self::Votes, Self::Cells];
}

/// Time spent on each part, in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct RectifySeconds {
    /// Analysis of the meshes.
    pub topology: f64,
    /// Contacts, cells, patches.
    pub patches: f64,
    /// Rays and their votes.
    pub pretrace: f64,
    /// From votes to media.
    pub resolve: f64,
}

impl RectifySeconds {
    pub fn total(&self) -> f64 {
        self.topology + self.patches + self.pretrace + self.resolve
    }
}

/// The work was cancelled and has no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Shared between the thread that rectifies and those that watch it.
#[derive(Debug, Default)]
pub struct Progress {
    is_cancelled: AtomicBool,
    stage: AtomicU8,
    done: AtomicU64,
    total: AtomicU64,
}

impl Progress {
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks the work to end soon, without a result.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    pub fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }

    /// The current stage, and the share of it that is done, in [0, 1].
    pub fn state(&self) -> (Stage, f64) {
        let stage = Stage::ALL[usize::from(self.stage.load(Ordering::Relaxed)) % Stage::ALL.len()];
        let (done, total) = (self.done.load(Ordering::Relaxed), self.total.load(Ordering::Relaxed));
        (stage, if total == 0 { 0.0 } else { (done as f64 / total as f64).min(1.0) })
    }

    /// Begins a stage of so many steps.
    pub(super) fn enter(&self, stage: Stage, steps: usize) -> Result<(), Cancelled> {
        self.done.store(0, Ordering::Relaxed);
        self.total.store(steps as u64, Ordering::Relaxed);
        self.stage.store(stage as u8, Ordering::Relaxed);
        self.go_on()
    }

    /// Steps of the current stage are done.
    pub(super) fn advance(&self, steps: usize) {
        self.done.fetch_add(steps as u64, Ordering::Relaxed);
    }

    /// # Errors
    /// When the work has been cancelled.
    pub fn go_on(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_stages() {
        let progress = Progress::new();
        assert_eq!(progress.state(), (Stage::Meshes, 0.0));
        progress.enter(Stage::Cells, 4).unwrap();
        progress.advance(1);
        assert_eq!(progress.state(), (Stage::Cells, 0.25));
        progress.cancel();
        assert_eq!(progress.enter(Stage::Votes, 1), Err(Cancelled));
    }
}
