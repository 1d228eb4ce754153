//! What `render` and `compare` share: from a scene's name to films, with progress.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::arguments::{ImageArguments, Size};
use super::preparation::prepare_shown;
use super::progress::Progress;
use super::{Failure, pool, tell};
use crate::check::unrendered;
use crate::export::renderer;
use crate::render::choice::{self, Work};
use crate::render::exact::unit_exponent;
use crate::render::{
    Backend, BackendChoice, Chosen, Display, Estimator, Film, ImageSettings, Recipe, RenderTask, SampleRange, choose,
    choose_estimator,
};
use crate::scene::camera::Camera;
use crate::tracking::Mode;
use crate::tracking::{Events, Prepared};

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
    /// Of choosing the backend, and of compiling for the graphics processor.
    pub compile: f64,
    pub render: f64,
}

/// What is said about one rendered image: `render --json`, and each pane of `compare --json`.
#[derive(Debug, Serialize)]
pub struct ImageReport<'a> {
    pub scene: Cow<'a, str>,
    #[serde(flatten)]
    pub settings: ImageSettings,
    /// The graphics processor that took samples, if one did.
    pub adapter: Option<&'a str>,
    /// What came in the way of the graphics processor.
    pub notice: Option<&'a str>,
    pub width: u32,
    pub height: u32,
    pub spp: u32,
    /// Indices of the samples, where they were asked for.
    pub samples: Option<SampleRange>,
    pub adaptive: bool,
    pub threads: usize,
    pub seconds: Seconds,
    pub events: Events,
    /// Share of the crossings that were of faces whose surroundings differ from place to place; `None` for other modes than `rectified`.
    pub mixed_share: Option<f64>,
    pub left_out: Vec<&'static str>,
    /// What is no Unicode in it is replaced.
    pub output: Option<Cow<'a, str>>,
}

/// One image.
pub struct Rendered {
    pub mode: Mode,
    pub film: Film,
    /// Seconds spent on this mode alone.
    pub seconds: f64,
    /// Why the CPU took samples that the graphics processor should have taken.
    pub notice: Option<String>,
}

impl Rendered {
    fn new(mode: Mode, film: Film) -> Self {
        Self { mode, film, seconds: 0.0, notice: None }
    }

    /// Tells, once, that the graphics processor has failed after so many samples per pixel.
    fn notice_of_fault(&mut self, settings: &ImageSettings, samples: u32) {
        let is_as_planned = self.film.backend == Some(settings.backend);
        if is_as_planned || self.notice.is_some() {
            return;
        }
        let why = choice::fault().unwrap_or_else(|| "the graphics processor failed".into());
        let notice = format!("{why} after {samples} samples per pixel of {}; the CPU took the others", self.mode);
        tell(&format!("note: {notice}\n"));
        self.notice = Some(notice);
    }
}

/// When a render ends: at whichever of its limits comes first. It has one at least.
#[derive(Debug, Clone, Copy)]
struct Until {
    samples: Option<u32>,
    seconds: Option<f64>,
}

impl Until {
    fn samples(samples: u32) -> Self {
        Self { samples: Some(samples), seconds: None }
    }

    /// The part that is done, from 0 to 1.
    fn part(self, samples: f64, elapsed: Duration) -> f64 {
        let of_samples = self.samples.map_or(0.0, |limit| samples / f64::from(limit));
        let of_seconds = self.seconds.map_or(0.0, |limit| elapsed.as_secs_f64() / limit);
        of_samples.max(of_seconds).min(1.0)
    }

    /// Samples to take next, 0 at the end: as many as fit into a slice of time, and no more than were asked for.
    fn next_slice(self, done: u32, elapsed: Duration, per_sample: Duration) -> u32 {
        let fitting = |time: Duration| (time.as_secs_f64() / per_sample.as_secs_f64().max(1e-9)) as u32;
        let left = self.samples.unwrap_or(u32::MAX).saturating_sub(done);
        let wanted = match self.seconds {
            // Samples of a pixel that are taken together cost less each.
            None => fitting(SLICE).max(TOGETHER),
            Some(limit) => {
                let time = Duration::from_secs_f64(limit).saturating_sub(elapsed);
                // The last slice may come out a little early rather than a whole sample late.
                fitting(time.min(SLICE)).max(u32::from(time > per_sample / 2))
            }
        };
        wanted.min(left)
    }
}

/// A scene ready to be rendered, and the threads to do it on.
pub struct Job<'a> {
    arguments: &'a ImageArguments,
    pub prepared: Prepared,
    camera: Camera,
    chosen: Chosen,
    pub estimator: Estimator,
    load_secs: f64,
    compile_secs: f64,
    pool: rayon::ThreadPool,
}

impl<'a> Job<'a> {
    /// Reads and prepares the scene, which is to be rendered in these modes with so many samples per pixel, unless time decides.
    pub fn new(arguments: &'a ImageArguments, modes: &[Mode], samples: u32) -> Result<Self, Failure> {
        let start = Instant::now();
        let description = crate::formats::open(&arguments.scene)?;
        let load_secs = start.elapsed().as_secs_f64();
        for problem in unrendered(&description) {
            tell(&format!("note: {}: {}\n", problem.place, problem.message));
        }
        let camera = Camera::new(&description.camera)?;
        let pool = pool(arguments.threads)?;
        let prepared = pool.install(|| prepare_shown(Arc::new(description)))?;
        let estimator = arguments.estimator().map_err(Failure::wrong)?;
        let estimator = pool.install(|| choose_estimator(estimator, &prepared, &camera));
        let settings: Vec<ImageSettings> = modes.iter().map(|&mode| arguments.settings(mode, estimator)).collect();
        for settings in &settings {
            let task = RenderTask { prepared: &prepared, camera: &camera, settings };
            task.require().map_err(|error| Failure::Wrong(error.into()))?;
        }
        let Size { width, height } = arguments.size;
        let work = Work {
            prepared: &prepared,
            camera: &camera,
            settings: &settings,
            size: [width, height],
            samples: if arguments.time.is_none() { Some(samples) } else { None },
        };
        let asked = arguments.backend().map_err(Failure::wrong)?;
        let start = Instant::now();
        let chosen = pool.install(|| choose(asked, &work)).map_err(|error| Failure::Failed(error.into()))?;
        let compile_secs = start.elapsed().as_secs_f64();
        match (&chosen.reason, asked) {
            (Some(reason), BackendChoice::Gpu) => tell(&format!("note: {reason}; the CPU renders it\n")),
            (Some(reason), _) => log::info!("rendering on the CPU: {reason}"),
            (None, _) => {}
        }
        Ok(Self { arguments, prepared, camera, chosen, estimator, load_secs, compile_secs, pool })
    }

    /// How the image of one mode is rendered.
    pub fn settings(&self, mode: Mode) -> ImageSettings {
        self.chosen.settings(self.arguments.settings(mode, self.estimator))
    }

    /// The graphics processor that took samples of any of these images, if one did.
    pub fn adapter(&self, images: &[Rendered]) -> Option<&str> {
        let is_by_gpu = |image: &Rendered| matches!(image.film.backend, Some(Backend::Gpu | Backend::Mixed));
        self.chosen.adapter.as_deref().filter(|_| images.iter().any(is_by_gpu))
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
        let mut images: Vec<Rendered> = modes.iter().map(|&mode| Rendered::new(mode, film())).collect();
        let ImageArguments { spp, time, .. } = self.arguments;
        let samples = if time.is_none() { Some(spp.unwrap_or(DEFAULT_SPP)) } else { *spp };
        self.advance(&mut images, Until { samples, seconds: *time });
        images
    }

    /// Takes some samples of one image, with exact sums.
    pub fn render_part(&self, mode: Mode, samples: SampleRange) -> Rendered {
        let Size { width, height } = self.arguments.size;
        let unit_exponent = unit_exponent(&self.prepared.description);
        let film = Film::partial(width, height, samples.0, unit_exponent);
        let mut images = [Rendered::new(mode, film)];
        self.advance(&mut images, Until::samples(samples.count()));
        let [image] = images;
        image
    }

    /// What decides the samples of an image of [`Self::render_part`].
    pub fn recipe(&self, image: &Rendered) -> Recipe {
        let description = &self.prepared.description;
        Recipe {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: description.name.clone(),
            content: description.fingerprint(),
            camera: self.camera.fingerprint(),
            adapter: self.adapter(std::slice::from_ref(image)).map(str::to_owned),
            width: self.arguments.size.width,
            height: self.arguments.size.height,
            settings: self.settings_of(image),
            unit_exponent: unit_exponent(description),
        }
    }

    fn advance(&self, images: &mut [Rendered], until: Until) {
        let progress = Progress::new(self.arguments.tells_progress);
        let modes = images.len() as f64;
        let never = AtomicBool::new(false);
        let start = Instant::now();
        let mut done = 0;
        let mut slice = 1;
        while slice > 0 {
            if self.arguments.lose_gpu_after.is_some_and(|samples| done >= samples) {
                choice::take_gpu_away();
            }
            let slice_start = Instant::now();
            for (index, image) in images.iter_mut().enumerate() {
                let settings = self.settings(image.mode);
                let mode_start = Instant::now();
                let task = RenderTask { prepared: &self.prepared, camera: &self.camera, settings: &settings };
                self.pool.install(|| task.pass(&mut image.film, slice, &never));
                image.seconds += mode_start.elapsed().as_secs_f64();
                image.notice_of_fault(&settings, done);
                let samples = f64::from(done) + f64::from(slice) * (index + 1) as f64 / modes;
                progress.tell(until.part(samples, start.elapsed()), start.elapsed());
            }
            done += slice;
            Film::allocate(&mut images.iter_mut().map(|image| &mut image.film).collect::<Vec<_>>());
            slice = until.next_slice(done, start.elapsed(), slice_start.elapsed().div_f64(f64::from(slice)));
            slice = slice.min(images.first().map_or(0, |image| image.film.samples_to_decision()));
        }
    }

    /// What has rendered these images, for pictures' texts.
    pub fn renderer(&self, images: &[Rendered]) -> (String, String) {
        let backends: Vec<Backend> = images.iter().map(|image| self.settings_of(image).backend).collect();
        renderer(&backends, self.adapter(images))
    }

    /// How an image was rendered, whatever was planned.
    fn settings_of(&self, image: &Rendered) -> ImageSettings {
        let settings = self.settings(image.mode);
        ImageSettings { backend: image.film.backend.unwrap_or(settings.backend), ..settings }
    }

    fn is_gpu_asked(&self) -> bool {
        self.arguments.backend == BackendChoice::Gpu
    }

    fn is_adaptive(&self) -> bool {
        self.estimator == Estimator::Path && self.arguments.adaptive.is_none_or(|adaptive| adaptive.0)
    }

    /// What there is to say about an image.
    pub fn report<'b>(&'b self, image: &'b Rendered, output: Option<&'b Path>) -> ImageReport<'b> {
        let is_part = image.film.exact.is_some();
        ImageReport {
            scene: self.arguments.scene.to_string_lossy(),
            settings: self.settings_of(image),
            adapter: self.adapter(std::slice::from_ref(image)),
            notice: image.notice.as_deref().or(self.chosen.reason.as_deref().filter(|_| self.is_gpu_asked())),
            width: image.film.width,
            height: image.film.height,
            spp: image.film.samples,
            samples: is_part.then(|| SampleRange(image.film.first, image.film.first + image.film.samples)),
            adaptive: self.is_adaptive() && !is_part,
            threads: self.pool.current_num_threads(),
            seconds: Seconds {
                load: self.load_secs,
                bvh: self.prepared.seconds.bvh,
                rectify: self.prepared.seconds.rectify,
                compile: self.compile_secs,
                render: image.seconds,
            },
            events: image.film.events,
            mixed_share: image.film.events.mixed_share().filter(|_| image.mode == Mode::Rectified),
            left_out: if self.arguments.leave_out.0 { self.prepared.scene.needs.left_out() } else { Vec::new() },
            output: output.map(Path::to_string_lossy),
        }
    }
}

/// Where a picture goes: as asked for, else into the current folder under the scene's name, else, with `--json`, nowhere.
pub fn output_path(asked: Option<&PathBuf>, is_json: bool, scene: &Path, ending: &str) -> Option<PathBuf> {
    match asked {
        Some(path) => Some(path.clone()),
        None if is_json => None,
        None => {
            let stem = scene.file_stem().map_or("scene".into(), |stem| stem.to_string_lossy());
            Some(PathBuf::from(format!("{stem}-{ending}")))
        }
    }
}

/// Millions of samples a second, for people.
pub fn mega_samples_per_second(film: &Film, seconds: f64) -> f64 {
    let samples = f64::from(film.width) * f64::from(film.height) * f64::from(film.samples);
    samples / seconds.max(1e-9) / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUICK: Duration = Duration::from_millis(1);

    #[test]
    fn a_render_ends_at_whichever_limit_comes_first() {
        let secs = Duration::from_secs;
        let both = Until { samples: Some(64), seconds: Some(20.0) };
        assert_eq!(both.next_slice(64, secs(1), QUICK), 0);
        assert_eq!(both.next_slice(60, secs(1), QUICK), 4);
        assert_eq!(both.next_slice(8, secs(20), QUICK), 0);
        assert_eq!(both.next_slice(8, secs(19), secs(3)), 0, "no sample that comes out much too late");
        assert_eq!(both.next_slice(8, secs(19), QUICK), 56);
        assert_eq!(Until::samples(200).next_slice(8, secs(1000), QUICK), 150);
        assert_eq!(Until { samples: None, seconds: Some(1e7) }.next_slice(u32::MAX - 2, secs(0), QUICK), 2);
        assert_eq!(both.part(32.0, secs(5)), 0.5);
        assert_eq!(both.part(1.0, secs(15)), 0.75);
        assert_eq!(both.part(1.0, secs(150)), 1.0);
    }
}
