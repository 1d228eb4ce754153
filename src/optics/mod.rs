//! The physics of interfaces and media, without any geometry.

pub mod catalog;
pub mod dispersion;
pub mod fresnel;
pub mod medium;

pub use dispersion::IorModel;
pub use fresnel::{Interface, Refraction};
pub use medium::Medium;
