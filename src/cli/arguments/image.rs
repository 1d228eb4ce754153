//! Commands that make images.

use std::path::PathBuf;

use clap::Args;

use super::values::{
    Depth, Size, Switch, backend, depth, estimator, exposure, on_or_off, samples, seconds, sequence, size,
};
use crate::render::{BackendChoice, Estimator, EstimatorChoice, ImageSettings, SampleRange, ToneCurve};
use crate::tracking::Mode;
use crate::transport::sampler::Sequence;

/// What makes an image, for `render` and `compare`.
#[derive(Debug, Args)]
pub struct ImageArguments {
    /// A scene file or a built-in scene's name
    pub scene: PathBuf,
    /// Samples per pixel [default: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24), allow_negative_numbers = true, conflicts_with = "time")]
    pub spp: Option<u32>,
    /// Render for this many seconds instead (one sample per pixel at least)
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// Image size in pixels, at most 32768 a side and 67108864 in all
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size, allow_hyphen_values = true)]
    pub size: Size,
    /// Seed of the random numbers; all modes use the same ones
    #[arg(long, value_name = "K", default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u64,
    /// Most segments of a path, the camera's first being one, or `none`: K surfaces need K + 1
    #[arg(long, value_name = "D", default_value = "none", value_parser = depth, allow_negative_numbers = true)]
    pub max_depth: Depth,
    /// What computes: cpu, gpu, or auto, which takes the graphics processor where a short measurement finds it faster; mode reference
    /// is always computed by the CPU
    #[arg(long, value_name = "BACKEND", default_value = "auto", value_parser = backend)]
    pub backend: BackendChoice,
    /// How light is transported: path (from the camera), bidirectional (from the lights too), merging (these, and light that has come to places
    /// nearby: caustics seen through glass), or auto, which merges where caustics of small lights would be too noisy for paths
    #[arg(long, value_name = "ESTIMATOR", default_value = "auto", value_parser = estimator)]
    pub estimator: EstimatorChoice,
    /// Threads to render on [default: one per core]; the image does not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024), allow_negative_numbers = true)]
    pub threads: Option<u32>,
    /// Exposure of PNG pictures in stops; EXR and figures stay linear
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, value_parser = exposure, allow_negative_numbers = true)]
    pub exposure: f32,
    /// Tone curve of PNG pictures: soft (a shoulder) or clip (cut off at 1)
    #[arg(long, value_name = "CURVE", default_value = "soft")]
    pub curve: ToneCurve,
    /// Whether samples go where they lower the error most: on or off; `--spp` is then the mean over the pixels [default: on, but off with
    /// --samples and for estimators that begin at lights too]
    #[arg(long, value_name = "on|off", value_parser = on_or_off)]
    pub adaptive: Option<Switch>,
    /// Interfaces seen from the camera at which a path may split, so that both the reflected and the transmitted light are followed; 0: none,
    /// as always with the graphics processor [default: 2, or 0 with the graphics processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=8), allow_negative_numbers = true)]
    pub splits: Option<u32>,
    /// Where random numbers come from: sobol, whose samples are spread evenly, or independent
    #[arg(long, value_name = "SEQUENCE", default_value = "sobol", value_parser = sequence)]
    pub sampler: Sequence,
    /// Whether image environments are sampled where they are bright: on or off
    #[arg(long, value_name = "on|off", default_value = "on", value_parser = on_or_off)]
    pub sample_environment: Switch,
    /// Whether work that the scene does not need is left out: on or off; off only measures what that saves
    #[arg(long, value_name = "on|off", default_value = "on", value_parser = on_or_off)]
    pub leave_out: Switch,
    /// Print what was done as JSON; without -o, no picture is written then
    #[arg(long)]
    pub json: bool,
    /// Take the graphics processor away after so many samples per pixel, to try what happens then
    #[arg(long, hide = true, value_name = "N")]
    pub lose_gpu_after: Option<u32>,
    /// Whether progress is told in lines where standard error is no terminal; nothing that can be asked for.
    #[arg(skip)]
    pub tells_progress: bool,
}

impl ImageArguments {
    /// How the image of one mode is rendered by the CPU with an estimator.
    pub fn settings(&self, mode: Mode, estimator: Estimator) -> ImageSettings {
        let usual = ImageSettings::new(mode, self.seed);
        ImageSettings {
            estimator,
            max_depth: self.max_depth.0,
            leave_out: self.leave_out.0,
            splits: if estimator == Estimator::Path { self.splits.unwrap_or(usual.splits) } else { 0 },
            sampler: self.sampler,
            sample_environment: self.sample_environment.0,
            ..usual
        }
    }

    /// The estimators to choose from: what only paths from the camera can do decides for those.
    ///
    /// # Errors
    /// When another is asked for.
    pub fn estimator(&self) -> Result<EstimatorChoice, String> {
        let is_adaptive = self.adaptive == Some(Switch(true));
        match self.estimator {
            EstimatorChoice::Auto if is_adaptive || self.backend == BackendChoice::Gpu || self.splits.is_some() => {
                Ok(EstimatorChoice::Path)
            }
            estimator @ (EstimatorChoice::Bidirectional | EstimatorChoice::Merging) if is_adaptive => Err(format!(
                "estimator {} spreads its samples evenly, as light from lamps falls on any pixel; leave out `--adaptive on`, or use `--estimator \
                 path`",
                estimator.name()
            )),
            estimator @ (EstimatorChoice::Bidirectional | EstimatorChoice::Merging)
                if self.splits.is_some_and(|splits| splits > 0) =>
            {
                Err(format!(
                    "estimator {} does not split paths; leave out --splits, or use `--estimator path`",
                    estimator.name()
                ))
            }
            estimator => Ok(estimator),
        }
    }

    /// What may render: the graphics processor does not split paths.
    ///
    /// # Errors
    /// When both are asked for.
    pub fn backend(&self) -> Result<BackendChoice, &'static str> {
        match (self.backend, self.splits) {
            (BackendChoice::Gpu, Some(1..)) => {
                Err("the graphics processor does not split paths; leave out --splits, or use `--backend cpu`")
            }
            (BackendChoice::Auto, Some(1..)) => Ok(BackendChoice::Cpu),
            (backend, _) => Ok(backend),
        }
    }
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  iorect render camera-in-water                                  → camera-in-water-rectified.png
  iorect render my.toml --mode stack --spp 256 --size 1280x720 -o stack.png
  iorect render my.toml --time 30 -o linear.exr
  iorect render my.toml --spp 16 --json                          figures only
  iorect render my.toml --samples 256..512 -o part1.exr          for `iorect merge`")]
pub struct RenderArguments {
    #[command(flatten)]
    pub image: ImageArguments,
    #[arg(long, value_name = "MODE", default_value = "rectified", help = format!("How media are tracked: {}", Mode::list()))]
    pub mode: Mode,
    /// Take the samples from A up to but without B of every pixel, and write their sums and counts without rounding, as an EXR file: `iorect
    /// merge` puts such parts together. The samples are those of one render; parts of 2^k samples that begin at a multiple of 2^k are
    /// as well distributed as its first
    #[arg(long, value_name = "A..B", value_parser = samples, conflicts_with_all = ["spp", "time"])]
    pub samples: Option<SampleRange>,
    /// Picture to write, by its extension PNG (as seen, with text about what it shows) or EXR (linear) [default: SCENE-MODE.png, or with
    /// --samples SCENE-MODE-A-B.exr]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Also show the picture, linear, in the image viewer tev, where it listens [address without a value: 127.0.0.1:14158]
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, require_equals = true, default_missing_value = "")]
    pub tev: Option<String>,
}

#[derive(Debug, Args)]
#[command(after_help = "\
All modes use the same random numbers and advance in lockstep, so that differences show the modes' errors rather than noise.
They are taken against the most trusted mode listed: the help of --modes names all, the least trusted first.

Examples:
  iorect compare camera-in-water                                 → camera-in-water-comparison.png
  iorect compare my.toml --modes stack,rectified,reference --spp 256 -o compared.png
  iorect compare my.toml --time 20 --json                        figures only")]
pub struct CompareArguments {
    #[command(flatten)]
    pub image: ImageArguments,
    #[arg(
        long, value_name = "MODES", default_value = "naive,stack,rectified", value_delimiter = ',',
        help = format!("Modes to compare, separated by commas: {}", Mode::list())
    )]
    pub modes: Vec<Mode>,
    /// Picture to write [default: SCENE-comparison.png]
    #[arg(short, long, value_name = "FILE.png")]
    pub output: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Files must be of one image: same content of the scene, camera, size, mode, backend, seed and settings, and no sample twice. The result is the
same to the bit in whatever order and grouping files are merged, and, by the CPU, as if one machine had taken all samples.

Examples:
  iorect merge part*.exr -o all.exr                              can be merged further; any viewer opens it
  iorect merge part*.exr -o all.exr -o all.png
  iorect merge part*.exr --json                                  what they hold, and whether they go together")]
pub struct MergeArguments {
    /// Files that `iorect render --samples` or `iorect merge` wrote
    #[arg(required = true, value_name = "FILE.exr")]
    pub files: Vec<PathBuf>,
    /// Put together parts by the CPU and by graphics processors, which agree but for rounding; the CPU's need `--splits 0`
    #[arg(long)]
    pub mix_backends: bool,
    /// File to write, by its extension EXR (sums and counts again, and the picture) or PNG; may be given more than once
    #[arg(short, long = "output", value_name = "FILE")]
    pub outputs: Vec<PathBuf>,
    /// Exposure of PNG pictures in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, value_parser = exposure, allow_negative_numbers = true)]
    pub exposure: f32,
    /// Tone curve of PNG pictures: soft (a shoulder) or clip (cut off at 1)
    #[arg(long, value_name = "CURVE", default_value = "soft")]
    pub curve: ToneCurve,
    /// Print what was merged as JSON
    #[arg(long)]
    pub json: bool,
}
