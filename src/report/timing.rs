//! Times of two ways of doing the same, compared so that a busy machine does not decide the answer.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::progress::Progress;
use crate::measure::statistics::{median, median_interval};
use crate::render::{Film, ImageSettings, RenderTask};
use crate::scene::camera::Camera;
use crate::tracking::Prepared;

/// One time over another, from pairs that were taken one right after the other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ratio {
    /// Median of the pairs' ratios.
    pub median: f64,
    /// An interval that holds the true median with a probability of at least `confidence`, whatever the distribution.
    pub low: f64,
    pub high: f64,
    /// 95 %, or as much as so few pairs can give.
    pub confidence: f64,
    pub pairs: usize,
    /// Median times in seconds, above and below the line.
    pub above_secs: f64,
    pub below_secs: f64,
}

impl Ratio {
    /// Of pairs (above, below) in seconds; `None` where there is none.
    pub fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        let mut ratios: Vec<f64> = pairs.iter().map(|(above, below)| above / below).collect();
        ratios.sort_by(f64::total_cmp);
        let of_ratios = median(&ratios)?;
        let (rank, confidence) = median_interval(ratios.len());
        Some(Self {
            median: of_ratios,
            low: ratios[rank],
            high: ratios[ratios.len() - 1 - rank],
            confidence,
            pairs: pairs.len(),
            above_secs: median(&pairs.iter().map(|pair| pair.0).collect::<Vec<_>>())?,
            below_secs: median(&pairs.iter().map(|pair| pair.1).collect::<Vec<_>>())?,
        })
    }
}

/// Takes `count` pairs of times after one that is thrown away; which of a pair goes first changes from pair to pair, so that a
/// machine that slows down or speeds up favours neither. `None` when cancelled.
pub fn pairs(
    count: usize,
    mut above: impl FnMut() -> Option<f64>,
    mut below: impl FnMut() -> Option<f64>,
) -> Option<Vec<(f64, f64)>> {
    let pair = |index: usize| {
        let early = if index.is_multiple_of(2) { Some(above()?) } else { None };
        let below = below()?;
        Some((early.or_else(&mut above)?, below))
    };
    (0..=count).map(pair).skip(1).collect()
}

/// One image that is rendered in slices, each of them timed.
pub struct Timed<'a> {
    pub prepared: &'a Prepared,
    pub camera: &'a Camera,
    pub settings: ImageSettings,
    pub film: Film,
}

impl<'a> Timed<'a> {
    pub fn new(prepared: &'a Prepared, camera: &'a Camera, settings: ImageSettings, size: (u32, u32)) -> Self {
        Self { prepared, camera, settings, film: Film::new(size.0, size.1) }
    }

    /// Takes so many samples more of every pixel; returns the seconds that they took. `None` when cancelled: the film is incomplete then.
    pub fn slice(&mut self, samples: u32, progress: &Progress<'_>) -> Option<f64> {
        let start = Instant::now();
        let task = RenderTask { prepared: self.prepared, camera: self.camera, settings: &self.settings };
        task.pass(&mut self.film, samples, progress.cancel).then(|| start.elapsed().as_secs_f64())
    }

    /// Seconds of a sample of every pixel, after one that finds cold caches.
    pub fn warm_secs(&mut self, samples: u32, progress: &Progress<'_>) -> Option<f64> {
        self.slice(1, progress)?;
        Some(self.slice(samples, progress)? / f64::from(samples))
    }

    /// Samples per pixel whose slice takes at least `seconds`, as found by taking more and more of them; at most 4096.
    pub fn samples_for(&mut self, seconds: f64, progress: &Progress<'_>) -> Option<u32> {
        let mut samples = 1;
        while samples < 4096 {
            let took = self.slice(samples, progress)?;
            if took >= seconds {
                break;
            }
            samples *= if took < 0.2 * seconds { 4 } else { 2 };
        }
        Some(samples)
    }

    /// Median seconds of a sample of a pixel over `slices` slices of about `slice_secs`; `None` when cancelled.
    pub fn sample_secs(&mut self, slices: usize, slice_secs: f64, progress: &Progress<'_>) -> Option<f64> {
        let samples = self.samples_for(slice_secs, progress)?;
        let times: Vec<f64> = (0..slices).map(|_| self.slice(samples, progress)).collect::<Option<_>>()?;
        Some(median(&times)? / (f64::from(samples) * self.film.sums.len() as f64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_slow_pair_does_not_decide_a_ratio() {
        let mut pairs: Vec<(f64, f64)> = (0..9).map(|k| (2.0 + 0.01 * f64::from(k), 1.0)).collect();
        pairs[3] = (90.0, 1.0);
        let ratio = Ratio::of(&pairs).unwrap();
        assert!((ratio.median - 2.05).abs() < 1e-12 && ratio.high < 2.1, "{ratio:?}");
        // The twin: a mean would have been fooled.
        assert!(pairs.iter().map(|pair| pair.0).sum::<f64>() / 9.0 > 10.0);
        assert!(Ratio::of(&[]).is_none());
    }
}
