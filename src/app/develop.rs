//! Develops films into pictures: exposure, tone curve, false colour of differences. On a thread of its own, so that neither the window
//! nor the renderer waits.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use egui::{Color32, ColorImage};

use super::settings::PaneContent;
use crate::export::color_map::{diverging, luminance};
use crate::render::Display;
use crate::render::worker::{Board, PaintedSurfaces, Snapshot};

/// How to develop.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recipe {
    pub contents: BTreeSet<PaneContent>,
    pub display: Display,
    pub signed_difference: bool,
}

/// A picture, ready to be uploaded.
#[derive(Debug, Clone)]
pub struct Picture {
    pub image: Arc<ColorImage>,
    pub source: Source,
    /// Mean over all pixels of the absolute difference in linear luminance, for a difference.
    pub mean_difference: Option<f64>,
}

/// What a picture was made from.
#[derive(Debug, Clone, Default)]
pub struct Source {
    /// One film, or two for a difference.
    pub films: Vec<Arc<Snapshot>>,
    /// Painted surfaces.
    pub painted: Option<Arc<PaintedSurfaces>>,
}

impl Source {
    /// The epochs of what it was made from.
    pub fn epochs(&self) -> impl Iterator<Item = u64> {
        self.films.iter().map(|film| film.epoch).chain(self.painted.iter().map(|painted| painted.epoch))
    }

    /// Whether any of it is at a lower resolution.
    pub fn is_preview(&self) -> bool {
        self.films.iter().any(|film| film.is_preview()) || self.painted.iter().any(|painted| painted.is_preview())
    }

    /// Whether nothing more will come.
    pub fn is_done(&self) -> bool {
        self.films.iter().all(|film| film.is_done) && self.painted.iter().all(|painted| painted.is_done())
    }

    /// Samples for each pixel.
    pub fn samples(&self) -> u32 {
        let painted = self.painted.iter().map(|painted| painted.painting.rays);
        self.films.iter().map(|film| film.samples).chain(painted).min().unwrap_or(0)
    }
}

#[derive(Default)]
struct Desk {
    recipe: Recipe,
    has_news: bool,
    is_closed: bool,
    finished: BTreeMap<PaneContent, Picture>,
}

struct Shared {
    desk: Mutex<Desk>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The handle to the thread. Dropping it ends the thread.
pub struct Developer {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// A way to tell a [`Developer`] that films have changed.
#[derive(Clone)]
pub struct Bell(Arc<Shared>);

impl Bell {
    /// A bell without a developer yet.
    pub fn new() -> Self {
        Self(Arc::new(Shared { desk: Mutex::new(Desk::default()), changed: Condvar::new() }))
    }

    pub fn ring(&self) {
        self.0.lock().has_news = true;
        self.0.changed.notify_all();
    }
}

impl Developer {
    /// Starts the thread, which looks at `board` whenever `bell` rings and calls `wake` after each batch of pictures.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn start(bell: Bell, board: Arc<Board>, wake: impl Fn() + Send + 'static) -> std::io::Result<Self> {
        let shared = bell.0;
        let thread = {
            let shared = Arc::clone(&shared);
            std::thread::Builder::new().name("develop".into()).spawn(move || run(&shared, &board, &wake))?
        };
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Says how to develop from now on.
    pub fn set_recipe(&self, recipe: &Recipe) {
        let mut desk = self.shared.lock();
        if desk.recipe != *recipe {
            desk.recipe = recipe.clone();
            desk.has_news = true;
            self.shared.changed.notify_all();
        }
    }

    /// The pictures finished since the last call.
    pub fn take_finished(&self) -> BTreeMap<PaneContent, Picture> {
        std::mem::take(&mut self.shared.lock().finished)
    }
}

impl Drop for Developer {
    fn drop(&mut self) {
        self.shared.lock().is_closed = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so already.
            let _ = thread.join();
        }
    }
}

fn run(shared: &Shared, board: &Board, wake: &dyn Fn()) {
    // What each picture was last made from and how.
    let mut made: BTreeMap<PaneContent, (Vec<Arc<Snapshot>>, Display, bool)> = BTreeMap::new();
    let mut painted: BTreeMap<PaneContent, Arc<PaintedSurfaces>> = BTreeMap::new();
    loop {
        let recipe = {
            let mut desk = shared.lock();
            while !desk.has_news && !desk.is_closed {
                desk = shared.changed.wait(desk).unwrap_or_else(PoisonError::into_inner);
            }
            if desk.is_closed {
                return;
            }
            desk.has_news = false;
            desk.recipe.clone()
        };
        // One look at the board for all pictures, so that panes show the same number of samples.
        let snapshots = board.snapshots();
        let paintings = board.paintings();
        made.retain(|content, _| recipe.contents.contains(content));
        painted.retain(|content, _| recipe.contents.contains(content));
        let mut batch = BTreeMap::new();
        for content in &recipe.contents {
            if let PaneContent::Surfaces(quantity) = content {
                let Some(new) = paintings.get(quantity) else { continue };
                if painted.get(content).is_some_and(|old| Arc::ptr_eq(old, new)) {
                    continue;
                }
                painted.insert(*content, Arc::clone(new));
                let size = [new.painting.width, new.painting.height].map(|side| side as usize);
                let pixels = new.painting.pixels().map(|[r, g, b]| Color32::from_rgb(r, g, b)).collect();
                let source = Source { films: Vec::new(), painted: Some(Arc::clone(new)) };
                let image = Arc::new(ColorImage::new(size, pixels));
                batch.insert(*content, Picture { image, source, mean_difference: None });
                continue;
            }
            let films: Vec<Arc<Snapshot>> = content.modes().filter_map(|mode| snapshots.get(&mode).cloned()).collect();
            if films.len() != content.modes().count() {
                continue;
            }
            let is_same = made.get(content).is_some_and(|(old, display, signed)| {
                old.len() == films.len()
                    && old.iter().zip(&films).all(|(a, b)| Arc::ptr_eq(a, b))
                    && (*display, *signed) == (recipe.display, recipe.signed_difference)
            });
            if is_same {
                continue;
            }
            if let Some(image) = develop(&films, &recipe) {
                made.insert(*content, (films.clone(), recipe.display, recipe.signed_difference));
                let mean_difference = mean_difference(&films);
                let source = Source { films, painted: None };
                batch.insert(*content, Picture { image: Arc::new(image), source, mean_difference });
            }
        }
        if !batch.is_empty() {
            shared.lock().finished.append(&mut batch);
            wake();
        }
    }
}

/// `None` while two films of a difference are not of the same size.
fn develop(films: &[Arc<Snapshot>], recipe: &Recipe) -> Option<ColorImage> {
    let size = films[0].size.map(|side| side as usize);
    let pixels = match films {
        [film] => (film.rgb.iter())
            .map(|rgb| {
                let [r, g, b] = recipe.display.encode(*rgb);
                Color32::from_rgb(r, g, b)
            })
            .collect(),
        [a, b] if a.size == b.size => {
            let gain = recipe.display.exposure.exp2();
            (a.rgb.iter().zip(&b.rgb))
                .map(|(a, b)| difference_color((luminance(*a) - luminance(*b)) * gain, recipe.signed_difference))
                .collect()
        }
        _ => return None,
    };
    Some(ColorImage::new(size, pixels))
}

fn mean_difference(films: &[Arc<Snapshot>]) -> Option<f64> {
    let [a, b] = films else { return None };
    let sum: f64 = a.rgb.iter().zip(&b.rgb).map(|(a, b)| f64::from((luminance(*a) - luminance(*b)).abs())).sum();
    Some(sum / a.rgb.len().max(1) as f64)
}

/// The colour of a difference in luminance, full at ±1. Signed: blue where the first is darker, black where equal, orange where it is
/// brighter, as in exports. Absolute: black through purple and orange to pale yellow. NaN is magenta, as everywhere.
pub fn difference_color(difference: f32, is_signed: bool) -> Color32 {
    if difference.is_nan() {
        return Color32::from_rgb(255, 0, 255);
    }
    // A root shows small differences, which are what one looks for.
    let size = difference.abs().min(1.0).sqrt();
    if is_signed {
        let [r, g, b] = diverging(size.copysign(difference));
        return Color32::from_rgb(r, g, b);
    }
    // After the map "inferno" of Smith and van der Walt (2015), which is even to the eye and safe for colour-blind ones.
    let stops: [[f32; 3]; 6] = [
        [8.0, 8.0, 10.0],
        [66.0, 10.0, 104.0],
        [147.0, 38.0, 103.0],
        [221.0, 81.0, 58.0],
        [252.0, 165.0, 10.0],
        [252.0, 255.0, 164.0],
    ];
    let place = size * (stops.len() - 1) as f32;
    let index = (place as usize).min(stops.len() - 2);
    let part = place - index as f32;
    let [r, g, b] = std::array::from_fn(|i| stops[index][i] + part * (stops[index + 1][i] - stops[index][i]));
    Color32::from_rgb(r as u8, g as u8, b as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Events;
    use crate::tracking::Mode;

    fn film(mode: Mode, rgb: Vec<[f32; 3]>) -> Arc<Snapshot> {
        Arc::new(Snapshot {
            epoch: 1,
            mode,
            size: [rgb.len() as u32, 1],
            full_size: [rgb.len() as u32, 1],
            rgb,
            samples: 1,
            events: Events::default(),
            seconds: 1.0,
            is_done: false,
        })
    }

    #[test]
    fn a_mode_is_shown_as_the_display_encodes_it() {
        let recipe = Recipe { display: Display { exposure: 1.0, ..Display::default() }, ..Recipe::default() };
        let image = develop(&[film(Mode::Naive, vec![[0.1, 0.2, 0.3]])], &recipe).unwrap();
        let [r, g, b] = recipe.display.encode([0.1, 0.2, 0.3]);
        assert_eq!(image.pixels, [Color32::from_rgb(r, g, b)]);
    }

    #[test]
    fn differences_show_sign_and_size() {
        let (a, b) = (film(Mode::Naive, vec![[0.0; 3], [1.0; 3]]), film(Mode::Stack, vec![[1.0; 3], [0.0; 3]]));
        let signed =
            develop(&[a.clone(), b.clone()], &Recipe { signed_difference: true, ..Recipe::default() }).unwrap();
        assert!(signed.pixels[0].b() > signed.pixels[0].r() && signed.pixels[1].r() > signed.pixels[1].b());
        let absolute = develop(&[a.clone(), b], &Recipe::default()).unwrap();
        assert_eq!(absolute.pixels[0], absolute.pixels[1]);
        assert!(difference_color(0.0, true).r() < 20 && difference_color(0.0, false).r() < 20);
        assert!(develop(&[a, film(Mode::Stack, vec![[0.0; 3]])], &Recipe::default()).is_none());
        assert_eq!(difference_color(f32::NAN, true), Color32::from_rgb(255, 0, 255));
    }
}
