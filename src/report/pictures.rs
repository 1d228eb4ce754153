//! Pictures of a scene for the page: as `rectified` shows it, and what each mode that differs has too much or too little.

use std::path::Path;

use base64::prelude::{BASE64_STANDARD, Engine as _};
use serde::{Deserialize, Serialize};

use super::progress::Progress;
use super::timing::Timed;
use crate::export::color_map::{diverging, luminance, round_up_to_125};
use crate::export::{ExportError, Picture, png_bytes};
use crate::measure::difference;
use crate::render::{Display, Film, ImageSettings, RenderTask};
use crate::scene::camera::Camera;
use crate::tracking::Mode;
use crate::tracking::{Events, Prepared};

/// The modes that are held against `rectified`.
const OTHERS: [Mode; 4] = [Mode::Naive, Mode::Stack, Mode::Priority, Mode::RectifiedObject];
/// The colour scale ends where at most this share of the pixels goes beyond it.
const BEYOND_SCALE: f64 = 0.01;
/// Pictures nearer to each other than this, in relMSE, differ by roundings alone.
const ROUNDING: f64 = 1e-12;

/// What is rendered.
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

/// The pictures of one scene.
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
    let modes: Vec<Mode> = std::iter::once(Mode::Rectified).chain(OTHERS).collect();
    let plan = &affordable(prepared, camera, plan, modes.len(), progress);
    let Some(films) = render(prepared, camera, plan, &modes, progress) else { return Ok(None) };
    let pictures: Vec<Picture> = films.iter().map(Picture::from).collect();
    let right = &pictures[0];
    let title = Path::new(&prepared.description.name);
    let mut others = Vec::new();
    for ((&mode, film), picture) in modes.iter().zip(&films).zip(&pictures).skip(1) {
        let figures = difference(&picture.rgb, &right.rgb)?;
        let sameness = match () {
            () if picture.rgb == right.rgb => Sameness::Equal,
            () if figures.relmse < ROUNDING => Sameness::Rounding,
            () => Sameness::Different,
        };
        let (relmse, mean_abs) = (figures.relmse, figures.mean_abs);
        others.push(OtherMode { mode, sameness, relmse, mean_abs, events: film.events, difference: None });
    }
    let is_different = |other: &OtherMode| other.sameness == Sameness::Different;
    let different: Vec<&Picture> = others
        .iter()
        .zip(&pictures[1..])
        .filter(|(other, _)| is_different(other))
        .map(|(_, picture)| picture)
        .collect();
    let scale = round_up_to_125(beyond(&different, right));
    for (other, picture) in others.iter_mut().zip(&pictures[1..]) {
        if is_different(other) {
            let pixels = picture.rgb.iter().zip(&right.rgb);
            let bytes = pixels.flat_map(|(a, b)| diverging((luminance(*a) - luminance(*b)) / scale)).collect();
            let image = image::RgbImage::from_raw(plan.width, plan.height, bytes).expect("three bytes a pixel");
            other.difference = Some(BASE64_STANDARD.encode(png_bytes(&image, &[], title)?));
        }
    }
    Ok(Some(Pictures {
        width: plan.width,
        height: plan.height,
        samples: films[0].samples,
        rectified: BASE64_STANDARD.encode(png_bytes(&right.encode(&Display::default()), &[], title)?),
        rectified_events: films[0].events,
        scale,
        others,
    }))
}

/// The plan with pictures as small as they have to be.
fn affordable(
    prepared: &Prepared,
    camera: &Camera,
    plan: &PicturePlan,
    modes: usize,
    progress: &Progress<'_>,
) -> PicturePlan {
    let mut plan = *plan;
    let settings = settings(Mode::Rectified, plan.seed);
    // The first sample finds cold caches.
    let mut probe = Timed::new(prepared, camera, settings, (plan.width.div_ceil(4), plan.height.div_ceil(4)));
    probe.slice(1, progress);
    let secs = probe.slice(1, progress) / probe.film.sums.len() as f64 * modes as f64;
    let takes = |plan: &PicturePlan| secs * f64::from(plan.width) * f64::from(plan.height) * f64::from(plan.samples);
    while takes(&plan) > plan.secs && plan.width >= 2 * LEAST_WIDTH {
        (plan.width, plan.height) = (plan.width / 2, plan.height / 2);
    }
    let share = (plan.secs / takes(&plan)).min(1.0);
    plan.samples = ((f64::from(plan.samples) * share) as u32).max(LEAST_SAMPLES.min(plan.samples));
    plan
}

fn settings(mode: Mode, seed: u64) -> ImageSettings {
    ImageSettings::new(mode, seed)
}

/// Films of all modes, with samples where the most wrong of them needs them, as `compare` spreads them.
fn render(
    prepared: &Prepared,
    camera: &Camera,
    plan: &PicturePlan,
    modes: &[Mode],
    progress: &Progress<'_>,
) -> Option<Vec<Film>> {
    let mut films: Vec<Film> = modes.iter().map(|_| Film::adaptive(plan.width, plan.height)).collect();
    let mut left = plan.samples;
    while left > 0 {
        let slice = left.min(films[0].samples_to_decision());
        for (film, &mode) in films.iter_mut().zip(modes) {
            let task = RenderTask { prepared, camera, settings: &settings(mode, plan.seed) };
            if !task.pass(film, slice, progress.cancel) {
                return None;
            }
        }
        Film::allocate(&mut films.iter_mut().collect::<Vec<_>>());
        left -= slice;
    }
    Some(films)
}

/// The difference in luminance that at most [`BEYOND_SCALE`] of the pixels of these pictures exceed.
fn beyond(pictures: &[&Picture], right: &Picture) -> f32 {
    let mut sizes: Vec<f32> = (pictures.iter())
        .flat_map(|picture| picture.rgb.iter().zip(&right.rgb))
        .map(|(a, b)| (luminance(*a) - luminance(*b)).abs())
        .collect();
    sizes.sort_by(f32::total_cmp);
    let rank = ((1.0 - BEYOND_SCALE) * sizes.len() as f64) as usize;
    sizes.get(rank).copied().unwrap_or(0.0)
}
