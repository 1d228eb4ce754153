//! Lights of every kind in whole images, held against closed forms: at a point, in a cone, from afar, with two sides, by their power, and in media.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::common::{ALBEDO, add, floor, mean, nest, ready, render, sphere};
use glam::DVec3;
use iorect::scene::description::{Light, Object, Paint, Quantity, Shape, Solid};
use iorect::scene::needs::SceneNeeds;
use iorect::scene::{MediumId, Scene};
use iorect::tracking::{Mode, Prepared};

/// Of every light along its axis or across it.
const STRENGTH: f64 = 5.0;

fn light(shape: Shape) -> Object {
    let quantity = shape.quantity();
    Object::new("lamp", shape, Light::of(quantity, [STRENGTH; 3]))
}

fn floor_under(light: Object) -> Prepared {
    let mut description = floor();
    description.objects.push(light);
    ready(description)
}

/// What is seen, which is the same in every sample but for their places.
fn seen(scene: &Prepared, mode: Mode) -> f64 {
    let (measured, error) = mean(&render(scene, mode, (2, 2), 4, None));
    assert!(error <= 1e-6 * measured.abs(), "{measured} ± {error}");
    measured
}

fn check_seen(scene: &Prepared, mode: Mode, expected: f64) {
    let measured = seen(scene, mode);
    assert!((measured - expected).abs() <= 1e-6 * expected, "{mode}: {measured} is not {expected}");
}

/// E = I cos θ / d².
#[test]
fn a_point_light_over_a_floor() {
    for position in [DVec3::Y, DVec3::new(1.0, 2.0, -3.0), DVec3::new(9.0, 0.1, 0.0)] {
        let d = position.length();
        let expected = ALBEDO / PI * STRENGTH * (position.y / d) / (d * d);
        let scene = floor_under(light(Shape::Point { position }));
        for mode in Mode::ALL {
            check_seen(&scene, mode, expected);
        }
        // By its power it is the same, and moved by its transform too.
        let mut moved = light(Shape::Point { position: DVec3::ZERO });
        moved.transform.translate = position;
        moved.role = Light::of(Quantity::Power, [4.0 * PI * STRENGTH; 3]).into();
        check_seen(&floor_under(moved), Mode::Rectified, expected);
    }
    // From below, the floor hides it.
    assert_eq!(seen(&floor_under(light(Shape::Point { position: DVec3::NEG_Y })), Mode::Rectified), 0.0);
}

/// The numbers of glTF's falloff for a spot of 20° and 30° at a height of 2, straight down, at some distances from its axis.
#[test]
fn a_spot_over_a_floor() {
    for (rho, expected) in [
        (0.0, 0.25),
        (0.5, 0.228_268_823_563_607_5),
        (0.7, 0.210_213_442_397_776_7),
        (0.8, 0.143_809_403_527_334_3),
        (0.9, 0.073_589_433_331_096),
        (1.0, 0.026_589_967_171_881_6),
        (1.1, 0.003_218_224_135_401_6),
        (1.2, 0.0),
    ] {
        let position = DVec3::new(0.6 * rho, 2.0, 0.8 * rho);
        let spot = Shape::Spot { position, target: position.with_y(0.0), inner_angle: 20.0, outer_angle: 30.0 };
        check_spot(light(spot.clone()), expected);
        // Its power is 0.5332… times its intensity.
        let power = STRENGTH * 0.533_210_697_487_302_7;
        check_spot(Object::new("lamp", spot, Light::of(Quantity::Power, [power; 3])), expected);
    }
}

fn check_spot(light: Object, irradiance: f64) {
    let measured = seen(&floor_under(light), Mode::Rectified);
    let expected = ALBEDO / PI * STRENGTH * irradiance;
    assert!((measured - expected).abs() <= 1e-6 * expected + 1e-12, "{measured} is not {expected}");
}

/// E = E⊥ cos θ, exactly for a sun of no extent, and for any other that is whole above the horizon.
#[test]
fn a_sun_over_a_floor() {
    for degrees in [0.0_f64, 30.0, 60.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let sun = |angle| light(Shape::Directional { direction: DVec3::new(-sin, -cos, 0.0) * 7.0, angle });
        let expected = ALBEDO / PI * STRENGTH * cos;
        check_seen(&floor_under(sun(0.0)), Mode::Rectified, expected);
        for angle in [0.53, 40.0] {
            let scene = floor_under(sun(angle));
            check_mean(&scene, expected);
            if angle > 1.0 {
                // Scattered rays find it too.
                let needs = SceneNeeds { emitters: false, ..scene.scene.needs };
                let scene = Prepared { scene: Arc::new(Scene { needs, ..(*scene.scene).clone() }), ..scene };
                check_mean(&scene, expected);
            }
        }
    }
    let below = Shape::Directional { direction: DVec3::Y, angle: 0.53 };
    assert_eq!(seen(&floor_under(light(below)), Mode::Rectified), 0.0);
}

fn check_mean(scene: &Prepared, expected: f64) {
    let (measured, error) = mean(&render(scene, Mode::Rectified, (32, 32), 64, None));
    assert!((measured - expected).abs() <= 4.0 * error + 1e-9, "{measured} ± {error} is not {expected}");
}

/// The camera sees a sun's disc, of its irradiance over ∫ cos across it, and nothing of what has no extent; with nothing else in the scene, too.
#[test]
fn a_sun_is_seen() {
    for has_floor in [true, false] {
        for (angle, expected) in [(0.0, 0.0), (0.53, STRENGTH / (PI * (0.265_f64.to_radians().sin()).powi(2)))] {
            let mut description = floor();
            description.objects.push(light(Shape::Directional { direction: DVec3::new(-3.0, -4.0, 0.0), angle }));
            description.objects.push(Object::new(
                "spot",
                Shape::Point { position: DVec3::new(3.0, 5.0, 0.0) },
                Light::of(Quantity::Intensity, [1.0; 3]),
            ));
            if !has_floor {
                description.objects.remove(0);
            }
            description.camera.target = DVec3::new(6.0, 8.0, 0.0);
            check_seen(&ready(description), Mode::Rectified, expected);
        }
    }
}

/// Light in water over a floor in it: I cos θ / d² · exp(−σ(d + d′)), in every mode that knows where camera and light are.
#[test]
fn lights_in_water_lose_what_the_water_absorbs() {
    let sigma = 0.3;
    let mut description = floor();
    add(&mut description, Shape::Box { min: DVec3::new(-20.0, -1.0, -20.0), max: DVec3::splat(20.0) }, 1.333, sigma);
    let (position, camera) = (DVec3::new(1.0, 2.0, -3.0), description.camera.position.length());
    description.objects.push(light(Shape::Point { position }));
    let scene = ready(description);
    let d = position.length();
    let expected = ALBEDO / PI * STRENGTH * position.y / d.powi(3) * (-sigma * (d + camera)).exp();
    // There is light that comes back from the water's surfaces as well; not with so few segments.
    for mode in [Mode::Rectified, Mode::Reference] {
        let (measured, error) = mean(&render(&scene, mode, (2, 2), 4, Some(2)));
        assert!((measured / expected - 1.0).abs() < 1e-6, "{mode}: {measured} ± {error} is not {expected}");
    }
    let patch = scene.table.lights.last().unwrap();
    assert_eq!(patch.outside.map(|medium| scene.scene.medium(medium).ior()), Some(1.333));
}

/// A body of the world's own IOR between floor and light, or around the light, changes nothing; an opaque one behind the light neither.
#[test]
fn shadow_rays_go_as_far_as_the_light() {
    let position = DVec3::new(0.0, 3.0, 1.0);
    for shape in [
        Shape::Point { position },
        Shape::Spot { position, target: DVec3::ZERO, inner_angle: 5.0, outer_angle: 20.0 },
        Shape::Directional { direction: -position, angle: 0.0 },
        Shape::Directional { direction: -position, angle: 5.0 },
    ] {
        let image = |extra: &[(Shape, bool)]| {
            let mut description = floor();
            description.objects.push(light(shape.clone()));
            for (number, (shape, is_clear)) in extra.iter().enumerate() {
                match is_clear {
                    true => add(&mut description, shape.clone(), 1.0, 0.0),
                    false => description.objects.push(Object::new(
                        format!("solid {number}"),
                        shape.clone(),
                        Solid::of(Paint::Color([0.0; 3])),
                    )),
                }
            }
            mean(&render(&ready(description), Mode::Rectified, (4, 4), 16, None)).0
        };
        let plain = image(&[]);
        assert!(plain > 0.0);
        let near = |other: f64| (other / plain - 1.0).abs() < 1e-9;
        assert!(near(image(&[(sphere(position * 0.5, 0.3), true)])), "{shape:?}: between");
        assert!(near(image(&[(sphere(position, 0.3), true)])), "{shape:?}: around");
        let is_from_afar = matches!(shape, Shape::Directional { .. });
        let behind = image(&[(sphere(position * 1.2, 0.3), false)]);
        assert!(if is_from_afar { behind == 0.0 } else { near(behind) }, "{shape:?}: behind");
        let both = image(&[(sphere(position * 1.2, 0.3), false), (sphere(position * 0.5, 0.3), true)]);
        assert!(if is_from_afar { both == 0.0 } else { near(both) }, "{shape:?}: behind and between");
        assert_eq!(image(&[(sphere(position * 0.5, 0.3), false)]), 0.0, "{shape:?}: in the way");
    }
}

/// The back of a quad with two sides is as bright as its front; its power is then twice that of one side. A closed body with two sides, whose
/// inside nobody sees, is as it is with one.
#[test]
fn lights_with_two_sides() {
    let image = |shape: Shape, quantity: Quantity, strength: f64, two_sided: bool| {
        let light = Light { two_sided, ..Light::of(quantity, [strength; 3]) };
        mean(&render(&floor_under(Object::new("lamp", shape, light)), Mode::Rectified, (16, 16), 64, None)).0
    };
    let quad = |flip: f64| Shape::Quad { center: DVec3::Y, edge_u: DVec3::X * 0.5, edge_v: DVec3::Z * flip };
    // edge_u × edge_v of the first points down.
    let (down, up) = (quad(1.0), quad(-1.0));
    let front = image(down.clone(), Quantity::Radiance, STRENGTH, false);
    assert!(front > 0.0 && image(up.clone(), Quantity::Radiance, STRENGTH, false) == 0.0);
    let near = |other: f64| assert!((other / front - 1.0).abs() < 0.02, "{other} is not {front}");
    near(image(up.clone(), Quantity::Radiance, STRENGTH, true));
    near(image(down.clone(), Quantity::Power, PI * 0.5 * STRENGTH, false));
    near(image(up, Quantity::Power, PI * STRENGTH, true));
    near(image(down, Quantity::Power, PI * STRENGTH, true));
    for body in [
        sphere(DVec3::Y * 2.0, 0.5),
        Shape::Box { min: DVec3::new(-0.5, 1.0, -0.5), max: DVec3::new(0.5, 1.5, 0.5) },
        // Its parts hide each other.
        Shape::Torus { center: DVec3::Y * 2.0, major: 0.5, minor: 0.2, segments: 16, rings: 8 },
    ] {
        let [one, two] = [false, true].map(|two_sided| image(body.clone(), Quantity::Radiance, STRENGTH, two_sided));
        assert!((two / one - 1.0).abs() < 0.03, "{body:?}: {one} {two}");
    }
}

/// Parts of a light that hide each other are counted once: with light sampling as without.
#[test]
fn a_light_that_hides_parts_of_itself() {
    let torus = Shape::Torus { center: DVec3::Y * 1.5, major: 0.8, minor: 0.3, segments: 24, rings: 12 };
    let scene = floor_under({
        let mut torus = light(torus);
        torus.transform.rotate.x = 90.0;
        torus
    });
    let needs = SceneNeeds { emitters: false, ..scene.scene.needs };
    let blind = Prepared { scene: Arc::new(Scene { needs, ..(*scene.scene).clone() }), ..scene.clone() };
    let [(sampled, error), (found, other)] =
        [(&scene, 64), (&blind, 512)].map(|(scene, spp)| mean(&render(scene, Mode::Rectified, (32, 32), spp, None)));
    let sigma = error.hypot(other);
    assert!((sampled - found).abs() < 4.0 * sigma && sigma < 0.01 * found, "{sampled} {found} ± {sigma}");
}

/// Each light is told the medium that it stands in, and one on a surface that there are several.
#[test]
fn the_medium_of_a_light_is_found() {
    let mut description = nest(1.0, &[(2.0, 1.333), (1.0, 1.5)]);
    for (name, x) in [("in glass", 0.5), ("in water", 1.5), ("outside", 3.0), ("on the glass", 1.0)] {
        let shape = Shape::Point { position: DVec3::X * x };
        description.objects.push(Object::new(name, shape, Light::of(Quantity::Power, [1.0; 3])));
    }
    let spot = Shape::Spot { position: DVec3::Y, target: DVec3::ZERO, inner_angle: 1.0, outer_angle: 2.0 };
    let mut spot = Object::new("spot", spot, Light::of(Quantity::Intensity, [1.0; 3]));
    spot.transform.translate = DVec3::Y * 0.7;
    description.objects.push(spot);
    let sun = Shape::Directional { direction: DVec3::X, angle: 0.53 };
    description.objects.push(Object::new("sun", sun, Light::of(Quantity::Irradiance, [1.0; 3])));
    let scene = ready(description);
    let ior = |medium: MediumId| scene.scene.medium(medium).ior();
    let found: Vec<(&str, Option<f64>)> = (scene.table.lights.iter())
        .map(|patch| (scene.scene.object(patch.refractor).name.as_str(), patch.outside.map(ior)))
        .collect();
    let expected = [
        ("in glass", Some(1.5)),
        ("in water", Some(1.333)),
        ("outside", Some(1.0)),
        ("on the glass", None),
        ("spot", Some(1.333)),
        ("sun", Some(1.0)),
    ];
    assert_eq!(found, expected);
    for patch in &scene.table.lights {
        assert_eq!(scene.table.place_of(patch.refractor), Some(patch));
    }
}
