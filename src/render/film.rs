//! Accumulated radiance.

use glam::DVec3;

use super::events::Events;

/// Sums of radiance samples per pixel in f64, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    /// Sum of the finite samples of each pixel, linear RGB.
    pub sums: Vec<DVec3>,
    /// Finite samples in each pixel's sum.
    pub counts: Vec<u32>,
    /// Samples taken of every pixel, finite or not.
    pub samples: u32,
    pub events: Events,
}

impl Film {
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            width,
            height,
            sums: vec![DVec3::ZERO; pixels],
            counts: vec![0; pixels],
            samples: 0,
            events: Events::default(),
        }
    }

    /// Mean radiance of a pixel by index; black before the first sample.
    #[inline]
    pub fn mean(&self, pixel: usize) -> DVec3 {
        self.sums[pixel] / f64::from(self.counts[pixel].max(1))
    }

    /// Means of all pixels as linear RGB in f32.
    pub fn to_rgb(&self) -> Vec<[f32; 3]> {
        (0..self.sums.len()).map(|pixel| self.mean(pixel).as_vec3().to_array()).collect()
    }
}
