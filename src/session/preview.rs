//! The first pictures of films: from a coarse one, in time, to one sample of every pixel. Coarse ones are rendered by the backend that is fastest at them,
//! which need not be that of the film.

use std::time::{Duration, Instant};

use super::film_cache::Entry;
use super::job::{Job, MAX_DIVISOR, divisor_for};
use super::lane::{Outcome, Threads, post};
use super::mailbox::Alarm;
use super::speed::Speed;
use super::{Snapshot, job};
use crate::tracking::Mode;

/// Fraction of the time for the first image that the pilot takes.
pub(super) const PILOT_SHARE: f64 = 0.2;
/// Fraction of the budget that the pilot leaves for the first image; the rest is slack for other lanes and programs.
const FIRST_IMAGE_SHARE: f64 = 0.7;
/// Until an epoch has its first image, its passes are left to finish until they have taken this long together.
const FIRST_IMAGE_GRACE: Duration = Duration::from_millis(150);

/// Films of one size, smaller than what is wanted until the last.
pub(super) struct Preview {
    pub(super) entries: Vec<Entry>,
    /// Films have 1/divisor of the full size each way.
    divisor: u32,
    /// Divisor of the next films, if it is known.
    next_divisor: Option<u32>,
    begun: Instant,
    /// Deadline of the first image; at it the pilot is shown if nothing finer is ready.
    first_image_due: Instant,
    /// Images of the pilot, held back until then.
    pilot: Option<Vec<Snapshot>>,
    is_shown: bool,
}

impl Preview {
    /// Begins with a pilot: a picture so coarse that it takes little of the time for the first image, and says how fine that can be.
    pub(super) fn new(job: &Job, modes: Vec<Mode>, speed: &Speed) -> Self {
        let begun = Instant::now();
        let first_image_due = job.first_image_due(begun);
        let seconds = PILOT_SHARE * (first_image_due - begun).as_secs_f64();
        let size = job.request.size;
        let by = |mode: &Mode| (*mode, speed.previews_by(*mode, job.film_by(*mode)));
        let divisor = divisor_for(speed.seconds_of(modes.iter().map(by), size), seconds).min(MAX_DIVISOR);
        let divisor = divisor.max(least_divisor(job, modes.iter().copied(), speed));
        let mut preview = Self {
            entries: modes.into_iter().map(|mode| Entry::new(mode, size)).collect(),
            divisor,
            next_divisor: None,
            begun,
            first_image_due,
            pilot: None,
            is_shown: false,
        };
        preview.restart(size, divisor);
        preview
    }

    fn restart(&mut self, full: [u32; 2], divisor: u32) {
        let size = full.map(|side| side.div_ceil(divisor).max(1));
        self.divisor = divisor;
        self.entries = self.entries.iter().map(|entry| Entry::new(entry.mode, size)).collect();
        self.next_divisor = None;
    }

    /// Keeps what is still wanted.
    pub(super) fn retain(&mut self, is_wanted: impl Fn(Mode) -> bool) {
        self.entries.retain(|entry| is_wanted(entry.mode));
        if let Some(pilot) = &mut self.pilot {
            pilot.retain(|snapshot| is_wanted(snapshot.mode));
        }
    }

    /// Whether the films have one sample of every pixel of the full size.
    pub(super) fn is_over(&self) -> bool {
        self.divisor == 1 && self.entries.iter().all(|entry| entry.film.samples > 0)
    }

    /// One sample for every film.
    pub(super) fn advance(&mut self, job: &Job, threads: &Threads<'_>, speed: &mut Speed) -> Outcome {
        if let Some(next) = self.next_divisor {
            self.restart(job.request.size, next);
        }
        let grace_end = match &self.pilot {
            _ if self.is_shown => Instant::now(),
            Some(_) => self.first_image_due,
            None => self.begun + FIRST_IMAGE_GRACE,
        };
        for entry in self.entries.iter_mut().filter(|entry| entry.film.samples == 0) {
            let (pilot, is_shown) = (&mut self.pilot, &mut self.is_shown);
            let alarm = pilot.is_some().then(|| Alarm {
                at: self.first_image_due,
                ring: Box::new(|| {
                    post(threads.board, threads.wake, pilot.take().unwrap_or_default());
                    *is_shown = true;
                }),
            });
            let film_by = job.film_by(entry.mode);
            let by = if self.divisor > 1 { speed.previews_by(entry.mode, film_by) } else { film_by };
            if threads.pass(job, entry, by, 1, job::puts_out_of_date(job), grace_end, alarm, speed)
                == Outcome::Interrupted
            {
                return Outcome::Interrupted;
            }
        }
        let snapshots =
            || self.entries.iter().map(|entry| Snapshot::of_entry(job, entry, false)).collect::<Vec<Snapshot>>();
        if self.divisor == 1 {
            return Outcome::Complete;
        }
        let spent: f64 = self.entries.iter().map(|entry| entry.seconds).sum();
        let full_seconds = spent * f64::from(self.divisor * self.divisor);
        if !self.is_shown {
            let left = self.first_image_due.saturating_duration_since(Instant::now());
            let finer = divisor_for(full_seconds, FIRST_IMAGE_SHARE * left.as_secs_f64());
            let finer = finer.max(least_divisor(job, self.entries.iter().map(|entry| entry.mode), speed));
            if 3 * finer <= 2 * self.divisor {
                self.pilot = Some(snapshots());
                self.next_divisor = Some(finer);
                return Outcome::Complete;
            }
        }
        // Each picture may take a few times as long as the one before it.
        self.next_divisor = Some(divisor_for(full_seconds, (4.0 * spent).max(0.1)).min(self.divisor / 2).max(1));
        post(threads.board, threads.wake, snapshots());
        self.pilot = None;
        self.is_shown = true;
        Outcome::Complete
    }
}

/// Of the first image: what the CPU is asked for because it is faster has to be coarser than the film.
fn least_divisor(job: &Job, mut modes: impl Iterator<Item = Mode>, speed: &Speed) -> u32 {
    let is_by_other = |mode: Mode| speed.previews_by(mode, job.film_by(mode)) != job.film_by(mode);
    if modes.any(is_by_other) { 2 } else { 1 }
}
