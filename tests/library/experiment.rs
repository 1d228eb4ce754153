//! Error against run time, through real renders: references are found again and only if they are whole, an interrupted measurement goes on,
//! and a wrong mode shows as what it is.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use iorect::formats;
use iorect::measure::Interval;
use iorect::measure::statistics::t_quantile;
use iorect::render::{Film, ImageSettings, RenderTask};
use iorect::report::experiment::{Curve, Effort, SceneErrors, Technique, scene_errors};
use iorect::report::progress::Progress;
use iorect::report::reference::{References, SEEDS, Wanted, references};
use iorect::report::store::Store;
use iorect::scene::camera::Camera;
use iorect::tracking::Mode;
use iorect::tracking::{Prepared, prepare};

static NEVER: AtomicBool = AtomicBool::new(false);
const QUIETLY: Progress<'_> = Progress { cancel: &NEVER, tell: &|_, _| () };

fn prepared(scene: &str) -> Prepared {
    prepare(Arc::new(formats::open(scene).unwrap()), None).unwrap()
}

/// Of references: what is kept and made again does not depend on it, and `reference` is slow.
const SIZE: [u32; 2] = [12, 8];

struct Subject {
    prepared: Prepared,
    camera: Camera,
}

impl Subject {
    fn new(scene: &str) -> Self {
        let prepared = prepared(scene);
        let camera = Camera::new(&prepared.description.camera).unwrap();
        Self { prepared, camera }
    }

    fn wanted(&self, spp: u32) -> Wanted<'_> {
        Wanted { prepared: &self.prepared, camera: &self.camera, size: SIZE, max_depth: Some(16), spp }
    }

    fn references(&self, spp: u32, folder: &Path) -> References {
        references(&self.wanted(spp), &Store::open(folder).unwrap(), QUIETLY).unwrap().unwrap()
    }
}

fn files(folder: &Path, kind: &str) -> Vec<PathBuf> {
    let all = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut found: Vec<PathBuf> =
        all.filter(|path| path.file_name().unwrap().to_str().unwrap().starts_with(kind)).collect();
    found.sort();
    found
}

#[test]
fn references_are_those_of_the_mode_that_asks_and_have_seeds_of_their_own() {
    let subject = Subject::new("iced-water");
    let folder = tempfile::tempdir().unwrap();
    let found = subject.references(4, folder.path());
    for (seed, image) in SEEDS.into_iter().zip(&found.images) {
        let settings = ImageSettings { max_depth: Some(16), ..ImageSettings::new(Mode::Reference, seed) };
        let mut film = Film::new(SIZE[0], SIZE[1]);
        assert!(
            RenderTask { prepared: &subject.prepared, camera: &subject.camera, settings: &settings }
                .pass(&mut film, 4, &NEVER)
        );
        assert_eq!(film.to_rgb(), *image);
    }
    assert_ne!(found.images[0], found.images[1]);
    assert!(Effort::FULL.first_seed + u64::from(Effort::FULL.seeds) < SEEDS[0]);
}

#[test]
fn references_that_are_kept_grow_and_equal_fresh_ones() {
    let subject = Subject::new("iced-water");
    let (fresh, kept) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let expected = subject.references(12, fresh.path());
    let first = subject.references(5, kept.path());
    assert_eq!(first.spp, [5, 5]);
    assert_ne!(first.images, expected.images);
    let grown = subject.references(12, kept.path());
    assert_eq!((grown.spp, &grown.images, grown.events), ([12, 12], &expected.images, expected.events));
    // Found again, and not made again: its seconds are those of then.
    assert_eq!(subject.references(12, kept.path()), grown);
    // More than was asked for is no worse.
    assert_eq!(subject.references(5, kept.path()), grown);
    assert_eq!(files(kept.path(), "reference").len(), 2);
    // Another depth is another image.
    let deeper = Wanted { max_depth: None, ..subject.wanted(5) };
    let deeper = references(&deeper, &Store::open(kept.path()).unwrap(), QUIETLY).unwrap().unwrap();
    assert_ne!(deeper.images, grown.images);
}

#[test]
fn damaged_references_are_made_again() {
    let subject = Subject::new("iced-water");
    let folder = tempfile::tempdir().unwrap();
    let expected = subject.references(6, folder.path());
    let path = files(folder.path(), "reference").remove(0);
    let whole = fs::read(&path).unwrap();
    // One bit in the middle of the sums, which would be believed without a checksum, and an end that is missing.
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    for damaged in [flipped, whole[..whole.len() / 2].to_vec(), Vec::new()] {
        fs::write(&path, damaged).unwrap();
        assert_eq!(subject.references(6, folder.path()).images, expected.images);
        assert_eq!(fs::read(&path).unwrap().len(), whole.len());
    }
    // A whole file of another image in this one's place is taken at its word only if it could be this one: of another size it cannot.
    let other = Wanted { size: [8, 8], ..subject.wanted(6) };
    references(&other, &Store::open(folder.path()).unwrap(), QUIETLY).unwrap().unwrap();
    let smaller = files(folder.path(), "reference")
        .into_iter()
        .find(|other| fs::metadata(other).unwrap().len() < whole.len() as u64);
    fs::copy(smaller.unwrap(), &path).unwrap();
    assert_eq!(subject.references(6, folder.path()).images, expected.images);
}

#[test]
fn cancelled_references_are_none_and_go_on_later() {
    let subject = Subject::new("iced-water");
    let (fresh, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let cancel = AtomicBool::new(false);
    // Stops in the second reference.
    let tell = |_: &str, done: f64| cancel.store(done > 0.5, Ordering::Relaxed);
    let stopped =
        references(&subject.wanted(9), &Store::open(folder.path()).unwrap(), Progress { cancel: &cancel, tell: &tell });
    assert!(stopped.unwrap().is_none());
    assert_eq!(files(folder.path(), "reference").len(), 1);
    assert_eq!(subject.references(9, folder.path()).images, subject.references(9, fresh.path()).images);
}

/// Small enough for a test. Time does not decide.
const EFFORT: Effort =
    Effort { size: [24, 16], seeds: 4, secs: 1e9, largest_spp: 64, reference_factor: 4, ..Effort::QUICK };

fn measured(prepared: &Prepared, effort: &Effort, folder: &Path) -> SceneErrors {
    scene_errors(prepared, effort, &Store::open(folder).unwrap(), QUIETLY).unwrap().unwrap()
}

fn curve(errors: &SceneErrors, mode: Mode) -> &Curve {
    errors.curves.iter().find(|c| c.mode == mode && c.technique == Technique::independent()).unwrap()
}

#[test]
fn from_inside_stack_stays_at_its_bias_and_rectified_has_none() {
    let folder = tempfile::tempdir().unwrap();
    let prepared = prepared("camera-in-water");
    let errors = measured(&prepared, &EFFORT, folder.path());
    assert_eq!(errors.plan.spp, [1, 2, 4, 8, 16, 32, 64]);
    assert_eq!(errors.reference.spp, 256);
    for mode in [Mode::Stack, Mode::Naive] {
        let curve = curve(&errors, mode);
        assert!(curve.bias.is_biased && curve.bias.squared.low > 0.0, "{mode}: {:?}", curve.bias);
        let plateau = curve.plateau.unwrap();
        assert!(plateau.measured_over_predicted.unwrap().contains(1.0), "{mode}: {plateau:?}");
        let last = curve.points.last().unwrap();
        let relmse = last.relmse.unwrap();
        // Noise has gone below bias, and the error lies at the plateau and little above.
        assert!(plateau.spp < 64.0 && last.variance < plateau.relmse.value, "{mode}: {plateau:?} {last:?}");
        assert!(relmse.value > plateau.relmse.low && relmse.value < 2.0 * plateau.relmse.high, "{mode}: {relmse:?}");
        // Sixteen times the samples would bring an unbiased mode to a sixteenth.
        let earlier = curve.points[2].relmse.unwrap().value;
        assert!(relmse.value > earlier / 8.0, "{mode}: {earlier} {relmse:?}");
    }
    let rectified = curve(&errors, Mode::Rectified);
    assert!(!rectified.bias.is_biased && rectified.plateau.is_none(), "{:?}", rectified.bias);
    let slope = rectified.slope.unwrap();
    assert!(slope.trimmed.value < -0.8 && slope.trimmed.value > -1.2, "{slope:?}");
    assert!(
        rectified.points.last().unwrap().relmse.unwrap().high
            < curve(&errors, Mode::Stack).points[6].relmse.unwrap().low
    );
    // Rectification is in the time of those that use it, and of those only.
    assert_eq!(rectified.secs_before, prepared.seconds.rectify);
    assert_eq!(curve(&errors, Mode::Stack).secs_before, 0.0);
    // All that is measured is there, and nothing twice.
    assert_eq!(errors.curves.len(), 6);
    assert!(errors.curves.last().is_some_and(|c| c.mode == Mode::Rectified && c.technique == Technique::shipped()));
    assert!(errors.pairs.iter().any(|pair| pair.mode == Mode::Naive));
    assert!(errors.pairs.iter().all(|pair| curve(&errors, pair.mode).equal_to.is_none()));
    // Runs have said all that they had to say; references may be asked for again.
    assert!(files(folder.path(), "run").is_empty());
    assert_eq!(files(folder.path(), "reference").len(), 2);
}

#[test]
fn where_nothing_is_nested_all_modes_are_one() {
    let folder = tempfile::tempdir().unwrap();
    let errors = measured(&prepared("plain-glass"), &Effort { largest_spp: 16, ..EFFORT }, folder.path());
    for mode in [Mode::Naive, Mode::Stack, Mode::Priority, Mode::RectifiedObject] {
        let (curve, rectified) = (curve(&errors, mode), curve(&errors, Mode::Rectified));
        assert_eq!(curve.equal_to, Some(Mode::Rectified), "{mode}");
        assert_eq!(curve.points[2].relmse, rectified.points[2].relmse);
        assert!(!curve.bias.is_biased);
    }
    assert!(errors.pairs.is_empty());
}

/// All but seconds, which no two measurements share.
fn without_times(errors: &SceneErrors) -> serde_json::Value {
    fn strip(value: &mut serde_json::Value) {
        match value {
            serde_json::Value::Object(map) => {
                map.retain(|key, _| !key.contains("secs") && key != "efficiency" && key != "threads");
                map.values_mut().for_each(strip);
            }
            serde_json::Value::Array(values) => values.iter_mut().for_each(strip),
            _ => {}
        }
    }
    let mut value = serde_json::to_value(errors).unwrap();
    strip(&mut value);
    value
}

#[test]
fn interruptions_and_threads_change_nothing_but_times() {
    let effort = Effort { largest_spp: 16, seeds: 3, ..EFFORT };
    let prepared = prepared("nested-spheres");
    let (whole, broken) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let expected = pool(1).install(|| measured(&prepared, &effort, whole.path()));

    // Stops again and again, each time a little later.
    let mut stops = 0;
    let resumed = pool(2).install(|| {
        for patience in 1.. {
            let (told, cancel) = (AtomicUsize::new(0), AtomicBool::new(false));
            let tell = |_: &str, done: f64| {
                assert!((0.0..=1.0).contains(&done));
                cancel.store(told.fetch_add(1, Ordering::Relaxed) + 1 >= patience * 4, Ordering::Relaxed);
            };
            let progress = Progress { cancel: &cancel, tell: &tell };
            let store = Store::open(broken.path()).unwrap();
            if let Some(errors) = scene_errors(&prepared, &effort, &store, progress).unwrap() {
                return errors;
            }
            stops += 1;
        }
        unreachable!("patience has no end")
    });
    assert!(stops > 1, "{stops}");
    assert_eq!(without_times(&resumed), without_times(&expected));

    // The twin: another seed is another measurement.
    let other = Effort { first_seed: 100, ..effort };
    assert_ne!(without_times(&measured(&prepared, &other, whole.path())), without_times(&expected));
}

/// The criterion of an honest mode, on every built-in scene: takes seven minutes in the release profile on two quiet cores.
///
/// An interval of 95 % misses the truth once in twenty scenes even of a perfect mode. So what each scene shows is printed as it is, and what
/// must hold of all of them together is checked with intervals that together hold with 95 %, each with the twelfth root of that.
#[test]
#[ignore = "minutes of rendering; run it with --release -- --ignored --nocapture"]
fn slopes_and_plateaus_of_all_built_in_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = iorect::formats::builtin::all();
    let together = 0.95_f64.powf(1.0 / scenes.len() as f64);
    let mut wrong = Vec::new();
    for scene in scenes {
        let effort = Effort { seeds: 8, secs: 60.0, largest_spp: 64, reference_factor: 4, ..Effort::QUICK };
        let errors = measured(&prepared(scene.name), &effort, folder.path());
        let rectified = curve(&errors, Mode::Rectified);
        let slope = rectified.slope.unwrap().trimmed;
        let wider = t_quantile(together, 7) / t_quantile(0.95, 7);
        let all_together = Interval::around(slope.value, (slope.high - slope.value) * wider);
        println!(
            "{:16} slope {:.3} in {:.3} to {:.3}{}, bias {:+.1} σ",
            scene.name,
            slope.value,
            slope.low,
            slope.high,
            if slope.contains(-1.0) { "" } else { ", without −1" },
            rectified.bias.significance
        );
        if !all_together.contains(-1.0) || rectified.bias.is_biased || slope.high - slope.low > 0.2 {
            wrong.push(format!("{}: {slope:?} {:?}", scene.name, rectified.bias));
        }
        for curve in errors.curves.iter().filter(|curve| curve.bias.is_biased) {
            let plateau = curve.plateau.unwrap();
            let ratio = plateau.measured_over_predicted.unwrap();
            println!(
                "{:16}   {} stays at {:.2e}; measured over predicted {:.3} in {:.3} to {:.3}",
                "", curve.mode, plateau.relmse.value, ratio.value, ratio.low, ratio.high
            );
            // As wide as slopes, for the same reason. A mode of heavy tails is known only roughly.
            if !Interval::around(ratio.value, (ratio.high - ratio.value) * wider).contains(1.0) {
                wrong.push(format!("{}: {} {plateau:?}", scene.name, curve.mode));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
