//! How fast each mode renders, measured as it goes.

use std::collections::HashMap;
use std::sync::Arc;

use super::job::{FIRST_IMAGE, Job};
use super::preview::PILOT_SHARE;
use crate::render::Backend;
use crate::scene::description::Source;
use crate::tracking::Mode;

/// Pixels of the first pass of a mode that has not been timed in this scene.
const UNTIMED_PIXELS: f64 = 600.0;

/// Measured pixel samples per second of each mode by each backend, in one scene.
#[derive(Debug, Default)]
pub(super) struct Speed {
    scene: Option<Arc<Source>>,
    /// Whether the graphics processor computes on the CPU.
    is_software: bool,
    of_mode: HashMap<(Mode, Backend), f64>,
}

impl Speed {
    /// Forgets what was measured in another scene than the job's.
    pub(super) fn begin(&mut self, job: &Job, is_software: bool) {
        let scene = &job.prepared.description.source;
        if !job.is_of(self.scene.as_ref()) {
            *self = Self { scene: scene.clone(), ..Self::default() };
        }
        self.is_software = is_software;
    }

    pub(super) fn of(&self, mode: Mode, backend: Backend) -> Option<f64> {
        self.of_mode.get(&(mode, backend)).copied()
    }

    pub(super) fn learn(&mut self, mode: Mode, backend: Backend, samples_per_second: f64) {
        let speed = self.of_mode.entry((mode, backend)).or_insert(samples_per_second);
        // Slower at once, faster with caution: a late image is worse than a coarse one.
        let weight = if samples_per_second < *speed { 0.7 } else { 0.2 };
        *speed += weight * (samples_per_second - *speed);
    }

    /// What renders the pictures of a mode that are coarser than what is wanted: where the graphics processor renders the film, the CPU if it is faster. One in
    /// software always is slower, most of all where pixels are few.
    pub(super) fn previews_by(&self, mode: Mode, film_by: Backend) -> Backend {
        if film_by == Backend::Cpu || self.is_software {
            return Backend::Cpu;
        }
        match (self.of(mode, Backend::Cpu), self.of(mode, film_by)) {
            (Some(cpu), Some(gpu)) if cpu > gpu => Backend::Cpu,
            _ => film_by,
        }
    }

    /// Seconds that one sample of every one of `modes` should take at full size, each by the backend beside it. A mode that has not been timed is taken for
    /// one that renders [`UNTIMED_PIXELS`] in a pilot's time.
    pub(super) fn seconds_of(&self, modes: impl Iterator<Item = (Mode, Backend)>, size: [u32; 2]) -> f64 {
        let pixels = f64::from(size[0]) * f64::from(size[1]);
        let untimed = UNTIMED_PIXELS / (PILOT_SHARE * FIRST_IMAGE.as_secs_f64());
        modes.map(|(mode, backend)| pixels / self.of(mode, backend).unwrap_or(untimed)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn previews_are_rendered_by_what_is_faster() {
        use Backend::{Cpu, Gpu};
        let mode = Mode::Rectified;
        let mut speed = Speed::default();
        assert_eq!((speed.previews_by(mode, Cpu), speed.previews_by(mode, Gpu)), (Cpu, Gpu));
        speed.learn(mode, Cpu, 1e6);
        assert_eq!(speed.previews_by(mode, Gpu), Gpu);
        speed.learn(mode, Gpu, 1e5);
        assert_eq!((speed.previews_by(mode, Gpu), speed.previews_by(Mode::Naive, Gpu)), (Cpu, Gpu));
        speed.learn(mode, Gpu, 1e8);
        assert_eq!(speed.previews_by(mode, Gpu), Gpu);
        speed.is_software = true;
        assert_eq!(speed.previews_by(mode, Gpu), Cpu);
    }

    #[test]
    fn each_backend_has_its_own_speed() {
        let mut speed = Speed::default();
        speed.learn(Mode::Naive, Backend::Cpu, 1e6);
        speed.learn(Mode::Naive, Backend::Gpu, 1e8);
        let secs = |backend| speed.seconds_of([(Mode::Naive, backend)].into_iter(), [1000, 1000]);
        assert_eq!([Backend::Cpu, Backend::Gpu].map(secs), [1.0, 0.01]);
    }
}
