//! What is known about a scene once it has been measured: plain data, for a page, a table or a file.
//!
//! Errors are relMSE unless they say otherwise: squares of differences over the reference's square plus 0.01, see [`crate::measure`].

use serde::{Deserialize, Serialize};

use super::plan::Plan;
use super::technique::Technique;
use crate::measure::Interval;
use crate::tracking::Events;
use crate::tracking::Mode;

/// Error against run time of one scene, in all modes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneErrors {
    /// The scene's own name.
    pub scene: String,
    pub plan: Plan,
    pub threads: usize,
    /// Building the tree, which every mode needs. In no curve's time.
    pub bvh_secs: f64,
    /// Rectification as a whole. In the time of those modes that use it: see [`Curve::secs_before`].
    pub rectify_secs: f64,
    pub reference: ReferenceAbout,
    /// In the order in which modes deserve trust; last the default technique of `rectified`.
    pub curves: Vec<Curve>,
    /// Each mode that differs from `rectified`, against it.
    pub pairs: Vec<Pair>,
}

/// The two references that errors are taken against.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReferenceAbout {
    /// Samples per pixel of each: what the plan says, or more where more were kept.
    pub spp: u32,
    pub seeds: [u64; 2],
    /// Both together. Of an earlier day where they were kept.
    pub render_secs: f64,
    /// Noise of one of them in relMSE, from how far the two are apart. Errors have none of it in expectation.
    pub relmse: f64,
    pub events: Events,
}

/// Error of one mode with one technique, sample counts doubling.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    pub mode: Mode,
    pub technique: Technique,
    /// The mode whose images these were equal to, to the bit, with the first seed and at every sample count. Other seeds were not
    /// rendered again: all below is that mode's, seconds of rendering too; only `secs_before`, which every time counts in, is its own. So
    /// such curves say nothing of how fast one mode is beside the other.
    pub equal_to: Option<Mode>,
    /// Seconds that the mode needs before its first sample, counted in all its times: rectification where it is used, else 0.
    pub secs_before: f64,
    /// By rising sample count.
    pub points: Vec<Point>,
    /// How the trimmed relMSE falls, where it does.
    pub slope: Option<Slope>,
    pub bias: Bias,
    /// Where a biased mode stops to improve.
    pub plateau: Option<Plateau>,
    /// Of all runs together.
    pub events: Events,
}

/// Runs with different seeds at one sample count. Intervals are over the seeds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    pub spp: u32,
    /// Geometric mean over the runs, [`Curve::secs_before`] included.
    pub secs: f64,
    /// Geometric means with t-intervals on the logarithm. `None` where a run's error came out at or below 0, which reference noise can do.
    pub relmse: Option<Interval>,
    /// Without the worst 0.1 % of pixels of each run.
    pub relmse_trimmed: Option<Interval>,
    pub mse: Option<Interval>,
    pub smape: Option<Interval>,
    /// Mean HDR-FLIP.
    pub flip: Option<Interval>,
    /// Of one run: expected relMSE that other seeds would not share.
    pub variance: f64,
    /// What all seeds share. Unbiased, so without a bias it scatters about 0.
    pub bias_squared: f64,
    /// 1/(relMSE · seconds), `secs_before` not included, so that it stays the same along an unbiased curve.
    pub efficiency: Option<Interval>,
    pub runs: Vec<RunPoint>,
}

/// One run at one sample count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RunPoint {
    pub seed: u64,
    /// Rendering alone.
    pub render_secs: f64,
    pub relmse: f64,
    pub relmse_trimmed: f64,
    /// relMSE without the 0.1 % of pixels in which this run's four quarters differ the most: the same pixels at every sample count, chosen for
    /// being unsteady and not for being wrong. Slopes are of this figure.
    pub relmse_steady: f64,
    pub mse: f64,
    pub smape: f64,
    pub flip: Option<f64>,
}

/// error ∝ samples^slope. Each is fitted to every run for itself, and the interval is over the runs. Of an unbiased mode with independent
/// samples −1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    /// Of the relMSE trimmed of the same 0.1 % of pixels all along: [`RunPoint::relmse_steady`].
    pub trimmed: Interval,
    /// Of the trimmed relMSE whose pixels are chosen anew at each sample count. Its expectation does not fall as 1/samples: while bright rare
    /// paths have reached few pixels, those are left out with all that they add, and later they are too many to be.
    pub trimmed_anew: Option<Interval>,
    /// Of the relMSE with all pixels. Unbiased; but a few bright ones can decide it, so that the t-interval promises too much.
    pub untrimmed: Option<Interval>,
    /// As `trimmed`, against seconds of rendering, which other programs on the machine can disturb.
    pub by_secs: Option<Interval>,
    /// Sample counts of the first and last point that the line goes through.
    pub from_spp: u32,
    pub to_spp: u32,
}

/// What the mean over the seeds says about what all runs share, at the greatest sample count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bias {
    /// bias² in relMSE. Its interval allows for the noise of runs and references.
    pub squared: Interval,
    /// bias² in radiance².
    pub squared_mse: f64,
    /// bias² without the worst 0.1 % of pixels.
    pub squared_trimmed: f64,
    /// A test of its own for whether there is a bias at all, in standard deviations of what chance does; far more sensitive than whether the
    /// interval of `squared` reaches 0.
    pub significance: f64,
    /// Whether `significance` is beyond [`super::BIAS_SIGNIFICANCE`].
    pub is_biased: bool,
    /// Mean of image − reference over all pixels and channels, as a share of the reference's mean: how much too bright.
    pub brightness: f64,
}

/// Where the error of a biased mode stays.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Plateau {
    /// bias² in relMSE.
    pub relmse: Interval,
    /// bias² without the worst 0.1 % of pixels.
    pub relmse_trimmed: f64,
    /// Samples per pixel at which noise is as large as bias: the median over all sample counts, since a bright path that few runs met can
    /// multiply the variance at one.
    pub spp: f64,
    /// When that is, `secs_before` included.
    pub secs: f64,
    /// relMSE at the greatest sample count, as measured on every other seed, over what the remaining seeds' bias and variance predict.
    /// 1 where the plateau lies where the bias says.
    pub measured_over_predicted: Option<Interval>,
}

/// The difference of two modes, rendered with the same random numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    pub mode: Mode,
    /// Always `rectified` so far.
    pub against: Mode,
    pub technique: Technique,
    pub points: Vec<PairPoint>,
    /// How many times sooner than `mode`'s own image the image of the difference has the same absolute error: its variance over the
    /// difference's, at the greatest sample count.
    pub sooner_than_mode: Option<Interval>,
    pub sooner_than_against: Option<Interval>,
    /// The same against the difference of two images with unrelated random numbers.
    pub sooner_than_unpaired: Option<Interval>,
}

/// Variances of one run, mean over pixels and channels, divided by the reference's square plus 0.01 as in relMSE.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PairPoint {
    pub spp: u32,
    pub of_mode: f64,
    pub of_against: f64,
    pub of_difference: f64,
}
