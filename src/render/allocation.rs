//! Adaptive sampling: how the samples of an image are spread over its pixels.
//!
//! The first [`PILOT`] samples of every pixel are looked at once. From then on a pixel gets samples in proportion to a weight, a power of
//! two, for which the error of its neighbourhood pays best (relative error against what a sample costs).
//!
//! Samples that are rare and bright, such as light that a small lamp throws through ice, are missed by the pilot samples of most pixels, which would
//! then be starved. So the weights are tempered: raised to a power from 0, all alike, to 1, that which pays best for pilot samples that the weights
//! were not made from. What is rare in one pixel is not rare in a whole image, and shows in the sum over it.
//!
//! The result has no bias, because no sample decides how many samples it is averaged with: pixels are divided like a chessboard, and the
//! weights of the white ones, their normalisation and power included, depend on the pilot samples of the black ones alone, and the other way
//! round. Given the black ones' pilot samples, the number of samples of a white pixel is a constant, and their mean is that of any fixed number.

use glam::DVec3;
use rayon::prelude::*;

use super::pilot::{PILOT, PilotPixel, relative};

/// The greatest and the least weight, as powers of two.
const LEVELS: i32 = 3;
/// Pixels this far apart, in either direction, tell of each other.
const REACH: i64 = 3;
/// Relative variance of a sample that is taken for granted where the pilot saw none: what so few samples can have missed.
const UNSEEN_VARIANCE: f64 = 5e-3;
/// Powers that weights may be raised to.
const POWERS: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Pixels of a colour, at most, by which a power is chosen.
const MOST_TRIED: usize = 1 << 14;
/// A power must lower the error this far, times what the samples cost, or all pixels get as many samples: what is gained by less may be chance.
const LEAST_GAIN: f64 = 0.9;

/// The weight of each pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Allocation {
    /// As powers of two.
    levels: Vec<i8>,
}

/// A pixel as it is seen by others.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    /// Variance relative to the pixel's own radiance, the largest of all images.
    variance: f64,
    segments: f64,
}

impl Allocation {
    /// For images of that `width` that are compared with each other, from what their pilot samples tell.
    pub fn new(width: usize, images: &[Vec<PilotPixel>]) -> Self {
        let mut pixels: Vec<Seen> = Vec::new();
        for image in images {
            pixels.resize(image.len(), Seen::default());
            pixels.par_iter_mut().zip(image).for_each(|(seen, pixel)| {
                seen.variance = seen.variance.max(pixel.relative_variance());
                seen.segments += pixel.segments;
            });
        }
        let board = Board { width, height: pixels.len() / width.max(1) };
        // log2 of the weight that each pixel would have, up to a factor, from the pixels of the other colour.
        let wishes = board.wishes(&pixels, |dx, dy| (dx + dy) % 2 != 0);
        // The same from pixels of its own colour, in other rows and columns.
        let tried = board.wishes(&pixels, |dx, dy| dx % 2 != 0 && dy % 2 != 0);
        let errors = board.errors(images);
        let [of_black, of_white] = [false, true].map(|white| {
            let of_color = (0..pixels.len()).filter(|pixel| board.is_white(*pixel) == white);
            let some = of_color.step_by(pixels.len().div_ceil(2 * MOST_TRIED).max(1));
            best_power(some.map(|pixel| (tried[pixel], errors[pixel], pixels[pixel].segments)))
        });
        let [for_black, for_white] = [(false, of_white), (true, of_black)].map(|(white, power)| {
            let of_color = |pixel: &usize| board.is_white(*pixel) == white;
            (power, normalization((0..wishes.len()).filter(of_color).map(|pixel| power * wishes[pixel])))
        });
        let level = |(pixel, wish): (usize, &f32)| {
            let (power, shift) = if board.is_white(pixel) { for_white } else { for_black };
            level(power * wish + shift)
        };
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

/// An image's pixels as a chessboard.
#[derive(Debug, Clone, Copy)]
struct Board {
    width: usize,
    height: usize,
}

impl Board {
    fn is_white(self, pixel: usize) -> bool {
        (pixel % self.width + pixel / self.width).is_multiple_of(2)
    }

    /// Visits the pixels around one, by number, whose distance across and down `is_asked`.
    fn around(self, pixel: usize, is_asked: impl Fn(i64, i64) -> bool, mut visit: impl FnMut(usize)) {
        let (x, y) = ((pixel % self.width) as i64, (pixel / self.width) as i64);
        for dy in -REACH..=REACH {
            for dx in -REACH..=REACH {
                let (nx, ny) = (x + dx, y + dy);
                let is_inside = nx >= 0 && ny >= 0 && nx < self.width as i64 && ny < self.height as i64;
                if is_inside && is_asked(dx, dy) {
                    visit(ny as usize * self.width + nx as usize);
                }
            }
        }
    }

    /// log2 of the weight of each pixel by the pixels around it, up to a factor.
    fn wishes(self, pixels: &[Seen], is_asked: impl Fn(i64, i64) -> bool + Sync) -> Vec<f32> {
        (0..pixels.len())
            .into_par_iter()
            .map(|pixel| {
                let (mut variance, mut segments, mut count) = (0.0, 0.0, 0.0);
                self.around(pixel, &is_asked, |other| {
                    variance += pixels[other].variance;
                    segments += pixels[other].segments;
                    count += 1.0;
                });
                // An image of one pixel has no neighbours.
                let count = f64::max(count, 1.0);
                (0.5 * ((variance / count + UNSEEN_VARIANCE) / (segments / count + 1.0)).log2()) as f32
            })
            .collect()
    }

    /// The variance of each pixel relative to the radiance of pixels of its colour around it, its own included: where one sample of eight is bright,
    /// the pixel's own mean is too bright to compare with. Sum over the images.
    fn errors(self, images: &[Vec<PilotPixel>]) -> Vec<f64> {
        let count = images.first().map_or(0, Vec::len);
        (0..count)
            .into_par_iter()
            .map(|pixel| {
                let of_image = |image: &Vec<PilotPixel>| {
                    let (mut radiance, mut count) = (DVec3::ZERO, 0.0);
                    self.around(
                        pixel,
                        |dx, dy| (dx + dy) % 2 == 0,
                        |other| {
                            radiance += image[other].mean;
                            count += 1.0;
                        },
                    );
                    relative(image[pixel].variance, radiance / f64::max(count, 1.0))
                };
                images.iter().map(of_image).sum()
            })
            .collect()
    }
}

/// The power of the weights that lowers the error most, times what the samples cost: of pixels with their wishes, errors and costs.
fn best_power(pixels: impl Iterator<Item = (f32, f64, f64)> + Clone) -> f32 {
    let product = |power: f32| {
        let shift = normalization(pixels.clone().map(|(wish, ..)| power * wish));
        let (mut error, mut cost) = (0.0, 0.0);
        for (wish, variance, segments) in pixels.clone() {
            let weight = f64::from(level(power * wish + shift)).exp2();
            error += variance / weight;
            cost += segments * weight;
        }
        error * cost
    };
    let all_alike = product(POWERS[0]);
    let best = POWERS[1..].iter().map(|&power| (power, product(power))).min_by(|a, b| a.1.total_cmp(&b.1));
    best.filter(|(_, product)| *product < LEAST_GAIN * all_alike).map_or(POWERS[0], |(power, _)| power)
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
