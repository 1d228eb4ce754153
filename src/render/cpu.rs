//! Passes over the image on all cores.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec2;
use rayon::prelude::*;

use super::events::Events;
use super::film::Film;
use super::prepare::Prepared;
use crate::estimator::path::{PathTracer, Scratch, dimension};
use crate::estimator::sampler::Sampler;
use crate::rectify::start::StartRegion;
use crate::scene::camera::Camera;
use crate::scene::needs::SceneNeeds;
use crate::tracking::naive::Naive;
use crate::tracking::priority::Priority;
use crate::tracking::rectified::{Rectified, RectifiedObject};
use crate::tracking::reference::Reference;
use crate::tracking::stack::Stack;
use crate::tracking::{Mode, Tracker};

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
    let pass = Pass { prepared, camera, settings, samples, cancel };
    match settings.mode {
        Mode::Naive => pass.run(&Naive, film),
        Mode::Stack => pass.run(&Stack, film),
        Mode::Priority => pass.run(&Priority { world: &prepared.world }, film),
        Mode::RectifiedObject => pass.run(&RectifiedObject::new(&prepared.world, &prepared.table), film),
        Mode::Rectified => pass.run(&Rectified { world: &prepared.world, table: &prepared.table }, film),
        Mode::Reference => pass.run(&Reference { world: &prepared.world }, film),
    }
}

struct Pass<'a> {
    prepared: &'a Prepared,
    camera: &'a Camera,
    settings: &'a RenderSettings,
    samples: u32,
    cancel: &'a AtomicBool,
}

impl Pass<'_> {
    fn run<T: Tracker>(&self, tracker: &T, film: &mut Film) -> bool {
        let world = &*self.prepared.world;
        let tracer = PathTracer {
            world,
            tracker,
            needs: if self.settings.leave_out { world.needs } else { SceneNeeds::EVERYTHING.without_impossible(world) },
            max_depth: self.settings.max_depth.unwrap_or(u32::MAX),
        };
        let camera = Camera { position: self.camera.position - world.geometry.origin, ..*self.camera };
        let lens = StartRegion::new(world, camera.position, camera.aperture_radius);
        let width = film.width;
        let size = DVec2::new(f64::from(film.width), f64::from(film.height));
        let first = film.samples;

        let events = (film.sums.par_chunks_mut(width as usize))
            .zip(film.counts.par_chunks_mut(width as usize))
            .enumerate()
            .map_init(Scratch::<T::State>::default, |scratch, (row, (sums, counts))| {
                scratch.events = Events::default();
                for (column, (sum, count)) in sums.iter_mut().zip(counts).enumerate() {
                    // A row can take a third of a second, which is too long to wait for an image that is out of date.
                    if self.cancel.load(Ordering::Relaxed) {
                        return Events::default();
                    }
                    let pixel = row as u32 * width + column as u32;
                    for sample in first..first + self.samples {
                        let sampler = Sampler::new(self.settings.seed, pixel, sample);
                        let [x, y] = sampler.get_2d(dimension::PIXEL);
                        let at = DVec2::new(column as f64 + x, row as f64 + y);
                        let ray = camera.ray(at, size, lens_point(&camera, &sampler));
                        let start = lens.start(world, ray);
                        scratch.events.ambiguous += u64::from(start.is_ambiguous);
                        let radiance = tracer.radiance(start.ray, start.medium, &sampler, scratch);
                        if radiance.is_finite() {
                            *sum += radiance;
                            *count += 1;
                        } else {
                            scratch.events.non_finite += 1;
                        }
                    }
                }
                scratch.events
            })
            .reduce(Events::default, |mut a, b| {
                a += b;
                a
            });
        if self.cancel.load(Ordering::Relaxed) {
            return false;
        }
        film.events += events;
        film.samples += self.samples;
        true
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
