//! Differences between two linear images, never between tone-mapped ones.
//!
//! With x the image and r the reference, over all pixels and channels: MSE = mean (x − r)², relMSE = mean (x − r)²/(r² + 0.01)
//! (Rousselle et al. 2011), sMAPE = mean 2|x − r|/(|x| + |r| + 0.01). The trimmed relMSE leaves out the worst 0.1 % of pixels, so that
//! a few fireflies do not decide it. All sums are in f64.

/// Keeps relMSE and sMAPE finite where the reference is black.
const DARK: f64 = 0.01;
/// The share of pixels that the trimmed relMSE leaves out: one in so many.
const TRIM_ONE_IN: usize = 1000;

/// Figures of one image against another. All ≥ 0, all 0 for equal images.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Difference {
    /// Mean squared difference, radiance².
    pub mse: f64,
    /// Mean squared difference relative to the reference's square.
    pub relmse: f64,
    /// The same without the worst 0.1 % of pixels (rounded down: nothing is left out below 1000 pixels).
    pub relmse_trimmed: f64,
    /// Mean absolute difference, radiance.
    pub mean_abs: f64,
    /// Symmetric mean absolute percentage error, as a fraction in [0, 2).
    pub smape: f64,
}

/// Images that cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MetricError {
    /// There is nothing to take a mean of.
    #[error("cannot compare images without pixels")]
    Empty,
    /// The images have different numbers of pixels.
    #[error("cannot compare images of different sizes: {image} pixels and {reference} pixels")]
    SizesDiffer {
        /// Pixels in the image.
        image: usize,
        /// Pixels in the reference.
        reference: usize,
    },
    /// A NaN or an infinity, which would make every figure meaningless or, worse, barely move it.
    #[error("pixel {pixel} of the {which} is not a finite number, so the images cannot be compared")]
    NotFinite {
        /// `"image"` or `"reference"`.
        which: &'static str,
        /// Row-major index of the first such pixel.
        pixel: usize,
    },
    /// The width does not go with the number of pixels.
    #[error("an image of {pixels} pixels cannot be {width} pixels wide and {height} high")]
    WrongShape {
        /// Pixels given.
        pixels: usize,
        /// Claimed width.
        width: usize,
        /// Claimed height.
        height: usize,
    },
}

/// Compares `image` with `reference`, both linear RGB in the same pixel order.
///
/// # Errors
/// When the images are empty, differ in size, or hold a component that is not finite.
pub fn difference(image: &[[f32; 3]], reference: &[[f32; 3]]) -> Result<Difference, MetricError> {
    if image.len() != reference.len() {
        return Err(MetricError::SizesDiffer { image: image.len(), reference: reference.len() });
    }
    if image.is_empty() {
        return Err(MetricError::Empty);
    }
    require_finite(image, "image")?;
    require_finite(reference, "reference")?;

    let (mut squared, mut absolute, mut symmetric) = (0.0, 0.0, 0.0);
    let mut relative_of_pixel = Vec::with_capacity(image.len());
    for (x, r) in image.iter().zip(reference) {
        let mut relative = 0.0;
        for channel in 0..3 {
            let (x, r) = (f64::from(x[channel]), f64::from(r[channel]));
            let d = x - r;
            squared += d * d;
            absolute += d.abs();
            symmetric += 2.0 * d.abs() / (x.abs() + r.abs() + DARK);
            relative += d * d / (r * r + DARK);
        }
        relative_of_pixel.push(relative / 3.0);
    }
    let pixels = image.len() as f64;
    let components = 3.0 * pixels;
    let relmse = relative_of_pixel.iter().sum::<f64>() / pixels;

    let kept = image.len() - image.len() / TRIM_ONE_IN;
    if kept < image.len() {
        relative_of_pixel.select_nth_unstable_by(kept, f64::total_cmp);
    }
    let relmse_trimmed = relative_of_pixel[..kept].iter().sum::<f64>() / kept as f64;

    Ok(Difference {
        mse: squared / components,
        relmse,
        relmse_trimmed,
        mean_abs: absolute / components,
        smape: symmetric / components,
    })
}

/// Means over blocks of `block` × `block` pixels (smaller at the right and lower edge), row-major: they show a bias that the noise of
/// single pixels hides.
///
/// # Errors
/// When there are no pixels, `width` × `height` is not their number, or a component is not finite.
///
/// # Panics
/// When `block` is 0.
pub fn block_means(
    pixels: &[[f32; 3]],
    width: usize,
    height: usize,
    block: usize,
) -> Result<Vec<[f32; 3]>, MetricError> {
    assert!(block > 0, "a block has at least one pixel");
    if pixels.is_empty() {
        return Err(MetricError::Empty);
    }
    if width.checked_mul(height) != Some(pixels.len()) {
        return Err(MetricError::WrongShape { pixels: pixels.len(), width, height });
    }
    require_finite(pixels, "image")?;
    let mut means = Vec::with_capacity(width.div_ceil(block) * height.div_ceil(block));
    for top in (0..height).step_by(block) {
        for left in (0..width).step_by(block) {
            let (bottom, right) = ((top + block).min(height), (left + block).min(width));
            let mut sum = [0.0_f64; 3];
            for row in top..bottom {
                for pixel in &pixels[row * width + left..row * width + right] {
                    (0..3).for_each(|channel| sum[channel] += f64::from(pixel[channel]));
                }
            }
            let count = ((bottom - top) * (right - left)) as f64;
            means.push(sum.map(|s| (s / count) as f32));
        }
    }
    Ok(means)
}

fn require_finite(pixels: &[[f32; 3]], which: &'static str) -> Result<(), MetricError> {
    match pixels.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        Some(pixel) => Err(MetricError::NotFinite { which, pixel }),
        None => Ok(()),
    }
}
