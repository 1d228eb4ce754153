//! Develops films into pictures: exposure, tone curve, false colour of differences. On a thread of its own, so that neither the window
//! nor the renderer waits.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Instant;

use egui::{Color32, ColorImage};

use super::background::{Background, Bell, Desk, Repaint};
use super::settings::{DifferenceKind, PaneContent};
use super::theme::opaque;
use crate::color::along;
use crate::export::color_map::{diverging, luminance};
use crate::measure::flip;
use crate::render::Display;
use crate::session::{Board, Halves, PaintedSurfaces, Snapshot};

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recipe {
    pub contents: BTreeSet<PaneContent>,
    pub display: Display,
    pub difference: DifferenceKind,
}

/// FLIP takes far longer than everything else here: after it the thread pauses for this many times the time it took.
const FLIP_REST: u32 = 3;

/// A picture, ready to be uploaded.
#[derive(Debug, Clone)]
pub struct Picture {
    pub image: Arc<ColorImage>,
    pub about: About,
}

/// What is known of a picture.
#[derive(Debug, Clone, Default)]
pub struct About {
    pub source: Source,
    /// For a difference: the mean over all pixels of the absolute difference in linear luminance, or of FLIP where that is shown.
    pub mean_difference: Option<(DifferenceKind, f64)>,
    /// FLIP of every pixel, for a difference that shows it.
    pub flip: Option<Arc<Vec<f32>>>,
}

/// What a picture was made from.
#[derive(Debug, Clone, Default)]
pub struct Source {
    /// One film, or two for a difference.
    pub films: Vec<Arc<Snapshot>>,
    pub painted: Option<Arc<PaintedSurfaces>>,
    /// What the film is compared with, for an error.
    pub truth: Option<Arc<Halves>>,
}

impl Source {
    /// The two images, row by row, that a difference is of; `None` for anything else, or while they are not of one size.
    pub fn pair(&self) -> Option<[&[[f32; 3]]; 2]> {
        match (&self.films[..], &self.truth) {
            ([a, b], _) if a.size == b.size => Some([&a.rgb, &b.rgb]),
            ([film], Some(truth)) if film.size == truth.size => Some([&film.rgb, &truth.mean]),
            _ => None,
        }
    }

    /// Whether it is made from the very same images.
    fn is(&self, other: &Self) -> bool {
        fn same<T>(a: Option<&Arc<T>>, b: Option<&Arc<T>>) -> bool {
            a.map(Arc::as_ptr) == b.map(Arc::as_ptr)
        }
        self.films.len() == other.films.len()
            && self.films.iter().zip(&other.films).all(|(a, b)| Arc::ptr_eq(a, b))
            && same(self.painted.as_ref(), other.painted.as_ref())
            && same(self.truth.as_ref(), other.truth.as_ref())
    }

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

/// What is shown, each with its picture.
type Pictures = BTreeMap<PaneContent, Picture>;

/// The thread that develops. Its bell tells it that films have changed.
pub type Developer = Background<Recipe, Pictures>;

/// Starts the thread, which looks at `board` whenever `bell` rings and calls `wake` after each batch of pictures.
pub fn start(bell: Bell<Recipe, Pictures>, board: Arc<Board>, wake: Repaint) -> std::io::Result<Developer> {
    Background::start("develop", bell, move |desk| run(desk, &board, &wake))
}

fn run(desk: &Desk<Recipe, Pictures>, board: &Board, wake: &Repaint) {
    // What each picture was last made from and how.
    let mut made: BTreeMap<PaneContent, (Source, Display, DifferenceKind)> = BTreeMap::new();
    let mut rest_until = Instant::now();
    let mut has_put_off = false;
    while let Some(recipe) = desk.wait(has_put_off.then_some(rest_until)) {
        // One look at the board for all pictures, so that panes show the same number of samples.
        let sources = sources(&recipe, board);
        made.retain(|content, _| recipe.contents.contains(content));
        let mut batch = BTreeMap::new();
        let begin = Instant::now();
        let is_resting = begin < rest_until;
        has_put_off = false;
        let mut has_flip = false;
        for (content, source) in sources {
            let is_same = made.get(&content).is_some_and(|(old, display, kind)| {
                old.is(&source)
                    && (source.painted.is_some() || *display == recipe.display)
                    && (!content.is_difference() || *kind == recipe.difference)
            });
            if is_same {
                continue;
            }
            if content.is_difference() && recipe.difference == DifferenceKind::Flip {
                if is_resting {
                    has_put_off = true;
                    continue;
                }
                has_flip = true;
            }
            if let Some(picture) = develop(content, &source, &recipe) {
                made.insert(content, (source, recipe.display, recipe.difference));
                batch.insert(content, picture);
            }
        }
        if has_flip {
            rest_until = Instant::now() + begin.elapsed() * FLIP_REST;
        }
        if !batch.is_empty() {
            desk.put(|finished| finished.append(&mut batch));
            wake();
        }
    }
}

/// What there is to make pictures from.
fn sources(recipe: &Recipe, board: &Board) -> Vec<(PaneContent, Source)> {
    let snapshots = board.snapshots();
    let paintings = board.paintings();
    let truth = board.ground_truth();
    let source = |content: PaneContent| {
        let films: Option<Vec<_>> = content.modes().map(|mode| snapshots.get(&mode).cloned()).collect();
        let source = Source { films: films?, ..Source::default() };
        Some(match content {
            PaneContent::Mode(_) | PaneContent::Difference(..) => source,
            PaneContent::Surfaces(quantity) => {
                Source { painted: Some(Arc::clone(paintings.get(&quantity)?)), ..source }
            }
            PaneContent::Error(_) => {
                let truth = truth.as_ref().filter(|truth| source.films.iter().all(|film| film.epoch == truth.epoch))?;
                Source { truth: Some(Arc::clone(truth.halves.as_ref()?)), ..source }
            }
        })
    };
    recipe.contents.iter().filter_map(|content| Some((*content, source(*content)?))).collect()
}

/// `None` while the two images of a difference are not of the same size, or cannot be compared.
fn develop(content: PaneContent, source: &Source, recipe: &Recipe) -> Option<Picture> {
    let finish = |size: [u32; 2], pixels: Vec<Color32>| {
        let image = Arc::new(ColorImage::new(size.map(|side| side as usize), pixels));
        Picture { image, about: About { source: source.clone(), ..About::default() } }
    };
    if let Some(painted) = &source.painted {
        let pixels = painted.painting.pixels().map(opaque).collect();
        return Some(finish([painted.painting.width, painted.painting.height], pixels));
    }
    let size = source.films.first()?.size;
    if !content.is_difference() {
        let pixels = source.films[0].rgb.iter().map(|rgb| recipe.display.encode(*rgb));
        return Some(finish(size, pixels.map(opaque).collect()));
    }
    let [a, b] = source.pair()?;
    if recipe.difference == DifferenceKind::Flip {
        let [width, height] = size.map(|side| side as usize);
        let viewed = flip::DEFAULT_PIXELS_PER_DEGREE;
        let reference = flip::Reference::displayed(b, width, height, viewed, recipe.display).ok()?;
        let flip = reference.flip(a).ok()?;
        let mut picture = finish(size, flip.error.iter().map(|x| flip_color(*x)).collect());
        picture.about.mean_difference = Some((recipe.difference, flip.mean()));
        picture.about.flip = Some(Arc::new(flip.error));
        return Some(picture);
    }
    let gain = recipe.display.exposure.exp2();
    let is_signed = recipe.difference == DifferenceKind::Signed;
    let differences = || a.iter().zip(b).map(|(a, b)| luminance(*a) - luminance(*b));
    let mean = differences().map(|d| f64::from(d.abs())).sum::<f64>() / a.len().max(1) as f64;
    let mut picture = finish(size, differences().map(|d| difference_color(d * gain, is_signed)).collect());
    picture.about.mean_difference = Some((recipe.difference, mean));
    Some(picture)
}

/// The colour of a difference in luminance, full at ±1. Signed: blue where the first is darker, black where equal, orange where it is
/// brighter, as in exports. Absolute: black through purple and orange to pale yellow. NaN is magenta, as everywhere.
pub fn difference_color(difference: f32, is_signed: bool) -> Color32 {
    // A root shows small differences, which are what one looks for.
    let size = difference.abs().sqrt();
    if is_signed { opaque(diverging(size.copysign(difference))) } else { sequential(size) }
}

/// The colour of FLIP: from black at 0 to pale yellow at 1, evenly.
pub fn flip_color(flip: f32) -> Color32 {
    sequential(flip)
}

/// Of a number in [0, 1].
fn sequential(size: f32) -> Color32 {
    // After the map "inferno" of Smith and van der Walt (2015), which is even to the eye and safe for colour-blind ones.
    const STOPS: [[u8; 3]; 6] =
        [[8, 8, 10], [66, 10, 104], [147, 38, 103], [221, 81, 58], [252, 165, 10], [252, 255, 164]];
    opaque(along(&STOPS, size * (STOPS.len() - 1) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracking::Mode;

    fn film(mode: Mode, rgb: Vec<[f32; 3]>) -> Arc<Snapshot> {
        Snapshot::of(mode, [rgb.len() as u32, 1], rgb)
    }

    fn of(films: &[&Arc<Snapshot>]) -> Source {
        Source { films: films.iter().map(|film| Arc::clone(film)).collect(), ..Source::default() }
    }

    const PAIR: PaneContent = PaneContent::Difference(Mode::Naive, Mode::Stack);

    #[test]
    fn a_mode_is_shown_as_the_display_encodes_it() {
        let recipe = Recipe { display: Display { exposure: 1.0, ..Display::default() }, ..Recipe::default() };
        let film = film(Mode::Naive, vec![[0.1, 0.2, 0.3]]);
        let picture = develop(PaneContent::Mode(Mode::Naive), &of(&[&film]), &recipe).unwrap();
        assert_eq!(picture.image.pixels, [opaque(recipe.display.encode([0.1, 0.2, 0.3]))]);
    }

    #[test]
    fn differences_show_sign_and_size() {
        let (a, b) = (film(Mode::Naive, vec![[0.0; 3], [1.0; 3]]), film(Mode::Stack, vec![[1.0; 3], [0.0; 3]]));
        let with = |difference| Recipe { difference, ..Recipe::default() };
        let signed = develop(PAIR, &of(&[&a, &b]), &with(DifferenceKind::Signed)).unwrap();
        let pixels = &signed.image.pixels;
        assert!(pixels[0].b() > pixels[0].r() && pixels[1].r() > pixels[1].b());
        let absolute = develop(PAIR, &of(&[&a, &b]), &with(DifferenceKind::Absolute)).unwrap();
        assert_eq!(absolute.image.pixels[0], absolute.image.pixels[1]);
        assert!((absolute.about.mean_difference.unwrap().1 - 1.0).abs() < 1e-6);
        assert!(difference_color(0.0, true).r() < 20 && difference_color(0.0, false).r() < 20);
        let short = film(Mode::Stack, vec![[0.0; 3]]);
        assert!(develop(PAIR, &of(&[&a, &short]), &Recipe::default()).is_none());
        assert_eq!(difference_color(f32::NAN, true), Color32::from_rgb(255, 0, 255));
    }

    #[test]
    fn flip_is_nothing_for_equal_pictures_and_seen_where_they_differ() {
        let recipe = Recipe { difference: DifferenceKind::Flip, ..Recipe::default() };
        let (dark, half) = (vec![[0.05; 3]; 64], (0..64).map(|x| if x < 32 { [0.05; 3] } else { [0.9; 3] }).collect());
        let (a, b) = (film(Mode::Naive, dark.clone()), film(Mode::Stack, half));
        let equal = develop(PAIR, &of(&[&a, &film(Mode::Stack, dark)]), &recipe).unwrap();
        assert!(equal.about.mean_difference.unwrap().1 < 1e-4);
        let other = develop(PAIR, &of(&[&a, &b]), &recipe).unwrap();
        let flip = other.about.flip.unwrap();
        assert!(flip[60] > 0.5 && flip[2] < 0.2, "{flip:?}");
    }

    #[test]
    fn an_error_is_against_the_ground_truth() {
        let a = film(Mode::Naive, vec![[0.5; 3]; 2]);
        let rgb = [vec![[0.25; 3]; 2], vec![[0.75; 3]; 2]];
        let truth = Halves { size: [2, 1], samples: 1, rgb, mean: vec![[0.4; 3]; 2] };
        let source = Source { truth: Some(Arc::new(truth)), ..of(&[&a]) };
        let recipe = Recipe { difference: DifferenceKind::Signed, ..Recipe::default() };
        let picture = develop(PaneContent::Error(Mode::Naive), &source, &recipe).unwrap();
        assert!((picture.about.mean_difference.unwrap().1 - 0.1).abs() < 1e-6);
        assert!(picture.image.pixels[0].r() > picture.image.pixels[0].b(), "brighter than the truth");
        assert!(develop(PaneContent::Error(Mode::Naive), &of(&[&a]), &recipe).is_none());
    }
}
