//! How long it takes until a picture looks clean: a scene is rendered as the window's first panes are, all modes in turns with the same random
//! numbers, and each is held against a converged image of its own mode by FLIP, which says what an eye sees.

use serde::{Deserialize, Serialize};

use super::progress::Progress;
use super::timing::Timed;
use crate::measure::{MetricError, flip};
use crate::render::{Display, ImageSettings};
use crate::scene::Description;
use crate::scene::camera::Camera;
use crate::session::first_modes;
use crate::tracking::{Mode, Prepared};

/// A picture with less mean FLIP than this looks clean.
pub const CLEAN: f64 = 0.05;
/// Pixels of each of the first four panes, in a window of its first size with all panels.
pub const PANE: [u32; 2] = [509, 450];

/// The modes of a scene's first panes, in the order of [`Mode::ALL`]; those of most scenes for one that is not built in.
pub fn modes(description: &Description) -> Vec<Mode> {
    let first = first_modes::of(description)
        .map_or([Mode::Naive, Mode::Stack, Mode::Rectified], |first| [first.wrong, first.right, first.third]);
    Mode::ALL.into_iter().filter(|mode| first.contains(mode)).collect()
}

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FirstLookPlan {
    pub size: [u32; 2],
    /// Samples per pixel of the converged images, whose seed is another one.
    pub converged_samples: u32,
    /// Gives up after so many seconds of rendering.
    pub most_secs: f64,
    pub seed: u64,
}

/// How long one scene takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FirstLook {
    pub size: [u32; 2],
    pub converged_samples: u32,
    /// Seconds until the first sample can be taken: building the tree and rectification.
    pub prepare_secs: f64,
    pub modes: Vec<ModeLook>,
}

/// How long one mode's picture takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModeLook {
    pub mode: Mode,
    /// At doublings of the samples.
    pub points: Vec<Look>,
    /// Seconds of rendering until FLIP is below [`CLEAN`], between two points by interpolation; `None` where it was given up before.
    pub clean_secs: Option<f64>,
    /// Samples per pixel by then.
    pub clean_samples: Option<f64>,
}

/// A picture at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Look {
    pub samples: u32,
    /// Seconds that all modes together have been rendered.
    pub secs: f64,
    /// Mean FLIP against the converged image.
    pub flip: f64,
}

impl FirstLook {
    /// Seconds until every mode's picture is clean; `None` where one was given up.
    pub fn all_clean_secs(&self) -> Option<f64> {
        let times: Option<Vec<f64>> = self.modes.iter().map(|mode| mode.clean_secs).collect();
        times.and_then(|times| times.into_iter().reduce(f64::max))
    }
}

/// How long the pictures of the modes `shown` take, on rayon's current pool. `Ok(None)` when cancelled.
///
/// # Errors
/// When images cannot be compared: not every number in them is finite.
pub fn measure(
    prepared: &Prepared,
    camera: &Camera,
    shown: &[Mode],
    plan: &FirstLookPlan,
    progress: &Progress<'_>,
) -> Result<Option<FirstLook>, MetricError> {
    let [width, height] = plan.size;
    let timed = |mode, seed| Timed::new(prepared, camera, ImageSettings::new(mode, seed), (width, height));
    let mut modes = Vec::new();
    for &mode in shown {
        let mut converged = timed(mode, plan.seed.wrapping_add(1));
        while converged.film.samples < plan.converged_samples {
            let some = (plan.converged_samples - converged.film.samples).min(16);
            if converged.slice(some, progress).is_none() {
                return Ok(None);
            }
        }
        let image = converged.film.to_rgb();
        let [width, height] = plan.size.map(|side| side as usize);
        let viewed = flip::DEFAULT_PIXELS_PER_DEGREE;
        let converged = flip::Reference::displayed(&image, width, height, viewed, Display::default())?;
        modes.push((timed(mode, plan.seed), converged, Vec::<Look>::new()));
    }
    let mut secs = 0.0;
    let mut samples = 1;
    loop {
        for (timed, ..) in &mut modes {
            let Some(took) = timed.slice(samples - timed.film.samples, progress) else { return Ok(None) };
            secs += took;
        }
        for (timed, converged, points) in &mut modes {
            let flip = converged.flip(&timed.film.to_rgb())?.mean();
            points.push(Look { samples, secs, flip });
        }
        let is_clean = modes.iter().all(|(.., points)| points.last().is_some_and(|point| point.flip < CLEAN));
        // With half as many samples as the converged image its noise counts too.
        if is_clean || secs > plan.most_secs || 2 * samples >= plan.converged_samples {
            break;
        }
        samples *= 2;
    }
    let modes = modes.into_iter().map(|(timed, _, points)| ModeLook::of(timed.settings.mode, points)).collect();
    let prepare_secs = prepared.seconds.bvh + prepared.seconds.rectify;
    Ok(Some(FirstLook { size: plan.size, converged_samples: plan.converged_samples, prepare_secs, modes }))
}

impl ModeLook {
    /// What pictures at rising numbers of samples say.
    pub fn of(mode: Mode, points: Vec<Look>) -> Self {
        let clean = points.iter().position(|point| point.flip < CLEAN);
        let at = clean.map(|after| match after.checked_sub(1).map(|before| points[before]) {
            None => (points[after].secs, f64::from(points[after].samples)),
            Some(before) => {
                // FLIP falls as a power of the samples.
                let after = points[after];
                let part = (before.flip / CLEAN).ln() / (before.flip / after.flip.max(f64::MIN_POSITIVE)).ln();
                let between = |a: f64, b: f64| a * (b / a).powf(part);
                (between(before.secs, after.secs), between(f64::from(before.samples), f64::from(after.samples)))
            }
        });
        Self { mode, points, clean_secs: at.map(|(secs, _)| secs), clean_samples: at.map(|(_, samples)| samples) }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::tracking::prepare;

    #[test]
    fn the_time_lies_between_the_pictures_around_it() {
        let look = |samples: u32, flip: f64| Look { samples, secs: 0.1 * f64::from(samples), flip };
        let points = vec![look(1, 0.4), look(2, 0.2), look(4, 0.1), look(8, 0.025)];
        let found = ModeLook::of(Mode::Stack, points.clone());
        // Half-way from 0.1 to 0.025 by the logarithm.
        assert!((found.clean_secs.unwrap() - 0.4 * 2.0_f64.sqrt()).abs() < 1e-9);
        assert!((found.clean_samples.unwrap() - 4.0 * 2.0_f64.sqrt()).abs() < 1e-9);
        assert_eq!(ModeLook::of(Mode::Stack, points[..3].to_vec()).clean_secs, None);
        assert_eq!(ModeLook::of(Mode::Stack, vec![look(1, 0.01)]).clean_secs, Some(0.1));
    }

    #[test]
    fn pictures_of_a_scene_become_clean() {
        let description = Arc::new(crate::formats::open("plain-glass").unwrap());
        let camera = Camera::new(&description.camera).unwrap();
        let shown = modes(&description);
        let prepared = prepare(description, None).unwrap();
        let plan = FirstLookPlan { size: [32, 24], converged_samples: 256, most_secs: 1e9, seed: 0 };
        let measured = |cancel: bool| {
            let progress = Progress { cancel: &AtomicBool::new(cancel), tell: &|_, _| () };
            measure(&prepared, &camera, &shown, &plan, &progress).unwrap()
        };
        let found = measured(false).unwrap();
        assert!(measured(true).is_none());
        assert_eq!(found.modes.iter().map(|mode| mode.mode).collect::<Vec<_>>(), shown);
        for mode in &found.modes {
            assert!(
                mode.points.windows(2).all(|pair| pair[1].secs > pair[0].secs && pair[1].samples > pair[0].samples)
            );
            let (first, last) = (mode.points[0], mode.points[mode.points.len() - 1]);
            assert!(last.flip < 0.6 * first.flip, "{:?}", mode.points);
        }
    }
}
