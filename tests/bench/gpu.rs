//! What the graphics processor brings on this machine: million samples a second of each mode, by the CPU and by the graphics processor, of two
//! scenes of the tests' data (S1 and S2) or of any others.
//!
//! `cargo bench --bench gpu` takes less than five minutes, the build not counted. It says which graphics processor it has found, how long the
//! shaders took to compile, and how far the two images are apart, as the share of pixels that differ by more than rounding: what is quick
//! but wrong must not pass for a result. A second table says how far each part of the work is from what the card can do at the most, as far as that can be told without
//! its maker's tools: memory is copied and numbers are multiplied and added on it, as fast as it goes.

// Reason: printing is what it is for.
#![allow(clippy::print_stdout)]

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use iorect::render::choice::{self, Work};
use iorect::render::gpu::{Limits, SharedGpu, Tally};
use iorect::render::{Backend, Film, GPU_MODES, ImageSettings, RenderTask};
use iorect::report::backends::apart;
use iorect::scene::camera::Camera;
use iorect::tracking::{Mode, Prepared, prepare};

const HELP: &str = "\
Million samples a second by the CPU and by the graphics processor.

Usage: cargo bench --bench gpu -- [OPTIONS]

  --scene NAME  a scene file or a built-in scene [S1 and S2 of tests/data/reference]; as often as wanted
  --size WxH    pixels of each picture [1024x1024]
  --secs S      seconds for each measurement [5]
  --help        this text

WGPU_BACKEND (vulkan, dx12, metal, gl) and WGPU_ADAPTER_NAME choose among several graphics processors.
";

/// Samples per pixel of the images that are compared.
const COMPARED: u32 = 4;

/// Bytes that a step in the tree reads: a node; a triangle or sphere has about as many.
const BYTES_PER_STEP: f64 = 64.0;
/// Operations of a step: two boxes, each with six products and sums, six margins and twelve comparisons.
const FLOPS_PER_STEP: f64 = 60.0;
/// Bytes that are written and read again for a path that is put away: its state, and the sums of its pixel.
const BYTES_PER_RESUMED: f64 = 2.0 * (128.0 + 32.0);

const ABOUT_PARTS: &str = "\
Segments: million a second of a path, from surface to surface; rays towards lights come on top. Steps: nodes and triangles that rays are held against, rays
towards lights included. Tree: what steps read and compute, as a share of what was copied and computed above at the most; more than 100 % of memory
comes from caches. Put away: states of paths that go on in a later dispatch. What is far below both limits waits: for memory it depends on, or for other threads of
its group. Dispatch: mean time, and the longest since the program began.";

struct Options {
    scenes: Vec<PathBuf>,
    modes: Vec<Mode>,
    size: [u32; 2],
    secs: f64,
}

fn main() -> ExitCode {
    let Some(options) = options() else {
        println!("{HELP}");
        return ExitCode::SUCCESS;
    };
    match run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            println!("{why}");
            // Whoever runs the tests need not have a graphics processor.
            let is_test = !std::env::args().any(|word| word == "--bench");
            if is_test && std::env::var_os("CI").is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
    }
}

/// `None` where help is wanted, or nothing can be done.
fn options() -> Option<Options> {
    let mut options = Options { scenes: Vec::new(), modes: GPU_MODES.to_vec(), size: [1024; 2], secs: 5.0 };
    // Run among the tests, it only shows that it runs.
    if !std::env::args().any(|word| word == "--bench") {
        return Some(Options {
            scenes: vec!["plain-glass".into()],
            modes: vec![Mode::Naive],
            size: [16; 2],
            secs: 0.01,
        });
    }
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    while let Some(word) = words.next() {
        let mut value = || words.next();
        match word.as_str() {
            "--scene" => options.scenes.push(value()?.into()),
            "--size" => {
                let (width, height) = value()?.split_once('x').map(|(w, h)| (w.to_owned(), h.to_owned()))?;
                options.size = [width.parse().ok()?, height.parse().ok()?];
            }
            "--secs" => options.secs = value()?.parse().ok()?,
            _ => return None,
        }
    }
    if options.scenes.is_empty() {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/reference");
        options.scenes = ["s1.toml", "s2.toml"].map(|name| folder.join(name)).to_vec();
    }
    Some(options)
}

fn run(options: &Options) -> Result<(), String> {
    let begin = Instant::now();
    let adapter = choice::adapter().map_err(|error| error.to_string())?;
    let kind = if adapter.is_software { ", which computes on the CPU itself" } else { "" };
    println!("{}{kind}, found in {:.2} s", adapter.label, begin.elapsed().as_secs_f64());
    let [width, height] = options.size;
    println!("{} threads on the CPU, {width} × {height} pixels\n", rayon::current_num_threads());
    let limits = SharedGpu::get().map_err(|error| error.to_string())?.limits().map_err(|error| error.to_string())?;
    let Limits { bytes_per_sec, flops_per_sec } = limits;
    println!(
        "It copies {:.1} GB a second (read and written), and computes {:.1} Gflop a second\n",
        bytes_per_sec / 1e9,
        flops_per_sec / 1e9
    );
    println!("| scene | mode | CPU | GPU | GPU/CPU | compiled in | other paths | mean |");
    println!("|---|---|---|---|---|---|---|---|");
    let mut parts = Vec::new();
    for path in &options.scenes {
        let description = iorect::formats::open(path).map_err(|error| error.to_string())?;
        let camera = Camera::new(&description.camera).map_err(|error| error.to_string())?;
        let name = description.name.clone();
        let prepared = prepare(Arc::new(description), None).map_err(|error| error.to_string())?;
        for &mode in &options.modes {
            let (row, work) = row(&prepared, &camera, mode, options)?;
            println!("| {name} | {mode} | {row}");
            parts.push(format!("| {name} | {mode} | {}", parts_of(&work, limits)));
        }
    }
    println!(
        "\nIn million samples of a pixel a second, without splits. Other paths: pixels that differ by more than rounding."
    );
    println!(
        "\n| scene | mode | segments | steps a segment | tree: memory | tree: arithmetic | put away: memory | dispatch |"
    );
    println!("|---|---|---|---|---|---|---|---|\n{}", parts.join("\n"));
    println!("\n{ABOUT_PARTS}");
    match choice::fault() {
        Some(fault) => Err(format!("These figures are worth nothing: {fault}.")),
        None => Ok(()),
    }
}

/// How far the parts of the work of `secs` are from the limits.
fn parts_of((work, secs): &(Tally, f64), limits: Limits) -> String {
    let (steps, resumed) = (work.steps as f64 / secs, work.resumed as f64 / secs);
    let percent = |rate: f64, limit: f64| 100.0 * rate / limit;
    format!(
        "{:.2} | {:.0} | {:.1} % | {:.1} % | {:.1} % | {:.1} ms, {:.1} ms |",
        work.segments as f64 / secs / 1e6,
        work.steps as f64 / work.segments.max(1) as f64,
        percent(steps * BYTES_PER_STEP, limits.bytes_per_sec),
        percent(steps * FLOPS_PER_STEP, limits.flops_per_sec),
        percent(resumed * BYTES_PER_RESUMED, limits.bytes_per_sec),
        1e3 * work.secs / work.dispatches.max(1) as f64,
        1e3 * work.longest_secs,
    )
}

fn tally() -> Tally {
    SharedGpu::get().map_or_else(|_| Tally::default(), |gpu| gpu.tally())
}

/// The row of a table, and what the graphics processor did in how many seconds.
fn row(prepared: &Prepared, camera: &Camera, mode: Mode, options: &Options) -> Result<(String, (Tally, f64)), String> {
    let usual = ImageSettings { splits: 0, ..ImageSettings::new(mode, 1) };
    let begin = Instant::now();
    let work = Work { prepared, camera, settings: &[usual], size: options.size, samples: None };
    work.make_ready()?;
    let compiled = begin.elapsed().as_secs_f64();
    let by = |backend| ImageSettings { backend, ..usual };
    let images = [Backend::Cpu, Backend::Gpu].map(|backend| {
        let mut film = Film::new(128, 128);
        pass(prepared, camera, &by(backend), &mut film, COMPARED);
        film.to_rgb()
    });
    let cpu = rate(prepared, camera, &by(Backend::Cpu), options);
    let (before, begin) = (tally(), Instant::now());
    let gpu = rate(prepared, camera, &by(Backend::Gpu), options);
    let work = (tally().since(before), begin.elapsed().as_secs_f64());
    let [by_cpu, by_gpu] = &images;
    let (others, ratio) = apart(by_cpu, by_gpu);
    let shares = format!("{compiled:.2} s | {:.2} % | {:+.3} %", 100.0 * others, 100.0 * (ratio - 1.0));
    Ok((format!("{cpu:.2} | {gpu:.2} | {:.1} | {shares} |", gpu / cpu), work))
}

fn pass(prepared: &Prepared, camera: &Camera, settings: &ImageSettings, film: &mut Film, samples: u32) {
    RenderTask { prepared, camera, settings }.pass(film, samples, &AtomicBool::new(false));
}

/// Million samples of a pixel a second, after one pass that finds cold caches.
fn rate(prepared: &Prepared, camera: &Camera, settings: &ImageSettings, options: &Options) -> f64 {
    let mut film = Film::new(options.size[0], options.size[1]);
    pass(prepared, camera, settings, &mut film, 1);
    let begin = Instant::now();
    let mut samples = 1;
    while begin.elapsed().as_secs_f64() < options.secs {
        let slice = Instant::now();
        pass(prepared, camera, settings, &mut film, samples);
        // Slices of a fifth of a second or more.
        if slice.elapsed().as_secs_f64() < 0.2 {
            samples *= 2;
        }
    }
    let taken = f64::from(film.samples - 1) * f64::from(film.width) * f64::from(film.height);
    taken / begin.elapsed().as_secs_f64() / 1e6
}
