//! Cases beyond the forty.

use glam::DVec3;
use rayon::prelude::*;

use super::closed_forms::{absorbing_ball, lateral_shift, shares_of_ball};
use super::definition::{CaseDefinition, Measured, Subject, of_each};
use super::outcome::Measurement;
use super::scenes::{Numbers, add, downwards, empty, layers, mean, nest, onto_disc, ready, samples_of, sphere};
use crate::geometry::Ray;
use crate::scene::description::Kind;
use crate::transport::inspect::{Follow, Vertex, VertexEvent, trace};

const fn case(name: &'static str, source: &'static str, measure: fn(&Subject) -> Measured) -> CaseDefinition {
    CaseDefinition { number: None, name, source, measure, is_of_images: false }
}

pub(super) const CASES: &[CaseDefinition] = &[
    case(
        "Paths through an eccentric nest, run backwards",
        "reversibility: the same interfaces in the opposite order, R and direction alike",
        reversed,
    ),
    case("Light that leaves a ball of glass after p internal reflections", "mean of T² R^p over the disc", shares),
    case("Matched absorbing ball, σR = 0.01 and 1", "[1 − (1 + 2s) e^(−2s)]/(2s²), s = σR", matched_ball).of_images(),
    case("Lateral shift by a slab", "sin θ (1 − cos θ/√(n² − sin² θ))", shift),
];

/// The media on both sides of a vertex as the path backwards must see them: what it goes through it meets from the other side.
fn sides(vertex: &Vertex, is_backwards: bool) -> [Option<&str>; 2] {
    let (from, to) = (vertex.from.as_deref(), vertex.to.as_deref());
    if is_backwards && vertex.event == VertexEvent::Transmit { [to, from] } else { [from, to] }
}

/// Eccentric spheres have no closed form, but a path must lead back.
fn reversed(subject: &Subject) -> Measured {
    let mut description = empty(1.2);
    add(&mut description, sphere(DVec3::ZERO, 1.0), 1.5, 0.0);
    add(&mut description, sphere(DVec3::new(0.1, 0.2, 0.05), 0.6), 1.333, 0.0);
    add(&mut description, sphere(DVec3::new(0.2, 0.1, -0.1), 0.25), 1.8, 0.0);
    let scene = ready(description)?;
    let mut numbers = Numbers(53);
    let rays: Vec<Ray> = (0..subject.amount(300, 5000))
        .map(|_| {
            let direction = numbers.direction();
            Ray::new(numbers.point(DVec3::splat(-0.5), DVec3::splat(0.5)) - direction * 4.0, direction)
        })
        .collect();
    subject.in_modes(|mode| {
        let (mut turned, mut reflectance, mut other): (f64, f64, usize) = (0.0, 0.0, 0);
        for ray in &rays {
            let there = trace(&scene, mode, *ray, Follow::Transmit, 0, None);
            let Some(last) = there.vertices.last() else { continue };
            let direction = DVec3::from(there.final_direction);
            let start = Ray::new(DVec3::from(last.position) + direction, -direction);
            let back = trace(&scene, mode, start, Follow::Transmit, 0, None);
            let forth_sides = there.vertices.iter().map(|v| sides(v, false));
            if !back.escaped || !forth_sides.eq(back.vertices.iter().rev().map(|v| sides(v, true))) {
                other += 1;
                continue;
            }
            turned = turned.max((DVec3::from(back.final_direction) + ray.direction).length());
            for (a, b) in there.vertices.iter().zip(back.vertices.iter().rev()) {
                reflectance = reflectance.max((a.fresnel.unwrap_or(f64::NAN) - b.fresnel.unwrap_or(f64::NAN)).abs());
            }
        }
        Ok([
            Measurement::none_of("paths that go another way back", other, "paths"),
            Measurement::absolute("direction", turned, 0.0, 1e-9).in_unit("rad"),
            Measurement::absolute("|ΔR| at an interface", reflectance, 0.0, 1e-9),
        ])
    })
}

/// Paths chosen at random as the renderer does, over the ball's disc, sorted by the number of their vertices.
fn shares(subject: &Subject) -> Measured {
    let ball = ready(nest(1.0, &[(1.0, 1.5)]))?;
    subject.in_modes(|mode| {
        let count = samples_of(mode, subject.amount(40_000, 400_000));
        let vertices =
            |k: u32| trace(&ball, mode, onto_disc(k, count), Follow::Sample, u64::from(k), Some(8)).vertices.len();
        let lengths: Vec<usize> = (0..count).into_par_iter().map(vertices).collect();
        let share = |(k, expected): (usize, f64)| {
            let measured = lengths.iter().filter(|length| **length == k + 1).count() as f64 / f64::from(count);
            // Of random paths; spreading them evenly over the disc makes it less.
            let noise = (expected * (1.0 - expected) / f64::from(count)).sqrt();
            let what = if k == 0 { "reflected outside".to_owned() } else { format!("p = {}", k - 1) };
            Measurement::absolute(what, measured, expected, 1e-5).with_noise(noise)
        };
        Ok(shares_of_ball::<5>(1.5).into_iter().enumerate().map(share).collect::<Vec<_>>())
    })
}

/// The ball fills a disc in the image, of the image's width; around it the room is white.
fn matched_ball(subject: &Subject) -> Measured {
    of_each([0.01, 1.0], |s| {
        let mut description = empty(1.3);
        add(&mut description, sphere(DVec3::ZERO, 1.0), 1.3, s);
        description.camera.position = DVec3::new(0.0, 0.0, 1e5);
        description.camera.vertical_fov = 2.0 * (1e-5f64).atan().to_degrees();
        let scene = ready(description)?;
        subject.in_modes(|mode| {
            let film = subject.render(&scene, mode, (64, 64), subject.amount(8, 64), 1, None)?;
            let measured = 1.0 - (1.0 - mean(&film).0) / std::f64::consts::FRAC_PI_4;
            // Low-discrepancy points leave an error at the rim alone.
            let what = format!("mean T over the disc, σR = {s}");
            Ok([Measurement::absolute(what, measured, absorbing_ball(s), 1e-3)])
        })
    })
}

fn shift(subject: &Subject) -> Measured {
    let mut description = layers(&[(0.0, -1.0, 1.5, 0.0)], 0.0);
    description.objects.clear(Kind::Light);
    let scene = ready(description)?;
    of_each([30.0, 45.0, 89.0], |degrees| {
        subject.in_modes(|mode| {
            let ray = downwards(degrees);
            let path = trace(&scene, mode, ray, Follow::Transmit, 0, None);
            let exit = path.vertices.get(1).map_or(DVec3::NAN, |v| DVec3::from(v.position));
            let measured = exit.cross(ray.direction).length();
            let what = format!("shift at {degrees}°");
            Ok([Measurement::absolute(what, measured, lateral_shift(1.5, degrees), 1e-9)])
        })
    })
}
