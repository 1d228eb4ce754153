//! Paths from both ends: sample after sample of the whole image, as each pixel uses what light has left everywhere.

use std::sync::atomic::Ordering;

use glam::DVec2;
use rayon::prelude::*;

use super::{Pass, View};
use crate::render::renderer::RenderTask;
use crate::render::settings::Estimator;
use crate::spectrum::Spectrum;
use crate::tracking::{Events, Tracker};
use crate::transport::bidirectional::{Bidirectional, CameraPath, Iteration, LightPaths, LightVertex, light_paths};
use crate::transport::dimension;
use crate::transport::photon_map::{Photon, PhotonMap};
use crate::transport::sampler::Sampler;

/// Subpaths from lights that one thread traces in a row.
const LIGHT_PATHS_TOGETHER: u32 = 512;

/// A pixel's sample: its radiance and the segments of its path from the camera.
type Sample = (Spectrum, u32);

/// The estimator for a task, for images of `size`.
pub(super) fn bidirectional<'a, T>(
    task: &RenderTask<'a>,
    view: &'a View<'a, T>,
    size: [u32; 2],
    has_merging: bool,
) -> Bidirectional<'a, T> {
    let RenderTask { prepared, settings, .. } = *task;
    Bidirectional {
        tracked: view.tracked,
        table: &prepared.table,
        camera: view.camera,
        lens: &view.lens,
        aims: &view.aims,
        ask: view.ask,
        size,
        max_depth: settings.max_depth.unwrap_or(u32::MAX),
        seed: settings.seed,
        sequence: settings.sampler,
        has_merging,
        light_paths: light_paths(size),
    }
}

impl Pass<'_, '_> {
    /// Adds samples by [`Bidirectional`]. An iteration that is cancelled leaves nothing.
    pub(super) fn iterations<T: Tracker>(self, view: &View<'_, T>) -> bool {
        let has_merging = self.task.settings.estimator == Estimator::Merging;
        let bidirectional = bidirectional(self.task, view, [self.film.width, self.film.height], has_merging);
        for _ in 0..self.samples {
            let iteration = bidirectional.iteration(self.film.first + self.film.samples);
            let Some(light) = self.trace_light(&bidirectional, &iteration) else { return false };
            let Some(rows) = self.trace_camera(&bidirectional, &iteration, &light) else { return false };
            let mut events = Vec::with_capacity(rows.len());
            for (mut target, (samples, mut of_row)) in self.film.rows().into_iter().zip(rows) {
                for (column, (radiance, segments)) in samples.into_iter().enumerate() {
                    target.add(column, radiance, segments, &mut of_row);
                }
                events.push(Some(of_row));
            }
            self.film.finish_pass(1, &events);
            for part in &light {
                self.film.events += part.events;
                part.splats.iter().for_each(|splat| self.film.splat(splat.pixel as usize, splat.radiance));
            }
        }
        true
    }

    /// Traces the subpaths from lights, some in a row; `None` where that is cancelled.
    fn trace_light<T: Tracker>(
        &self,
        bidirectional: &Bidirectional<'_, T>,
        iteration: &Iteration,
    ) -> Option<Vec<LightPaths>> {
        let count = bidirectional.light_paths;
        (0..count.div_ceil(LIGHT_PATHS_TOGETHER))
            .into_par_iter()
            .map_init(T::State::default, |room, part| {
                if self.cancel.load(Ordering::Relaxed) {
                    return None;
                }
                let mut paths = LightPaths::default();
                let first = part * LIGHT_PATHS_TOGETHER;
                for number in first..(first + LIGHT_PATHS_TOGETHER).min(count) {
                    bidirectional.trace_light(iteration, number, &mut paths, room);
                }
                Some(paths)
            })
            .collect()
    }

    /// A sample of every pixel, by rows; `None` where that is cancelled.
    fn trace_camera<T: Tracker>(
        &self,
        bidirectional: &Bidirectional<'_, T>,
        iteration: &Iteration,
        light: &[LightPaths],
    ) -> Option<Vec<(Vec<Sample>, Events)>> {
        let Bidirectional { tracked, camera, lens, ask, size: [width, height], .. } = *bidirectional;
        let settings = self.task.settings;
        let size = DVec2::new(f64::from(width), f64::from(height));
        let photons = iteration.radius.map(|radius| {
            let vertices = light.iter().flat_map(|paths| &paths.vertices);
            let photons: Vec<Photon> = vertices.filter(|vertex| vertex.can_merge()).map(LightVertex::photon).collect();
            PhotonMap::new(radius, &photons)
        });
        let count = bidirectional.light_paths;
        let subpath = |pixel: u32| -> &[LightVertex] {
            let Some(number) = pixel.checked_rem(count) else { return &[] };
            light[(number / LIGHT_PATHS_TOGETHER) as usize].of((number % LIGHT_PATHS_TOGETHER) as usize)
        };
        (0..height)
            .into_par_iter()
            .map_init(T::State::default, |room, row| {
                let mut events = Events::default();
                let mut samples = Vec::with_capacity(width as usize);
                for column in 0..width {
                    if self.cancel.load(Ordering::Relaxed) {
                        return None;
                    }
                    let pixel = row * width + column;
                    let sampler = Sampler::of(settings.sampler, settings.seed, pixel, iteration.number);
                    let [x, y] = sampler.get_2d(dimension::PIXEL);
                    let at = DVec2::new(f64::from(column) + x, f64::from(row) + y);
                    let ray = camera.ray(at, size, camera.lens_point(|| sampler.get_2d(dimension::LENS)));
                    let start = lens.start_by_asking(tracked.scene, ray, ask);
                    let path = CameraPath { start, sampler, light: subpath(pixel), photons: photons.as_ref() };
                    samples.push(bidirectional.trace_camera(iteration, &path, room, &mut events));
                }
                Some((samples, events))
            })
            .collect()
    }
}
