//! Times of two ways of doing the same, compared so that a busy machine does not decide the answer.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::progress::Progress;
use crate::measure::statistics::median;
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
    progress: &Progress<'_>,
    mut above: impl FnMut() -> f64,
    mut below: impl FnMut() -> f64,
) -> Option<Vec<(f64, f64)>> {
    let mut times = Vec::with_capacity(count);
    for index in 0..=count {
        let pair = if index % 2 == 0 {
            let first = above();
            (first, below())
        } else {
            let first = below();
            (above(), first)
        };
        if progress.is_cancelled() {
            return None;
        }
        times.push(pair);
    }
    times.remove(0);
    Some(times)
}

/// Rank, from both ends, of the ordered values between which the median lies with a probability of at least 95 % where so many values can
/// give that, and the probability. The median lies below the k-th smallest of n with the probability that a fair coin shows heads fewer
/// than k times in n throws (David and Nagaraja, *Order Statistics*, 7.1).
fn median_interval(count: usize) -> (usize, f64) {
    let all = (count as f64).exp2();
    // Probability of at most `rank` heads, and of one side of the interval.
    let (mut ways, mut outside) = (1.0, 1.0);
    let mut best = (0, 1.0 - 2.0 * outside / all);
    for rank in 1..count.div_ceil(2) {
        ways *= (count - rank + 1) as f64 / rank as f64;
        outside += ways;
        let inside = 1.0 - 2.0 * outside / all;
        if inside < 0.95 {
            break;
        }
        best = (rank, inside);
    }
    (best.0, best.1.max(0.0))
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

    /// Takes so many samples more of every pixel; returns the seconds that they took. The film stays as it is when cancelled.
    pub fn slice(&mut self, samples: u32, progress: &Progress<'_>) -> f64 {
        let start = Instant::now();
        RenderTask { prepared: self.prepared, camera: self.camera, settings: &self.settings }.pass(
            &mut self.film,
            samples,
            progress.cancel,
        );
        start.elapsed().as_secs_f64()
    }

    /// Samples per pixel whose slice takes at least `seconds`, as found by taking more and more of them; at most 4096.
    pub fn samples_for(&mut self, seconds: f64, progress: &Progress<'_>) -> u32 {
        let mut samples = 1;
        while samples < 4096 && !progress.is_cancelled() {
            let took = self.slice(samples, progress);
            if took >= seconds {
                break;
            }
            samples *= if took < 0.2 * seconds { 4 } else { 2 };
        }
        samples
    }

    /// Median seconds of a sample of a pixel over `slices` slices of about `slice_secs`; `None` when cancelled.
    pub fn sample_secs(&mut self, slices: usize, slice_secs: f64, progress: &Progress<'_>) -> Option<f64> {
        let samples = self.samples_for(slice_secs, progress);
        let times: Vec<f64> = (0..slices).map(|_| self.slice(samples, progress)).collect();
        let pixels = self.film.sums.len() as f64;
        median(&times).filter(|_| !progress.is_cancelled()).map(|secs| secs / (f64::from(samples) * pixels))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against tables of the sign test, as in Conover, *Practical Nonparametric Statistics*: ranks and exact coverages.
    #[test]
    fn intervals_of_the_median_are_those_of_the_sign_test() {
        for (count, rank, confidence) in
            [(1, 0, 0.0), (2, 0, 0.5), (5, 0, 0.9375), (6, 0, 0.96875), (9, 1, 0.9609375), (15, 3, 0.96484375)]
        {
            let (found, probability) = median_interval(count);
            assert_eq!(found, rank, "{count}");
            assert!((probability - confidence).abs() < 1e-12, "{count}: {probability}");
        }
    }

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
