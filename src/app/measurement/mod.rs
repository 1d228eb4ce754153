//! Error against time, while it happens: films are kept as they grow and measured against a ground truth that is made beside them.
//! [`measurer`] works on a thread of its own; [`curve`] says what the figures mean.

pub mod csv;
pub mod curve;
mod given;
pub mod measurer;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use self::curve::{Curve, Point, Trend};
pub use self::given::{Given, GivenImage};
pub use self::measurer::Measurements;
use crate::session::{GroundTruth, GroundTruthDemand};

/// The figures by which an error can be told. All are ≥ 0 but for chance, and 0 for equal images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum ErrorMetric {
    #[default]
    RelMse,
    RelMseTrimmed,
    Mse,
    Smape,
    Flip,
}

impl ErrorMetric {
    pub const ALL: [Self; 5] = [Self::RelMse, Self::RelMseTrimmed, Self::Mse, Self::Smape, Self::Flip];

    pub fn name(self) -> &'static str {
        match self {
            Self::RelMse => "relMSE",
            Self::RelMseTrimmed => "relMSE, trimmed",
            Self::Mse => "MSE",
            Self::Smape => "sMAPE",
            Self::Flip => "FLIP",
        }
    }

    /// One sentence for tooltips.
    pub fn about(self) -> &'static str {
        match self {
            Self::RelMse => "Mean of squared error over squared reference + 0.01. Falls as 1/time without bias.",
            Self::RelMseTrimmed => {
                "relMSE without the worst 0.1 % of pixels, so that a few fireflies do not decide it. Falls as 1/time without bias."
            }
            Self::Mse => "Mean squared error of linear radiance. Falls as 1/time without bias.",
            Self::Smape => {
                "Symmetric mean absolute percentage error. Falls as 1/√time without bias; holds the reference's noise."
            }
            Self::Flip => {
                "What an eye sees when it flips between image and reference at the display's exposure. Holds the reference's noise."
            }
        }
    }

    /// Whether it is of the order of the error's square, as a variance is.
    pub fn is_squared(self) -> bool {
        matches!(self, Self::RelMse | Self::RelMseTrimmed | Self::Mse)
    }
}

/// What errors are plotted against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ErrorAxis {
    #[default]
    Time,
    Samples,
}

/// What is measured, as the panels show it.
#[derive(Debug, Default)]
pub struct Measurement {
    pub demand: GroundTruthDemand,
    /// The image that is measured against instead.
    pub given: Given,
    pub truth: Option<GroundTruth>,
    pub results: Arc<Measurements>,
    /// Whether a ground truth was lost because the picture changed, and the next one has only just begun.
    pub has_begun_anew: bool,
}

/// Samples from which on nobody need be told any more that a ground truth has begun anew.
const WELL_UNDER_WAY: u32 = 32;

impl Measurement {
    pub fn is_on(&self) -> bool {
        self.is_rendered() || self.given.0.is_some()
    }

    /// Whether the reference image is one that is rendered.
    pub fn is_rendered(&self) -> bool {
        self.demand != GroundTruthDemand::Off
    }

    /// Takes in how far the ground truth is.
    pub fn set_truth(&mut self, truth: Option<GroundTruth>) {
        let samples = |truth: &Option<GroundTruth>| truth.as_ref().map_or(0, |truth| truth.samples);
        let (before, now) = (samples(&self.truth), samples(&truth));
        if !self.is_rendered() || now >= WELL_UNDER_WAY {
            self.has_begun_anew = false;
        } else if now < before {
            self.has_begun_anew = true;
        }
        self.truth = truth.filter(|_| self.is_rendered());
    }
}
