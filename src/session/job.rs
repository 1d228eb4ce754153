//! What the threads tell each other: requests, messages to the lanes, jobs, and passes that a newer message cancels.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::mailbox::{Alarm, Mailbox};
use super::{Board, Request, Wake, guarded};
use crate::render::backends::backend_of;
use crate::render::{Backend, ImageSettings};
use crate::scene::camera::Camera;
use crate::scene::description::Source;
use crate::tracking::Mode;
use crate::tracking::Prepared;

/// When the first image of an epoch is there, counted from the request: the rest of 100 ms is for display and the screen.
pub(super) const FIRST_IMAGE: Duration = Duration::from_millis(60);
/// Least time for the first image where its deadline has passed or is near: after a long preparation, or in a stream of edits.
const LEAST_FIRST_IMAGE: Duration = Duration::from_millis(30);
/// Coarsest preview: one pixel for this many squared.
pub(super) const MAX_DIVISOR: u32 = 40;

/// A request, and when it came.
pub(super) struct Asked {
    pub(super) request: Request,
    pub(super) at: Instant,
}

/// What a lane is told; `None`: nothing to do until told otherwise.
pub(super) type LaneMessage = Option<Box<Job>>;

/// What a lane renders.
#[derive(Debug, Clone)]
pub(super) struct Job {
    pub(super) prepared: Prepared,
    pub(super) camera: Camera,
    pub(super) modes: Vec<Mode>,
    pub(super) request: Request,
    /// When the request came.
    pub(super) asked_at: Instant,
}

impl Job {
    /// Whether both are about one picture, whatever else is wanted of it: which modes show it, how many samples.
    pub(super) fn shows_the_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.prepared.description, &other.prepared.description)
            && self.request.camera == other.request.camera
            && self.request.size == other.request.size
            && self.request.settings == other.request.settings
    }

    /// When the first image must be there, if work on it begins at `begun`.
    pub(super) fn first_image_due(&self, begun: Instant) -> Instant {
        (self.asked_at + FIRST_IMAGE).max(begun + LEAST_FIRST_IMAGE)
    }

    /// Whether no other lane renders.
    pub(super) fn is_alone(&self) -> bool {
        self.request.modes.iter().all(|mode| self.modes.contains(mode))
    }

    /// What renders the film of a mode.
    pub(super) fn film_by(&self, mode: Mode) -> Backend {
        backend_of(mode, self.request.settings.backend)
    }

    /// How to render a film of this picture.
    pub(super) fn settings(&self, mode: Mode, seed: u64) -> ImageSettings {
        ImageSettings { mode, seed, backend: self.film_by(mode), ..self.request.settings }
    }

    /// Whether its scene was read from `source`, edited since or not.
    pub(super) fn is_of(&self, source: Option<&Arc<Source>>) -> bool {
        self.prepared.description.is_of(source)
    }

    /// Whether the graphics processor renders its films.
    pub(super) fn is_by_graphics(&self) -> bool {
        self.modes.iter().all(|mode| self.film_by(*mode) == Backend::Gpu)
    }

    /// Whether only this lane takes the CPU: the others have nothing to do, or a graphics processor, other than one in software, to do it.
    pub(super) fn has_cpu_to_itself(&self, is_software: bool) -> bool {
        let is_by_gpu = self.request.settings.backend == Backend::Gpu && !is_software;
        self.is_alone() || (is_by_gpu && self.modes == [Mode::Reference])
    }
}

/// Whether a job's `pass` is complete. One that panics is told as a failure of the job's request.
pub(super) fn attempted(epoch: u64, board: &Board, wake: &Wake, pass: impl FnOnce() -> bool) -> bool {
    guarded(|| Ok(pass())).unwrap_or_else(|error| {
        board.fail(epoch, error, wake);
        false
    })
}

/// What puts the images of `epoch` out of date.
pub(super) fn of_another_epoch(epoch: u64) -> impl Fn(&LaneMessage) -> bool {
    move |message| message.as_ref().is_none_or(|job| job.request.epoch != epoch)
}

/// What puts first pictures of a job out of date: another epoch, and other modes of the same one.
pub(super) fn puts_out_of_date(job: &Job) -> impl Fn(&LaneMessage) -> bool {
    move |message| {
        message.as_ref().is_none_or(|other| other.request.epoch != job.request.epoch || other.modes != job.modes)
    }
}

/// Runs `pass` on the pool while this thread watches the mailbox and the clock for the `alarm`, and cancels it when a message comes that
/// puts it out of date, though not before `not_before`.
pub(super) fn cancellable(
    pool: &rayon::ThreadPool,
    mailbox: &Mailbox<LaneMessage>,
    is_other: impl Fn(&LaneMessage) -> bool,
    not_before: Instant,
    alarm: Option<Alarm<'_>>,
    pass: impl FnOnce(&AtomicBool) -> bool + Send,
) -> bool {
    let cancel = AtomicBool::new(false);
    let mut is_complete = false;
    let work = mailbox.begin();
    pool.in_place_scope(|scope| {
        scope.spawn(|_| {
            let _work = work;
            is_complete = pass(&cancel);
        });
        mailbox.watch(not_before, is_other, || cancel.store(true, Ordering::Relaxed), alarm);
    });
    is_complete
}

/// Smallest divisor at which a pass of `full_seconds` at full size takes at most `seconds`.
pub(super) fn divisor_for(full_seconds: f64, seconds: f64) -> u32 {
    (full_seconds / seconds.max(1e-6)).sqrt().ceil().max(1.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divisors_fit_into_the_time() {
        for (full, seconds) in [(1.0, 0.07), (0.01, 0.07), (40.0, 0.01), (0.07, 0.07)] {
            let divisor = divisor_for(full, seconds);
            let takes = |divisor: u32| full / f64::from(divisor * divisor);
            assert!(takes(divisor) <= seconds && (divisor == 1 || takes(divisor - 1) > seconds), "{full}, {seconds}");
        }
    }
}
