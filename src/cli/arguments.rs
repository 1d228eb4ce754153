//! What can be said on the command line, and what each word means.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use glam::DVec3;

use crate::check::Severity;
use crate::export::resolved::Target;
use crate::render::{BackendChoice, Estimator, EstimatorChoice, ImageSettings, SampleRange, ToneCurve};
use crate::report::make::Part;
use crate::scene::shapes::MAX_LENGTH;
use crate::tracking::Mode;
use crate::transport::inspect::Follow;
use crate::transport::sampler::Sequence;

/// Longest side of an image.
const MOST_SIDE: u32 = 32_768;
/// Most pixels of an image: a film takes 28 bytes for each.
const MOST_PIXELS: u64 = 1 << 26;

const EXAMPLES: &str = "\
Examples:
  iorect                                        open the window on a built-in scene
  iorect my-scene.toml                          open the window on your own
  iorect table.glb                              or on a glTF file
  iorect scenes                                 list the built-in scenes
  iorect compare camera-in-water                naive, stack and rectified side by side, as a PNG
  iorect render nested-spheres --spp 256 -o out.exr
  iorect merge part*.exr -o all.exr             parts that `render --samples A..B` wrote, as one
  iorect rectify nested-spheres                 what lies on the other side of every surface
  iorect trace camera-in-water --pixel 256,256  one path, vertex by vertex
  iorect check my-scene.toml                    what is wrong or doubtful in a scene
  iorect check scene.xml --deny warning         a linter for scenes of other renderers
  iorect report -o report --quick               error against time, stability, speed, growth: a page

Exit codes: 0 fine, 1 the work failed, 2 the command or the scene was wrong.";

/// Scenes in which dielectrics sit inside dielectrics: seen, compared, measured.
///
/// Without a command, opens the window. Wherever a SCENE is asked for, the path of a scene file, a glTF, Mitsuba or pbrt file or a mesh,
/// or the name of a built-in scene will do.
#[derive(Debug, Parser)]
#[command(name = "iorect", version, args_conflicts_with_subcommands = true, after_help = EXAMPLES, max_term_width = 110)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<Command>,
    #[command(flatten)]
    pub window: WindowArguments,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render one image in one mode, to PNG or EXR
    Render(RenderArguments),
    /// Render several modes side by side, with labels and differences, in one PNG
    Compare(CompareArguments),
    /// Put together parts of an image that were rendered apart, without rounding
    Merge(MergeArguments),
    /// Show what rectification found on the other side of every refractor
    Rectify(RectifyArguments),
    /// Follow one path, vertex by vertex
    Trace(TraceArguments),
    /// Say what is wrong or doubtful in a scene, with advice
    Check(CheckArguments),
    /// Write a glTF, Mitsuba or pbrt file, a scene around a mesh, or a built-in scene as a scene file
    Convert(ConvertArguments),
    /// List the built-in scenes
    Scenes(ListArguments),
    /// Measure scenes: error against run time, stability, what was left out, growth, as a page with plots and tables
    Report(ReportArguments),
    /// Write a scene for another renderer, every interface resolved
    Export(ExportArguments),
}

/// The window, and the flags by which the project takes pictures of it.
#[derive(Debug, Args)]
pub struct WindowArguments {
    /// Scene to open: a file or a built-in scene's name [default: iced-water]
    #[arg(value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// Take a picture of the window and quit
    #[arg(long, hide = true, value_name = "FILE.png")]
    pub screenshot: Option<PathBuf>,
    /// Measure how long the window takes for a frame while panes render, write that and quit
    #[arg(long, hide = true, value_name = "FILE.json", conflicts_with = "screenshot")]
    pub measure_frames: Option<PathBuf>,
    /// Size of the window in pixels
    #[arg(long, hide = true, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    pub window_size: Option<Size>,
    /// Samples per pixel to wait for before the picture is taken
    #[arg(long, hide = true, default_value_t = 32, requires = "screenshot")]
    pub samples: u32,
    /// Number of panes in the picture: 1, 2 or 4
    #[arg(long, hide = true, requires = "screenshot")]
    pub panes: Option<usize>,
    /// What renders the pictures
    #[arg(long, hide = true, value_name = "BACKEND", default_value = "auto", value_parser = backend)]
    pub backend: BackendChoice,
    /// One pane over the other, with a divider
    #[arg(long, hide = true, requires = "screenshot")]
    pub wipe: bool,
    /// The light theme
    #[arg(long, hide = true, requires = "screenshot")]
    pub light: bool,
    /// Tab at the right: render, rectification, inspector or measure, which begins to measure
    #[arg(long, hide = true, requires = "screenshot", value_parser = ["render", "rectification", "inspector", "measure"])]
    pub tab: Option<String>,
    /// Place in the first pane whose path is inspected, in percent of its width and height
    #[arg(long, hide = true, requires = "screenshot", value_name = "X,Y", value_parser = pixel, allow_hyphen_values = true)]
    pub inspect: Option<[u32; 2]>,
    /// The ghost view of that path, from the side
    #[arg(long, hide = true, requires = "inspect")]
    pub ghost: bool,
}

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

#[derive(Debug, Args)]
pub struct RectifyArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// What one answer is stored for: patch (a part of a surface with the same surroundings everywhere) or object
    #[arg(long, value_name = "GRANULARITY", default_value = "patch", value_parser = granularity)]
    pub granularity: Granularity,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  iorect trace camera-in-water --pixel 256,256
  iorect trace camera-in-water --pixel 256,256 --mode stack      where the stack goes wrong
  iorect trace my.toml --origin 0,1,4 --direction 0,-0.2,-1 --json")]
pub struct TraceArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Pixel whose centre the path goes through, from the lens's centre; 0,0 is top left
    #[arg(long, value_name = "X,Y", value_parser = pixel, allow_hyphen_values = true, conflicts_with = "origin")]
    pub pixel: Option<[u32; 2]>,
    /// Size of the image that --pixel counts in
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size, allow_hyphen_values = true)]
    pub size: Size,
    /// Light whose light the path is, instead of --pixel; --seed decides where and in which direction it starts
    #[arg(long, value_name = "NAME", conflicts_with_all = ["pixel", "origin"])]
    pub from_light: Option<String>,
    /// Where the path starts, instead of --pixel
    #[arg(long, value_name = "X,Y,Z", value_parser = origin, allow_hyphen_values = true, requires = "direction")]
    pub origin: Option<DVec3>,
    /// Where the path goes from --origin; any length but 0
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true, requires = "origin")]
    pub direction: Option<DVec3>,
    #[arg(long, value_name = "MODE", default_value = "rectified", help = format!("How media are tracked: {}", Mode::list()))]
    pub mode: Mode,
    /// Another mode: its path is told too, and where the two part and why
    #[arg(long, value_name = "MODE")]
    pub against: Option<Mode>,
    /// Which way to go at each surface: transmit (where reflection is not total), reflect, or sample (by chance, as a render does)
    #[arg(long, value_name = "WAY", default_value = "transmit", value_parser = follow)]
    pub follow: Follow,
    /// Seed for --follow sample
    #[arg(long, value_name = "K", default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u64,
    /// Most segments, or `none`
    #[arg(long, value_name = "D", default_value = "none", value_parser = depth, allow_negative_numbers = true)]
    pub max_depth: Depth,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Writes report.html, which holds everything and needs no network, and beside it report.json and the tables as CSV. What is finished is
kept in DIR/cache: a report that was interrupted goes on from there when the same command is given again.

Examples:
  iorect report -o report --quick                                all built-in scenes, in two minutes
  iorect report -o report                                        the same in full: more than an hour
  iorect report my.toml iced-water -o report --only error
  iorect report -o report --only stability,growth")]
pub struct ReportArguments {
    /// Scene files or built-in scenes' names [default: all built-in scenes]
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// Folder to write into; it is made where it is missing
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Small images and few runs
    #[arg(long)]
    pub quick: bool,
    /// What to measure, separated by commas: error, stability, left-out, editing, first-look, growth, estimators, backends [default: all of it]
    #[arg(long, value_name = "PARTS", value_delimiter = ',')]
    pub only: Vec<Part>,
    /// Whether a graphics processor is measured beside the CPU, which renders everything else: cpu (no), auto (where it is real hardware), or
    /// gpu, by which the part editing is rendered too
    #[arg(long, value_name = "BACKEND", default_value = "auto", value_parser = backend)]
    pub backend: BackendChoice,
    /// Seed of the random numbers
    #[arg(long, value_name = "K", default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u64,
    /// Threads to measure on [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024), allow_negative_numbers = true)]
    pub threads: Option<u32>,
    /// What the window has measured of its frames (written by iorect --measure-frames), to be shown too
    #[arg(long, hide = true, value_name = "FILE.json")]
    pub frames: Option<PathBuf>,
    /// Print the whole report as JSON
    #[arg(long)]
    pub json: bool,
    /// Next to nothing of everything, to try what is done with measurements
    #[arg(long, hide = true, conflicts_with = "quick")]
    pub tiny: bool,
}

#[derive(Debug, Args)]
pub struct SceneArguments {
    /// A scene file or a built-in scene's name
    pub scene: PathBuf,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  iorect check my.toml
  iorect check my.toml --json --deny warning      for continuous integration: exit code 1 at a warning, 2 at an error")]
pub struct CheckArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Exit with code 1 if there is a problem of this severity or a worse one: warning or advice
    #[arg(long, value_name = "SEVERITY", value_parser = severity)]
    pub deny: Option<Severity>,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  iorect convert bunny.stl bunny.toml             the mesh in glass, on a floor under a lamp
  iorect convert table.glb table.toml             a glTF file, with its meshes as PLY in the folder table-meshes
  iorect convert iced-water mine.toml             a built-in scene, with the files that it names")]
pub struct ConvertArguments {
    /// A scene file, a glTF, Mitsuba or pbrt file, a mesh, or a built-in scene's name
    pub from: PathBuf,
    /// The file to write; its ending must be `.toml`
    pub to: PathBuf,
}

#[derive(Debug, Args)]
pub struct ListArguments {
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Every place where light meets another medium is written once, with the media on both sides: meshes are split along patches and along the curves where
surfaces cross, of coincident surfaces one stands for all, and what has the same medium on both sides is left out. What can only be approximated is
listed.

  mitsuba   scene.xml for Mitsuba 3
  pbrt      scene.pbrt for pbrt-v4
  gltf      scene.glb for viewers: volumes as objects, nothing split
  faces     faces.json and a PLY file for each refractor, whose faces have the properties `outside` and `inside`

Examples:
  iorect export iced-water --to mitsuba -o iced-water-mitsuba
  iorect export my.toml --to faces -o tables --json")]
pub struct ExportArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// What for: mitsuba, pbrt, gltf or faces
    #[arg(long, value_name = "TARGET", value_parser = target)]
    pub to: Target,
    /// Folder to write to; it is made if it is not there
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Size of the picture that the scene asks for
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size, allow_hyphen_values = true)]
    pub size: Size,
    /// Samples of each of its pixels
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
}

fn target(text: &str) -> Result<Target, String> {
    let all = [Target::Mitsuba, Target::Pbrt, Target::Gltf, Target::Faces];
    let valid = || all.map(Target::name).join(", ");
    all.into_iter()
        .find(|target| target.name() == text)
        .ok_or_else(|| format!("unknown target `{text}`; valid: {}", valid()))
}

/// Width and height in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

/// A cap on the segments of a path; `None`: no cap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Depth(pub Option<u32>);

/// What one answer of rectification is stored for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Granularity {
    /// Each part of a surface that has the same surroundings everywhere.
    Patch,
    /// Each object.
    Object,
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Switch(pub bool);

fn size(text: &str) -> Result<Size, String> {
    let (width, height) =
        text.split_once(['x', 'X', '×']).ok_or("give width and height in pixels, such as 1280x720")?;
    let side = |text: &str| text.trim().parse::<u32>().map_err(|_| format!("`{text}` is not a number of pixels"));
    let (width, height) = (side(width)?, side(height)?);
    if width == 0 || height == 0 {
        return Err("an image needs at least one pixel in each direction".into());
    }
    if width > MOST_SIDE || height > MOST_SIDE || u64::from(width) * u64::from(height) > MOST_PIXELS {
        return Err(format!("at most {MOST_SIDE} pixels a side and {MOST_PIXELS} in all"));
    }
    Ok(Size { width, height })
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= 1e7 => Ok(seconds),
        _ => Err("give a number of seconds above 0, at most 1e7".into()),
    }
}

fn samples(text: &str) -> Result<SampleRange, String> {
    let index = |text: &str| text.trim().parse::<u32>().ok();
    let range = text.split_once("..").and_then(|(first, end)| Some(SampleRange(index(first)?, index(end)?)));
    match range {
        Some(range) if range.count() > 0 => Ok(range),
        _ => Err("give the first sample and the one after the last, such as 0..256, at most 4294967295".into()),
    }
}

fn depth(text: &str) -> Result<Depth, String> {
    match (text, text.parse::<u32>()) {
        ("none", _) => Ok(Depth(None)),
        (_, Ok(segments)) if segments > 0 => Ok(Depth(Some(segments))),
        _ => Err("give a number of segments, at least 1, or `none`".into()),
    }
}

fn exposure(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(stops) if stops.abs() <= 40.0 => Ok(stops),
        _ => Err("give a number of stops between -40 and 40".into()),
    }
}

fn on_or_off(text: &str) -> Result<Switch, String> {
    one_of(text, &[("on", Switch(true)), ("off", Switch(false))], &[])
}

fn backend(text: &str) -> Result<BackendChoice, String> {
    let all = [BackendChoice::Auto, BackendChoice::Cpu, BackendChoice::Gpu];
    one_of(text, &all.map(|backend| (backend.name(), backend)), &[])
}

fn estimator(text: &str) -> Result<EstimatorChoice, String> {
    use EstimatorChoice::{Auto, Bidirectional, Merging, Path};
    one_of(text, &[Auto, Path, Bidirectional, Merging].map(|estimator| (estimator.name(), estimator)), &[])
}

fn severity(text: &str) -> Result<Severity, String> {
    one_of(text, &[("warning", Severity::Warning), ("advice", Severity::Advice)], &[])
}

fn sequence(text: &str) -> Result<Sequence, String> {
    one_of(text, &[("sobol", Sequence::Sobol), ("independent", Sequence::Independent)], &[])
}

fn granularity(text: &str) -> Result<Granularity, String> {
    one_of(text, &[("patch", Granularity::Patch), ("object", Granularity::Object)], &[])
}

fn follow(text: &str) -> Result<Follow, String> {
    let all = [("sample", Follow::Sample), ("transmit", Follow::Transmit), ("reflect", Follow::Reflect)];
    one_of(text, &all, &[])
}

/// The value of the choice that `text` names; names in `planned` are known, but not built yet.
fn one_of<T: Copy>(text: &str, choices: &[(&str, T)], planned: &[&str]) -> Result<T, String> {
    if let Some((_, value)) = choices.iter().find(|(name, _)| *name == text) {
        return Ok(*value);
    }
    let valid = choices.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    if planned.contains(&text) {
        return Err(format!("`{text}` is not yet supported; valid: {valid}"));
    }
    Err(format!("valid: {valid}"))
}

fn pixel(text: &str) -> Result<[u32; 2], String> {
    let wrong = || "give column and row, such as 256,128; 0,0 is top left".to_owned();
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    Ok([x.trim().parse().map_err(|_| wrong())?, y.trim().parse().map_err(|_| wrong())?])
}

fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if DVec3::new(x, y, z).is_finite() => Ok(DVec3::new(x, y, z)),
        _ => Err("give three finite numbers, such as 0,1.5,-4".into()),
    }
}

fn origin(text: &str) -> Result<DVec3, String> {
    let origin = point(text)?;
    if origin.abs().max_element() <= MAX_LENGTH {
        Ok(origin)
    } else {
        Err(format!("numbers are at most {MAX_LENGTH:e}"))
    }
}

fn direction(text: &str) -> Result<DVec3, String> {
    let direction = point(text)?;
    // The squares of a very long or short one would not be finite or not be there.
    (direction / direction.abs().max_element()).try_normalize().ok_or_else(|| "a direction cannot be zero".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn sizes() {
        assert_eq!(size("1280x720"), Ok(Size { width: 1280, height: 720 }));
        assert_eq!(size("8192×8192"), Ok(Size { width: 8192, height: 8192 }));
        for wrong in ["0x0", "0x5", "5x0", "5", "x", "-1x5", "1e3x5", "32769x1", "8193x8192", "99999999999x1"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn ranges_of_samples() {
        assert_eq!(samples("0..256"), Ok(SampleRange(0, 256)));
        assert_eq!(samples("4294967294..4294967295"), Ok(SampleRange(u32::MAX - 1, u32::MAX)));
        for wrong in ["", "5", "5..5", "6..5", "-1..5", "0..", "..4", "0...4", "0..=4", "0..4294967296", "a..b"] {
            assert!(samples(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_is_unknown_is_told_what_is_valid() {
        assert_eq!(backend("auto"), Ok(BackendChoice::Auto));
        assert_eq!(backend("gpu"), Ok(BackendChoice::Gpu));
        assert!(backend("abacus").unwrap_err().contains("auto, cpu, gpu"));
        assert_eq!(estimator("merging"), Ok(EstimatorChoice::Merging));
        assert!(estimator("photons").unwrap_err().contains("auto, path, bidirectional, merging"));
        assert_eq!(granularity("patch"), Ok(Granularity::Patch));
        assert!(granularity("face").unwrap_err().contains("patch, object"));
    }

    #[test]
    fn points_and_directions() {
        assert_eq!(point("-1, 2e1,0.5"), Ok(DVec3::new(-1.0, 20.0, 0.5)));
        assert_eq!(direction("0,0,-4"), Ok(DVec3::NEG_Z));
        assert_eq!(direction("0,1e-300,0"), Ok(DVec3::Y));
        assert_eq!(direction("1e300,0,0"), Ok(DVec3::X));
        assert_eq!(origin("1e18,0,0"), Ok(DVec3::X * 1e18));
        assert!(origin("0,-1e19,0").unwrap_err().contains("1e18"));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,nan", "1,2,inf", "a,b,c"] {
            assert!(point(wrong).is_err(), "{wrong}");
        }
        assert!(direction("0,0,0").is_err());
    }
}
