//! Paths from the camera: rows of the film, each path for itself.

use std::sync::atomic::Ordering;

use glam::DVec2;
use rayon::prelude::*;

use super::{Pass, View};
use crate::tracking::{Events, Tracker};
use crate::transport::dimension;
use crate::transport::path::{Batch, PathTracer};
use crate::transport::sampler::Sampler;

impl Pass<'_, '_> {
    /// Adds samples by [`PathTracer`].
    pub(super) fn paths<T: Tracker>(self, view: &View<'_, T>) -> bool {
        let View { tracked, camera, lens, ask, .. } = view;
        let settings = self.task.settings;
        let scene = tracked.scene;
        let tracer = PathTracer {
            tracked: *tracked,
            max_depth: settings.max_depth.unwrap_or(u32::MAX),
            splits: settings.splits,
        };
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
                        let ray = camera.ray(at, size, camera.lens_point(|| sampler.get_2d(dimension::LENS)));
                        batch.add(&lens.start_by_asking(scene, ray, ask), sampler, &tracer);
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
