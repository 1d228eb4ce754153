//! How fast each mode renders, measured as it goes.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::job::{FIRST_IMAGE, Job};
use super::preview::PILOT_SHARE;
use crate::render::Backend;
use crate::scene::description::Source;
use crate::tracking::Mode;

/// Pixels of the first pass of a mode that has not been timed in this scene.
const UNTIMED_PIXELS: f64 = 600.0;

/// Measured pixel samples per second of each mode, in one scene by one backend.
#[derive(Debug, Default)]
pub(super) struct Speed {
    scene: Option<Arc<Source>>,
    backend: Backend,
    of_mode: BTreeMap<Mode, f64>,
}

impl Speed {
    /// Forgets what was measured in another scene than the job's, or by another backend.
    pub(super) fn begin(&mut self, job: &Job) {
        let scene = &job.prepared.description.source;
        let backend = job.request.settings.backend;
        if !job.is_of(self.scene.as_ref()) || backend != self.backend {
            *self = Self { scene: scene.clone(), backend, of_mode: BTreeMap::new() };
        }
    }

    pub(super) fn of(&self, mode: Mode) -> Option<f64> {
        self.of_mode.get(&mode).copied()
    }

    pub(super) fn learn(&mut self, mode: Mode, samples_per_second: f64) {
        let speed = self.of_mode.entry(mode).or_insert(samples_per_second);
        // Slower at once, faster with caution: a late image is worse than a coarse one.
        let weight = if samples_per_second < *speed { 0.7 } else { 0.2 };
        *speed += weight * (samples_per_second - *speed);
    }

    /// Seconds that one sample of every one of `modes` should take at full size. A mode that has not been timed is taken for one that renders
    /// [`UNTIMED_PIXELS`] in a pilot's time.
    pub(super) fn seconds_of(&self, modes: impl Iterator<Item = Mode>, size: [u32; 2]) -> f64 {
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        let untimed = UNTIMED_PIXELS / (PILOT_SHARE * FIRST_IMAGE.as_secs_f64());
        modes.map(|mode| pixels / self.of(mode).unwrap_or(untimed)).sum()
    }
}
