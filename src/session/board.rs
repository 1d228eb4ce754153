//! What the threads publish and the window reads.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{GraphicsStatus, GroundTruth, Preparation};
use crate::check::Problem;
use crate::render::surfaces::{OFFSETS, Painting, SurfaceQuantity};
use crate::render::{Backend, Estimator};
use crate::scene::SceneError;
use crate::tracking::Mode;
use crate::tracking::{Events, Prepared};

/// The state of one mode's film.
#[derive(Debug, Clone)]
pub struct Snapshot {
    pub epoch: u64,
    pub mode: Mode,
    /// Size of `rgb`, smaller than `full_size` in a preview.
    pub size: [u32; 2],
    /// The size that was asked for.
    pub full_size: [u32; 2],
    /// Mean radiance, linear RGB, row 0 at the top.
    pub rgb: Vec<[f32; 3]>,
    /// Samples per pixel.
    pub samples: u32,
    /// The mean over all pixels of their error relative to their brightness, estimated; `None` before two samples.
    pub noise: Option<f64>,
    /// Variance of the luminance of each pixel, roughly; `None` before two samples.
    pub variances: Option<Vec<f32>>,
    pub events: Events,
    /// What has taken the samples.
    pub backend: Backend,
    pub estimator: Estimator,
    /// Time spent rendering this film, in seconds.
    pub seconds: f64,
    /// Whether the limit of samples or of noise has been reached.
    pub is_done: bool,
}

impl Snapshot {
    /// Whether this is a quick picture at a lower resolution.
    pub fn is_preview(&self) -> bool {
        self.size != self.full_size
    }

    /// Pixel samples per second.
    pub fn samples_per_second(&self) -> f64 {
        let samples = f64::from(self.size[0]) * f64::from(self.size[1]) * f64::from(self.samples);
        samples / self.seconds.max(1e-9)
    }
}

#[cfg(test)]
impl Snapshot {
    /// One sample of every pixel.
    pub fn of(mode: Mode, size: [u32; 2], rgb: Vec<[f32; 3]>) -> Arc<Self> {
        let events = Events::default();
        Arc::new(Self {
            epoch: 1,
            mode,
            size,
            full_size: size,
            rgb,
            samples: 1,
            noise: None,
            variances: None,
            events,
            backend: Backend::Cpu,
            estimator: Estimator::Path,
            seconds: 1.0,
            is_done: false,
        })
    }
}

/// A picture of the surfaces by one quantity.
#[derive(Debug, Clone)]
pub struct PaintedSurfaces {
    pub epoch: u64,
    pub quantity: SurfaceQuantity,
    /// The size that was asked for; the painting is smaller in a preview.
    pub full_size: [u32; 2],
    pub painting: Painting,
}

impl PaintedSurfaces {
    pub fn is_preview(&self) -> bool {
        [self.painting.width, self.painting.height] != self.full_size
    }

    /// Whether every ray has been taken.
    pub fn is_done(&self) -> bool {
        !self.is_preview() && self.painting.rays as usize >= OFFSETS.len()
    }
}

/// A scene that could be prepared.
#[derive(Debug, Clone)]
pub struct SceneReport {
    /// Epoch of the request that brought it.
    pub epoch: u64,
    pub prepared: Prepared,
    /// What is doubtful in it, worst first; `None` until it has been looked for.
    pub problems: Option<Vec<Problem>>,
}

#[derive(Debug, Default)]
pub struct Board {
    state: Mutex<BoardState>,
}

#[derive(Debug, Default)]
pub(super) struct BoardState {
    pub(super) scene: Option<Arc<SceneReport>>,
    pub(super) failure: Option<(u64, SceneError)>,
    pub(super) preparation: Option<Arc<Preparation>>,
    pub(super) snapshots: BTreeMap<Mode, Arc<Snapshot>>,
    pub(super) paintings: BTreeMap<SurfaceQuantity, Arc<PaintedSurfaces>>,
    pub(super) ground_truth: Option<GroundTruth>,
    pub(super) graphics: Option<Arc<GraphicsStatus>>,
}

impl Board {
    pub(super) fn lock(&self) -> MutexGuard<'_, BoardState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says that the request of `epoch` could not be served.
    pub(super) fn fail(&self, epoch: u64, error: SceneError, wake: &Wake) {
        self.lock().failure = Some((epoch, error));
        wake(News::Scene);
    }

    /// The scene that is being rendered.
    pub fn scene(&self) -> Option<Arc<SceneReport>> {
        self.lock().scene.clone()
    }

    /// The scene that is being prepared.
    pub fn preparation(&self) -> Option<Arc<Preparation>> {
        self.lock().preparation.clone()
    }

    /// The last request that could not be served, with its epoch; told once. The previous scene stays.
    pub fn take_failure(&self) -> Option<(u64, SceneError)> {
        self.lock().failure.take()
    }

    /// The latest image of each mode. Modes of one lane come from the same pass.
    pub fn snapshots(&self) -> BTreeMap<Mode, Arc<Snapshot>> {
        self.lock().snapshots.clone()
    }

    /// The latest picture of the surfaces by each quantity.
    pub fn paintings(&self) -> BTreeMap<SurfaceQuantity, Arc<PaintedSurfaces>> {
        self.lock().paintings.clone()
    }

    /// What is known of the graphics processor; `None` until it has been looked for.
    pub fn graphics(&self) -> Option<Arc<GraphicsStatus>> {
        self.lock().graphics.clone()
    }

    /// The ground truth and how far it is; `None` where none is wanted.
    pub fn ground_truth(&self) -> Option<GroundTruth> {
        self.lock().ground_truth.clone()
    }
}

/// What has been published.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum News {
    /// A new scene, a preparation, problems, a failure, or samples of the ground truth.
    Scene,
    /// Images, of the ground truth too.
    Images,
}

/// Called from the threads after each publication; must be quick.
pub type Wake = Arc<dyn Fn(News) + Send + Sync>;
