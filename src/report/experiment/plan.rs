//! How much is measured of a scene: decided once, from how fast it renders, and kept, so that an interrupted measurement goes on with
//! the same plan.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::technique::Technique;
use crate::render::{Film, RenderTask};
use crate::scene::camera::Camera;
use crate::tracking::Mode;
use crate::tracking::Prepared;

/// The work allowed for a scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Effort {
    /// Width and height of the images, in pixels; halved where a scene is slow.
    pub size: [u32; 2],
    /// Runs of each mode, at least 3: fewer leave nothing to say about what seeds share.
    pub seeds: u32,
    /// The first run's seed; each further run has the next one.
    pub first_seed: u64,
    pub max_depth: Option<u32>,
    /// Rendering of runs and references together takes about so long.
    pub secs: f64,
    /// No run takes more samples than this, however fast, unless it is below 16.
    pub largest_spp: u32,
    /// Samples of each reference for each sample of a run.
    pub reference_factor: u32,
}

impl Effort {
    /// All built-in scenes in a minute.
    pub const QUICK: Self = Self {
        size: [96, 64],
        seeds: 4,
        first_seed: 0,
        max_depth: None,
        secs: 4.0,
        largest_spp: 256,
        reference_factor: 2,
    };
    /// All built-in scenes in two hours.
    pub const FULL: Self =
        Self { size: [144, 96], seeds: 16, secs: 200.0, largest_spp: 1024, reference_factor: 8, ..Self::QUICK };
}

/// What is measured of one scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    pub size: [u32; 2],
    pub seeds: Vec<u64>,
    pub max_depth: Option<u32>,
    /// Each run's samples per pixel: powers of two from 1 on.
    pub spp: Vec<u32>,
    /// Samples per pixel of each of the two references.
    pub reference_spp: u32,
}

/// Doublings that show a slope well. A scene that is too slow for them is measured in smaller images.
const WANTED_DOUBLINGS: u32 = 5;
/// Least doublings, however slow the scene or busy the machine.
const LEAST_DOUBLINGS: u32 = 4;
/// Images are not made smaller than this many pixels.
const LEAST_PIXELS: u32 = 1500;
/// Modes other than `rectified` and `reference` that are expected to differ and so to be rendered with every seed, and the shipped
/// technique.
const FURTHER_CURVES: f64 = 3.0;

impl Plan {
    /// The plan that `effort` buys on this machine: renders a few samples to see how long they take.
    pub fn new(prepared: &Prepared, camera: &Camera, effort: &Effort) -> Self {
        let secs_per_spp = |mode| probe(prepared, camera, effort, mode);
        let seeds = effort.seeds.max(3);
        let curves = f64::from(seeds) * (1.0 + FURTHER_CURVES) * secs_per_spp(Mode::Rectified);
        let references = 2.0 * f64::from(effort.reference_factor) * secs_per_spp(Mode::Reference);
        let affordable = |size: [u32; 2]| {
            let share = f64::from(size[0] * size[1]) / f64::from(effort.size[0] * effort.size[1]);
            (effort.secs / ((curves + references) * share).max(1e-9)).min(f64::from(effort.largest_spp))
        };
        let mut size = effort.size;
        while affordable(size) < f64::from(1 << WANTED_DOUBLINGS) && size[0] * size[1] >= 4 * LEAST_PIXELS {
            size = size.map(|side| side / 2);
        }
        let doublings = (affordable(size).log2().floor() as u32).max(LEAST_DOUBLINGS);
        Self {
            size,
            seeds: (0..u64::from(seeds)).map(|run| effort.first_seed.wrapping_add(run)).collect(),
            max_depth: effort.max_depth,
            spp: (0..=doublings).map(|doubling| 1 << doubling).collect(),
            reference_spp: effort.reference_factor << doublings,
        }
    }

    pub fn largest_spp(&self) -> u32 {
        self.spp.last().copied().unwrap_or(0)
    }
}

/// Seconds that one sample of every pixel takes.
fn probe(prepared: &Prepared, camera: &Camera, effort: &Effort, mode: Mode) -> f64 {
    let settings = Technique::independent().settings(mode, effort.first_seed, effort.max_depth);
    let mut film = Film::new(effort.size[0], effort.size[1]);
    let mut add = |samples| {
        let start = Instant::now();
        RenderTask { prepared, camera, settings: &settings }.pass(&mut film, samples, &AtomicBool::new(false));
        start.elapsed().as_secs_f64() / f64::from(samples)
    };
    // The first sample finds cold caches.
    add(1);
    add(2)
}
