//! Paths from both ends: bidirectional path tracing, and merging. Closed forms, paths from the camera, and images made elsewhere.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3};
use iorect::formats;
use iorect::measure::metrics::block_means;
use iorect::render::exact::unit_exponent;
use iorect::render::{Estimator, Film, ImageSettings, RenderTask};
use iorect::scene::camera::Camera;
use iorect::scene::description::{Description, Emission, Environment, Light, Object, Paint, Quantity, Shape, Solid};
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
    Object::new("lamp", shape, Light::of_radiance([5.0, 4.0, 3.0]))
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

/// Means over blocks of pixels, of some runs.
struct Blocks(Vec<Vec<f64>>);

impl Blocks {
    const RUNS: u64 = 8;
    const SIZE: (u32, u32) = (32, 24);

    fn of(prepared: &Prepared, way: Way, samples: u32) -> Self {
        let run = |run: u64| {
            let film = Way { seed: way.seed + run, ..way }.film(prepared, Self::SIZE, samples);
            let means = block_means(&film.to_rgb(), Self::SIZE.0 as usize, Self::SIZE.1 as usize, 8).unwrap();
            means.into_iter().map(|rgb| f64::from(rgb.into_iter().sum::<f32>())).collect()
        };
        Self((0..Self::RUNS).map(run).collect())
    }

    /// The mean of a block, and its variance.
    fn statistics(&self, block: usize) -> (f64, f64) {
        let n = self.0.len() as f64;
        let mean = self.0.iter().map(|run| run[block]).sum::<f64>() / n;
        let variance = self.0.iter().map(|run| (run[block] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, variance / n)
    }

    /// Whether both have the same means: the squares of their differences by their own variance have the mean that they should have. Blocks may
    /// differ by the part `allowed` beyond that.
    fn agree(&self, other: &Self, allowed: f64) -> Result<(), String> {
        let count = self.0[0].len();
        let squares: Vec<f64> = (0..count)
            .map(|block| {
                let ((a, variance_a), (b, variance_b)) = (self.statistics(block), other.statistics(block));
                (a - b).powi(2) / (variance_a + variance_b + (allowed * a).powi(2) + 1e-16)
            })
            .collect();
        // Student's t with 14 degrees of freedom: its square has mean 14/12 and a standard deviation of some 2.1.
        let mean = squares.iter().sum::<f64>() / count as f64;
        let limit = 1.17 + 4.0 * 2.1 / (count as f64).sqrt();
        let worst = squares.iter().copied().fold(0.0, f64::max);
        if mean < limit {
            Ok(())
        } else {
            Err(format!("mean square {mean:.2} of at most {limit:.2}, worst {worst:.1}"))
        }
    }
}

/// The part by which merging is biased in images of that size.
fn bias(estimator: Estimator) -> f64 {
    if estimator == Estimator::Merging { 0.02 } else { 0.0 }
}

/// A sphere of radius r at distance d, seen by a grey floor: radiance albedo · L (r/d)² cos θ.
#[test]
fn direct_light() {
    let mut description = empty(1.0);
    description.environment = Environment::Color([0.0; 3]);
    let floor = Shape::Quad { center: DVec3::ZERO, edge_u: DVec3::Z * 200.0, edge_v: DVec3::X * 200.0 };
    description.objects.push(Object::new("floor", floor, Solid::of(Paint::Color([0.6; 3]))));
    let center = DVec3::new(0.0, 2.0, 1.0);
    description.objects.push(Object::new("lamp", sphere(center, 0.5), Light::of_radiance([5.0; 3])));
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
        let allowed = 4.0 * error + bias(estimator) + 1e-9;
        assert!((measured - 1.0).abs() <= allowed, "{estimator:?}: {measured} ± {error}");
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
            // Small ones in air would make caustics in water that paths hardly find.
            description.objects.push(lamp(sphere(at, if lamp_in == "air" { 0.45 } else { 0.2 })));
            description.camera.position = from;
            description.camera.target = DVec3::new(0.3, 0.0, 0.2);
            let prepared = ready(description);
            let by_path = Blocks::of(&prepared, Way::of(Estimator::Path), 128);
            for estimator in BOTH_ENDS {
                for (mode, samples) in [(Mode::Rectified, 48), (Mode::Reference, 12)] {
                    let blocks = Blocks::of(&prepared, Way { mode, seed: 100, ..Way::of(estimator) }, samples);
                    if let Err(error) = by_path.agree(&blocks, bias(estimator)) {
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
    let truth = Blocks::of(&inside, right, 128);
    assert_eq!(truth.agree(&Blocks::of(&inside, stack(Estimator::Path), 128), 0.0), Ok(()));
    for estimator in BOTH_ENDS {
        let events = stack(estimator).film(&inside, size, 16).events;
        assert!(events.stack_underflow > 1000 && events.inconsistent > 1000, "{events:?}");
        assert!(truth.agree(&Blocks::of(&inside, stack(estimator), 32), bias(estimator)).is_err(), "{estimator:?}");
        let events = Way::of(estimator).film(&inside, size, 16).events;
        assert_eq!((events.stack_underflow, events.inconsistent), (0, 0), "{estimator:?}");
    }
    // Outside, no end has anything to miss.
    let mut outside = pool([0.0; 3]);
    outside.objects.push(lamp(sphere(DVec3::new(1.6, 1.9, 1.4), 0.45)));
    let outside = ready(outside);
    let truth = Blocks::of(&outside, right, 128);
    for estimator in BOTH_ENDS {
        let events = stack(estimator).film(&outside, size, 16).events;
        assert_eq!((events.stack_underflow, events.inconsistent), (0, 0));
        let blocks = Blocks::of(&outside, stack(estimator), 32);
        assert_eq!(truth.agree(&blocks, bias(estimator)), Ok(()), "{estimator:?}");
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
        let by_path = Blocks::of(&prepared, Way { max_depth, ..Way::of(Estimator::Path) }, 128);
        for estimator in BOTH_ENDS {
            let blocks = Blocks::of(&prepared, Way { max_depth, seed: 100, ..Way::of(estimator) }, 24);
            if let Err(error) = by_path.agree(&blocks, bias(estimator)) {
                problems.push(format!("{name}, {estimator:?}: {error}"));
            }
        }
    }
    assert_eq!(problems, Vec::<String>::new());
}

/// Lights at a point, in a cone, from afar in one direction and in many, and with two sides.
#[test]
fn every_kind_of_light() {
    let lights = [
        Shape::Point { position: DVec3::new(0.6, 2.0, 0.4) },
        Shape::Spot { position: DVec3::new(0.0, 3.0, 1.0), target: DVec3::ZERO, inner_angle: 15.0, outer_angle: 30.0 },
        Shape::Directional { direction: DVec3::new(0.3, -1.0, 0.2), angle: 0.0 },
        Shape::Directional { direction: DVec3::new(-0.4, -1.0, 0.1), angle: 12.0 },
        Shape::Quad { center: DVec3::new(0.5, 0.8, -0.5), edge_u: DVec3::Y * 0.5, edge_v: DVec3::X * 0.4 },
    ];
    let mut problems = Vec::new();
    let scene = |lights: &[Shape]| {
        let mut description = pool([0.0; 3]);
        // Glass would make caustics that paths from the camera cannot find.
        description.objects.clear(iorect::scene::description::Kind::Refractor);
        description.media.clear();
        let ball = Solid::of(Paint::Color([0.7; 3]));
        description.objects.push(Object::new("ball", sphere(DVec3::new(-0.4, 0.5, 0.2), 0.5), ball));
        for (index, shape) in lights.iter().enumerate() {
            let quantity = shape.quantity();
            let light = Light { emission: Emission { quantity, rgb: [3.0, 2.0, 1.0] }, two_sided: true, outside: None };
            description.objects.push(Object::new(format!("light {index}"), shape.clone(), light));
        }
        description
    };
    let one_by_one = lights.iter().map(|light| scene(std::slice::from_ref(light)));
    for (index, description) in one_by_one.chain([scene(&lights)]).enumerate() {
        let prepared = ready(description);
        let by_path = Blocks::of(&prepared, Way::of(Estimator::Path), 128);
        for estimator in BOTH_ENDS {
            let blocks = Blocks::of(&prepared, Way { seed: 100, ..Way::of(estimator) }, 48);
            if let Err(error) = by_path.agree(&blocks, 0.0) {
                problems.push(format!("light {index}, {estimator:?}: {error}"));
            }
        }
    }
    assert_eq!(problems, Vec::<String>::new());
}

/// Irradiance on a floor behind a glass ball in parallel light, by distance from the middle, against a table made elsewhere.
#[test]
fn caustic_in_parallel_light() {
    let mut description = empty(1.0);
    description.environment = Environment::Color([0.0; 3]);
    add(&mut description, sphere(DVec3::Y, 0.5), 1.5, 0.0);
    let floor = Shape::Quad { center: DVec3::ZERO, edge_u: DVec3::Z * 3.0, edge_v: DVec3::X * 3.0 };
    description.objects.push(Object::new("floor", floor, Solid::of(Paint::Color([0.5; 3]))));
    let emission = Emission { quantity: Quantity::Irradiance, rgb: [1.0; 3] };
    let sun = Shape::Directional { direction: DVec3::NEG_Y, angle: 0.0 };
    description.objects.push(Object::new("sun", sun, Light { emission, two_sided: false, outside: None }));
    description.camera.position = DVec3::new(0.0, 1.0, 3.0);
    description.camera.target = DVec3::ZERO;
    description.camera.vertical_fov = 12.0;
    let camera = Camera::new(&description.camera).unwrap();
    let prepared = ready(description);
    let table = include_str!("../data/truth/B1d_directional_profile.csv");
    let bins: Vec<[f64; 3]> = table
        .lines()
        .skip(1)
        .map(|line| {
            let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
            [numbers[0], numbers[1], numbers[2]]
        })
        .filter(|[_, to, _]| *to <= 0.35)
        .collect();
    assert!(bins.len() > 10);
    let (width, height) = (192, 192);
    for (estimator, allowed) in [(Estimator::Bidirectional, 0.05), (Estimator::Merging, 0.07)] {
        let film = Way::of(estimator).film(&prepared, (width, height), 24);
        let mut sums = vec![(0.0, 0.0); bins.len()];
        for pixel in 0..film.sums.len() {
            let at = DVec2::new((pixel as u32 % width) as f64 + 0.5, (pixel as u32 / width) as f64 + 0.5);
            let ray = camera.ray(at, DVec2::new(width.into(), height.into()), DVec2::ZERO);
            let t = -ray.origin.y / ray.direction.y;
            // The floor that a pixel covers grows with the squared distance and the inverse of both cosines.
            let area = t * t / (ray.direction.dot(camera.forward).powi(3) * -ray.direction.y);
            let from_middle = ray.at(t).length();
            if let Some(bin) = bins.iter().position(|[from, to, _]| (*from..*to).contains(&from_middle)) {
                sums[bin].0 += film.mean(pixel).y * std::f64::consts::PI / 0.5 * area;
                sums[bin].1 += area;
            }
        }
        let mut compared = 0;
        for ([from, to, expected], (sum, area)) in bins.iter().zip(&sums) {
            // In the middle there are too few pixels.
            if *area > 0.0 && *from >= 0.05 {
                let measured = sum / area;
                compared += 1;
                assert!(
                    (measured / expected - 1.0).abs() < allowed,
                    "{estimator:?}, {from} to {to}: {measured} is not {expected}"
                );
            }
        }
        assert!(compared >= 6);
    }
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

/// Share of unpolarised light that goes through from a medium of index 1 into one of `n`, where it comes at `theta` and goes on at `behind`.
fn through(n: f64, theta: f64, behind: f64) -> f64 {
    let (a, b) = (theta.cos(), behind.cos());
    let (s, p) = ((a - n * b) / (a + n * b), (n * a - b) / (n * a + b));
    1.0 - (s * s + p * p) / 2.0
}

/// Irradiance over the intensity of a light at a point, at a distance `rho` from its foot, on a plane behind a flat surface: `above` the surface the
/// light, `below` it the plane, where the index is `n` times as large.
fn behind_flat_surface(n: f64, above: f64, below: f64, rho: f64) -> f64 {
    let refracted = |theta: f64| (theta.sin() / n).asin();
    let reach = |theta: f64| above * theta.tan() + below * refracted(theta).tan();
    // Light from the denser side arrives up to the critical angle.
    let (mut low, mut high) = (0.0, if n < 1.0 { n.asin() } else { std::f64::consts::FRAC_PI_2 } - 1e-9);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if reach(middle) < rho { low = middle } else { high = middle }
    }
    let theta = 0.5 * (low + high);
    let behind = refracted(theta);
    let slope = above / theta.cos().powi(2) + below * theta.cos() / (n * behind.cos().powi(3));
    let transmitted = if n >= 1.0 {
        through(n, theta, behind)
    } else {
        // The same both ways.
        through(1.0 / n, behind, theta)
    };
    transmitted * theta.sin() / (rho * slope)
}

/// Light at a point that reaches a plane through interfaces, by closed forms: into water, out of it, and out of the middle of concentric balls.
#[test]
fn light_at_a_point_through_interfaces() {
    // Dark, so that hardly any light comes back to it.
    const ALBEDO: f64 = 0.05;
    // The closed form itself, against figures worked out elsewhere.
    for (n, rho, expected) in [(1.333, 0.5, 0.2924695132), (1.333, 2.0, 0.1083298287), (1.0 / 1.333, 1.0, 0.1202921708)]
    {
        let found = behind_flat_surface(n, 1.0, 1.0, rho);
        assert!((found / expected - 1.0).abs() < 1e-6, "{n}, {rho}: {found}");
    }
    let water = |description: &mut Description, bottom: f64| {
        let (min, max) = (DVec3::new(-4.0, bottom, -4.0), DVec3::new(4.0, 0.0, 4.0));
        add(description, Shape::Box { min, max }, 1.333, 0.0);
    };
    let balls = |description: &mut Description| {
        for (radius, ior) in [(0.8, 1.5), (0.6, 1.0), (0.5, 1.333)] {
            add(description, sphere(DVec3::new(0.0, 1.0, 0.0), radius), ior, 0.0);
        }
    };
    // Where the light is, on which height the plane, where the camera, how much light arrives.
    type Case<'a> = (&'a str, &'a dyn Fn(&mut Description), f64, f64, f64, &'a dyn Fn(f64) -> f64);
    let cases: [Case<'_>; 3] = [
        ("into water", &|d| water(d, -1.2), 1.0, -1.0, -0.3, &|rho| behind_flat_surface(1.333, 1.0, 1.0, rho)),
        ("out of water", &|d| water(d, -2.0), -1.0, 1.0, 0.3, &|rho| behind_flat_surface(1.0 / 1.333, 1.0, 1.0, rho)),
        ("out of balls", &balls, 1.0, -0.5, -0.1, &|rho| 1.5 / (1.5_f64.powi(2) + rho * rho).powf(1.5)),
    ];
    for (name, fill, light, plane, camera, expected) in cases {
        let mut description = empty(1.0);
        description.environment = Environment::Color([0.0; 3]);
        fill(&mut description);
        let screen = Shape::Quad { center: DVec3::Y * plane, edge_u: DVec3::Z * 7.0, edge_v: DVec3::X * 7.0 };
        description.objects.push(Object::new("screen", screen, Solid::of(Paint::Color([ALBEDO; 3]))));
        let emission = Emission { quantity: Quantity::Intensity, rgb: [1.0; 3] };
        let at = Shape::Point { position: DVec3::Y * light };
        description.objects.push(Object::new("light", at, Light { emission, two_sided: false, outside: None }));
        description.camera.position = DVec3::new(0.9, camera, 0.1);
        description.camera.target = DVec3::new(0.6, plane, 0.0);
        description.camera.vertical_fov = 70.0;
        let camera = Camera::new(&description.camera).unwrap();
        let prepared = ready(description);
        let (width, height) = (64, 64);
        // Of flat surfaces the closed form is that of light which goes through once; balls let everything out in the end.
        let max_depth = (name != "out of balls").then_some(3);
        for estimator in BOTH_ENDS {
            let film = Way { max_depth, ..Way::of(estimator) }.film(&prepared, (width, height), 96);
            let (mut measured, mut truth) = (0.0, 0.0);
            for pixel in 0..film.sums.len() {
                let place = DVec2::new((pixel as u32 % width) as f64 + 0.5, (pixel as u32 / width) as f64 + 0.5);
                let ray = camera.ray(place, DVec2::new(width.into(), height.into()), DVec2::ZERO);
                let hit = ray.at((plane - ray.origin.y) / ray.direction.y);
                measured += film.mean(pixel).y * std::f64::consts::PI / ALBEDO;
                truth += expected(hit.x.hypot(hit.z));
            }
            let ratio = measured / truth;
            assert!((ratio - 1.0).abs() < 0.03, "{name}, {estimator:?}: {ratio}");
        }
    }
}
