//! Images held against two references at once.

use super::data::RunPoint;
use crate::measure::MetricError;
use crate::measure::flip;
use crate::report::reference::References;

/// Added to squared radiance where an error is taken relative to it, and to sums of radiance, as in [`crate::measure`].
const DARK: f64 = 0.01;
/// The share of pixels that a trimmed figure leaves out: one in so many.
const TRIM_ONE_IN: usize = 1000;

/// What is known of the true image, per pixel and channel.
#[derive(Debug, Clone)]
pub struct Truth {
    pub pixels: Vec<TruePixel>,
    flip: flip::Reference,
}

/// A pixel of both references.
#[derive(Debug, Clone, Copy)]
pub struct TruePixel {
    /// Of the two, r.
    pub mean: [f64; 3],
    /// Half of how far they are apart. (x − r₁)(x − r₂) = (x − r)² − half_gap².
    pub half_gap: [f64; 3],
    /// 1/(r² + 0.01).
    pub weight: [f64; 3],
}

impl Truth {
    /// # Errors
    /// When a reference has a component that is not finite.
    pub fn new(references: &References, size: [u32; 2]) -> Result<Self, MetricError> {
        let [width, height] = size.map(|side| side as usize);
        let flip = flip::Reference::hdr(&references.mean(), width, height, flip::DEFAULT_PIXELS_PER_DEGREE)?;
        let [first, second] = &references.images;
        let pixel = |(a, b): (&[f32; 3], &[f32; 3])| {
            let (a, b) = (a.map(f64::from), b.map(f64::from));
            let mean: [f64; 3] = std::array::from_fn(|c| f64::midpoint(a[c], b[c]));
            TruePixel {
                mean,
                half_gap: std::array::from_fn(|c| (a[c] - b[c]) / 2.0),
                weight: mean.map(|r| 1.0 / (r * r + DARK)),
            }
        };
        Ok(Self { pixels: first.iter().zip(second).map(pixel).collect(), flip })
    }

    /// Relative noise of one reference: E (r₁ − r₂)² is twice its variance.
    pub fn noise(&self) -> f64 {
        let of_pixel = |p: &TruePixel| (0..3).map(|c| 2.0 * p.half_gap[c].powi(2) * p.weight[c]).sum::<f64>();
        self.pixels.iter().map(of_pixel).sum::<f64>() / self.components()
    }

    /// Components of an image: three for each pixel.
    pub fn components(&self) -> f64 {
        3.0 * self.pixels.len() as f64
    }

    /// relMSE of each pixel of `image`, which has the truth's size.
    pub fn relative(&self, image: &[[f32; 3]]) -> Vec<Relative> {
        let of_pixel = |(x, truth): (&[f32; 3], &TruePixel)| {
            let mut relative = Relative::default();
            for (c, &x) in x.iter().enumerate() {
                let squared = (f64::from(x) - truth.mean[c]).powi(2);
                relative.badness += squared * truth.weight[c] / 3.0;
                relative.error += (squared - truth.half_gap[c].powi(2)) * truth.weight[c] / 3.0;
            }
            relative
        };
        image.iter().zip(&self.pixels).map(of_pixel).collect()
    }

    /// Errors of `image`, which belongs to that seed and took so long. `left_out` are the pixels that [`RunPoint::relmse_steady`] leaves
    /// out, which are all of a run's.
    ///
    /// # Errors
    /// When the image has another size or a component that is not finite.
    pub fn errors(
        &self,
        image: &[[f32; 3]],
        left_out: &[usize],
        seed: u64,
        render_secs: f64,
    ) -> Result<RunPoint, MetricError> {
        // Refuses what cannot be compared.
        let flip = self.flip.flip(image)?.mean();
        let (mut mse, mut smape) = (0.0, 0.0);
        for (x, truth) in image.iter().zip(&self.pixels) {
            for c in 0..3 {
                let (x, r) = (f64::from(x[c]), truth.mean[c]);
                mse += (x - r).powi(2) - truth.half_gap[c].powi(2);
                smape += 2.0 * (x - r).abs() / (x.abs() + r.abs() + DARK);
            }
        }
        let relative = self.relative(image);
        let components = self.components();
        Ok(RunPoint {
            seed,
            render_secs,
            relmse: mean_without(&relative, &[]),
            relmse_trimmed: mean_without(&relative, &worst(&relative)),
            relmse_steady: mean_without(&relative, left_out),
            mse: mse / components,
            smape: smape / components,
            flip: Some(flip),
        })
    }
}

/// One pixel's part of a relMSE.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Relative {
    /// The squared error, the noise of the references included: by this pixels are called the worst. To leave out pixels in which that
    /// noise happens to be small would be a bias.
    pub badness: f64,
    /// The squared error without that noise.
    pub error: f64,
}

/// Indices of the worst 0.1 % (rounded down), rising.
pub fn worst(pixels: &[Relative]) -> Vec<usize> {
    let count = pixels.len() / TRIM_ONE_IN;
    let mut indices: Vec<usize> = (0..pixels.len()).collect();
    // Stable: of equals the first goes.
    indices.sort_by(|&a, &b| pixels[b].badness.total_cmp(&pixels[a].badness));
    indices.truncate(count);
    indices.sort_unstable();
    indices
}

/// Mean error of all but some, whose indices rise.
pub fn mean_without(pixels: &[Relative], left_out: &[usize]) -> f64 {
    let mut left_out = left_out.iter().copied().peekable();
    let (mut sum, mut count) = (0.0, 0);
    for (index, pixel) in pixels.iter().enumerate() {
        if left_out.next_if_eq(&index).is_none() {
            sum += pixel.error;
            count += 1;
        }
    }
    sum / f64::from(count.max(1))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::measure::{difference, difference_from_two};
    use crate::tracking::Events;
    use crate::transport::sampler::{Sampler, Sequence};

    pub const SIZE: [u32; 2] = [64, 48];

    /// Noise of variance 1/12 for each number: uniform in [−½, ½), another for each seed.
    pub fn noise(seed: u64, pixel: usize, channel: usize) -> f64 {
        Sampler::of(Sequence::Independent, seed, pixel as u32, 0).get_1d(channel as u32) - 0.5
    }

    /// A smooth picture between 0.5 and 1.5 with something added.
    pub fn image(added: impl Fn(usize, usize) -> f64) -> Vec<[f32; 3]> {
        let true_value = |pixel: usize, channel: usize| 1.0 + 0.5 * ((pixel * (channel + 1)) as f64 * 0.01).sin();
        (0..(SIZE[0] * SIZE[1]) as usize)
            .map(|pixel| std::array::from_fn(|c| (true_value(pixel, c) + added(pixel, c)) as f32))
            .collect()
    }

    /// References with noise of standard deviation `scale`/√12.
    pub fn references(scale: f64) -> References {
        References {
            images: [1_000_001, 1_000_002].map(|seed| image(|pixel, c| scale * noise(seed, pixel, c))),
            spp: [1, 1],
            render_secs: 0.0,
            events: Events::default(),
        }
    }

    /// An image that is off by 0.1 everywhere has an MSE of 0.01, however noisy the references are, where one reference alone adds
    /// its own noise.
    #[test]
    fn noise_of_references_cancels() {
        let references = references(0.5);
        let truth = Truth::new(&references, SIZE).unwrap();
        let biased = image(|_, _| 0.1);
        let errors = truth.errors(&biased, &[], 3, 1.5).unwrap();
        let variance = 0.25 / 12.0;
        // Standard deviation over 9216 components of 0.2 times the noise of the mean, and of the product of both noises.
        let scatter = ((0.04 * variance / 2.0 + variance * variance / 4.0) / truth.components()).sqrt();
        assert!((errors.mse - 0.01).abs() < 4.0 * scatter, "{} ± {scatter}", errors.mse);
        assert!(errors.relmse > 0.0 && errors.relmse_trimmed < errors.relmse);
        assert_eq!((errors.seed, errors.render_secs), (3, 1.5));
        let against_one = difference(&biased, &references.images[0]).unwrap();
        assert!((against_one.mse - 0.01 - variance).abs() < 20.0 * scatter, "{}", against_one.mse);

        let errors_of_truth = truth.errors(&image(|_, _| 0.0), &[], 0, 0.0).unwrap();
        assert!(errors_of_truth.mse.abs() < 4.0 * scatter, "{}", errors_of_truth.mse);
    }

    #[test]
    fn figures_are_those_of_measure() {
        let references = references(0.2);
        let truth = Truth::new(&references, SIZE).unwrap();
        let noisy = image(|pixel, c| noise(7, pixel, c));
        let left_out = worst(&truth.relative(&noisy));
        assert_eq!(left_out.len(), 3);
        let errors = truth.errors(&noisy, &left_out, 0, 0.0).unwrap();
        let [a, b] = &references.images;
        let usual = difference_from_two(&noisy, [a, b]).unwrap();
        let symmetric = difference(&noisy, &references.mean()).unwrap().smape;
        for (a, b, tolerance) in [
            (errors.mse, usual.mse, 1e-12),
            (errors.relmse, usual.relmse, 1e-12),
            (errors.relmse_trimmed, usual.relmse_trimmed, 1e-12),
            (errors.relmse_steady, usual.relmse_trimmed, 1e-12),
            // The mean of the references has been rounded to f32.
            (errors.smape, symmetric, 1e-6),
        ] {
            assert!((a - b).abs() < tolerance * b, "{a} {b}");
        }
        assert!(errors.flip.is_some_and(|flip| flip > 0.0));
    }

    #[test]
    fn noise_of_the_references_is_known() {
        let truth = Truth::new(&references(0.3), SIZE).unwrap();
        let expected = truth.pixels.iter().flat_map(|p| p.weight).sum::<f64>() * 0.09 / 12.0 / truth.components();
        assert!((truth.noise() / expected - 1.0).abs() < 0.05, "{} {expected}", truth.noise());
    }

    #[test]
    fn what_is_not_finite_or_of_another_size_is_refused() {
        let truth = Truth::new(&references(0.0), SIZE).unwrap();
        let mut broken = image(|_, _| 0.0);
        broken[5][1] = f32::NAN;
        assert!(truth.errors(&broken, &[], 0, 0.0).is_err());
        assert!(truth.errors(&broken[..5], &[], 0, 0.0).is_err());
    }

    #[test]
    fn trimming_drops_one_in_a_thousand() {
        let mut pixels = vec![Relative { badness: 1.0, error: 1.0 }; 2000];
        for (index, error) in [(17, 1e9), (1700, 1e9), (3, 1e5)] {
            pixels[index] = Relative { badness: error, error };
        }
        assert_eq!(worst(&pixels), [17, 1700]);
        assert!((mean_without(&pixels, &[17, 1700]) - (1997.0 + 1e5) / 1998.0).abs() < 1e-9);
        assert_eq!(mean_without(&pixels[..3], &[]), 1.0);
        assert!(worst(&pixels[..999]).is_empty());
    }
}
