//! The thread that prepares scenes and tells the lanes what to render.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::estimators::Estimators;
use super::job::{Asked, Job, LaneMessage};
use super::mailbox::{Mailbox, Taken};
use super::preparation::watched;
use super::{Board, GroundTruthDemand, News, Preparation, Request, SceneReport, Wake, guarded};
use crate::check::{Problem, check_watched};
use crate::rectify::Progress;
use crate::scene::SceneError;
use crate::scene::camera::Camera;
use crate::tracking::Mode;
use crate::tracking::Prepared;

/// What the lanes are told: main, reference, surfaces, ground truth, graphics.
pub(super) type Lanes = [Arc<Mailbox<LaneMessage>>; 5];

/// Requests of a drag follow each other faster than this: what can wait is done when there is none for so long.
const QUIET: Duration = Duration::from_millis(80);
/// Pre-traces of a scene beyond the first, done while nothing else is wanted.
pub(super) const REPEATS: u32 = 8;

/// What can be done about a scene while nobody asks for anything else: look for problems, then shoot more rays.
struct Leisure {
    epoch: u64,
    is_checked: bool,
    repeats: u32,
    is_paused: bool,
}

impl Leisure {
    fn is_over(&self) -> bool {
        self.is_checked && (self.is_paused || self.repeats >= REPEATS)
    }

    /// One piece of work. Returns the scene as it is known now, and its problems if they have been looked for; `None` where a request
    /// came in between.
    fn work(&mut self, prepared: &Prepared, requests: &Mailbox<Asked>) -> Option<(Prepared, Option<Vec<Problem>>)> {
        let progress = Progress::new();
        let mut outcome = None;
        watched(requests, Instant::now(), |_| true, &progress, || outcome = Some(self.piece(prepared, &progress)));
        outcome.filter(|_| !progress.is_cancelled())
    }

    /// The work itself. Worthless once `progress` is cancelled.
    fn piece(&mut self, prepared: &Prepared, progress: &Progress) -> (Prepared, Option<Vec<Problem>>) {
        if !self.is_checked {
            let problems = guarded(|| Ok(check_watched(prepared, progress).unwrap_or_default())).unwrap_or_default();
            self.is_checked = !progress.is_cancelled();
            return (prepared.clone(), Some(problems));
        }
        self.repeats += 1;
        // Fresh directions: their votes are added, and what one ray in a million has missed may be seen now. Nobody has asked for this:
        // where it fails, the scene stays as it is known.
        let Ok(Ok(table)) = guarded(|| Ok(prepared.table.repeated_watched(&prepared.scene, progress))) else {
            return (prepared.clone(), None);
        };
        // Other answers may have other problems.
        self.is_checked = table.says_the_same(&prepared.table);
        table.containers(&prepared.scene);
        (Prepared { table: Arc::new(table), ..prepared.clone() }, None)
    }
}

/// Serves requests until the mailbox is closed.
pub(super) fn prepare_scenes(requests: &Mailbox<Asked>, lanes: &Lanes, board: &Board, wake: &Wake) {
    let mut current: Option<Prepared> = None;
    let mut leisure: Option<Leisure> = None;
    let mut estimators = Estimators::default();
    loop {
        let is_free = leisure.as_ref().is_some_and(|leisure| !leisure.is_over());
        let Asked { request, at: asked_at } = match requests.wait(is_free.then_some(QUIET)) {
            Taken::Message(asked) => asked,
            Taken::Closed => return,
            Taken::Empty => {
                if let (Some(leisure), Some(prepared)) = (&mut leisure, &mut current) {
                    let Some((known, problems)) = leisure.work(prepared, requests) else { continue };
                    *prepared = known.clone();
                    let mut state = board.lock();
                    let problems = problems.or_else(|| state.scene.as_ref().and_then(|scene| scene.problems.clone()));
                    state.scene = Some(Arc::new(SceneReport { epoch: leisure.epoch, prepared: known, problems }));
                    drop(state);
                    wake(News::Scene);
                }
                continue;
            }
        };
        let is_new = current.as_ref().is_none_or(|p| !Arc::ptr_eq(&p.description, &request.description));
        let outcome = guarded(|| {
            let camera = Camera::new(&request.camera)?;
            if is_new {
                // All cores for the preparation: what is being rendered is out of date.
                lanes.iter().for_each(|lane| lane.post(None));
                let preparation = Arc::new(Preparation::new(request.epoch));
                board.lock().preparation = Some(Arc::clone(&preparation));
                wake(News::Scene);
                let prepared = preparation.run(&request.description, current.as_ref(), requests)?;
                // The tree of objects is drawn from these, and nothing may wait for them then.
                prepared.iter().for_each(|prepared| _ = prepared.table.containers(&prepared.scene));
                Ok(prepared.map(|prepared| (camera, prepared)))
            } else {
                current.clone().map(|prepared| Some((camera, prepared))).ok_or_else(|| SceneError::new("no scene"))
            }
        });
        board.lock().preparation = None;
        let (camera, prepared) = match outcome {
            Ok(Some(ready)) => ready,
            // A newer request has cancelled it.
            Ok(None) => continue,
            Err(error) => {
                board.fail(request.epoch, error, wake);
                continue;
            }
        };
        if is_new {
            let report = SceneReport { epoch: request.epoch, prepared: prepared.clone(), problems: None };
            board.lock().scene = Some(Arc::new(report));
            wake(News::Scene);
        }
        let request = Request { settings: estimators.settings(&request, &prepared, &camera), ..request };
        let (reference, main): (Vec<Mode>, Vec<Mode>) =
            request.modes.iter().partition(|mode| **mode == Mode::Reference);
        let measures = request.ground_truth != GroundTruthDemand::Off;
        let has_work = [!main.is_empty(), !reference.is_empty(), !request.surfaces.is_empty(), measures, true];
        let modes = [main.clone(), reference, Vec::new(), Vec::new(), main];
        for ((lane, modes), has_work) in lanes.iter().zip(modes).zip(has_work) {
            let (prepared, request) = (prepared.clone(), request.clone());
            lane.post(has_work.then(|| Box::new(Job { prepared, camera, modes, request, asked_at })));
        }
        {
            let mut state = board.lock();
            state.snapshots.retain(|mode, _| request.modes.contains(mode));
            state.paintings.retain(|quantity, _| request.surfaces.contains(quantity));
        }
        if is_new {
            leisure =
                Some(Leisure { epoch: request.epoch, is_checked: false, repeats: 0, is_paused: request.is_paused });
            current = Some(prepared);
        } else if let Some(leisure) = &mut leisure {
            leisure.is_paused = request.is_paused;
        }
    }
}
