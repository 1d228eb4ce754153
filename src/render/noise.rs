//! How noisy an image is, estimated while it is rendered.
//!
//! Samples are looked at whenever their number has doubled: half of them are new, so what the mean of all differs from the mean of the first
//! half tells how far either may be from the truth. Where the halves are independent, the difference is distributed as the error of the
//! mean of all; where later samples fill the gaps of earlier ones, as here, the error is smaller than that.

use rayon::prelude::*;

use super::film::Film;
use crate::color::luminance;

/// Pixels darker than this part of the image's mean count as if they were so bright: nobody sees their noise.
const DARK: f64 = 0.1;

/// The estimate for one film.
#[derive(Debug, Clone, Default)]
pub struct Noise {
    /// Luminance of every pixel when there were half as many samples, or fewer, and how many.
    earlier: Option<(u32, Vec<f32>)>,
    /// The latest estimate, and of how many samples it is.
    measured: Option<(u32, f64)>,
    /// The square of each pixel's difference then: its variance, estimated from two numbers.
    squares: Vec<f32>,
}

impl Noise {
    /// How many samples to take at most until [`Self::look`] is to be called again.
    pub fn samples_to_look(film: &Film) -> u32 {
        film.samples
            .checked_add(1)
            .and_then(u32::checked_next_power_of_two)
            .map_or(u32::MAX, |next| next - film.samples)
    }

    /// Takes note of the film as it is now.
    pub fn look(&mut self, film: &Film) {
        if !film.samples.is_power_of_two() || self.measured.is_some_and(|(at, _)| at >= film.samples) {
            return;
        }
        let now: Vec<f32> = (0..film.sums.len())
            .into_par_iter()
            .map(|pixel| luminance(film.mean(pixel).as_vec3().to_array()))
            .collect();
        if let Some((_, before)) = self.earlier.as_ref().filter(|(samples, _)| 2 * samples == film.samples) {
            self.measured = Some((film.samples, mean_relative_difference(&now, before)));
            self.squares = now.par_iter().zip(before).map(|(now, before)| (now - before).powi(2)).collect();
        }
        self.earlier = Some((film.samples, now));
    }

    /// The mean over all pixels of their error relative to their brightness; `None` before two samples.
    pub fn of(&self, film: &Film) -> Option<f64> {
        let (at, noise) = self.measured?;
        Some(noise * (f64::from(at) / f64::from(film.samples.max(at))).sqrt())
    }

    /// Bytes that it takes in memory.
    pub fn bytes(&self) -> usize {
        self.earlier.as_ref().map_or(0, |(_, luminances)| size_of_val(&luminances[..])) + size_of_val(&self.squares[..])
    }

    /// The variance of each pixel's luminance, as roughly as two numbers tell, and of how many samples it is.
    pub(super) fn squares(&self) -> Option<(u32, &[f32])> {
        self.measured.map(|(at, _)| (at, &self.squares[..]))
    }
}

fn mean_relative_difference(now: &[f32], before: &[f32]) -> f64 {
    let count = now.len().max(1) as f64;
    let mean = now.par_iter().map(|x| f64::from(*x)).filter(|x| x.is_finite()).sum::<f64>() / count;
    let floor = (DARK * mean).max(f64::MIN_POSITIVE);
    let relative = |(now, before): (&f32, &f32)| {
        let [now, before] = [*now, *before].map(f64::from);
        (now - before).abs() / now.abs().max(floor)
    };
    // A picture that is black has no noise; what is not finite tells nothing.
    now.par_iter().zip(before).map(relative).filter(|x| x.is_finite()).sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::render::{ImageSettings, RenderTask};
    use crate::scene::camera::Camera;
    use crate::tracking::{Mode, prepare};

    /// The estimate against the error that a far better image shows.
    #[test]
    fn the_estimate_is_near_the_error_and_not_below_it() {
        let description = Arc::new(crate::formats::open("nested-spheres").unwrap());
        let camera = Camera::new(&description.camera).unwrap();
        let prepared = prepare(description, None).unwrap();
        let rendered = |seed: u64, samples: u32, noise: &mut Noise| {
            let settings = ImageSettings { max_depth: Some(16), ..ImageSettings::new(Mode::Rectified, seed) };
            let task = RenderTask { prepared: &prepared, camera: &camera, settings: &settings };
            let mut film = Film::new(48, 32);
            while film.samples < samples {
                let some = Noise::samples_to_look(&film).min(samples - film.samples);
                assert!(task.pass(&mut film, some, &AtomicBool::new(false)));
                noise.look(&film);
            }
            film
        };
        let truth = rendered(7, 1024, &mut Noise::default());
        let luminances = |film: &Film| film.to_rgb().into_iter().map(luminance).collect::<Vec<f32>>();
        for samples in [4, 16, 48] {
            let mut noise = Noise::default();
            let film = rendered(1, samples, &mut noise);
            let error = mean_relative_difference(&luminances(&truth), &luminances(&film));
            let estimate = noise.of(&film).unwrap();
            assert!((0.8..3.0).contains(&(estimate / error)), "{samples}: {estimate} for {error}");
        }
    }

    #[test]
    fn nothing_is_said_before_two_samples_and_of_black() {
        let mut film = Film::new(2, 2);
        film.samples = 1;
        let mut noise = Noise::default();
        noise.look(&film);
        assert_eq!(noise.of(&film), None);
        film.samples = 2;
        noise.look(&film);
        assert_eq!(noise.of(&film), Some(0.0));
        assert_eq!(
            [1, 2, 3, 4, 7].map(|samples| Noise::samples_to_look(&Film { samples, ..Film::new(1, 1) })),
            [1, 2, 1, 4, 1]
        );
    }
}
