//! The threads behind the window: one that prepares scenes, and lanes that render them.
//!
//! A request describes everything that decides the images and carries an epoch. The latest request wins: a pass for an older
//! epoch is cancelled, except the first coarse one, which is short and so always reaches the screen; a steady stream of edits (a
//! slider that is dragged) therefore shows a steady stream of images.
//!
//! ```text
//! requests ─► preparer (scene, rectification) ─► main lane:      every mode, in lockstep
//!                                              ├► reference lane: `reference` beside other modes, on a few threads of its own
//!                                              ├► surfaces lane:  surfaces in the colours of what rectification found
//!                                              └► ground truth:   `reference` twice, to measure the others against
//! ```
//!
//! Modes of one lane always have equally many samples, taken with the same random numbers: their difference shows the modes' error
//! and not noise. `reference` is far slower than the others; beside them it has a lane of its own and holds nobody back.

mod ground_truth;
mod lane;
mod mailbox;
mod painter;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

pub use self::ground_truth::{GroundTruth, GroundTruthDemand, Halves, MOST_SAMPLES as MOST_GROUND_TRUTH_SAMPLES};
use self::ground_truth::{Pools, run_ground_truth};
use self::lane::{Job, LaneMessage, run_lane};
use self::mailbox::{Mailbox, Taken};
use self::painter::run_painter;
use super::events::Events;
use super::prepare::{Prepared, prepare};
use super::surfaces::{OFFSETS, Painting, SurfaceQuantity};
use crate::check::{Problem, check};
use crate::scene::camera::Camera;
use crate::scene::description::CameraDescription;
use crate::scene::{Description, SceneError};
use crate::tracking::Mode;

/// What to render.
#[derive(Debug, Clone)]
pub struct Request {
    /// Different whenever anything else than `surfaces`, `sample_limit`, `is_paused` and `ground_truth` is: a new epoch starts from
    /// nothing.
    pub epoch: u64,
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
    pub seed: u64,
    /// As in [`super::RenderSettings`].
    pub max_depth: Option<u32>,
    /// Samples per pixel at which to stop; `None`: go on for ever.
    pub sample_limit: Option<u32>,
    /// Stops after the first sample at full resolution.
    pub is_paused: bool,
    /// It outlives the epoch where only `modes` change.
    pub ground_truth: GroundTruthDemand,
}

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
    pub events: Events,
    /// Time spent rendering this film, in seconds.
    pub seconds: f64,
    /// Whether the sample limit has been reached.
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
    /// Whether this is a quick picture at a lower resolution.
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

/// What the threads publish and the window reads.
#[derive(Debug, Default)]
pub struct Board {
    state: Mutex<BoardState>,
}

#[derive(Debug, Default)]
struct BoardState {
    scene: Option<Arc<SceneReport>>,
    failure: Option<(u64, SceneError)>,
    snapshots: BTreeMap<Mode, Arc<Snapshot>>,
    paintings: BTreeMap<SurfaceQuantity, Arc<PaintedSurfaces>>,
    ground_truth: Option<GroundTruth>,
}

impl Board {
    fn lock(&self) -> MutexGuard<'_, BoardState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The scene that is being rendered.
    pub fn scene(&self) -> Option<Arc<SceneReport>> {
        self.lock().scene.clone()
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

    /// The ground truth and how far it is; `None` where none is wanted.
    pub fn ground_truth(&self) -> Option<GroundTruth> {
        self.lock().ground_truth.clone()
    }
}

/// What has been published.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum News {
    /// A scene, its problems, a failure, or that the ground truth has come on.
    Scene,
    /// Images, of the ground truth too.
    Images,
}

/// Called from the threads after each publication; must be quick.
pub type Wake = Arc<dyn Fn(News) + Send + Sync>;

/// A request, and when it came.
struct Asked {
    request: Request,
    at: Instant,
}

/// What the lanes are told: main, reference, surfaces, ground truth.
type Lanes = [Arc<Mailbox<LaneMessage>>; 4];

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
        let lanes: Lanes = [(); 4].map(|()| Arc::new(Mailbox::new()));
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let mut threads = Vec::new();
        // The window's own thread is idle most of the time. Where there are cores to spare it has one for itself; on small machines
        // rendering takes all of them, which made no frame later when measured on two cores.
        let widths = [if cores >= 4 { cores - 1 } else { cores }, (cores / 4).max(1), (cores / 2).max(1)];
        let pool_of = |name: &'static str, width: usize| {
            let named = rayon::ThreadPoolBuilder::new().thread_name(move |index| format!("{name}-{index}"));
            named.num_threads(width).build().map_err(std::io::Error::other)
        };
        for ((mailbox, width), name) in lanes.iter().zip(widths).zip(["render", "reference", "surfaces"]) {
            let pool = pool_of(name, width)?;
            let (mailbox, board, wake) = (Arc::clone(mailbox), Arc::clone(&board), Arc::clone(&wake));
            threads.push(std::thread::Builder::new().name(format!("{name}-lane")).spawn(move || match name {
                "surfaces" => run_painter(&pool, &mailbox, &board, &wake),
                _ => run_lane(&pool, &mailbox, &board, &wake),
            })?);
        }
        let pools = Pools { beside: pool_of("truth-beside", widths[1])?, alone: pool_of("truth-alone", widths[0])? };
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

/// Requests of a drag follow each other faster than this: what can wait is done when there is none for so long.
const QUIET: Duration = Duration::from_millis(80);
/// Pre-traces of a scene beyond the first, done while nothing else is wanted.
const REPEATS: u32 = 8;

/// What can be done about a scene while nobody asks for anything else: look for problems, then shoot more rays.
struct Leisure {
    epoch: u64,
    is_checked: bool,
    repeats: u32,
}

impl Leisure {
    fn is_over(&self) -> bool {
        self.is_checked && self.repeats >= REPEATS
    }

    /// One piece of work. Returns the scene as it is known now, and its problems if they have been looked for.
    fn work(&mut self, prepared: &Prepared) -> (Prepared, Option<Vec<Problem>>) {
        if !self.is_checked {
            self.is_checked = true;
            return (prepared.clone(), Some(guarded(|| Ok(check(prepared))).unwrap_or_default()));
        }
        self.repeats += 1;
        // Fresh directions: their votes are added, and what one ray in a million has missed may be seen now. Nobody has asked for this:
        // where it fails, the scene stays as it is known.
        let Ok(table) = guarded(|| Ok(prepared.table.repeated(&prepared.world))) else {
            return (prepared.clone(), None);
        };
        // Other answers may have other problems.
        self.is_checked = table.says_the_same(&prepared.table);
        (Prepared { table: Arc::new(table), ..prepared.clone() }, None)
    }
}

fn prepare_scenes(requests: &Mailbox<Asked>, lanes: &Lanes, board: &Board, wake: &Wake) {
    let mut current: Option<Prepared> = None;
    let mut leisure: Option<Leisure> = None;
    loop {
        let is_free = leisure.as_ref().is_some_and(|leisure| !leisure.is_over());
        let taken = if is_free { requests.wait_for(QUIET) } else { requests.wait().into() };
        let Asked { request, at: asked_at } = match taken {
            Taken::Message(asked) => asked,
            Taken::Closed => return,
            Taken::Empty => {
                if let (Some(leisure), Some(prepared)) = (&mut leisure, &mut current) {
                    let (known, problems) = leisure.work(prepared);
                    *prepared = known.clone();
                    let mut state = board.lock();
                    let problems = problems.or_else(|| state.scene.as_ref().and_then(|scene| scene.problems.clone()));
                    state.scene = Some(Arc::new(SceneReport { epoch: leisure.epoch, prepared: known, problems }));
                    drop(state);
                    wake(News::Scene);
                }
                continue;
            }
        };
        let is_new = current.as_ref().is_none_or(|p| !Arc::ptr_eq(&p.description, &request.description));
        let outcome = guarded(|| {
            let camera = Camera::new(&request.camera)?;
            if is_new {
                // All cores for the preparation: what is being rendered is out of date.
                lanes.iter().for_each(|lane| lane.post(LaneMessage::Hold));
                let prepared = prepare(Arc::clone(&request.description), current.as_ref())?;
                Ok((camera, prepared))
            } else {
                current.clone().map(|prepared| (camera, prepared)).ok_or_else(|| SceneError::new("no scene"))
            }
        });
        let (camera, prepared) = match outcome {
            Ok(ready) => ready,
            Err(error) => {
                board.lock().failure = Some((request.epoch, error));
                wake(News::Scene);
                continue;
            }
        };
        if is_new {
            let report = SceneReport { epoch: request.epoch, prepared: prepared.clone(), problems: None };
            board.lock().scene = Some(Arc::new(report));
            wake(News::Scene);
        }
        let alone = request.modes.iter().all(|mode| *mode == Mode::Reference);
        let (reference, main): (Vec<Mode>, Vec<Mode>) =
            request.modes.iter().partition(|mode| **mode == Mode::Reference && !alone);
        let measures = request.ground_truth != GroundTruthDemand::Off;
        let has_work = [!main.is_empty(), !reference.is_empty(), !request.surfaces.is_empty(), measures];
        for ((lane, modes), has_work) in lanes.iter().zip([main, reference, Vec::new(), Vec::new()]).zip(has_work) {
            lane.post(if !has_work {
                LaneMessage::Hold
            } else {
                LaneMessage::Render(Box::new(Job {
                    prepared: prepared.clone(),
                    camera,
                    modes,
                    request: request.clone(),
                    asked_at,
                }))
            });
        }
        {
            let mut state = board.lock();
            state.snapshots.retain(|mode, _| request.modes.contains(mode));
            state.paintings.retain(|quantity, _| request.surfaces.contains(quantity));
        }
        if is_new {
            leisure = Some(Leisure { epoch: request.epoch, is_checked: false, repeats: 0 });
            current = Some(prepared);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(epoch: u64, modes: &[Mode]) -> Request {
        let description = Arc::new(crate::scene::load::open("nested-spheres").expect("a built-in scene"));
        Request {
            epoch,
            camera: description.camera,
            description,
            modes: modes.to_vec(),
            surfaces: Vec::new(),
            size: [96, 64],
            seed: 0,
            max_depth: Some(8),
            sample_limit: Some(3),
            is_paused: false,
            ground_truth: GroundTruthDemand::Off,
        }
    }

    fn until(worker: &Worker, is_met: impl Fn(&BTreeMap<Mode, Arc<Snapshot>>) -> bool) {
        let start = Instant::now();
        while !is_met(&worker.board().snapshots()) {
            assert!(start.elapsed() < Duration::from_secs(60), "waited too long");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn quiet() -> Wake {
        Arc::new(|_| {})
    }

    #[test]
    fn modes_advance_in_lockstep_to_the_limit() {
        let modes = [Mode::Naive, Mode::Stack, Mode::Rectified];
        let worker = Worker::start(quiet()).unwrap();
        worker.submit(request(1, &modes));
        until(&worker, |snapshots| {
            let samples: Vec<_> = snapshots.values().map(|s| (s.size, s.samples)).collect();
            assert!(samples.windows(2).all(|pair| pair[0] == pair[1]), "out of step: {samples:?}");
            snapshots.len() == 3 && snapshots.values().all(|s| s.is_done)
        });
        let snapshots = worker.board().snapshots();
        assert!(snapshots.values().all(|s| s.samples == 3 && s.size == [96, 64] && !s.is_preview()));
        // From outside a proper nest the stack knows everything: the same random numbers give the same image.
        assert_eq!(snapshots[&Mode::Stack].rgb, snapshots[&Mode::Rectified].rgb);
        assert_ne!(snapshots[&Mode::Naive].rgb, snapshots[&Mode::Rectified].rgb);
    }

    #[test]
    fn a_higher_limit_goes_on_and_a_new_epoch_starts_anew() {
        let worker = Worker::start(quiet()).unwrap();
        let first = request(1, &[Mode::Rectified]);
        worker.submit(first.clone());
        until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.is_done));
        let three = Arc::clone(&worker.board().snapshots()[&Mode::Rectified]);
        worker.submit(Request { sample_limit: Some(5), ..first.clone() });
        until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.samples == 5));
        let five = Arc::clone(&worker.board().snapshots()[&Mode::Rectified]);
        assert!(five.seconds > three.seconds && five.epoch == 1, "the same film went on");

        // Many requests at once: the last one is what remains.
        for epoch in 2..30 {
            worker.submit(Request { epoch, ..first.clone() });
        }
        until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.epoch == 29 && s.is_done));
        assert_eq!(
            worker.board().snapshots()[&Mode::Rectified].rgb,
            three.rgb,
            "an image depends on its request alone"
        );
    }

    #[test]
    fn a_pause_stops_after_one_sample() {
        let worker = Worker::start(quiet()).unwrap();
        let paused = Request { is_paused: true, sample_limit: None, ..request(1, &[Mode::Rectified]) };
        worker.submit(paused.clone());
        until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| !s.is_preview()));
        std::thread::sleep(Duration::from_millis(100));
        assert_eq!(worker.board().snapshots()[&Mode::Rectified].samples, 1);
        worker.submit(Request { is_paused: false, ..paused });
        until(&worker, |s| s[&Mode::Rectified].samples > 10);
    }

    #[test]
    fn reference_beside_others_has_a_lane_of_its_own() {
        let worker = Worker::start(quiet()).unwrap();
        worker.submit(Request { sample_limit: Some(2), ..request(1, &[Mode::Rectified, Mode::Reference]) });
        until(&worker, |s| s.len() == 2 && s.values().all(|s| s.is_done));
        worker.submit(Request { sample_limit: Some(2), ..request(2, &[Mode::Reference]) });
        until(&worker, |s| s.len() == 1 && s.values().all(|s| s.epoch == 2 && s.is_done));
    }

    /// Every image that is shown, the coarse ones of a drag too, is the one of its size.
    #[test]
    fn previews_are_images_of_their_size() {
        type Shown = Mutex<Vec<(u64, Arc<Snapshot>)>>;
        let seen: Arc<Shown> = Arc::default();
        let board: Arc<Mutex<Option<Arc<Board>>>> = Arc::default();
        let worker = {
            let (seen, board) = (Arc::clone(&seen), Arc::clone(&board));
            Worker::start(Arc::new(move |_| {
                let Some(board) = board.lock().unwrap().clone() else { return };
                let shown = board.snapshots().into_values().map(|snapshot| (snapshot.epoch, snapshot));
                seen.lock().unwrap().extend(shown);
            }))
            .unwrap()
        };
        *board.lock().unwrap() = Some(Arc::clone(worker.board()));
        let modes = [Mode::Stack, Mode::Rectified, Mode::Reference];
        let first = Request { size: [480, 320], sample_limit: Some(1), ..request(1, &modes) };
        let asked = |epoch: u64| {
            let mut asked = Request { epoch, ..first.clone() };
            asked.camera.position.x += 0.05 * epoch as f64;
            asked
        };
        for epoch in 1..6 {
            worker.submit(asked(epoch));
            std::thread::sleep(Duration::from_millis(30));
        }
        until(&worker, |s| s.len() == 3 && s.values().all(|s| s.epoch == 5 && s.is_done));
        let mut seen = seen.lock().unwrap().clone();
        seen.dedup_by(|a, b| Arc::ptr_eq(&a.1, &b.1));
        // (How many of them are previews is a matter of the machine's speed.)
        assert!(seen.len() >= 3);
        let prepared = prepare(Arc::clone(&first.description), None).unwrap();
        for (epoch, snapshot) in seen {
            let camera = Camera::new(&asked(epoch).camera).unwrap();
            let settings = crate::render::RenderSettings {
                mode: snapshot.mode,
                seed: first.seed,
                max_depth: first.max_depth,
                variance: crate::render::VarianceReduction::default(),
                leave_out: true,
            };
            let mut film = crate::render::Film::new(snapshot.size[0], snapshot.size[1]);
            let never = std::sync::atomic::AtomicBool::new(false);
            crate::render::accumulate(&prepared, &camera, &settings, &mut film, snapshot.samples, &never);
            assert_eq!(film.to_rgb(), snapshot.rgb, "{} at {:?}", snapshot.mode, snapshot.size);
        }
    }

    #[test]
    fn what_can_wait_is_done_when_nothing_else_is_wanted() {
        let worker = Worker::start(quiet()).unwrap();
        let asked = request(1, &[Mode::Rectified]);
        worker.submit(asked.clone());
        until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.is_done));
        let rays = || worker.board().scene().map_or(0, |scene| scene.prepared.table.rays());
        let first = rays();
        assert!(first > 0);
        // Every pre-trace shoots as many rays here: nobody doubts this nest.
        until(&worker, |_| rays() == first * (1 + u64::from(REPEATS)));
        let scene = worker.board().scene().unwrap();
        assert!(scene.problems.is_some() && scene.epoch == 1);
        // An edit of optics counts on.
        let mut description = Description::clone(&asked.description);
        description.world.ior = crate::optics::IorModel::Constant(1.2);
        worker.submit(Request { epoch: 2, description: Arc::new(description), ..asked });
        until(&worker, |_| rays() > first * (1 + u64::from(REPEATS)));
    }

    #[test]
    fn surfaces_are_painted_beside_the_films_and_without_any() {
        let paintings = |worker: &Worker| worker.board().paintings();
        let worker = Worker::start(quiet()).unwrap();
        let both = vec![SurfaceQuantity::Outside, SurfaceQuantity::Class];
        let films_too = Request { surfaces: both.clone(), ..request(1, &[Mode::Rectified]) };
        worker.submit(films_too.clone());
        until(&worker, |s| s.len() == 1 && s.values().all(|s| s.is_done));
        until(&worker, |_| paintings(&worker).len() == 2 && paintings(&worker).values().all(|p| p.is_done()));
        let first = Arc::clone(&paintings(&worker)[&SurfaceQuantity::Class]);
        assert_eq!([first.painting.width, first.painting.height], [96, 64]);
        // Less of the same epoch keeps what there is; another epoch paints anew.
        worker.submit(Request { surfaces: both[1..].to_vec(), modes: Vec::new(), ..films_too.clone() });
        until(&worker, |_| paintings(&worker).len() == 1);
        assert!(Arc::ptr_eq(&paintings(&worker)[&SurfaceQuantity::Class], &first));
        worker.submit(Request { surfaces: both.clone(), modes: Vec::new(), ..films_too });
        until(&worker, |_| paintings(&worker).len() == 2 && paintings(&worker).values().all(|p| p.is_done()));
        worker.submit(Request { surfaces: both, ..request(2, &[]) });
        until(&worker, |_| {
            paintings(&worker).len() == 2 && paintings(&worker).values().all(|p| p.is_done() && p.epoch == 2)
        });
    }

    #[test]
    fn a_ground_truth_is_kept_while_the_picture_is_the_same() {
        let worker = Worker::start(quiet()).unwrap();
        let truth_when = |is_met: &dyn Fn(Option<&GroundTruth>) -> bool| {
            let start = Instant::now();
            loop {
                let truth = worker.board().ground_truth();
                if is_met(truth.as_ref()) {
                    return truth;
                }
                assert!(start.elapsed() < Duration::from_secs(60), "waited too long");
                std::thread::sleep(Duration::from_millis(2));
            }
        };
        let first = Request { ground_truth: GroundTruthDemand::On, ..request(1, &[Mode::Rectified]) };
        worker.submit(first.clone());
        let truth =
            truth_when(&|truth| truth.is_some_and(|truth| truth.halves.as_ref().is_some_and(|h| h.samples >= 4)));
        let halves = truth.and_then(|truth| truth.halves).unwrap();
        assert_eq!((halves.size, halves.mean.len()), ([96, 64], 96 * 64));
        assert_ne!(halves.rgb[0], halves.rgb[1], "the halves have noise of their own");
        let film = Arc::clone(&worker.board().snapshots()[&Mode::Rectified]);
        assert!(halves.rgb.iter().all(|half| *half != film.rgb));

        // Another mode is another epoch of the same picture. Paused, it stays as it is.
        let paused =
            Request { epoch: 2, modes: vec![Mode::Stack], ground_truth: GroundTruthDemand::Paused, ..first.clone() };
        worker.submit(paused);
        let kept = truth_when(&|truth| truth.is_some_and(|truth| truth.epoch == 2)).unwrap();
        assert!(kept.samples >= halves.samples);
        // Another view is another picture.
        let mut moved = Request { epoch: 3, ..first.clone() };
        moved.camera.position.x += 0.1;
        worker.submit(moved);
        let anew = truth_when(&|truth| truth.is_some_and(|truth| truth.epoch == 3)).unwrap();
        assert!(anew.samples < kept.samples, "it begins anew: {} of {}", anew.samples, kept.samples);
        worker.submit(Request { epoch: 4, ..request(4, &[Mode::Rectified]) });
        truth_when(&|truth| truth.is_none());
    }

    #[test]
    fn an_impossible_request_is_told_and_the_old_scene_stays() {
        let worker = Worker::start(quiet()).unwrap();
        let good = request(1, &[Mode::Rectified]);
        worker.submit(good.clone());
        until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.is_done));
        let mut bad = Request { epoch: 2, ..good.clone() };
        bad.camera.target = bad.camera.position;
        worker.submit(bad);
        let start = Instant::now();
        let (epoch, error) = loop {
            if let Some(failure) = worker.board().take_failure() {
                break failure;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "waited too long");
            std::thread::sleep(Duration::from_millis(2));
        };
        assert_eq!(epoch, 2);
        assert!(error.message.contains("direction"), "{error}");
        assert!(worker.board().scene().is_some());
        worker.submit(Request { epoch: 3, ..good });
        until(&worker, |s| s.get(&Mode::Rectified).is_some_and(|s| s.epoch == 3 && s.is_done));
    }
}
