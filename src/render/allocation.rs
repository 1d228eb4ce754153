//! Adaptive sampling: how the samples of an image are spread over its pixels.
//!
//! The first [`PILOT`] samples of every pixel are looked at once. From then on a pixel gets samples in proportion to a weight, a power of
//! two, for which the error of its neighbourhood pays best (relative error against what a sample costs).
//!
//! The result has no bias, because no sample decides how many samples it is averaged with: pixels are divided like a chessboard, and the
//! weights of the white ones, their normalisation included, depend on the pilot samples of the black ones alone, and the other way
//! round. Given the black ones' pilot samples, the number of samples of a white pixel is a constant, and their mean is that of any fixed number.

use rayon::prelude::*;

use super::pilot::{PILOT, PilotPixel};

/// The greatest and the least weight, as powers of two.
const LEVELS: i32 = 3;
/// Pixels this far apart, in either direction, tell of each other.
const REACH: i64 = 3;
/// Relative variance of a sample that is taken for granted where the pilot saw none: what so few samples can have missed.
const UNSEEN_VARIANCE: f64 = 5e-3;
/// The weight of each pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Allocation {
    /// As powers of two.
    levels: Vec<i8>,
}

impl Allocation {
    /// For images of that `width` that are compared with each other, from what their pilot samples tell.
    pub fn new(width: usize, images: &[Vec<PilotPixel>]) -> Self {
        let mut pixels: Vec<(f64, f64)> = Vec::new();
        for image in images {
            pixels.resize(image.len(), (0.0, 0.0));
            pixels.par_iter_mut().zip(image).for_each(|((variance, segments), pixel)| {
                *variance = variance.max(pixel.variance);
                *segments += pixel.segments;
            });
        }
        let height = pixels.len() / width.max(1);
        // log2 of the weight that each pixel would have, up to a factor.
        let wishes: Vec<f32> = (0..pixels.len())
            .into_par_iter()
            .map(|pixel| {
                let (variance, segments) = of_neighbours(&pixels, width, height, pixel);
                (0.5 * ((variance + UNSEEN_VARIANCE) / (segments + 1.0)).log2()) as f32
            })
            .collect();
        let is_white = |pixel: usize| (pixel % width + pixel / width).is_multiple_of(2);
        let shifts = [true, false].map(|white| {
            let of_color = |pixel: &usize| is_white(*pixel) == white;
            normalization((0..wishes.len()).filter(of_color).map(|pixel| wishes[pixel]))
        });
        let level = |(pixel, wish): (usize, &f32)| level(*wish + shifts[usize::from(!is_white(pixel))]);
        Self { levels: wishes.par_iter().enumerate().map(level).collect() }
    }

    /// Samples that a pixel has when the image has `samples` per pixel in the mean.
    #[inline]
    pub fn samples(&self, pixel: usize, samples: u32) -> u32 {
        // Up to the decision there is no difference.
        if samples <= PILOT {
            return samples;
        }
        let level = self.levels[pixel];
        let weighted =
            if level >= 0 { samples.saturating_mul(1 << level) } else { samples >> u32::from(level.unsigned_abs()) };
        weighted.max(PILOT)
    }
}

/// Mean variance and segments of the pixels of the other colour around one.
fn of_neighbours(pixels: &[(f64, f64)], width: usize, height: usize, pixel: usize) -> (f64, f64) {
    let (x, y) = ((pixel % width) as i64, (pixel / width) as i64);
    let (mut variance, mut segments, mut count) = (0.0, 0.0, 0.0);
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            let (nx, ny) = (x + dx, y + dy);
            if (dx + dy) % 2 == 0 || nx < 0 || ny < 0 || nx >= width as i64 || ny >= height as i64 {
                continue;
            }
            let (v, s) = pixels[ny as usize * width + nx as usize];
            variance += v;
            segments += s;
            count += 1.0;
        }
    }
    // An image of one pixel has no neighbours.
    let count = f64::max(count, 1.0);
    (variance / count, segments / count)
}

/// What to add to all wishes so that the weights' mean comes as near to 1 from below as it can.
fn normalization(wishes: impl Iterator<Item = f32> + Clone) -> f32 {
    let count = wishes.clone().count().max(1) as f64;
    let mean = |shift: f32| wishes.clone().map(|wish| f64::from(level(wish + shift)).exp2()).sum::<f64>() / count;
    let (mut low, mut high) = (-32.0, 32.0);
    for _ in 0..16 {
        let middle = 0.5 * (low + high);
        if mean(middle) <= 1.0 { low = middle } else { high = middle }
    }
    low
}

fn level(log2: f32) -> i8 {
    (log2.round() as i32).clamp(-LEVELS, LEVELS) as i8
}
