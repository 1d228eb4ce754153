//! How a check is run: what is put to the test, and what may come of it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::formula::Formula;
use super::outcome::{Case, Effort, Measurement, Outcome, Step, Sweep};
use super::scenes;
use crate::render::{Backend, Estimator, Film, ImageSettings, RenderTask, Unsupported};
use crate::scene::SceneError;
use crate::scene::camera::Camera;
use crate::tracking::{Mode, Prepared};

/// What is put to the test. The shipping code is [`Subject::shipped`]; with other modes or another formula the same checks must fail.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    pub effort: Effort,
    /// Ways of tracking media that must be right.
    pub modes: &'a [Mode],
    pub formula: Formula,
    /// What renders the images.
    pub backend: Backend,
    /// How.
    pub estimator: Estimator,
    /// Set to stop early: what has not been measured by then is not run.
    pub cancel: &'a AtomicBool,
}

impl<'a> Subject<'a> {
    pub fn shipped(effort: Effort, cancel: &'a AtomicBool) -> Self {
        Self {
            effort,
            modes: &[Mode::Rectified, Mode::Reference],
            formula: Formula::Shipped,
            backend: Backend::Cpu,
            estimator: Estimator::Path,
            cancel,
        }
    }

    /// The graphics processor, in the mode that must be right: for [`CaseDefinition::is_of_images`].
    pub fn graphics(effort: Effort, cancel: &'a AtomicBool) -> Self {
        Self { modes: &[Mode::Rectified], backend: Backend::Gpu, ..Self::shipped(effort, cancel) }
    }

    /// Another estimator, in the mode that must be right: for [`CaseDefinition::is_of_images`].
    pub fn estimator(effort: Effort, estimator: Estimator, cancel: &'a AtomicBool) -> Self {
        Self { modes: &[Mode::Rectified], estimator, ..Self::shipped(effort, cancel) }
    }

    /// An image of a scene by its camera.
    pub(super) fn render(
        &self,
        scene: &Prepared,
        mode: Mode,
        size: (u32, u32),
        samples: u32,
        seed: u64,
        max_depth: Option<u32>,
    ) -> Result<Film, Unmeasured> {
        if self.backend == Backend::Cpu {
            return Ok(scenes::render_by(scene, self.estimator, mode, size, samples, seed, max_depth)?);
        }
        let camera = Camera::new(&scene.description.camera)?;
        let usual = ImageSettings { max_depth, ..ImageSettings::new(mode, seed) };
        let settings = ImageSettings { backend: self.backend, splits: 0, ..usual };
        let task = RenderTask { prepared: scene, camera: &camera, settings: &settings };
        task.require()?;
        let mut film = Film::new(size.0, size.1);
        // Never cancelled: these films take a fraction of a second.
        if !task.try_pass(&mut film, samples, &AtomicBool::new(false)) {
            return Err(Unmeasured::Failed);
        }
        Ok(film)
    }

    /// `quick` or `full`, by effort.
    pub(super) fn amount<T>(&self, quick: T, full: T) -> T {
        match self.effort {
            Effort::Quick => quick,
            Effort::Full => full,
        }
    }

    /// Fails when the checks were cancelled.
    pub(super) fn go_on(&self) -> Result<(), Unmeasured> {
        if self.cancel.load(Ordering::Relaxed) { Err(Unmeasured::Cancelled) } else { Ok(()) }
    }

    /// What `measure` finds in each mode, whose name ends what is said of each measurement.
    pub(super) fn in_modes<I: IntoIterator<Item = Measurement>>(
        &self,
        mut measure: impl FnMut(Mode) -> Result<I, Unmeasured>,
    ) -> Measured {
        of_each(self.modes, |&mode| {
            self.go_on()?;
            let of_mode = |m: Measurement| Measurement { what: format!("{}, {mode}", m.what), ..m };
            Ok(measure(mode)?.into_iter().map(of_mode).collect())
        })
    }
}

/// Why there are no measurements.
#[derive(Debug, thiserror::Error)]
pub(super) enum Unmeasured {
    #[error("cancelled")]
    Cancelled,
    #[error("the scene was refused: {0}")]
    Refused(#[from] SceneError),
    #[error("{0}")]
    Unsupported(#[from] Unsupported),
    #[error("the graphics processor has failed")]
    Failed,
}

pub(super) type Measured<T = Measurement> = Result<Vec<T>, Unmeasured>;

/// What `measure` finds of each row, one after the other.
pub(super) fn of_each<R, T>(rows: impl IntoIterator<Item = R>, measure: impl FnMut(R) -> Measured<T>) -> Measured<T> {
    Ok(rows.into_iter().map(measure).collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// The steps of a sweep over these values.
pub(super) fn steps(values: impl IntoIterator<Item = f64>, mut measure: impl FnMut(f64) -> Measured) -> Measured<Step> {
    of_each(values, |x| Ok(measure(x)?.into_iter().map(|measurement| Step::at(x, measurement)).collect()))
}

/// Runs a check: what it found, what came of that, and the seconds that it took.
fn timed<T>(
    subject: &Subject,
    measure: fn(&Subject) -> Measured<T>,
    judge: fn(&[T]) -> Outcome,
) -> (Vec<T>, Outcome, f64) {
    let start = Instant::now();
    let (found, outcome) = match subject.go_on().and_then(|()| measure(subject)) {
        Ok(found) => {
            let outcome = judge(&found);
            (found, outcome)
        }
        Err(why @ Unmeasured::Refused(_)) => (Vec::new(), Outcome::Failed { reason: why.to_string() }),
        Err(why) => (Vec::new(), Outcome::NotRun { reason: why.to_string() }),
    };
    (found, outcome, start.elapsed().as_secs_f64())
}

#[derive(Debug, Clone, Copy)]
pub struct CaseDefinition {
    /// As in [`Case`].
    pub number: Option<u32>,
    pub name: &'static str,
    pub source: &'static str,
    pub(super) measure: fn(&Subject) -> Measured,
    /// Whether everything is measured in images, so that any backend and any estimator can be put to the test.
    pub is_of_images: bool,
}

/// A case of the forty.
pub(super) const fn case(
    number: u32,
    name: &'static str,
    source: &'static str,
    measure: fn(&Subject) -> Measured,
) -> CaseDefinition {
    CaseDefinition { number: Some(number), name, source, measure, is_of_images: false }
}

impl CaseDefinition {
    /// The same, all of which is measured in images.
    pub(super) const fn of_images(self) -> Self {
        Self { is_of_images: true, ..self }
    }

    pub fn run(&self, subject: &Subject) -> Case {
        let (measurements, outcome, seconds) = timed(subject, self.measure, |found| Outcome::of(found));
        let (name, source) = (self.name.to_owned(), self.source.to_owned());
        Case { number: self.number, name, source, measurements, outcome, seconds }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct SweepDefinition {
    pub name: &'static str,
    pub about: &'static str,
    pub parameter: &'static str,
    pub(super) measure: fn(&Subject) -> Measured<Step>,
}

impl SweepDefinition {
    pub fn run(&self, subject: &Subject) -> Sweep {
        let (steps, outcome, seconds) = timed(subject, self.measure, Outcome::of_steps);
        let [name, about, parameter] = [self.name, self.about, self.parameter].map(str::to_owned);
        Sweep { name, about, parameter, steps, outcome, seconds }
    }
}
