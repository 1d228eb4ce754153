//! Numerical stability: stiff and extreme cases, put to the code that renders, with what was to be found, what was found, and how far
//! apart the two may be.
//!
//! - [`Case`]s: forty named ones, and a few beyond them, each with its source in physics.
//! - [`Sweep`]s: one property of a scene taken from harmless to extreme, with the error at each step.
//! - [`Map`]s: the error of Fresnel's equations over index and angle.
//!
//! Expected values are closed forms, evaluated here in f64 or in [`extended`] precision; none comes from this renderer. What needs a
//! capability that the program does not have is *not run*, which is never a pass; what is missed is a failure with its reason.

mod beyond;
pub(super) mod closed_forms;
mod contrasts;
mod convex;
mod definition;
pub mod extended;
mod formula;
mod harsh;
mod images;
mod layers;
mod map;
mod nests;
mod optics;
mod outcome;
pub mod scenes;
mod shells;
mod sweeps;

pub use definition::{CaseDefinition, Subject, SweepDefinition};
pub use formula::{Evaluated, Formula};
pub use map::maps;
pub use outcome::{
    ByEstimator, Case, Effort, ErrorKind, Graphics, Map, Measurement, NOISE_ALLOWANCE, Outcome, Stability, Step, Sweep,
};

pub fn sweeps() -> Vec<SweepDefinition> {
    [contrasts::SWEEPS, sweeps::SWEEPS].concat()
}

/// All cases: the forty in order, and those beyond.
pub fn cases() -> Vec<CaseDefinition> {
    let mut cases: Vec<CaseDefinition> =
        [optics::CASES, layers::CASES, nests::CASES, images::CASES, shells::CASES, harsh::CASES, beyond::CASES]
            .concat();
    cases.sort_by_key(|case| case.number.unwrap_or(u32::MAX));
    cases
}
