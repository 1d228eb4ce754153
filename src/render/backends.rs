//! The renderers, by their backends.

use std::sync::atomic::AtomicBool;

use super::cpu::Cpu;
use super::film::Film;
use super::renderer::{RenderTask, Renderer, Unsupported};
use super::settings::Backend;

/// The renderer of a backend.
pub fn renderer(backend: Backend) -> &'static dyn Renderer {
    match backend {
        Backend::Cpu => &Cpu,
    }
}

impl RenderTask<'_> {
    /// Whether the backend that the settings name can do this: see [`Renderer::require`].
    ///
    /// # Errors
    /// When it cannot: why, and what to do instead.
    pub fn require(&self) -> Result<(), Unsupported> {
        renderer(self.settings.backend).require(self)
    }

    /// A pass over `film` by the backend that the settings name: see [`Renderer::pass`].
    pub fn pass(&self, film: &mut Film, samples: u32, cancel: &AtomicBool) -> bool {
        renderer(self.settings.backend).pass(self, film, samples, cancel)
    }
}
