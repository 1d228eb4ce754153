//! Takes all measurements of a report, one piece after the other; finished pieces are kept and not taken again.

use std::cell::Cell;
use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::data::{Origin, Report, SceneReport};
use super::editing::{self, EditingError};
use super::experiment::{ExperimentError, SceneErrors, scene_errors};
use super::extent::{Extent, StabilityPlan};
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
use crate::rectify::start::start;
use crate::scene::camera::Camera;
use crate::scene::fingerprint::Hasher;
use crate::scene::{Description, SceneError};
use crate::tracking::{Prepared, prepare};

/// What a report can be about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    Error,
    Stability,
    LeftOut,
    Editing,
    Growth,
}

impl Part {
    pub const ALL: [Self; 5] = [Self::Error, Self::Stability, Self::LeftOut, Self::Editing, Self::Growth];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Stability => "stability",
            Self::LeftOut => "left-out",
            Self::Editing => "editing",
            Self::Growth => "growth",
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

/// A scene to be measured.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The built-in scene's name, or the file's stem: short, for headings, tables and names of files.
    pub name: String,
    pub description: Arc<Description>,
}

/// What is asked for.
#[derive(Debug, Clone)]
pub struct Request {
    pub subjects: Vec<Subject>,
    pub parts: Vec<Part>,
    pub extent: Extent,
    pub seed: u64,
    /// As it was typed.
    pub command: String,
}

/// A report that could not be made.
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
}

/// Takes the measurements that are asked for, on rayon's current pool. `None` when cancelled; what was finished by then is in `store`.
///
/// # Errors
/// When a scene is impossible, or a piece cannot be kept.
pub fn make(request: &Request, store: &Store, progress: &Progress<'_>) -> Result<Option<Report>, ReportError> {
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
    let mut scenes = Vec::new();
    for (subject, prepared) in request.subjects.iter().zip(&prepared) {
        match scene(request, subject, prepared, &tally)? {
            Some(scene) => scenes.push(scene),
            None => return Ok(None),
        }
    }
    let stability = if request.parts.contains(&Part::Stability) {
        let found = all_stability(&request.extent.stability, &tally)?;
        if found.is_none() {
            return Ok(None);
        }
        found
    } else {
        None
    };
    let growth = if request.parts.contains(&Part::Growth) {
        match all_growth(&request.extent.growth, &tally)? {
            Some(growth) => growth,
            None => return Ok(None),
        }
    } else {
        Vec::new()
    };
    let origin = Origin {
        program: "iorect",
        version: env!("CARGO_PKG_VERSION"),
        is_optimized: !cfg!(debug_assertions),
        machine: tally.machine,
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
    Ok(Some(Report { origin, scenes, stability, growth }))
}

/// Work of a request, for the progress bar, in units of about a second of a quick report.
fn weight_of(request: &Request) -> f64 {
    let has = |part: Part| if request.parts.contains(&part) { 1.0 } else { 0.0 };
    let sizes = Quantity::ALL.iter().flat_map(|&quantity| request.extent.growth.sizes(quantity));
    let errors = has(Part::Error) * request.extent.errors.secs.min(MOST_ERRORS);
    let scene = PICTURES + errors + has(Part::LeftOut) * LEFT_OUT + has(Part::Editing) * EDITING;
    let checks = stability::cases().len().min(request.extent.stability.cases)
        + stability::sweeps().len().min(request.extent.stability.sweeps)
        + 1;
    let growth = sizes.map(|&size| weight_of_size(size)).sum::<f64>();
    request.subjects.len() as f64 * scene + has(Part::Stability) * checks as f64 * CHECK + has(Part::Growth) * growth
}

const PICTURES: f64 = 1.0;
const LEFT_OUT: f64 = 0.5;
const EDITING: f64 = 1.0;
const CHECK: f64 = 0.4;
/// Largest weight of error against time.
const MOST_ERRORS: f64 = 1000.0;

fn weight_of_size(size: u64) -> f64 {
    0.2 + size as f64 * 1e-6
}

/// One scene; `None` when cancelled.
fn scene(
    request: &Request,
    subject: &Subject,
    prepared: &Prepared,
    tally: &Tally<'_>,
) -> Result<Option<SceneReport>, ReportError> {
    let description = &*subject.description;
    let camera = Camera::new(&description.camera)?;
    let mut hasher = Hasher::new("iorect report 1");
    hasher.fingerprint(description.fingerprint());
    camera.hash_into(&mut hasher);
    let fingerprint = hasher.finish();
    let extent = &request.extent;
    let label = |what: &str| format!("{} · {what}", subject.name);
    let pictures =
        tally.piece(&label("pictures"), PICTURES, "pictures", &(fingerprint, extent.pictures), |progress| {
            Ok(pictures::make(prepared, &camera, &extent.pictures, progress)?)
        })?;
    let Some(pictures) = pictures else { return Ok(None) };
    let mut left_out = None;
    if request.parts.contains(&Part::LeftOut) {
        left_out = tally.piece(
            &label("what is left out"),
            LEFT_OUT,
            "left-out",
            &(fingerprint, extent.left_out),
            |progress| Ok(left_out::measure(prepared, &camera, &extent.left_out, progress)),
        )?;
        if left_out.is_none() {
            return Ok(None);
        }
    }
    let mut editing = None;
    if request.parts.contains(&Part::Editing) {
        let what = label("from an edit to the picture");
        editing = tally.piece(&what, EDITING, "editing", &(fingerprint, extent.editing), |progress| {
            Ok(editing::measure(&subject.description, &extent.editing, progress)?)
        })?;
        if editing.is_none() {
            return Ok(None);
        }
    }
    let mut found = None;
    if request.parts.contains(&Part::Error) {
        found = errors(request, subject, prepared, tally)?;
        if found.is_none() {
            return Ok(None);
        }
    }
    let scene = &prepared.scene;
    let ray = Ray::new(camera.position - scene.geometry.origin, camera.forward);
    Ok(Some(SceneReport {
        name: subject.name.clone(),
        title: description.name.clone(),
        about: builtin::find(&subject.name).map(|builtin| builtin.about.to_owned()),
        refractors: scene.refractors().count(),
        triangles: scene.geometry.triangle_count(),
        spheres: scene.geometry.sphere_count(),
        camera_medium: scene.medium(start(scene, ray).medium).name.clone(),
        build_secs: prepared.seconds.bvh,
        rectify_secs: prepared.seconds.rectify,
        pictures: Some(pictures),
        errors: found,
        left_out,
        editing,
    }))
}

/// Error against run time, whose pieces the experiment keeps by itself; `None` when cancelled.
fn errors(
    request: &Request,
    subject: &Subject,
    prepared: &Prepared,
    tally: &Tally<'_>,
) -> Result<Option<SceneErrors>, ReportError> {
    let (done, all, tell) = (tally.done.get(), tally.all, tally.progress.tell);
    let weight = request.extent.errors.secs.min(MOST_ERRORS);
    let name = &subject.name;
    tell(&format!("{name} · error against time"), done / all);
    if tally.progress.is_cancelled() {
        return Ok(None);
    }
    let within = |what: &str, part: f64| tell(&format!("{name} · {what}"), (done + part * weight) / all);
    let progress = Progress { cancel: tally.progress.cancel, tell: &within };
    let found = scene_errors(prepared, &request.extent.errors, tally.store, progress)?;
    tally.done.set(done + weight);
    Ok(found)
}

/// Cases, sweeps and maps, each a piece; `None` when cancelled.
fn all_stability(plan: &StabilityPlan, tally: &Tally<'_>) -> Result<Option<Stability>, ReportError> {
    let (mut cases, mut sweeps) = (Vec::new(), Vec::new());
    for definition in stability::cases().iter().take(plan.cases) {
        let what = format!("stability · {}", definition.name);
        let case = tally.piece(&what, CHECK, "stability-case", &(plan.effort, definition.name), |progress| {
            let case = definition.run(&stability::Subject::shipped(plan.effort, progress.cancel));
            Ok((!progress.is_cancelled()).then_some(case))
        })?;
        match case {
            Some(case) => cases.push(case),
            None => return Ok(None),
        }
    }
    for definition in stability::sweeps().iter().take(plan.sweeps) {
        let what = format!("stability · {}", definition.name);
        let sweep = tally.piece(&what, CHECK, "stability-sweep", &(plan.effort, definition.name), |progress| {
            let sweep = definition.run(&stability::Subject::shipped(plan.effort, progress.cancel));
            Ok((!progress.is_cancelled()).then_some(sweep))
        })?;
        match sweep {
            Some(sweep) => sweeps.push(sweep),
            None => return Ok(None),
        }
    }
    let mut maps = Vec::new();
    if plan.has_maps {
        let what = "stability · maps of Fresnel's equations";
        let made = tally.piece(what, CHECK, "stability-maps", &plan.effort, |progress| {
            Ok(stability::maps(&stability::Subject::shipped(plan.effort, progress.cancel)))
        })?;
        match made {
            Some(made) => maps = made,
            None => return Ok(None),
        }
    }
    Ok(Some(Stability { effort: plan.effort, cases, sweeps, maps }))
}

/// Every quantity; `None` when cancelled.
fn all_growth(plan: &GrowthPlan, tally: &Tally<'_>) -> Result<Option<Vec<Growth>>, ReportError> {
    let mut all = Vec::new();
    for quantity in Quantity::ALL {
        let (mut points, mut too_large) = (Vec::new(), Vec::new());
        for &size in plan.sizes(quantity) {
            if !growth::fits(quantity, size) {
                too_large.push(size);
                continue;
            }
            let what = format!("growth · {} {}", grouped(size), quantity.name());
            let name = format!("growth-{}-{size}", quantity.name());
            // The other sizes do not decide this one's result.
            let inputs =
                GrowthPlan { triangles: vec![], nesting: vec![], objects: vec![], threads: vec![], ..plan.clone() };
            let point = tally.piece(&what, weight_of_size(size), &name, &inputs, |progress| {
                Ok(growth::measure(quantity, size, plan, progress)?)
            })?;
            match point {
                Some(point) => points.push(point),
                None => return Ok(None),
            }
        }
        all.push(Growth::of(quantity, points, too_large));
    }
    Ok(Some(all))
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
    /// A piece of that weight, kept or made now.
    fn piece<T: Serialize + DeserializeOwned>(
        &self,
        what: &str,
        weight: f64,
        name: &str,
        inputs: &impl Serialize,
        make: impl FnOnce(&Progress<'_>) -> Result<Option<T>, ReportError>,
    ) -> Result<Option<T>, ReportError> {
        let (done, all, tell) = (self.done.get(), self.all, self.progress.tell);
        tell(what, done / all);
        if self.progress.is_cancelled() {
            return Ok(None);
        }
        let mut is_made = false;
        let piece = self.store.piece(name, &(&self.machine, self.threads, inputs), || {
            is_made = true;
            let within = |_: &str, part: f64| tell(what, (done + part * weight) / all);
            make(&Progress { cancel: self.progress.cancel, tell: &within })
        })?;
        let counter = if is_made { &self.made } else { &self.reused };
        counter.set(counter.get() + usize::from(piece.is_some()));
        self.done.set(done + weight);
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
