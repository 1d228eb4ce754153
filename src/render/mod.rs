//! Images: their settings, the film that samples are added to, and what renders them.

pub mod allocation;
pub mod backends;
pub mod choice;
pub mod cpu;
pub mod denoise;
pub mod display;
pub mod estimators;
pub mod exact;
pub mod film;
pub mod fingerprint;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod noise;
pub mod partial;
pub mod pilot;
pub mod renderer;
pub mod settings;
pub mod slice;
pub mod surfaces;

pub use backends::{GPU_MODES, renderer};
pub use choice::{BackendChoice, Chosen, choose};
pub use display::{Display, ToneCurve};
pub use estimators::{EstimatorChoice, choose_estimator};
pub use film::Film;
pub use fingerprint::fingerprint;
pub use noise::Noise;
pub use partial::{CannotMerge, Partial, Recipe, SampleRange};
pub use renderer::{RenderTask, Renderer, Unsupported};
pub use settings::{Backend, Estimator, ImageSettings};
