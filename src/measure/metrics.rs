//! Differences between two linear images, never between tone-mapped ones.
//!
//! With x the image and r the reference, over all pixels and channels: MSE = mean (x − r)², relMSE = mean (x − r)²/(r² + 0.01)
//! (Rousselle et al. 2011), sMAPE = mean 2|x − r|/(|x| + |r| + 0.01). The trimmed relMSE leaves out the worst 0.1 % of pixels, so that
//! a few fireflies do not decide it. All sums are in f64.
//!
//! A reference that is itself rendered has noise, which adds its own variance to every figure. With two independent references r₁ and r₂,
//! (x − r₁)(x − r₂) has the mean (x − E r)²: their noise cancels ([`difference_from_two`]).

/// Keeps relMSE and sMAPE finite where the reference is black.
pub const DARK: f64 = 0.01;
/// The share of pixels that the trimmed relMSE leaves out: one in so many.
pub const TRIM_ONE_IN: usize = 1000;

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
    #[error("cannot compare images without pixels")]
    Empty,
    #[error("cannot compare images of different sizes: {image} pixels and {reference} pixels")]
    SizesDiffer { image: usize, reference: usize },
    /// A NaN or an infinity, which would make every figure meaningless or, worse, barely move it. `which` is `"image"` or `"reference"`,
    /// `pixel` the row-major index of the first such pixel.
    #[error("pixel {pixel} of the {which} is not a finite number, so the images cannot be compared")]
    NotFinite { which: &'static str, pixel: usize },
    #[error("an image of {pixels} pixels cannot be {width} pixels wide and {height} high")]
    WrongShape { pixels: usize, width: usize, height: usize },
    /// FLIP looks at images from a distance, and this is none.
    #[error("FLIP needs between 1 and 1000 pixels per degree; 67 is usual")]
    PixelsPerDegree,
}

/// Compares `image` with `reference`, both linear RGB in the same pixel order.
///
/// # Errors
/// When the images are empty, differ in size, or hold a component that is not finite.
pub fn difference(image: &[[f32; 3]], reference: &[[f32; 3]]) -> Result<Difference, MetricError> {
    require_comparable(image, reference)?;
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
    let components = 3.0 * image.len() as f64;
    Ok(Difference {
        mse: squared / components,
        relmse: mean(&relative_of_pixel),
        relmse_trimmed: mean(without_worst(&mut relative_of_pixel, |&relative| relative)),
        mean_abs: absolute / components,
        smape: symmetric / components,
    })
}

/// Squared errors of one image, freed from the noise of its reference. Where the error is below that noise, a figure can come out
/// negative by chance: its mean over further references is not, and it is not to be cut off at 0, which would make it too large.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct UnbiasedDifference {
    /// Mean (x − r₁)(x − r₂), radiance².
    pub mse: f64,
    /// The same relative to the square of r = (r₁ + r₂)/2: mean (x − r₁)(x − r₂)/(r² + 0.01). The denominator keeps
    /// its noise: references whose noise is a share s of their radiance leave a term of the order of s² times the root of this figure.
    pub relmse: f64,
    /// The same without the worst 0.1 % of pixels. The worst are those where (x − r)²/(r² + 0.01) is greatest, and not where the product
    /// is: (x − r₁)(x − r₂) = (x − r)² − (r₁ − r₂)²/4, and to leave out pixels in which the second term happens to be small would be a bias.
    pub relmse_trimmed: f64,
}

/// Compares `image` with what two independent `references` have in common, all linear RGB in the same pixel order. Independent:
/// rendered with different seeds, from each other and from the image.
///
/// # Errors
/// As [`difference`].
pub fn difference_from_two(
    image: &[[f32; 3]],
    references: [&[[f32; 3]]; 2],
) -> Result<UnbiasedDifference, MetricError> {
    for reference in references {
        require_comparable(image, reference)?;
    }
    let mut squared = 0.0;
    // Of each pixel: how bad it is, and what it adds.
    let mut relative_of_pixel = Vec::with_capacity(image.len());
    for ((x, a), b) in image.iter().zip(references[0]).zip(references[1]) {
        let (mut relative, mut badness) = (0.0, 0.0);
        for channel in 0..3 {
            let [x, a, b] = [x, a, b].map(|pixel| f64::from(pixel[channel]));
            let r = 0.5 * (a + b);
            let product = (x - a) * (x - b);
            squared += product;
            relative += product / (r * r + DARK);
            badness += (x - r) * (x - r) / (r * r + DARK);
        }
        relative_of_pixel.push((badness, relative / 3.0));
    }
    let relative: Vec<f64> = relative_of_pixel.iter().map(|(_, relative)| *relative).collect();
    let kept: Vec<f64> =
        without_worst(&mut relative_of_pixel, |(badness, _)| *badness).iter().map(|(_, relative)| *relative).collect();
    Ok(UnbiasedDifference {
        mse: squared / (3.0 * image.len() as f64),
        relmse: mean(&relative),
        relmse_trimmed: mean(&kept),
    })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The pixels but for the worst 0.1 %, in another order where any are left out.
fn without_worst<T>(pixels: &mut [T], badness: impl Fn(&T) -> f64) -> &[T] {
    let kept = pixels.len() - pixels.len() / TRIM_ONE_IN;
    if kept < pixels.len() {
        pixels.select_nth_unstable_by(kept, |a, b| badness(a).total_cmp(&badness(b)));
    }
    &pixels[..kept]
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

fn require_comparable(image: &[[f32; 3]], reference: &[[f32; 3]]) -> Result<(), MetricError> {
    if image.len() != reference.len() {
        return Err(MetricError::SizesDiffer { image: image.len(), reference: reference.len() });
    }
    if image.is_empty() {
        return Err(MetricError::Empty);
    }
    require_finite(image, "image")?;
    require_finite(reference, "reference")
}

pub(super) fn require_finite(pixels: &[[f32; 3]], which: &'static str) -> Result<(), MetricError> {
    match pixels.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        Some(pixel) => Err(MetricError::NotFinite { which, pixel }),
        None => Ok(()),
    }
}
