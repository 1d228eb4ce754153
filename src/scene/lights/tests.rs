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
            mesh: Mesh { positions: corners.to_vec(), normals: Vec::new(), triangles: vec![[0, 1, 2]] },
            smooth: false,
        },
    ];
    Geometry::build_in(Frame::default(), parts)
}

fn area_lights(geometry: &Geometry) -> [AreaLight; 2] {
    [0, 1].map(|object| AreaLight {
        object: ObjectId(object),
        radiance: Spectrum::from_rgb(RADIANCE),
        area: geometry.area(object),
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
            assert_eq!(sample.target, Target::Object(ObjectId(geometry.object_of(hit.primitive))));
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
                let told = light.pdf_ray(&geometry, normal, emitted.ray.direction);
                assert!((emitted.pdf_position / told[0] - 1.0).abs() < 1e-9);
                assert!((emitted.pdf_direction / told[1] - 1.0).abs() < 1e-6, "{emitted:?} {told:?}");
                assert!((emitted.ray.direction.length() - 1.0).abs() < 1e-12 && emitted.cosine > 0.0);
                match emitted.start {
                    Some(point) => assert_eq!(emitted.ray.origin, point.position),
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
    for light in &area_lights(&geometry) {
        let (measured, expected) = (power(&Light::Area(light)), light.power());
        assert!((measured / expected - 1.0).abs() < 2e-3, "{measured} {expected}");
    }
    for light in &environments() {
        let count = 400_000;
        let over_directions: f64 = (0..count)
            .map(|index| light.radiance(uniform_direction(numbers(index).1)).sum() * 4.0 * PI / f64::from(count))
            .sum();
        let (measured, expected) = (power(&Light::Environment(light)), over_directions * PI * bounds.radius.powi(2));
        assert!((measured / expected - 1.0).abs() < 1e-2, "{light:?}: {measured} {expected}");
    }
}

#[test]
fn emitters_are_chosen_by_their_power() {
    let geometry = geometry();
    let emitters = Emitters::new(
        &geometry,
        [(ObjectId(0), Spectrum::from_rgb([1.0; 3])), (ObjectId(1), Spectrum::from_rgb([9.0; 3]))],
    );
    let powers: Vec<f64> = emitters.iter().map(|(light, _)| light.power()).collect();
    for (index, (light, probability)) in emitters.iter().enumerate() {
        assert!((probability - powers[index] / powers.iter().sum::<f64>()).abs() < 1e-12);
        assert_eq!(emitters.find(light.object).unwrap().1, probability);
    }
    let chosen = (0..10_000).filter(|&i| emitters.choose(f64::from(i) / 10_000.0).unwrap().0.object == ObjectId(0));
    let expected = powers[0] / (powers[0] + powers[1]);
    assert!((chosen.count() as f64 / 10_000.0 - expected).abs() < 2e-4);
}
