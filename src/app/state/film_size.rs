//! The size of the films: that of the panes when a picture begins, kept while it is good enough, so that samples are not lost where panes
//! change a little.

use super::State;

/// A film may be shown so much larger than one film pixel for each pixel of the screen before it is too coarse.
const MOST_MAGNIFICATION: f64 = 1.02;
/// A new picture may have so many times the pixels that its pane shows.
const MOST_WASTE: f64 = 1.25;
/// Panes that grow are waited for until they have had one size for so long, in seconds.
const SETTLING: f64 = 0.2;
/// A picture that is younger than this has few samples to lose, and is begun anew at once.
const YOUNG: f64 = 0.5;

/// What is known of the size of films and panes, in pixels.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FilmSize {
    /// Of the films.
    pub(super) film: [u32; 2],
    /// Of the panes.
    pane: [u32; 2],
    /// Since when panes have had that size, in seconds.
    pane_since: f64,
    /// When the picture began; `None`: in the next frame.
    picture_since: Option<f64>,
    /// Whether films are to fit the panes even where they would do as they are.
    must_fit: bool,
    /// The size that films have whatever that of the panes is.
    fixed: Option<[u32; 2]>,
}

impl FilmSize {
    /// A new picture begins: its films fit the panes, more or less.
    pub(super) fn begin(&mut self) {
        // Nearly the same size stays the same: earlier films of it may come back.
        let pixels = |size: [u32; 2]| size.map(f64::from).iter().product::<f64>();
        let fits = magnification(self.film, self.pane.map(f64::from)) <= MOST_MAGNIFICATION
            && pixels(self.film) <= MOST_WASTE * pixels(self.pane);
        if self.must_fit || !fits {
            self.film = self.pane;
        }
        self.film = self.fixed.unwrap_or(self.film);
        self.picture_since = None;
        self.must_fit = false;
    }

    /// Films of the panes' size are wanted, and no others.
    pub(super) fn fit(&mut self) {
        self.must_fit = true;
    }
}

/// How much a film of `film` pixels is magnified to cover `pane`.
pub fn magnification(film: [u32; 2], pane: [f64; 2]) -> f64 {
    let [across, down] = [0, 1].map(|side| pane[side] / f64::from(film[side].max(1)));
    across.max(down)
}

impl State {
    /// Says how large the panes are, in pixels, at `now_secs` of a steady clock. Returns after how many seconds it wants to be told again.
    pub fn set_pane_size(&mut self, pane: [u32; 2], now_secs: f64) -> Option<f64> {
        let size = &mut self.size;
        if pane != size.pane {
            (size.pane, size.pane_since) = (pane, now_secs);
        }
        let age = now_secs - *size.picture_since.get_or_insert(now_secs);
        if size.film.contains(&0) || size.must_fit {
            self.invalidate();
            return None;
        }
        if size.fixed.is_some() || magnification(size.film, pane.map(f64::from)) <= MOST_MAGNIFICATION {
            return None;
        }
        let rest = SETTLING - (now_secs - size.pane_since);
        if age > YOUNG && rest > 0.0 {
            return Some(rest);
        }
        // The same picture in another size: what is shown stays until the new films are as good.
        size.film = pane;
        self.next_epoch();
        None
    }

    /// Films of that size are wanted from now on, in pixels; `None`: such as fit the panes.
    pub(super) fn fix_film_size(&mut self, fixed: Option<[u32; 2]>) {
        let size = &mut self.size;
        if std::mem::replace(&mut size.fixed, fixed) == fixed {
            return;
        }
        if size.film != fixed.unwrap_or(size.pane) && !size.film.contains(&0) {
            size.fit();
            self.invalidate();
        }
    }

    /// Whether films have a size that is not the panes'.
    pub fn has_fixed_film_size(&self) -> bool {
        self.size.fixed.is_some()
    }

    /// Size of the films, in pixels.
    pub fn film_size(&self) -> [u32; 2] {
        self.size.film
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::app::Settings;

    fn state() -> State {
        let mut state = State::new(Arc::new(crate::formats::open("plain-glass").unwrap()), Settings::default());
        state.set_pane_size([400, 300], 0.0);
        state.set_pane_size([400, 300], 10.0);
        state
    }

    #[test]
    fn panes_that_shrink_keep_their_films() {
        let mut state = state();
        let epoch = state.epoch();
        for pane in [[400, 270], [300, 300], [200, 150], [200, 300], [400, 300], [405, 303]] {
            assert_eq!(state.set_pane_size(pane, 20.0), None);
            assert_eq!((state.film_size(), state.epoch()), ([400, 300], epoch), "{pane:?}");
        }
        // The next picture fits, if it would not nearly fit as it is.
        state.set_pane_size([400, 270], 20.0);
        state.invalidate();
        assert_eq!(state.film_size(), [400, 300]);
        state.set_pane_size([200, 300], 20.0);
        state.invalidate();
        assert_eq!(state.film_size(), [200, 300]);
    }

    #[test]
    fn a_fixed_size_is_that_of_the_films_whatever_the_panes_do() {
        let mut state = state();
        let epoch = state.epoch();
        state.fix_film_size(Some([64, 64]));
        assert!(state.film_size() == [64, 64] && state.epoch() > epoch);
        let epoch = state.epoch();
        for pane in [[40, 30], [4000, 3000], [64, 64]] {
            assert_eq!(state.set_pane_size(pane, 20.0), None);
            assert_eq!((state.film_size(), state.epoch()), ([64, 64], epoch), "{pane:?}");
        }
        state.set_pane_size([500, 300], 20.0);
        state.invalidate();
        assert_eq!(state.film_size(), [64, 64]);
        state.fix_film_size(None);
        assert_eq!(state.film_size(), [500, 300]);
        // What changes nothing loses no samples, also of films that are not quite as large as the panes.
        state.set_pane_size([490, 300], 30.0);
        let epoch = state.epoch();
        state.fix_film_size(None);
        assert_eq!((state.film_size(), state.epoch()), ([500, 300], epoch));
    }

    #[test]
    fn panes_that_grow_get_finer_films_once_they_rest() {
        let mut state = state();
        let (epoch, floor) = (state.epoch(), state.picture_floor());
        assert!(state.set_pane_size([500, 300], 20.0).is_some());
        assert!(state.set_pane_size([600, 300], 20.15).is_some());
        let rest = state.set_pane_size([600, 300], 20.3).unwrap();
        assert_eq!(state.epoch(), epoch);
        assert_eq!(state.set_pane_size([600, 300], 20.31 + rest), None);
        assert_eq!((state.film_size(), state.picture_floor()), ([600, 300], floor), "it shows the same");
        assert!(state.epoch() > epoch);
        // A picture that has just begun has nothing to lose.
        state.invalidate();
        state.set_pane_size([600, 300], 30.0);
        state.set_pane_size([700, 300], 30.1);
        assert_eq!(state.film_size(), [700, 300]);
    }
}
