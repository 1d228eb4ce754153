//! From an edit to the picture: a scene is edited again and again while the window's threads render it, and each time it is taken how
//! long rectification and the first new image of every pane take.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::progress::Progress;
use crate::measure::statistics::median;
use crate::optics::Ior;
use crate::render::{Backend, BackendChoice, EstimatorChoice, ImageSettings};
use crate::scene::{Description, SceneError};
use crate::session::{GroundTruthDemand, Request, Worker};
use crate::spectrum::WAVELENGTH_D_UM;
use crate::tracking::Mode;

/// Time after which a missing image is an error.
const PATIENCE: Duration = Duration::from_secs(60);

/// What is measured, and how long.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EditingPlan {
    /// Pixels of each of the four panes.
    pub size: [u32; 2],
    pub edits: usize,
    /// An edit comes at an irregular moment within so many seconds after the last one was answered.
    pub within_secs: f64,
    /// What renders the panes.
    pub backend: BackendChoice,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Edit {
    /// The IOR of one medium after the other.
    Ior,
    /// The place of one dielectric after the other.
    Transform,
    Camera,
}

impl Edit {
    pub const ALL: [Self; 3] = [Self::Ior, Self::Transform, Self::Camera];

    pub fn about(self) -> &'static str {
        match self {
            Self::Ior => "the IOR of a medium",
            Self::Transform => "the place of a dielectric",
            Self::Camera => "the camera",
        }
    }

    fn is_possible(self, description: &Description) -> bool {
        match self {
            Self::Ior => !description.media.is_empty(),
            Self::Transform => !description.objects.refractors().is_empty(),
            Self::Camera => true,
        }
    }
}

/// One scene. Times are of the threads behind the window: one per core, whatever the report was told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Editing {
    /// Mode of each pane.
    pub panes: Vec<Mode>,
    /// Pixels of each.
    pub size: [u32; 2],
    /// What rendered the first of them.
    pub backend: Backend,
    pub times: Vec<EditTimes>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EditTimes {
    pub edit: Edit,
    pub edits: usize,
    /// Median seconds of rectifying the edited scene, where it has to be.
    pub rectify_secs: Option<f64>,
    /// Seconds until every pane had a new image: median, and of all.
    pub image_secs: f64,
    pub worst_secs: f64,
    /// Width of the coarsest of the first images, in pixels.
    pub width: u32,
}

#[derive(Debug, thiserror::Error)]
pub enum EditingError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("the window's threads cannot be started: {0}")]
    Threads(#[from] std::io::Error),
    #[error("no image came within {} seconds of an edit", PATIENCE.as_secs())]
    NoImage,
}

/// Edits one scene while it is rendered. `None` when cancelled.
///
/// # Errors
/// When the system refuses threads, or no image comes.
pub fn measure(
    description: &Arc<Description>,
    plan: &EditingPlan,
    progress: &Progress<'_>,
) -> Result<Option<Editing>, EditingError> {
    let panes = vec![Mode::Naive, Mode::Stack, Mode::Rectified, Mode::Reference];
    let kinds: Vec<Edit> = Edit::ALL.into_iter().filter(|edit| edit.is_possible(description)).collect();
    let mut request = Request { backend: plan.backend, ..first_request(description, panes.clone(), plan.size) };
    let window = Window::open()?;
    if window.answer(&request, progress)?.is_none() {
        return Ok(None);
    }
    window.wait_for_graphics(plan.backend, progress);
    let mut answers = vec![Vec::new(); kinds.len()];
    // Multiples of the golden ratio: each edit meets the renderer at another moment of its work.
    let mut moment = 0.0_f64;
    for index in 0..plan.edits {
        for (&edit, answers) in kinds.iter().zip(&mut answers) {
            moment += 0.618_033_988_749_895;
            std::thread::sleep(Duration::from_secs_f64(plan.within_secs * moment.fract()));
            request = edited(&request, edit, index);
            let Some(answer) = window.answer(&request, progress)? else { return Ok(None) };
            answers.push(answer);
        }
    }
    let backend = window.backend(panes[0]);
    let times = kinds.into_iter().zip(&answers).filter_map(|(edit, answers)| of_kind(edit, answers)).collect();
    Ok(Some(Editing { panes, size: plan.size, backend, times }))
}

fn first_request(description: &Arc<Description>, modes: Vec<Mode>, size: [u32; 2]) -> Request {
    Request {
        epoch: 1,
        restarts: 0,
        description: Arc::clone(description),
        camera: description.camera,
        modes,
        surfaces: Vec::new(),
        size,
        settings: ImageSettings::new(Mode::Rectified, 0),
        estimator: EstimatorChoice::Path,
        backend: BackendChoice::Cpu,
        backend_choices: 0,
        sample_limit: Some(4096),
        noise_target: None,
        is_paused: false,
        ground_truth: GroundTruthDemand::Off,
    }
}

/// `None` without times.
fn of_kind(edit: Edit, answers: &[Answer]) -> Option<EditTimes> {
    let rectify: Vec<f64> = answers.iter().filter_map(|answer| answer.rectify_secs).collect();
    let image: Vec<f64> = answers.iter().map(|answer| answer.image_secs).collect();
    Some(EditTimes {
        edit,
        edits: answers.len(),
        rectify_secs: median(&rectify),
        worst_secs: image.iter().copied().reduce(f64::max)?,
        image_secs: median(&image)?,
        width: answers.iter().map(|answer| answer.width).min()?,
    })
}

/// Edits go back and forth, so that none leads far away.
fn edited(before: &Request, edit: Edit, index: usize) -> Request {
    let mut request = Request { epoch: before.epoch + 1, ..before.clone() };
    let way = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut description = Description::clone(&before.description);
    match edit {
        Edit::Ior => {
            let medium = index / 2 % description.media.len();
            let medium = &mut description.media[medium];
            medium.ior = Ior::Constant(1.0 + medium.ior.ior_minus_one(WAVELENGTH_D_UM) + 0.01 * way);
            request.description = Arc::new(description);
        }
        Edit::Transform => {
            let refractor = index / 2 % description.objects.refractors().len();
            let step = 0.01 * (before.camera.target - before.camera.position).length();
            description.objects.refractors_mut()[refractor].transform.translate +=
                DVec3::new(0.22, 0.14, 0.26) * (step * way);
            request.description = Arc::new(description);
        }
        Edit::Camera => request.camera.position += (before.camera.target - before.camera.position) * (0.01 * way),
    }
    request
}

#[derive(Debug, Clone, Copy)]
struct Answer {
    /// `None` where nothing was rectified.
    rectify_secs: Option<f64>,
    image_secs: f64,
    width: u32,
}

/// The threads behind a window, and a bell that they ring.
struct Window {
    worker: Worker,
    bell: Arc<(Mutex<()>, Condvar)>,
}

impl Window {
    fn open() -> std::io::Result<Self> {
        let bell = Arc::new((Mutex::new(()), Condvar::new()));
        let rung = Arc::clone(&bell);
        let worker = Worker::start(Arc::new(move |_| {
            drop(rung.0.lock());
            rung.1.notify_all();
        }))?;
        Ok(Self { worker, bell })
    }

    /// What has rendered the image of a mode.
    fn backend(&self, mode: Mode) -> Backend {
        self.worker.board().snapshots().get(&mode).map_or(Backend::Cpu, |film| film.backend)
    }

    /// Waits until it is decided whether the graphics processor renders, and it has begun to.
    fn wait_for_graphics(&self, backend: BackendChoice, progress: &Progress<'_>) {
        let start = Instant::now();
        let board = self.worker.board();
        let is_open = || match board.graphics() {
            None => true,
            Some(status) => status.is_used && !board.snapshots().values().any(|film| film.backend == Backend::Gpu),
        };
        while backend != BackendChoice::Cpu && is_open() && start.elapsed() < PATIENCE && !progress.is_cancelled() {
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Submits and waits until each pane has an image of that epoch; `None` when cancelled.
    fn answer(&self, request: &Request, progress: &Progress<'_>) -> Result<Option<Answer>, EditingError> {
        let (mutex, rung) = &*self.bell;
        let start = Instant::now();
        self.worker.submit(request.clone());
        let board = self.worker.board();
        let mut guard = mutex.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            let snapshots = board.snapshots();
            let width = |mode| snapshots.get(mode).filter(|film| film.epoch == request.epoch).map(|film| film.size[0]);
            let widths: Option<Vec<u32>> = request.modes.iter().map(width).collect();
            if let Some(width) = widths.and_then(|widths| widths.into_iter().min()) {
                let image_secs = start.elapsed().as_secs_f64();
                let scene = board.scene().filter(|scene| scene.epoch == request.epoch);
                let rectify_secs = scene.map(|scene| scene.prepared.seconds.rectify);
                return Ok(Some(Answer { rectify_secs, image_secs, width }));
            }
            if let Some((_, error)) = board.take_failure() {
                return Err(error.into());
            }
            if progress.is_cancelled() {
                return Ok(None);
            }
            if start.elapsed() > PATIENCE {
                return Err(EditingError::NoImage);
            }
            let waited = rung.wait_timeout(guard, Duration::from_millis(50));
            guard = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats;
    use std::sync::atomic::AtomicBool;

    const PLAN: EditingPlan = EditingPlan { size: [32, 18], edits: 2, within_secs: 0.01, backend: BackendChoice::Cpu };

    fn measured(description: Description, cancel: bool) -> Result<Option<Editing>, EditingError> {
        let progress = Progress { cancel: &AtomicBool::new(cancel), tell: &|_, _| () };
        measure(&Arc::new(description), &PLAN, &progress)
    }

    #[test]
    fn every_kind_of_edit_is_answered() {
        let found = measured(formats::open("nested-spheres").unwrap(), false).unwrap().unwrap();
        assert_eq!(found.times.iter().map(|times| times.edit).collect::<Vec<_>>(), Edit::ALL);
        for times in &found.times {
            assert_eq!(times.edits, 2);
            assert!(0.0 < times.image_secs && times.image_secs <= times.worst_secs, "{times:?}");
            assert!((1..=32).contains(&times.width), "{times:?}");
            // The camera alone needs no rectification.
            assert_eq!(times.rectify_secs.is_some(), times.edit != Edit::Camera, "{times:?}");
        }
        assert!(measured(formats::open("plain-glass").unwrap(), true).unwrap().is_none());
    }

    #[test]
    fn what_is_not_there_is_not_edited() {
        let mut description = formats::open("plain-glass").unwrap();
        description.objects.clear(crate::scene::description::Kind::Refractor);
        let found = measured(description, false).unwrap().unwrap();
        assert_eq!(found.times.iter().map(|times| times.edit).collect::<Vec<_>>(), [Edit::Ior, Edit::Camera]);
    }

    #[test]
    fn edits_come_back_to_where_they_began() {
        let description = Arc::new(formats::open("nested-spheres").unwrap());
        for edit in Edit::ALL {
            let before = first_request(&description, Vec::new(), [1, 1]);
            let there = edited(&before, edit, 0);
            let back = edited(&there, edit, 1);
            let place = |request: &Request| {
                let refractor = request.description.objects.refractors()[0].transform.translate;
                let ior = request.description.media[0].ior.ior_minus_one(WAVELENGTH_D_UM);
                (refractor, request.camera.position, ior)
            };
            let (first, far, last) = (place(&before), place(&there), place(&back));
            assert_ne!(far, first, "{edit:?}");
            assert!((last.0 - first.0).length() < 1e-12 && (last.2 - first.2).abs() < 1e-12);
            // The camera's step shrinks with its distance.
            assert!((last.1 - first.1).length() < 2e-3 * (far.1 - first.1).length() + 0.02, "{edit:?}");
        }
    }
}
