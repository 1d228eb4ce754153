//! The renderers, by their backends.

use std::sync::atomic::{AtomicBool, Ordering};

use super::cpu::Cpu;
use super::film::Film;
#[cfg(feature = "gpu")]
use super::gpu::SharedGpu;
use super::renderer::{RenderTask, Renderer, Unsupported};
use super::settings::Backend;
use crate::tracking::Mode;

/// The renderer of a backend. Without the Cargo feature `gpu` there is only one.
pub fn renderer(backend: Backend) -> &'static dyn Renderer {
    match backend {
        Backend::Cpu | Backend::Mixed => &Cpu,
        #[cfg(feature = "gpu")]
        Backend::Gpu => &SharedGpu,
        #[cfg(not(feature = "gpu"))]
        Backend::Gpu => &Cpu,
    }
}

/// The modes that the graphics processor renders: all but [`Mode::Reference`], which is computed in f64.
pub const GPU_MODES: [Mode; 6] =
    [Mode::Naive, Mode::Declared, Mode::Stack, Mode::Priority, Mode::RectifiedObject, Mode::Rectified];

/// What renders in `mode` where `backend` is asked for: modes other than [`GPU_MODES`] are always rendered by the CPU.
pub fn backend_of(mode: Mode, backend: Backend) -> Backend {
    if !GPU_MODES.contains(&mode) || cfg!(not(feature = "gpu")) { Backend::Cpu } else { backend }
}

impl RenderTask<'_> {
    /// Whether the backend that the settings name can do this: see [`Renderer::require`].
    ///
    /// # Errors
    /// When it cannot: why, and what to do instead.
    pub fn require(&self) -> Result<(), Unsupported> {
        renderer(self.backend()).require(self)
    }

    /// A pass over `film` by the backend that the settings name: see [`Renderer::pass`]. Where its device fails, the CPU goes on, and
    /// [`Film::backend`] says so.
    pub fn pass(&self, film: &mut Film, samples: u32, cancel: &AtomicBool) -> bool {
        let is_complete = self.try_pass(film, samples, cancel);
        let has_failed = !is_complete && self.backend() == Backend::Gpu && !cancel.load(Ordering::Relaxed);
        if !has_failed {
            return is_complete;
        }
        let is_complete = Cpu.pass(self, film, samples, cancel);
        film.rendered_by(Backend::Cpu);
        is_complete
    }

    /// [`Self::pass`] without another backend that steps in.
    pub fn try_pass(&self, film: &mut Film, samples: u32, cancel: &AtomicBool) -> bool {
        let backend = self.backend();
        let before = film.samples;
        let is_complete = renderer(backend).pass(self, film, samples, cancel);
        // Of a pass that failed, rows that were finished are kept.
        if film.samples > before || film.ahead.iter().any(|ahead| *ahead > 0) {
            film.rendered_by(backend);
        }
        is_complete
    }

    fn backend(&self) -> Backend {
        backend_of(self.settings.mode, self.settings.backend)
    }
}
