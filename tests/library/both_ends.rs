//! Paths from both ends: bidirectional path tracing, and merging. Closed forms, paths from the camera, and images made elsewhere.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use iorect::formats;
use iorect::measure::metrics::block_means;
use iorect::render::exact::unit_exponent;
use iorect::render::{Estimator, Film, ImageSettings, RenderTask};
use iorect::scene::camera::Camera;
use iorect::scene::description::{Description, Environment, Light, Object, Paint, Shape, Solid};
use iorect::tracking::{Mode, Prepared};

use crate::common::{add, empty, icosphere, mean, nest, ready, sphere};

const BOTH_ENDS: [Estimator; 2] = [Estimator::Bidirectional, Estimator::Merging];
const ALL: [Estimator; 3] = [Estimator::Path, Estimator::Bidirectional, Estimator::Merging];

static NEVER: AtomicBool = AtomicBool::new(false);

/// How an image is rendered.
#[derive(Clone, Copy)]
struct Way {
    estimator: Estimator,
    mode: Mode,
    seed: u64,
    max_depth: Option<u32>,
}

impl Way {
    fn of(estimator: Estimator) -> Self {
        Self { estimator, mode: Mode::Rectified, seed: 1, max_depth: None }
    }

    fn settings(self) -> ImageSettings {
        let Self { estimator, mode, seed, max_depth } = self;
        ImageSettings { estimator, max_depth, splits: 0, ..ImageSettings::new(mode, seed) }
    }

    fn add_to(self, film: &mut Film, prepared: &Prepared, samples: u32) {
        let camera = Camera::new(&prepared.description.camera).unwrap();
        let task = RenderTask { prepared, camera: &camera, settings: &self.settings() };
        task.require().unwrap();
        assert!(task.pass(film, samples, &NEVER));
    }

    fn film(self, prepared: &Prepared, size: (u32, u32), samples: u32) -> Film {
        let mut film = Film::new(size.0, size.1);
        self.add_to(&mut film, prepared, samples);
        film
    }
}

fn quad(name: &str, center: DVec3, edge_u: DVec3, edge_v: DVec3) -> Object {
    Object::new(name, Shape::Quad { center, edge_u, edge_v }, Solid::of(Paint::Color([0.6, 0.5, 0.3])))
}

fn lamp(shape: Shape) -> Object {
    Object::new("lamp", shape, Light { radiance: [5.0, 4.0, 3.0] })
}

/// A floor, in the dark or not, with a ball of water on it and one of ice in that; what is put in later stands in the ice, in the water or
/// outside.
fn pool(environment: [f64; 3]) -> Description {
    let mut description = empty(1.0);
    description.environment = Environment::Color(environment);
    add(&mut description, sphere(DVec3::new(0.0, 1.3, 0.0), 1.2), 1.333, 0.1);
    add(&mut description, sphere(DVec3::new(0.2, 1.2, 0.1), 0.6), 1.31, 0.05);
    description.objects.push(quad("floor", DVec3::ZERO, DVec3::Z * 8.0, DVec3::X * 8.0));
    description.camera.position = DVec3::new(0.5, 3.0, 4.5);
    description.camera.target = DVec3::Y;
    description
}

/// Whether means over blocks of pixels agree: in many runs of each, the squares of their differences by their own variance have the mean that
/// they should have. Of both, `allowed` is the part by which blocks may differ beyond that.
fn agreement(prepared: &Prepared, [a, b]: [Way; 2], samples: [u32; 2], allowed: f64) -> Result<(), String> {
    const RUNS: u64 = 8;
    const SIZE: (u32, u32) = (32, 24);
    let blocks = |way: Way, samples: u32| -> Vec<Vec<f64>> {
        (0..RUNS)
            .map(|run| {
                let film = Way { seed: way.seed + run, ..way }.film(prepared, SIZE, samples);
                let means = block_means(&film.to_rgb(), SIZE.0 as usize, SIZE.1 as usize, 8).unwrap();
                means.into_iter().map(|rgb| f64::from(rgb.into_iter().sum::<f32>())).collect()
            })
            .collect()
    };
    let (a, b) = (blocks(a, samples[0]), blocks(b, samples[1]));
    let n = RUNS as f64;
    let statistics = |runs: &[Vec<f64>], block: usize| {
        let mean = runs.iter().map(|run| run[block]).sum::<f64>() / n;
        let variance = runs.iter().map(|run| (run[block] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, variance / n)
    };
    let count = a[0].len();
    let (mut squares, mut worst) = (0.0, 0.0_f64);
    for block in 0..count {
        let ((a, variance_a), (b, variance_b)) = (statistics(&a, block), statistics(&b, block));
        let square = (a - b).powi(2) / (variance_a + variance_b + (allowed * a).powi(2) + 1e-16);
        squares += square;
        worst = worst.max(square);
    }
    // Student's t with 14 degrees of freedom: its square has mean 14/12 and a standard deviation of some 2.1.
    let mean = squares / count as f64;
    let limit = 1.17 + 4.0 * 2.1 / (count as f64).sqrt();
    if mean < limit { Ok(()) } else { Err(format!("mean square {mean:.2} of at most {limit:.2}, worst {worst:.1}")) }
}

/// A sphere of radius r at distance d, seen by a grey floor: radiance albedo · L (r/d)² cos θ.
#[test]
fn direct_light() {
    let mut description = empty(1.0);
    description.environment = Environment::Color([0.0; 3]);
    let floor = Shape::Quad { center: DVec3::ZERO, edge_u: DVec3::Z * 200.0, edge_v: DVec3::X * 200.0 };
    description.objects.push(Object::new("floor", floor, Solid::of(Paint::Color([0.6; 3]))));
    let center = DVec3::new(0.0, 2.0, 1.0);
    description.objects.push(Object::new("lamp", sphere(center, 0.5), Light { radiance: [5.0; 3] }));
    description.camera.position = DVec3::new(3.0, 4.0, 0.0);
    description.camera.vertical_fov = 1e-6;
    let prepared = ready(description);
    let d = center.length();
    let expected = 0.6 * 5.0 * (0.5 / d).powi(2) * (2.0 / d);
    for estimator in ALL {
        let (measured, error) = mean(&Way::of(estimator).film(&prepared, (32, 32), 64));
        assert!((measured - expected).abs() <= 4.0 * error + 1e-9, "{estimator:?}: {measured} ± {error}, {expected}");
    }
}

/// Nothing absorbs, and light comes from everywhere: everything is as bright as the light, matt surfaces too.
#[test]
fn furnace() {
    let mut description = nest(1.0, &[(2.0, 1.5), (1.5, 1.333), (1.0, 2.4)]);
    let white = Solid::of(Paint::Color([1.0; 3]));
    description.objects.push(Object::new("matt", sphere(DVec3::new(0.3, 0.1, 0.2), 0.5), white));
    let prepared = ready(description);
    for estimator in ALL {
        let (measured, error) = mean(&Way::of(estimator).film(&prepared, (24, 24), 64));
        assert!((measured - 1.0).abs() <= 4.0 * error + 1e-9, "{estimator:?}: {measured} ± {error}");
    }
}

/// Camera and lamp in air, in water and in ice, each with each: paths from the camera, from both ends, and merged, agree in modes that are right.
#[test]
fn every_pairing_of_camera_and_lamp() {
    let places = [DVec3::new(1.6, 1.9, 1.4), DVec3::new(-0.6, 1.5, 0.3), DVec3::new(0.3, 1.3, 0.2)];
    let cameras = [DVec3::new(0.5, 3.0, 4.5), DVec3::new(-0.3, 2.1, -0.3), DVec3::new(0.0, 1.4, -0.1)];
    let mut problems = Vec::new();
    for (lamp_in, at) in ["air", "water", "ice"].into_iter().zip(places) {
        for (camera_in, from) in ["air", "water", "ice"].into_iter().zip(cameras) {
            let mut description = pool([0.0; 3]);
            description.objects.push(lamp(sphere(at, 0.2)));
            description.camera.position = from;
            description.camera.target = DVec3::new(0.3, 0.0, 0.2);
            let prepared = ready(description);
            for estimator in BOTH_ENDS {
                for mode in [Mode::Rectified, Mode::Reference] {
                    let ways = [Way::of(Estimator::Path), Way { mode, seed: 100, ..Way::of(estimator) }];
                    // Merging is biased by so much at this size.
                    let allowed = if estimator == Estimator::Merging { 0.02 } else { 0.0 };
                    let samples = if mode == Mode::Reference { 8 } else { 24 };
                    if let Err(error) = agreement(&prepared, ways, [256, samples], allowed) {
                        problems
                            .push(format!("lamp in {lamp_in}, camera in {camera_in}, {estimator:?}, {mode}: {error}"));
                    }
                }
            }
        }
    }
    assert_eq!(problems, Vec::<String>::new());
}

/// A stack has nothing to start from at either end. Where the camera is outside, its paths are right; those of a lamp inside are not, and say so.
#[test]
fn a_stack_fails_at_the_lamp_as_it_does_at_the_camera() {
    let mut description = pool([0.0; 3]);
    description.objects.push(lamp(sphere(DVec3::new(0.3, 1.3, 0.2), 0.2)));
    let inside = ready(description.clone());
    let stack = |estimator| Way { mode: Mode::Stack, ..Way::of(estimator) };
    let size = (32, 24);
    let by_path = stack(Estimator::Path).film(&inside, size, 64).events;
    assert_eq!((by_path.stack_underflow, by_path.inconsistent), (0, 0));
    let right = Way { seed: 50, ..Way::of(Estimator::Path) };
    assert_eq!(agreement(&inside, [right, stack(Estimator::Path)], [128, 128], 0.0), Ok(()));
    for estimator in BOTH_ENDS {
        let events = stack(estimator).film(&inside, size, 16).events;
        assert!(events.stack_underflow > 1000, "{events:?}");
        assert!(agreement(&inside, [right, stack(estimator)], [128, 32], 0.02).is_err(), "{estimator:?}");
    }
    // Outside, no end has anything to miss.
    let count = description.objects.refractors().len();
    assert_eq!(count, 2);
    let mut outside = pool([0.0; 3]);
    outside.objects.push(lamp(sphere(DVec3::new(1.6, 1.9, 1.4), 0.2)));
    let outside = ready(outside);
    for estimator in BOTH_ENDS {
        let events = stack(estimator).film(&outside, size, 16).events;
        assert_eq!((events.stack_underflow, events.inconsistent), (0, 0));
        let allowed = if estimator == Estimator::Merging { 0.02 } else { 0.0 };
        assert_eq!(agreement(&outside, [right, stack(estimator)], [128, 32], allowed), Ok(()), "{estimator:?}");
    }
}

/// A lens, interpolated normals, an environment beside a lamp, a mirror, a cap on the segments.
#[test]
fn whatever_a_scene_has() {
    let mut description = pool([0.3, 0.4, 0.6]);
    description.objects.push(lamp(Shape::Quad {
        center: DVec3::new(0.0, 3.5, 0.0),
        edge_u: DVec3::X * 0.8,
        edge_v: DVec3::Z * 0.6,
    }));
    let mut mirror = Solid::of(Paint::Color([0.8; 3]));
    mirror.mirror = true;
    let wall = Shape::Quad { center: DVec3::new(0.0, 1.0, -2.5), edge_u: DVec3::X * 5.0, edge_v: DVec3::Y * 3.0 };
    description.objects.push(Object::new("mirror", wall, mirror));
    let plain = description.clone();
    description.camera.aperture_radius = 0.3;
    let lens = description.clone();
    description.camera.aperture_radius = 0.0;
    let mut smooth = description;
    smooth.objects.clear(iorect::scene::description::Kind::Refractor);
    smooth.media.clear();
    add(&mut smooth, icosphere(0.9, 3), 1.5, 0.0);
    smooth.objects.refractor_roles_mut().for_each(|refractor| refractor.smooth = true);
    let mut problems = Vec::new();
    for (name, description, max_depth) in [
        ("plain", &plain, None),
        ("lens", &lens, None),
        ("smooth", &smooth, None),
        ("2 segments", &plain, Some(2)),
        ("4 segments", &plain, Some(4)),
        ("6 segments", &plain, Some(6)),
    ] {
        let prepared = ready(description.clone());
        for estimator in BOTH_ENDS {
            let ways = [Estimator::Path, estimator].map(|estimator| Way { max_depth, ..Way::of(estimator) });
            let ways = [ways[0], Way { seed: 100, ..ways[1] }];
            let allowed = if estimator == Estimator::Merging { 0.02 } else { 0.0 };
            if let Err(error) = agreement(&prepared, ways, [192, 32], allowed) {
                problems.push(format!("{name}, {estimator:?}: {error}"));
            }
        }
    }
    assert_eq!(problems, Vec::<String>::new());
}

/// The image does not depend on threads, on how samples are grouped, or on where parts are rendered; and a pass that is cancelled leaves
/// nothing behind.
#[test]
fn one_image_however_it_is_made() {
    let mut description = pool([0.1; 3]);
    description.objects.push(lamp(sphere(DVec3::new(0.3, 1.3, 0.2), 0.1)));
    let exponent = unit_exponent(&description);
    let prepared = ready(description);
    let size = (33, 21);
    for estimator in BOTH_ENDS {
        let way = Way::of(estimator);
        let whole = way.film(&prepared, size, 6);
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut film = Film::new(size.0, size.1);
            pool.install(|| [1, 2, 3].into_iter().for_each(|samples| way.add_to(&mut film, &prepared, samples)));
            assert_eq!((&film.sums, film.events, film.samples), (&whole.sums, whole.events, 6), "{estimator:?}");
        }
        let part = |first, samples| {
            let mut film = Film::partial(size.0, size.1, first, exponent);
            way.add_to(&mut film, &prepared, samples);
            film.exact.unwrap().sums
        };
        let (all, head, tail) = (part(0, 6), part(0, 2), part(2, 4));
        let together: Vec<_> =
            head.iter().zip(&tail).map(|(head, tail)| [0, 1, 2].map(|k| head[k] + tail[k])).collect();
        assert!(together == all, "{estimator:?}");
        let camera = Camera::new(&prepared.description.camera).unwrap();
        let task = RenderTask { prepared: &prepared, camera: &camera, settings: &way.settings() };
        let mut film = way.film(&prepared, size, 6);
        assert!(!task.pass(&mut film, 2, &AtomicBool::new(true)));
        assert_eq!(film, whole);
    }
}

/// Images that another program made of lamps inside media and of caustics: see `tests/data/truth/README.md`.
#[test]
fn images_made_elsewhere() {
    // The error that paths from both ends, and merged ones, may have: noise of so few samples for the most part.
    for (name, samples, [both, merged]) in [
        ("A1", 48, [0.03, 4e-3]),
        ("A4", 48, [0.06, 4e-3]),
        ("B1", 48, [0.02, 8e-3]),
        ("B2", 48, [f64::INFINITY, 0.03]),
    ] {
        let file = |ending: &str| {
            Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/truth").join(name).with_extension(ending)
        };
        let truth = formats::image_from_file(&file("exr")).unwrap();
        let prepared = ready(formats::file(&file("toml")).unwrap());
        for (estimator, limit) in BOTH_ENDS.into_iter().zip([both, merged]) {
            let film = Way::of(estimator).film(&prepared, (truth.width as u32, truth.height as u32), samples);
            let mut errors: Vec<f64> = film
                .to_rgb()
                .iter()
                .zip(&truth.pixels)
                .map(|(a, t)| {
                    let of = |k: usize| f64::from(a[k] - t[k]).powi(2) / (f64::from(t[k]).powi(2) + 0.01);
                    (of(0) + of(1) + of(2)) / 3.0
                })
                .collect();
            // Glints of a lamp are left out: the brightest of them are in few pixels.
            errors.sort_by(f64::total_cmp);
            let kept = &errors[..errors.len() * 997 / 1000];
            let error = kept.iter().sum::<f64>() / kept.len() as f64;
            assert!(error < limit, "{name}, {estimator:?}: {error:.2e}, at most {limit:.0e}");
        }
    }
}
