//! How far rendering is, how long it will take, and how to say so.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::state::State;
use crate::export::words::{brief, duration, grouped};
use crate::session::Snapshot;
use crate::tracking::Mode;

/// The films of the panes together. Where modes differ, the one that is farthest behind counts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Progress {
    /// Samples per pixel at full resolution.
    pub samples: u32,
    /// Samples at which rendering will stop, as far as is known; `None`: never.
    pub wanted: Option<u32>,
    /// Whether it is noise that decides that, so that the number is an estimate.
    pub is_estimated: bool,
    /// The mean relative error of a pixel in the noisiest film; `None` before two samples.
    pub noise: Option<f64>,
    /// Seconds until then; `None` where nobody can tell.
    pub seconds_to_go: Option<f64>,
    /// Whether there are films of all modes and nothing is left to do.
    pub is_done: bool,
}

impl Progress {
    /// Of the films that `state` asks for.
    pub fn of(state: &State) -> Self {
        let modes = state.settings.modes();
        // As rendering is divided: each lane renders its modes one after the other, the lanes at the same time.
        let (reference, main): (Vec<Mode>, Vec<Mode>) = modes.into_iter().partition(|mode| *mode == Mode::Reference);
        let lanes = [main, reference].into_iter().filter(|modes| !modes.is_empty());
        lanes.map(|modes| Self::of_lane(state, &modes)).reduce(Self::together).unwrap_or_default()
    }

    fn of_lane(state: &State, modes: &[Mode]) -> Self {
        let limit = state.settings.sample_limit;
        let Some(films) = films(&state.films, state.epoch(), modes) else {
            return Self { wanted: limit, ..Self::default() };
        };
        let samples = films.iter().map(|film| film.samples).min().unwrap_or(0);
        let noises: Option<Vec<f64>> = films.iter().map(|film| film.noise).collect();
        let noise = noises.and_then(|noises| noises.into_iter().reduce(f64::max));
        let is_done = films.iter().all(|film| film.is_done);
        // Noise falls as one over the root of the samples.
        let clean = (noise.zip(state.noise_target())).map(|(noise, target)| {
            (f64::from(samples) * (noise / target).powi(2)).ceil().min(f64::from(u32::MAX)) as u32
        });
        let is_estimated = clean.is_some_and(|clean| limit.is_none_or(|limit| clean < limit));
        let wanted = if is_estimated { clean } else { limit }.map(|wanted| wanted.max(samples));
        let per_sample: f64 = films.iter().map(|film| film.seconds / f64::from(film.samples.max(1))).sum();
        let seconds_to_go = wanted.map(|wanted| per_sample * f64::from(wanted - samples));
        Self { samples, wanted, is_estimated, noise, seconds_to_go, is_done }
    }

    fn together(self, other: Self) -> Self {
        let (behind, ahead) = if self.share() <= other.share() { (self, other) } else { (other, self) };
        let seconds_to_go = [self, other].map(|lane| lane.seconds_to_go).into_iter().flatten().reduce(f64::max);
        let noise = [self, other].map(|lane| lane.noise).into_iter().flatten().reduce(f64::max);
        Self { seconds_to_go, noise, is_done: behind.is_done && ahead.is_done, ..behind }
    }

    /// The part of the samples that have been taken, in [0, 1]; 0 where there is no end.
    pub fn share(self) -> f32 {
        self.wanted.map_or(0.0, |wanted| (f64::from(self.samples) / f64::from(wanted.max(1))).min(1.0) as f32)
    }

    /// In words, most important first.
    pub fn words(self, is_paused: bool) -> Vec<String> {
        let samples =
            |count: u32| format!("{} {}", grouped(u64::from(count)), if count == 1 { "sample" } else { "samples" });
        let mut words = Vec::new();
        if self.is_done {
            let reason = if self.is_estimated { "done: noise target reached" } else { "done" };
            words.extend([reason.to_owned(), samples(self.samples)]);
        } else {
            words.push(if is_paused { "paused" } else { "rendering" }.to_owned());
            words.push(match self.wanted.filter(|_| !is_paused && self.samples > 0) {
                Some(wanted) => {
                    let about = if self.is_estimated { "about " } else { "" };
                    format!("{} of {about}{}", grouped(u64::from(self.samples)), samples(wanted))
                }
                None => samples(self.samples),
            });
        }
        if let Some(noise) = self.noise {
            words.push(format!("noise {} %", brief(100.0 * noise)));
        }
        if let Some(seconds) = self.seconds_to_go.filter(|_| !self.is_done && !is_paused && self.samples > 0) {
            words.push(format!("{} to go", duration(seconds.ceil().max(1.0))));
        }
        words
    }
}

/// The films of `modes` at full resolution, if all are there.
fn films<'a>(all: &'a BTreeMap<Mode, Arc<Snapshot>>, epoch: u64, modes: &[Mode]) -> Option<Vec<&'a Snapshot>> {
    let film = |mode: &Mode| all.get(mode).map(|film| &**film).filter(|film| film.epoch == epoch && !film.is_preview());
    modes.iter().map(film).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{PaneContent, Settings};

    fn state(films: &[(Mode, u32, Option<f64>, f64)]) -> State {
        let mut settings = Settings {
            pane_count: 2,
            sample_limit: Some(1000),
            noise_target: Some(0.01),
            has_first_panes: false,
            ..Settings::default()
        };
        settings.panes[0] = PaneContent::Mode(Mode::Stack);
        settings.panes[1] = PaneContent::Mode(Mode::Reference);
        let mut state = State::new(Arc::new(crate::formats::open("plain-glass").unwrap()), settings);
        for &(mode, samples, noise, seconds) in films {
            let film = Snapshot::of(mode, [1, 1], vec![[0.0; 3]]);
            let film = Snapshot { epoch: state.epoch(), samples, noise, seconds, ..Snapshot::clone(&film) };
            state.films.insert(mode, Arc::new(film));
        }
        state
    }

    #[test]
    fn the_mode_that_is_farthest_behind_counts() {
        let stack = (Mode::Stack, 64, Some(0.02), 6.4);
        let waiting = Progress::of(&state(&[stack]));
        assert_eq!((waiting.samples, waiting.wanted), (0, Some(1000)));
        let progress = Progress::of(&state(&[stack, (Mode::Reference, 16, Some(0.04), 16.0)]));
        assert_eq!((progress.samples, progress.wanted, progress.is_estimated), (16, Some(256), true));
        assert_eq!(progress.noise, Some(0.04));
        assert_eq!(progress.seconds_to_go, Some(240.0), "one second each");
        assert_eq!(progress.words(false), ["rendering", "16 of about 256 samples", "noise 4 %", "4 min 00 s to go"]);
        assert_eq!(progress.words(true), ["paused", "16 samples", "noise 4 %"]);
    }

    #[test]
    fn the_limit_counts_where_noise_would_take_longer() {
        let progress =
            Progress::of(&state(&[(Mode::Stack, 100, Some(0.5), 1.0), (Mode::Reference, 100, Some(0.4), 2.0)]));
        assert_eq!((progress.wanted, progress.is_estimated), (Some(1000), false));
        assert_eq!(progress.words(false)[1], "100 of 1,000 samples");
        assert!((progress.share() - 0.1).abs() < 1e-6);
        let done = Progress { is_done: true, is_estimated: true, ..progress };
        assert_eq!(done.words(false), ["done: noise target reached", "100 samples", "noise 50 %"]);
    }
}
