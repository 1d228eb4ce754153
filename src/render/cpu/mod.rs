//! Rendering on all cores of this machine.

mod iterations;
mod paths;

use std::sync::atomic::AtomicBool;

use super::film::Film;
use super::renderer::{RenderTask, Renderer, Unsupported};
use super::settings::Estimator;
use crate::rectify::containment::medium_at;
use crate::rectify::start::{Ask, StartRegion};
use crate::scene::camera::Camera;
use crate::scene::needs::SceneNeeds;
use crate::tracking::{Tracker, WithTracker};
use crate::transport::aim::Aims;
use crate::transport::bidirectional::Bidirectional;
use crate::transport::caustics::CausticNoise;
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

/// What caustics would do to the image of a task, whose pixels have this radiance.
pub(super) fn caustic_noise(task: &RenderTask<'_>, size: [u32; 2], light_paths: u32, radiance: &[f64]) -> CausticNoise {
    struct Judge<'a>(&'a RenderTask<'a>, [u32; 2], u32, &'a [f64]);

    impl WithTracker for Judge<'_> {
        type Output = CausticNoise;

        fn run<T: Tracker>(self, tracker: &T) -> CausticNoise {
            let Self(task, size, light_paths, radiance) = self;
            with_view(task, tracker, |view| {
                let bidirectional = iterations::bidirectional(task, &view, size, true);
                Bidirectional { light_paths, ..bidirectional }.caustic_noise(radiance)
            })
        }
    }

    task.prepared.with_tracker(task.settings.mode, Judge(task, size, light_paths, radiance))
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
        with_view(self.task, tracker, |view| match self.task.settings.estimator {
            Estimator::Path => self.paths(&view),
            Estimator::Bidirectional | Estimator::Merging => self.iterations(&view),
        })
    }
}

/// A scene with a mode at work in it, and where it is seen from.
struct View<'a, T> {
    tracked: TrackedScene<'a, T>,
    /// Local coordinates.
    camera: Camera,
    lens: StartRegion,
    ask: Ask<'a>,
    /// What subpaths from lights are aimed at.
    aims: Aims,
}

fn with_view<T: Tracker, R>(task: &RenderTask<'_>, tracker: &T, work: impl FnOnce(View<'_, T>) -> R) -> R {
    let RenderTask { prepared, camera, settings } = *task;
    let scene = &*prepared.scene;
    let needs = if settings.leave_out { scene.needs } else { SceneNeeds::EVERYTHING.without_impossible(scene) };
    let samples_environment = needs.image_environment && settings.sample_environment;
    let needs = SceneNeeds { image_environment: samples_environment, ..needs };
    let camera = Camera { position: camera.position - scene.geometry.origin, ..*camera };
    let told = tracker.camera_medium().map(|medium| (medium, false));
    let ask = |point| told.or_else(|| tracker.medium_at(point)).unwrap_or_else(|| medium_at(scene, point));
    let lens = StartRegion::by_asking(scene, camera.position, camera.aperture_radius, &ask);
    let aims = if settings.estimator == Estimator::Path { Aims::default() } else { Aims::of(scene) };
    work(View { tracked: TrackedScene { scene, tracker, needs }, camera, lens, ask: &ask, aims })
}
