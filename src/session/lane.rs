//! A lane: one set of films that advance in lockstep, from a coarse preview to full resolution and then on, sample by sample.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::job::{FIRST_IMAGE, Job, LaneMessage, MAX_DIVISOR, attempted, cancellable, divisor_for, of_another_epoch};
use super::mailbox::{Alarm, Mailbox, Taken};
use super::{Board, News, Snapshot, Wake};
use crate::render::{Film, RenderTask};
use crate::scene::description::Source;
use crate::tracking::Mode;

/// Fraction of the time for the first image that the pilot takes.
const PILOT_SHARE: f64 = 0.2;
/// Fraction of the budget that the pilot leaves for the first image; the rest is slack for other lanes and programs.
const FIRST_IMAGE_SHARE: f64 = 0.7;
/// Time that a slice of samples should take, in seconds.
const SLICE_SECONDS: f64 = 0.08;
/// Until an epoch has its first image, its passes are left to finish until they have taken this long together.
const FIRST_IMAGE_GRACE: Duration = Duration::from_millis(150);
/// Pixels of the first pass of a mode that has not been timed in this scene.
const UNTIMED_PIXELS: f64 = 600.0;

/// The films of one epoch.
struct Progress {
    job: Job,
    films: Vec<Film>,
    seconds: Vec<f64>,
    /// Films have 1/divisor of the full size each way.
    divisor: u32,
    /// Divisor of the next films, if it is known.
    next_divisor: Option<u32>,
    begun: Instant,
    /// Deadline of the first image; at it the pilot is shown if nothing finer is ready.
    first_image_due: Instant,
    /// Images of the pilot, held back until then.
    pilot: Option<Vec<Snapshot>>,
    last_published: Option<Instant>,
    /// Time that the last publication took.
    publish_cost: Duration,
}

/// Renders what the mailbox says until it is closed.
pub(super) fn run_lane(pool: &rayon::ThreadPool, mailbox: &Mailbox<LaneMessage>, board: &Board, wake: &Wake) {
    let mut speed = Speed::default();
    let mut progress: Option<Progress> = None;
    loop {
        let has_work = progress.as_ref().is_some_and(Progress::has_work);
        match mailbox.wait(has_work.then_some(Duration::ZERO)) {
            Taken::Closed => return,
            Taken::Empty => {}
            Taken::Message(None) => progress = None,
            Taken::Message(Some(job)) => match &mut progress {
                // Only the limit or the pause has changed: go on.
                Some(p) if p.job.request.epoch == job.request.epoch => p.job = *job,
                _ => {
                    speed.begin(&job);
                    progress = Some(Progress::new(*job, &speed));
                }
            },
        }
        let Some(p) = progress.as_mut().filter(|p| p.has_work()) else { continue };
        let epoch = p.job.request.epoch;
        if !attempted(epoch, board, wake, || p.advance(pool, mailbox, board, wake, &mut speed)) {
            progress = None;
        }
    }
}

impl Progress {
    /// Begins with a pilot: a picture so coarse that it takes little of the time for the first image, and says how fine that can be.
    fn new(job: Job, speed: &Speed) -> Self {
        let begun = Instant::now();
        let first_image_due = job.first_image_due(begun);
        let seconds = PILOT_SHARE * (first_image_due - begun).as_secs_f64();
        let divisor = divisor_for(speed.seconds_of(&job), seconds).min(MAX_DIVISOR);
        let mut progress = Self {
            seconds: Vec::new(),
            films: Vec::new(),
            job,
            divisor,
            next_divisor: None,
            begun,
            first_image_due,
            pilot: None,
            last_published: None,
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
        self.next_divisor = None;
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
        if let Some(next) = self.next_divisor {
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
        let grace_end = match (self.last_published, &self.pilot) {
            (Some(_), _) => start,
            (None, Some(_)) => self.first_image_due,
            (None, None) => self.begun + FIRST_IMAGE_GRACE,
        };
        for ((film, seconds), mode) in self.films.iter_mut().zip(&mut self.seconds).zip(&self.job.modes) {
            let settings = self.job.settings(*mode, self.job.request.settings.seed);
            let task = RenderTask { prepared: &self.job.prepared, camera: &self.job.camera, settings: &settings };
            let begin = Instant::now();
            let (pilot, last_published) = (&mut self.pilot, &mut self.last_published);
            let alarm = pilot.is_some().then(|| Alarm {
                at: self.first_image_due,
                ring: Box::new(|| {
                    post(board, wake, pilot.take().unwrap_or_default());
                    *last_published = Some(Instant::now());
                }),
            });
            let is_other = of_another_epoch(self.job.request.epoch);
            let is_complete =
                cancellable(pool, mailbox, is_other, grace_end, alarm, |cancel| task.pass(film, samples, cancel));
            if !is_complete {
                return false;
            }
            let elapsed = begin.elapsed().as_secs_f64();
            *seconds += elapsed;
            speed.learn(*mode, pixels * f64::from(samples) / elapsed.max(1e-6));
        }
        if self.divisor > 1 {
            let spent: f64 = self.seconds.iter().sum();
            let full_seconds = spent * f64::from(self.divisor * self.divisor);
            if self.last_published.is_none() {
                let left = self.first_image_due.saturating_duration_since(Instant::now());
                let finer = divisor_for(full_seconds, FIRST_IMAGE_SHARE * left.as_secs_f64());
                if 3 * finer <= 2 * self.divisor {
                    self.pilot = Some(self.snapshots());
                    self.next_divisor = Some(finer);
                    return true;
                }
            }
            // Each picture may take a few times as long as the one before it.
            self.next_divisor = Some(divisor_for(full_seconds, (4.0 * spent).max(0.1)).min(self.divisor / 2).max(1));
        }
        // Reading a large film costs time that rendering could use: at most a sixth of it.
        let pause = Duration::from_secs_f64(SLICE_SECONDS).max(5 * self.publish_cost);
        let is_due = self.last_published.is_none_or(|last| last.elapsed() > pause);
        if self.divisor > 1 || self.samples() <= samples || self.remaining() == 0 || is_due {
            self.publish(board, wake);
        }
        true
    }

    fn snapshots(&self) -> Vec<Snapshot> {
        let is_done = self.divisor == 1 && !self.job.request.is_paused && self.remaining() == 0;
        (self.films.iter().zip(&self.seconds).zip(&self.job.modes))
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
            .collect()
    }

    fn publish(&mut self, board: &Board, wake: &Wake) {
        let start = Instant::now();
        post(board, wake, self.snapshots());
        self.pilot = None;
        self.publish_cost = start.elapsed();
        self.last_published = Some(Instant::now());
    }
}

/// Puts images on the board.
fn post(board: &Board, wake: &Wake, snapshots: Vec<Snapshot>) {
    let mut state = board.lock();
    for snapshot in snapshots {
        // A mode that moved to the other lane may have newer images from there.
        let is_stale = state.snapshots.get(&snapshot.mode).is_some_and(|old| old.epoch > snapshot.epoch);
        if !is_stale {
            state.snapshots.insert(snapshot.mode, Arc::new(snapshot));
        }
    }
    drop(state);
    wake(News::Images);
}

/// Measured pixel samples per second of each mode, in one scene.
#[derive(Debug, Default)]
struct Speed {
    scene: Option<Arc<Source>>,
    of_mode: BTreeMap<Mode, f64>,
}

impl Speed {
    /// Forgets what was measured in another scene than the job's.
    fn begin(&mut self, job: &Job) {
        let scene = &job.prepared.description.source;
        let is_same = match (&self.scene, scene) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        if !is_same {
            *self = Self { scene: scene.clone(), of_mode: BTreeMap::new() };
        }
    }

    fn of(&self, mode: Mode) -> Option<f64> {
        self.of_mode.get(&mode).copied()
    }

    fn learn(&mut self, mode: Mode, samples_per_second: f64) {
        let speed = self.of_mode.entry(mode).or_insert(samples_per_second);
        // Slower at once, faster with caution: a late image is worse than a coarse one.
        let weight = if samples_per_second < *speed { 0.7 } else { 0.2 };
        *speed += weight * (samples_per_second - *speed);
    }

    /// Seconds that one sample of every mode should take at full size. A mode that has not been timed is taken for one that renders
    /// [`UNTIMED_PIXELS`] in a pilot's time.
    fn seconds_of(&self, job: &Job) -> f64 {
        let pixels = f64::from(job.request.size[0]) * f64::from(job.request.size[1]);
        let untimed = UNTIMED_PIXELS / (PILOT_SHARE * FIRST_IMAGE.as_secs_f64());
        job.modes.iter().map(|mode| pixels / self.of(*mode).unwrap_or(untimed)).sum()
    }
}
