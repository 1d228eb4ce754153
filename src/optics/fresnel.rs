//! Fresnel and Snell.

/// An ordered pair of media, ready for Snell and Fresnel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interface {}

/// What happens to a ray at an interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refraction {}
