//! Error against run time of each estimator: what caustics cost paths from the camera, and what merging costs where there are none.
//!
//! Every way renders independent runs, whose samples double. Errors are taken from two halves of the truth, whose noise drops out that way; the
//! square of the bias is told from noise by the product of the errors of two runs.

use serde::{Deserialize, Serialize};

use super::progress::Progress;
use super::timing::Timed;
use crate::measure::metrics::{MetricError, difference_from_two};
use crate::measure::statistics::{line, mean};
use crate::render::{Estimator, EstimatorChoice, Film, ImageSettings, choose_estimator};
use crate::scene::camera::Camera;
use crate::tracking::{Mode, Prepared};

/// A way to take samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Way {
    pub estimator: Estimator,
    /// Whether samples go where they matter.
    pub adaptive: bool,
}

pub const WAYS: [Way; 4] = [
    Way { estimator: Estimator::Path, adaptive: false },
    Way { estimator: Estimator::Path, adaptive: true },
    Way { estimator: Estimator::Bidirectional, adaptive: false },
    Way { estimator: Estimator::Merging, adaptive: false },
];

/// The relMSE to which the time is told.
pub const GOAL: f64 = 1e-2;
/// Added to squared radiance, as in relMSE.
const DARK: f64 = 0.01;

/// What is measured, and how long.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EstimatorsPlan {
    pub size: [u32; 2],
    pub runs: usize,
    /// Seconds of each run; it ends with the first doubling after that.
    pub secs: f64,
    /// Samples at which a run ends at the latest.
    pub most_samples: u32,
    /// Times as many samples as the longest run of the estimator that the scene chooses: of each half of the truth.
    pub truth_factor: u32,
    pub seed: u64,
}

/// What was found in one scene, in mode rectified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimators {
    pub size: [u32; 2],
    /// What `auto` chooses, and what has made the truth.
    pub chosen: Estimator,
    /// Samples of each half of the truth.
    pub truth_samples: u32,
    /// In the order of [`WAYS`].
    pub ways: Vec<WayErrors>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WayErrors {
    pub way: Way,
    pub levels: Vec<Level>,
    /// Exponent of samples by which the error falls; `None` of fewer than two levels.
    pub slope: Option<f64>,
    /// Square of the bias relative to radiance, at the last level, from pairs of runs: it may be below 0 by noise.
    pub bias_squared: f64,
    /// Seconds to an error of [`GOAL`], on the line through the levels; `None` where that does not lead there.
    pub secs_to_goal: Option<f64>,
}

/// The mean over the runs after some samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Level {
    pub samples: u32,
    pub secs: f64,
    pub relmse: f64,
    /// Without the worst 0.1 % of the pixels.
    pub trimmed: f64,
}

type Image = Vec<[f32; 3]>;

/// One run of a way: its images at samples that double, and the seconds up to each.
struct Run(Vec<(u32, f64, Image)>);

/// Measures one scene on the current pool. `None` when cancelled.
///
/// # Errors
/// When an image cannot be compared.
pub fn measure(
    prepared: &Prepared,
    camera: &Camera,
    plan: &EstimatorsPlan,
    progress: &Progress<'_>,
) -> Result<Option<Estimators>, MetricError> {
    let chosen = choose_estimator(EstimatorChoice::Auto, prepared, camera);
    let timed = |way: Way, seed: u64| {
        let splits = if way.estimator == Estimator::Path { ImageSettings::new(Mode::Rectified, 0).splits } else { 0 };
        let settings = ImageSettings { estimator: way.estimator, splits, ..ImageSettings::new(Mode::Rectified, seed) };
        let mut timed = Timed::new(prepared, camera, settings, plan.size.into());
        if way.adaptive {
            timed.film = Film::adaptive(plan.size[0], plan.size[1]);
        }
        timed
    };
    let run = |way: Way, seed: u64| -> Option<Run> {
        let mut timed = timed(way, seed);
        let (mut secs, mut levels) = (0.0, Vec::new());
        let mut next = 1;
        while timed.film.samples < plan.most_samples && secs < plan.secs {
            while timed.film.samples < next {
                let samples = (next - timed.film.samples).min(timed.film.samples_to_decision());
                secs += timed.slice(samples, progress)?;
                Film::allocate(&mut [&mut timed.film]);
            }
            levels.push((next, secs, timed.film.to_rgb()));
            next *= 2;
        }
        Some(Run(levels))
    };
    let mut all = Vec::new();
    for way in WAYS {
        let runs: Option<Vec<Run>> = (0..plan.runs).map(|index| run(way, plan.seed + 1 + index as u64)).collect();
        let Some(runs) = runs else { return Ok(None) };
        all.push((way, runs));
    }
    let is_chosen = |way: &Way| way.estimator == chosen && !way.adaptive;
    let longest = all.iter().filter(|(way, _)| is_chosen(way)).flat_map(|(_, runs)| runs);
    let longest = longest.filter_map(|run| run.0.last()).map(|(samples, ..)| *samples).max().unwrap_or(1);
    let truth_samples = longest.saturating_mul(plan.truth_factor);
    let half = |seed: u64| -> Option<Image> {
        let mut timed = timed(Way { estimator: chosen, adaptive: false }, seed);
        while timed.film.samples < truth_samples {
            timed.slice((truth_samples - timed.film.samples).min(64), progress)?;
        }
        Some(timed.film.to_rgb())
    };
    let (Some(first), Some(second)) = (half(plan.seed + 1000), half(plan.seed + 2000)) else { return Ok(None) };
    let ways = all.into_iter().map(|(way, runs)| errors(way, &runs, [&first, &second]));
    let ways = ways.collect::<Result<Vec<WayErrors>, MetricError>>()?;
    Ok(Some(Estimators { size: plan.size, chosen, truth_samples, ways }))
}

fn errors(way: Way, runs: &[Run], truth: [&[[f32; 3]]; 2]) -> Result<WayErrors, MetricError> {
    let count = runs.iter().map(|run| run.0.len()).min().unwrap_or(0);
    let mut levels = Vec::with_capacity(count);
    for level in 0..count {
        let of_level = || runs.iter().map(|run| &run.0[level]);
        let found = of_level().map(|(_, _, image)| difference_from_two(image, truth));
        let found = found.collect::<Result<Vec<_>, MetricError>>()?;
        let of = |values: Vec<f64>| mean(&values).unwrap_or(f64::NAN);
        levels.push(Level {
            samples: runs[0].0[level].0,
            secs: of(of_level().map(|(_, secs, _)| *secs).collect()),
            relmse: of(found.iter().map(|difference| difference.relmse).collect()),
            trimmed: of(found.iter().map(|difference| difference.relmse_trimmed).collect()),
        });
    }
    let last: Vec<&Image> = runs.iter().filter_map(|run| Some(&run.0.get(count.checked_sub(1)?)?.2)).collect();
    let bias_squared = bias_squared(&last, truth);
    let (slope, secs_to_goal) = fit(&levels);
    Ok(WayErrors { way, levels, slope, bias_squared, secs_to_goal })
}

/// The mean over pairs of images of the product of their errors, relative to squared radiance: noise drops out of it.
fn bias_squared(images: &[&Image], [first, second]: [&[[f32; 3]]; 2]) -> f64 {
    let mut products = Vec::new();
    for (index, a) in images.iter().enumerate() {
        for b in &images[index + 1..] {
            let pixels = a.iter().zip(b.iter()).zip(first.iter().zip(second));
            let product = pixels.map(|((a, b), (first, second))| {
                let of = |k: usize| {
                    let [a, b, first, second] = [a[k], b[k], first[k], second[k]].map(f64::from);
                    let truth = 0.5 * (first + second);
                    // Each error is taken from another half, or the truth's own noise would be taken for bias.
                    (a - first) * (b - second) / (truth * truth + DARK)
                };
                (of(0) + of(1) + of(2)) / 3.0
            });
            products.push(product.sum::<f64>() / a.len().max(1) as f64);
        }
    }
    mean(&products).unwrap_or(f64::NAN)
}

/// The exponent of samples that the error follows, and the seconds until it reaches [`GOAL`]: both on lines through the last four levels, as the
/// first are coarse.
fn fit(levels: &[Level]) -> (Option<f64>, Option<f64>) {
    let last = &levels[levels.len().saturating_sub(4)..];
    let of = |value: fn(&Level) -> f64| -> Option<Vec<f64>> {
        last.iter().map(|level| Some(value(level)).filter(|x| *x > 0.0).map(f64::ln)).collect()
    };
    let (Some(samples), Some(secs), Some(error)) = (of(|l| f64::from(l.samples)), of(|l| l.secs), of(|l| l.relmse))
    else {
        return (None, None);
    };
    let slope = line(&samples, &error).map(|line| line.slope);
    let reached = levels.iter().find(|level| level.relmse <= GOAL).map(|level| level.secs);
    let ahead = || {
        let line = line(&secs, &error).filter(|line| line.slope < -0.25)?;
        let at = ((GOAL.ln() - line.intercept) / line.slope).exp();
        at.is_finite().then_some(at)
    };
    (slope, reached.or_else(ahead))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bias_is_told_from_noise() {
        let truth: Image = vec![[1.0; 3]; 1000];
        let noise = |index: usize, step: f64| ((index as f64 * step).fract() - 0.5) as f32;
        let image =
            |step: f64, bias: f32| -> Image { (0..1000).map(|index| [1.0 + bias + noise(index, step); 3]).collect() };
        for (bias, expected) in [(0.0, 0.0), (0.3, 0.09 / 1.01)] {
            let (a, b) = (image(0.618_034, bias), image(0.414_214, bias));
            let found = bias_squared(&[&a, &b], [&truth, &truth]);
            assert!((found - expected).abs() < 5e-3, "{bias}: {found}");
        }
    }

    #[test]
    fn the_goal_is_read_off_or_led_to() {
        let level =
            |samples: u32, relmse: f64| Level { samples, secs: f64::from(samples) * 0.5, relmse, trimmed: relmse };
        let fall = |first: f64| -> Vec<Level> { (0..5).map(|k| level(1 << k, first / f64::from(1 << k))).collect() };
        let (slope, secs) = fit(&fall(0.04));
        assert!((slope.unwrap() + 1.0).abs() < 1e-9 && secs == Some(2.0), "{secs:?}");
        let (_, secs) = fit(&fall(1.0));
        assert!((secs.unwrap() - 50.0).abs() < 1e-6, "{secs:?}");
        // Without an end in sight there is no time.
        assert_eq!(fit(&[level(1, 0.5), level(2, 0.5), level(4, 0.5)]).1, None);
        assert_eq!(fit(&[]), (None, None));
    }
}
