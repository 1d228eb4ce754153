//! The first samples of every pixel, from which further ones are allocated.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Samples that every pixel gets before anything is decided.
pub const PILOT: u32 = 8;
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

    /// What each pixel's samples tell, given their sums and counts.
    pub(super) fn pixels(&self, sums: &[DVec3], counts: &[u32]) -> Vec<PilotPixel> {
        (sums.par_iter().zip(counts).zip(&self.squares).zip(&self.segments))
            .map(|(((sum, count), squares), segments)| {
                let mean = *sum / f64::from((*count).max(1));
                let variance = variance(mean, *squares, *count);
                PilotPixel { mean, variance, segments: f64::from(*segments) }
            })
            .collect()
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

#[cfg(feature = "gpu")]
impl PilotRow<'_> {
    /// Adds samples whose squares and segments were summed elsewhere.
    pub(super) fn add_sums(&mut self, column: usize, squares: [f32; 3], segments: u32) {
        self.segments[column] += segments;
        self.squares[column].iter_mut().zip(squares).for_each(|(sum, value)| *sum += value);
    }
}

/// What the pilot samples of one pixel tell.
#[derive(Debug, Clone, Copy)]
pub struct PilotPixel {
    /// Of the samples, linear RGB.
    pub mean: DVec3,
    /// Of a sample, estimated.
    pub variance: DVec3,
    /// Of all its paths.
    pub segments: f64,
}

impl PilotPixel {
    /// Variance of a sample relative to the pixel's own radiance, mean over the channels.
    pub fn relative_variance(&self) -> f64 {
        relative(self.variance, self.mean)
    }
}

/// This variance relative to a radiance, as in relMSE: mean over the channels.
pub fn relative(variance: DVec3, radiance: DVec3) -> f64 {
    (variance / (radiance * radiance + DARK)).element_sum() / 3.0
}

/// Of a sample, from `count` of them with this mean and these sums of squares; 0 where there are too few.
fn variance(mean: DVec3, squares: [f32; 3], count: u32) -> DVec3 {
    let count = f64::from(count);
    if count < 2.0 {
        return DVec3::ZERO;
    }
    let squares = Vec3::from(squares).as_dvec3() / count;
    (squares - mean * mean).max(DVec3::ZERO) * (count / (count - 1.0))
}
