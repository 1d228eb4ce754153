//! Two independent references of a scene: long renders in mode `reference`, kept on disk, and gone on with after an interruption.
//!
//! Samples are Sobol points, whose scrambling depends on seed and pixel: each sample of each seed is uniform for itself, so the mean over seeds
//! is unbiased, and two seeds share nothing. Every pixel gets equally many. Interfaces are split as usual, which is unbiased too.
//!
//! The key of a kept reference is the fingerprint of its image (contents of meshes and images, camera, size, settings, version) and the
//! build of this program, since another build may sample differently. The number of samples is not in it: a kept reference with too few
//! is added to, whichever run left it behind, and one with more is used as it is.

use glam::DVec3;

use super::progress::Progress;
use super::store::Store;
use super::timing::Timed;
use crate::export::ExportError;
use crate::render::{Film, ImageSettings, fingerprint};
use crate::scene::camera::Camera;
use crate::tracking::{Events, Mode, Prepared};

/// Seeds of the two references; those of runs count up from [`super::experiment::Effort::first_seed`].
pub const SEEDS: [u64; 2] = [u64::MAX - 1, u64::MAX];
/// Seconds of rendering after which a reference is kept; at most as much is lost at an interruption.
const KEPT_EVERY_SECS: f64 = 5.0;
/// Seconds between reports of progress and checks for cancellation, about.
const SLICE_SECS: f64 = 0.25;

#[derive(Debug, Clone, Copy)]
pub struct Wanted<'a> {
    pub prepared: &'a Prepared,
    /// In scene coordinates.
    pub camera: &'a Camera,
    pub size: [u32; 2],
    pub max_depth: Option<u32>,
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
    let mut made = Vec::with_capacity(SEEDS.len());
    for (index, seed) in SEEDS.into_iter().enumerate() {
        let tell = |_: &str, done: f64| (progress.tell)("reference", (index as f64 + done) / SEEDS.len() as f64);
        let Some(one) = reference(wanted, seed, store, Progress { tell: &tell, ..progress })? else { return Ok(None) };
        made.push(one);
    }
    let [(first, first_secs), (second, second_secs)] = &made[..] else { return Ok(None) };
    let mut events = first.events;
    events += second.events;
    Ok(Some(References {
        images: [first.to_rgb(), second.to_rgb()],
        spp: [first.samples, second.samples],
        render_secs: first_secs + second_secs,
        events,
    }))
}

/// What is kept of a film: samples, events, seconds, sums and counts.
type Kept = (u32, Events, f64, Vec<DVec3>, Vec<u32>);

/// A film and the seconds that it took.
fn reference(
    wanted: &Wanted<'_>,
    seed: u64,
    store: &Store,
    progress: Progress<'_>,
) -> Result<Option<(Film, f64)>, ExportError> {
    let Wanted { prepared, camera, size, max_depth, spp } = *wanted;
    let settings = ImageSettings { max_depth, ..ImageSettings::new(Mode::Reference, seed) };
    let image = fingerprint(&prepared.description, camera, size, &settings);
    let mut timed = Timed::new(prepared, camera, settings, size.into());
    let mut render_secs = 0.0;
    if let Some((samples, events, secs, sums, counts)) = store.find::<Kept>("reference", &image) {
        render_secs = secs;
        timed.film = Film { samples, events, sums, counts, ..timed.film };
    }
    let mut unkept_secs = 0.0;
    let mut slice = 1;
    while timed.film.samples < spp {
        let samples = slice.min(spp - timed.film.samples);
        // The half-done slice is lost; what was kept before it stays.
        let Some(secs) = timed.slice(samples, &progress) else { return Ok(None) };
        render_secs += secs;
        unkept_secs += secs;
        slice = ((SLICE_SECS / secs.max(1e-9) * f64::from(samples)) as u32).max(1);
        let film = &timed.film;
        if unkept_secs >= KEPT_EVERY_SECS || film.samples >= spp {
            store.keep("reference", &image, &(film.samples, film.events, render_secs, &film.sums, &film.counts))?;
            unkept_secs = 0.0;
        }
        (progress.tell)("reference", f64::from(film.samples) / f64::from(spp));
    }
    Ok(Some((timed.film, render_secs)))
}
