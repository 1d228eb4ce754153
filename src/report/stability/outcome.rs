//! What comes of a stability check: plain data, ready to be shown, stored and read back.

use serde::{Deserialize, Serialize};

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

/// How an error is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorKind {
    /// |measured − expected|, in the measurement's unit.
    Absolute,
    /// |measured/expected − 1|.
    Relative,
}

/// One number and what it should have been.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// What was measured, and how: a mode, an angle, a height. In a sweep, the name of the curve.
    pub what: String,
    #[serde(with = "null_is_nan")]
    pub expected: f64,
    /// NaN where nothing could be measured, which is a failure.
    #[serde(with = "null_is_nan")]
    pub measured: f64,
    pub kind: ErrorKind,
    /// As `kind` says; NaN where nothing could be measured.
    #[serde(with = "null_is_nan")]
    pub error: f64,
    /// The largest error allowed next to noise, as `kind` says.
    #[serde(with = "null_is_nan")]
    pub bound: f64,
    /// Standard error of a random estimate, as `kind` says; 0 for what is not random. Four of them are allowed next to the bound.
    #[serde(with = "null_is_nan")]
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

    /// The same measurement held against another expected value.
    #[must_use]
    pub fn against(&self, expected: f64) -> Self {
        let fresh = match self.kind {
            ErrorKind::Absolute => Self::absolute(self.what.clone(), self.measured, expected, self.bound),
            ErrorKind::Relative => Self::relative(self.what.clone(), self.measured, expected, self.bound),
        };
        Self { noise: self.noise, unit: self.unit.clone(), limit: self.limit.clone(), ..fresh }
    }

    /// In words, with the reason where one is known.
    fn fault(&self) -> String {
        let Self { what, measured, expected, error, bound, unit, .. } = self;
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let noise = if self.noise > 0.0 { format!(", noise {:.2e}", self.noise) } else { String::new() };
        // Counts of what must not happen need no error.
        let is_exact = self.kind == ErrorKind::Absolute && *bound == 0.0 && self.noise == 0.0;
        let error = if is_exact { String::new() } else { format!(" (error {error:.2e}, bound {bound:.2e}{noise})") };
        let limit = self.limit.as_ref().map_or(String::new(), |limit| format!(": {limit}"));
        format!("{what}: {measured}{unit}, not {expected}{error}{limit}")
    }
}

/// What came of a case or a sweep.
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
        Self::of_all(measurements.into_iter().map(|measurement| (String::new(), measurement)))
    }

    /// Of the steps of a sweep.
    pub fn of_steps(steps: &[Step]) -> Self {
        let place = |step: &Step| match &step.label {
            Some(label) => format!("at {label}, "),
            None => format!("at {:e}, ", step.x),
        };
        Self::of_all(steps.iter().map(|step| (place(step), &step.measurement)))
    }

    /// Each with its place in words.
    fn of_all<'a>(measurements: impl Iterator<Item = (String, &'a Measurement)>) -> Self {
        let (mut count, mut faults) = (0, Vec::new());
        for (place, measurement) in measurements {
            count += 1;
            if !measurement.is_within_bound() {
                faults.push(place + &measurement.fault());
            }
        }
        match (count, faults.as_slice()) {
            (0, _) => Self::Failed { reason: "nothing was measured".to_owned() },
            (_, []) => Self::Passed,
            (_, [only]) => Self::Failed { reason: only.clone() },
            (_, [first, ..]) => {
                Self::Failed { reason: format!("{} of {count} are out of bounds; first, {first}", faults.len()) }
            }
        }
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

/// A stiff or extreme case.
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
    /// Time it took, in seconds.
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

/// One property of a scene, from harmless to extreme.
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
    /// Time it took, in seconds.
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
    /// At a value of the parameter.
    pub fn at(x: f64, measurement: Measurement) -> Self {
        Self { x, label: None, measurement }
    }

    /// At a place with a name.
    pub fn named(x: f64, label: impl Into<String>, measurement: Measurement) -> Self {
        Self { x, label: Some(label.into()), measurement }
    }
}

/// Relative error of a quantity of Fresnel's equations over the relative index and an angle, ready to be drawn as a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// `"reflectance"` or `"transmittance"`.
    pub quantity: String,
    /// How it was computed.
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
    /// Largest of the errors.
    pub worst: f64,
    /// Largest of the errors where the problem itself is well conditioned: c²/b² below 10, b being η cos θt.
    pub worst_well_conditioned: f64,
}

/// Everything.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stability {
    pub effort: Effort,
    pub cases: Vec<Case>,
    pub sweeps: Vec<Sweep>,
    pub maps: Vec<Map>,
}

impl Stability {
    /// Cases passed, failed and not run.
    pub fn counts(&self) -> [usize; 3] {
        ["passed", "failed", "not run"].map(|name| self.cases.iter().filter(|c| c.outcome.name() == name).count())
    }
}

/// JSON has no NaN and no infinities: they are written as null, and null is read as NaN.
mod null_is_nan {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
    pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(*value).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
    }
}
