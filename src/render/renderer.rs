//! What renders: one interface for every backend and estimator.

use std::sync::atomic::AtomicBool;

use super::film::Film;
use super::settings::{Backend, ImageSettings};
use crate::scene::camera::Camera;
use crate::tracking::Prepared;

/// What is to be rendered, but for its size and samples, which are its film's.
#[derive(Debug, Clone, Copy)]
pub struct RenderTask<'a> {
    pub prepared: &'a Prepared,
    /// In scene coordinates.
    pub camera: &'a Camera,
    pub settings: &'a ImageSettings,
}

/// A way to render.
pub trait Renderer: Sync {
    /// Whether this renderer can render `task`.
    ///
    /// # Errors
    /// When it cannot: why, and what to do instead.
    fn require(&self, task: &RenderTask<'_>) -> Result<(), Unsupported>;

    /// Whether a pass can begin soon; else [`Self::make_ready`] takes a while, and the first pass as long.
    fn is_ready(&self, _task: &RenderTask<'_>) -> bool {
        true
    }

    /// Does what takes long before the first pass of such a task: compiles shaders.
    ///
    /// # Errors
    /// When it turns out that it cannot be rendered.
    fn make_ready(&self, task: &RenderTask<'_>) -> Result<(), Unsupported> {
        self.require(task)
    }

    /// Adds `samples` samples to every pixel of `film`; with an allocation, in the mean. The result depends on the task and on the film's size
    /// and earlier samples, not on how work is divided.
    ///
    /// Returns `false` when `cancel` was set before all was done. A film that [`Film::is_resumable`] has kept each row that was finished
    /// and can be gone on with: the next pass takes what is missing. Another one is spoilt.
    ///
    /// Also `false` where the device fails meanwhile: the film has kept each row that was finished, and none in part, so that another renderer
    /// can go on with it.
    fn pass(&self, task: &RenderTask<'_>, film: &mut Film, samples: u32, cancel: &AtomicBool) -> bool;
}

/// What a renderer cannot do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{what} cannot be rendered by the backend {}; {instead}", backend.name())]
pub struct Unsupported {
    pub what: String,
    pub backend: Backend,
    pub instead: String,
}
