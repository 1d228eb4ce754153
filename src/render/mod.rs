//! Samples in bulk: a scene made ready, a film, and passes over it on all cores.

pub mod allocation;
pub mod cpu;
pub mod display;
pub mod events;
pub mod exact;
pub mod film;
pub mod fingerprint;
pub mod partial;
pub mod prepare;
pub mod surfaces;
pub mod worker;

pub use cpu::{RenderSettings, VarianceReduction, accumulate};
pub use display::{Display, ToneCurve};
pub use events::Events;
pub use film::Film;
pub use fingerprint::fingerprint;
pub use partial::{CannotMerge, Partial, Recipe, SampleRange};
pub use prepare::{PrepareError, PrepareSeconds, Prepared, prepare, prepare_watched};
