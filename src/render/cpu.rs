//! Passes over the image on all cores.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec2;
use rayon::prelude::*;

use super::film::Film;
use crate::rectify::containment::medium_at;
use crate::rectify::start::StartRegion;
use crate::scene::camera::Camera;
use crate::scene::needs::SceneNeeds;
use crate::tracking::Events;
use crate::tracking::Prepared;
use crate::tracking::naive::Naive;
use crate::tracking::priority::Priority;
use crate::tracking::rectified::{Rectified, RectifiedObject};
use crate::tracking::stack::Stack;
use crate::tracking::{Mode, Tracker};
use crate::transport::path::{Batch, PathTracer, dimension};
use crate::transport::sampler::{Sampler, Sequence};

/// What decides an image, next to the scene and the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RenderSettings {
    pub mode: Mode,
    pub seed: u64,
    /// Cap on the segments of a path, the camera's first being one; `None`: no cap.
    pub max_depth: Option<u32>,
    /// Whether work that the scene does not need is left out. Off only to measure what that saves.
    pub leave_out: bool,
    pub variance: VarianceReduction,
}

/// What lowers the noise of an image without changing what it converges to. Off only to measure what each brings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VarianceReduction {
    pub sequence: Sequence,
    /// How many interfaces from the camera on paths may split at, into one that is reflected and one that goes through; 0: none.
    pub splits: u32,
    /// Whether image environments are sampled where they are bright.
    pub sample_environment: bool,
}

impl Default for VarianceReduction {
    fn default() -> Self {
        // More splits bring less than they cost.
        Self { sequence: Sequence::Sobol, splits: 2, sample_environment: true }
    }
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
        Mode::Priority => pass.run(&Priority { scene: &prepared.scene }, film),
        Mode::RectifiedObject => pass.run(&RectifiedObject::new(&prepared.scene, &prepared.table), film),
        Mode::Rectified => pass.run(&Rectified { scene: &prepared.scene, table: &prepared.table }, film),
        Mode::Reference => pass.run(&prepared.reference(), film),
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
        let scene = &*self.prepared.scene;
        let needs =
            if self.settings.leave_out { scene.needs } else { SceneNeeds::EVERYTHING.without_impossible(scene) };
        let samples_environment = needs.image_environment && self.settings.variance.sample_environment;
        let tracer = PathTracer {
            scene,
            tracker,
            needs: SceneNeeds { image_environment: samples_environment, ..needs },
            max_depth: self.settings.max_depth.unwrap_or(u32::MAX),
            splits: self.settings.variance.splits,
        };
        let camera = Camera { position: self.camera.position - scene.geometry.origin, ..*self.camera };
        let ask = |point| tracker.medium_at(point).unwrap_or_else(|| medium_at(scene, point));
        let lens = StartRegion::by_asking(scene, camera.position, camera.aperture_radius, &ask);
        let width = film.width;
        let size = DVec2::new(f64::from(film.width), f64::from(film.height));
        let taken = film.samples + self.samples;
        let (first, last) = (film.first + film.samples, film.first + taken);
        let allocation = film.allocation.clone();
        let range = |pixel: usize| match &allocation {
            Some(allocation) => allocation.samples(pixel, first)..allocation.samples(pixel, last),
            None => first..last,
        };
        let pilot: Vec<_> = match &mut film.pilot {
            Some(pilot) => pilot.rows(width as usize).map(Some).collect(),
            None => (0..film.height).map(|_| None).collect(),
        };
        let exact: Vec<_> = match &mut film.exact {
            Some(exact) => exact.rows(width as usize).map(Some).collect(),
            None => (0..film.height).map(|_| None).collect(),
        };

        let events = (film.sums.par_chunks_mut(width as usize))
            .zip(film.counts.par_chunks_mut(width as usize))
            .zip(pilot)
            .zip(exact)
            .enumerate()
            .map_init(Batch::<T::State>::default, |batch, (row, (((sums, counts), mut pilot), mut exact))| {
                batch.events = Events::default();
                let first_pixel = row * width as usize;
                // Where the next radiance goes.
                let mut columns = (0..width as usize)
                    .flat_map(|column| std::iter::repeat_n(column, range(first_pixel + column).len()));
                let mut trace = |batch: &mut Batch<T::State>| {
                    tracer.trace(batch);
                    let (mut non_finite, mut overflows) = (0, 0);
                    for ((radiance, segments), column) in batch.drain().zip(&mut columns) {
                        // What has exact sums takes no sample that these cannot hold.
                        if exact.as_mut().map_or_else(|| radiance.is_finite(), |exact| exact.add(column, radiance)) {
                            sums[column] += radiance;
                            counts[column] += 1;
                            overflows += u64::from(radiance.max_element() > f64::from(f32::MAX));
                        } else {
                            non_finite += 1;
                        }
                        if let Some(pilot) = &mut pilot {
                            pilot.add(column, radiance, segments);
                        }
                    }
                    batch.events.non_finite += non_finite;
                    batch.events.radiance_overflow += overflows;
                };
                for column in 0..width {
                    // A row can take a third of a second, which is too long to wait for an image that is out of date.
                    if self.cancel.load(Ordering::Relaxed) {
                        drop(batch.drain());
                        return Events::default();
                    }
                    let pixel = first_pixel + column as usize;
                    for sample in range(pixel) {
                        let sampler =
                            Sampler::of(self.settings.variance.sequence, self.settings.seed, pixel as u32, sample);
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
                batch.events
            })
            .reduce(Events::default, |mut a, b| {
                a += b;
                a
            });
        if self.cancel.load(Ordering::Relaxed) {
            return false;
        }
        film.events += events;
        film.samples = taken;
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
