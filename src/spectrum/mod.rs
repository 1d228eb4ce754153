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

/// Implements operators band by band, each as one of [`DVec3`].
macro_rules! operators {
    ($($operator:ident $method:ident $other:ty: $value:expr,)*) => {
        $(impl $operator<$other> for Spectrum {
            type Output = Self;

            #[inline]
            fn $method(self, other: $other) -> Self {
                Self($operator::$method(self.0, $value(other)))
            }
        })*
    };
    ($($operator:ident $method:ident $other:ty: $value:expr;)*) => {
        $(impl $operator<$other> for Spectrum {
            #[inline]
            fn $method(&mut self, other: $other) {
                $operator::$method(&mut self.0, $value(other));
            }
        })*
    };
}

operators! {
    Add add Self: |other: Self| other.0,
    Sub sub Self: |other: Self| other.0,
    Mul mul Self: |other: Self| other.0,
    Mul mul f64: |factor: f64| factor,
    Div div f64: |divisor: f64| divisor,
}

operators! {
    AddAssign add_assign Self: |other: Self| other.0;
    MulAssign mul_assign Self: |other: Self| other.0;
    MulAssign mul_assign f64: |factor: f64| factor;
    DivAssign div_assign f64: |divisor: f64| divisor;
}
