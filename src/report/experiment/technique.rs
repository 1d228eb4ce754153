//! How light is sampled in a measurement.

use serde::{Deserialize, Serialize};

use crate::render::{RenderSettings, VarianceReduction};
use crate::tracking::Mode;
use crate::transport::sampler::Sequence;

/// How light is sampled: what lowers noise and must not change what an image converges to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Technique {
    pub sampler: Sequence,
    /// As in [`VarianceReduction`].
    pub splits: u32,
    pub sample_environment: bool,
    /// Whether samples go where they matter: see [`crate::render::allocation`].
    pub adaptive: bool,
}

impl Technique {
    /// Independent samples, equally many for each pixel: their error falls as 1/samples, which shows whether there is a bias.
    pub fn independent() -> Self {
        let default = VarianceReduction::default();
        Self {
            sampler: Sequence::Independent,
            splits: default.splits,
            sample_environment: default.sample_environment,
            adaptive: false,
        }
    }

    /// What the program does unless told otherwise.
    pub fn shipped() -> Self {
        let default = VarianceReduction::default();
        Self { sampler: default.sequence, adaptive: true, ..Self::independent() }
    }

    /// Settings of an image by this technique. Adaptive sampling is not among them: it is a property of the film.
    pub fn settings(self, mode: Mode, seed: u64, max_depth: Option<u32>) -> RenderSettings {
        RenderSettings { mode, seed, max_depth, leave_out: true, variance: self.variance_reduction() }
    }

    fn variance_reduction(self) -> VarianceReduction {
        VarianceReduction { sequence: self.sampler, splits: self.splits, sample_environment: self.sample_environment }
    }
}
