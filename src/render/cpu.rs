//! The path tracer on all cores of this machine.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec2;
use rayon::prelude::*;

use super::film::Film;
use super::renderer::{RenderTask, Renderer, Unsupported};
use super::settings::Estimator;
use crate::rectify::containment::medium_at;
use crate::rectify::start::StartRegion;
use crate::scene::camera::Camera;
use crate::scene::needs::SceneNeeds;
use crate::tracking::{Events, Tracker, WithTracker};
use crate::transport::dimension;
use crate::transport::interaction::TrackedScene;
use crate::transport::path::{Batch, PathTracer};
use crate::transport::sampler::Sampler;

/// Renders on rayon's current pool.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cpu;

impl Renderer for Cpu {
    fn require(&self, task: &RenderTask<'_>) -> Result<(), Unsupported> {
        match task.settings.estimator {
            Estimator::Path => Ok(()),
        }
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
        let tracer = PathTracer {
            tracked: TrackedScene {
                scene,
                tracker,
                needs: SceneNeeds { image_environment: samples_environment, ..needs },
            },
            max_depth: settings.max_depth.unwrap_or(u32::MAX),
            splits: settings.splits,
        };
        let camera = Camera { position: camera.position - scene.geometry.origin, ..*camera };
        let ask = |point| tracker.medium_at(point).unwrap_or_else(|| medium_at(scene, point));
        let lens = StartRegion::by_asking(scene, camera.position, camera.aperture_radius, &ask);
        let film = self.film;
        let width = film.width;
        let size = DVec2::new(f64::from(film.width), f64::from(film.height));
        let samples = film.next_samples(self.samples);

        let rows: Vec<Option<Events>> = (film.rows().into_par_iter().enumerate())
            .map_init(Batch::<T::State>::default, |batch, (row, mut target)| {
                batch.events = Events::default();
                let first_pixel = row * width as usize;
                let before = target.saved();
                let ahead = target.ahead;
                let samples_of = |pixel: usize| samples.of_pixel(pixel, ahead);
                // Where the next radiance goes.
                let mut columns = (0..width as usize)
                    .flat_map(|column| std::iter::repeat_n(column, samples_of(first_pixel + column).len()));
                let mut trace = |batch: &mut Batch<T::State>| {
                    tracer.trace(batch);
                    let mut events = Events::default();
                    for ((radiance, segments), column) in batch.drain().zip(&mut columns) {
                        target.add(column, radiance, segments, &mut events);
                    }
                    batch.events += events;
                };
                for column in 0..width {
                    // A row can take a third of a second, which is too long to wait for an image that is out of date.
                    if self.cancel.load(Ordering::Relaxed) {
                        drop(batch.drain());
                        target.restore(&before);
                        return None;
                    }
                    let pixel = first_pixel + column as usize;
                    for sample in samples_of(pixel) {
                        let sampler = Sampler::of(settings.sampler, settings.seed, pixel as u32, sample);
                        let [x, y] = sampler.get_2d(dimension::PIXEL);
                        let at = DVec2::new(f64::from(column) + x, row as f64 + y);
                        let ray = camera.ray(at, size, lens_point(&camera, &sampler));
                        batch.add(&lens.start_by_asking(scene, ray, &ask), sampler, &tracer);
                        if batch.is_full() {
                            trace(batch);
                        }
                    }
                }
                trace(batch);
                Some(batch.events)
            })
            .collect();
        film.finish_pass(self.samples, &rows)
    }
}

/// A point of the unit disc, uniform by area (Shirley and Chiu 1997).
fn lens_point(camera: &Camera, sampler: &Sampler) -> DVec2 {
    if camera.aperture_radius == 0.0 {
        return DVec2::ZERO;
    }
    let u = DVec2::from(sampler.get_2d(dimension::LENS)) * 2.0 - 1.0;
    if u == DVec2::ZERO {
        return u;
    }
    let quarter = std::f64::consts::FRAC_PI_4;
    let (r, angle) =
        if u.x.abs() > u.y.abs() { (u.x, quarter * u.y / u.x) } else { (u.y, 2.0 * quarter - quarter * u.x / u.y) };
    DVec2::from_angle(angle) * r
}
