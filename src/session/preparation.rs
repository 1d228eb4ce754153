//! A scene that is being prepared: how far that has come, and how it ends early.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::job::Asked;
use super::mailbox::Mailbox;
use crate::rectify::Progress;
use crate::rectify::progress::Stage;
use crate::scene::{Description, SceneError};
use crate::tracking::{PrepareError, Prepared, prepare_watched};

/// A preparation that takes longer gives way to a request for another scene. Shorter ones are finished, so that a steady stream of edits
/// shows a steady stream of images.
pub(super) const GRACE: Duration = Duration::from_secs(1);

/// A scene that is being prepared.
#[derive(Debug)]
pub struct Preparation {
    /// Of the request that brought the scene.
    pub epoch: u64,
    pub begun: Instant,
    progress: Progress,
    is_given_up: AtomicBool,
}

impl Preparation {
    pub(super) fn new(epoch: u64) -> Self {
        Self { epoch, begun: Instant::now(), progress: Progress::new(), is_given_up: AtomicBool::new(false) }
    }

    /// What is being done, and the share of it that is done, in [0, 1].
    pub fn state(&self) -> (Stage, f64) {
        self.progress.state()
    }

    /// The user does not want to wait: it ends soon, and its request fails.
    pub fn give_up(&self) {
        self.is_given_up.store(true, Ordering::Relaxed);
        self.progress.cancel();
    }

    /// Prepares `description`, unless that is impossible or given up, and cancels it when there is a request for another scene. `None`: that
    /// request is to be served.
    pub(super) fn run(
        &self,
        description: &Arc<Description>,
        previous: Option<&Prepared>,
        requests: &Mailbox<Asked>,
    ) -> Result<Option<Prepared>, SceneError> {
        let is_other = |asked: &Asked| !Arc::ptr_eq(&asked.request.description, description);
        let mut outcome = Ok(None);
        watched(requests, self.begun + GRACE, is_other, &self.progress, || {
            outcome = match prepare_watched(Arc::clone(description), previous, &self.progress) {
                Ok(prepared) => Ok(Some(prepared)),
                Err(PrepareError::Scene(error)) => Err(error),
                Err(PrepareError::Cancelled(_)) if self.is_given_up.load(Ordering::Relaxed) => {
                    Err(SceneError::new("The scene was not prepared: it was given up."))
                }
                Err(PrepareError::Cancelled(_)) => Ok(None),
            };
        });
        outcome
    }
}

/// Does `work`, and cancels `progress` when, past `not_before`, there is a request that `matters`, or no more are served.
pub(super) fn watched(
    requests: &Mailbox<Asked>,
    not_before: Instant,
    matters: impl Fn(&Asked) -> bool,
    progress: &Progress,
    work: impl FnOnce() + Send,
) {
    let watched = requests.begin();
    rayon::in_place_scope(|scope| {
        scope.spawn(|_| {
            let _watched = watched;
            work();
        });
        requests.watch(not_before, matters, || progress.cancel(), None);
    });
}
