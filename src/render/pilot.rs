//! The first samples of every pixel, from which further ones are allocated.

use glam::DVec3;
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
            .map(|(((sum, count), squares), segments)| PilotPixel {
                variance: relative_variance(*sum, *squares, *count),
                segments: f64::from(*segments),
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
    /// Of a sample, relative to the pixel's radiance.
    pub variance: f64,
    /// Of all its paths.
    pub segments: f64,
}

/// Variance of a sample relative to the pixel's radiance, mean over the channels.
fn relative_variance(sum: DVec3, squares: [f32; 3], count: u32) -> f64 {
    let mean = (sum / f64::from(count.max(1))).to_array();
    let count = f64::from(count);
    if count < 2.0 {
        return 0.0;
    }
    let of_channel = |channel: usize| {
        let squares = f64::from(squares[channel]) / count;
        let variance = (squares - mean[channel] * mean[channel]).max(0.0) * count / (count - 1.0);
        variance / (mean[channel] * mean[channel] + DARK)
    };
    (0..3).map(of_channel).sum::<f64>() / 3.0
}
