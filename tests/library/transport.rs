//! Whole images: light that arrives directly and indirectly, absorption, independence of threads and slices, agreement of modes, and
//! agreement with another renderer.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::common::{self, ALBEDO, ESTIMATORS, add, empty, floor, mean, nest, ready, render, render_by, sphere};
use glam::DVec3;
use iorect::formats;
use iorect::geometry::Mesh;
use iorect::measure::metrics;
use iorect::render::{Estimator, Film, ImageSettings, RenderTask};
use iorect::scene::Scene;
use iorect::scene::camera::Camera;
use iorect::scene::description::{Description, Environment, Light, Object, Paint, Shape, Solid};
use iorect::scene::environment::EnvironmentImage;
use iorect::scene::needs::SceneNeeds;
use iorect::tracking::Mode;
use iorect::tracking::{Prepared, prepare};

fn lamp(shape: Shape) -> Object {
    Object::new("lamp", shape, Light::of_radiance([5.0; 3]))
}

/// A lamp that looks down: half a unit by a unit, at a height of 1, straight above the point that is seen.
fn square_lamp() -> Object {
    lamp(Shape::Quad { center: DVec3::Y, edge_u: DVec3::X * 0.5, edge_v: DVec3::Z })
}

/// By each estimator.
fn check_mean(scene: &Prepared, expected: f64) {
    for (estimator, bias) in ESTIMATORS {
        let (measured, error) = mean(&render_by(scene, estimator, (32, 32), 64, None));
        let allowed = 4.0 * error + bias * expected + 1e-9;
        assert!((measured - expected).abs() <= allowed, "{estimator}: {measured} ± {error} is not {expected}");
    }
}

/// By paths from the camera that find light by scattering alone.
fn check_without_light_sampling(scene: &Prepared, expected: f64) {
    let (measured, error) = mean(&render(&without_light_sampling(scene), Mode::Rectified, (32, 32), 64, None));
    assert!((measured - expected).abs() <= 4.0 * error + 1e-9, "{measured} ± {error} is not {expected}");
}

/// The same scene without sampling lights or the environment: light is then found by scattering alone.
fn without_light_sampling(prepared: &Prepared) -> Prepared {
    let needs = SceneNeeds { emitters: false, image_environment: false, ..prepared.scene.needs };
    Prepared { scene: Arc::new(Scene { needs, ..(*prepared.scene).clone() }), ..prepared.clone() }
}

/// A sphere of radius r at distance d, above the horizon: radiance albedo · L (r/d)² cos θ.
#[test]
fn direct_light_of_a_sphere() {
    let mut description = floor();
    let center = DVec3::new(0.0, 2.0, 1.0);
    description.objects.push(lamp(sphere(center, 0.5)));
    let scene = ready(description);
    let d = center.length();
    let expected = ALBEDO * 5.0 * (0.5 / d).powi(2) * (2.0 / d);
    check_mean(&scene, expected);
    check_without_light_sampling(&scene, expected);
}

/// A rectangle a × b at height h over the point: four times the form factor of a quarter with its corner above the point.
#[test]
fn direct_light_of_a_rectangle() {
    let mut description = floor();
    description.objects.push(square_lamp());
    let scene = ready(description);
    let (a, b) = (0.25f64, 0.5f64);
    let part = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
    let form_factor = 4.0 * (part(a, b) + part(b, a)) / std::f64::consts::TAU;
    let expected = ALBEDO * 5.0 * form_factor;
    check_mean(&scene, expected);
    check_without_light_sampling(&scene, expected);
}

/// Lamps shine from their outward side only.
#[test]
fn the_back_of_a_lamp_is_dark() {
    let mut description = floor();
    description.objects.push(lamp(Shape::Quad { center: DVec3::Y, edge_u: DVec3::Z, edge_v: DVec3::X }));
    check_mean(&ready(description), 0.0);
}

/// A matched absorbing pane between lamp and floor, and between floor and camera, dims both ways, also for shadow rays.
#[test]
fn light_through_a_matched_absorbing_pane() {
    let mut description = floor();
    description.objects.push(lamp(sphere(DVec3::new(0.0, 50.0, 0.0), 0.5)));
    description.camera.position = DVec3::new(0.0, 10.0, 1e-3);
    let (min, max) = (DVec3::new(-90.0, 1.0, -90.0), DVec3::new(90.0, 2.0, 90.0));
    add(&mut description, Shape::Box { min, max }, 1.0, 0.7);
    let scene = ready(description);
    let expected = ALBEDO * 5.0 * (0.5f64 / 50.0).powi(2) * (-1.4f64).exp();
    let films = Mode::ALL.map(|mode| (mode.name(), 0.0, render(&scene, mode, (16, 16), 64, None)));
    let by_estimators =
        ESTIMATORS.map(|(estimator, bias)| (estimator.name(), bias, render_by(&scene, estimator, (16, 16), 64, None)));
    for (name, bias, film) in films.into_iter().chain(by_estimators) {
        let (measured, error) = mean(&film);
        // The path through the pane is up to 0.01 % longer than its thickness.
        let allowed = 4.0 * error + (3e-4 + bias) * expected;
        assert!((measured - expected).abs() <= allowed, "{name}: {measured} ± {error} is not {expected}");
    }
}

/// Mean transmittance of a matched absorbing ball over its disc, s = σR: [1 − (1 + 2s)e^(−2s)]/(2s²).
#[test]
fn matched_absorbing_ball() {
    for (s, expected) in [(1.0, 0.296997075), (0.01, 0.986766136)] {
        let mut description = empty(1.3);
        add(&mut description, sphere(DVec3::ZERO, 1.0), 1.3, s);
        description.camera.position = DVec3::new(0.0, 0.0, 1e5);
        description.camera.vertical_fov = 2.0 * (1e-5f64).atan().to_degrees();
        let expected = 1.0 - (1.0 - expected) * std::f64::consts::FRAC_PI_4;
        let scene = ready(description);
        for (estimator, _) in ESTIMATORS {
            let (measured, _) = mean(&render_by(&scene, estimator, (128, 128), 16, None));
            assert!((measured - expected).abs() < 2e-4, "{estimator}: {measured} is not {expected}");
        }
    }
}

/// The global medium fills the bounding sphere and no more.
#[test]
fn an_absorbing_world_leaves_the_environment_in_sight() {
    let mut description = empty(1.0);
    description.world.absorption = [0.5; 3];
    add(&mut description, sphere(DVec3::ZERO, 1.0), 1.0, 0.0);
    description.camera.position = DVec3::new(0.0, 0.0, 1e3);
    description.camera.vertical_fov = 1e-6;
    // The bounding sphere reaches √3 from the middle; the ball itself is clear.
    check_mean(&ready(description), (-0.5 * 2.0 * (3f64.sqrt() - 1.0)).exp());
}

/// An uneven image environment with a sun, found by sampling it and by scattering alone.
#[test]
fn image_environments_are_sampled_without_bias() {
    let pixels = (0..32 * 16)
        .map(|i| if i == 4 * 32 + 11 { [60.0, 50.0, 40.0] } else { [0.2 + 0.05 * (i % 7) as f32; 3] })
        .collect();
    let image = Arc::new(EnvironmentImage { width: 32, height: 16, pixels, notes: vec![] });
    let mut description = floor();
    description.environment = Environment::Image { path: "sky".into(), image, rotation: 40.0, scale: 1.5 };
    let scene = ready(description);
    let (scattered, other_error) = mean(&render(&without_light_sampling(&scene), Mode::Rectified, (64, 64), 256, None));
    for (estimator, bias) in ESTIMATORS {
        let (sampled, error) = mean(&render_by(&scene, estimator, (32, 32), 64, None));
        assert!(
            (sampled - scattered).abs() <= 4.0 * error.hypot(other_error) + bias * scattered,
            "{estimator}: {sampled} ± {error}, {scattered} ± {other_error}"
        );
        // A quarter of the error would be what sixteen times the samples give.
        assert!(
            error < 2.0 * other_error,
            "{estimator}, sampling helps: {error} against {other_error} with sixteen times the samples"
        );
    }
}

/// A grey convex solid in a white room has the radiance of its albedo; in a mirror the room looks as it is, times the tint.
#[test]
fn grey_and_mirroring_solids_in_a_white_room() {
    for mirror in [false, true] {
        let mut description = empty(1.0);
        description.objects.push(Object::new(
            "ball",
            sphere(DVec3::ZERO, 1.0),
            Solid { mirror, ..Solid::of(Paint::Color([ALBEDO; 3])) },
        ));
        description.camera.vertical_fov = 1.0;
        check_mean(&ready(description), ALBEDO);
    }
}

/// Interpolated normals bend light as a smooth surface would, but never to the wrong side: no medium is missed, and a coarse smooth ball
/// bends light more like a sphere than a flat one does. A lossless nest of them all but vanishes in a white room; not quite, as their
/// paths cannot be reversed, and some light is caught for ever.
#[test]
fn interpolated_normals() {
    let ball = |smooth: bool| {
        let mut description = empty(1.0);
        description.camera.vertical_fov = 12.0;
        for (radius, ior) in [(1.0, 1.5), (0.7, 1.2)] {
            add(&mut description, Shape::Icosphere { center: DVec3::ZERO, radius, subdivisions: 2 }, ior, 0.0);
        }
        description.objects.refractor_roles_mut().for_each(|r| r.smooth = smooth);
        ready(description)
    };
    let film = render(&ball(true), Mode::Rectified, (64, 64), 16, None);
    assert_eq!(film.events.total(), 0);
    let (measured, _) = mean(&film);
    assert!((measured - 1.0).abs() <= 5e-3, "{measured}");

    let exact = ready(nest(1.0, &[(1.0, 1.5), (0.7, 1.2)]));
    let error = |smooth: bool| -> f64 {
        let scene = ball(smooth);
        let degrees =
            |scene: &Prepared, b: f64| common::deflection_degrees(&common::through(scene, Mode::Rectified, b));
        (1..60).map(|k| f64::from(k) / 100.0).map(|b| (degrees(&scene, b) - degrees(&exact, b)).abs()).sum()
    };
    let (smooth, flat) = (error(true), error(false));
    assert!(smooth < 0.5 * flat, "{smooth} {flat}");
}

/// A busy scene: spheres and meshes, nested and absorbing, a floor, a lamp and an image.
fn busy() -> Prepared {
    let mut description = floor();
    description.camera.vertical_fov = 40.0;
    description.camera.aperture_radius = 0.05;
    add(&mut description, Shape::Icosphere { center: DVec3::Y * 1.2, radius: 1.0, subdivisions: 3 }, 1.5, 0.1);
    add(&mut description, sphere(DVec3::new(0.1, 1.2, 0.0), 0.6), 1.333, 0.2);
    add(&mut description, sphere(DVec3::new(0.2, 1.1, 0.1), 0.3), 1.0, 0.0);
    description.objects.push(square_lamp());
    description.objects.lights_mut()[0].transform.translate = DVec3::Y * 3.0;
    description.environment =
        Environment::Gradient { zenith: [0.3, 0.5, 1.0], horizon: [0.8; 3], nadir: [0.1, 0.05, 0.0] };
    ready(description)
}

#[test]
fn results_do_not_depend_on_threads_or_slices() {
    let scene = busy();
    let camera = Camera::new(&scene.description.camera).unwrap();
    let settings = ImageSettings::new(Mode::Rectified, 7);
    let render = |threads: usize, slices: &[u32]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut film = Film::new(40, 30);
        pool.install(|| {
            for &samples in slices {
                assert!(RenderTask { prepared: &scene, camera: &camera, settings: &settings }.pass(
                    &mut film,
                    samples,
                    &AtomicBool::new(false)
                ));
            }
        });
        film
    };
    let one = render(1, &[6]);
    assert_eq!(one, render(2, &[6]));
    assert_eq!(one, render(5, &[6]));
    assert_eq!(one, render(2, &[1, 2, 3]));
    assert!(one.sums.iter().any(|s| *s != DVec3::ZERO));
}

/// In cleanly nested scenes the stored answer and the answer asked anew are the same, so the images are too, bit for bit; the stack
/// agrees from outside. Leaving nothing out changes nothing either.
#[test]
fn modes_agree_where_they_should() {
    let scene = busy();
    let rectified = render(&scene, Mode::Rectified, (32, 24), 4, None);
    assert_eq!(rectified.events.total(), 0);
    assert_eq!(rectified.sums, render(&scene, Mode::Reference, (32, 24), 4, None).sums);
    assert_eq!(rectified.sums, render(&scene, Mode::Stack, (32, 24), 4, None).sums);
    assert_ne!(rectified.sums, render(&scene, Mode::Naive, (32, 24), 4, None).sums);

    let camera = Camera::new(&scene.description.camera).unwrap();
    let settings = ImageSettings { leave_out: false, ..ImageSettings::new(Mode::Rectified, 1) };
    let mut everything = Film::new(32, 24);
    assert!(RenderTask { prepared: &scene, camera: &camera, settings: &settings }.pass(
        &mut everything,
        4,
        &AtomicBool::new(false)
    ));
    assert_eq!(rectified.sums, everything.sums);
}

#[test]
fn a_cancelled_pass_says_so() {
    let scene = ready(nest(1.0, &[(1.0, 1.5)]));
    let camera = Camera::new(&scene.description.camera).unwrap();
    let settings = ImageSettings::new(Mode::Stack, 0);
    let mut film = Film::new(8, 8);
    assert!(!RenderTask { prepared: &scene, camera: &camera, settings: &settings }.pass(
        &mut film,
        1,
        &AtomicBool::new(true)
    ));
    assert_eq!(film.samples, 0);
}

/// A pass can be cancelled at any moment and gone on with: in the end everything is as if it had not been.
#[test]
fn a_cancelled_pass_loses_nothing() {
    let scene = ready(nest(1.0, &[(1.0, 1.5), (0.6, 1.2)]));
    let camera = Camera::new(&scene.description.camera).unwrap();
    let settings = ImageSettings::new(Mode::Naive, 0);
    let task = RenderTask { prepared: &scene, camera: &camera, settings: &settings };
    let mut whole = Film::new(96, 64);
    assert!(task.pass(&mut whole, 12, &AtomicBool::new(false)));
    let interrupted = || {
        let mut film = Film::new(96, 64);
        let mut cancelled = 0;
        for attempt in 0.. {
            let cancel = AtomicBool::new(false);
            let slice = [5, 1, 4][attempt % 3].min(12 - film.samples);
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    std::thread::sleep(std::time::Duration::from_micros(500 + 400 * attempt as u64));
                    cancel.store(true, std::sync::atomic::Ordering::Relaxed);
                });
                cancelled += usize::from(!task.pass(&mut film, slice, &cancel));
            });
            assert!(film.counts.chunks(96).all(|row| row.iter().all(|count| *count == row[0])), "a row is whole");
            if film.samples == 12 {
                break;
            }
        }
        (cancelled > 0).then_some(film)
    };
    // On a busy machine the one who cancels may always come too late.
    let film = (0..50).find_map(|_| interrupted()).expect("some pass is cancelled");
    assert_eq!((film.sums, film.counts), (whole.sums, whole.counts));
    assert_eq!(film.events, whole.events);
    assert!(film.ahead.iter().all(|ahead| *ahead == 0));
}

/// An edit of an index keeps geometry and votes, and another pre-trace adds to them; the result is that of a scene compiled from scratch.
#[test]
fn edits_keep_what_they_cannot_change() {
    let before = busy();
    let mut description = (*before.description).clone();
    description.media[1].ior = iorect::optics::Ior::Constant(1.7);
    description.world.ior = iorect::optics::Ior::Constant(1.1);
    let description = Arc::new(description);
    let after = prepare(Arc::clone(&description), Some(&before)).unwrap();
    let fresh = prepare(description, None).unwrap();
    assert!(Arc::ptr_eq(&before.scene.geometry, &after.scene.geometry));
    assert_eq!(after.table.patches[0].rays, before.table.patches[0].rays);
    let again = after.table.repeated(&after.scene);
    assert!(again.patches[0].rays > after.table.patches[0].rays && again.says_the_same(&after.table));
    let outsides = |p: &Prepared| p.table.patches.iter().map(|p| (p.outside, p.inside)).collect::<Vec<_>>();
    assert_eq!(outsides(&after), outsides(&fresh));
    let [a, b] = [&after, &fresh].map(|scene| render(scene, Mode::Rectified, (24, 16), 2, None).sums);
    assert_eq!(a, b);

    // Moving an object is another geometry.
    let mut moved = (*before.description).clone();
    moved.objects.refractors_mut()[1].transform.translate.x += 0.01;
    let moved = prepare(Arc::new(moved), Some(&before)).unwrap();
    assert!(!Arc::ptr_eq(&before.scene.geometry, &moved.scene.geometry));
}

/// The image of another renderer that was told every interface by hand.
mod against_another_renderer {
    use super::*;
    use iorect::report::stability::scenes;

    /// Samples a pixel, `default` unless `IORECT_TEST_SPP` says otherwise: with 1024 and `--nocapture` the tests print the figures of
    /// the README.
    fn spp(default: u32) -> u32 {
        std::env::var("IORECT_TEST_SPP").ok().and_then(|text| text.parse().ok()).unwrap_or(default)
    }

    fn load_scene(name: &str) -> Description {
        formats::open(format!("tests/data/reference/{name}.toml")).expect("the scene is in the repository")
    }

    /// relMSE against the image of `name`, of pixels and of means over 16×16 of them, freed from noise: (x₁ − r)(x₂ − r)/(r² + 0.01) of two
    /// independent renders of half the samples, which is 0 on average where only noise differs. Measured over pairs of seeds: ±5e-5 and
    /// ±3e-6 for s1 at 16 samples, ±1.4e-4 and ±5e-6 for s2 at 8.
    fn errors(name: &str, description: Description, mode: Mode, spp: u32) -> (f64, f64) {
        errors_by(Estimator::Path, name, description, mode, spp)
    }

    #[expect(clippy::print_stdout, reason = "shown on failure, and asked for with --nocapture")]
    fn errors_by(estimator: Estimator, name: &str, description: Description, mode: Mode, spp: u32) -> (f64, f64) {
        let path = format!("tests/data/reference/{}_refdeep256.exr", name.to_uppercase());
        let truth = image::open(path).expect("the image is in the repository").to_rgb32f();
        let truth: Vec<[f32; 3]> = truth.pixels().map(|p| p.0).collect();
        let scene = ready(description);
        let [a, b] = [1, 2]
            .map(|seed| scenes::render_by(&scene, estimator, mode, (256, 256), spp / 2, seed, None).unwrap().to_rgb());
        let both: Vec<[f32; 3]> = a.iter().zip(&b).map(|(a, b)| [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]))).collect();
        let blocks = |rgb: &[[f32; 3]]| metrics::block_means(rgb, 256, 256, 16).unwrap();
        let [blocks_a, blocks_b, blocks_of_both, blocks_of_truth] = [&a, &b, &both, &truth].map(|rgb| blocks(rgb));
        let (pixels, of_blocks) = (common_error(&a, &b, &truth), common_error(&blocks_a, &blocks_b, &blocks_of_truth));
        let relmse = |a: &[[f32; 3]], b: &[[f32; 3]]| metrics::difference(a, b).unwrap().relmse;
        println!(
            "{name} {mode} {estimator} at {spp} spp: relMSE {:.3e}, of blocks {:.3e}; without noise {pixels:.3e} and {of_blocks:.3e}",
            relmse(&both, &truth),
            relmse(&blocks_of_both, &blocks_of_truth)
        );
        (pixels, of_blocks)
    }

    /// Mean (a − r)(b − r)/(r² + 0.01) over all channels.
    fn common_error(a: &[[f32; 3]], b: &[[f32; 3]], r: &[[f32; 3]]) -> f64 {
        let [a, b, r] = [a, b, r].map(|image| image.iter().flatten().map(|&x| f64::from(x)));
        let products: Vec<f64> = a.zip(b).zip(r).map(|((a, b), r)| (a - r) * (b - r) / (r * r + 0.01)).collect();
        products.iter().sum::<f64>() / products.len() as f64
    }

    #[test]
    fn rectified_agrees_on_nested_spheres() {
        let (pixels, blocks) = errors("s1", load_scene("s1"), Mode::Rectified, spp(16));
        assert!(pixels < 3e-4 && blocks < 3e-5, "{pixels:e} {blocks:e}");
    }

    /// By paths from both ends, with fewer samples, which take longer: their noise is larger, and cancels out of what is compared. Merging is biased, by
    /// so few samples the most: 8e-5 in s1.
    #[test]
    fn other_estimators_agree() {
        for (estimator, bias) in [(Estimator::Bidirectional, 0.0), (Estimator::Merging, 1e-4)] {
            for (name, limit, of_blocks) in [("s1", 9e-4, 6e-5 + bias), ("s2", 3e-3, 1e-4 + bias)] {
                let (pixels, blocks) = errors_by(estimator, name, load_scene(name), Mode::Rectified, spp(4));
                assert!(pixels < limit && blocks < of_blocks, "{name}, {estimator}: {pixels:e} {blocks:e}");
            }
        }
    }

    #[test]
    fn naive_is_as_wrong_as_the_other_renderers_naive() {
        let (pixels, _) = errors("s1", load_scene("s1"), Mode::Naive, spp(4));
        assert!((pixels - 0.180).abs() < 0.01, "{pixels}");
    }

    /// To the bit, on a smaller image, without events.
    fn assert_same(a: (&Prepared, Mode), b: (&Prepared, Mode)) {
        let [a, b] = [a, b].map(|(scene, mode)| render(scene, mode, (64, 64), 2, None));
        assert_eq!(a.sums, b.sums);
        assert_eq!(a.events.total() + b.events.total(), 0);
    }

    fn without_priorities(mut description: Description) -> Prepared {
        description.objects.refractor_roles_mut().for_each(|refractor| refractor.priority = 0);
        ready(description)
    }

    /// Water that overlaps its glass and ice that floats half out, decided by priorities: `rectified` and `reference` agree, `priority` can be
    /// trusted from outside, and one exterior per object cannot.
    #[test]
    fn overlapping_volumes() {
        let (pixels, blocks) = errors("s2", load_scene("s2"), Mode::Rectified, spp(8));
        assert!(pixels < 1e-3 && blocks < 3e-5, "{pixels:e} {blocks:e}");
        let scene = ready(load_scene("s2"));
        for mode in [Mode::Reference, Mode::Priority] {
            assert_same((&scene, Mode::Rectified), (&scene, mode));
        }
        let (_, blocks) = errors("s2", load_scene("s2"), Mode::RectifiedObject, spp(4));
        assert!(blocks > 1e-3, "{blocks:e}");
    }

    /// Without priorities the smaller volume wins, which here is what the priorities say: ice before glass before water.
    #[test]
    fn overlapping_volumes_without_priorities() {
        let scene = without_priorities(load_scene("s2"));
        assert_same((&ready(load_scene("s2")), Mode::Rectified), (&scene, Mode::Rectified));
    }

    /// How water is modelled that ends where its glass begins.
    #[derive(Clone, Copy)]
    enum Bed {
        /// By the faces of the glass.
        SameFaces,
        /// In the same planes, divided into fewer faces along other diagonals.
        OtherFaces,
        /// By the faces of the glass, and then shrunk by a thousandth about its middle: an air gap.
        Apart,
    }

    /// The scene s2 with the overlapping water replaced by one that lies in the glass as `bed` says.
    fn with_water_that_fits(bed: Bed) -> Description {
        const BOTTOM: f64 = 0.21;
        const LEVEL: f64 = 1.71;
        let mut description = load_scene("s2");
        let glass = description.objects.refractors().iter().find(|r| r.name == "glass").expect("s2 has a glass");
        let Shape::Mesh { mesh: glass, .. } = &glass.shape else { panic!("the glass is a mesh") };
        // The inner side of the wall is a cone above a disc.
        let inner_radius = |y: f64| 0.68 + (y - BOTTOM) * 0.0864;
        let is_wet = |i: &u32| {
            let p = glass.positions[*i as usize];
            p.y > BOTTOM - 1e-4 && p.y < LEVEL + 1e-4 && p.x.hypot(p.z) < inner_radius(p.y) + 1e-3
        };
        let mut water =
            Mesh { positions: glass.positions.clone(), normals: Vec::new(), triangles: Vec::new(), uvs: Vec::new() };
        let ring = |y: f64| -> Vec<u32> {
            let on_ring = |i: &u32| {
                let p = glass.positions[*i as usize];
                (p.y - y).abs() < 1e-4 && (p.x.hypot(p.z) - inner_radius(y)).abs() < 1e-3
            };
            let mut ring: Vec<u32> = (0..glass.positions.len() as u32).filter(on_ring).collect();
            let angle = |i: &u32| glass.positions[*i as usize].z.atan2(glass.positions[*i as usize].x);
            ring.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
            ring
        };
        let (low, high) = (ring(BOTTOM), ring(LEVEL));
        assert_eq!((low.len(), high.len()), (128, 128));
        let segments = |ring: &[u32]| -> Vec<[u32; 2]> {
            (0..ring.len()).map(|k| [ring[k], ring[(k + 1) % ring.len()]]).collect()
        };
        // Angles run from +x to +z, clockwise seen from above.
        let fan = |water: &mut Mesh, ring: &[u32], is_up: bool| {
            let middle = water.positions.len() as u32;
            water.positions.push(DVec3::Y * glass.positions[ring[0] as usize].y);
            let faces = segments(ring).into_iter().map(|[a, b]| if is_up { [middle, b, a] } else { [middle, a, b] });
            water.triangles.extend(faces);
        };
        fan(&mut water, &high, true);
        if let Bed::OtherFaces = bed {
            fan(&mut water, &low, false);
            for ([a, b], [d, c]) in segments(&low).into_iter().zip(segments(&high)) {
                water.triangles.extend([[a, d, b], [b, d, c]]);
            }
        } else {
            let wet = glass.triangles.iter().filter(|triangle| triangle.iter().all(is_wet));
            water.triangles.extend(wet.map(|&[a, b, c]| [a, c, b]));
        }
        if let Bed::Apart = bed {
            let middle = DVec3::Y * (0.5 * (BOTTOM + LEVEL));
            water.positions.iter_mut().for_each(|p| *p = middle + (*p - middle) * 0.999);
        }
        let volume = water.signed_volume();
        assert!((volume - 2.63).abs() < 0.05, "closed, and outward: {volume}");
        let shape = Shape::mesh("water.ply", Arc::new(water));
        description.objects.refractors_mut().iter_mut().find(|r| r.name == "water").expect("s2 has water").shape =
            shape;
        description
    }

    /// Water that touches its glass exactly is the same water, however its faces are cut.
    #[test]
    fn touching_volumes() {
        for bed in [Bed::SameFaces, Bed::OtherFaces] {
            let description = with_water_that_fits(bed);
            let (pixels, blocks) = errors("s2", description.clone(), Mode::Rectified, spp(8));
            assert!(pixels < 1e-3 && blocks < 3e-5, "{pixels:e} {blocks:e}");
            let scene = without_priorities(description.clone());
            assert_same((&ready(description), Mode::Rectified), (&scene, Mode::Rectified));
        }
    }

    /// A gap of air, a thousandth wide, looks like one: light is reflected at it that was not before. `reference` sees the same.
    #[test]
    fn an_air_gap_is_seen() {
        let description = with_water_that_fits(Bed::Apart);
        let (_, blocks) = errors("s2", description.clone(), Mode::Rectified, spp(4));
        assert!(blocks > 1e-3, "{blocks:e}");
        let scene = ready(description);
        assert_same((&scene, Mode::Rectified), (&scene, Mode::Reference));
    }

    /// The comparison notices an index that is wrong by 1 %.
    #[test]
    fn a_planted_error_is_seen() {
        let mut description = load_scene("s1");
        description.media[1].ior = iorect::optics::Ior::Constant(1.33 * 1.01);
        let (pixels, blocks) = errors("s1", description, Mode::Rectified, spp(4));
        assert!(pixels > 3e-4 && blocks > 3e-5, "{pixels:e} {blocks:e}");
    }
}
