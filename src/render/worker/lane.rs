//! A lane: one set of films that advance in lockstep, from a coarse preview to full resolution and then on, sample by sample.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::mailbox::{Mailbox, Taken};
use super::{Board, News, Request, Snapshot, Wake, guarded};
use crate::render::{Film, Prepared, RenderSettings, SPLITS, accumulate};
use crate::scene::camera::Camera;
use crate::tracking::Mode;

/// What a lane is told.
#[derive(Debug, Clone)]
pub(super) enum LaneMessage {
    Render(Box<Job>),
    /// Nothing to do until told otherwise.
    Hold,
}

/// What a lane renders.
#[derive(Debug, Clone)]
pub(super) struct Job {
    pub(super) prepared: Prepared,
    pub(super) camera: Camera,
    pub(super) modes: Vec<Mode>,
    pub(super) request: Request,
}

/// Time that the first image of an epoch should take, in seconds: the rest of 100 ms is for preparation, display and the screen.
const FIRST_IMAGE_SECONDS: f64 = 0.05;
/// Time that a slice of samples should take, in seconds.
const SLICE_SECONDS: f64 = 0.08;
/// A first pass is left to finish until it has taken this long.
const FIRST_PASS_GRACE: Duration = Duration::from_millis(150);
/// Pixels of the first pass of a mode that has never been timed.
const UNTIMED_PIXELS: f64 = 3000.0;
/// Coarsest preview: one pixel for this many squared.
const MAX_DIVISOR: u32 = 32;

/// The films of one epoch.
struct Progress {
    job: Job,
    films: Vec<Film>,
    seconds: Vec<f64>,
    /// Films have 1/divisor of the full size each way.
    divisor: u32,
    is_first_pass: bool,
    last_published: Instant,
    /// Time that the last publication took.
    publish_cost: Duration,
}

/// Renders what the mailbox says until it is closed.
pub(super) fn run_lane(pool: &rayon::ThreadPool, mailbox: &Mailbox<LaneMessage>, board: &Board, wake: &Wake) {
    let mut speed = Speed::default();
    let mut progress: Option<Progress> = None;
    loop {
        let message = if progress.as_ref().is_some_and(Progress::has_work) {
            match mailbox.take() {
                Taken::Message(message) => Some(message),
                Taken::Empty => None,
                Taken::Closed => return,
            }
        } else {
            let Some(message) = mailbox.wait() else { return };
            Some(message)
        };
        match message {
            Some(LaneMessage::Hold) => progress = None,
            Some(LaneMessage::Render(job)) => match &mut progress {
                // Only the limit or the pause has changed: go on.
                Some(p) if p.job.request.epoch == job.request.epoch => p.job = *job,
                _ => progress = Some(Progress::new(*job, &speed)),
            },
            None => {}
        }
        if let Some(p) = progress.as_mut().filter(|p| p.has_work()) {
            let outcome = guarded(|| Ok(p.advance(pool, mailbox, board, wake, &mut speed)));
            match outcome {
                Ok(true) => {}
                Ok(false) => progress = None,
                Err(error) => {
                    board.lock().failure = Some((p.job.request.epoch, error));
                    progress = None;
                    wake(News::Scene);
                }
            }
        }
    }
}

impl Progress {
    fn new(job: Job, speed: &Speed) -> Self {
        let divisor = speed.divisor(&job, FIRST_IMAGE_SECONDS, MAX_DIVISOR);
        let now = Instant::now();
        let mut progress = Self {
            seconds: Vec::new(),
            films: Vec::new(),
            job,
            divisor,
            is_first_pass: true,
            last_published: now,
            publish_cost: Duration::ZERO,
        };
        progress.restart(divisor);
        progress
    }

    fn restart(&mut self, divisor: u32) {
        let [width, height] = self.job.request.size.map(|side| side.div_ceil(divisor).max(1));
        self.divisor = divisor;
        self.films = self.job.modes.iter().map(|_| Film::new(width, height)).collect();
        self.seconds = vec![0.0; self.films.len()];
    }

    fn samples(&self) -> u32 {
        self.films.first().map_or(0, |film| film.samples)
    }

    /// Samples still to take at full resolution.
    fn remaining(&self) -> u32 {
        let limit = if self.job.request.is_paused { 1 } else { self.job.request.sample_limit.unwrap_or(u32::MAX) };
        limit.max(1).saturating_sub(self.samples())
    }

    fn has_work(&self) -> bool {
        self.divisor > 1 || self.remaining() > 0
    }

    /// One pass over every film. `false` when a newer message has cancelled it.
    fn advance(
        &mut self,
        pool: &rayon::ThreadPool,
        mailbox: &Mailbox<LaneMessage>,
        board: &Board,
        wake: &Wake,
        speed: &mut Speed,
    ) -> bool {
        if self.divisor > 1 && self.samples() > 0 {
            // Each picture may take a few times as long as all before it together.
            let spent: f64 = self.seconds.iter().sum();
            let next = speed.divisor(&self.job, (4.0 * spent).max(0.1), self.divisor / 2);
            self.restart(next);
        }
        let start = Instant::now();
        let pixels = f64::from(self.films[0].width) * f64::from(self.films[0].height);
        let samples = if self.divisor > 1 || self.samples() == 0 {
            1
        } else {
            let per_sample: f64 = self.job.modes.iter().map(|mode| pixels / speed.of(*mode).unwrap_or(1.0)).sum();
            ((SLICE_SECONDS / per_sample) as u32).clamp(1, 32).min(self.remaining())
        };
        let grace_end = if self.is_first_pass { start + FIRST_PASS_GRACE } else { start };
        for ((film, seconds), mode) in self.films.iter_mut().zip(&mut self.seconds).zip(&self.job.modes) {
            let settings = RenderSettings {
                mode: *mode,
                seed: self.job.request.seed,
                max_depth: self.job.request.max_depth,
                splits: SPLITS,
                leave_out: true,
            };
            let begin = Instant::now();
            let is_complete = cancellable(pool, mailbox, self.job.request.epoch, grace_end, |cancel| {
                accumulate(&self.job.prepared, &self.job.camera, &settings, film, samples, cancel)
            });
            if !is_complete {
                return false;
            }
            let elapsed = begin.elapsed().as_secs_f64();
            *seconds += elapsed;
            speed.learn(*mode, pixels * f64::from(samples) / elapsed.max(1e-6));
        }
        self.is_first_pass = false;
        // Reading a large film costs time that rendering could use: at most a sixth of it.
        let due = Duration::from_secs_f64(SLICE_SECONDS).max(5 * self.publish_cost);
        if self.divisor > 1 || self.samples() <= samples || self.remaining() == 0 || self.last_published.elapsed() > due
        {
            self.publish(board);
            wake(News::Images);
        }
        true
    }

    fn publish(&mut self, board: &Board) {
        let start = Instant::now();
        let is_done = self.divisor == 1 && !self.job.request.is_paused && self.remaining() == 0;
        let snapshots: Vec<Snapshot> = (self.films.iter().zip(&self.seconds).zip(&self.job.modes))
            .map(|((film, seconds), mode)| Snapshot {
                epoch: self.job.request.epoch,
                mode: *mode,
                size: [film.width, film.height],
                full_size: self.job.request.size,
                rgb: film.to_rgb(),
                samples: film.samples,
                events: film.events,
                seconds: *seconds,
                is_done,
            })
            .collect();
        let mut state = board.lock();
        for snapshot in snapshots {
            // The other lane may be ahead, or the mode may have moved there.
            let is_stale = state.snapshots.get(&snapshot.mode).is_some_and(|old| old.epoch > snapshot.epoch);
            if !is_stale {
                state.snapshots.insert(snapshot.mode, Arc::new(snapshot));
            }
        }
        drop(state);
        self.publish_cost = start.elapsed();
        self.last_published = Instant::now();
    }
}

/// Runs `pass` on the pool while this thread watches the mailbox, and cancels it when it is out of date, though not before
/// `not_before`.
pub(super) fn cancellable(
    pool: &rayon::ThreadPool,
    mailbox: &Mailbox<LaneMessage>,
    epoch: u64,
    not_before: Instant,
    pass: impl FnOnce(&AtomicBool) -> bool + Send,
) -> bool {
    /// Ends the watch even if the pass panics.
    struct Finish<'a>(&'a Mailbox<LaneMessage>);
    impl Drop for Finish<'_> {
        fn drop(&mut self) {
            self.0.finish();
        }
    }

    let cancel = AtomicBool::new(false);
    let mut is_complete = false;
    mailbox.begin();
    pool.in_place_scope(|scope| {
        scope.spawn(|_| {
            let _finish = Finish(mailbox);
            is_complete = pass(&cancel);
        });
        let is_other = |message: &LaneMessage| match message {
            LaneMessage::Hold => true,
            LaneMessage::Render(job) => job.request.epoch != epoch,
        };
        mailbox.watch(not_before, is_other, || cancel.store(true, Ordering::Relaxed));
    });
    is_complete
}

/// Measured pixel samples per second of each mode.
#[derive(Debug, Default)]
struct Speed {
    of_mode: BTreeMap<Mode, f64>,
}

impl Speed {
    fn of(&self, mode: Mode) -> Option<f64> {
        self.of_mode.get(&mode).copied()
    }

    fn learn(&mut self, mode: Mode, samples_per_second: f64) {
        let speed = self.of_mode.entry(mode).or_insert(samples_per_second);
        // Slower at once, faster with caution: a late image is worse than a coarse one.
        let weight = if samples_per_second < *speed { 0.7 } else { 0.2 };
        *speed += weight * (samples_per_second - *speed);
    }

    /// The finest power of two, at most `coarsest`, at which one sample of every mode is expected to take at most `seconds`.
    fn divisor(&self, job: &Job, seconds: f64, coarsest: u32) -> u32 {
        let pixels = f64::from(job.request.size[0]) * f64::from(job.request.size[1]);
        let full: f64 = (job.modes.iter())
            .map(|mode| match self.of(*mode) {
                Some(speed) => pixels / speed,
                None => FIRST_IMAGE_SECONDS * pixels / UNTIMED_PIXELS,
            })
            .sum();
        let mut divisor = 1;
        while divisor < coarsest && full / f64::from(divisor * divisor) > seconds {
            divisor *= 2;
        }
        divisor.min(coarsest).max(1)
    }
}
