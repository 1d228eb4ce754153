//! Two independent references of a scene: long renders in mode `reference`, kept on disk, and gone on with after an interruption.
//!
//! Samples are Sobol points, whose scrambling depends on seed and pixel: each sample of each seed is uniform for itself, so the mean over seeds
//! is unbiased, and two seeds share nothing. Every pixel gets equally many. Interfaces are split as usual, which is unbiased too.
//!
//! The key of a kept reference is the fingerprint of its image (contents of meshes and images, camera, size, settings, version) and the
//! build of this program, since another build may sample differently. The number of samples is not in it: a kept reference with too few
//! is added to, whichever run left it behind, and one with more is used as it is.

use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DVec3;

use super::checked::{Reader, Writer};
use super::progress::Progress;
use super::store::Store;
use crate::export::ExportError;
use crate::render::{Cpu, Film, ImageSettings, RenderTask, Renderer, fingerprint};
use crate::scene::camera::Camera;
use crate::tracking::Mode;
use crate::tracking::{Events, Prepared};

/// The seeds of the two, which no run takes unless it is asked to.
pub const SEEDS: [u64; 2] = [u64::MAX - 1, u64::MAX];
/// What was rendered since the last time of keeping is lost at an interruption.
const KEPT_EVERY_SECS: f64 = 5.0;
/// Progress is told, and cancelling looked after, about so often.
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

struct Kept {
    film: Film,
    render_secs: f64,
}

fn reference(
    wanted: &Wanted<'_>,
    seed: u64,
    store: &Store,
    progress: Progress<'_>,
) -> Result<Option<Kept>, ExportError> {
    let settings = ImageSettings { max_depth: wanted.max_depth, ..ImageSettings::new(Mode::Reference, seed) };
    let path = path(wanted, &settings, store);
    let [width, height] = wanted.size;
    let mut kept =
        read(&path, wanted.size).unwrap_or_else(|| Kept { film: Film::new(width, height), render_secs: 0.0 });
    let mut unkept_secs = 0.0;
    let mut slice = 1;
    while kept.film.samples < wanted.spp {
        let samples = slice.min(wanted.spp - kept.film.samples);
        let start = Instant::now();
        if !Cpu.pass(
            &RenderTask { prepared: wanted.prepared, camera: wanted.camera, settings: &settings },
            &mut kept.film,
            samples,
            progress.cancel,
        ) {
            // The slice is half done and lost; what stood before it is worth keeping only if it was kept already.
            return Ok(None);
        }
        let secs = start.elapsed().as_secs_f64();
        kept.render_secs += secs;
        unkept_secs += secs;
        slice = ((SLICE_SECS / secs.max(1e-9) * f64::from(samples)) as u32).max(1);
        if unkept_secs >= KEPT_EVERY_SECS || kept.film.samples >= wanted.spp {
            write(&path, &kept)?;
            unkept_secs = 0.0;
        }
        (progress.tell)("reference", f64::from(kept.film.samples) / f64::from(wanted.spp));
    }
    Ok(Some(kept))
}

fn path(wanted: &Wanted<'_>, settings: &ImageSettings, store: &Store) -> PathBuf {
    let image = fingerprint(&wanted.prepared.description, wanted.camera, wanted.size, settings);
    store.file("reference", image)
}

/// `None` where nothing fitting is kept.
fn read(path: &Path, size: [u32; 2]) -> Option<Kept> {
    let mut reader = Reader::open(path)?;
    let kept = parse(&mut reader, size).filter(|_| reader.is_at_end());
    if kept.is_none() {
        log::warn!("{}: is not a reference of this size; it is made again", path.display());
    }
    kept
}

fn parse(reader: &mut Reader, size: [u32; 2]) -> Option<Kept> {
    if [reader.small()?, reader.small()?] != size {
        return None;
    }
    let mut film = Film::new(size[0], size[1]);
    film.samples = reader.small()?;
    film.events = reader.events()?;
    let render_secs = reader.number()?;
    for sum in &mut film.sums {
        *sum = DVec3::new(reader.number()?, reader.number()?, reader.number()?);
    }
    for count in &mut film.counts {
        *count = reader.small()?;
    }
    Some(Kept { film, render_secs })
}

fn write(path: &Path, kept: &Kept) -> Result<(), ExportError> {
    let Kept { film, render_secs } = kept;
    let mut writer = Writer::default();
    [film.width, film.height, film.samples].into_iter().for_each(|value| writer.small(value));
    writer.events(&film.events);
    writer.number(*render_secs);
    film.sums.iter().flat_map(DVec3::to_array).for_each(|value| writer.number(value));
    film.counts.iter().for_each(|&count| writer.small(count));
    writer.keep(path)
}
