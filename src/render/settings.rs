//! What decides the samples of an image, next to the scene, the camera and the size: said here once for every place that sets, compares or
//! keeps it.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::tracking::Mode;
use crate::transport::sampler::Sequence;

named! {
    /// What computes.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Backend {
        #[default]
        Cpu = "cpu",
        Gpu = "gpu",
        /// Some samples each: what the GPU was lost over, and parts of both that were put together. The CPU takes what is missing.
        Mixed = "mixed",
    }
}

impl Backend {
    /// What has taken the samples of two images that are put together.
    pub fn and(self, other: Self) -> Self {
        if self == other { self } else { Self::Mixed }
    }
}

named! {
    /// How light is transported.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Estimator {
        /// Paths from the camera.
        #[default]
        Path = "path",
        /// Paths from the camera and from lights, joined.
        Bidirectional = "bidirectional",
        /// These, and light that has come to places nearby.
        Merging = "merging",
    }
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// How one image is rendered. Two images of one scene, camera and size that have equal settings have equal samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImageSettings {
    pub mode: Mode,
    #[serde(default)]
    pub backend: Backend,
    pub estimator: Estimator,
    pub seed: u64,
    /// Cap on the segments of a path, the camera's first being one; `None`: no cap.
    pub max_depth: Option<u32>,
    /// Whether work that the scene does not need is left out. Off only to measure what that saves.
    pub leave_out: bool,
    /// How many interfaces from the camera on paths may split at, into one that is reflected and one that goes through; 0: none.
    pub splits: u32,
    pub sampler: Sequence,
    /// Whether image environments are sampled where they are bright. Off only to measure what that brings.
    pub sample_environment: bool,
}

impl ImageSettings {
    /// As the program renders unless told otherwise.
    pub fn new(mode: Mode, seed: u64) -> Self {
        Self {
            mode,
            backend: Backend::default(),
            estimator: Estimator::default(),
            seed,
            max_depth: None,
            leave_out: true,
            // More splits bring less than they cost.
            splits: 2,
            sampler: Sequence::Sobol,
            sample_environment: true,
        }
    }

    /// How messages name the backend.
    pub const BACKEND: &'static str = "the backend";

    /// Each setting, as messages name it, with its value: what the fingerprint of an image takes up, and what parts of an image must agree in.
    pub fn named(&self) -> [(&'static str, String); 9] {
        let on_or_off = |value: bool| if value { "on" } else { "off" }.to_owned();
        // Taken apart so that no field can be forgotten.
        let Self { mode, backend, estimator, seed, max_depth, leave_out, splits, sampler, sample_environment } = *self;
        [
            ("the mode", mode.to_string()),
            (Self::BACKEND, backend.name().to_owned()),
            ("the estimator", estimator.name().to_owned()),
            ("the seed", seed.to_string()),
            ("--max-depth", max_depth.map_or("none".into(), |depth| depth.to_string())),
            ("--leave-out", on_or_off(leave_out)),
            ("--splits", splits.to_string()),
            ("--sampler", sampler.name().to_owned()),
            ("--sample-environment", on_or_off(sample_environment)),
        ]
    }
}
