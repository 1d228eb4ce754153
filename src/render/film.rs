//! Accumulated radiance.

use std::sync::Arc;

use glam::DVec3;

use super::allocation::Allocation;
use super::exact::{ExactRow, ExactSums};
use super::pilot::{PILOT, Pilot, PilotRow};
use super::settings::Backend;
use crate::spectrum::Spectrum;
use crate::tracking::Events;

/// Sums of radiance samples per pixel in f64, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    /// Sum of the finite samples of each pixel, linear RGB.
    pub sums: Vec<DVec3>,
    /// Finite samples in each pixel's sum.
    pub counts: Vec<u32>,
    /// Index of the first sample: 0 but for a part of an image.
    pub first: u32,
    /// Samples taken of every pixel, finite or not; with an `allocation`, in the mean.
    pub samples: u32,
    pub events: Events,
    /// Pilot statistics until the allocation is computed; `None` if samples are spread evenly.
    pub pilot: Option<Pilot>,
    /// How samples are spread over the pixels; `None`: evenly.
    pub allocation: Option<Arc<Allocation>>,
    /// The sums once more and without rounding, where parts of the image are to be put together later.
    pub exact: Option<ExactSums>,
    /// Samples that each row has beyond `samples`, because a pass was cancelled; empty where none was.
    pub ahead: Vec<u32>,
    /// What has taken the samples; `None` before the first.
    pub backend: Option<Backend>,
}

impl Film {
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            width,
            height,
            sums: vec![DVec3::ZERO; pixels],
            counts: vec![0; pixels],
            first: 0,
            samples: 0,
            events: Events::default(),
            pilot: None,
            allocation: None,
            exact: None,
            ahead: Vec::new(),
            backend: None,
        }
    }

    /// A film whose samples go where they matter, once [`Self::allocate`] has been called.
    pub fn adaptive(width: u32, height: u32) -> Self {
        let film = Self::new(width, height);
        Self { pilot: Some(Pilot::new(film.sums.len())), ..film }
    }

    /// A film for a part of an image, whose samples begin at index `first`; see [`super::exact::unit_exponent`].
    pub fn partial(width: u32, height: u32, first: u32, unit_exponent: i32) -> Self {
        let film = Self::new(width, height);
        Self { first, exact: Some(ExactSums::new(film.sums.len(), unit_exponent)), ..film }
    }

    /// Decides how the further samples of `films`, which are of one size and are compared with each other, are spread. Nothing happens
    /// before their pilot samples are taken, nor after the first time.
    pub fn allocate(films: &mut [&mut Self]) {
        if films.iter().any(|film| film.samples != PILOT) {
            return;
        }
        let pilots: Option<Vec<_>> =
            films.iter().map(|film| Some(film.pilot.as_ref()?.pixels(&film.sums, &film.counts))).collect();
        let (Some(pilots), Some(first)) = (pilots, films.first()) else { return };
        let allocation = Arc::new(Allocation::new(first.width as usize, &pilots));
        for film in films {
            film.pilot = None;
            film.allocation = Some(Arc::clone(&allocation));
        }
    }

    /// Most samples one pass may take before [`Self::allocate`] must run.
    pub fn samples_to_decision(&self) -> u32 {
        if self.pilot.is_some() && self.samples < PILOT { PILOT - self.samples } else { u32::MAX }
    }

    /// The indices of the next `samples` samples of each pixel.
    pub(super) fn next_samples(&self, samples: u32) -> NextSamples {
        let first = self.first + self.samples;
        NextSamples { allocation: self.allocation.clone(), first, last: first + samples }
    }

    /// Whether a cancelled pass leaves it as good as before, to be gone on with.
    pub fn is_resumable(&self) -> bool {
        self.pilot.is_none() && self.exact.is_none()
    }

    /// Takes note of a pass of `samples`: what happened in each row, `None` where it was cancelled. `true` if the pass is complete.
    pub(super) fn finish_pass(&mut self, samples: u32, rows: &[Option<Events>]) -> bool {
        rows.iter().flatten().for_each(|events| self.events += *events);
        let is_complete = rows.iter().all(Option::is_some);
        if !is_complete {
            self.ahead.resize(rows.len(), 0);
        }
        for (ahead, row) in self.ahead.iter_mut().zip(rows) {
            *ahead = match row {
                _ if is_complete => ahead.saturating_sub(samples),
                Some(_) => samples.max(*ahead),
                None => *ahead,
            };
        }
        if is_complete {
            self.samples += samples;
        }
        is_complete
    }

    /// Takes note of who has added samples.
    pub(super) fn rendered_by(&mut self, backend: Backend) {
        self.backend = Some(self.backend.map_or(backend, |before| before.and(backend)));
    }

    /// Its rows, to be added to.
    pub(super) fn rows(&mut self) -> Vec<FilmRow<'_>> {
        let width = self.width as usize;
        let mut pilot = self.pilot.as_mut().map(|pilot| pilot.rows(width));
        let mut exact = self.exact.as_mut().map(|exact| exact.rows(width));
        let mut ahead = self.ahead.iter();
        (self.sums.chunks_mut(width).zip(self.counts.chunks_mut(width)))
            .map(|(sums, counts)| FilmRow {
                sums,
                counts,
                pilot: pilot.as_mut().and_then(Iterator::next),
                exact: exact.as_mut().and_then(Iterator::next),
                ahead: ahead.next().copied().unwrap_or(0),
            })
            .collect()
    }

    /// Adds light to a pixel by index, from a path that was not sampled through it, such as one that starts at a light. It is divided by the
    /// pixel's samples as the rest of its sum, so samples must be spread evenly. Where sums are exact the order of splats does not
    /// matter. One that is not finite, or too large for exact sums, is counted and left out.
    pub fn splat(&mut self, pixel: usize, radiance: Spectrum) {
        let radiance = DVec3::from(radiance.to_rgb());
        if self.exact.as_mut().map_or_else(|| radiance.is_finite(), |exact| exact.add(pixel, radiance)) {
            self.sums[pixel] += radiance;
            self.events.radiance_overflow += u64::from(radiance.max_element() > f64::from(f32::MAX));
        } else {
            self.events.non_finite += 1;
        }
    }

    /// Mean radiance of a pixel by index, from exact sums where there are any; black before the first sample.
    #[inline]
    pub fn mean(&self, pixel: usize) -> DVec3 {
        match &self.exact {
            Some(exact) => exact.mean(pixel, self.counts[pixel]).into(),
            None => self.sums[pixel] / f64::from(self.counts[pixel].max(1)),
        }
    }

    /// Means of all pixels as linear RGB in f32, none beyond what that holds.
    pub fn to_rgb(&self) -> Vec<[f32; 3]> {
        (0..self.sums.len()).map(|pixel| capped(self.mean(pixel).to_array())).collect()
    }
}

/// Which samples a pass takes.
pub(super) struct NextSamples {
    allocation: Option<Arc<Allocation>>,
    first: u32,
    last: u32,
}

impl NextSamples {
    /// Of a pixel in a row that is so many samples ahead.
    #[inline]
    pub(super) fn of_pixel(&self, pixel: usize, ahead: u32) -> std::ops::Range<u32> {
        let first = self.first + ahead;
        match &self.allocation {
            Some(allocation) => allocation.samples(pixel, first)..allocation.samples(pixel, self.last),
            None => first..self.last,
        }
    }
}

/// What some samples of a pixel come to.
#[cfg(feature = "gpu")]
#[derive(Debug, Clone, Default)]
pub(super) struct SampleSums {
    /// Of the finite ones.
    pub radiance: DVec3,
    pub count: u32,
    /// Of the finite ones.
    pub squares: [f32; 3],
    /// Of all their paths.
    pub segments: u32,
}

/// A row of a film, to be added to.
pub(super) struct FilmRow<'a> {
    sums: &'a mut [DVec3],
    counts: &'a mut [u32],
    pilot: Option<PilotRow<'a>>,
    exact: Option<ExactRow<'a>>,
    /// Samples that the row has beyond those of the film.
    pub(super) ahead: u32,
}

impl FilmRow<'_> {
    /// Its sums and counts as they are, for [`Self::restore`].
    pub(super) fn saved(&self) -> (Vec<DVec3>, Vec<u32>) {
        (self.sums.to_vec(), self.counts.to_vec())
    }

    /// Takes back what was added since.
    pub(super) fn restore(&mut self, (sums, counts): &(Vec<DVec3>, Vec<u32>)) {
        self.sums.copy_from_slice(sums);
        self.counts.copy_from_slice(counts);
    }

    /// Adds samples that were summed elsewhere; where sums are exact, one at the most.
    #[cfg(feature = "gpu")]
    pub(super) fn add_sums(&mut self, column: usize, samples: &SampleSums, events: &mut Events) {
        let mut count = samples.count;
        if let Some(exact) = &mut self.exact
            && count > 0
            && !exact.add(column, samples.radiance)
        {
            events.non_finite += 1;
            count = 0;
        }
        if count > 0 {
            self.sums[column] += samples.radiance;
            self.counts[column] += count;
        }
        if let Some(pilot) = &mut self.pilot {
            pilot.add_sums(column, samples.squares, samples.segments);
        }
    }

    /// Adds a sample whose path had so many segments. One that is not finite, or too large for exact sums, is counted in `events` and left out.
    #[inline]
    pub(super) fn add(&mut self, column: usize, radiance: Spectrum, segments: u32, events: &mut Events) {
        let radiance = DVec3::from(radiance.to_rgb());
        if self.exact.as_mut().map_or_else(|| radiance.is_finite(), |exact| exact.add(column, radiance)) {
            self.sums[column] += radiance;
            self.counts[column] += 1;
            events.radiance_overflow += u64::from(radiance.max_element() > f64::from(f32::MAX));
        } else {
            events.non_finite += 1;
        }
        if let Some(pilot) = &mut self.pilot {
            pilot.add(column, radiance, segments);
        }
    }
}

/// Radiance in f32. What is beyond its largest number becomes that: such samples are counted ([`Events::radiance_overflow`]), and an infinite
/// pixel would make every mean over the image infinite. NaN stays NaN.
pub(super) fn capped(rgb: [f64; 3]) -> [f32; 3] {
    rgb.map(|component| if component > f64::from(f32::MAX) { f32::MAX } else { component as f32 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Splats that are added in another order, and in two parts of an image that are then put together, give the same sums to the bit; in f64
    /// they do not.
    #[test]
    fn splats_do_not_depend_on_their_order() {
        let splats: Vec<(usize, Spectrum)> = (0..1000_u32)
            .map(|i| {
                (i as usize % 4, Spectrum::from_rgb([0.1_f64.powi(i as i32 % 18) * f64::from(i * 7919 % 1000); 3]))
            })
            .collect();
        let with = |splats: &mut dyn Iterator<Item = &(usize, Spectrum)>| {
            let mut film = Film::partial(2, 2, 0, -64);
            film.counts = vec![3; 4];
            splats.for_each(|(pixel, radiance)| film.splat(*pixel, *radiance));
            film
        };
        let [forth, back] = [with(&mut splats.iter()), with(&mut splats.iter().rev())];
        assert_eq!((&forth.exact, forth.to_rgb()), (&back.exact, back.to_rgb()));
        assert_ne!(forth.sums, back.sums);
        let (first, second) = splats.split_at(333);
        let [first, second] = [first, second].map(|part| with(&mut part.iter()).exact.unwrap().sums);
        let together: Vec<_> = first.iter().zip(&second).map(|(a, b)| [0, 1, 2].map(|k| a[k] + b[k])).collect();
        assert_eq!(together, forth.exact.as_ref().unwrap().sums);
        let mut film = with(&mut splats.iter());
        film.splat(1, Spectrum::from_rgb([f64::NAN; 3]));
        assert_eq!((film.events.non_finite, &film.exact), (1, &forth.exact));
    }

    #[test]
    fn radiance_beyond_f32_is_capped_and_nothing_else_is() {
        let most = f64::from(f32::MAX);
        assert_eq!(capped([1e39, f64::INFINITY, most.next_up()]), [f32::MAX; 3]);
        assert_eq!(capped([most, 1e38, 0.25]), [f32::MAX, 1e38, 0.25]);
        assert!(capped([f64::NAN, 0.0, 0.0])[0].is_nan());
    }
}
