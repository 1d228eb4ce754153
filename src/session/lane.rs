//! A lane: one set of films that advance in lockstep, from a coarse preview to full resolution and then on, sample by sample. Films that
//! are wanted again come back from where they are kept, with their samples.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::backend::Graphics;
use super::film_cache::{Entry, FilmCache, Picture};
use super::job::{Job, LaneMessage, attempted, cancellable};
use super::mailbox::{Alarm, Mailbox, Taken};
use super::preview::Preview;
use super::speed::Speed;
use super::{Board, News, Snapshot, Wake};
use crate::render::denoise::variances;
use crate::render::{Backend, ImageSettings, Noise, RenderTask, choice};
use crate::tracking::Mode;

/// Time that a slice of samples should take, in seconds.
const SLICE_SECONDS: f64 = 0.08;
const MOST_SAMPLES_OF_A_SLICE: u32 = 128;
/// Samples that are taken before an estimate of noise is believed.
const LEAST_SAMPLES_TO_STOP: u32 = 16;

/// The pools to render with: with the machine to itself, and beside other lanes.
pub(super) struct Pools {
    pub(super) alone: Arc<rayon::ThreadPool>,
    pub(super) beside: Arc<rayon::ThreadPool>,
    /// One thread, which waits for the graphics processor: among threads that render it would have to wait for them first.
    pub(super) graphics: Arc<rayon::ThreadPool>,
}

/// What a lane works with and tells its results to.
pub(super) struct Threads<'a> {
    pub(super) cpu: &'a rayon::ThreadPool,
    /// For the graphics processor, while it can be used. The CPU must not step in there.
    pub(super) graphics: Option<&'a rayon::ThreadPool>,
    pub(super) mailbox: &'a Mailbox<LaneMessage>,
    pub(super) board: &'a Board,
    pub(super) wake: &'a Wake,
}

/// How work ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    Complete,
    /// A newer message came in between; what has been done is kept.
    Interrupted,
}

impl Threads<'_> {
    /// Adds samples to a film, by that backend.
    #[allow(clippy::too_many_arguments, reason = "each is said once, by the two callers")]
    pub(super) fn pass(
        &self,
        job: &Job,
        entry: &mut Entry,
        backend: Backend,
        samples: u32,
        interrupts: impl Fn(&LaneMessage) -> bool,
        not_before: Instant,
        alarm: Option<Alarm<'_>>,
        speed: &mut Speed,
    ) -> Outcome {
        let settings = ImageSettings { backend, ..job.settings(entry.mode, job.request.settings.seed) };
        let task = RenderTask { prepared: &job.prepared, camera: &job.camera, settings: &settings };
        let begin = Instant::now();
        let film = &mut entry.film;
        let pixels = f64::from(film.width) * f64::from(film.height);
        let graphics = self.graphics.filter(|_| backend == Backend::Gpu);
        let pool = graphics.unwrap_or(self.cpu);
        let is_complete = cancellable(pool, self.mailbox, interrupts, not_before, alarm, |cancel| {
            if graphics.is_some() { task.try_pass(film, samples, cancel) } else { task.pass(film, samples, cancel) }
        });
        let elapsed = begin.elapsed().as_secs_f64();
        entry.seconds += elapsed;
        if !is_complete {
            return Outcome::Interrupted;
        }
        speed.learn(entry.mode, backend, pixels * f64::from(samples) / elapsed.max(1e-6));
        Outcome::Complete
    }
}

/// The films of one epoch.
struct Progress {
    job: Job,
    picture: Picture,
    /// Films at full size that have samples.
    full: Vec<Entry>,
    /// Films that do not yet.
    preview: Option<Preview>,
    last_published: Option<Instant>,
    /// Time that the last publication took.
    publish_cost: Duration,
}

/// Renders what the mailbox says until it is closed.
pub(super) fn run_lane(
    pools: &Pools,
    mailbox: &Mailbox<LaneMessage>,
    board: &Board,
    wake: &Wake,
    cache: &Mutex<FilmCache>,
    graphics: &Graphics,
) {
    let mut speed = Speed::default();
    let mut progress: Option<Progress> = None;
    loop {
        let has_work = progress.as_ref().is_some_and(Progress::has_work);
        let mut next = None;
        let message = mailbox.wait(has_work.then_some(Duration::ZERO));
        let mut cache = cache.lock().unwrap_or_else(PoisonError::into_inner);
        match message {
            Taken::Closed => return,
            Taken::Empty => {}
            Taken::Message(None) => {
                if let Some(before) = progress.take() {
                    before.park(&mut cache);
                }
            }
            Taken::Message(Some(job)) => next = Some(*job),
        }
        // The graphics processor may have become ready since.
        let changed = || progress.as_ref().filter(|p| p.has_work()).map(|p| &p.job).filter(|job| graphics.changes(job));
        if let Some(mut job) = next.take().or_else(|| changed().cloned()) {
            // Films of one epoch go on as they began, also where the graphics processor has failed since.
            let begun = progress
                .as_ref()
                .map(|p| &p.job.request)
                .filter(|begun| begun.epoch == job.request.epoch && begun.settings.backend == Backend::Gpu);
            job.request.settings = begun.map_or_else(|| graphics.settings(&job), |begun| begun.settings);
            let is_other = |p: &mut Progress| {
                p.job.request.epoch != job.request.epoch || p.job.request.settings != job.request.settings
            };
            if let Some(before) = progress.take_if(is_other) {
                before.park(&mut cache);
            }
            speed.begin(&job, graphics.is_software());
            let p = progress.get_or_insert_with(|| Progress::new(job.clone()));
            p.go_on(job, &mut cache, &speed);
            p.publish_changes(board, wake);
        }
        drop(cache);
        let Some(p) = progress.as_mut().filter(|p| p.has_work()) else { continue };
        let is_graphics = p.job.is_by_graphics() && choice::fault().is_none();
        let has_cpu = p.job.has_cpu_to_itself(graphics.is_software());
        let cpu = if has_cpu { &*pools.alone } else { &*pools.beside };
        let threads = Threads { cpu, graphics: is_graphics.then_some(&*pools.graphics), mailbox, board, wake };
        if !attempted(p.job.request.epoch, board, wake, || p.advance(&threads, &mut speed)) {
            progress = None;
        }
        graphics.notice_fault(board, wake);
    }
}

impl Progress {
    fn new(job: Job) -> Self {
        let picture = Picture::of(&job);
        Self { job, picture, full: Vec::new(), preview: None, last_published: None, publish_cost: Duration::ZERO }
    }

    /// Lets the films be kept.
    fn park(self, cache: &mut FilmCache) {
        self.full.into_iter().for_each(|entry| cache.put(&self.picture, entry));
    }

    /// Goes on with what a message of the same epoch wants: films of modes that are not wanted now are kept, others come back.
    fn go_on(&mut self, job: Job, cache: &mut FilmCache, speed: &Speed) {
        let is_wanted = |mode: Mode| job.modes.contains(&mode);
        for entry in self.full.extract_if(.., |entry| !is_wanted(entry.mode)) {
            cache.put(&self.picture, entry);
        }
        let mut waiting: Vec<Mode> = Vec::new();
        if let Some(preview) = &mut self.preview {
            preview.retain(is_wanted);
            waiting = preview.entries.iter().map(|entry| entry.mode).collect();
        }
        let mut has_new = false;
        for &mode in &job.modes {
            if waiting.contains(&mode) || self.full.iter().any(|entry| entry.mode == mode) {
                continue;
            }
            match cache.take(&self.picture, mode) {
                Some(entry) => self.full.push(entry),
                None => {
                    waiting.push(mode);
                    has_new = true;
                }
            }
        }
        if has_new {
            waiting.sort();
            self.preview = Some(Preview::new(&job, waiting, speed));
        } else if waiting.is_empty() {
            self.preview = None;
        }
        self.full.sort_by_key(|entry| entry.mode);
        self.job = job;
    }

    fn fewest_samples(&self) -> u32 {
        self.full.iter().map(|entry| entry.film.samples).min().unwrap_or(0)
    }

    fn most_samples(&self) -> u32 {
        self.full.iter().map(|entry| entry.film.samples).max().unwrap_or(0)
    }

    fn limit(&self) -> u32 {
        let request = &self.job.request;
        if request.is_paused { 1 } else { request.sample_limit.unwrap_or(u32::MAX).max(1) }
    }

    /// Whether noise in every film is as little as is wanted.
    fn is_clean(&self) -> bool {
        self.job.request.noise_target.is_some_and(|target| {
            let is_clean = |entry: &Entry| entry.noise.of(&entry.film).is_some_and(|noise| noise <= target);
            self.fewest_samples() >= LEAST_SAMPLES_TO_STOP && self.full.iter().all(is_clean)
        })
    }

    /// Samples that every film should have in the end, as far as is known: those that are behind catch up in any case.
    fn wanted_samples(&self) -> u32 {
        if self.is_clean() { self.most_samples().min(self.limit()) } else { self.limit() }
    }

    fn has_work(&self) -> bool {
        self.preview.is_some() || (!self.full.is_empty() && self.fewest_samples() < self.wanted_samples())
    }

    /// Some samples for those films that have fewest.
    fn advance(&mut self, threads: &Threads<'_>, speed: &mut Speed) -> bool {
        if let Some(preview) = &mut self.preview {
            let outcome = preview.advance(&self.job, threads, speed);
            if outcome == Outcome::Complete && preview.is_over() {
                self.full.extend(self.preview.take().into_iter().flat_map(|preview| preview.entries));
                self.full.sort_by_key(|entry| entry.mode);
                self.publish_changes(threads.board, threads.wake);
            }
            return true;
        }
        let fewest = self.fewest_samples();
        let next = self.full.iter().map(|entry| entry.film.samples).filter(|samples| *samples > fewest).min();
        let end = next.unwrap_or(u32::MAX).min(self.wanted_samples());
        let behind = || self.full.iter().filter(|entry| entry.film.samples == fewest);
        let per_sample =
            speed.seconds_of(behind().map(|entry| (entry.mode, self.job.film_by(entry.mode))), self.job.request.size);
        let to_look = behind().map(|entry| Noise::samples_to_look(&entry.film)).min().unwrap_or(1);
        let samples =
            ((SLICE_SECONDS / per_sample) as u32).clamp(1, MOST_SAMPLES_OF_A_SLICE).min(to_look).min(end - fewest);
        for entry in self.full.iter_mut().filter(|entry| entry.film.samples == fewest) {
            // Any message may want something else, and nothing is lost.
            let by = self.job.film_by(entry.mode);
            let outcome = threads.pass(&self.job, entry, by, samples, |_| true, Instant::now(), None, speed);
            if outcome == Outcome::Interrupted {
                return true;
            }
            threads.cpu.install(|| entry.noise.look(&entry.film));
        }
        // Reading a large film costs time that rendering could use: at most a sixth of it.
        let pause = Duration::from_secs_f64(SLICE_SECONDS).max(5 * self.publish_cost);
        let is_due = self.last_published.is_none_or(|last| last.elapsed() > pause);
        if !self.has_work() || is_due {
            self.publish_changes(threads.board, threads.wake);
        }
        true
    }

    /// Publishes the films at full size that the board does not have as they are.
    fn publish_changes(&mut self, board: &Board, wake: &Wake) {
        let start = Instant::now();
        let (wanted, shown) = (self.wanted_samples(), board.snapshots());
        let is_done = |entry: &Entry| {
            !self.job.request.is_paused && entry.film.samples >= wanted && entry.film.samples >= self.most_samples()
        };
        let is_news = |entry: &&Entry| {
            shown.get(&entry.mode).is_none_or(|shown| {
                shown.epoch != self.job.request.epoch
                    || shown.is_preview()
                    || shown.samples != entry.film.samples
                    || shown.is_done != is_done(entry)
            })
        };
        let news = self.full.iter().filter(is_news);
        let news: Vec<Snapshot> = news.map(|entry| Snapshot::of_entry(&self.job, entry, is_done(entry))).collect();
        if news.is_empty() {
            return;
        }
        post(board, wake, news);
        self.publish_cost = start.elapsed();
        self.last_published = Some(Instant::now());
    }
}

impl Snapshot {
    pub(super) fn of_entry(job: &Job, Entry { mode, film, seconds, noise }: &Entry, is_done: bool) -> Self {
        Self {
            epoch: job.request.epoch,
            mode: *mode,
            size: [film.width, film.height],
            full_size: job.request.size,
            rgb: film.to_rgb(),
            samples: film.samples,
            noise: noise.of(film),
            variances: variances(film, noise),
            events: film.events,
            backend: film.backend.unwrap_or(job.request.settings.backend),
            estimator: job.request.settings.estimator,
            seconds: *seconds,
            is_done,
        }
    }
}

/// Puts images on the board.
pub(super) fn post(board: &Board, wake: &Wake, snapshots: Vec<Snapshot>) {
    let mut state = board.lock();
    for snapshot in snapshots {
        // A mode that moved to the other lane may have newer images from there. What began anew on the graphics processor is shown when it
        // has caught up.
        let is_stale = state.snapshots.get(&snapshot.mode).is_some_and(|old| {
            let has_less = !old.is_preview() && (snapshot.is_preview() || snapshot.samples < old.samples);
            old.epoch > snapshot.epoch || (old.epoch == snapshot.epoch && has_less)
        });
        if !is_stale {
            state.snapshots.insert(snapshot.mode, Arc::new(snapshot));
        }
    }
    drop(state);
    wake(News::Images);
}
