//! Samples in bulk: a scene made ready, a film, and passes over it on all cores.

pub mod allocation;
pub mod cpu;
pub mod display;
pub mod exact;
pub mod film;
pub mod fingerprint;
pub mod partial;
pub mod surfaces;

pub use cpu::{RenderSettings, VarianceReduction, accumulate};
pub use display::{Display, ToneCurve};
pub use film::Film;
pub use fingerprint::fingerprint;
pub use partial::{CannotMerge, Partial, Recipe, SampleRange};
