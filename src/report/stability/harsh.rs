//! Cases 39 and 40: broken meshes, deep nests, and absorption from nothing to everything.

use glam::DVec3;

use super::closed_forms::reflectance;
use super::definition::{CaseDefinition, Measured, Subject, case, of_each};
use super::outcome::Measurement;
use super::scenes::{Numbers, add, empty, icosphere, interfaces, mean, mesh_of, mesh_shape, nest, ready};
use crate::geometry::{Mesh, Ray};
use crate::render::Film;
use crate::scene::description::Shape;
use crate::tracking::Mode;
use crate::transport::inspect::{Follow, trace};

pub(super) const CASES: &[CaseDefinition] = &[
    case(
        39,
        "5 % of the triangles missing, slivers, duplicates",
        "nothing is not a number, and most answers are those of the whole meshes",
        broken,
    ),
    case(40, "256 deep; σd from 1e-6 to 1e3", "e^(−σd); overflow is counted", deep_and_dark),
];

fn with_faults(whole: Mesh, numbers: &mut Numbers) -> Mesh {
    let mut triangles = Vec::new();
    for t in whole.triangles {
        match numbers.index(40) {
            // 5 %.
            0 | 1 => {}
            2 => triangles.extend([t, t]),
            3 => triangles.extend([t, [t[0], t[1], t[1]]]),
            _ => triangles.push(t),
        }
    }
    Mesh { triangles, ..whole }
}

fn broken(subject: &Subject) -> Measured {
    let radii = [1.0, 0.6];
    // Faces lie up to 1 % within their sphere, and a point there may be on either side.
    let medium_at = |p: DVec3| {
        let r = p.length();
        let is_clear = radii.iter().all(|radius| r < 0.98 * radius || r > *radius);
        let depth = radii.iter().filter(|radius| r <= **radius).count();
        is_clear.then_some(["world", "object 0", "object 1"][depth])
    };
    let mut numbers = Numbers(43);
    let mut description = empty(1.0);
    for (radius, ior) in radii.into_iter().zip([1.4, 1.5]) {
        let mesh = with_faults(mesh_of(&icosphere(radius, 3))?, &mut numbers);
        add(&mut description, mesh_shape(mesh), ior, 0.0);
    }
    description.camera.vertical_fov = 15.0;
    let scene = ready(description)?;
    let rays: Vec<Ray> = (0..subject.amount(500, 5000))
        .map(|_| Ray::new(numbers.point(DVec3::splat(-0.7), DVec3::splat(0.7)), numbers.direction()))
        .collect();
    subject.in_modes(|mode| {
        let (mut starts, mut right_starts, mut crossings, mut right_crossings, mut not_numbers) = (0, 0, 0, 0, 0);
        for ray in &rays {
            let path = trace(&scene, mode, *ray, Follow::Transmit, 0, Some(12));
            if let Some(expected) = medium_at(ray.origin) {
                starts += 1;
                right_starts += usize::from(path.camera_medium == expected);
            }
            let sides = path.vertices.iter().filter(|v| v.from != v.to);
            for (vertex, (from, to)) in sides.zip(interfaces(&path)) {
                let is_outer = DVec3::from(vertex.position).length() > 0.8;
                let shell = if is_outer { ("world", "object 0") } else { ("object 0", "object 1") };
                crossings += 1;
                right_crossings += usize::from((from, to) == shell || (to, from) == shell);
            }
            not_numbers += usize::from(!path.final_direction.iter().all(|x| x.is_finite()));
        }
        let share = |right: usize, all: usize| right as f64 / all as f64;
        let film = subject.render(&scene, mode, (24, 24), subject.amount(2, 16), 1, None)?;
        not_numbers += film.events.non_finite as usize + pixels_without_a_number(&film);
        Ok([
            Measurement::absolute("share of starts in the right medium", share(right_starts, starts), 1.0, 0.005),
            Measurement::absolute("share of right crossings", share(right_crossings, crossings), 1.0, 0.01),
            Measurement::none_of("values that are no number", not_numbers, ""),
        ])
    })
}

fn pixels_without_a_number(film: &Film) -> usize {
    (0..film.sums.len()).filter(|&pixel| !film.mean(pixel).is_finite()).count()
}

fn deep_and_dark(subject: &Subject) -> Measured {
    // Spheres and, within each by less than the next one's distance, meshes.
    let shells: Vec<_> = (0..256).map(|k| (1.0 - f64::from(k) / 300.0, if k % 2 == 0 { 1.5 } else { 1.4 })).collect();
    let mut description = nest(1.0, &shells);
    for (k, refractor) in description.objects.refractors_mut().iter_mut().enumerate().filter(|(k, _)| k % 16 == 0) {
        refractor.shape = icosphere(shells[k].0, 4);
    }
    description.camera.vertical_fov = 8.0;
    let scene = ready(description)?;
    let ray = Ray::new(DVec3::new(-3.0, 0.011, 0.023), DVec3::X);
    // Modes that carry a state must hold all of it, or say so.
    let modes = [subject.modes, &[Mode::Stack, Mode::Priority]].concat();
    let mut found = Subject { modes: &modes, ..*subject }.in_modes(|mode| {
        let path = trace(&scene, mode, ray, Follow::Transmit, 0, None);
        let side = if mode == Mode::Reference { 2 } else { 6 };
        let not_numbers = pixels_without_a_number(&subject.render(&scene, mode, (side, side), 1, 1, None)?);
        Ok([
            Measurement::absolute("interfaces", path.vertices.len() as f64, 512.0, 0.0),
            Measurement::none_of("events", path.events.total() as usize, "events"),
            Measurement::none_of("pixels that are no number", not_numbers, "pixels"),
        ])
    })?;
    found.extend(of_each(-6..=3, |exponent| {
        let sigma = 10f64.powi(exponent);
        let scene = ready(matched_absorbers(sigma))?;
        subject.in_modes(|mode| {
            let (measured, _) = mean(&subject.render(&scene, mode, (4, 4), 2, 1, None)?);
            Ok([Measurement::relative(format!("T at σd = 1e{exponent}"), measured, (-sigma).exp(), 1e-8)])
        })
    })?);
    // A drop of water that absorbs all is black but for its surface; its middle is seen at normal incidence.
    let mut description = nest(1.0, &[(1.0, 1.333)]);
    description.media[0].absorption = [1e3; 3];
    description.camera.vertical_fov = 0.1;
    let scene = ready(description)?;
    found.extend(subject.in_modes(|mode| {
        let (measured, error) = mean(&subject.render(&scene, mode, (32, 32), subject.amount(64, 1024), 1, None)?);
        let expected = reflectance(1.0, 1.333, 1.0);
        Ok([Measurement::absolute("R of a black drop", measured, expected, 1e-5).with_noise(error)])
    })?);
    Ok(found)
}

/// Half a unit in each of two matched media, the inner of which overlaps the outer's far wall.
pub(super) fn matched_absorbers(sigma: f64) -> crate::scene::Description {
    let mut description = empty(1.333);
    for (min, max) in [([-100.0, -100.0, -0.5], [100.0, 100.0, 0.25]), ([-90.0, -90.0, 0.0], [90.0, 90.0, 0.5])] {
        add(&mut description, Shape::Box { min: min.into(), max: max.into() }, 1.333, sigma);
    }
    description.camera.vertical_fov = 1e-6;
    description
}
