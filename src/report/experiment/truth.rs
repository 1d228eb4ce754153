//! Images held against two references at once.

use super::data::RunPoint;
use crate::measure::metrics::MetricError;
use crate::report::reference::References;

/// Added to squared radiance where an error is taken relative to it, and to sums of radiance, as in [`crate::measure`].
const DARK: f64 = 0.01;
/// The share of pixels that a trimmed figure leaves out: one in so many.
const TRIM_ONE_IN: usize = 1000;

/// What is known of the true image, per pixel and channel.
#[derive(Debug, Clone)]
pub struct Truth {
    pub pixels: Vec<TruePixel>,
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
        let _ = size;
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
        Ok(Self { pixels: first.iter().zip(second).map(pixel).collect() })
    }

    /// Relative noise of one reference: E (r₁ − r₂)² is twice its variance.
    pub fn noise(&self) -> f64 {
        let of_pixel = |p: &TruePixel| (0..3).map(|c| 2.0 * p.half_gap[c].powi(2) * p.weight[c]).sum::<f64>();
        self.pixels.iter().map(of_pixel).sum::<f64>() / self.components()
    }

    /// Numbers in an image.
    pub fn components(&self) -> f64 {
        3.0 * self.pixels.len() as f64
    }

    /// Errors of `image`, with the seed and the time that they belong to.
    ///
    /// # Errors
    /// When the image has another size or a component that is not finite.
    pub fn errors(&self, image: &[[f32; 3]], seed: u64, render_secs: f64) -> Result<RunPoint, MetricError> {
        let flip = None;
        let (mut mse, mut smape) = (0.0, 0.0);
        let mut relative = Vec::with_capacity(image.len());
        for (x, truth) in image.iter().zip(&self.pixels) {
            let mut of_pixel = 0.0;
            for c in 0..3 {
                let (x, r) = (f64::from(x[c]), truth.mean[c]);
                let squared = (x - r).powi(2) - truth.half_gap[c].powi(2);
                mse += squared;
                of_pixel += squared * truth.weight[c];
                smape += 2.0 * (x - r).abs() / (x.abs() + r.abs() + DARK);
            }
            relative.push(of_pixel / 3.0);
        }
        let components = self.components();
        Ok(RunPoint {
            seed,
            render_secs,
            relmse: relative.iter().sum::<f64>() / relative.len() as f64,
            relmse_trimmed: trimmed_mean(relative),
            mse: mse / components,
            smape: smape / components,
            flip,
        })
    }
}

/// The mean without the greatest 0.1 % (rounded down).
pub fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    let kept = values.len() - values.len() / TRIM_ONE_IN;
    if kept < values.len() {
        values.select_nth_unstable_by(kept, f64::total_cmp);
    }
    values[..kept].iter().sum::<f64>() / kept as f64
}
