//! Bias and variance apart, from images with different seeds.

use super::significance::significance;
use super::sums::{Image, Sums};
use super::truth::{Relative, TruePixel, Truth, mean_without, worst};
use super::{BIAS_SIGNIFICANCE, Bias};
use crate::measure::Interval;
use crate::measure::statistics::{CONFIDENCE, jackknife, t_quantile};

/// Sums over runs of x − r and of its square, per pixel and channel.
pub struct Spread<'a> {
    truth: &'a Truth,
    images: &'a [&'a Image],
    sums: Vec<[Sums; 3]>,
}

/// Mean over all components, relative as in relMSE.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    /// Of one run.
    pub variance: f64,
    pub bias_squared: f64,
}

impl<'a> Spread<'a> {
    /// Of two images or more, each of the truth's size.
    pub fn new(truth: &'a Truth, images: &'a [&'a Image]) -> Self {
        let mut sums = vec![[Sums::default(); 3]; truth.pixels.len()];
        for image in images {
            for ((sums, x), truth) in sums.iter_mut().zip(*image).zip(&truth.pixels) {
                for (c, sums) in sums.iter_mut().enumerate() {
                    sums.add(f64::from(x[c]) - truth.mean[c]);
                }
            }
        }
        Self { truth, images, sums }
    }

    fn count(&self) -> f64 {
        self.images.len() as f64
    }

    /// Bias and variance of all runs.
    pub fn parts(&self) -> Parts {
        self.parts_of(self.sums.iter().copied(), self.count())
    }

    /// The same of all runs but one, for each.
    pub fn parts_without_one(&self) -> Vec<Parts> {
        let without = |image: &&Image| {
            let sums = self.sums.iter().zip(*image).zip(&self.truth.pixels);
            let sums = sums
                .map(|((sums, x), truth)| std::array::from_fn(|c| sums[c].without(f64::from(x[c]) - truth.mean[c])));
            self.parts_of(sums, self.count() - 1.0)
        };
        self.images.iter().map(without).collect()
    }

    fn parts_of(&self, sums: impl Iterator<Item = [Sums; 3]>, count: f64) -> Parts {
        let (mut variance, mut bias_squared) = (0.0, 0.0);
        for (sums, truth) in sums.zip(&self.truth.pixels) {
            for (c, sums) in sums.iter().enumerate() {
                variance += truth.weight[c] * sums.variance(count);
                bias_squared += truth.weight[c] * (sums.squared_mean(count) - truth.half_gap[c].powi(2));
            }
        }
        let components = self.truth.components();
        Parts { variance: variance / components, bias_squared: bias_squared / components }
    }

    /// bias² of each pixel, relative, mean over its channels. As bad as its mean image is, noise included.
    fn bias_squared_of_pixels(&self) -> Vec<Relative> {
        let of_pixel = |(sums, truth): (&[Sums; 3], &TruePixel)| {
            let mut relative = Relative::default();
            for (c, sums) in sums.iter().enumerate() {
                let weight = truth.weight[c] / 3.0;
                relative.badness += weight * (sums.values / self.count()).powi(2);
                relative.error += weight * (sums.squared_mean(self.count()) - truth.half_gap[c].powi(2));
            }
            relative
        };
        self.sums.iter().zip(&self.truth.pixels).map(of_pixel).collect()
    }

    /// What the runs share, with all that is said about it; of three runs or more.
    pub fn bias(&self) -> Bias {
        let whole = self.parts().bias_squared;
        let left_out: Vec<f64> = self.parts_without_one().iter().map(|parts| parts.bias_squared).collect();
        let of_runs = jackknife(whole, &left_out).map_or(0.0, |interval| interval.high - whole);
        // Moving r by its noise n moves bias² by −2 b n; half_gap is distributed as n is.
        let of_references = (self.sums.iter().zip(&self.truth.pixels))
            .map(|(sums, truth)| {
                let moved = |c: usize| truth.weight[c] * 2.0 * sums[c].values / self.count() * truth.half_gap[c];
                (0..3).map(moved).sum::<f64>().powi(2)
            })
            .sum::<f64>()
            .sqrt()
            / self.truth.components();
        let half_width = of_runs.hypot(t_quantile(CONFIDENCE, 1_000_000) * of_references);

        let of_pixels = self.bias_squared_of_pixels();
        let significance = significance(self.truth, self.images);
        let (mut squared_mse, mut difference, mut brightness) = (0.0, 0.0, 0.0);
        for (sums, truth) in self.sums.iter().zip(&self.truth.pixels) {
            for (c, sums) in sums.iter().enumerate() {
                squared_mse += sums.squared_mean(self.count()) - truth.half_gap[c].powi(2);
                difference += sums.values / self.count();
                brightness += truth.mean[c];
            }
        }
        Bias {
            squared: Interval::around(whole, half_width),
            squared_mse: squared_mse / self.truth.components(),
            squared_trimmed: mean_without(&of_pixels, &worst(&of_pixels)),
            significance,
            is_biased: significance > BIAS_SIGNIFICANCE,
            brightness: if brightness > 0.0 { difference / brightness } else { 0.0 },
        }
    }
}

/// Relative variances of two modes and of their difference, seed by seed, over the seeds: of all, and of all but one for each.
pub fn paired_variances(truth: &Truth, mode: &[&Image], against: &[&Image]) -> (PairedVariances, Vec<PairedVariances>) {
    let (count, components) = (mode.len() as f64, truth.components());
    let mut all = PairedVariances::default();
    let mut without = vec![PairedVariances::default(); mode.len()];
    for (pixel, truth) in truth.pixels.iter().enumerate() {
        for c in 0..3 {
            let values = |run: usize| {
                let (a, b) = (f64::from(mode[run][pixel][c]), f64::from(against[run][pixel][c]));
                [a - truth.mean[c], b - truth.mean[c], a - b]
            };
            let mut sums = [Sums::default(); 3];
            for run in 0..mode.len() {
                for (sums, value) in sums.iter_mut().zip(values(run)) {
                    sums.add(value);
                }
            }
            let weight = truth.weight[c] / components;
            all.add(weight, sums.map(|sums| sums.variance(count)));
            for (run, without) in without.iter_mut().enumerate() {
                let values = values(run);
                let variance = |which: usize| sums[which].without(values[which]).variance(count - 1.0);
                without.add(weight, std::array::from_fn(variance));
            }
        }
    }
    (all, without)
}

/// See [`paired_variances`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PairedVariances {
    pub of_mode: f64,
    pub of_against: f64,
    pub of_difference: f64,
}

impl PairedVariances {
    fn add(&mut self, weight: f64, [mode, against, difference]: [f64; 3]) {
        self.of_mode += weight * mode;
        self.of_against += weight * against;
        self.of_difference += weight * difference;
    }
}

#[cfg(test)]
mod tests {
    use super::super::truth::tests::{SIZE, image, noise, references};
    use super::*;

    /// Runs that are all off by `bias` on every fifth pixel, with noise of variance `scale`²/12.
    fn runs(count: u64, bias: f64, scale: f64) -> Vec<Image> {
        let off = move |pixel: usize| if pixel.is_multiple_of(5) { bias } else { 0.0 };
        (0..count).map(|seed| image(|pixel, c| off(pixel) + scale * noise(seed, pixel, c))).collect()
    }

    fn of<T>(images: &[Image], look: impl FnOnce(Spread<'_>, &Truth) -> T) -> T {
        let truth = Truth::new(&references(0.05), SIZE).unwrap();
        let images: Vec<&Image> = images.iter().collect();
        look(Spread::new(&truth, &images), &truth)
    }

    #[test]
    fn bias_and_variance_come_apart() {
        for count in [3, 8] {
            of(&runs(count, 0.2, 0.6), |spread, truth| {
                let weights = |every: usize| {
                    truth.pixels.iter().step_by(every).flat_map(|pixel| pixel.weight).sum::<f64>() / truth.components()
                };
                let (bias, parts) = (spread.bias(), spread.parts());
                assert!((parts.variance / (weights(1) * 0.36 / 12.0) - 1.0).abs() < 0.05, "{parts:?}");
                assert!(bias.squared.contains(weights(5) * 0.04), "{bias:?}");
                let width = (bias.squared.high - bias.squared.low) / bias.squared.value;
                assert!(width < if count == 3 { 1.0 } else { 0.3 }, "{bias:?}");
                assert!(bias.is_biased);
                assert!((bias.brightness / (0.04 / 1.0) - 1.0).abs() < 0.1, "{bias:?}");
                // The planted error: the mean film's squared error alone takes what noise is left for a bias.
                let naively = parts.bias_squared + parts.variance / count as f64;
                assert!(!bias.squared.contains(naively), "{bias:?} {naively}");
            });
        }
    }

    #[test]
    fn without_a_bias_its_square_scatters_about_nothing() {
        let interval = |first: u64| {
            let images: Vec<Image> = (0..4).map(|run| image(|pixel, c| 0.6 * noise(first + run, pixel, c))).collect();
            of(&images, |spread, _| spread.bias())
        };
        let found: Vec<Bias> = (0..20).map(|run| interval(100 + 10 * run)).collect();
        // At least 95 % are expected to.
        assert!(found.iter().filter(|bias| bias.squared.contains(0.0)).count() >= 17, "{found:?}");
        assert!(found.iter().any(|bias| bias.squared.value < 0.0) && found.iter().any(|bias| bias.squared.value > 0.0));
        assert!(found.iter().all(|bias| !bias.is_biased), "{found:?}");
    }

    #[test]
    fn leaving_one_out_is_what_it_says() {
        let images = runs(4, 0.1, 0.4);
        let left_out = of(&images, |spread, _| spread.parts_without_one());
        let direct = of(&images[1..], |spread, _| spread.parts());
        assert!((left_out[0].variance - direct.variance).abs() < 1e-12);
        assert!((left_out[0].bias_squared - direct.bias_squared).abs() < 1e-12);
    }

    /// A mode that adds a tenth of fresh noise to what it shares with the other: its difference has 1 % of the variance.
    #[test]
    fn what_pairs_share_drops_out() {
        let shared = runs(5, 0.0, 0.5);
        let mode: Vec<Image> = (0..5)
            .map(|seed| image(|pixel, c| 0.5 * noise(seed, pixel, c) + 0.05 * noise(900 + seed, pixel, c)))
            .collect();
        let unrelated: Vec<Image> = (0..5).map(|seed| image(|pixel, c| 0.5 * noise(700 + seed, pixel, c))).collect();
        let truth = Truth::new(&references(0.0), SIZE).unwrap();
        let variances = |mode: &[Image]| {
            let (mode, shared): (Vec<&Image>, Vec<&Image>) = (mode.iter().collect(), shared.iter().collect());
            paired_variances(&truth, &mode, &shared)
        };
        let (all, without_one) = variances(&mode);
        assert!((all.of_against / all.of_difference / 100.0 - 1.0).abs() < 0.05, "{all:?}");
        assert!((all.of_mode / all.of_difference / 101.0 - 1.0).abs() < 0.05, "{all:?}");
        assert_eq!(without_one.len(), 5);
        assert!(without_one.iter().all(|one| (one.of_mode / all.of_mode - 1.0).abs() < 0.1), "{without_one:?}");
        // The twin: modes that share nothing have a difference that is noisier than either.
        let (unpaired, _) = variances(&unrelated);
        assert!((unpaired.of_difference / unpaired.of_against / 2.0 - 1.0).abs() < 0.05, "{unpaired:?}");
    }
}
