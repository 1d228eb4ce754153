//! How light is sampled in a measurement.

use serde::{Deserialize, Serialize};

use crate::render::ImageSettings;
use crate::tracking::Mode;
use crate::transport::sampler::Sequence;

/// How light is sampled: what lowers noise and must not change what an image converges to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Technique {
    pub sampler: Sequence,
    /// As in [`ImageSettings`].
    pub splits: u32,
    pub sample_environment: bool,
    /// Whether samples go where they matter: see [`crate::render::allocation`].
    pub adaptive: bool,
}

impl Technique {
    /// Independent samples, equally many for each pixel: their error falls as 1/samples, which shows whether there is a bias.
    pub fn independent() -> Self {
        let ImageSettings { splits, sample_environment, .. } = ImageSettings::new(Mode::Rectified, 0);
        Self { sampler: Sequence::Independent, splits, sample_environment, adaptive: false }
    }

    /// What the program does unless told otherwise.
    pub fn shipped() -> Self {
        Self { sampler: Sequence::Sobol, adaptive: true, ..Self::independent() }
    }

    /// Settings of an image by this technique. Adaptive sampling is not among them: it is a property of the film.
    pub fn settings(self, mode: Mode, seed: u64, max_depth: Option<u32>) -> ImageSettings {
        ImageSettings {
            max_depth,
            splits: self.splits,
            sampler: self.sampler,
            sample_environment: self.sample_environment,
            ..ImageSettings::new(mode, seed)
        }
    }
}
