//! The modes: ways to know, at a crossing of a refractor's surface, which medium is left and which is entered.
//!
//! A mode is a file with its [`Tracker`] and one line in [`mode`].

pub mod events;
pub mod mode;
pub mod naive;
pub mod prepare;
pub mod priority;
pub mod rectified;
pub mod rectified_object;
pub mod reference;
pub mod stack;
pub mod tracker;

pub use events::Events;
pub use mode::Mode;
pub use prepare::{PrepareError, PrepareSeconds, Prepared, prepare, prepare_watched};
pub use tracker::{Crossing, Sides, Tracker, TrackingMode, WithTracker};
