//! The thread that measures: keeps films at doublings of their samples and measures them again whenever the ground truth has become
//! better. Neither the window nor the renderer waits for it.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::curve::{Curve, Point};
use super::{ErrorMetric, Given};
use crate::app::background::{Background, Bell, Desk, Repaint};
use crate::measure::{MetricError, difference, difference_from_two, flip};
use crate::render::Display;
use crate::session::{Board, GroundTruth, Halves, Snapshot};
use crate::tracking::Mode;

/// What to measure.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    pub is_on: bool,
    /// Nothing is measured for now; what was measured stays.
    pub is_paused: bool,
    /// Of the films to be measured.
    pub epoch: u64,
    /// What they are measured against; `None`: the ground truth that is rendered.
    pub given: Given,
    /// FLIP is measured only where it is looked at: it takes far longer than the others.
    pub metric: ErrorMetric,
    /// FLIP is measured on displayed pictures.
    pub display: Display,
    /// Time that rectification has taken, counted with the modes that use what it found.
    pub rectification_seconds: f64,
}

impl Plan {
    /// Time to be counted with a mode beside its film's, where it looks up what rectification found.
    fn more_seconds(&self, mode: Mode) -> f64 {
        if mode.is_rectified() { self.rectification_seconds } else { 0.0 }
    }
}

/// What has been measured.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measurements {
    pub epoch: u64,
    /// Width and height of the films, in pixels.
    pub size: [u32; 2],
    pub curves: BTreeMap<Mode, Curve>,
    /// What noise in the mean of the ground truth's halves amounts to, as relMSE.
    pub truth_noise: Option<f64>,
}

/// Bytes of films that are kept; beyond, the earliest keep their last figures.
const MOST_BYTES: usize = 256 << 20;
/// A film is measured anew when the ground truth has so many times the samples.
const BETTER_TRUTH: u32 = 2;
/// Pause between measurements of the films as they are just now.
const LIVE_PAUSE: Duration = Duration::from_millis(400);

/// What has been measured, if it is new.
type Results = Option<Arc<Measurements>>;

/// The thread that measures. Its bell tells it that films have changed.
pub type Measurer = Background<Plan, Results>;

/// Starts the thread, which looks at `board` whenever `bell` rings and calls `wake` when it has measured something.
pub fn start(bell: Bell<Plan, Results>, board: Arc<Board>, wake: Repaint) -> std::io::Result<Measurer> {
    Background::start("measure", bell, move |desk| run(desk, &board, &wake))
}

fn run(desk: &Desk<Plan, Results>, board: &Board, wake: &Repaint) {
    let mut records = Records::default();
    let (mut has_more, mut is_paused) = (false, false);
    while let Some(plan) = desk.wait(match () {
        () if is_paused => None,
        () if has_more => Some(Instant::now()),
        () => records.live_due(),
    }) {
        is_paused = plan.is_paused;
        let truth = plan.is_on.then(|| plan.given.or_rendered(plan.epoch, board.ground_truth())).flatten();
        let is_out_of_date = records.take_in(&plan, board);
        // One film at a time: between two, the board may have films that must not be missed.
        has_more = !is_paused && records.measure_next(&plan, truth.as_ref());
        if is_out_of_date || has_more {
            let measurements = Arc::new(records.measurements(&plan));
            desk.put(|finished| *finished = Some(measurements));
            wake();
        }
    }
}

/// A film at one moment.
struct Record {
    /// Let go where there are too many; the figures stay.
    film: Option<Arc<Snapshot>>,
    point: Option<Point>,
    /// How FLIP was measured.
    flip_display: Option<Display>,
}

impl Record {
    fn new(film: Arc<Snapshot>) -> Self {
        Self { film: Some(film), point: None, flip_display: None }
    }

    fn samples(&self) -> Option<u32> {
        self.film.as_ref().map(|film| film.samples).or(self.point.map(|point| point.samples))
    }

    fn is_due(&self, plan: &Plan, truth: &Halves, is_last: bool) -> bool {
        if self.film.as_ref().is_none_or(|film| film.size != truth.size) {
            return false;
        }
        self.point.is_none_or(|point| {
            truth.samples >= point.truth_samples.saturating_mul(BETTER_TRUTH)
                || (is_last && truth.samples != point.truth_samples)
                || (plan.metric == ErrorMetric::Flip && self.flip_display != Some(plan.display))
        })
    }

    fn measure(&mut self, plan: &Plan, truth: &Halves, more_seconds: f64) {
        let Some(film) = &self.film else { return };
        let flip_display = (plan.metric == ErrorMetric::Flip).then_some(plan.display);
        match measured(film, truth, more_seconds, flip_display) {
            Ok(point) => (self.point, self.flip_display) = (Some(point), flip_display),
            // Not every figure is finite, or the sizes differ: there is nothing to be measured in this film.
            Err(_) => self.film = None,
        }
    }
}

/// One mode's films.
#[derive(Default)]
struct Track {
    /// At doublings of the samples.
    records: Vec<Record>,
    /// As it is just now, where that is between two doublings.
    live: Option<Record>,
    live_since: Option<Instant>,
    newest: Option<Arc<Snapshot>>,
}

#[derive(Default)]
struct Records {
    epoch: u64,
    given: Given,
    tracks: BTreeMap<Mode, Track>,
    /// The images that `noise` is of.
    truth: Option<Arc<Halves>>,
    noise: Option<f64>,
}

impl Records {
    /// When a film as it is just now is to be measured next; `None`: there is no new one.
    fn live_due(&self) -> Option<Instant> {
        self.truth.as_ref()?;
        let newer = self.tracks.values().filter(|track| track.has_newer());
        newer.map(|track| track.live_since.map_or_else(Instant::now, |since| since + LIVE_PAUSE)).min()
    }

    /// Looks for films at doublings. `true` when what was measured is out of date.
    fn take_in(&mut self, plan: &Plan, board: &Board) -> bool {
        if !plan.is_on || plan.epoch != self.epoch || plan.given != self.given {
            let had_any = !self.tracks.is_empty();
            *self = Self { epoch: plan.epoch, given: plan.given.clone(), ..Self::default() };
            if !plan.is_on || had_any {
                return had_any;
            }
        }
        for (mode, film) in board.snapshots() {
            if film.epoch != self.epoch || film.is_preview() || film.samples == 0 {
                continue;
            }
            let track = self.tracks.entry(mode).or_default();
            let last = track.records.last().and_then(Record::samples);
            if last.is_none_or(|last| film.samples >= 2 * last) {
                track.records.push(Record::new(Arc::clone(&film)));
                track.live = None;
            }
            track.newest = Some(film);
        }
        self.let_go();
        false
    }

    /// Keeps memory bounded: the earliest films go first.
    fn let_go(&mut self) {
        let bytes = |record: &Record| record.film.as_ref().map_or(0, |film| size_of_val(&film.rgb[..]));
        let mut held: usize = self.tracks.values().flat_map(|track| &track.records).map(bytes).sum();
        while held > MOST_BYTES {
            let earliest = (self.tracks.values_mut())
                .filter_map(|track| {
                    let count = track.records.len();
                    track.records[..count.saturating_sub(1)].iter_mut().find(|record| record.film.is_some())
                })
                .min_by_key(|record| record.samples());
            let Some(record) = earliest else { return };
            held -= bytes(record);
            record.film = None;
        }
    }

    /// Measures one film that is due. `false` when there is none.
    fn measure_next(&mut self, plan: &Plan, truth: Option<&GroundTruth>) -> bool {
        let Some(halves) = truth.and_then(|truth| truth.halves.as_ref()) else {
            self.truth = None;
            return false;
        };
        let is_last = truth.is_some_and(|truth| truth.is_done);
        let is_other = self.truth.as_ref().is_none_or(|known| !Arc::ptr_eq(known, halves));
        if is_other {
            self.noise = noise(halves).filter(|_| halves.file.is_none());
            self.truth = Some(Arc::clone(halves));
        }
        for (mode, track) in &mut self.tracks {
            let more_seconds = plan.more_seconds(*mode);
            if let Some(record) = track.records.iter_mut().find(|record| record.is_due(plan, halves, is_last)) {
                record.measure(plan, halves, more_seconds);
                return true;
            }
            let may_look = track.live_since.is_none_or(|since| since.elapsed() >= LIVE_PAUSE);
            if may_look && track.has_newer() {
                track.live = track.newest.clone().map(Record::new);
                track.live_since = Some(Instant::now());
            }
            if let Some(record) = track.live.as_mut().filter(|record| record.is_due(plan, halves, is_last)) {
                record.measure(plan, halves, more_seconds);
                return true;
            }
        }
        is_other
    }

    fn measurements(&self, plan: &Plan) -> Measurements {
        let curves = self.tracks.iter().map(|(mode, track)| {
            let points = track.records.iter().chain(&track.live).filter_map(|record| record.point).collect();
            (*mode, Curve { points, rectification_seconds: plan.more_seconds(*mode) })
        });
        Measurements {
            epoch: self.epoch,
            size: self.truth.as_ref().map_or([0; 2], |truth| truth.size),
            curves: curves.collect(),
            truth_noise: self.noise,
        }
    }
}

impl Track {
    /// Whether the newest film is neither kept nor measured.
    fn has_newer(&self) -> bool {
        let known = self.live.as_ref().or(self.records.last()).and_then(Record::samples);
        self.newest.as_ref().is_some_and(|film| Some(film.samples) != known)
    }
}

/// Measures a film. FLIP needs to know how pictures are displayed.
fn measured(
    film: &Snapshot,
    truth: &Halves,
    more_seconds: f64,
    flip_display: Option<Display>,
) -> Result<Point, MetricError> {
    let [first, second] = &truth.rgb;
    let squared = difference_from_two(&film.rgb, [first, second])?;
    let smape = difference(&film.rgb, &truth.mean)?.smape;
    let flip_for = |display: Display| {
        let [width, height] = film.size.map(|side| side as usize);
        let viewed = flip::DEFAULT_PIXELS_PER_DEGREE;
        Ok(flip::Reference::displayed(&truth.mean, width, height, viewed, display)?.flip(&film.rgb)?.mean())
    };
    let flip = flip_display.map(flip_for).transpose()?;
    Ok(Point {
        samples: film.samples,
        seconds: film.seconds + more_seconds,
        squared,
        smape,
        flip,
        relmse_standard_error: standard_error(&film.rgb, truth),
        truth_samples: truth.samples,
    })
}

/// The standard error of relMSE as a mean over pixels that are independent of each other.
fn standard_error(image: &[[f32; 3]], truth: &Halves) -> f64 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for (((x, a), b), r) in image.iter().zip(&truth.rgb[0]).zip(&truth.rgb[1]).zip(&truth.mean) {
        let relative: f64 = (0..3)
            .map(|channel| {
                let [x, a, b, r] = [x, a, b, r].map(|rgb| f64::from(rgb[channel]));
                (x - a) * (x - b) / (r * r + 0.01)
            })
            .sum();
        sum += relative / 3.0;
        squares += (relative / 3.0).powi(2);
    }
    let count = image.len().max(2) as f64;
    ((squares / count - (sum / count).powi(2)).max(0.0) / (count - 1.0)).sqrt()
}

/// The noise of the mean of both halves, as relMSE: half of their difference is as noisy as their mean.
fn noise(truth: &Halves) -> Option<f64> {
    let [first, second] = &truth.rgb;
    let mut sum = 0.0;
    for ((a, b), r) in first.iter().zip(second).zip(&truth.mean) {
        for channel in 0..3 {
            let half = 0.5 * (f64::from(a[channel]) - f64::from(b[channel]));
            sum += half * half / (f64::from(r[channel]).powi(2) + 0.01);
        }
    }
    let noise = sum / (3.0 * first.len() as f64);
    noise.is_finite().then_some(noise)
}
