//! From an edit to the first new image of every pane, as the window's worker does it: milliseconds, for every built-in scene.
//!
//! ```text
//! cargo bench --bench first_image                       every scene
//! cargo bench --bench first_image -- SCENE… [--edits N] some, with so many edits of each kind (default 12)
//! ```
//!
//! Panes share a picture of 1280×720: one of that size (`rectified`), two of half the width (`stack` beside it, or surfaces painted by what
//! lies outside), four of half each way (`naive`, `stack`, `rectified`, `reference`). Edits come while the worker is at work, at irregular moments after the last one was answered. Under `cargo
//! test`, it tries itself on one small case.

use std::io::Write;
use std::process::ExitCode;
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use glam::DVec3;
use iorect::optics::IorModel;
use iorect::optics::dispersion::WAVELENGTH_D_UM;
use iorect::render::surfaces::SurfaceQuantity;
use iorect::render::worker::{GroundTruthDemand, Request, Worker};
use iorect::scene::{Description, builtin};
use iorect::tracking::Mode;

/// How panes divide the picture.
struct Panes {
    modes: &'static [Mode],
    surfaces: &'static [SurfaceQuantity],
    /// Of each pane.
    size: [u32; 2],
}

const PANES: [Panes; 4] = [
    Panes { modes: &[Mode::Rectified], surfaces: &[], size: [1280, 720] },
    Panes { modes: &[Mode::Stack, Mode::Rectified], surfaces: &[], size: [640, 720] },
    Panes { modes: &[Mode::Rectified], surfaces: &[SurfaceQuantity::Outside], size: [640, 720] },
    Panes { modes: &[Mode::Naive, Mode::Stack, Mode::Rectified, Mode::Reference], surfaces: &[], size: [640, 360] },
];

impl Panes {
    fn name(&self) -> String {
        match self.surfaces.len() {
            0 => self.modes.len().to_string(),
            painted => format!("{}+{painted}", self.modes.len()),
        }
    }
}

const EDITS: [Edit; 3] = [Edit::Ior, Edit::Transform, Edit::Camera];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Edit {
    Ior,
    /// Of one object after the other.
    Transform,
    Camera,
}

/// Longer than any answer takes.
const PATIENCE: Duration = Duration::from_secs(60);

fn main() -> ExitCode {
    // Cargo's own word for "measure": without it, this is a test.
    let is_bench = std::env::args().any(|word| word == "--bench");
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    let mut edits = 12;
    let mut scenes = Vec::new();
    while let Some(word) = words.next() {
        if word == "--edits" {
            match words.next().map(|count| count.parse()) {
                Some(Ok(count)) if count > 0 => edits = count,
                _ => return ExitCode::from(2),
            }
        } else if is_bench {
            scenes.push(word);
        }
    }
    let names: Vec<&str> = match &scenes[..] {
        [] => builtin::all().iter().map(|scene| scene.name).collect(),
        some => some.iter().map(String::as_str).collect(),
    };
    let is_done = if is_bench {
        measure(&names, edits, &PANES)
    } else {
        measure(&["plain-glass"], 1, &PANES.map(|panes| Panes { size: [64, 48], ..panes }))
    };
    if is_done.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Prints a table: for each scene and division, the median and the worst of each kind of edit, and the first image's width.
fn measure(names: &[&str], edits: usize, divisions: &[Panes]) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "milliseconds from an edit to the first new image of every pane: median, worst (width of the image)\n"
    )?;
    writeln!(out, "{:16} {:>5}  {:>20}  {:>20}  {:>20}", "scene", "panes", "IOR", "transform", "camera")?;
    let mut worst_of_all: f64 = 0.0;
    for name in names {
        let description = iorect::scene::load::open(name).map_err(std::io::Error::other)?;
        for panes in divisions {
            write!(out, "{name:16} {:>5}", panes.name())?;
            for answers in run(&description, panes, edits)? {
                let mut millis: Vec<f64> = answers.iter().map(|answer| answer.seconds * 1e3).collect();
                millis.sort_by(f64::total_cmp);
                let (median, worst) = (millis[millis.len() / 2], millis[millis.len() - 1]);
                let width = answers.iter().map(|answer| answer.width).min().unwrap_or(0);
                write!(out, "  {:>20}", format!("{median:.0}, {worst:.0} ({width})"))?;
                worst_of_all = worst_of_all.max(worst);
            }
            writeln!(out)?;
        }
    }
    writeln!(out, "\nworst of all {worst_of_all:.0} ms")
}

/// How an edit was answered.
struct Answer {
    seconds: f64,
    /// Of the coarsest of the first images, in pixels.
    width: u32,
}

/// The answers to each kind of edit, in the order of [`EDITS`].
fn run(description: &Description, panes: &Panes, edits: usize) -> std::io::Result<[Vec<Answer>; 3]> {
    let news = Arc::new((Mutex::new(0_u64), Condvar::new()));
    let bell = Arc::clone(&news);
    let worker = Worker::start(Arc::new(move |_| {
        *bell.0.lock().expect("no holder panics") += 1;
        bell.1.notify_all();
    }))?;
    let mut request = Request {
        epoch: 1,
        description: Arc::new(description.clone()),
        camera: description.camera,
        modes: panes.modes.to_vec(),
        surfaces: panes.surfaces.to_vec(),
        size: panes.size,
        seed: 0,
        max_depth: None,
        sample_limit: Some(4096),
        is_paused: false,
        ground_truth: GroundTruthDemand::Off,
    };
    answer(&worker, &news, &request);
    let mut moments = 0.0_f64;
    let mut answers = [const { Vec::new() }; 3];
    for index in 0..edits {
        for (edit, answers) in EDITS.into_iter().zip(&mut answers) {
            // In the middle of something: a preview, a pass at full resolution, work in the background.
            moments += 0.618_033_988_749_895;
            std::thread::sleep(Duration::from_secs_f64(0.02 + 0.7 * moments.fract()));
            request = edited(&request, edit, index);
            answers.push(answer(&worker, &news, &request));
        }
    }
    Ok(answers)
}

fn edited(before: &Request, edit: Edit, index: usize) -> Request {
    let mut request = Request { epoch: before.epoch + 1, ..before.clone() };
    // There and back again: no edit leads far away.
    let way = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    match edit {
        Edit::Ior => {
            let mut description = Description::clone(&before.description);
            let medium = index / 2 % description.media.len();
            let medium = &mut description.media[medium];
            medium.ior = IorModel::Constant(1.0 + medium.ior.ior_minus_one(WAVELENGTH_D_UM) + 0.01 * way);
            request.description = Arc::new(description);
        }
        Edit::Transform => {
            let mut description = Description::clone(&before.description);
            let object = index / 2 % description.refractors.len();
            description.refractors[object].transform.translate += DVec3::new(0.011, 0.007, 0.013) * way;
            request.description = Arc::new(description);
        }
        Edit::Camera => request.camera.position += (before.camera.target - before.camera.position) * (0.01 * way),
    }
    request
}

/// Submits and waits until each pane has an image of that epoch.
fn answer(worker: &Worker, (count, changed): &(Mutex<u64>, Condvar), request: &Request) -> Answer {
    let start = Instant::now();
    worker.submit(request.clone());
    let mut seen = count.lock().expect("no holder panics");
    loop {
        let (snapshots, paintings) = (worker.board().snapshots(), worker.board().paintings());
        let film = |mode| snapshots.get(mode).filter(|film| film.epoch == request.epoch).map(|film| film.size[0]);
        let painted = |quantity| {
            paintings
                .get(quantity)
                .filter(|painted| painted.epoch == request.epoch)
                .map(|painted| painted.painting.width)
        };
        let widths: Option<Vec<u32>> =
            request.modes.iter().map(film).chain(request.surfaces.iter().map(painted)).collect();
        if let Some(widths) = widths {
            return Answer { seconds: start.elapsed().as_secs_f64(), width: widths.into_iter().min().unwrap_or(0) };
        }
        assert!(start.elapsed() < PATIENCE, "waited too long for an image: {:?}", worker.board().take_failure());
        seen = changed.wait_timeout(seen, Duration::from_millis(50)).expect("no holder panics").0;
    }
}
