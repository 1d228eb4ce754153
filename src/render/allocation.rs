//! Adaptive sampling: how the samples of an image are spread over its pixels.
//!
//! The first [`PILOT`] samples of every pixel are looked at once. From then on a pixel gets samples in proportion to a weight, a power of
//! two, for which the error of its neighbourhood pays best (relative error against what a sample costs).
//!
//! The result has no bias, because no sample decides how many samples it is averaged with: pixels are divided like a chessboard, and the
//! weights of the white ones, their normalisation included, depend on the pilot samples of the black ones alone, and the other way
//! round. Given the black ones' pilot samples, the number of samples of a white pixel is a constant, and their mean is that of any fixed number.

use glam::DVec3;
use rayon::prelude::*;

use super::film::Film;

/// Samples that every pixel gets before anything is decided.
pub const PILOT: u32 = 8;
/// The greatest and the least weight, as powers of two.
const LEVELS: i32 = 3;
/// Pixels this far apart, in either direction, tell of each other.
const REACH: i64 = 3;
/// Relative variance of a sample that is taken for granted where the pilot saw none: what so few samples can have missed.
const UNSEEN_VARIANCE: f64 = 5e-3;
/// Added to squared radiance where an error is taken relative to it, as in relMSE.
const DARK: f64 = 0.01;

/// What the pilot samples of a film tell, next to their sum.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pilot {
    /// Sums of squares of each pixel's samples, linear RGB.
    pub squares: Vec<[f32; 3]>,
    /// Segments of each pixel's paths.
    pub segments: Vec<u32>,
}

impl Pilot {
    pub(super) fn new(pixels: usize) -> Self {
        Self { squares: vec![[0.0; 3]; pixels], segments: vec![0; pixels] }
    }

    /// Rows of an image of that width.
    pub(super) fn rows(&mut self, width: usize) -> impl Iterator<Item = PilotRow<'_>> {
        let segments = self.segments.chunks_mut(width);
        self.squares.chunks_mut(width).zip(segments).map(|(squares, segments)| PilotRow { squares, segments })
    }
}

/// A row of an image, to be added to.
pub(super) struct PilotRow<'a> {
    squares: &'a mut [[f32; 3]],
    segments: &'a mut [u32],
}

impl PilotRow<'_> {
    /// Adds a sample of that radiance, whose path had so many segments.
    #[inline]
    pub(super) fn add(&mut self, column: usize, radiance: DVec3, segments: u32) {
        self.segments[column] += segments;
        if radiance.is_finite() {
            for (sum, value) in self.squares[column].iter_mut().zip(radiance.as_vec3().to_array()) {
                *sum += value * value;
            }
        }
    }
}

/// The weight of each pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Allocation {
    /// As powers of two.
    levels: Vec<i8>,
}

impl Allocation {
    /// From films of one size that have their pilot samples; those that are compared with each other share one allocation. `None` where a film
    /// has not recorded them.
    pub fn new<'a>(films: impl IntoIterator<Item = &'a Film>) -> Option<Self> {
        let mut pixels: Vec<(f64, f64)> = Vec::new();
        let mut width = 0;
        for film in films {
            let pilot = film.pilot.as_ref()?;
            width = film.width as usize;
            pixels.resize(film.sums.len(), (0.0, 0.0));
            pixels.par_iter_mut().enumerate().for_each(|(pixel, (variance, segments))| {
                *variance = variance.max(relative_variance(film, pilot, pixel));
                *segments += f64::from(pilot.segments[pixel]);
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
        Some(Self { levels: wishes.par_iter().enumerate().map(level).collect() })
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

/// Variance of a sample relative to the pixel's radiance, mean over the channels.
fn relative_variance(film: &Film, pilot: &Pilot, pixel: usize) -> f64 {
    let count = f64::from(film.counts[pixel]);
    if count < 2.0 {
        return 0.0;
    }
    let mean = film.mean(pixel).to_array();
    let of_channel = |channel: usize| {
        let squares = f64::from(pilot.squares[pixel][channel]) / count;
        let variance = (squares - mean[channel] * mean[channel]).max(0.0) * count / (count - 1.0);
        variance / (mean[channel] * mean[channel] + DARK)
    };
    (0..3).map(of_channel).sum::<f64>() / 3.0
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
