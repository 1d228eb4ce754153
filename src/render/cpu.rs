//! Passes over the image on all cores.

use std::sync::atomic::AtomicBool;

use super::film::Film;
use super::prepare::Prepared;
use crate::scene::camera::Camera;
use crate::tracking::Mode;

/// What decides an image, next to the scene and the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RenderSettings {
    pub mode: Mode,
    pub seed: u64,
    /// Cap on the segments of a path, the camera's first being one; `None`: no cap.
    pub max_depth: Option<u32>,
    /// Whether work that the scene does not need is left out. Off only to measure what that saves.
    pub leave_out: bool,
}

/// Adds `samples` samples to every pixel of `film`, on rayon's current pool. The result depends on the settings, the scene, the camera
/// and the film's size and earlier samples, not on threads. `camera` is in scene coordinates.
///
/// Returns `false` when `cancel` was set before all was done: the film is then incomplete and should be dropped.
pub fn accumulate(
    prepared: &Prepared,
    camera: &Camera,
    settings: &RenderSettings,
    film: &mut Film,
    samples: u32,
    cancel: &AtomicBool,
) -> bool {
    let _ = (prepared, camera, settings, film, samples, cancel);
    todo!("core")
}
