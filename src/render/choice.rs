//! Which backend renders an image: as it was asked for, or the faster one.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use super::backends::{GPU_MODES, backend_of, renderer};
use super::film::Film;
use super::renderer::{RenderTask, Renderer};
use super::settings::{Backend, ImageSettings};
use crate::scene::camera::Camera;
use crate::tracking::Prepared;

named! {
    /// What is asked for.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum BackendChoice {
        /// The graphics processor where it is real hardware, can render the scene and is the faster of the two; else the CPU.
        #[default]
        Auto = "auto",
        Cpu = "cpu",
        Gpu = "gpu",
    }
}

/// What is to be rendered.
#[derive(Debug, Clone, Copy)]
pub struct Work<'a> {
    pub prepared: &'a Prepared,
    pub camera: &'a Camera,
    /// Of each image. Their backends do not matter.
    pub settings: &'a [ImageSettings],
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel of each image; `None`: as many as come.
    pub samples: Option<u32>,
}

/// What renders.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chosen {
    /// [`Backend::Cpu`] or [`Backend::Gpu`], but for images that are always rendered by the CPU.
    pub backend: Backend,
    /// Name and interface of the graphics processor that is used.
    pub adapter: Option<String>,
    /// Why the graphics processor is not used, if it might have been.
    pub reason: Option<String>,
}

impl Chosen {
    pub fn cpu(reason: Option<String>) -> Self {
        Self { backend: Backend::Cpu, adapter: None, reason }
    }

    /// These settings with the backend of their mode. The graphics processor does not split paths, and images beside its images, which are
    /// compared with them, must not either.
    pub fn settings(&self, settings: ImageSettings) -> ImageSettings {
        let splits = if self.backend == Backend::Gpu { 0 } else { settings.splits };
        ImageSettings { backend: backend_of(settings.mode, self.backend), splits, ..settings }
    }
}

/// There is no graphics processor to render with, and one was asked for: why, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NoGpu(pub String);

/// Work that the CPU does in this time is not worth the looking for a graphics processor.
const SHORT: Duration = Duration::from_secs(1);
/// So few samples, of all images together, are done in that time on any CPU.
const FEW: f64 = 20_000.0;
/// Time for measuring one image on one backend, in seconds.
const MEASURING: f64 = 0.04;
/// Pixels of the image that the CPU is measured with; the graphics processor is measured with the whole.
const CPU_PIXELS: f64 = 4096.0;

/// Chooses the backend for `work`, and compiles what the graphics processor needs, if that is chosen. For [`BackendChoice::Auto`] both are
/// measured, which takes a tenth of a second for each image; runs on rayon's current pool.
///
/// # Errors
/// When a graphics processor is asked for and there is none.
pub fn choose(asked: BackendChoice, work: &Work<'_>) -> Result<Chosen, NoGpu> {
    match asked {
        BackendChoice::Cpu => Ok(Chosen::cpu(None)),
        BackendChoice::Gpu => {
            let adapter = adapter()?;
            if !work.settings.is_empty() && work.settings.iter().all(|settings| !GPU_MODES.contains(&settings.mode)) {
                return Ok(Chosen::cpu(Some(format!("mode {} is computed in f64", work.settings[0].mode))));
            }
            Ok(match work.make_ready() {
                Ok(()) => Chosen { backend: Backend::Gpu, adapter: Some(adapter.label), reason: None },
                Err(reason) => Chosen::cpu(Some(reason)),
            })
        }
        BackendChoice::Auto => Ok(faster(work)),
    }
}

fn faster(work: &Work<'_>) -> Chosen {
    let pixels = f64::from(work.size[0]) * f64::from(work.size[1]);
    if work.samples.is_some_and(|samples| pixels * f64::from(samples) * (work.settings.len() as f64) < FEW) {
        return Chosen::cpu(None);
    }
    let by_gpu = |settings: &&ImageSettings| backend_of(settings.mode, Backend::Gpu) == Backend::Gpu;
    let settings: Vec<ImageSettings> = work.settings.iter().filter(by_gpu).copied().collect();
    let Some(cpu) = seconds_per_sample(Backend::Cpu, work, &settings).filter(|_| !settings.is_empty()) else {
        return Chosen::cpu(None);
    };
    if work.samples.is_some_and(|samples| f64::from(samples) * cpu < SHORT.as_secs_f64()) {
        return Chosen::cpu(None);
    }
    let adapter = match hardware() {
        Ok(adapter) => adapter,
        Err(error) => return Chosen::cpu(Some(error.to_string())),
    };
    if let Err(reason) = work.make_ready() {
        return Chosen::cpu(Some(reason));
    }
    match seconds_per_sample(Backend::Gpu, work, &settings) {
        Some(gpu) if gpu < cpu => Chosen { backend: Backend::Gpu, adapter: Some(adapter.label), reason: None },
        Some(_) => Chosen::cpu(Some(format!("{} is slower than the CPU here", adapter.label))),
        None => Chosen::cpu(Some(fault().unwrap_or_else(|| format!("{} failed", adapter.label)))),
    }
}

/// The graphics processor of this machine, if it is real hardware.
///
/// # Errors
/// When it is not, or as [`adapter`].
pub fn hardware() -> Result<KnownAdapter, NoGpu> {
    if !may_have_hardware() {
        return Err(NoGpu("this machine has no graphics processor".into()));
    }
    let adapter = adapter()?;
    if adapter.is_software { Err(NoGpu(adapter.as_slow())) } else { Ok(adapter) }
}

/// Whether there may be a graphics processor in hardware. On Linux the kernel tells without any driver being loaded: that takes time, and Mesa's
/// writes messages of its own to standard error where nobody has logged in to a desktop.
fn may_have_hardware() -> bool {
    let is_there = |path: &str| std::path::Path::new(path).exists();
    cfg!(not(target_os = "linux")) || ["/dev/dri", "/dev/nvidiactl", "/dev/dxg", "/dev/kfd"].into_iter().any(is_there)
}

impl Work<'_> {
    /// Whether the graphics processor can begin with all of it at once.
    pub fn is_ready(&self) -> bool {
        self.on_gpu(|renderer, task| (renderer.require(task).is_err() || !renderer.is_ready(task)).then_some(()))
            .is_none()
    }

    /// Compiles what the graphics processor needs for it.
    ///
    /// # Errors
    /// When it turns out that it cannot render it: why.
    pub fn make_ready(&self) -> Result<(), String> {
        self.on_gpu(|renderer, task| renderer.make_ready(task).err()).map_or(Ok(()), |error| {
            let why = error.to_string();
            // That is what is done.
            Err(why.strip_suffix("; use the CPU").unwrap_or(&why).to_owned())
        })
    }

    /// The first that `find` finds among the images that the graphics processor would render.
    fn on_gpu<T>(&self, find: impl Fn(&dyn Renderer, &RenderTask<'_>) -> Option<T>) -> Option<T> {
        self.settings.iter().find_map(|settings| {
            let backend = backend_of(settings.mode, Backend::Gpu);
            let settings = &ImageSettings { backend, splits: 0, ..*settings };
            find(renderer(backend), &RenderTask { prepared: self.prepared, camera: self.camera, settings })
        })
    }
}

/// Seconds that one sample of every pixel of all images takes on a backend, by a short measurement after one pass that finds cold caches and
/// compiles. `None` where it fails.
fn seconds_per_sample(backend: Backend, work: &Work<'_>, settings: &[ImageSettings]) -> Option<f64> {
    let [width, height] = work.size;
    let pixels = f64::from(width) * f64::from(height);
    let shrink = if backend == Backend::Cpu { (CPU_PIXELS / pixels).sqrt().min(1.0) } else { 1.0 };
    let [width, height] = [width, height].map(|side| ((f64::from(side) * shrink) as u32).max(1));
    let never = AtomicBool::new(false);
    settings
        .iter()
        .map(|settings| {
            let settings = ImageSettings {
                backend,
                splits: if backend == Backend::Gpu { 0 } else { settings.splits },
                ..*settings
            };
            let task = RenderTask { prepared: work.prepared, camera: work.camera, settings: &settings };
            let mut film = Film::new(width, height);
            // By the renderer itself, so that no other steps in for it.
            let mut pass = |samples| renderer(backend).pass(&task, &mut film, samples, &never).then_some(());
            pass(1)?;
            let begin = Instant::now();
            let (mut taken, mut next) = (0_u32, 1);
            while begin.elapsed().as_secs_f64() < MEASURING && taken < 1024 {
                pass(next)?;
                taken += next;
                next *= 2;
            }
            let seconds = begin.elapsed().as_secs_f64() / f64::from(taken);
            Some(seconds * pixels / (f64::from(width) * f64::from(height)))
        })
        .sum()
}

/// The graphics processor of this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KnownAdapter {
    /// Name and interface, such as `NVIDIA GeForce RTX 4070 (Vulkan)`.
    pub label: String,
    pub is_software: bool,
}

impl KnownAdapter {
    /// Why it is not used where it is one in software.
    pub fn as_slow(&self) -> String {
        format!("{} computes on the CPU itself", self.label)
    }
}

/// The graphics processor of this machine, which is looked for when it is first asked for: that can take a second.
///
/// # Errors
/// When there is none that can compute, or this program is built without.
#[cfg(feature = "gpu")]
pub fn adapter() -> Result<KnownAdapter, NoGpu> {
    let gpu = super::gpu::SharedGpu::get().map_err(|error| NoGpu(error.to_string()))?;
    let adapter = &gpu.device.adapter;
    match gpu.fault() {
        Some(fault) => Err(NoGpu(fault.to_string())),
        None => Ok(KnownAdapter { label: adapter.label(), is_software: adapter.is_software }),
    }
}

/// The graphics processor of this machine.
///
/// # Errors
/// Always, as this program is built without.
#[cfg(not(feature = "gpu"))]
pub fn adapter() -> Result<KnownAdapter, NoGpu> {
    let advice = "build it with `--features gpu`, or use the CPU";
    Err(NoGpu(format!("this program is built without rendering by the graphics processor; {advice}")))
}

/// Forgets a graphics processor that has failed, or that there was none: it is looked for again when it is next asked for.
pub fn renew() {
    #[cfg(feature = "gpu")]
    super::gpu::SharedGpu::renew();
}

/// Takes the graphics processor away from this process, as a driver that is reset does: to try what happens then.
pub fn take_gpu_away() {
    #[cfg(feature = "gpu")]
    if let Ok(device) = super::gpu::GpuDevice::shared() {
        device.take_away();
    }
}

/// What went wrong with the graphics processor, if it has been used and something has.
#[cfg(feature = "gpu")]
pub fn fault() -> Option<String> {
    super::gpu::SharedGpu::fault().map(|fault| fault.to_string())
}

#[cfg(not(feature = "gpu"))]
pub fn fault() -> Option<String> {
    None
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::tracking::{Mode, prepare};

    #[test]
    fn the_reference_stays_on_the_cpu_and_takes_the_samples_of_those_beside_it() {
        let [rectified, reference] = [Mode::Rectified, Mode::Reference].map(|mode| ImageSettings::new(mode, 7));
        assert!(rectified.splits > 0);
        let by_cpu = Chosen::cpu(None);
        assert_eq!((by_cpu.settings(rectified), by_cpu.settings(reference)), (rectified, reference));
        let by_gpu = Chosen { backend: Backend::Gpu, adapter: Some("Card".into()), reason: None };
        let [rectified, reference] = [rectified, reference].map(|settings| by_gpu.settings(settings));
        assert_eq!((reference.backend, reference.splits, rectified.splits), (Backend::Cpu, 0, 0));
        assert_eq!(rectified.backend == Backend::Gpu, cfg!(feature = "gpu"));
    }

    #[test]
    fn little_work_is_not_worth_the_looking() {
        let prepared = prepare(Arc::new(crate::formats::open("plain-glass").unwrap()), None).unwrap();
        let camera = Camera::new(&prepared.description.camera).unwrap();
        let settings = [ImageSettings::new(Mode::Rectified, 0)];
        let work = Work { prepared: &prepared, camera: &camera, settings: &settings, size: [10, 10], samples: Some(4) };
        for asked in [BackendChoice::Cpu, BackendChoice::Auto] {
            assert_eq!(choose(asked, &work), Ok(Chosen::cpu(None)));
        }
        // An hour of work is, but what computes on the CPU itself is no help.
        let long = Work { size: [1000, 1000], samples: Some(1 << 20), ..work };
        let chosen = choose(BackendChoice::Auto, &long).unwrap();
        assert_eq!(chosen.backend == Backend::Gpu, chosen.adapter.is_some());
        assert!(chosen.adapter.is_some() || chosen.reason.is_some() || !cfg!(feature = "gpu"));
        assert!(hardware().is_ok() || chosen.backend == Backend::Cpu);
    }

    #[test]
    fn both_backends_can_be_measured() {
        let prepared = prepare(Arc::new(crate::formats::open("plain-glass").unwrap()), None).unwrap();
        let camera = Camera::new(&prepared.description.camera).unwrap();
        let settings = [ImageSettings::new(Mode::Naive, 0)];
        let work = Work { prepared: &prepared, camera: &camera, settings: &settings, size: [16, 12], samples: None };
        let secs = |backend| seconds_per_sample(backend, &work, &settings);
        assert!(secs(Backend::Cpu).is_some_and(|secs| secs > 0.0));
        match adapter() {
            Ok(_) => assert!(work.make_ready() == Ok(()) && secs(Backend::Gpu).is_some_and(|secs| secs > 0.0)),
            Err(why) => assert!(std::env::var_os("CI").is_none() || cfg!(not(feature = "gpu")), "{why}"),
        }
    }

    #[test]
    fn what_is_put_together_names_both() {
        use Backend::{Cpu, Gpu, Mixed};
        assert_eq!([Cpu.and(Cpu), Gpu.and(Gpu), Cpu.and(Gpu), Gpu.and(Cpu)], [Cpu, Gpu, Mixed, Mixed]);
        assert_eq!([Mixed.and(Cpu), Gpu.and(Mixed)], [Mixed; 2]);
    }
}
