//! What `render` and `compare` share: from a scene's name to films, with progress.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::Failure;
use super::arguments::{ImageArguments, Size};
use super::preparation::prepare_shown;
use crate::estimator::sampler::Sequence;
use crate::render::exact::unit_exponent;
use crate::render::{
    Display, Events, Film, Prepared, Recipe, RenderSettings, SampleRange, VarianceReduction, accumulate,
};
use crate::scene;
use crate::scene::camera::Camera;
use crate::tracking::Mode;

/// Samples per pixel where neither `--spp` nor `--time` is given.
pub const DEFAULT_SPP: u32 = 64;
/// At least so many samples are taken in one slice, where time does not decide.
const TOGETHER: u32 = 16;
/// One slice of work takes about this long, so that progress moves and `--time` is kept.
const SLICE: Duration = Duration::from_millis(150);

/// Seconds spent on each part, as in JSON.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Seconds {
    pub load: f64,
    pub bvh: f64,
    pub rectify: f64,
    pub render: f64,
}

/// What is said about one rendered image: `render --json`, and each pane of `compare --json`.
#[derive(Debug, Serialize)]
pub struct ImageReport<'a> {
    pub scene: &'a str,
    pub mode: Mode,
    pub backend: &'static str,
    pub estimator: &'static str,
    pub width: u32,
    pub height: u32,
    pub spp: u32,
    /// Indices of the samples, where they were asked for.
    pub samples: Option<SampleRange>,
    pub seed: u64,
    pub max_depth: Option<u32>,
    pub adaptive: bool,
    pub splits: u32,
    pub sampler: Sequence,
    pub sample_environment: bool,
    pub threads: usize,
    pub seconds: Seconds,
    pub events: Events,
    /// Share of the crossings that were of faces whose surroundings differ from place to place; `None` for other modes than `rectified`.
    pub mixed_share: Option<f64>,
    pub left_out: Vec<&'static str>,
    pub output: Option<&'a Path>,
}

/// One image.
pub struct Rendered {
    pub mode: Mode,
    pub film: Film,
    /// Seconds spent on this mode alone.
    pub seconds: f64,
}

/// When a render ends.
#[derive(Clone, Copy)]
enum Until {
    Samples(u32),
    Seconds(f64),
}

/// A scene ready to be rendered, and the threads to do it on.
pub struct Job<'a> {
    arguments: &'a ImageArguments,
    pub prepared: Prepared,
    camera: Camera,
    load_secs: f64,
    pool: rayon::ThreadPool,
}

impl<'a> Job<'a> {
    /// Reads and prepares the scene.
    pub fn new(arguments: &'a ImageArguments) -> Result<Self, Failure> {
        let start = Instant::now();
        let description = scene::load::open(&arguments.scene)?;
        let load_secs = start.elapsed().as_secs_f64();
        let camera = Camera::new(&description.camera)?;
        // 0 lets rayon take one thread per core.
        let threads = arguments.threads.unwrap_or(0) as usize;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| Failure::Failed(anyhow::Error::new(error).context("the threads cannot be started")))?;
        let prepared = pool.install(|| prepare_shown(Arc::new(description)))?;
        Ok(Self { arguments, prepared, camera, load_secs, pool })
    }

    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Does `work` on no more threads than were asked for.
    pub fn on_threads<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.pool.install(work)
    }

    pub fn display(&self) -> Display {
        Display { exposure: self.arguments.exposure, curve: self.arguments.curve }
    }

    /// Renders all `modes` in lockstep, a slice of samples at a time.
    pub fn render(&self, modes: &[Mode]) -> Vec<Rendered> {
        let Size { width, height } = self.arguments.size;
        let film = || if self.is_adaptive() { Film::adaptive(width, height) } else { Film::new(width, height) };
        let mut images: Vec<Rendered> =
            modes.iter().map(|&mode| Rendered { mode, film: film(), seconds: 0.0 }).collect();
        let spp = || Until::Samples(self.arguments.spp.unwrap_or(DEFAULT_SPP));
        self.advance(&mut images, self.arguments.time.map_or_else(spp, Until::Seconds));
        images
    }

    /// Takes some samples of one image, with exact sums.
    pub fn render_part(&self, mode: Mode, samples: SampleRange) -> Rendered {
        let Size { width, height } = self.arguments.size;
        let unit_exponent = unit_exponent(&self.prepared.description);
        let film = Film::partial(width, height, samples.0, unit_exponent);
        let mut images = [Rendered { mode, film, seconds: 0.0 }];
        self.advance(&mut images, Until::Samples(samples.count()));
        let [image] = images;
        image
    }

    /// What decides the samples of [`Self::render_part`].
    pub fn recipe(&self, mode: Mode) -> Recipe {
        let RenderSettings { mode, seed, max_depth, leave_out, variance } = self.settings(mode);
        let VarianceReduction { sequence, splits, sample_environment } = variance;
        let description = &self.prepared.description;
        Recipe {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: description.name.clone(),
            content: description.fingerprint(),
            camera: self.camera.fingerprint(),
            width: self.arguments.size.width,
            height: self.arguments.size.height,
            mode,
            estimator: self.arguments.estimator.to_owned(),
            seed,
            max_depth,
            leave_out,
            splits,
            sampler: sequence,
            sample_environment,
            unit_exponent: unit_exponent(description),
        }
    }

    fn advance(&self, images: &mut [Rendered], until: Until) {
        let bar = Self::progress_bar(until, images.len());
        let never = AtomicBool::new(false);
        let start = Instant::now();
        let mut done = 0;
        let mut slice = 1;
        while slice > 0 {
            let slice_start = Instant::now();
            for image in &mut *images {
                let settings = self.settings(image.mode);
                let mode_start = Instant::now();
                self.pool.install(|| {
                    accumulate(&self.prepared, &self.camera, &settings, &mut image.film, slice, &never);
                });
                image.seconds += mode_start.elapsed().as_secs_f64();
                if matches!(until, Until::Samples(_)) {
                    bar.inc(u64::from(slice));
                }
            }
            done += slice;
            Film::allocate(&mut images.iter_mut().map(|image| &mut image.film).collect::<Vec<_>>());
            if matches!(until, Until::Seconds(_)) {
                bar.set_position(start.elapsed().as_millis() as u64);
            }
            slice = next_slice(until, done, start.elapsed(), slice_start.elapsed().div_f64(f64::from(slice)));
            slice = slice.min(images.first().map_or(0, |image| image.film.samples_to_decision()));
        }
        bar.finish_and_clear();
    }

    fn settings(&self, mode: Mode) -> RenderSettings {
        RenderSettings {
            mode,
            seed: self.arguments.seed,
            max_depth: self.arguments.max_depth.0,
            variance: self.variance(),
            leave_out: self.arguments.leave_out.0,
        }
    }

    fn is_adaptive(&self) -> bool {
        self.arguments.adaptive.is_none_or(|adaptive| adaptive.0)
    }

    fn variance(&self) -> VarianceReduction {
        VarianceReduction {
            sequence: self.arguments.sampler,
            splits: self.arguments.splits,
            sample_environment: self.arguments.sample_environment.0,
        }
    }

    fn progress_bar(until: Until, modes: usize) -> ProgressBar {
        let (length, template) = match until {
            Until::Seconds(limit) => ((limit * 1e3) as u64, "{bar:40.cyan/dim} {percent:>3} % · {elapsed}"),
            Until::Samples(spp) => {
                (u64::from(spp) * modes as u64, "{bar:40.cyan/dim} {percent:>3} % · {elapsed}, {eta} left")
            }
        };
        // Draws on standard error, and only if that is a terminal.
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::new(length).with_style(style.progress_chars("━━─"))
    }

    /// What there is to say about an image.
    pub fn report<'b>(&'b self, image: &Rendered, output: Option<&'b Path>) -> ImageReport<'b> {
        let is_part = image.film.exact.is_some();
        ImageReport {
            scene: &self.arguments.scene,
            mode: image.mode,
            backend: self.arguments.backend,
            estimator: self.arguments.estimator,
            width: image.film.width,
            height: image.film.height,
            spp: image.film.samples,
            samples: is_part.then(|| SampleRange(image.film.first, image.film.first + image.film.samples)),
            seed: self.arguments.seed,
            max_depth: self.arguments.max_depth.0,
            adaptive: self.is_adaptive() && !is_part,
            splits: self.arguments.splits,
            sampler: self.arguments.sampler,
            sample_environment: self.arguments.sample_environment.0,
            threads: self.threads(),
            seconds: Seconds {
                load: self.load_secs,
                bvh: self.prepared.seconds.bvh,
                rectify: self.prepared.seconds.rectify,
                render: image.seconds,
            },
            events: image.film.events,
            mixed_share: image.film.events.mixed_share().filter(|_| image.mode == Mode::Rectified),
            left_out: if self.arguments.leave_out.0 { self.prepared.world.needs.left_out() } else { Vec::new() },
            output,
        }
    }
}

/// Samples to take next, 0 at the end: as many as fit into a slice of time, and no more than were asked for.
fn next_slice(until: Until, done: u32, elapsed: Duration, per_sample: Duration) -> u32 {
    let fitting = |time: Duration| (time.as_secs_f64() / per_sample.as_secs_f64().max(1e-9)) as u32;
    match until {
        Until::Samples(spp) => {
            // Samples of a pixel that are taken together cost less each.
            fitting(SLICE).max(TOGETHER).min(spp.saturating_sub(done))
        }
        Until::Seconds(limit) => {
            let left = Duration::from_secs_f64(limit).saturating_sub(elapsed);
            let room = u32::MAX - done;
            // The last slice may come out a little early rather than a whole sample late.
            fitting(left.min(SLICE)).max(u32::from(left > per_sample / 2)).min(room)
        }
    }
}

/// Where a picture goes: as asked for, else into the current folder under the scene's name, else, with `--json`, nowhere.
pub fn output_path(asked: Option<&PathBuf>, is_json: bool, scene: &str, ending: &str) -> Option<PathBuf> {
    match asked {
        Some(path) => Some(path.clone()),
        None if is_json => None,
        None => {
            let stem = Path::new(scene).file_stem().map_or("scene".into(), |stem| stem.to_string_lossy());
            Some(PathBuf::from(format!("{stem}-{ending}")))
        }
    }
}

/// Millions of samples a second, for people.
pub fn mega_samples_per_second(film: &Film, seconds: f64) -> f64 {
    let samples = f64::from(film.width) * f64::from(film.height) * f64::from(film.samples);
    samples / seconds.max(1e-9) / 1e6
}
