//! Irregular numbers for pre-trace rays: a counter through a strong mixing function (SplitMix64, Steele et al. 2014).

use glam::DVec3;

use crate::geometry::uniform_direction;

/// A stream of numbers that its seed determines.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A stream that the bits of a point determine.
    pub fn from_point(point: DVec3) -> Self {
        let mut random = Self(0x9E37_79B9_7F4A_7C15);
        for coordinate in point.to_array() {
            random.0 ^= coordinate.to_bits();
            random.0 = random.next_bits();
        }
        random
    }

    fn next_bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn next(&mut self) -> f64 {
        (self.next_bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
    /// Uniform on the sphere.
    pub fn direction(&mut self) -> DVec3 {
        uniform_direction([self.next(), self.next()])
    }
}
