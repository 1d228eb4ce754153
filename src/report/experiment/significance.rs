//! Whether runs are off at all: a test for a bias that is exact about what chance does, however skewed and heavy-tailed noise is.
//!
//! The runs are halved, A and B, and held against one reference each, so that a = mean(A) − r₁ and b = mean(B) − r₂ are independent in every
//! pixel. Without a bias both are 0 in the mean; so is a · g(b) for every function g, because g(b) knows nothing of a. Where there is a
//! bias, b tells its direction. g is chosen so that a pixel that is plainly off counts for 1, by however much it is off, and one whose
//! b may be noise counts for little: otherwise a few dark pixels that are off by many times their radiance decide, and a few
//! numbers are never significant. What noise is, a pixel knows from its own runs and, as they are few, from all other pixels': two
//! runs that happen to agree are no proof of a mean that is known well.

use super::sums::{Image, Sums};
use super::truth::Truth;
use crate::measure::statistics::median;

/// How many times its standard error b must be for a pixel to count for half.
const NOISE: f64 = 4.0;
/// Variance that is taken for granted where the runs show none, relative to squared radiance.
const FLOOR: f64 = 1e-4;

/// The sum of a · g(b) and b · g(a) over all pixels, which share no random numbers, in units of the scatter that it has without a bias.
/// 0 of fewer than three runs: g needs two to know what noise is.
pub fn significance(truth: &Truth, images: &[&Image]) -> f64 {
    let half = |which: usize| images.iter().skip(which).step_by(2).copied().collect::<Vec<&Image>>();
    let halves = [half(0), half(1)];
    let usual = halves.each_ref().map(|half| usual_noise(truth, half));
    let (mut sum, mut squares) = (0.0, 0.0);
    for (pixel, truth) in truth.pixels.iter().enumerate() {
        let mut of_pixel = 0.0;
        for c in 0..3 {
            let references = [truth.mean[c] + truth.half_gap[c], truth.mean[c] - truth.half_gap[c]];
            let [a, b] = [0, 1].map(|which| Half::new(&halves[which], pixel, c, references[which], usual[which]));
            of_pixel += a.off * b.direction + b.off * a.direction;
        }
        sum += of_pixel;
        squares += of_pixel * of_pixel;
    }
    if squares > 0.0 { sum / squares.sqrt() } else { 0.0 }
}

/// Squared standard error of a component of the mean image, relative to its squared radiance: the median over all, which a few bright
/// paths do not decide. 0 of fewer than two images.
fn usual_noise(truth: &Truth, images: &[&Image]) -> f64 {
    if images.len() < 2 {
        return 0.0;
    }
    let of_component = |pixel: usize, c: usize| {
        let mean = truth.pixels[pixel].mean[c];
        squared_error(Sums::of(images, pixel, c, mean), images.len() as f64) / squared_radiance(mean)
    };
    let all: Vec<f64> = (0..truth.pixels.len())
        .flat_map(|pixel| (0..3).map(move |c| (pixel, c)))
        .map(|(p, c)| of_component(p, c))
        .collect();
    median(&all).unwrap_or(f64::NAN)
}

/// Of the mean of `count` components; of two or more.
fn squared_error(sums: Sums, count: f64) -> f64 {
    (sums.variance(count) / count).max(0.0)
}

/// As in relMSE, never 0.
fn squared_radiance(radiance: f64) -> f64 {
    radiance * radiance + 0.01
}

/// One component of a mean image against its reference.
#[derive(Default)]
struct Half {
    off: f64,
    /// g of it.
    direction: f64,
}

impl Half {
    fn new(images: &[&Image], pixel: usize, channel: usize, reference: f64, usual_noise: f64) -> Self {
        if images.is_empty() {
            return Self::default();
        }
        let (sums, count) = (Sums::of(images, pixel, channel, reference), images.len() as f64);
        let off = sums.values / count;
        if images.len() < 2 {
            return Self { off, direction: 0.0 };
        }
        // As many degrees of freedom as there are, and one more for what is usual.
        let freedom = count - 1.0;
        let usual = usual_noise * squared_radiance(reference);
        let squared_error = (freedom * squared_error(sums, count) + usual) / (freedom + 1.0);
        let floor = FLOOR * squared_radiance(reference);
        Self { off, direction: off / (off * off + NOISE * NOISE * squared_error + floor) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::BIAS_SIGNIFICANCE;
    use super::super::truth::tests::{SIZE, image, noise, references};
    use super::*;

    fn of(count: u64, first: u64, off: impl Fn(usize) -> f64, noisy: impl Fn(f64) -> f64) -> f64 {
        let truth = Truth::new(&references(0.1), SIZE).unwrap();
        let images: Vec<Image> = (first..first + count)
            .map(|seed| image(|pixel, c| off(pixel) + noisy(noise(seed, pixel, c) + 0.5)))
            .collect();
        significance(&truth, &images.iter().collect::<Vec<_>>())
    }

    fn even(u: f64) -> f64 {
        0.6 * (u - 0.5)
    }

    /// Mean 0; one number in fifty is 49 times as far off as the others and the other way.
    fn skewed(u: f64) -> f64 {
        if u < 0.02 { 2.45 } else { -0.05 }
    }

    #[test]
    fn chance_is_not_taken_for_a_bias() {
        for noisy in [even, skewed] {
            for count in [3, 4, 16] {
                let found: Vec<f64> = (0..12).map(|run| of(count, 100 + 20 * run, |_| 0.0, noisy)).collect();
                assert!(found.iter().all(|z| z.abs() < BIAS_SIGNIFICANCE), "{count}: {found:?}");
                assert!(found.iter().any(|z| z.abs() > 0.3), "{count}: {found:?}");
            }
        }
    }

    /// Everywhere a little, and in one pixel of twenty-five by amounts of all sizes.
    #[test]
    fn a_bias_is_found_however_it_is_spread() {
        let few = |pixel: usize| if pixel.is_multiple_of(25) { 10.0_f64.powi((pixel / 25 % 5) as i32) } else { 0.0 };
        for count in [4, 16] {
            assert!(of(count, 0, |_| 0.1, even) > BIAS_SIGNIFICANCE, "{count}");
            assert!(of(count, 0, |_| 0.1, skewed) > BIAS_SIGNIFICANCE, "{count}");
            assert!(of(count, 0, few, even) > BIAS_SIGNIFICANCE, "{count}");
        }
    }
}
