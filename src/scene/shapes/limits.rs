//! How large and how fine shapes may be, and how fine they are by default.

/// Largest coordinate and length: beyond, products of two would overflow in single precision.
pub const MAX_LENGTH: f64 = 1e18;
/// Least length and scale: below it, products of three lengths are 0.
pub const MIN_LENGTH: f64 = 1e-100;
/// Angles under which directional lights are seen, in degrees, other than 0. Smaller ones would not be told from it in single precision.
pub const SUN_ANGLES: std::ops::RangeInclusive<f64> = 0.001..=180.0;
/// Most triangles that a shape may be tessellated into.
pub const MAX_TRIANGLES: u64 = 4_000_000;
/// Most segments of a shape of revolution, and most rings of a torus.
pub const MAX_SEGMENTS: u32 = 8192;
/// Most subdivisions of an icosphere: 20 · 4⁸ = 1.3 million triangles.
pub const MAX_SUBDIVISIONS: u32 = 8;

/// Segments around the axis where a scene gives none.
pub const DEFAULT_SEGMENTS: u32 = 192;
/// Rings of a torus where a scene gives none.
pub const DEFAULT_RINGS: u32 = 96;
