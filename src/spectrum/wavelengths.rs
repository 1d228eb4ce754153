//! Which wavelengths a path carries, and so where the indices of its media are taken.

/// The helium d line, in micrometres (587.5618 nm, commonly written 587.56): the wavelength at which an IOR is taken where
/// transport is in RGB, and at which glass makers print n.
pub const WAVELENGTH_D_UM: f64 = 0.587_561_8;

/// The wavelengths of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wavelengths {
    /// The three bands of RGB, all refracted as the d line is.
    Rgb,
    /// One wavelength, in micrometres.
    Single { um: f64 },
}
