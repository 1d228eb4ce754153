//! The medium that camera rays start in, against closed forms: from a point exactly on a face, an edge or a vertex, through a lens that
//! straddles, touches or surrounds a surface.

use crate::common::{add, empty, ready, render, sphere};
use glam::{DVec2, DVec3};
use iorect::geometry::{Ray, uniform_direction};
use iorect::rectify::containment::medium_at;
use iorect::rectify::start::{StartRegion, start};
use iorect::scene::description::{Description, Shape, Transform};
use iorect::tracking::Mode;
use iorect::tracking::Prepared;
use iorect::transport::inspect::{Follow, trace};

/// Evenly spread directions, none along an axis.
fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |k| {
        let turn = (f64::from(k) * 0.618_033_988_749_894_9).fract();
        uniform_direction([(f64::from(k) + 0.31) / f64::from(count), turn])
    })
}

/// Points of the unit disc.
fn disc(count: u32) -> impl Iterator<Item = DVec2> {
    (0..count).map(move |k| {
        DVec2::from_angle(2.399_963_229_728_653 * f64::from(k)) * ((f64::from(k) + 0.5) / f64::from(count)).sqrt()
    })
}

/// Of a ray in scene coordinates.
fn name_at_start(prepared: &Prepared, ray: Ray) -> &str {
    let started = start(&prepared.scene, Ray::new(ray.origin - prepared.scene.geometry.origin, ray.direction));
    assert!(!started.is_ambiguous);
    &prepared.scene.medium(started.medium).name
}

fn water(min: DVec3, max: DVec3) -> Description {
    let mut description = empty(1.0);
    add(&mut description, Shape::Box { min, max }, 1.333, 0.2);
    description
}

fn turned(mut description: Description, rotate: DVec3, translate: DVec3) -> (Description, Transform) {
    let transform = Transform { scale: DVec3::ONE, rotate, translate };
    description.objects.refractors_mut()[0].transform = transform;
    (description, transform)
}

/// At heights that f32 vertices hold exactly and at others, turned and moved: rays start in the medium that they go to.
#[test]
fn a_pinhole_on_the_face_of_the_water() {
    let mut wrong_if_asked_as_a_point = 0;
    for (height, rotate, translate) in [
        (0.0, DVec3::ZERO, DVec3::ZERO),
        (0.35, DVec3::ZERO, DVec3::ZERO),
        (0.1, DVec3::new(20.0, -70.0, 130.0), DVec3::new(0.3, -7.7, 1.1)),
        (0.1, DVec3::new(33.0, 12.0, 5.0), DVec3::new(1234.5, 0.7, -987.6)),
    ] {
        let (description, transform) =
            turned(water(DVec3::new(-2.0, -3.0, -1.5), DVec3::new(2.0, height, 1.5)), rotate, translate);
        let prepared = ready(description);
        let matrix = transform.matrix();
        for (x, z) in [(0.4, 0.3), (-1.3, 0.77), (1.99, -1.49)] {
            let eye = matrix.transform_point3(DVec3::new(x, height, z)) - prepared.scene.geometry.origin;
            for direction in directions(250) {
                let side = direction.dot(matrix.transform_vector3(DVec3::Y));
                // Level rays stay within rounding.
                if side.abs() < 1e-3 {
                    continue;
                }
                let expected = if side < 0.0 { "object 0" } else { "world" };
                let ray = Ray::new(eye + prepared.scene.geometry.origin, direction);
                assert_eq!(name_at_start(&prepared, ray), expected, "at {eye} along {direction}");
                wrong_if_asked_as_a_point +=
                    u32::from(prepared.scene.medium(medium_at(&prepared.scene, eye).0).name != expected);
                let path = trace(
                    &prepared,
                    Mode::Reference,
                    Ray::new(eye + prepared.scene.geometry.origin, direction),
                    Follow::Transmit,
                    0,
                    // Totally reflected on all sides, some are trapped for ever.
                    Some(64),
                );
                assert_eq!((path.camera_medium.as_str(), path.events.total()), (expected, 0));
                // Upwards nothing is in the way; downwards the first thing met is the far side.
                assert_eq!(path.vertices.is_empty(), side > 0.0);
            }
        }
    }
    assert!(wrong_if_asked_as_a_point > 1000, "a point on a face has no one medium: {wrong_if_asked_as_a_point}");
}

/// On the diagonal between the two triangles of a face, on an edge and on a vertex of a box: inside are the rays that go there.
#[test]
fn a_pinhole_on_edges_and_vertices() {
    let (min, max) = (DVec3::new(-1.1, -0.7, -1.3), DVec3::new(0.9, 0.35, 0.6));
    for rotate in [DVec3::ZERO, DVec3::new(31.0, -17.0, 64.0)] {
        let (description, transform) = turned(water(min, max), rotate, DVec3::ZERO);
        let scene = ready(description);
        let matrix = transform.matrix();
        let middle = (min + max) / 2.0;
        for eye in [middle.with_y(max.y), max.with_z(0.123), max.with_y(0.1), max] {
            for direction in directions(500) {
                // A step that leaves the box through every face that the eye is on, or through none.
                let ahead = eye + direction * 1e-3;
                if ((ahead - max).abs().min_element() < 2e-5) || ((ahead - min).abs().min_element() < 2e-5) {
                    continue;
                }
                let is_inside = ahead.cmplt(max).all() && ahead.cmpgt(min).all();
                let ray = Ray::new(matrix.transform_point3(eye), matrix.transform_vector3(direction));
                assert_eq!(
                    name_at_start(&scene, ray),
                    if is_inside { "object 0" } else { "world" },
                    "{eye} {direction}"
                );
            }
        }
    }
}

#[test]
fn a_pinhole_on_a_sphere() {
    let mut description = empty(1.2);
    let center = DVec3::new(0.3, -0.2, 0.7);
    add(&mut description, sphere(DVec3::ZERO, 3.0), 1.4, 0.0);
    add(&mut description, sphere(center, 0.77), 1.5, 0.0);
    let scene = ready(description);
    for normal in directions(20) {
        let eye = center + normal * 0.77;
        for direction in directions(100).filter(|d| d.dot(normal).abs() > 1e-3) {
            let expected = if direction.dot(normal) < 0.0 { "object 1" } else { "object 0" };
            assert_eq!(name_at_start(&scene, Ray::new(eye, direction)), expected);
            // Paths along the inside of a sphere are trapped for ever.
            let path = trace(&scene, Mode::Reference, Ray::new(eye, direction), Follow::Transmit, 0, Some(8));
            assert_eq!(path.events.total(), 0);
        }
    }
}

/// Oil that stands on water: the eye is on the top of one and the bottom of the other.
#[test]
fn a_pinhole_between_two_boxes_that_touch() {
    let mut description = water(DVec3::new(-2.0, -2.0, -2.0), DVec3::new(2.0, 0.35, 2.0));
    add(&mut description, Shape::Box { min: DVec3::new(-2.0, 0.35, -2.0), max: DVec3::splat(2.0) }, 1.47, 0.0);
    let scene = ready(description);
    for direction in directions(500).filter(|d| d.y.abs() > 1e-3) {
        let ray = Ray::new(DVec3::new(0.3, 0.35, 0.4), direction);
        assert_eq!(name_at_start(&scene, ray), if direction.y < 0.0 { "object 0" } else { "object 1" });
    }
}

/// Only a camera on the face itself is decided by the ray: a little above or below it, the height alone counts.
#[test]
fn next_to_the_face_the_height_decides() {
    let scene = ready(water(DVec3::new(-2.0, -2.0, -2.0), DVec3::new(2.0, 0.35, 2.0)));
    for exponent in 2..7 {
        let step = 10f64.powi(-exponent);
        for direction in directions(100) {
            let name_at = |y: f64| name_at_start(&scene, Ray::new(DVec3::new(0.3, y, 0.4), direction));
            assert_eq!((name_at(0.35 + step), name_at(0.35 - step)), ("world", "object 0"), "{step}");
        }
    }
}

/// Sets every point of a lens against `expected`, a closed form, and returns how many start in the refractor.
fn check_lens(prepared: &Prepared, center: DVec3, radius: f64, expected: impl Fn(DVec3) -> bool) -> u32 {
    // Tilted, looking along −z and a little down.
    let (right, up) = (DVec3::X, DVec3::new(0.0, 0.98, -0.199).normalize());
    let to_local = -prepared.scene.geometry.origin;
    let ask = |point| medium_at(&prepared.scene, point);
    let lens = StartRegion::by_asking(&prepared.scene, center + to_local, radius, &ask);
    let mut inside = 0;
    for (point, direction) in disc(4000).zip(directions(4000)) {
        let origin = center + (right * point.x + up * point.y) * radius;
        let started = lens.start_by_asking(&prepared.scene, Ray::new(origin + to_local, direction), &ask);
        assert!(!started.is_ambiguous);
        assert_eq!(prepared.scene.medium(started.medium).name == "object 0", expected(origin), "at {origin}");
        inside += u32::from(expected(origin));
    }
    inside
}

#[test]
fn every_point_of_a_lens_knows_its_medium() {
    let pool = ready(water(DVec3::new(-5.0, -5.0, -5.0), DVec3::new(5.0, 0.35, 5.0)));
    // Half in, a sliver in, wholly in, wholly out.
    for (y, inside) in [(0.35, 1950..2050), (0.35 + 0.0975, 1..30), (0.2, 4000..4001), (0.5, 0..1)] {
        let count = check_lens(&pool, DVec3::new(0.1, y, 0.2), 0.1, |p| p.y < 0.35);
        assert!(inside.contains(&count), "{count}");
    }
    // A drop that touches the lens from outside, one that pokes through a place between the middle and the rim, and one that holds it.
    let drop = |center: DVec3, radius: f64| {
        let mut description = empty(1.0);
        add(&mut description, sphere(center, radius), 1.333, 0.2);
        let scene = ready(description);
        check_lens(&scene, DVec3::ZERO, 0.1, |p| p.distance(center) < radius)
    };
    assert_eq!(drop(DVec3::X * 0.15, 0.05), 0);
    assert!((1..100).contains(&drop(DVec3::new(0.04, 0.02, 0.0), 0.012)));
    assert_eq!(drop(DVec3::new(0.01, 0.02, 0.3), 1.0), 4000);
}

/// A whole image from a lens half in the water, and one from a pinhole on its face: no path may be counted as inconsistent.
#[test]
fn images_from_the_waterline_are_consistent() {
    for radius in [0.0, 0.1] {
        let mut description = water(DVec3::new(-5.0, -5.0, -5.0), DVec3::new(5.0, 0.35, 5.0));
        description.camera.position = DVec3::new(0.0, 0.35, 0.0);
        description.camera.target = DVec3::new(0.4, 0.3, -1.0);
        description.camera.vertical_fov = 80.0;
        description.camera.aperture_radius = radius;
        let scene = ready(description);
        for mode in [Mode::Rectified, Mode::Reference] {
            assert_eq!(render(&scene, mode, (24, 24), 8, None).events.total(), 0, "{mode}, lens {radius}");
        }
    }
}
