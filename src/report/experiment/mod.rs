//! Error against run time: runs with different seeds, sample counts doubling, held against two independent references.
//!
//! # What is measured
//!
//! A run is one film that grows: the samples at N are the first half of those at 2N. That costs half of what films of their own would,
//! and is what a user sees. The errors along one run are correlated; so whatever has an interval is estimated from each run
//! for itself (a slope), or with each run left out in turn (a bias), and the interval is over the runs, whose seeds make them independent.
//!
//! # Error, bias and variance
//!
//! With an image x, references r₁ and r₂ and r their mean, the squared error of a component is (x − r₁)(x − r₂): the noise of the references
//! drops out of its expectation, and a figure of an image as good as the references can come out negative. It is divided by r² + 0.01 for
//! relMSE. With K runs of mean m and sample variance s², the bias squared is (m − r₁)(m − r₂) − s²/K, without a bias of its own.

mod curve;
pub mod data;
mod pair;
pub mod plan;
mod run;
mod significance;
mod spread;
mod sums;
mod technique;
mod truth;

pub use data::{Bias, Curve, Pair, PairPoint, Plateau, Point, ReferenceAbout, RunPoint, SceneErrors, Slope};
pub use plan::{Effort, Plan};
pub use technique::Technique;

use self::run::{Maker, Run};
use self::truth::Truth;
use super::progress::Progress;
use super::reference;
use super::store::Store;
use crate::export::ExportError;
use crate::measure::MetricError;
use crate::render::fingerprint;
use crate::scene::SceneError;
use crate::scene::camera::Camera;
use crate::tracking::{Mode, Prepared};

/// A mode is called biased beyond this many standard deviations; by chance, one in thirty thousand is.
pub const BIAS_SIGNIFICANCE: f64 = 4.0;

/// Fraction of the whole time that the references take, about.
const SHARE_OF_REFERENCES: f64 = 0.4;

#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Keep(#[from] ExportError),
    /// Images that cannot be held against each other, because a component is not finite.
    #[error("error against run time of `{scene}`: {error}")]
    Metric {
        scene: String,
        #[source]
        error: MetricError,
    },
}

/// Measures a scene as far as `effort` goes, on rayon's current pool. What has been finished is kept in `store`, piece by piece, and found
/// again by the same build of this program. `Ok(None)` where `progress` was cancelled.
///
/// # Errors
/// See [`ExperimentError`].
pub fn scene_errors(
    prepared: &Prepared,
    effort: &Effort,
    store: &Store,
    progress: Progress<'_>,
) -> Result<Option<SceneErrors>, ExperimentError> {
    let camera = Camera::new(&prepared.description.camera)?;
    let settings = Technique::independent().settings(Mode::Rectified, effort.first_seed, effort.max_depth);
    let image = fingerprint(&prepared.description, &camera, effort.size, &settings);
    let inputs = (image, effort, rayon::current_num_threads());
    let plan = || Ok::<_, ExperimentError>(Plan::new(prepared, &camera, effort, &progress));
    let Some(plan) = store.piece("plan", &inputs, plan)? else { return Ok(None) };
    let maker = Maker { prepared, camera: &camera, plan: &plan, store };
    let errors = store.piece("errors", &(image, &plan, rayon::current_num_threads()), || measure(&maker, progress))?;
    if errors.is_some() {
        // The runs, some hundred megabytes of a long measurement, are not needed any more.
        let all = variants().flat_map(|variant| plan.seeds.iter().map(move |&seed| (variant, seed)));
        all.for_each(|((mode, technique), seed)| maker.forget(mode, technique, seed));
    }
    Ok(errors)
}

/// Every mode with independent samples, and the shipped technique.
fn variants() -> impl Iterator<Item = (Mode, Technique)> {
    // A later one that gives the same images as an earlier one is not rendered with every seed.
    // The report's scenes declare nothing: `declared` would be told no more than `naive`.
    let measured = Mode::ALL.into_iter().rev().filter(|mode| !matches!(mode, Mode::Reference | Mode::Declared));
    let independent = measured.map(|mode| (mode, Technique::independent()));
    independent.chain([(Mode::Rectified, Technique::shipped())])
}

fn measure(maker: &Maker<'_>, progress: Progress<'_>) -> Result<Option<SceneErrors>, ExperimentError> {
    let Maker { prepared, camera, plan, store } = *maker;
    let scene = &prepared.description.name;
    let wanted =
        reference::Wanted { prepared, camera, size: plan.size, max_depth: plan.max_depth, spp: plan.reference_spp };
    let of_references = |_: &str, done: f64| {
        (progress.tell)(&format!("{scene}: references"), done * SHARE_OF_REFERENCES);
    };
    let Some(references) = reference::references(&wanted, store, Progress { tell: &of_references, ..progress })? else {
        return Ok(None);
    };
    let Some(measured) = run_all(maker, progress)? else { return Ok(None) };

    let analysed = || -> Result<_, MetricError> {
        let truth = Truth::new(references, plan.size)?;
        let mut curves = Vec::with_capacity(measured.len());
        let mut pairs = Vec::new();
        for variant in &measured {
            let twin = variant.equal_to.and_then(|mode| find(&measured, mode)).unwrap_or(variant);
            curves.push(curve::curve(variant, &twin.runs, plan, &truth)?);
            if let Some(rectified) = find(&measured, Mode::Rectified)
                && variant.mode != Mode::Rectified
                && variant.equal_to.is_none()
            {
                pairs.push(pair::pair(variant.mode, variant.technique, &variant.runs, &rectified.runs, plan, &truth));
            }
        }
        // Stable: the shipped technique stays behind its mode's independent samples.
        curves.sort_by_key(|curve| (curve.technique != Technique::independent(), curve.mode));
        pairs.sort_by_key(|pair| pair.mode);
        let reference::References { spp, render_secs, events, .. } = truth.references;
        let (spp, seeds) = (spp[0].min(spp[1]), reference::SEEDS);
        Ok((curves, pairs, ReferenceAbout { spp, seeds, render_secs, relmse: truth.noise(), events }))
    };
    let (curves, pairs, reference) =
        analysed().map_err(|error| ExperimentError::Metric { scene: scene.clone(), error })?;
    Ok(Some(SceneErrors {
        scene: scene.clone(),
        plan: plan.clone(),
        threads: rayon::current_num_threads(),
        bvh_secs: prepared.seconds.bvh,
        rectify_secs: prepared.seconds.rectify,
        reference,
        curves,
        pairs,
    }))
}

/// A mode with a technique, and its runs.
struct Measured {
    mode: Mode,
    technique: Technique,
    equal_to: Option<Mode>,
    /// Of rectification, in modes that look up what it found.
    secs_before: f64,
    /// With the plan's seeds, or the first of them only where equal to another mode's.
    runs: Vec<Run>,
}

/// The runs with independent samples of a mode.
fn find(measured: &[Measured], mode: Mode) -> Option<&Measured> {
    measured.iter().find(|variant| variant.mode == mode && variant.technique == Technique::independent())
}

/// Seed by seed, all modes in turn, so that what disturbs the machine disturbs all of them. `None` where cancelled.
fn run_all(maker: &Maker<'_>, progress: Progress<'_>) -> Result<Option<Vec<Measured>>, ExportError> {
    let seeds = &maker.plan.seeds;
    let new = |(mode, technique): (Mode, Technique)| {
        let secs_before = if mode.is_rectified() { maker.prepared.seconds.rectify } else { 0.0 };
        Measured { mode, technique, equal_to: None, secs_before, runs: Vec::with_capacity(seeds.len()) }
    };
    let mut measured: Vec<Measured> = variants().map(new).collect();
    for (index, &seed) in seeds.iter().enumerate() {
        for variant in 0..measured.len() {
            let Measured { mode, technique, equal_to, .. } = measured[variant];
            if equal_to.is_some() {
                continue;
            }
            let done = (index as f64 + variant as f64 / measured.len() as f64) / seeds.len() as f64;
            let what = format!("{}: {mode}, seed {seed}", maker.prepared.description.name);
            (progress.tell)(&what, SHARE_OF_REFERENCES + done * (1.0 - SHARE_OF_REFERENCES));
            let Some(run) = maker.run(mode, technique, seed, progress)? else { return Ok(None) };
            if index == 0 {
                let same = |earlier: &&Measured| {
                    earlier.technique == technique && earlier.runs.iter().all(|other| other.has_images_of(&run))
                };
                measured[variant].equal_to = measured[..variant].iter().find(same).map(|earlier| earlier.mode);
            }
            measured[variant].runs.push(run);
        }
    }
    Ok(Some(measured))
}
