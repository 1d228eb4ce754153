//! Interpolated normals on coarse meshes lose no light: lossless objects in a white room cannot be seen, and what they show comes near to what the
//! round shape shows.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::common::{Numbers, add, case, empty, mean, ready, render, sphere};
use glam::DVec3;
use iorect::geometry::{Geometry, Mesh, Part, Ray};
use iorect::optics::Interface;
use iorect::render::{Film, ImageSettings, RenderTask};
use iorect::scatter::dielectric::{self, Choice};
use iorect::scatter::normals::Normals;
use iorect::scene::camera::Camera;
use iorect::scene::description::{Description, Environment, Kind, Object, Paint, Shape, Solid};
use iorect::scene::environment::EnvironmentImage;
use iorect::tracking::Mode;
use iorect::tracking::Prepared;

/// A closed surface of revolution about y with its exact normals: for each point of the outline from the top to the bottom, radius and height and
/// the normal's. Where the radius is 0, one vertex.
fn revolved(outline: &[[f64; 4]], segments: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let mut rings: Vec<Vec<u32>> = Vec::new();
    for &[r, y, normal_r, normal_y] in outline {
        let count = if r.abs() < 1e-12 { 1 } else { segments };
        let first = mesh.positions.len() as u32;
        for i in 0..count {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(segments)).sin_cos();
            mesh.positions.push(DVec3::new(r * cos, y, -r * sin));
            mesh.normals.push(DVec3::new(normal_r * cos, normal_y, -normal_r * sin).normalize());
        }
        rings.push((0..=segments).map(|i| first + i % count).collect());
    }
    for ring in rings.windows(2) {
        for i in 0..segments as usize {
            let [a, b, c, d] = [ring[0][i], ring[1][i], ring[1][i + 1], ring[0][i + 1]];
            mesh.triangles
                .extend([[a, b, c], [a, c, d]].into_iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]));
        }
    }
    mesh
}

/// Points of an arc of radius `r` about (0, `y`), from one angle to another, measured from the top.
fn arc(r: f64, y: f64, from: f64, to: f64, pieces: u32) -> impl Iterator<Item = [f64; 4]> {
    (0..=pieces).map(move |i| {
        let (sin, cos) = (from + (to - from) * f64::from(i) / f64::from(pieces)).sin_cos();
        // The poles' radius is 0 but for rounding.
        let sin = if sin.abs() < 1e-12 { 0.0 } else { sin };
        [r * sin, y + r * cos, sin, cos]
    })
}

fn round(radius: f64, segments: u32, rings: u32) -> Mesh {
    revolved(&arc(radius, 0.0, 0.0, PI, rings).collect::<Vec<_>>(), segments)
}

fn capsule(segments: u32, rings: u32) -> Mesh {
    let outline: Vec<_> = arc(0.6, 0.5, 0.0, FRAC_PI_2, rings).chain(arc(0.6, -0.5, FRAC_PI_2, PI, rings)).collect();
    revolved(&outline, segments)
}

/// A cube whose normals are those of a ball: farther from the faces' own than on any mesh that one would call smooth.
fn rounded_cube() -> Mesh {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 1.4 - 0.7;
    let positions: Vec<DVec3> = (0..8).map(corner).collect();
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        normals: positions.iter().map(|p| p.normalize()).collect(),
        positions,
        triangles: squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        uvs: Vec::new(),
    }
}

fn given(mesh: Mesh) -> Shape {
    Shape::mesh("made.obj", Arc::new(mesh))
}

/// Coarse shapes of every kind, with a name; with their own normals and with those that the program works out.
fn shapes() -> Vec<(&'static str, Shape)> {
    let lathe = |profile: &[[f64; 2]], segments| Shape::Lathe { profile: profile.to_vec(), segments };
    vec![
        ("ball 10 × 10", given(round(1.0, 10, 10))),
        ("ball 6 × 4", given(round(1.0, 6, 4))),
        ("icosphere", Shape::Icosphere { center: DVec3::ZERO, radius: 1.0, subdivisions: 1 }),
        ("icosahedron", Shape::Icosphere { center: DVec3::ZERO, radius: 1.0, subdivisions: 0 }),
        ("capsule", given(capsule(8, 3))),
        ("torus 8 × 6", Shape::Torus { center: DVec3::ZERO, major: 0.7, minor: 0.3, segments: 8, rings: 6 }),
        ("torus 16 × 10", Shape::Torus { center: DVec3::ZERO, major: 0.7, minor: 0.3, segments: 16, rings: 10 }),
        ("cylinder", Shape::Cylinder { center: DVec3::ZERO, radius: 0.7, height: 1.4, segments: 8 }),
        ("lathe", lathe(&[[0.0, -0.9], [0.5, -0.8], [0.8, -0.3], [0.6, 0.2], [0.7, 0.7], [0.0, 0.9]], 9)),
        ("bowl", lathe(&[[0.0, -0.6], [0.6, -0.5], [0.9, 0.2], [0.8, 0.25], [0.5, -0.3], [0.0, -0.4]], 9)),
        ("rounded cube", given(rounded_cube())),
    ]
}

/// One smooth refractor in a white room, seen from nearby.
fn in_white_room(shape: Shape, ior: f64) -> Description {
    let mut description = empty(1.0);
    add(&mut description, shape, ior, 0.0);
    description.objects.refractors_mut()[0].refractor_mut().unwrap().smooth = true;
    description.camera.position = DVec3::new(0.3, 1.1, 4.0);
    description.camera.vertical_fov = 32.0;
    description
}

/// Renders without what makes a pixel's samples differ in weight: a path that gets out shows the room, which is then all that a pixel shows.
fn plain(scene: &Prepared, mode: Mode, size: u32, samples: u32) -> Film {
    let settings = ImageSettings { splits: 0, ..ImageSettings::new(mode, 1) };
    let camera = Camera::new(&scene.description.camera).expect("the camera is fine");
    let mut film = Film::new(size, size);
    assert!(RenderTask { prepared: scene, camera: &camera, settings: &settings }.pass(
        &mut film,
        samples,
        &AtomicBool::new(false)
    ));
    film
}

/// Mean and least radiance of the pixels.
fn mean_and_least(film: &Film) -> (f64, f64) {
    let least = (0..film.sums.len()).map(|pixel| film.mean(pixel).min_element()).fold(f64::INFINITY, f64::min);
    (mean(film).0, least)
}

/// Asserts that nothing is seen: every path gets out and brings `radiance`. Only those of over 64 segments may be ended by roulette, and the others
/// of them then count for more: at the most two of a pixel's, and in the mean that evens out. On round shapes it was one path in 100,000.
fn assert_white(scene: &Prepared, mode: Mode, radiance: f64, what: &str) {
    let film = plain(scene, mode, 32, if mode == Mode::Reference { 4 } else { 16 });
    let (mean, least) = mean_and_least(&film);
    assert_eq!(film.events.total(), 0, "{what}, {mode}");
    assert!((mean / radiance - 1.0).abs() < 5e-4, "{what}, {mode}: mean {mean}");
    assert!(least / radiance > 0.86, "{what}, {mode}: a pixel of {least}");
}

/// The case of its kind: the mean was 0.995 and the darkest pixel 0.5.
#[test]
fn the_rims_of_a_coarse_glass_ball_are_bright() {
    let scene = ready(case("smooth-dark-rims/scene.toml"));
    for mode in Mode::ALL {
        assert_white(&scene, mode, 1.0, "the case");
        let (_, least) = mean_and_least(&plain(&scene, mode, 32, 4));
        assert!(least > 0.9999, "{mode}: {least}");
    }
    // As it is rendered by default, paths split and play roulette.
    let (measured, error) = mean(&render(&scene, Mode::Rectified, (64, 64), 64, None));
    assert!((measured - 1.0).abs() < 4.0 * error + 1e-5, "{measured} ± {error}");
}

#[test]
fn coarse_smooth_glass_is_white_in_a_white_room() {
    for (name, shape) in shapes() {
        for ior in [1.1, 1.33, 1.5, 2.4] {
            assert_white(&ready(in_white_room(shape.clone(), ior)), Mode::Rectified, 1.0, &format!("{name} of {ior}"));
        }
    }
}

/// At the middle of a ball every direction gets out, with radiance n².
#[test]
fn coarse_smooth_glass_is_white_from_within() {
    for (name, mesh) in
        [("ball 10 × 10", round(1.0, 10, 10)), ("ball 6 × 4", round(1.0, 6, 4)), ("capsule", capsule(8, 3))]
    {
        for ior in [1.1, 1.5, 2.4] {
            let mut description = in_white_room(given(mesh.clone()), ior);
            description.camera.position = DVec3::new(0.02, 0.01, 0.03);
            description.camera.target = DVec3::new(0.3, 0.2, 0.7);
            description.camera.vertical_fov = 90.0;
            assert_white(&ready(description), Mode::Rectified, ior * ior, &format!("within {name} of {ior}"));
        }
    }
}

/// Smooth shapes in each other, and a world that is not vacuum.
#[test]
fn coarse_smooth_nests_are_white_in_a_white_room() {
    for (world, iors) in [(1.0, [1.5, 1.333, 1.0]), (1.333, [1.0, 1.5, 2.4]), (1.0, [1.31, 1.333, 1.5])] {
        let mut description = in_white_room(given(round(1.0, 10, 10)), iors[0]);
        description.world.ior = iorect::optics::Ior::Constant(world);
        add(&mut description, given(round(0.8, 8, 6)), iors[1], 0.0);
        let (center, major, minor) = (DVec3::new(0.05, 0.0, 0.0), 0.35, 0.15);
        add(&mut description, Shape::Torus { center, major, minor, segments: 9, rings: 6 }, iors[2], 0.0);
        description.objects.refractor_roles_mut().for_each(|r| r.smooth = true);
        let scene = ready(description);
        for mode in [Mode::Rectified, Mode::Reference, Mode::Priority] {
            assert_white(&scene, mode, 1.0, &format!("{iors:?} in {world}"));
        }
    }
}

fn white_solid(shape: Shape, mirror: bool) -> Description {
    let mut description = in_white_room(sphere(DVec3::new(0.0, -50.0, 0.0), 1.0), 1.5);
    description.objects.clear(Kind::Refractor);
    description.media.clear();
    description.objects.push(Object::new(
        "solid",
        shape,
        Solid { mirror, smooth: true, ..Solid::of(Paint::Color([1.0; 3])) },
    ));
    description
}

/// Nor does a white surface lose light at its terminator, or a mirror at its silhouette.
#[test]
fn coarse_smooth_solids_are_white_in_a_white_room() {
    for (name, shape) in shapes() {
        for mirror in [false, true] {
            let scene = ready(white_solid(shape.clone(), mirror));
            assert_white(&scene, Mode::Rectified, 1.0, &format!("{name}, mirror {mirror}"));
        }
    }
}

/// In an uneven environment, light sampling and scattering find together what scattering finds alone: both know how the cosine lobe is cut off.
#[test]
fn light_sampling_knows_what_interpolated_normals_do() {
    let pixels = (0..32 * 16).map(|i| if i % 97 == 5 { [20.0; 3] } else { [0.5; 3] }).collect();
    let image = Arc::new(EnvironmentImage { width: 32, height: 16, pixels, notes: Vec::new() });
    for shape in [given(round(1.0, 6, 4)), given(rounded_cube())] {
        let mut description = white_solid(shape, false);
        description.environment =
            Environment::Image { path: "sky".into(), image: image.clone(), rotation: 0.0, scale: 1.0 };
        description.camera.vertical_fov = 12.0;
        let scene = ready(description);
        let [sampled, scattered] = [true, false].map(|sample_environment| {
            let means: Vec<f64> = (0..8)
                .map(|seed| {
                    let settings = ImageSettings { sample_environment, ..ImageSettings::new(Mode::Rectified, seed) };
                    let camera = Camera::new(&scene.description.camera).expect("the camera is fine");
                    let mut film = Film::new(16, 16);
                    RenderTask { prepared: &scene, camera: &camera, settings: &settings }.pass(
                        &mut film,
                        256,
                        &AtomicBool::new(false),
                    );
                    mean(&film).0
                })
                .collect();
            iorect::report::stability::scenes::mean_and_error(&means)
        });
        let ((a, a_error), (b, b_error)) = (sampled, scattered);
        println!("{a} ± {a_error}, {b} ± {b_error}");
        assert!((a - b).abs() < 4.0 * a_error.hypot(b_error), "{a} ± {a_error} is not {b} ± {b_error}");
        assert!(a_error.max(b_error) < 0.01 * b, "{a_error} {b_error}: too noisy to tell");
    }
}

/// Which normals a ray is scattered about: a rule that is given the interface, the direction, the normals and the path's segment.
type Rule = fn(&Interface, DVec3, &Normals, u32, f64) -> dielectric::Scattered;

fn by_the_program(
    interface: &Interface,
    direction: DVec3,
    normals: &Normals,
    segment: u32,
    u: f64,
) -> dielectric::Scattered {
    dielectric::scatter(interface, direction, normals, segment, Choice::Sample(u))
}

/// The planted fault: where a normal looks away or sends a ray to the wrong side, the event is done again about the face's.
fn by_falling_back(
    interface: &Interface,
    direction: DVec3,
    normals: &Normals,
    _: u32,
    u: f64,
) -> dielectric::Scattered {
    let about = |normal| dielectric::scatter(interface, direction, &Normals::flat(normal), 1, Choice::Sample(u));
    if direction.dot(normals.shading) < 0.0 {
        let scattered = about(normals.shading);
        if (scattered.direction.dot(normals.face) < 0.0) == scattered.is_transmitted {
            return scattered;
        }
    }
    about(normals.face)
}

/// The planted fault: as the program does, but at every segment the interpolated normal alone says where reflection is total.
fn by_trusting_for_ever(
    interface: &Interface,
    direction: DVec3,
    normals: &Normals,
    _: u32,
    u: f64,
) -> dielectric::Scattered {
    by_the_program(interface, direction, normals, 1, u)
}

/// Segments after which a path counts as caught.
const CAUGHT: u32 = 400;

/// Share of the paths from outside towards `mesh` that are caught.
fn share_caught(mesh: &Mesh, ior: f64, rule: Rule) -> f64 {
    let geometry = Geometry::build(&[Part::Mesh { mesh: mesh.clone(), smooth: true }][..]);
    let mut numbers = Numbers(5);
    let paths = 5000;
    let mut caught = 0;
    for _ in 0..paths {
        let origin = DVec3::new(0.3, 1.1, 4.0);
        let target = DVec3::new(numbers.between(-1.1, 1.1), numbers.between(-1.1, 1.1), numbers.between(-1.1, 1.1));
        let mut ray = Ray::new(origin, (target - origin).normalize());
        let mut segment = 1;
        while let Some(hit) = geometry.closest(&ray).filter(|_| segment <= CAUGHT) {
            let point = geometry.surface(&ray, &hit);
            let outward = if hit.is_front { 1.0 } else { -1.0 };
            let normals = Normals {
                face: point.normal * outward,
                shading: geometry.shading_normal(&hit, point.normal) * outward,
            };
            let interface = if hit.is_front { Interface::new(0.0, ior - 1.0) } else { Interface::new(ior - 1.0, 0.0) };
            let scattered = rule(&interface, ray.direction, &normals, segment, numbers.next());
            ray = Ray::leaving(point.position, scattered.direction, hit.primitive);
            segment += 1;
        }
        caught += u32::from(segment > CAUGHT);
    }
    f64::from(caught) / f64::from(paths)
}

/// Where the light went: paths that a fallback let in at angles at which the interpolated normals never let them out.
#[test]
fn paths_are_not_caught() {
    let rules: [Rule; 3] = [by_the_program, by_falling_back, by_trusting_for_ever];
    for (name, mesh) in
        [("ball 10 × 10", round(1.0, 10, 10)), ("ball 6 × 4", round(1.0, 6, 4)), ("cube", rounded_cube())]
    {
        let [program, fallback, trusting] = rules.map(|rule| share_caught(&mesh, 1.5, rule));
        println!("{name}: {program}, falling back {fallback}, trusting for ever {trusting}");
        assert_eq!(program, 0.0, "{name}");
        assert!(fallback > 2e-3, "{name}: the planted fault catches {fallback}");
        assert!(trusting > 5e-3 || name != "cube", "{name}: the planted fault catches {trusting}");
    }
}

/// Mean squared relative difference to the picture of a glass sphere, by two pictures of independent noise of each.
fn difference_to_sphere(shape: Shape, ior: f64, smooth: bool) -> f64 {
    let picture = |shape: Shape, seed: u64| {
        let mut description = in_white_room(shape, ior);
        description.objects.refractors_mut()[0].refractor_mut().unwrap().smooth =
            smooth && !matches!(description.objects.refractors()[0].shape, Shape::Sphere { .. });
        description.environment =
            Environment::Gradient { zenith: [1.0, 0.9, 0.2], horizon: [0.3; 3], nadir: [0.05, 0.1, 0.4] };
        let scene = ready(description);
        let settings = ImageSettings::new(Mode::Rectified, seed);
        let camera = Camera::new(&scene.description.camera).expect("the camera is fine");
        let mut film = Film::new(64, 64);
        RenderTask { prepared: &scene, camera: &camera, settings: &settings }.pass(
            &mut film,
            64,
            &AtomicBool::new(false),
        );
        film
    };
    let analytic = || sphere(DVec3::ZERO, 1.0);
    let [a, b, r, s] =
        [(shape.clone(), 1), (shape, 2), (analytic(), 3), (analytic(), 4)].map(|(shape, seed)| picture(shape, seed));
    let pixels = a.sums.len();
    let sum: f64 = (0..pixels)
        .map(|pixel| {
            let reference = 0.5 * (r.mean(pixel) + s.mean(pixel));
            let product = (a.mean(pixel) - r.mean(pixel)) * (b.mean(pixel) - s.mean(pixel));
            (product / (reference * reference + 0.01)).element_sum() / 3.0
        })
        .sum();
    sum / pixels as f64
}

/// The finer the mesh, the nearer its picture to the sphere's; flat faces of the same mesh are far from it.
#[test]
fn smooth_meshes_look_round() {
    for ior in [1.33, 1.5, 2.4] {
        let [coarse, fine, flat] = [(16, 8, true), (64, 32, true), (64, 32, false)]
            .map(|(segments, rings, smooth)| difference_to_sphere(given(round(1.0, segments, rings)), ior, smooth));
        println!("{ior}: {coarse:.3e} {fine:.3e} flat {flat:.3e}");
        assert!(fine < 2e-4 && fine < 0.1 * coarse && flat > 3.0 * fine, "{ior}: {coarse} {fine} {flat}");
    }
}
