//! Whether the lanes render by the graphics processor. A thread looks for one, compiles for it and, where nobody has chosen, measures it,
//! while the CPU renders; films that are not finished by then begin anew.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::job::{Job, LaneMessage};
use super::mailbox::{Mailbox, Taken};
use super::{Board, News, Wake};
use crate::render::choice::{self, KnownAdapter, Work, choose};
use crate::render::{Backend, BackendChoice, Chosen, ImageSettings};
use crate::scene::description::Source;

/// What is known of the graphics processor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GraphicsStatus {
    /// The one that would be used, or why there is none and what to do.
    pub adapter: Result<KnownAdapter, String>,
    /// Whether it renders, or would if there were something to do.
    pub is_used: bool,
    /// Why it does not, where it was not simply told not to.
    pub reason: Option<String>,
    /// What went wrong with it since the program began; the CPU has gone on.
    pub fault: Option<String>,
}

/// What was decided about one scene.
#[derive(Debug, Clone)]
struct Decision {
    asked: BackendChoice,
    scene: Option<Arc<Source>>,
    chosen: Chosen,
}

impl Decision {
    fn is_about(&self, job: &Job) -> bool {
        job.is_of(self.scene.as_ref()) && self.asked == job.request.backend
    }
}

/// The decision that all lanes follow.
#[derive(Debug, Default)]
pub(super) struct Graphics(Mutex<Known>);

#[derive(Debug, Default)]
struct Known {
    decision: Option<Decision>,
    /// Of the graphics processor, while it rendered for these lanes.
    fault: Option<String>,
    /// Whether the graphics processor computes on the CPU.
    is_software: bool,
}

impl Graphics {
    fn lock(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the graphics processor computes on the CPU.
    pub(super) fn is_software(&self) -> bool {
        self.lock().is_software
    }

    /// How the films of a job are rendered.
    pub(super) fn settings(&self, job: &Job) -> ImageSettings {
        let usual = ImageSettings { backend: Backend::Cpu, ..job.request.settings };
        let decision = self.lock().decision.clone().filter(|decision| decision.is_about(job));
        let chosen = decision.map(|decision| decision.chosen).filter(|chosen| chosen.backend == Backend::Gpu);
        // What is compiled for one scene, with one set of modes, need not be all that another one needs.
        match chosen.filter(|_| with_work(job, |work| work.is_ready())) {
            Some(chosen) => ImageSettings { backend: chosen.backend, ..chosen.settings(usual) },
            None => usual,
        }
    }

    /// Whether the films of a job, which are being rendered, would be rendered otherwise now: by the graphics processor.
    pub(super) fn changes(&self, job: &Job) -> bool {
        job.request.settings.backend == Backend::Cpu
            && job.request.backend != BackendChoice::Cpu
            && self.settings(job).backend == Backend::Gpu
    }

    /// Publishes that the graphics processor has failed, once.
    pub(super) fn notice_fault(&self, board: &Board, wake: &Wake) {
        let mut known = self.lock();
        let used = known.decision.as_mut().filter(|decision| decision.chosen.backend == Backend::Gpu);
        let (Some(decision), Some(fault)) = (used, choice::fault()) else { return };
        decision.chosen = Chosen::cpu(Some(fault.clone()));
        known.fault = Some(fault.clone());
        drop(known);
        let mut state = board.lock();
        if let Some(status) = &state.graphics {
            let status = GraphicsStatus { is_used: false, fault: Some(fault), ..GraphicsStatus::clone(status) };
            state.graphics = Some(Arc::new(status));
        }
        drop(state);
        wake(News::Scene);
    }
}

/// Hands the images of a job that the graphics processor might render to `use_work`.
fn with_work<T>(job: &Job, use_work: impl FnOnce(Work<'_>) -> T) -> T {
    let settings: Vec<ImageSettings> =
        job.modes.iter().map(|&mode| job.settings(mode, job.request.settings.seed)).collect();
    let (prepared, camera, size) = (&job.prepared, &job.camera, job.request.size);
    use_work(Work { prepared, camera, settings: &settings, size, samples: None })
}

/// Decides for the jobs in the mailbox until it is closed.
pub(super) fn run_graphics(mailbox: &Mailbox<LaneMessage>, board: &Board, wake: &Wake, graphics: &Graphics) {
    let mut choices = None;
    loop {
        let job = match mailbox.wait(None) {
            Taken::Closed => return,
            Taken::Message(Some(job)) => job,
            Taken::Message(None) | Taken::Empty => continue,
        };
        // Who chooses anew after a fault wants to try again.
        if choices.is_some_and(|before| before != job.request.backend_choices) {
            choice::renew();
            *graphics.lock() = Known::default();
        }
        choices = Some(job.request.backend_choices);
        if job.request.backend == BackendChoice::Cpu {
            // Then nobody needs to know.
            graphics.lock().decision = None;
            continue;
        }
        let adapter = choice::adapter().map_err(|error| error.to_string());
        graphics.lock().is_software = adapter.as_ref().is_ok_and(|adapter| adapter.is_software);
        let known = graphics.lock().decision.clone().filter(|decision| decision.is_about(&job));
        let chosen = match (&adapter, job.request.backend) {
            (Err(reason), _) => Chosen::cpu(Some(reason.clone())),
            (Ok(adapter), BackendChoice::Auto) if adapter.is_software => Chosen::cpu(Some(adapter.as_slow())),
            _ => match known.map(|decision| decision.chosen) {
                // Measured once in a scene, and not while there is nothing to measure.
                Some(chosen) if job.request.backend == BackendChoice::Auto || job.modes.is_empty() => chosen,
                _ if job.modes.is_empty() => continue,
                _ => with_work(&job, |work| choose(job.request.backend, &work))
                    .unwrap_or_else(|error| Chosen::cpu(Some(error.to_string()))),
            },
        };
        // Another set of modes, or an edit, may need other shaders.
        let is_ready = match chosen.backend {
            Backend::Gpu => with_work(&job, |work| work.make_ready()),
            _ => Ok(()),
        };
        let chosen = is_ready.map_or_else(|reason| Chosen::cpu(Some(reason)), |()| chosen);
        let status = GraphicsStatus {
            adapter,
            is_used: chosen.backend == Backend::Gpu,
            reason: chosen.reason.clone(),
            fault: graphics.lock().fault.clone(),
        };
        let scene = job.prepared.description.source.clone();
        graphics.lock().decision = Some(Decision { asked: job.request.backend, scene, chosen });
        let mut state = board.lock();
        let is_news = state.graphics.as_deref() != Some(&status);
        state.graphics = Some(Arc::new(status));
        drop(state);
        if is_news {
            wake(News::Scene);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;
    use crate::render::EstimatorChoice;
    use crate::scene::camera::Camera;
    use crate::session::{GroundTruthDemand, Request};
    use crate::tracking::{Mode, prepare};

    fn job(scene: &str, modes: &[Mode], backend: BackendChoice) -> Job {
        let description = Arc::new(crate::formats::open(scene).unwrap());
        Job {
            prepared: prepare(Arc::clone(&description), None).unwrap(),
            camera: Camera::new(&description.camera).unwrap(),
            modes: modes.to_vec(),
            request: Request {
                epoch: 1,
                restarts: 0,
                camera: description.camera,
                description,
                modes: modes.to_vec(),
                surfaces: Vec::new(),
                size: [8, 8],
                settings: ImageSettings::new(Mode::Rectified, 0),
                estimator: EstimatorChoice::Path,
                backend,
                backend_choices: 0,
                sample_limit: None,
                noise_target: None,
                is_paused: false,
                ground_truth: GroundTruthDemand::Off,
            },
            asked_at: Instant::now(),
        }
    }

    /// What is decided holds for the scene and the choice that it was decided for.
    #[test]
    fn lanes_follow_the_decision_about_their_scene() {
        // Beside films of the graphics processor the reference, which needs none, takes the same samples.
        let asked = job("plain-glass", &[Mode::Reference], BackendChoice::Gpu);
        let graphics = Graphics::default();
        assert_eq!(graphics.settings(&asked), asked.request.settings);
        assert!(!graphics.changes(&asked));
        let chosen = Chosen { backend: Backend::Gpu, adapter: Some("Card".into()), reason: None };
        let scene = asked.prepared.description.source.clone();
        graphics.lock().decision = Some(Decision { asked: BackendChoice::Gpu, scene, chosen });
        let settings = graphics.settings(&asked);
        assert_eq!((settings.backend, settings.splits), (Backend::Gpu, 0));
        assert!(graphics.changes(&asked));
        let begun = Job { request: Request { settings, ..asked.request.clone() }, ..asked.clone() };
        assert!(!graphics.changes(&begun));
        assert_eq!(begun.settings(Mode::Reference, 0).backend, Backend::Cpu);
        // Neither for another choice nor for another scene.
        let by_cpu = Job { request: Request { backend: BackendChoice::Cpu, ..asked.request.clone() }, ..asked };
        let other = job("nested-spheres", &[Mode::Reference], BackendChoice::Gpu);
        assert!([by_cpu, other].iter().all(|job| graphics.settings(job).backend == Backend::Cpu));
    }
}
