//! A medium as the user describes it.

use super::Ior;

/// Name of the global medium wherever media are named.
pub const WORLD: &str = "world";
/// Name of the reserved medium that `naive` puts around everything: IOR 1, no absorption.
pub const VACUUM: &str = "vacuum";

/// A homogeneous medium.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// Unique in its scene; never [`WORLD`] or [`VACUUM`].
    pub name: String,
    pub ior: Ior,
    /// Absorption coefficient σ per scene unit, base e, for red, green and blue; each ≥ 0.
    pub absorption: [f64; 3],
}
