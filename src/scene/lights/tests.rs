//! What holds for every light: directions and rays are sampled with the density that is told, and rays carry the light's power.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::geometry::{Frame, Mesh, Part, Ray, uniform_direction};
use crate::scene::description::Environment;
use crate::scene::environment::EnvironmentImage;

const RADIANCE: [f64; 3] = [2.0, 3.0, 5.0];

/// A ball of radius 0.5 about (0, 2, 0), and a triangle of area 1 below y = −2 that looks up.
fn geometry() -> Geometry {
    let corners = [DVec3::new(0.0, -2.0, 0.0), DVec3::new(0.0, -2.0, 2.0), DVec3::new(1.0, -2.0, 0.0)];
    let parts = vec![
        Part::Sphere { center: DVec3::new(0.0, 2.0, 0.0), radius: 0.5 },
        Part::Mesh {
            mesh: Mesh {
                positions: corners.to_vec(),
                normals: Vec::new(),
                triangles: vec![[0, 1, 2]],
                uvs: Vec::new(),
            },
            smooth: false,
        },
    ];
    Geometry::build_in(Frame::default(), parts, None)
}

fn area_lights(geometry: &Geometry) -> [AreaLight; 2] {
    [0, 1].map(|object| AreaLight {
        object: ObjectId(object),
        radiance: Spectrum::from_rgb(RADIANCE),
        area: geometry.area(object),
        two_sided: false,
    })
}

fn environments() -> Vec<EnvironmentLight> {
    let pixels = (0..128).map(|i| if i == 37 { [90.0, 80.0, 70.0] } else { [0.2 + 0.1 * (i % 7) as f32; 3] }).collect();
    let image = Arc::new(EnvironmentImage { width: 16, height: 8, pixels, notes: Vec::new() });
    [
        Environment::Color(RADIANCE),
        Environment::Gradient { zenith: [1.0, 2.0, 3.0], horizon: [0.5; 3], nadir: [0.1, 0.0, 0.2] },
        Environment::Image { path: "e.hdr".into(), image, rotation: 30.0, scale: 1.5 },
    ]
    .iter()
    .map(EnvironmentLight::new)
    .collect()
}

/// Where lights at a point stand.
const PLACE: DVec3 = DVec3::new(0.5, 0.25, -1.0);

/// Two lights at a point, and two from afar.
fn bodiless() -> [Emitter; 4] {
    let rgb = Spectrum::from_rgb(RADIANCE);
    let axis = DVec3::new(0.6, -0.8, 0.0);
    [
        Emitter::Point(PointLight { object: ObjectId(2), position: PLACE, intensity: rgb }),
        Emitter::Spot(SpotLight::new(ObjectId(3), PLACE, axis, rgb, [20.0, 50.0])),
        Emitter::Directional(DirectionalLight::new(ObjectId(4), -axis, rgb, 0.0)),
        Emitter::Directional(DirectionalLight::new(ObjectId(5), -axis, rgb, 40.0)),
    ]
}

/// Numbers that look random, in [0, 1)⁵.
fn numbers(index: u32) -> ([f64; 3], [f64; 2]) {
    let at = |step: f64| (f64::from(index) * step + 0.5).fract();
    ([at(0.883_2), at(0.796_712_3), at(0.718_735_1)], [at(0.648_283_9), at(0.584_823_7)])
}

#[test]
fn directions_are_sampled_with_the_density_that_is_told() {
    let geometry = geometry();
    let from = DVec3::new(0.3, 0.1, 0.2);
    for light in &area_lights(&geometry) {
        let light = Light::Area(light);
        let (mut solid_angle, mut missed) = (0.0, 0);
        let count = 20_000;
        for index in 0..count {
            let sample = light.sample_direct(&geometry, from, numbers(index).0).unwrap();
            solid_angle += 1.0 / sample.pdf / f64::from(count);
            // Along the rim rounding may see past it.
            let Some(hit) = geometry.closest(&Ray::new(from, sample.direction)) else {
                missed += 1;
                continue;
            };
            let point = geometry.surface(&Ray::new(from, sample.direction), &hit);
            let object = ObjectId(geometry.object_of(hit.primitive));
            assert_eq!(sample.target, Target::Surface { object, primitive: hit.primitive });
            let told = light.pdf_direct(&geometry, from, sample.direction, Some(&point));
            assert!((sample.pdf / told - 1.0).abs() < 1e-9, "{} {told}", sample.pdf);
        }
        assert!(missed < 20, "{missed}");
        // The same by asking in all directions.
        let seen = (0..400_000_u32).map(|i| uniform_direction(numbers(i).1)).filter(|direction| {
            let Light::Area(light) = light else { return false };
            let hit = geometry.closest(&Ray::new(from, *direction));
            hit.is_some_and(|hit| hit.is_front && geometry.object_of(hit.primitive) == light.object.0)
        });
        let expected = seen.count() as f64 / 400_000.0 * 4.0 * PI;
        assert!((solid_angle / expected - 1.0).abs() < 0.02, "{solid_angle} {expected}");
    }
}

/// ∫ radiance · cosine over starts and directions is π · radiance · area of an object, and of the environment ∫ radiance over all directions
/// times the disc's area.
#[test]
fn rays_carry_the_power_of_their_light() {
    let geometry = geometry();
    let bounds = geometry.bounding_sphere().unwrap();
    let power = |light: &Light<'_>| -> f64 {
        let count = 200_000;
        (0..count)
            .map(|index| {
                let (start, direction) = numbers(index);
                let emitted = light.sample_ray(&geometry, start, direction).unwrap();
                let normal = emitted.start.map_or(DVec3::ZERO, |point| point.normal);
                let mut told = light.pdf_ray(&geometry, normal, emitted.ray.direction);
                if light.is_delta_direction() {
                    assert_eq!((told[1], emitted.pdf_direction), (0.0, 1.0));
                    told[1] = 1.0;
                }
                assert_eq!(light.emitted(emitted.ray.direction), emitted.radiance);
                assert_eq!(emitted.light, light.object());
                assert!((emitted.pdf_position / told[0] - 1.0).abs() < 1e-9);
                assert!((emitted.pdf_direction / told[1] - 1.0).abs() < 1e-6, "{emitted:?} {told:?}");
                assert!((emitted.ray.direction.length() - 1.0).abs() < 1e-12 && emitted.cosine > 0.0);
                match emitted.start {
                    Some(point) => assert_eq!(emitted.ray.origin, point.position),
                    None if light.is_delta_position() => assert_eq!(emitted.ray.origin, PLACE),
                    // From outside of the scene, towards it.
                    None => {
                        let to_center = bounds.center - emitted.ray.origin;
                        let along = to_center.dot(emitted.ray.direction);
                        assert!(along >= 0.999 * bounds.radius);
                        let aside = (to_center - emitted.ray.direction * along).length();
                        assert!(aside <= 1.000_001 * bounds.radius);
                    }
                }
                emitted.radiance.sum() * emitted.cosine / (emitted.pdf_position * emitted.pdf_direction)
            })
            .sum::<f64>()
            / f64::from(count)
    };
    let two_sided = area_lights(&geometry).map(|light| AreaLight { two_sided: true, ..light });
    for light in area_lights(&geometry).iter().chain(&two_sided) {
        let sides = if light.two_sided { 2.0 } else { 1.0 };
        let expected = PI * light.area * RADIANCE.iter().sum::<f64>() * sides;
        assert!((light.power() / expected - 1.0).abs() < 1e-12);
        let measured = power(&Light::Area(light));
        assert!((measured / expected - 1.0).abs() < 2e-3, "{measured} {expected}");
    }
    for light in &environments() {
        let count = 400_000;
        let over_directions: f64 = (0..count)
            .map(|index| light.radiance(uniform_direction(numbers(index).1)).sum() * 4.0 * PI / f64::from(count))
            .sum();
        let (light, expected) = (Light::Environment(light), over_directions * PI * bounds.radius.powi(2));
        let (measured, told) = (power(&light), light.power(&geometry));
        assert!((measured / expected - 1.0).abs() < 1e-2, "{light:?}: {measured} {expected}");
        assert!((told / expected - 1.0).abs() < 2e-2, "{light:?}: {told} {expected}");
    }
    for emitter in bodiless() {
        let light = emitter.light();
        let (measured, told) = (power(&light), light.power(&geometry));
        assert!((measured / told - 1.0).abs() < 2e-3, "{light:?}: {measured} {told}");
    }
}

#[test]
fn emitters_are_chosen_by_their_power() {
    let geometry = geometry();
    let of_surfaces = area_lights(&geometry).map(Emitter::Area);
    let emitters = Emitters::new(&geometry, of_surfaces.into_iter().chain(bodiless()));
    let powers: Vec<f64> = emitters.iter().map(|(light, _)| light.power(&geometry)).collect();
    let total = powers.iter().sum::<f64>();
    assert_eq!(emitters.len(), 6);
    for (index, (light, probability)) in emitters.iter().enumerate() {
        assert!((probability - powers[index] / total).abs() < 1e-12);
        assert_eq!(emitters.find(light.object().unwrap()).unwrap().1, probability);
        let is_chosen = |i: &i32| emitters.choose(f64::from(*i) / 10_000.0).unwrap().0.object() == light.object();
        let chosen = (0..10_000).filter(is_chosen).count();
        assert!((chosen as f64 / 10_000.0 - powers[index] / total).abs() < 2e-4);
    }
    // Of no power is no light.
    let black = PointLight { object: ObjectId(7), position: DVec3::ZERO, intensity: Spectrum::ZERO };
    assert!(Emitters::new(&geometry, [Emitter::Point(black)]).is_empty());
}

/// With I along the axis, I · cos / d² falls on a surface; in the edge of a spot less by the square of the share of the cosines.
#[test]
fn lights_at_a_point_fall_off_with_the_square_of_the_distance() {
    let geometry = geometry();
    let [point, spot, ..] = bodiless();
    let along = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        // Turned by that angle about z.
        DVec3::new(0.6 * cos + 0.8 * sin, -0.8 * cos + 0.6 * sin, 0.0)
    };
    let [cos_inner, cos_outer] = [20.0_f64, 50.0].map(|angle| angle.to_radians().cos());
    for (degrees, falloff) in [
        (0.0, 1.0),
        (19.99, 1.0),
        (35.0, ((35_f64.to_radians().cos() - cos_outer) / (cos_inner - cos_outer)).powi(2)),
        (50.01, 0.0),
        (180.0, 0.0),
    ] {
        for distance in [1e-3, 0.7, 40.0] {
            let from = PLACE + along(degrees) * distance;
            for (light, factor) in [(&point, 1.0), (&spot, falloff)] {
                let sample = light.light().sample_direct(&geometry, from, [0.5; 3]);
                let Some(sample) = sample else {
                    assert_eq!(factor, 0.0, "{light:?} at {degrees}");
                    continue;
                };
                let expected = RADIANCE.map(|x| x * factor / (distance * distance));
                let error = (DVec3::from(sample.radiance.to_rgb()) / DVec3::from(expected) - 1.0).abs().max_element();
                assert!(error < 1e-9, "{light:?} at {degrees}: {error}");
                assert_eq!((sample.pdf, sample.is_delta), (1.0, true));
                assert!((sample.direction + along(degrees)).length() < 1e-9);
                let Target::Point { distance: told } = sample.target else { panic!("{:?}", sample.target) };
                assert!((told / distance - 1.0).abs() < 1e-9);
            }
        }
    }
    assert!(point.light().sample_direct(&geometry, PLACE, [0.5; 3]).is_none());
}

/// Of every spot, and also of one with a sharp edge, and of one that shines all around.
#[test]
fn a_spots_density_integrates_to_one_and_its_power_is_the_integral_of_its_intensity() {
    for [inner, outer] in [[0.0, 30.0], [20.0, 50.0], [40.0, 40.0], [0.0, 180.0], [180.0, 180.0], [1.0, 3.0]] {
        let spot = SpotLight::new(ObjectId(0), PLACE, DVec3::Y, Spectrum::from_rgb(RADIANCE), [inner, outer]);
        let count = 100_000;
        let outer_cos = outer.to_radians().cos();
        let solid_angle = 2.0 * PI * (1.0 - outer_cos);
        let mean = |value: &dyn Fn(DVec3) -> f64| -> f64 {
            let each = (0..count).map(|i| {
                // A little beyond the edge counts for nothing.
                let cos = 1.0 - (1.0 - outer_cos) * (f64::from(i) + 0.5) / f64::from(count);
                let sin = (1.0 - cos * cos).sqrt();
                value(DVec3::new(sin * 0.6, cos, sin * 0.8))
            });
            each.sum::<f64>() / f64::from(count) * solid_angle
        };
        let integral = mean(&|direction| spot.pdf_ray(direction));
        assert!((integral - 1.0).abs() < 1e-4, "{inner} {outer}: {integral}");
        let power = mean(&|direction| spot.falloff(direction)) * RADIANCE.iter().sum::<f64>();
        assert!((power / spot.power() - 1.0).abs() < 1e-4, "{inner} {outer}: {power} {}", spot.power());
    }
}

/// A sun's irradiance across its direction is what was given, whatever its angle, by radiance seen and by sampling alike.
#[test]
fn a_suns_irradiance_is_what_was_given() {
    let axis = DVec3::new(0.48, 0.64, -0.6);
    let geometry = geometry();
    for angle in [0.0, 0.001, 0.53, 10.0, 180.0] {
        let sun = DirectionalLight::new(ObjectId(0), axis, Spectrum::from_rgb(RADIANCE), angle);
        let light = Light::Directional(&sun);
        let count = 20_000;
        let (mut irradiance, mut solid_angle) = (Spectrum::ZERO, 0.0);
        for i in 0..count {
            let sample = light.sample_direct(&geometry, PLACE, numbers(i).0).unwrap();
            let cosine = sample.direction.dot(axis);
            irradiance += sample.radiance * (cosine / sample.pdf / f64::from(count));
            solid_angle += 1.0 / sample.pdf / f64::from(count);
            assert_eq!(sample.target, Target::Environment);
            assert_eq!(sample.is_delta, angle == 0.0);
            let seen = if angle == 0.0 { Spectrum::ZERO } else { sample.radiance };
            assert_eq!(light.radiance(sample.direction), seen);
            let told = light.pdf_direct(&geometry, PLACE, sample.direction, None);
            assert!(if angle == 0.0 { told == 0.0 } else { (told / sample.pdf - 1.0).abs() < 1e-12 });
        }
        let error = (DVec3::from(irradiance.to_rgb()) / DVec3::from(RADIANCE) - 1.0).abs().max_element();
        assert!(error < 2e-3, "{angle}: {irradiance:?}");
        let half = (0.5 * angle).to_radians();
        let expected = if angle == 0.0 { 1.0 } else { 4.0 * PI * (0.5 * half).sin().powi(2) };
        assert!((solid_angle / expected - 1.0).abs() < 1e-9, "{angle}: {solid_angle}");
        // Just beyond the rim there is nothing.
        let across = DVec3::new(0.8, -0.6, 0.0);
        let rim = |share: f64| (axis * (share * half).cos() + across * (share * half).sin()).normalize();
        assert_eq!(light.radiance(rim(0.99)).is_black(), angle == 0.0);
        assert!(light.radiance(rim(1.01)).is_black());
    }
}

/// Both sides of a triangle are seen as bright, by sampling and by asking.
#[test]
fn a_light_with_two_sides_is_sampled_from_both() {
    let geometry = geometry();
    let [_, triangle] = area_lights(&geometry);
    let both = AreaLight { two_sided: true, ..triangle };
    for (from, is_front) in [(DVec3::new(0.3, 0.1, 0.2), true), (DVec3::new(0.3, -4.1, 0.2), false)] {
        for index in 0..1000 {
            let sample = both.sample_direct(&geometry, from, numbers(index).0).unwrap();
            let ray = Ray::new(from, sample.direction);
            let Some(hit) = geometry.closest(&ray) else { continue };
            assert_eq!(hit.is_front, is_front);
            let told = both.pdf_direct(&geometry, from, sample.direction, &geometry.surface(&ray, &hit));
            assert!((sample.pdf / told - 1.0).abs() < 1e-9);
            assert_eq!(triangle.sample_direct(&geometry, from, numbers(index).0).is_some(), is_front);
        }
    }
    let up = (0..1000).filter(|&i| {
        let (start, direction) = numbers(i);
        let emitted = both.sample_ray(&geometry, start, direction).unwrap();
        assert_eq!(emitted.is_front, emitted.ray.direction.y > 0.0);
        emitted.is_front
    });
    assert!((up.count() as f64 / 1000.0 - 0.5).abs() < 0.02);
}
