//! The physics of interfaces and media, without any geometry.

pub mod catalog;
pub mod fresnel;
pub mod ior;
pub mod medium;

pub use fresnel::{Interface, Refraction};
pub use ior::Ior;
pub use medium::Medium;
