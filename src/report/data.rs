//! Everything that one report holds: what the page shows and the files beside it say.

use serde::Serialize;

use super::backends::Backends;
use super::editing::Editing;
use super::estimators::Estimators;
use super::experiment::SceneErrors;
use super::first_look::FirstLook;
use super::frame_times::FrameTimes;
use super::growth::Growth;
use super::left_out::LeftOut;
use super::machine::Machine;
use super::pictures::Pictures;
use super::stability::Stability;

/// Where the numbers come from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Origin {
    pub program: &'static str,
    pub version: &'static str,
    /// Whether the program was built with optimisation; without it times mean little.
    pub is_optimized: bool,
    pub machine: Machine,
    /// Name and interface of the graphics processor that was measured; `None` where all was rendered by the CPU.
    pub adapter: Option<String>,
    /// When the report was finished; some of its pieces may be older, if it was interrupted.
    pub date: String,
    /// As it was typed.
    pub command: String,
    pub seed: u64,
    pub threads: usize,
    pub is_quick: bool,
    /// Load average over a minute at the start, if the system tells; above 0, other programs were using the machine.
    pub load_before: Option<f64>,
    /// Seconds that this run took; pieces that an earlier run had finished are not in it.
    pub seconds: f64,
    pub pieces_reused: usize,
    pub pieces_made: usize,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneReport {
    /// The built-in scene's name, or the file's stem.
    pub name: String,
    /// As it calls itself.
    pub title: String,
    /// One sentence, of built-in scenes.
    pub about: Option<String>,
    pub refractors: usize,
    pub triangles: usize,
    pub spheres: usize,
    /// The medium that paths start in.
    pub camera_medium: String,
    /// Seconds of building the tree and of rectification.
    pub build_secs: f64,
    pub rectify_secs: f64,
    pub pictures: Option<Pictures>,
    pub errors: Option<SceneErrors>,
    pub left_out: Option<LeftOut>,
    pub editing: Option<Editing>,
    pub first_look: Option<FirstLook>,
    pub estimators: Option<Estimators>,
    pub backends: Option<Backends>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    pub origin: Origin,
    pub scenes: Vec<SceneReport>,
    pub stability: Option<Stability>,
    pub growth: Vec<Growth>,
    /// As the window has measured them, where that is given.
    pub frames: Option<FrameTimes>,
}
