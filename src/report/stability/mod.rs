//! Numerical stability: stiff and extreme cases, put to the code that renders, with what was to be found, what was found, and how far
//! apart the two may be.
//!
//! - [`Case`]s: forty named ones, and a few beyond them, each with its source in physics.
//! - [`Sweep`]s: one property of a scene taken from harmless to extreme, with the error at each step.
//! - [`Map`]s: the error of Fresnel's equations over index and angle.
//!
//! Expected values are closed forms, evaluated here in f64 or in [`extended`] precision; none comes from this renderer. What needs a
//! capability that the program does not have is *not run*, which is never a pass; what is missed is a failure with its reason.

mod outcome;

pub use outcome::{Case, Effort, ErrorKind, Map, Measurement, Outcome, Stability, Step, Sweep};
