//! Light as transport carries it: how much of it, and at which wavelengths.

mod wavelengths;

use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Sub};

use glam::DVec3;

pub use wavelengths::{WAVELENGTH_D_UM, Wavelengths};

/// Radiance, or a factor on it, at the wavelengths of a path: today its three bands in linear Rec. 709.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(transparent)]
pub struct Spectrum(DVec3);

impl Spectrum {
    pub const ZERO: Self = Self(DVec3::ZERO);
    pub const ONE: Self = Self(DVec3::ONE);

    /// From linear Rec. 709.
    pub const fn from_rgb([r, g, b]: [f64; 3]) -> Self {
        Self(DVec3::new(r, g, b))
    }

    /// As linear Rec. 709.
    #[inline]
    pub fn to_rgb(self) -> [f64; 3] {
        self.0.to_array()
    }

    #[inline]
    pub fn max_component(self) -> f64 {
        self.0.max_element()
    }

    /// Sum over the bands.
    #[inline]
    pub fn sum(self) -> f64 {
        self.0.element_sum()
    }

    #[inline]
    pub fn is_black(self) -> bool {
        self.0 == DVec3::ZERO
    }

    #[inline]
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    /// Transmittance exp(−σ·`length`) of this absorption σ (Beer and Lambert).
    #[inline]
    pub fn transmittance(self, length: f64) -> Self {
        Self((self.0 * -length).exp())
    }
}

impl Add for Spectrum {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl AddAssign for Spectrum {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl Sub for Spectrum {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul for Spectrum {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl MulAssign for Spectrum {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        self.0 *= other.0;
    }
}

impl Mul<f64> for Spectrum {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self(self.0 * factor)
    }
}

impl MulAssign<f64> for Spectrum {
    #[inline]
    fn mul_assign(&mut self, factor: f64) {
        self.0 *= factor;
    }
}

impl Div<f64> for Spectrum {
    type Output = Self;

    #[inline]
    fn div(self, divisor: f64) -> Self {
        Self(self.0 / divisor)
    }
}

impl DivAssign<f64> for Spectrum {
    #[inline]
    fn div_assign(&mut self, divisor: f64) {
        self.0 /= divisor;
    }
}
