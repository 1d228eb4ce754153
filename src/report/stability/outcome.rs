//! What comes of a stability check: plain data, ready to be shown, stored and read back.

use serde::{Deserialize, Serialize};

use crate::render::Estimator;

/// Standard errors that a random estimate may be off, next to its bound.
pub const NOISE_ALLOWANCE: f64 = 4.0;

/// How much work goes into the random part of the checks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effort {
    /// All forty cases within some twenty seconds on two cores.
    Quick,
    /// Ten to twenty times the samples.
    Full,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorKind {
    /// |measured − expected|, in the measurement's unit.
    Absolute,
    /// |measured/expected − 1|.
    Relative,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// What was measured, and how: a mode, an angle, a height. In a sweep, the name of the curve.
    pub what: String,
    pub expected: f64,
    /// NaN where nothing could be measured, which is a failure.
    pub measured: f64,
    pub kind: ErrorKind,
    /// As `kind` says; NaN where nothing could be measured.
    pub error: f64,
    /// The largest error allowed next to noise, as `kind` says.
    pub bound: f64,
    /// Standard error of a random estimate, as `kind` says; 0 for what is not random. Four of them are allowed next to the bound.
    pub noise: f64,
    /// Of the three values: `"°"`, `"rad"`, `"pixels"`, `"rays"`, …; empty for plain numbers.
    pub unit: String,
    /// Why the bound cannot be met, where that is known.
    pub limit: Option<String>,
}

impl Measurement {
    /// A measurement that is off by `bound` at the most.
    pub fn absolute(what: impl Into<String>, measured: f64, expected: f64, bound: f64) -> Self {
        let error = (measured - expected).abs();
        Self {
            what: what.into(),
            expected,
            measured,
            kind: ErrorKind::Absolute,
            error,
            bound,
            noise: 0.0,
            unit: String::new(),
            limit: None,
        }
    }

    /// A measurement that is off by the fraction `bound` of `expected` at the most. An expected zero must be met exactly.
    pub fn relative(what: impl Into<String>, measured: f64, expected: f64, bound: f64) -> Self {
        let error = if measured == expected { 0.0 } else { (measured / expected - 1.0).abs() };
        Self { kind: ErrorKind::Relative, error, ..Self::absolute(what, measured, expected, bound) }
    }

    /// A count of things that must not happen.
    pub fn none_of(what: impl Into<String>, count: usize, unit: &str) -> Self {
        Self::absolute(what, count as f64, 0.0, 0.0).in_unit(unit)
    }

    /// The same as a random estimate with this standard error.
    #[must_use]
    pub fn with_noise(mut self, standard_error: f64) -> Self {
        self.noise = match self.kind {
            ErrorKind::Absolute => standard_error,
            ErrorKind::Relative => standard_error / self.expected.abs(),
        };
        self
    }

    #[must_use]
    pub fn in_unit(mut self, unit: &str) -> Self {
        unit.clone_into(&mut self.unit);
        self
    }

    /// The same with a reason to be shown if it fails.
    #[must_use]
    pub fn limited_by(mut self, reason: &str) -> Self {
        self.limit = Some(reason.to_owned());
        self
    }

    /// Whether the error is within the bound and the noise. A NaN anywhere is not.
    pub fn is_within_bound(&self) -> bool {
        self.error <= self.bound + NOISE_ALLOWANCE * self.noise
    }

    /// In words, with the reason where one is known; `None` within the bound.
    fn fault(&self) -> Option<String> {
        if self.is_within_bound() {
            return None;
        }
        let Self { what, measured, expected, error, bound, unit, .. } = self;
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let noise = if self.noise > 0.0 { format!(", noise {:.2e}", self.noise) } else { String::new() };
        // Counts of what must not happen need no error.
        let is_exact = self.kind == ErrorKind::Absolute && *bound == 0.0 && self.noise == 0.0;
        let error = if is_exact { String::new() } else { format!(" (error {error:.2e}, bound {bound:.2e}{noise})") };
        let limit = self.limit.as_ref().map_or(String::new(), |limit| format!(": {limit}"));
        Some(format!("{what}: {measured}{unit}, not {expected}{error}{limit}"))
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "outcome", rename_all = "kebab-case")]
pub enum Outcome {
    /// Everything was measured, and is within its bound.
    Passed,
    Failed {
        reason: String,
    },
    /// Nothing is known. Never a pass.
    NotRun {
        reason: String,
    },
}

impl Outcome {
    /// Of measurements that were all taken. None at all is a failure: it tells nothing.
    pub fn of<'a>(measurements: impl IntoIterator<Item = &'a Measurement>) -> Self {
        Self::of_faults(measurements.into_iter().map(Measurement::fault))
    }

    pub fn of_steps(steps: &[Step]) -> Self {
        Self::of_faults(steps.iter().map(|step| {
            let place = step.label.clone().unwrap_or_else(|| format!("{:e}", step.x));
            Some(format!("at {place}, {}", step.measurement.fault()?))
        }))
    }

    /// Of the fault of each measurement.
    fn of_faults(all: impl Iterator<Item = Option<String>>) -> Self {
        let all: Vec<Option<String>> = all.collect();
        let faults: Vec<&String> = all.iter().flatten().collect();
        let reason = match (all.len(), faults.as_slice()) {
            (0, _) => "nothing was measured".to_owned(),
            (_, []) => return Self::Passed,
            (_, [only]) => (*only).clone(),
            (count, [first, ..]) => format!("{} of {count} are out of bounds; first, {first}", faults.len()),
        };
        Self::Failed { reason }
    }

    pub fn is_passed(&self) -> bool {
        *self == Self::Passed
    }

    /// `"passed"`, `"failed"` or `"not run"`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed { .. } => "failed",
            Self::NotRun { .. } => "not run",
        }
    }

    /// Empty for a pass.
    pub fn reason(&self) -> &str {
        match self {
            Self::Passed => "",
            Self::Failed { reason } | Self::NotRun { reason } => reason,
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// 1 to 40; `None` for cases beyond the forty.
    pub number: Option<u32>,
    pub name: String,
    /// The formula or the paper that the expected values come from.
    pub source: String,
    /// Empty if the case was not run.
    pub measurements: Vec<Measurement>,
    #[serde(flatten)]
    pub outcome: Outcome,
    pub seconds: f64,
}

impl Case {
    /// The measurement nearest to its bound or farthest beyond: the one to show where there is room for one.
    pub fn worst(&self) -> Option<&Measurement> {
        let share = |m: &Measurement| {
            let share = m.error / (m.bound + NOISE_ALLOWANCE * m.noise);
            // Nothing allowed and nothing off is 0/0; a NaN measured is as bad as it gets.
            if m.error == 0.0 { 0.0 } else { share.max(if m.is_within_bound() { 0.0 } else { 1.0 }) }
        };
        self.measurements.iter().max_by(|a, b| share(a).total_cmp(&share(b)))
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    pub name: String,
    /// What was done and what it is compared with.
    pub about: String,
    /// What varies, for the axis of a plot: `"gap between shells, scene units"`.
    pub parameter: String,
    pub steps: Vec<Step>,
    #[serde(flatten)]
    pub outcome: Outcome,
    pub seconds: f64,
}

/// One measurement at one place of a sweep. Steps of equal [`Measurement::what`] make a curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Value of the parameter; where the parameter has names instead of values, the index of the name.
    pub x: f64,
    /// The parameter in words, where a number does not say it.
    pub label: Option<String>,
    pub measurement: Measurement,
}

impl Step {
    pub fn at(x: f64, measurement: Measurement) -> Self {
        Self { x, label: None, measurement }
    }

    pub fn named(x: f64, label: impl Into<String>, measurement: Measurement) -> Self {
        Self { x, label: Some(label.into()), measurement }
    }
}

/// Relative error of a quantity of Fresnel's equations over the relative index and an angle, ready to be drawn as a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// `"reflectance"` or `"transmittance"`.
    pub quantity: String,
    pub formula: String,
    /// Index behind over index before the interface, ascending: the columns.
    pub etas: Vec<f64>,
    /// What the rows are: `"cos θi"`, or how far the cosine lies above the critical one.
    pub row_parameter: String,
    /// Ascending. Rows of [`Self::relative_errors`].
    pub rows: Vec<f64>,
    /// `[row][column]`. `None` where reflection is total, which the formula also says, or where there is no such angle. A formula that
    /// is wrong about total reflection has an error of 1 in transmittance.
    pub relative_errors: Vec<Vec<Option<f64>>>,
    /// Places where the formula is wrong about whether reflection is total.
    pub wrong_decisions: usize,
    pub worst: f64,
    /// Largest of the errors where the problem itself is well conditioned: c²/b² below 10, b being η cos θt.
    pub worst_well_conditioned: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stability {
    pub effort: Effort,
    pub cases: Vec<Case>,
    pub sweeps: Vec<Sweep>,
    pub maps: Vec<Map>,
    /// The cases that are measured in images by the other estimators.
    #[serde(default)]
    pub by_estimators: Vec<ByEstimator>,
    /// `None` without a graphics processor.
    #[serde(default)]
    pub graphics: Option<Graphics>,
}

/// Cases whose images are rendered in another way than by paths from the camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ByEstimator {
    pub estimator: Estimator,
    pub cases: Vec<Case>,
}

/// The cases that are measured in images, by the graphics processor, which computes in f32.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Graphics {
    /// Name and interface of the graphics processor.
    pub adapter: String,
    /// Whether it computes on the CPU.
    pub is_software: bool,
    /// What it cannot render is not run.
    pub cases: Vec<Case>,
}

impl Stability {
    /// Cases passed, failed and not run.
    pub fn counts(&self) -> [usize; 3] {
        ["passed", "failed", "not run"].map(|name| self.cases.iter().filter(|c| c.outcome.name() == name).count())
    }
}
