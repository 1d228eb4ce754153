//! IOR against wavelength.

use super::catalog;

/// The helium d line, in micrometres: the wavelength at which an IOR is taken where transport is in RGB.
pub const WAVELENGTH_D_UM: f64 = 0.58756;

/// How a medium's index of refraction is given.
#[derive(Debug, Clone, PartialEq)]
pub enum IorModel {
    /// The same at every wavelength.
    Constant(f64),
    /// n = A + B/λ² + C/λ⁴, λ in µm.
    Cauchy([f64; 3]),
    /// n² = 1 + Σ Bλ²/(λ² − C), λ in µm, C in µm².
    Sellmeier(Vec<[f64; 2]>),
    /// By name, from [`catalog`].
    Catalog(&'static catalog::Entry),
}
