//! Samples in bulk: a scene made ready, a film, and passes over it on all cores.

pub mod allocation;
pub mod cpu;
pub mod display;
pub mod events;
pub mod film;
pub mod fingerprint;
pub mod prepare;
pub mod surfaces;
pub mod worker;

pub use cpu::{RenderSettings, VarianceReduction, accumulate};
pub use display::{Display, ToneCurve};
pub use events::Events;
pub use film::Film;
pub use fingerprint::fingerprint;
pub use prepare::{PrepareSeconds, Prepared, prepare};
