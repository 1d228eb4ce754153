//! Rendering on all cores of this machine.

mod iterations;
mod paths;

use std::sync::atomic::AtomicBool;

use super::film::Film;
use super::renderer::{RenderTask, Renderer, Unsupported};
use super::settings::Estimator;
use crate::rectify::containment::medium_at;
use crate::rectify::start::StartRegion;
use crate::scene::camera::Camera;
use crate::scene::needs::SceneNeeds;
use crate::tracking::{Tracker, WithTracker};
use crate::transport::interaction::TrackedScene;

/// Renders on rayon's current pool.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cpu;

impl Renderer for Cpu {
    fn require(&self, _task: &RenderTask<'_>) -> Result<(), Unsupported> {
        Ok(())
    }

    fn pass(&self, task: &RenderTask<'_>, film: &mut Film, samples: u32, cancel: &AtomicBool) -> bool {
        task.prepared.with_tracker(task.settings.mode, Pass { task, film, samples, cancel })
    }
}

struct Pass<'a, 'f> {
    task: &'a RenderTask<'a>,
    film: &'f mut Film,
    samples: u32,
    cancel: &'a AtomicBool,
}

impl WithTracker for Pass<'_, '_> {
    type Output = bool;

    fn run<T: Tracker>(self, tracker: &T) -> bool {
        let RenderTask { prepared, camera, settings } = *self.task;
        let scene = &*prepared.scene;
        let needs = if settings.leave_out { scene.needs } else { SceneNeeds::EVERYTHING.without_impossible(scene) };
        let samples_environment = needs.image_environment && settings.sample_environment;
        let needs = SceneNeeds { image_environment: samples_environment, ..needs };
        let tracked = TrackedScene { scene, tracker, needs };
        let camera = Camera { position: camera.position - scene.geometry.origin, ..*camera };
        let ask = |point| tracker.medium_at(point).unwrap_or_else(|| medium_at(scene, point));
        let lens = StartRegion::by_asking(scene, camera.position, camera.aperture_radius, &ask);
        match settings.estimator {
            Estimator::Path => self.paths(tracked, &camera, &lens, &ask),
            Estimator::Bidirectional | Estimator::Merging => self.iterations(tracked, &camera, &lens, &ask),
        }
    }
}
