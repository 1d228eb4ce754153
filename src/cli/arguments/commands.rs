//! Commands about scenes.

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;

use super::values::{
    Depth, Granularity, Size, backend, depth, direction, follow, granularity, origin, pixel, severity, size, target,
};
use crate::check::Severity;
use crate::export::resolved::Target;
use crate::render::BackendChoice;
use crate::report::make::Part;
use crate::tracking::Mode;
use crate::transport::inspect::Follow;

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
