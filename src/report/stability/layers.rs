//! Cases 12 to 16 and 25: plane interfaces, one to a thousand of them.

use glam::DVec3;
use rayon::prelude::*;

use super::closed_forms::{absorbing_slab, prism_deviation, stack_transmittance};
use super::definition::{CaseDefinition, Measured, Subject, case, of_each};
use super::outcome::Measurement;
use super::scenes::{add, downwards, empty, layers, level_lamp, mean, mesh_shape, ready, samples_of};
use crate::geometry::{Mesh, Ray};
use crate::scene::description::{Description, Kind};
use crate::tracking::Mode;
use crate::transport::inspect::{Follow, VertexEvent, trace};

pub(super) const CASES: &[CaseDefinition] = &[
    case(12, "Slab of glass at 0°, 45° and 60°", "T = (1 − R)/(1 + R)", slab).of_images(),
    case(13, "Five media in nine layers, 45°", "T = 1/(1 + Σ R/(1 − R))", five_media).of_images(),
    case(14, "200 interfaces, 45°, no cap on depth", "T = 1/(1 + Σ R/(1 − R))", two_hundred).of_images(),
    case(15, "1000 layers, 1.5 | 1.5001, up to 89°", "a ray leaves parallel layers as it came", thousand),
    case(16, "Absorbing slab of optical depth 1", "geometric series of internal reflections", absorbing).of_images(),
    case(25, "Prism of 60° at minimum deviation", "2 asin(n sin 30°) − 60°", prism),
];

/// Bound for what is not noise in a mean over an image.
const BIAS: f64 = 1e-6;

/// The image's mean in every mode, of a scene made by [`layers`].
fn image_means(subject: &Subject, description: Description, what: &str, expected: f64, samples: u32) -> Measured {
    let scene = ready(description)?;
    subject.in_modes(|mode| {
        let (measured, error) = mean(&subject.render(&scene, mode, (32, 32), samples_of(mode, samples), 1, None)?);
        Ok([Measurement::absolute(what, measured, expected, BIAS).with_noise(error)])
    })
}

fn slab(subject: &Subject) -> Measured {
    of_each([0.0, 45.0, 60.0], |degrees| {
        let description = layers(&[(0.0, -1.0, 1.5, 0.0)], degrees);
        let expected = stack_transmittance(&[1.0, 1.5, 1.0], degrees);
        image_means(subject, description, &format!("T at {degrees}°"), expected, subject.amount(64, 1024))
    })
}

fn five_media(subject: &Subject) -> Measured {
    let boxes: Vec<_> = ([1.31, 1.333, 1.5, 1.7].into_iter().enumerate())
        .map(|(k, ior)| (-(k as f64), -10.0 + k as f64, ior, 0.0))
        .collect();
    let sandwich = [(0.0, -3.0, 1.5, 0.0), (-1.0, -2.0, 1.333, 0.0)];
    let rows = [
        ("T", &boxes[..], &[1.0, 1.31, 1.333, 1.5, 1.7, 1.5, 1.333, 1.31, 1.0][..]),
        ("T of water between glass", &sandwich, &[1.0, 1.5, 1.333, 1.5, 1.0]),
    ];
    of_each(rows, |(what, boxes, indices)| {
        let expected = stack_transmittance(indices, 45.0);
        image_means(subject, layers(boxes, 45.0), what, expected, subject.amount(64, 1024))
    })
}

/// By rendering, which ends long paths by Russian roulette and is noisy for it, and by following paths at random to their ends.
fn two_hundred(subject: &Subject) -> Measured {
    let boxes: Vec<_> = (0..100).map(|k| (f64::from(-2 * k), f64::from(-2 * k - 1), 1.5, 0.0)).collect();
    let indices: Vec<f64> = (0..=200).map(|k| if k % 2 == 0 { 1.0 } else { 1.5 }).collect();
    let expected = stack_transmittance(&indices, 45.0);
    let description = layers(&boxes, 45.0);
    let mut found = image_means(subject, description.clone(), "T, rendered", expected, subject.amount(16, 512))?;
    let scene = ready(description)?;
    let camera = scene.description.camera.position;
    let ray = Ray::new(camera, -camera.normalize());
    found.extend(subject.in_modes(|mode| {
        let count = samples_of(mode, subject.amount(4000, 40_000)) / if mode == Mode::Reference { 2 } else { 1 };
        let goes_through = |seed: &u64| {
            let path = trace(&scene, mode, ray, Follow::Sample, *seed, None);
            path.vertices.last().is_some_and(|v| v.event == VertexEvent::Emit)
        };
        let through = (0..u64::from(count)).into_par_iter().filter(goes_through).count();
        let measured = through as f64 / f64::from(count);
        let noise = (expected * (1.0 - expected) / f64::from(count)).sqrt();
        let what = format!("T, share of {count} paths");
        Ok([Measurement::absolute(what, measured, expected, BIAS).with_noise(noise)])
    })?);
    Ok(found)
}

/// 500 panes of 1.5001 in a world of 1.5: the layers between them count too.
fn thousand(subject: &Subject) -> Measured {
    let boxes: Vec<_> = (0..500).map(|k| (-0.2 * f64::from(k), -0.2 * f64::from(k) - 0.1, 1.5001, 0.0)).collect();
    let mut description = layers(&boxes, 0.0);
    description.world.ior = crate::optics::Ior::Constant(1.5);
    description.objects.clear(Kind::Light);
    let scene = ready(description)?;
    subject.in_modes(|mode| {
        Ok([0.0, 30.0, 60.0, 85.0, 89.0].map(|degrees| {
            let ray = downwards(degrees);
            let path = trace(&scene, mode, ray, Follow::Transmit, 0, None);
            // A chord, not an arc cosine, which knows no angles below 1e-8.
            let turned = if path.vertices.len() == 1000 && path.escaped && path.events.total() == 0 {
                2.0 * ((DVec3::from(path.final_direction) - ray.direction).length() / 2.0).asin()
            } else {
                f64::NAN
            };
            Measurement::absolute(format!("exit against entry at {degrees}°"), turned, 0.0, 2e-4).in_unit("rad")
        }))
    })
}

fn absorbing(subject: &Subject) -> Measured {
    let description = layers(&[(0.0, -1.0, 1.5, 1.0)], 0.0);
    let (transmittance, reflectance) = absorbing_slab(0.04, 1.0);
    let mut from_above = description.clone();
    from_above.objects.clear(Kind::Light);
    from_above.objects.push(level_lamp(1000.0));
    of_each([("T", description, transmittance), ("R", from_above, reflectance)], |(what, description, expected)| {
        image_means(subject, description, what, expected, subject.amount(64, 1024))
    })
}

fn prism(subject: &Subject) -> Measured {
    of_each([(1.0, 1.5), (1.0, 1.333), (1.333, 1.5)], |(world, ior)| {
        let mut description = empty(world);
        // The edge of 60° is at the top, and the ray inside runs level.
        let height = 0.75f64.sqrt();
        let positions = ([-1.0, 1.0].into_iter())
            .flat_map(|z| [[-0.5, 0.0, z], [0.5, 0.0, z], [0.0, height, z]].map(DVec3::from))
            .collect();
        let triangles = vec![[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
        add(&mut description, mesh_shape(Mesh { positions, triangles, ..Mesh::default() }), ior, 0.0);
        let scene = ready(description)?;
        let expected = prism_deviation(world, ior, 60.0);
        let tilt = (expected / 2.0).to_radians();
        let direction = DVec3::new(tilt.cos(), tilt.sin(), 0.0);
        let entry = DVec3::new(-0.25, height / 2.0, 0.1);
        subject.in_modes(|mode| {
            let path = trace(&scene, mode, Ray::new(entry - direction, direction), Follow::Transmit, 0, None);
            let measured = direction.angle_between(DVec3::from(path.final_direction)).to_degrees();
            let what = format!("deviation, {ior} in {world}");
            Ok([Measurement::absolute(what, measured, expected, 1e-4).in_unit("°")])
        })
    })
}
