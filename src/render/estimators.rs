//! Which estimator renders an image: as it was asked for, or by what the scene shows.

use std::sync::atomic::AtomicBool;

use super::film::Film;
use super::renderer::{RenderTask, Renderer};
use super::settings::{Estimator, ImageSettings};
use crate::scene::camera::Camera;
use crate::tracking::{Mode, Prepared};
use crate::transport::caustics::CausticNoise;

named! {
    /// What is asked for.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum EstimatorChoice {
        /// Merging where caustics of small lights would be too noisy for paths from the camera, else those.
        #[default]
        Auto = "auto",
        Path = "path",
        Bidirectional = "bidirectional",
        Merging = "merging",
    }
}

/// Width and height of the image by which the choice is made.
const SIDE: u32 = 32;
/// Its samples of each pixel.
const SAMPLES: u32 = 4;
/// Subpaths from lights by which it is made.
const LIGHT_PATHS: u32 = 4096;
/// Relative variance that caustics may bring to a sample before they are merged. A sample of iced water has some 2 of all other kinds.
const MOST_VARIANCE: f64 = 4.0;
/// Share of the light that may be missed.
const MOST_MISSED: f64 = 0.002;

/// The estimator for a scene as its camera sees it, in any mode. Takes a hundredth of a second or two if it is to be found, on rayon's current pool.
pub fn choose_estimator(asked: EstimatorChoice, prepared: &Prepared, camera: &Camera) -> Estimator {
    match asked {
        EstimatorChoice::Path => Estimator::Path,
        EstimatorChoice::Bidirectional => Estimator::Bidirectional,
        EstimatorChoice::Merging => Estimator::Merging,
        EstimatorChoice::Auto => {
            let CausticNoise { variance, missed } = caustic_noise(prepared, camera);
            log::info!("caustics: relative variance of a sample {variance:.3}, missed {missed:.5} of the light");
            if variance > MOST_VARIANCE || missed > MOST_MISSED { Estimator::Merging } else { Estimator::Path }
        }
    }
}

/// What caustics would bring to an image that is rendered by paths from the camera; see [`crate::transport::caustics`].
pub fn caustic_noise(prepared: &Prepared, camera: &Camera) -> CausticNoise {
    if prepared.scene.emitters.is_empty() && !prepared.scene.needs.image_environment {
        return CausticNoise::default();
    }
    let settings = ImageSettings { splits: 0, ..ImageSettings::new(Mode::Rectified, 0) };
    let task = RenderTask { prepared, camera, settings: &settings };
    let mut film = Film::new(SIDE, SIDE);
    super::cpu::Cpu.pass(&task, &mut film, SAMPLES, &AtomicBool::new(false));
    let radiance: Vec<f64> = (0..film.sums.len()).map(|pixel| film.mean(pixel).element_sum() / 3.0).collect();
    let settings = ImageSettings { estimator: Estimator::Merging, ..settings };
    let task = RenderTask { settings: &settings, ..task };
    super::cpu::caustic_noise(&task, [SIDE; 2], LIGHT_PATHS, &radiance)
}
