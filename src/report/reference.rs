//! Two independent references of a scene: long renders in mode `reference`, kept on disk, and gone on with after an interruption.
//!
//! Samples are Sobol points, whose scrambling depends on seed and pixel: each sample of each seed is uniform for itself, so the mean over seeds
//! is unbiased, and two seeds share nothing. Every pixel gets equally many. Interfaces are split as usual, which is unbiased too.
//!
//! The key of a kept reference is the fingerprint of its image (contents of meshes and images, camera, size, settings, version) and the
//! build of this program, since another build may sample differently. The number of samples is not in it: a kept reference with too few
//! is added to, whichever run left it behind, and one with more is used as it is.

use std::time::Instant;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::progress::Progress;
use super::store::Store;
use crate::export::ExportError;
use crate::render::{Film, ImageSettings, RenderTask, fingerprint};
use crate::scene::camera::Camera;
use crate::tracking::Mode;
use crate::tracking::{Events, Prepared};

/// Seeds of the two references; those of runs count up from [`super::experiment::Effort::first_seed`].
pub const SEEDS: [u64; 2] = [u64::MAX - 1, u64::MAX];
/// Seconds of rendering after which a reference is kept; at most as much is lost at an interruption.
const KEPT_EVERY_SECS: f64 = 5.0;
/// Seconds between reports of progress and checks for cancellation, about.
const SLICE_SECS: f64 = 0.25;

/// Images of which references are wanted.
#[derive(Debug, Clone, Copy)]
pub struct Wanted<'a> {
    pub prepared: &'a Prepared,
    /// In scene coordinates.
    pub camera: &'a Camera,
    /// Width and height in pixels.
    pub size: [u32; 2],
    pub max_depth: Option<u32>,
    /// Samples per pixel of each.
    pub spp: u32,
}

/// Two images of the truth with noise of their own.
#[derive(Debug, Clone, PartialEq)]
pub struct References {
    /// Linear RGB, row 0 at the top.
    pub images: [Vec<[f32; 3]>; 2],
    /// Samples per pixel of each: what was wanted, or more.
    pub spp: [u32; 2],
    /// Seconds of rendering in all, whenever that was.
    pub render_secs: f64,
    pub events: Events,
}

impl References {
    /// Their mean, the best image there is.
    pub fn mean(&self) -> Vec<[f32; 3]> {
        let mean = |(a, b): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| f32::midpoint(a[c], b[c]));
        self.images[0].iter().zip(&self.images[1]).map(mean).collect()
    }
}

/// The two references, on rayon's current pool. `Ok(None)` where `progress` was cancelled: what is finished is kept in `store`.
///
/// # Errors
/// When they cannot be kept.
pub fn references(
    wanted: &Wanted<'_>,
    store: &Store,
    progress: Progress<'_>,
) -> Result<Option<References>, ExportError> {
    let mut kept = Vec::with_capacity(SEEDS.len());
    for (index, seed) in SEEDS.into_iter().enumerate() {
        let tell = |done: f64| (progress.tell)("reference", (index as f64 + done) / SEEDS.len() as f64);
        let Some(one) = reference(wanted, seed, store, Progress { tell: &|_, done| tell(done), ..progress })? else {
            return Ok(None);
        };
        kept.push(one);
    }
    let mut events = kept[0].film.events;
    events += kept[1].film.events;
    Ok(Some(References {
        images: [kept[0].film.to_rgb(), kept[1].film.to_rgb()],
        spp: [kept[0].film.samples, kept[1].film.samples],
        render_secs: kept[0].render_secs + kept[1].render_secs,
        events,
    }))
}

/// What is kept of a film: its fields of these names.
#[derive(Serialize, Deserialize)]
struct Kept {
    samples: u32,
    events: Events,
    render_secs: f64,
    sums: Vec<DVec3>,
    counts: Vec<u32>,
}

/// A film and the seconds that it took.
struct Reference {
    film: Film,
    render_secs: f64,
}

fn reference(
    wanted: &Wanted<'_>,
    seed: u64,
    store: &Store,
    progress: Progress<'_>,
) -> Result<Option<Reference>, ExportError> {
    let settings = ImageSettings { max_depth: wanted.max_depth, ..ImageSettings::new(Mode::Reference, seed) };
    let image = fingerprint(&wanted.prepared.description, wanted.camera, wanted.size, &settings);
    let [width, height] = wanted.size;
    let (mut film, mut render_secs) = (Film::new(width, height), 0.0);
    if let Some(kept) = store.find::<Kept>("reference", &image) {
        render_secs = kept.render_secs;
        film = Film { samples: kept.samples, events: kept.events, sums: kept.sums, counts: kept.counts, ..film };
    }
    let mut unkept_secs = 0.0;
    let mut slice = 1;
    while film.samples < wanted.spp {
        let samples = slice.min(wanted.spp - film.samples);
        let start = Instant::now();
        let task = RenderTask { prepared: wanted.prepared, camera: wanted.camera, settings: &settings };
        if !task.pass(&mut film, samples, progress.cancel) {
            // The half-done slice is lost; what was kept before it stays.
            return Ok(None);
        }
        let secs = start.elapsed().as_secs_f64();
        render_secs += secs;
        unkept_secs += secs;
        slice = ((SLICE_SECS / secs.max(1e-9) * f64::from(samples)) as u32).max(1);
        if unkept_secs >= KEPT_EVERY_SECS || film.samples >= wanted.spp {
            let (sums, counts) = (film.sums.clone(), film.counts.clone());
            let kept = Kept { samples: film.samples, events: film.events, render_secs, sums, counts };
            store.keep("reference", &image, &kept)?;
            unkept_secs = 0.0;
        }
        (progress.tell)("reference", f64::from(film.samples) / f64::from(wanted.spp));
    }
    Ok(Some(Reference { film, render_secs }))
}
