//! How a check is run: what is put to the test, and what may come of it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::formula::Formula;
use super::outcome::{Case, Effort, Measurement, Outcome, Step, Sweep};
use crate::scene::SceneError;
use crate::tracking::Mode;

/// What is put to the test. The shipping code is [`Subject::shipped`]; with other modes or another formula the same checks must fail.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    pub effort: Effort,
    /// Ways of tracking media that must be right.
    pub modes: &'a [Mode],
    pub formula: Formula,
    /// Set to stop early: what has not been measured by then is not run.
    pub cancel: &'a AtomicBool,
}

impl<'a> Subject<'a> {
    /// The code that renders.
    pub fn shipped(effort: Effort, cancel: &'a AtomicBool) -> Self {
        Self { effort, modes: &[Mode::Rectified, Mode::Reference], formula: Formula::Shipped, cancel }
    }

    /// `quick` or `full`, by effort.
    pub(super) fn amount<T>(&self, quick: T, full: T) -> T {
        match self.effort {
            Effort::Quick => quick,
            Effort::Full => full,
        }
    }

    /// # Errors
    /// When the checks were cancelled.
    pub(super) fn go_on(&self) -> Result<(), Unmeasured> {
        if self.cancel.load(Ordering::Relaxed) { Err(Unmeasured::Cancelled) } else { Ok(()) }
    }
}

/// Why there are no measurements.
#[derive(Debug)]
pub(super) enum Unmeasured {
    /// The program cannot do it yet.
    Missing(&'static str),
    Cancelled,
    /// The scene of the case was refused.
    Refused(SceneError),
}

impl From<SceneError> for Unmeasured {
    fn from(error: SceneError) -> Self {
        Self::Refused(error)
    }
}

impl Unmeasured {
    fn outcome(&self) -> Outcome {
        match self {
            Self::Missing(what) => Outcome::NotRun { reason: (*what).to_owned() },
            Self::Cancelled => Outcome::NotRun { reason: "cancelled".to_owned() },
            Self::Refused(error) => Outcome::Failed { reason: format!("the scene was refused: {error}") },
        }
    }
}

pub(super) type Measured = Result<Vec<Measurement>, Unmeasured>;

/// A case that can be run.
#[derive(Debug, Clone, Copy)]
pub struct CaseDefinition {
    /// As in [`Case`].
    pub number: Option<u32>,
    pub name: &'static str,
    pub source: &'static str,
    pub(super) measure: fn(&Subject) -> Measured,
}

impl CaseDefinition {
    pub(super) const fn new(
        number: u32,
        name: &'static str,
        source: &'static str,
        measure: fn(&Subject) -> Measured,
    ) -> Self {
        Self { number: Some(number), name, source, measure }
    }

    pub fn run(&self, subject: &Subject) -> Case {
        let start = Instant::now();
        let measured = subject.go_on().and_then(|()| (self.measure)(subject));
        let (measurements, outcome) = match measured {
            Ok(measurements) => {
                let outcome = Outcome::of(&measurements);
                (measurements, outcome)
            }
            Err(why) => (Vec::new(), why.outcome()),
        };
        Case {
            number: self.number,
            name: self.name.to_owned(),
            source: self.source.to_owned(),
            measurements,
            outcome,
            seconds: start.elapsed().as_secs_f64(),
        }
    }
}

/// A sweep that can be run.
#[derive(Debug, Clone, Copy)]
pub struct SweepDefinition {
    pub name: &'static str,
    pub about: &'static str,
    pub parameter: &'static str,
    pub(super) measure: fn(&Subject) -> Result<Vec<Step>, Unmeasured>,
}

impl SweepDefinition {
    pub fn run(&self, subject: &Subject) -> Sweep {
        let start = Instant::now();
        let (steps, outcome) = match subject.go_on().and_then(|()| (self.measure)(subject)) {
            Ok(steps) => {
                let outcome = Outcome::of(steps.iter().map(|step| &step.measurement));
                (steps, outcome)
            }
            Err(why) => (Vec::new(), why.outcome()),
        };
        Sweep {
            name: self.name.to_owned(),
            about: self.about.to_owned(),
            parameter: self.parameter.to_owned(),
            steps,
            outcome,
            seconds: start.elapsed().as_secs_f64(),
        }
    }
}
