//! Pictures of a scene for the page: as `rectified` shows it, and what each mode that differs has too much or too little.

use std::path::Path;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use serde::{Deserialize, Serialize};

use super::progress::Progress;
use super::timing::Timed;
use crate::export::color_map::{diverging, luminance, round_up_to_125};
use crate::export::{ExportError, Picture, png_bytes};
use crate::measure::{Difference, difference};
use crate::render::{Display, Film, ImageSettings};
use crate::scene::camera::Camera;
use crate::tracking::{Events, Mode, Prepared};

/// The colour scale ends where at most this share of the pixels goes beyond it.
const BEYOND_SCALE: f64 = 0.01;
/// Pictures nearer to each other than this, in relMSE, differ by roundings alone.
const ROUNDING: f64 = 1e-12;

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PicturePlan {
    /// Halved with `height` where a scene is slow.
    pub width: u32,
    pub height: u32,
    /// Per pixel, in the mean; fewer where smaller pictures are not enough.
    pub samples: u32,
    pub seed: u64,
    /// Seconds that all pictures of a scene may take, about.
    pub secs: f64,
}

/// Pictures are not made narrower than this, nor of fewer samples than the pilot's and one.
const LEAST_WIDTH: u32 = 96;
const LEAST_SAMPLES: u32 = 9;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pictures {
    pub width: u32,
    pub height: u32,
    pub samples: u32,
    /// PNG, in base64.
    #[serde(rename = "rectified_png")]
    pub rectified: String,
    pub rectified_events: Events,
    /// Where the scale of all differences ends, in linear luminance.
    pub scale: f32,
    pub others: Vec<OtherMode>,
}

/// Another mode beside `rectified`, with the same random numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OtherMode {
    pub mode: Mode,
    pub sameness: Sameness,
    /// Of the image against that of `rectified`. Noise of both is in it, though most of it is the same in both.
    pub relmse: f64,
    pub mean_abs: f64,
    pub events: Events,
    /// PNG in base64: luminance more (orange) or less (blue) than `rectified`; `None` where there is nothing to see.
    #[serde(rename = "difference_png")]
    pub difference: Option<String>,
}

/// How near an image is to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sameness {
    /// To the last bit.
    Equal,
    /// But for roundings.
    Rounding,
    Different,
}

impl Pictures {
    /// The same without pixels, for files that are read by programs.
    pub fn without_pixels(&self) -> Self {
        let blind = |other: &OtherMode| OtherMode { difference: None, ..other.clone() };
        Self { rectified: String::new(), others: self.others.iter().map(blind).collect(), ..self.clone() }
    }
}

/// Renders all modes in lockstep on the current pool. `None` when cancelled.
///
/// # Errors
/// When a picture cannot be made: it has no pixels, or one that is not a number.
pub fn make(
    prepared: &Prepared,
    camera: &Camera,
    plan: &PicturePlan,
    progress: &Progress<'_>,
) -> Result<Option<Pictures>, ExportError> {
    // The others are held against it.
    let others = Mode::ALL.into_iter().filter(|mode| *mode < Mode::Rectified && *mode != Mode::Declared);
    let modes: Vec<Mode> = std::iter::once(Mode::Rectified).chain(others).collect();
    let Some(plan) = &affordable(prepared, camera, plan, modes.len(), progress) else { return Ok(None) };
    let Some(films) = render(prepared, camera, plan, &modes, progress) else { return Ok(None) };
    let pictures: Vec<Picture> = films.iter().map(Picture::from).collect();
    let right = &pictures[0];
    let title = Path::new(&prepared.description.name);
    let mut others = Vec::new();
    for ((&mode, film), picture) in modes.iter().zip(&films).zip(&pictures).skip(1) {
        let Difference { relmse, mean_abs, .. } = difference(&picture.rgb, &right.rgb)?;
        let sameness = match () {
            () if picture.rgb == right.rgb => Sameness::Equal,
            () if relmse < ROUNDING => Sameness::Rounding,
            () => Sameness::Different,
        };
        let brighter = picture.rgb.iter().zip(&right.rgb).map(|(a, b)| luminance(*a) - luminance(*b));
        let brighter: Vec<f32> = if sameness == Sameness::Different { brighter.collect() } else { Vec::new() };
        let other = OtherMode { mode, sameness, relmse, mean_abs, events: film.events, difference: None };
        others.push((other, brighter));
    }
    let scale = round_up_to_125(beyond(others.iter().flat_map(|(_, brighter)| brighter)));
    for (other, brighter) in others.iter_mut().filter(|(_, brighter)| !brighter.is_empty()) {
        let bytes = brighter.iter().flat_map(|difference| diverging(difference / scale)).collect();
        let image = image::RgbImage::from_raw(plan.width, plan.height, bytes).expect("three bytes a pixel");
        other.difference = Some(BASE64_STANDARD.encode(png_bytes(&image, &[], title)?));
    }
    Ok(Some(Pictures {
        width: plan.width,
        height: plan.height,
        samples: films[0].samples,
        rectified: BASE64_STANDARD.encode(png_bytes(&right.encode(&Display::default()), &[], title)?),
        rectified_events: films[0].events,
        scale,
        others: others.into_iter().map(|(other, _)| other).collect(),
    }))
}

/// The plan with pictures as small as they have to be; `None` when cancelled.
fn affordable(
    prepared: &Prepared,
    camera: &Camera,
    plan: &PicturePlan,
    modes: usize,
    progress: &Progress<'_>,
) -> Option<PicturePlan> {
    let mut plan = *plan;
    let settings = ImageSettings::new(Mode::Rectified, plan.seed);
    let mut probe = Timed::new(prepared, camera, settings, (plan.width.div_ceil(4), plan.height.div_ceil(4)));
    let secs = probe.warm_secs(1, progress)? / probe.film.sums.len() as f64 * modes as f64;
    let takes = |plan: &PicturePlan| secs * f64::from(plan.width) * f64::from(plan.height) * f64::from(plan.samples);
    while takes(&plan) > plan.secs && plan.width >= 2 * LEAST_WIDTH {
        (plan.width, plan.height) = (plan.width / 2, plan.height / 2);
    }
    let share = (plan.secs / takes(&plan)).min(1.0);
    plan.samples = ((f64::from(plan.samples) * share) as u32).max(LEAST_SAMPLES.min(plan.samples));
    Some(plan)
}

/// Films of all modes, with samples where the most wrong of them needs them, as `compare` spreads them.
fn render(
    prepared: &Prepared,
    camera: &Camera,
    plan: &PicturePlan,
    modes: &[Mode],
    progress: &Progress<'_>,
) -> Option<Vec<Film>> {
    let adaptive = |&mode: &Mode| {
        let size = (plan.width, plan.height);
        let timed = Timed::new(prepared, camera, ImageSettings::new(mode, plan.seed), size);
        Timed { film: Film::adaptive(plan.width, plan.height), ..timed }
    };
    let mut all: Vec<Timed<'_>> = modes.iter().map(adaptive).collect();
    let mut left = plan.samples;
    while left > 0 {
        let slice = left.min(all[0].film.samples_to_decision());
        for timed in &mut all {
            timed.slice(slice, progress)?;
        }
        Film::allocate(&mut all.iter_mut().map(|timed| &mut timed.film).collect::<Vec<_>>());
        left -= slice;
    }
    Some(all.into_iter().map(|timed| timed.film).collect())
}

/// The size that at most [`BEYOND_SCALE`] of these differences exceed.
fn beyond<'a>(differences: impl Iterator<Item = &'a f32>) -> f32 {
    let mut sizes: Vec<f32> = differences.map(|difference| difference.abs()).collect();
    sizes.sort_by(f32::total_cmp);
    let rank = ((1.0 - BEYOND_SCALE) * sizes.len() as f64) as usize;
    sizes.get(rank).copied().unwrap_or(0.0)
}
