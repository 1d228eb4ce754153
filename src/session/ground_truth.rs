//! The lane that makes a ground truth of the picture: mode `reference`, twice, with random numbers that no other image has. Noise of the
//! two halves is independent, so a mean of products of errors against each is free of it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::job::{Job, LaneMessage, attempted, cancellable};
use super::lane::Pools;
use super::mailbox::{Mailbox, Taken};
use super::{Board, News, Wake};
use crate::render::{Film, RenderTask};
use crate::tracking::Mode;

/// Whether a ground truth is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GroundTruthDemand {
    #[default]
    Off,
    /// Paused: the samples taken so far are kept.
    Paused,
    On,
}

/// How far a ground truth has come.
#[derive(Debug, Clone)]
pub struct GroundTruth {
    /// The latest request for this picture: images of its epoch show the same.
    pub epoch: u64,
    /// Samples per pixel of each half.
    pub samples: u32,
    /// Time spent rendering it, in seconds.
    pub seconds: f64,
    /// Whether [`MOST_SAMPLES`] have been taken.
    pub is_done: bool,
    /// The latest images; `None` before the first sample.
    pub halves: Option<Arc<Halves>>,
}

/// Two independent images of one picture.
#[derive(Debug)]
pub struct Halves {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples per pixel of each.
    pub samples: u32,
    /// The name of the file that both were read from: one image of unknown noise. `None`: rendered.
    pub file: Option<String>,
    /// Mean radiance, linear RGB, row 0 at the top.
    pub rgb: [Vec<[f32; 3]>; 2],
    /// The mean of both.
    pub mean: Vec<[f32; 3]>,
}

/// Samples of each half after which a ground truth is good enough for anything that a window can show.
pub const MOST_SAMPLES: u32 = 1 << 16;
/// A picture that changes again within this time gets no ground truth: it is being dragged.
const SETTLING: Duration = Duration::from_millis(300);
/// Time that a slice of samples should take, in seconds.
const SLICE_SECONDS: f64 = 0.15;
const MOST_SAMPLES_OF_A_SLICE: f64 = 64.0;

struct Progress {
    job: Job,
    films: [Film; 2],
    truth: GroundTruth,
    /// Samples at which images are published next.
    next_images: u32,
    is_settled: bool,
}

/// Serves messages until the mailbox is closed.
pub(super) fn run_ground_truth(pools: &Pools, mailbox: &Mailbox<LaneMessage>, board: &Board, wake: &Wake) {
    let mut progress: Option<Progress> = None;
    loop {
        let working = progress.as_ref().filter(|p| p.has_work());
        match mailbox.wait(working.map(|p| if p.is_settled { Duration::ZERO } else { SETTLING })) {
            Taken::Closed => return,
            Taken::Empty => {}
            Taken::Message(None) => {
                progress = None;
                if board.lock().ground_truth.take().is_some() {
                    wake(News::Images);
                }
                continue;
            }
            Taken::Message(Some(job)) => {
                match &mut progress {
                    // Only panes, a limit or a pause have changed: go on.
                    Some(p) if p.job.shows_the_same(&job) => p.job = *job,
                    _ => progress = Some(Progress::new(*job)),
                }
                if let Some(p) = &mut progress {
                    p.publish(board, wake, News::Images);
                }
                continue;
            }
        }
        let Some(p) = progress.as_mut().filter(|p| p.has_work()) else { continue };
        p.is_settled = true;
        let epoch = p.job.request.epoch;
        if !attempted(epoch, board, wake, || p.advance(pools, mailbox, board, wake)) {
            progress = None;
        }
    }
}

impl Progress {
    fn new(job: Job) -> Self {
        let [width, height] = job.request.size;
        let truth = GroundTruth { epoch: job.request.epoch, samples: 0, seconds: 0.0, is_done: false, halves: None };
        Self {
            job,
            films: [Film::new(width, height), Film::new(width, height)],
            truth,
            next_images: 1,
            is_settled: false,
        }
    }

    fn has_work(&self) -> bool {
        let request = &self.job.request;
        request.ground_truth == GroundTruthDemand::On && !request.is_paused && !self.truth.is_done
    }

    /// Some samples for both halves. `false` when another picture is wanted.
    fn advance(&mut self, pools: &Pools, mailbox: &Mailbox<LaneMessage>, board: &Board, wake: &Wake) -> bool {
        let per_sample = self.truth.seconds / f64::from(self.truth.samples.max(1));
        let fitting = if self.truth.samples == 0 { 1.0 } else { SLICE_SECONDS / per_sample };
        let samples = (fitting.clamp(1.0, MOST_SAMPLES_OF_A_SLICE) as u32).min(MOST_SAMPLES - self.truth.samples);
        let pool = if self.is_alone(board) { &pools.alone } else { &pools.beside };
        let job = &self.job;
        let begin = Instant::now();
        for (half, film) in self.films.iter_mut().enumerate().filter(|(_, film)| film.samples <= self.truth.samples) {
            let samples = self.truth.samples + samples - film.samples;
            let settings = job.settings(Mode::Reference, seed_of(job.request.settings.seed, half));
            let task = RenderTask { prepared: &job.prepared, camera: &job.camera, settings: &settings };
            let is_other = |message: &LaneMessage| {
                message.as_ref().is_none_or(|other| !job.shows_the_same(other) || other.request.is_paused)
            };
            let is_complete =
                cancellable(pool, mailbox, is_other, begin, None, |cancel| task.pass(film, samples, cancel));
            if !is_complete {
                // Gone on with if the picture is still wanted.
                self.truth.seconds += begin.elapsed().as_secs_f64();
                return true;
            }
        }
        self.truth.seconds += begin.elapsed().as_secs_f64();
        self.truth.samples += samples;
        self.truth.is_done = self.truth.samples >= MOST_SAMPLES;
        if self.truth.samples >= self.next_images || self.truth.is_done {
            self.next_images = self.truth.samples + (self.truth.samples / 2).max(1);
            self.truth.halves = Some(Arc::new(self.halves()));
            self.publish(board, wake, News::Images);
        } else {
            self.publish(board, wake, News::Scene);
        }
        true
    }

    /// Whether no pane wants the cores.
    fn is_alone(&self, board: &Board) -> bool {
        let request = &self.job.request;
        let snapshots = board.snapshots();
        request.modes.iter().all(|mode| {
            let film = snapshots.get(mode).filter(|film| film.epoch == request.epoch && !film.is_preview());
            film.is_some_and(|film| film.is_done)
        })
    }

    fn halves(&self) -> Halves {
        let rgb = [0, 1].map(|half| self.films[half].to_rgb());
        let mean = (rgb[0].iter().zip(&rgb[1]))
            .map(|(a, b)| std::array::from_fn(|channel| 0.5 * (a[channel] + b[channel])))
            .collect();
        Halves { size: self.job.request.size, samples: self.truth.samples, file: None, rgb, mean }
    }

    fn publish(&mut self, board: &Board, wake: &Wake, news: News) {
        self.truth.epoch = self.job.request.epoch;
        board.lock().ground_truth = Some(self.truth.clone());
        wake(news);
    }
}

/// The seed of a half: different from the panes' and from the other half's.
fn seed_of(seed: u64, half: usize) -> u64 {
    seed.wrapping_add((half as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}
