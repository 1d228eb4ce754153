//! The threads behind the window: one that prepares scenes, and lanes that render them.
//!
//! A request describes everything that decides the images and carries an epoch. The latest request wins: a pass for an older
//! epoch is cancelled, except the first coarse one, which is short and so always reaches the screen; a steady stream of edits (a
//! slider that is dragged) therefore shows a steady stream of images. A long preparation is cancelled by a request for another scene.
//!
//! ```text
//! requests ─► preparer (scene, rectification) ─► main lane:      every mode but `reference`, in lockstep
//!                                              ├► reference lane: `reference`, beside other modes on a few threads of its own
//!                                              ├► surfaces lane:  surfaces in the colours of what rectification found
//!                                              ├► ground truth:   `reference` twice, to measure the others against
//!                                              └► graphics lane:  looks for a graphics processor and compiles for it, meanwhile the CPU renders
//! ```
//!
//! Modes of one lane have equally many samples, taken with the same random numbers: their difference shows the modes' error and not
//! noise. One that comes later catches up first. Films that are not shown any more are kept for a while. `reference` is far slower than the others; beside them it has a lane of its own and holds nobody back.

mod backend;
mod board;
mod estimators;
mod film_cache;
pub mod first_modes;
mod ground_truth;
mod job;
mod lane;
mod mailbox;
mod painter;
mod preparation;
mod preparer;
mod preview;
pub mod priority;
mod speed;
#[cfg(test)]
mod tests;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Instant;

pub use self::backend::GraphicsStatus;
use self::backend::{Graphics, run_graphics};
pub use self::board::{Board, News, PaintedSurfaces, SceneReport, Snapshot, Wake};
use self::film_cache::{FilmCache, MOST_BYTES};
use self::ground_truth::run_ground_truth;
pub use self::ground_truth::{GroundTruth, GroundTruthDemand, Halves, MOST_SAMPLES as MOST_GROUND_TRUTH_SAMPLES};
use self::job::Asked;
use self::lane::{Pools, run_lane};
use self::mailbox::Mailbox;
use self::painter::run_painter;
pub use self::preparation::Preparation;
use self::preparer::{Lanes, prepare_scenes};
use crate::render::surfaces::SurfaceQuantity;
use crate::render::{BackendChoice, EstimatorChoice, ImageSettings};
use crate::scene::description::CameraDescription;
use crate::scene::{Description, SceneError};
use crate::tracking::Mode;

/// What to render.
#[derive(Debug, Clone)]
pub struct Request {
    /// Changes with the description, the camera, the size, the settings and the number of restarts. Films of a new epoch begin anew, but for
    /// those that show what an earlier one showed: they go on.
    pub epoch: u64,
    /// Films go on only within one number of restarts.
    pub restarts: u64,
    /// Prepared anew when it is another allocation than the last request's.
    pub description: Arc<Description>,
    /// The view, which need not be the scene's own camera.
    pub camera: CameraDescription,
    /// Distinct modes; each gets a film.
    pub modes: Vec<Mode>,
    /// Distinct quantities; surfaces are painted by each.
    pub surfaces: Vec<SurfaceQuantity>,
    /// Width and height of the films in pixels, at least 1.
    pub size: [u32; 2],
    /// Of every film; `mode` is each of `modes` in turn.
    pub settings: ImageSettings,
    /// How light is transported: it decides the estimator in `settings`.
    pub estimator: EstimatorChoice,
    /// What renders; until a graphics processor is found and ready, the CPU.
    pub backend: BackendChoice,
    /// How often that was chosen: who chooses again wants a graphics processor that has failed to be tried again.
    pub backend_choices: u64,
    /// Samples per pixel at which to stop; `None`: go on for ever.
    pub sample_limit: Option<u32>,
    /// Noise, as in [`Snapshot::noise`], at which to stop before that.
    pub noise_target: Option<f64>,
    /// Everything stops: films after their first sample at full resolution, the rest at once.
    pub is_paused: bool,
    /// It outlives the epoch where only `modes` change.
    pub ground_truth: GroundTruthDemand,
}

/// The handle to the threads. Dropping it cancels and joins them.
pub struct Worker {
    requests: Arc<Mailbox<Asked>>,
    lanes: Lanes,
    board: Arc<Board>,
    threads: Vec<JoinHandle<()>>,
}

impl Worker {
    /// Starts the threads.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn start(wake: Wake) -> std::io::Result<Self> {
        let board = Arc::new(Board::default());
        let requests = Arc::new(Mailbox::new());
        let lanes: Lanes = [(); 5].map(|()| Arc::new(Mailbox::new()));
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let mut threads = Vec::new();
        // The window's own thread is idle most of the time. Where there are cores to spare it has one for itself; on small machines
        // rendering takes all of them, which made no frame later when measured on two cores.
        let widths = [if cores >= 4 { cores - 1 } else { cores }, (cores / 4).max(1), (cores / 2).max(1)];
        let pool_of = |name: &'static str, width: usize| {
            let named = rayon::ThreadPoolBuilder::new().thread_name(move |index| format!("{name}-{index}"));
            let polite = named.start_handler(|_| priority::yield_to_the_window());
            polite.num_threads(width).build().map(Arc::new).map_err(std::io::Error::other)
        };
        let alone = pool_of("render", widths[0])?;
        let cache = Arc::new(Mutex::new(FilmCache::new(MOST_BYTES)));
        let graphics = Arc::new(Graphics::default());
        let waiting = pool_of("graphics", 1)?;
        for (lane, name, beside) in
            [(0, "render", Arc::clone(&alone)), (1, "reference", pool_of("reference", widths[1])?)]
        {
            let pools = Pools { alone: Arc::clone(&alone), beside, graphics: Arc::clone(&waiting) };
            let (mailbox, board, wake) = (Arc::clone(&lanes[lane]), Arc::clone(&board), Arc::clone(&wake));
            let (cache, graphics) = (Arc::clone(&cache), Arc::clone(&graphics));
            threads.push(
                std::thread::Builder::new()
                    .name(format!("{name}-lane"))
                    .spawn(move || run_lane(&pools, &mailbox, &board, &wake, &cache, &graphics))?,
            );
        }
        let painter = {
            let pool = pool_of("surfaces", widths[2])?;
            let (mailbox, board, wake) = (Arc::clone(&lanes[2]), Arc::clone(&board), Arc::clone(&wake));
            move || run_painter(&pool, &mailbox, &board, &wake)
        };
        threads.push(std::thread::Builder::new().name("surfaces-lane".into()).spawn(painter)?);
        let chooser = {
            let (mailbox, board, wake) = (Arc::clone(&lanes[4]), Arc::clone(&board), Arc::clone(&wake));
            move || run_graphics(&mailbox, &board, &wake, &graphics)
        };
        threads.push(std::thread::Builder::new().name("graphics-lane".into()).spawn(chooser)?);
        let pools = Pools { beside: pool_of("truth", widths[1])?, alone, graphics: waiting };
        let ground_truth = {
            let (mailbox, board, wake) = (Arc::clone(&lanes[3]), Arc::clone(&board), Arc::clone(&wake));
            move || run_ground_truth(&pools, &mailbox, &board, &wake)
        };
        threads.push(std::thread::Builder::new().name("ground-truth-lane".into()).spawn(ground_truth)?);
        let preparer = {
            let (requests, lanes, board) = (Arc::clone(&requests), lanes.clone(), Arc::clone(&board));
            move || prepare_scenes(&requests, &lanes, &board, &wake)
        };
        threads.push(std::thread::Builder::new().name("prepare".into()).spawn(preparer)?);
        Ok(Self { requests, lanes, board, threads })
    }

    /// Asks for images. Returns at once; an older request that has not been looked at is dropped.
    pub fn submit(&self, request: Request) {
        self.requests.post(Asked { request, at: Instant::now() });
    }

    /// Where results appear.
    pub fn board(&self) -> &Arc<Board> {
        &self.board
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.requests.close();
        self.lanes.iter().for_each(|lane| lane.close());
        for thread in self.threads.drain(..) {
            // A thread that panicked has said so already.
            let _ = thread.join();
        }
    }
}

/// Runs `work`; a panic, which would be a bug, becomes an error message instead of a window that never shows anything again.
fn guarded<T>(work: impl FnOnce() -> Result<T, SceneError>) -> Result<T, SceneError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = (panic.downcast_ref::<String>().map(String::as_str))
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("no message");
        Err(SceneError::new(format!("an internal error, please report it: {text}")))
    })
}
