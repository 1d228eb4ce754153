//! Develops films into pictures: exposure, tone curve, false colour of differences. On a thread of its own, so that neither the window
//! nor the renderer waits.

mod source;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Instant;

use egui::{Color32, ColorImage};

pub use self::source::Source;
use self::source::sources;
use super::background::{Background, Bell, Desk, Repaint};
use super::enlarge::enlarged;
use super::histogram::{self, Histogram};
use super::measurement::Given;
use super::range::{self, DifferenceRange, RangeEnd, Scale};
use super::settings::{DifferenceKind, PaneContent};
use super::snapshots::Snapshots;
use super::theme::opaque;
use crate::color::along;
use crate::export::color_map::{diverging, luminance};
use crate::measure::flip;
use crate::render::Display;
use crate::render::denoise::denoised;
use crate::session::Board;

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recipe {
    pub contents: BTreeSet<PaneContent>,
    pub display: Display,
    pub difference: DifferenceKind,
    pub range: DifferenceRange,
    pub snapshots: Snapshots,
    /// What errors are told against; `None`: the ground truth that is rendered.
    pub given: Given,
    /// The pane whose pixels are counted.
    pub histogram_of: Option<PaneContent>,
    /// Whether noise is smoothed away in pictures of modes.
    pub denoise: bool,
}

/// FLIP and denoising take far longer than everything else here: after them the thread pauses for this many times the time it took.
const REST: u32 = 3;

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
    /// For a difference in luminance: the scale of its colours.
    pub scale: Option<Scale>,
    /// Where it was asked for.
    pub histogram: Option<Arc<Histogram>>,
    /// FLIP of every pixel, for a difference that shows it.
    pub flip: Option<Arc<Vec<f32>>>,
    /// Whether noise was smoothed away.
    pub is_denoised: bool,
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
    let mut made: BTreeMap<PaneContent, (Source, How)> = BTreeMap::new();
    let mut ends = Ends::default();
    let mut rest_until = Instant::now();
    let mut has_put_off = false;
    while let Some(recipe) = desk.wait(has_put_off.then_some(rest_until)) {
        // One look at the board for all pictures, so that panes show the same number of samples.
        let sources = sources(&recipe, board);
        made.retain(|content, _| recipe.contents.contains(content));
        let scales = ends.scales(&recipe, &sources);
        let mut batch = BTreeMap::new();
        let begin = Instant::now();
        let is_resting = begin < rest_until;
        has_put_off = false;
        let mut has_slow = false;
        for (content, source) in sources {
            let how = How::of(content, &recipe, scales.get(&content).copied());
            if made.get(&content).is_some_and(|(old, known)| old.is(&source) && *known == how) {
                continue;
            }
            let is_denoised = how.denoise && source.films.iter().any(|film| film.variances.is_some());
            let is_slow = how.difference == Some(DifferenceKind::Flip) || is_denoised;
            if is_slow {
                if is_resting {
                    has_put_off = true;
                    continue;
                }
                has_slow = true;
            }
            if let Some(picture) = develop(&source, how) {
                made.insert(content, (source, how));
                batch.insert(content, picture);
            }
        }
        if has_slow {
            rest_until = Instant::now() + begin.elapsed() * REST;
        }
        if !batch.is_empty() {
            desk.put(|finished| finished.append(&mut batch));
            wake();
        }
    }
}

/// All that decides how a picture is made.
#[derive(Debug, Clone, Copy, PartialEq)]
struct How {
    /// `None` where it does not matter.
    display: Option<Display>,
    difference: Option<DifferenceKind>,
    scale: Option<Scale>,
    has_histogram: bool,
    /// Whether noise is smoothed away.
    denoise: bool,
}

impl How {
    fn of(content: PaneContent, recipe: &Recipe, scale: Option<Scale>) -> Self {
        let difference = content.is_difference().then_some(recipe.difference);
        let is_displayed = match content {
            PaneContent::Surfaces(_) | PaneContent::Slice(_) => false,
            _ => difference.is_none_or(|kind| kind == DifferenceKind::Flip),
        };
        Self {
            display: is_displayed.then_some(recipe.display),
            difference,
            scale,
            has_histogram: recipe.histogram_of == Some(content),
            denoise: recipe.denoise && matches!(content, PaneContent::Mode(_)),
        }
    }
}

/// Where automatic ranges end, and of which images that is.
#[derive(Default)]
struct Ends(BTreeMap<PaneContent, (Source, f32)>);

impl Ends {
    /// The scale of every difference in luminance.
    fn scales(&mut self, recipe: &Recipe, sources: &[(PaneContent, Source)]) -> BTreeMap<PaneContent, Scale> {
        let curve = recipe.range.curve;
        let is_shown = |content: &PaneContent| content.is_difference() && recipe.difference != DifferenceKind::Flip;
        let contents = || sources.iter().map(|(content, _)| *content).filter(is_shown);
        let end = match recipe.range.end {
            RangeEnd::Exposure => (-recipe.display.exposure).exp2(),
            RangeEnd::Fixed(end) => end,
            RangeEnd::Automatic => {
                self.find(sources, is_shown);
                let known = |content: &PaneContent| self.0.get(content).map(|(_, end)| *end);
                if !recipe.range.is_shared {
                    return contents().filter_map(|c| Some((c, Scale { end: known(&c)?, curve }))).collect();
                }
                contents().filter_map(|content| known(&content)).reduce(f32::max).unwrap_or(1.0)
            }
        };
        contents().map(|content| (content, Scale { end, curve })).collect()
    }

    /// Finds the ends for images that are new.
    fn find(&mut self, sources: &[(PaneContent, Source)], is_shown: impl Fn(&PaneContent) -> bool) {
        self.0.retain(|content, _| sources.iter().any(|(shown, _)| shown == content));
        for (content, source) in sources.iter().filter(|(content, _)| is_shown(content)) {
            if self.0.get(content).is_some_and(|(known, _)| known.is(source)) {
                continue;
            }
            if let Some(pair) = source.pair() {
                self.0.insert(*content, (source.clone(), range::automatic_end(luminance_differences(pair))));
            }
        }
    }
}

fn luminance_differences([a, b]: [&[[f32; 3]]; 2]) -> impl Iterator<Item = f32> {
    a.iter().zip(b).map(|(a, b)| luminance(*a) - luminance(*b))
}

/// `None` while the two images of a difference are not of the same size, or cannot be compared.
fn develop(source: &Source, how: How) -> Option<Picture> {
    let finish = |size: [u32; 2], pixels: Vec<Color32>| {
        let image = Arc::new(ColorImage::new(size.map(|side| side as usize), pixels));
        Picture { image, about: About { source: source.clone(), ..About::default() } }
    };
    if let Some(painted) = &source.painted {
        let pixels = painted.painting.pixels().map(opaque).collect();
        return Some(finish([painted.painting.width, painted.painting.height], pixels));
    }
    let first = source.images().next()?;
    let size = first.size;
    let display = how.display.unwrap_or_default();
    let Some(kind) = how.difference else {
        let smooth = first.variances.as_ref().filter(|_| how.denoise);
        let smooth = smooth.map(|variances| denoised(&first.rgb, size[0] as usize, variances));
        let pixels = smooth.as_ref().unwrap_or(&first.rgb).iter().map(|rgb| display.encode(*rgb));
        let mut picture = finish(size, pixels.map(opaque).collect());
        picture.about.is_denoised = smooth.is_some();
        if first.is_preview() {
            picture.image = Arc::new(enlarged(Arc::unwrap_or_clone(picture.image), first.full_size));
        }
        if how.has_histogram {
            let counted = histogram::Radiance::of(&first.rgb);
            picture.about.histogram = Some(Arc::new(Histogram::Radiance(Box::new(counted))));
        }
        return Some(picture);
    };
    let count = |places: &mut dyn Iterator<Item = f32>| {
        how.has_histogram.then(|| Arc::new(Histogram::Difference(Box::new(histogram::Difference::of(kind, places)))))
    };
    let pair @ [a, b] = source.pair()?;
    if kind == DifferenceKind::Flip {
        let [width, height] = size.map(|side| side as usize);
        let viewed = flip::DEFAULT_PIXELS_PER_DEGREE;
        let reference = flip::Reference::displayed(b, width, height, viewed, display).ok()?;
        let flip = reference.flip(a).ok()?;
        let mut picture = finish(size, flip.error.iter().map(|x| flip_color(*x)).collect());
        picture.about.mean_difference = Some((kind, flip.mean()));
        picture.about.histogram = count(&mut flip.error.iter().copied());
        picture.about.flip = Some(Arc::new(flip.error));
        return Some(picture);
    }
    let is_signed = kind == DifferenceKind::Signed;
    let scale = how.scale?;
    let mean = luminance_differences(pair).map(|d| f64::from(d.abs())).sum::<f64>() / a.len().max(1) as f64;
    let colors = luminance_differences(pair).map(|d| difference_color(scale.place(d), is_signed));
    let mut picture = finish(size, colors.collect());
    picture.about.mean_difference = Some((kind, mean));
    picture.about.scale = Some(scale);
    picture.about.histogram = count(&mut luminance_differences(pair).map(|d| scale.place(d)));
    Some(picture)
}

/// The colour at a place of a scale of differences, which ends at ±1. Signed: blue where the first is darker, black where equal, orange
/// where it is brighter, as in exports. Absolute: black through purple and orange to pale yellow. NaN is magenta, as everywhere.
pub fn difference_color(place: f32, is_signed: bool) -> Color32 {
    if is_signed { opaque(diverging(place)) } else { sequential(place.abs()) }
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
    use crate::app::snapshots::{Kept, SnapshotId};
    use crate::session::{Halves, Snapshot};
    use crate::tracking::Mode;

    fn film(mode: Mode, rgb: Vec<[f32; 3]>) -> Arc<Snapshot> {
        Snapshot::of(mode, [rgb.len() as u32, 1], rgb)
    }

    fn developed(content: PaneContent, source: &Source, recipe: &Recipe) -> Option<Picture> {
        let scales = Ends::default().scales(recipe, &[(content, source.clone())]);
        develop(source, How::of(content, recipe, scales.get(&content).copied()))
    }

    fn of(films: &[&Arc<Snapshot>]) -> Source {
        Source { films: films.iter().map(|film| Arc::clone(film)).collect(), ..Source::default() }
    }

    const PAIR: PaneContent = PaneContent::Difference(Mode::Naive, Mode::Stack);

    #[test]
    fn a_mode_is_shown_as_the_display_encodes_it() {
        let recipe = Recipe { display: Display { exposure: 1.0, ..Display::default() }, ..Recipe::default() };
        let film = film(Mode::Naive, vec![[0.1, 0.2, 0.3]]);
        let picture = developed(PaneContent::Mode(Mode::Naive), &of(&[&film]), &recipe).unwrap();
        assert_eq!(picture.image.pixels, [opaque(recipe.display.encode([0.1, 0.2, 0.3]))]);
    }

    #[test]
    fn differences_show_sign_and_size() {
        let (a, b) = (film(Mode::Naive, vec![[0.0; 3], [1.0; 3]]), film(Mode::Stack, vec![[1.0; 3], [0.0; 3]]));
        let with = |difference| Recipe { difference, ..Recipe::default() };
        let signed = developed(PAIR, &of(&[&a, &b]), &with(DifferenceKind::Signed)).unwrap();
        let pixels = &signed.image.pixels;
        assert!(pixels[0].b() > pixels[0].r() && pixels[1].r() > pixels[1].b());
        let absolute = developed(PAIR, &of(&[&a, &b]), &with(DifferenceKind::Absolute)).unwrap();
        assert_eq!(absolute.image.pixels[0], absolute.image.pixels[1]);
        assert!((absolute.about.mean_difference.unwrap().1 - 1.0).abs() < 1e-6);
        assert!(difference_color(0.0, true).r() < 20 && difference_color(0.0, false).r() < 20);
        let short = film(Mode::Stack, vec![[0.0; 3]]);
        assert!(developed(PAIR, &of(&[&a, &short]), &Recipe::default()).is_none());
        assert_eq!(difference_color(f32::NAN, true), Color32::from_rgb(255, 0, 255));
    }

    #[test]
    fn a_change_is_what_is_now_less_what_was_kept() {
        let description = Arc::new(crate::formats::open("plain-glass").unwrap());
        let keep =
            |film: &Arc<Snapshot>| Arc::new(Kept::new(Arc::clone(film), Arc::clone(&description), description.camera));
        let (now, before) = (film(Mode::Naive, vec![[0.5; 3]; 4]), film(Mode::Naive, vec![[0.2; 3]; 4]));
        let source = Source { kept: vec![keep(&before)], ..of(&[&now]) };
        let recipe = Recipe { difference: DifferenceKind::Signed, ..Recipe::default() };
        let picture = developed(PaneContent::Change(Mode::Naive, SnapshotId::A), &source, &recipe).unwrap();
        assert!((picture.about.mean_difference.unwrap().1 - 0.3).abs() < 1e-6);
        assert!(picture.image.pixels[0].r() > picture.image.pixels[0].b(), "it is brighter now");
        let both = Source { kept: vec![keep(&before), keep(&now)], ..Source::default() };
        let picture = developed(PaneContent::SnapshotDifference, &both, &recipe).unwrap();
        assert!(picture.image.pixels[0].r() < picture.image.pixels[0].b(), "A is darker than B");
        let alone = Source { kept: vec![keep(&before)], ..Source::default() };
        let picture = developed(PaneContent::Snapshot(SnapshotId::A), &alone, &recipe).unwrap();
        assert_eq!(picture.image.pixels[0], opaque(recipe.display.encode([0.2; 3])));
    }

    #[test]
    fn automatic_ranges_are_shared_unless_said_otherwise() {
        let dark = film(Mode::Stack, vec![[0.0; 3]; 9]);
        let (near, far) = (film(Mode::Naive, vec![[0.02; 3]; 9]), film(Mode::Priority, vec![[1.5; 3]; 9]));
        let pairs =
            [(PAIR, of(&[&near, &dark])), (PaneContent::Difference(Mode::Priority, Mode::Stack), of(&[&far, &dark]))];
        let ends = |range: DifferenceRange, exposure: f32| {
            let display = Display { exposure, ..Display::default() };
            let recipe = Recipe { range, display, ..Recipe::default() };
            let scales = Ends::default().scales(&recipe, &pairs);
            pairs.iter().map(|(content, _)| scales[content].end).collect::<Vec<_>>()
        };
        let automatic = DifferenceRange { end: RangeEnd::Automatic, ..DifferenceRange::default() };
        let near =
            |ends: Vec<f32>, expected: [f32; 2]| ends.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-5);
        assert!(near(ends(automatic, 3.0), [2.0, 2.0]));
        assert!(near(ends(DifferenceRange { is_shared: false, ..automatic }, 0.0), [0.02, 2.0]));
        assert!(near(ends(DifferenceRange::default(), 1.0), [0.5, 0.5]));
        assert!(near(ends(DifferenceRange { end: RangeEnd::Fixed(0.3), ..automatic }, 1.0), [0.3, 0.3]));
    }

    #[test]
    fn a_difference_at_the_end_of_its_range_has_the_last_colour() {
        let (a, b) = (film(Mode::Naive, vec![[0.3; 3], [0.1; 3]]), film(Mode::Stack, vec![[0.0; 3]; 2]));
        for (end, is_full) in [(0.3, [true, false]), (0.05, [true, true]), (3.0, [false, false])] {
            let range = DifferenceRange { end: RangeEnd::Fixed(end), ..DifferenceRange::default() };
            let picture = developed(PAIR, &of(&[&a, &b]), &Recipe { range, ..Recipe::default() }).unwrap();
            let last = difference_color(1.0, false);
            assert_eq!([0, 1].map(|i| picture.image.pixels[i] == last), is_full, "{end}");
            assert_eq!(picture.about.scale.unwrap().end, end);
        }
    }

    #[test]
    fn flip_is_nothing_for_equal_pictures_and_seen_where_they_differ() {
        let recipe = Recipe { difference: DifferenceKind::Flip, ..Recipe::default() };
        let (dark, half) = (vec![[0.05; 3]; 64], (0..64).map(|x| if x < 32 { [0.05; 3] } else { [0.9; 3] }).collect());
        let (a, b) = (film(Mode::Naive, dark.clone()), film(Mode::Stack, half));
        let equal = developed(PAIR, &of(&[&a, &film(Mode::Stack, dark)]), &recipe).unwrap();
        assert!(equal.about.mean_difference.unwrap().1 < 1e-4);
        let other = developed(PAIR, &of(&[&a, &b]), &recipe).unwrap();
        let flip = other.about.flip.unwrap();
        assert!(flip[60] > 0.5 && flip[2] < 0.2, "{flip:?}");
    }

    #[test]
    fn an_error_is_against_the_ground_truth() {
        let a = film(Mode::Naive, vec![[0.5; 3]; 2]);
        let rgb = [vec![[0.25; 3]; 2], vec![[0.75; 3]; 2]];
        let truth = Halves { size: [2, 1], samples: 1, file: None, rgb, mean: vec![[0.4; 3]; 2] };
        let source = Source { truth: Some(Arc::new(truth)), ..of(&[&a]) };
        let recipe = Recipe { difference: DifferenceKind::Signed, ..Recipe::default() };
        let picture = developed(PaneContent::Error(Mode::Naive), &source, &recipe).unwrap();
        assert!((picture.about.mean_difference.unwrap().1 - 0.1).abs() < 1e-6);
        assert!(picture.image.pixels[0].r() > picture.image.pixels[0].b(), "brighter than the truth");
        assert!(developed(PaneContent::Error(Mode::Naive), &of(&[&a]), &recipe).is_none());
    }
}
