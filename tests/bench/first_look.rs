//! Time until pictures look clean, of one or several builds of iorect by the same method: a table of what a change has brought.
//!
//! `cargo bench --bench first_look -- --program before=/path/to/iorect --program after=target/release/iorect` renders every built-in scene
//! that a program has (`--scene NAME`, as often as wanted, chooses) in the modes of the first panes, as `report --only first-look` does, but by
//! the command line: each program's `render` writes images of 1, 2, 4, … samples per pixel, spread evenly, and says how long rendering took; each
//! is held against a converged image of the same program and mode with another seed. A picture looks clean when its mean FLIP is below 0.05. The
//! time of a picture is that of all modes with as many samples, as they are rendered in turns, with what preparing the scene took.

// Reason: printing is what it is for.
#![allow(clippy::print_stdout)]

use std::path::{Path, PathBuf};
use std::process::Command;

use iorect::measure::flip;
use iorect::render::Display;
use iorect::report::first_look::{self, CLEAN, Look, ModeLook, PANE};
use iorect::tracking::Mode;
use serde_json::Value;

const HELP: &str = "\
Seconds until pictures look clean, with one or several builds of iorect.

Usage: cargo bench --bench first_look -- --program NAME=PATH [OPTIONS]

  --program NAME=PATH  a build, under the name that its column gets; as often as wanted
  --scene NAME         a built-in scene [all that the program has]; as often as wanted
  --size WxH           pixels of each picture [that of the first four panes]
  --converged N        samples per pixel of the converged images [1024]
  --most-secs S        gives a scene up after so many seconds of rendering [300]
  --help               this text
";

struct Options {
    programs: Vec<(String, PathBuf)>,
    scenes: Vec<String>,
    size: [u32; 2],
    converged: u32,
    most_secs: f64,
}

fn main() {
    match options() {
        Some(options) => run(&options),
        None => println!("{HELP}"),
    }
}

/// `None` where help is wanted, or nothing can be done.
fn options() -> Option<Options> {
    let mut options =
        Options { programs: Vec::new(), scenes: Vec::new(), size: PANE, converged: 1024, most_secs: 300.0 };
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        let mut value = || words.next();
        match word.as_str() {
            "--program" => {
                let (name, path) = value()?.split_once('=').map(|(name, path)| (name.to_owned(), path.into()))?;
                options.programs.push((name, path));
            }
            "--scene" => options.scenes.push(value()?),
            "--size" => {
                let (width, height) = value()?.split_once('x').map(|(w, h)| (w.to_owned(), h.to_owned()))?;
                options.size = [width.parse().ok()?, height.parse().ok()?];
            }
            "--converged" => options.converged = value()?.parse().ok()?,
            "--most-secs" => options.most_secs = value()?.parse().ok()?,
            _ => return None,
        }
    }
    (!options.programs.is_empty()).then_some(options)
}

fn run(options: &Options) {
    let folder = tempfile::tempdir().expect("a folder for images");
    let columns: Vec<&str> = options.programs.iter().map(|(name, _)| name.as_str()).collect();
    println!("Seconds until mean FLIP is below {CLEAN} ({} × {} pixels)\n", options.size[0], options.size[1]);
    println!("| scene | {} |\n|---|{}", columns.join(" | "), "---|".repeat(columns.len()));
    let scenes = if options.scenes.is_empty() { scenes_of(&options.programs) } else { options.scenes.clone() };
    for scene in scenes {
        let cells = options.programs.iter().map(|(_, program)| {
            let looks = Program { path: program, folder: folder.path(), options }.looks(&scene);
            looks.map_or("–".to_owned(), |looks| looks.iter().map(entry).collect::<Vec<_>>().join(", "))
        });
        println!("| {scene} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
}

fn entry(look: &ModeLook) -> String {
    let time = match look {
        ModeLook { clean_secs: Some(secs), clean_samples: Some(samples), .. } => {
            format!("{secs:.1} ({samples:.0} spp)")
        }
        ModeLook { points, .. } => {
            points.last().map_or("–".to_owned(), |last| format!("> {:.1} (FLIP {:.3})", last.secs, last.flip))
        }
    };
    format!("{} {time}", look.mode)
}

/// The built-in scenes of all programs, each once.
fn scenes_of(programs: &[(String, PathBuf)]) -> Vec<String> {
    let mut scenes: Vec<String> = Vec::new();
    for (_, program) in programs {
        let output = Command::new(program).args(["scenes", "--json"]).output().expect("the program runs");
        let listed: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        let list = listed.as_array().or_else(|| listed["scenes"].as_array()).cloned().unwrap_or_default();
        for name in list.iter().filter_map(|scene| scene["name"].as_str()) {
            if !scenes.iter().any(|known| known == name) {
                scenes.push(name.to_owned());
            }
        }
    }
    scenes
}

struct Program<'a> {
    path: &'a Path,
    folder: &'a Path,
    options: &'a Options,
}

impl Program<'_> {
    /// `None` where the program cannot render the scene.
    fn looks(&self, scene: &str) -> Option<Vec<ModeLook>> {
        let [width, height] = self.options.size.map(|side| side as usize);
        let mut modes = Vec::new();
        for mode in first_look::modes(&iorect::formats::open(scene).ok()?) {
            let (_, image) = self.render(scene, mode, self.options.converged, 1)?;
            let viewed = flip::DEFAULT_PIXELS_PER_DEGREE;
            let reference = flip::Reference::displayed(&image, width, height, viewed, Display::default()).ok()?;
            modes.push((mode, reference, Vec::new()));
        }
        let mut samples = 1;
        loop {
            let mut secs = 0.0;
            let mut flips = Vec::new();
            for (mode, reference, _) in &modes {
                let ([prepare, render], image) = self.render(scene, *mode, samples, 0)?;
                secs += render + if flips.is_empty() { prepare } else { 0.0 };
                flips.push(reference.flip(&image).ok()?.mean());
            }
            for ((.., points), flip) in modes.iter_mut().zip(&flips) {
                points.push(Look { samples, secs, flip: *flip });
            }
            let is_clean = flips.iter().all(|flip| *flip < CLEAN);
            if is_clean || secs > self.options.most_secs || 2 * samples >= self.options.converged {
                break;
            }
            samples *= 2;
        }
        Some(modes.into_iter().map(|(mode, _, points)| ModeLook::of(mode, points)).collect())
    }

    /// Seconds of preparation and of rendering, and the image.
    fn render(&self, scene: &str, mode: Mode, samples: u32, seed: u64) -> Option<([f64; 2], Vec<[f32; 3]>)> {
        let file = self.folder.join("image.exr");
        let [width, height] = self.options.size;
        let output = Command::new(self.path)
            .args(["render", scene, "--mode", mode.name(), "--adaptive", "off", "--json", "-o"])
            .arg(&file)
            .args(["--spp", &samples.to_string(), "--seed", &seed.to_string(), "--size", &format!("{width}x{height}")])
            .output()
            .ok()?;
        let report: Value = serde_json::from_slice(&output.stdout).ok()?;
        let seconds = |part: &str| report["seconds"][part].as_f64();
        let image = image::open(&file).ok()?.to_rgb32f();
        let pixels = image.pixels().map(|pixel| pixel.0).collect();
        Some(([seconds("bvh")? + seconds("rectify")?, seconds("render")?], pixels))
    }
}
