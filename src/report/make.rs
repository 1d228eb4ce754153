//! Takes all measurements of a report, one piece after the other; finished pieces are kept and not taken again.

use std::cell::Cell;
use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::backends;
use super::data::{Origin, Report, SceneReport};
use super::editing::{self, EditingError};
use super::estimators;
use super::experiment::{ExperimentError, scene_errors};
use super::extent::{Extent, StabilityPlan};
use super::first_look;
use super::frame_times::FrameTimes;
use super::growth::{self, Growth, GrowthPlan, Quantity};
use super::left_out;
use super::machine::{self, Machine};
use super::pictures;
use super::progress::Progress;
use super::stability::{self, Stability};
use super::store::Store;
use crate::export::ExportError;
use crate::export::words::grouped;
use crate::formats::builtin;
use crate::geometry::Ray;
use crate::measure::MetricError;
use crate::rectify::start::start;
use crate::render::Estimator;
use crate::render::choice::KnownAdapter;
use crate::scene::camera::Camera;
use crate::scene::fingerprint::Hasher;
use crate::scene::{Description, SceneError};
use crate::tracking::{Prepared, prepare};

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    Error,
    Stability,
    LeftOut,
    Editing,
    FirstLook,
    Growth,
    Estimators,
    Backends,
}

impl Part {
    pub const ALL: [Self; 8] = [
        Self::Error,
        Self::Stability,
        Self::LeftOut,
        Self::Editing,
        Self::FirstLook,
        Self::Growth,
        Self::Estimators,
        Self::Backends,
    ];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Stability => "stability",
            Self::LeftOut => "left-out",
            Self::Editing => "editing",
            Self::FirstLook => "first-look",
            Self::Growth => "growth",
            Self::Estimators => "estimators",
            Self::Backends => "backends",
        }
    }
}

impl std::str::FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|part| part.name() == text)
            .ok_or_else(|| format!("unknown part `{text}`; valid parts: {}", Self::ALL.map(Self::name).join(", ")))
    }
}

#[derive(Debug, Clone)]
pub struct Subject {
    /// The built-in scene's name, or the file's stem: short, for headings, tables and names of files.
    pub name: String,
    pub description: Arc<Description>,
}

#[derive(Debug, Clone)]
pub struct Request {
    pub subjects: Vec<Subject>,
    pub parts: Vec<Part>,
    pub extent: Extent,
    pub seed: u64,
    /// As it was typed.
    pub command: String,
    /// What the window has measured of itself.
    pub frames: Option<FrameTimes>,
    /// The graphics processor to measure beside the CPU.
    pub adapter: Option<KnownAdapter>,
}

#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Output(#[from] ExportError),
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    #[error(transparent)]
    Editing(#[from] EditingError),
    #[error("images cannot be compared: {0}")]
    FirstLook(#[from] MetricError),
    #[error("the report was interrupted")]
    Interrupted,
}

/// Takes the measurements that are asked for, on rayon's current pool; what was finished when an error came is in `store`.
///
/// # Errors
/// When a scene is impossible, a piece cannot be kept, or `progress` was cancelled.
pub fn make(request: &Request, store: &Store, progress: &Progress<'_>) -> Result<Report, ReportError> {
    let start = Instant::now();
    let load_before = machine::load_average();
    let prepared: Vec<Prepared> = (request.subjects.iter())
        .map(|subject| prepare(Arc::clone(&subject.description), None))
        .collect::<Result<_, _>>()?;
    let tally = Tally {
        progress: *progress,
        store,
        machine: Machine::here(),
        threads: rayon::current_num_threads(),
        all: weight_of(request),
        done: Cell::new(0.0),
        made: Cell::new(0),
        reused: Cell::new(0),
    };
    let scenes =
        request.subjects.iter().zip(&prepared).map(|(subject, prepared)| scene(request, subject, prepared, &tally));
    let scenes = scenes.collect::<Result<_, _>>()?;
    let stability = request
        .asks_for(Part::Stability, || all_stability(&request.extent.stability, request.adapter.as_ref(), &tally))?;
    let growth = request.asks_for(Part::Growth, || all_growth(&request.extent.growth, &tally))?.unwrap_or_default();
    let origin = Origin {
        program: "iorect",
        version: env!("CARGO_PKG_VERSION"),
        is_optimized: !cfg!(debug_assertions),
        machine: tally.machine,
        adapter: request.used_adapter().map(|adapter| adapter.label.clone()),
        date: machine::now(),
        command: request.command.clone(),
        seed: request.seed,
        threads: tally.threads,
        is_quick: request.extent.is_quick,
        load_before,
        seconds: start.elapsed().as_secs_f64(),
        pieces_reused: tally.reused.get(),
        pieces_made: tally.made.get(),
    };
    Ok(Report { origin, scenes, stability, growth, frames: request.frames.clone() })
}

impl Request {
    /// The graphics processor, where it is measured.
    /// The graphics processor, if any part is measured with it.
    fn used_adapter(&self) -> Option<&KnownAdapter> {
        let is_used = [Part::Backends, Part::Stability, Part::LeftOut].iter().any(|part| self.parts.contains(part));
        self.adapter.as_ref().filter(|_| is_used)
    }

    fn measured_adapter(&self) -> Option<&KnownAdapter> {
        self.adapter.as_ref().filter(|_| self.parts.contains(&Part::Backends))
    }

    /// What `measure` finds, where the part is asked for.
    fn asks_for<T>(
        &self,
        part: Part,
        measure: impl FnOnce() -> Result<T, ReportError>,
    ) -> Result<Option<T>, ReportError> {
        self.parts.contains(&part).then(measure).transpose()
    }
}

/// Work of a request, for the progress bar, in units of about a second of a quick report.
fn weight_of(request: &Request) -> f64 {
    let backends = if request.measured_adapter().is_some() { BACKENDS } else { 0.0 };
    let has = |part: Part| if request.parts.contains(&part) { 1.0 } else { 0.0 };
    let errors = has(Part::Error) * request.extent.errors.secs.min(MOST_ERRORS);
    let scene = PICTURES
        + errors
        + has(Part::LeftOut) * LEFT_OUT
        + has(Part::Editing) * EDITING
        + has(Part::FirstLook) * FIRST_LOOK
        + has(Part::Estimators) * ESTIMATORS
        + backends;
    let checks = stability::cases().len().min(request.extent.stability.cases)
        + stability::sweeps().len().min(request.extent.stability.sweeps)
        + 1
        + of_images(&request.extent.stability).count()
            * (OTHER_ESTIMATORS.len() + usize::from(request.adapter.is_some()));
    let growth: f64 = request.extent.growth.sizes.iter().flatten().map(|&size| weight_of_size(size)).sum();
    request.subjects.len() as f64 * scene + has(Part::Stability) * checks as f64 * CHECK + has(Part::Growth) * growth
}

const PICTURES: f64 = 1.0;
const LEFT_OUT: f64 = 0.5;
const EDITING: f64 = 1.0;
const FIRST_LOOK: f64 = 5.0;
const ESTIMATORS: f64 = 3.0;
const BACKENDS: f64 = 6.0;
const CHECK: f64 = 0.4;
/// Largest weight of error against time.
const MOST_ERRORS: f64 = 1000.0;

fn weight_of_size(size: u64) -> f64 {
    0.2 + size as f64 * 1e-6
}

fn scene(
    request: &Request,
    subject: &Subject,
    prepared: &Prepared,
    tally: &Tally<'_>,
) -> Result<SceneReport, ReportError> {
    let description = &*subject.description;
    let camera = Camera::new(&description.camera)?;
    let mut hasher = Hasher::new("iorect report 1");
    hasher.fingerprint(description.fingerprint());
    camera.hash_into(&mut hasher);
    let fingerprint = hasher.finish();
    let (extent, name) = (&request.extent, &subject.name);
    let pictures =
        tally.piece([name, "pictures"], PICTURES, "pictures", &(fingerprint, extent.pictures), |progress| {
            Ok(pictures::make(prepared, &camera, &extent.pictures, progress)?)
        })?;
    let left_out = request.asks_for(Part::LeftOut, || {
        let what = [name, "what is left out"];
        let label = request.adapter.as_ref().map(|adapter| adapter.label.as_str());
        tally.piece(what, LEFT_OUT, "left-out", &(fingerprint, extent.left_out, label), |progress| {
            Ok(left_out::measure(prepared, &camera, &extent.left_out, request.adapter.as_ref(), progress))
        })
    })?;
    let editing = request.asks_for(Part::Editing, || {
        let what = [name, "from an edit to the picture"];
        tally.piece(what, EDITING, "editing", &(fingerprint, extent.editing), |progress| {
            Ok(editing::measure(&subject.description, &extent.editing, progress)?)
        })
    })?;
    let first_look = request.asks_for(Part::FirstLook, || {
        let what = [name, "the first look"];
        tally.piece(what, FIRST_LOOK, "first-look", &(fingerprint, extent.first_look), |progress| {
            Ok(first_look::measure(prepared, &camera, &first_look::modes(description), &extent.first_look, progress)?)
        })
    })?;
    let estimators = request.asks_for(Part::Estimators, || {
        tally.piece([name, "each estimator"], ESTIMATORS, "estimators", &(fingerprint, extent.estimators), |progress| {
            Ok(estimators::measure(prepared, &camera, &extent.estimators, progress)?)
        })
    })?;
    let backends = request.measured_adapter().map(|adapter| {
        let inputs = (fingerprint, extent.backends, &adapter.label);
        tally.piece([name, "both backends"], BACKENDS, "backends", &inputs, |progress| {
            Ok(backends::measure(prepared, &camera, adapter, &extent.backends, progress))
        })
    });
    let backends = backends.transpose()?;
    // The experiment keeps its pieces by itself.
    let errors = request.asks_for(Part::Error, || {
        tally.part([name, "error against time"], extent.errors.secs.min(MOST_ERRORS), |progress| {
            Ok(scene_errors(prepared, &extent.errors, tally.store, *progress)?)
        })
    })?;
    let scene = &prepared.scene;
    let ray = Ray::new(camera.position - scene.geometry.origin, camera.forward);
    Ok(SceneReport {
        name: name.clone(),
        title: description.name.clone(),
        about: builtin::find(name).map(|builtin| builtin.about.to_owned()),
        refractors: scene.refractors().count(),
        triangles: scene.geometry.triangle_count(),
        spheres: scene.geometry.sphere_count(),
        camera_medium: scene.medium(start(scene, ray).medium).name.clone(),
        build_secs: prepared.seconds.bvh,
        rectify_secs: prepared.seconds.rectify,
        pictures: Some(pictures),
        errors,
        left_out,
        editing,
        first_look,
        estimators,
        backends,
    })
}

fn all_stability(
    plan: &StabilityPlan,
    adapter: Option<&KnownAdapter>,
    tally: &Tally<'_>,
) -> Result<Stability, ReportError> {
    let effort = plan.effort;
    let cases = stability::cases()
        .into_iter()
        .take(plan.cases)
        .map(|case| check(tally, "stability-case", case.name, effort, |subject| case.run(subject)));
    let cases = cases.collect::<Result<_, _>>()?;
    let sweeps = stability::sweeps()
        .into_iter()
        .take(plan.sweeps)
        .map(|sweep| check(tally, "stability-sweep", sweep.name, effort, |subject| sweep.run(subject)));
    let sweeps = sweeps.collect::<Result<_, _>>()?;
    let maps = || check(tally, "stability-maps", "maps of Fresnel's equations", effort, stability::maps);
    let maps = plan.has_maps.then(maps).transpose()?.flatten().unwrap_or_default();
    let by_estimators = OTHER_ESTIMATORS.map(|estimator| {
        let cases = of_images(plan).map(|case| {
            let (inputs, label) = ((effort, case.name, estimator), format!("stability, {estimator}"));
            tally.piece([&label, case.name], CHECK, "stability-case-estimator", &inputs, |progress| {
                let found = case.run(&stability::Subject::estimator(effort, estimator, progress.cancel));
                Ok((!progress.is_cancelled()).then_some(found))
            })
        });
        Ok(stability::ByEstimator { estimator, cases: cases.collect::<Result<_, ReportError>>()? })
    });
    let by_estimators = by_estimators.into_iter().collect::<Result<_, ReportError>>()?;
    let graphics: Option<Result<_, ReportError>> = adapter.map(|adapter| {
        let cases = of_images(plan).map(|case| {
            let inputs = (effort, case.name, &adapter.label);
            tally.piece(["stability, GPU", case.name], CHECK, "stability-case-gpu", &inputs, |progress| {
                let found = case.run(&stability::Subject::graphics(effort, progress.cancel));
                Ok((!progress.is_cancelled()).then_some(found))
            })
        });
        let KnownAdapter { label, is_software } = adapter.clone();
        Ok(stability::Graphics { adapter: label, is_software, cases: cases.collect::<Result<_, _>>()? })
    });
    Ok(Stability { effort, cases, sweeps, maps, by_estimators, graphics: graphics.transpose()? })
}

/// The estimators beside the usual one.
const OTHER_ESTIMATORS: [Estimator; 2] = [Estimator::Bidirectional, Estimator::Merging];

/// The cases that are put to the other estimators and to the graphics processor too.
fn of_images(plan: &StabilityPlan) -> impl Iterator<Item = stability::CaseDefinition> {
    stability::cases().into_iter().take(plan.cases).filter(|case| case.is_of_images)
}

fn check<T: Serialize + DeserializeOwned>(
    tally: &Tally<'_>,
    piece: &str,
    name: &str,
    effort: stability::Effort,
    run: impl FnOnce(&stability::Subject) -> T,
) -> Result<T, ReportError> {
    tally.piece(["stability", name], CHECK, piece, &(effort, name), |progress| {
        let found = run(&stability::Subject::shipped(effort, progress.cancel));
        Ok((!progress.is_cancelled()).then_some(found))
    })
}

fn all_growth(plan: &GrowthPlan, tally: &Tally<'_>) -> Result<Vec<Growth>, ReportError> {
    let of_quantity = |quantity: Quantity| {
        let (possible, too_large) = plan.sizes_of(quantity).iter().partition(|&&size| growth::fits(quantity, size));
        let points = Vec::into_iter(possible).map(|size: u64| {
            let what = format!("{} {}", grouped(size), quantity.name());
            let name = format!("growth-{}-{size}", quantity.name());
            tally.piece(["growth", &what], weight_of_size(size), &name, &plan.timing, |progress| {
                Ok(growth::measure(quantity, size, &plan.timing, progress)?)
            })
        });
        Ok(Growth::of(quantity, points.collect::<Result<_, ReportError>>()?, too_large))
    };
    Quantity::ALL.into_iter().map(of_quantity).collect()
}

/// Progress over all pieces, and how many were made and reused.
struct Tally<'a> {
    progress: Progress<'a>,
    store: &'a Store,
    machine: Machine,
    threads: usize,
    all: f64,
    done: Cell<f64>,
    made: Cell<usize>,
    reused: Cell<usize>,
}

impl Tally<'_> {
    /// A part of that weight of the whole; what it tells of itself is told of `of`.
    fn part<T>(
        &self,
        [of, what]: [&str; 2],
        weight: f64,
        work: impl FnOnce(&Progress<'_>) -> Result<Option<T>, ReportError>,
    ) -> Result<T, ReportError> {
        let (Progress { cancel, tell }, done, all) = (self.progress, self.done.get(), self.all);
        let tell = |what: &str, part: f64| tell(&format!("{of} · {what}"), (done + part * weight) / all);
        tell(what, 0.0);
        let found = if self.progress.is_cancelled() { None } else { work(&Progress { cancel, tell: &tell })? };
        self.done.set(done + weight);
        found.ok_or(ReportError::Interrupted)
    }

    /// A part that is kept or made now.
    fn piece<T: Serialize + DeserializeOwned>(
        &self,
        what: [&str; 2],
        weight: f64,
        name: &str,
        inputs: &impl Serialize,
        make: impl FnOnce(&Progress<'_>) -> Result<Option<T>, ReportError>,
    ) -> Result<T, ReportError> {
        let mut counter = &self.reused;
        let piece = self.part(what, weight, |progress| {
            self.store.piece(name, &(&self.machine, self.threads, inputs), || {
                counter = &self.made;
                make(progress)
            })
        })?;
        counter.set(counter.get() + 1);
        Ok(piece)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_go_by_their_names() {
        assert!(Part::ALL.iter().all(|part| part.name().parse() == Ok(*part)));
        assert!("speed".parse::<Part>().unwrap_err().contains("left-out"));
    }
}
