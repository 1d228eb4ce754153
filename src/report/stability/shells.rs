//! Cases 35 to 38: where a ray must meet two surfaces that are next to each other, or a surface at a place that is easily missed. Straight
//! rays, all indices 1, so that the order of the media along each ray is known; a ray with another order is a miscount.

use glam::DVec3;

use super::convex::{Convex, TOGETHER, media_along};
use super::definition::{CaseDefinition, Measured, Subject, case, of_each};
use super::outcome::Measurement;
use super::scenes::{Numbers, add, empty, icosphere, interfaces, mesh_of, ready, sphere};
use crate::geometry::Ray;
use crate::scene::SceneError;
use crate::scene::description::{Description, Shape, Transform};
use crate::tracking::{Mode, Prepared};
use crate::transport::inspect::{Follow, TracedPath, trace};

const STRAIGHT: &str = "straight rays: the order of the media is known";

pub(super) const CASES: &[CaseDefinition] = &[
    case(35, "Gaps between shells, 1e-2 to 1e-6", STRAIGHT, gaps),
    case(36, "No gap; coincident planar faces of another tessellation", STRAIGHT, coincident),
    case(37, "Offset 1e5 with a gap of 0.1; scales 2^±20", "rigid motion and scaling change nothing", moved),
    case(38, "Rays at vertices, edges and along axes", STRAIGHT, vertices_and_edges),
];

pub(super) const OUT_AND_IN: [(&str, &str); 4] =
    [("world", "object 0"), ("object 0", "object 1"), ("object 1", "object 0"), ("object 0", "world")];

/// Whether spheres are analytic or of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Analytic,
    Triangles,
}

impl Kind {
    pub(super) const BOTH: [Self; 2] = [Self::Triangles, Self::Analytic];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Analytic => "analytic",
            Self::Triangles => "triangles",
        }
    }
}

/// Two shells a gap apart, turned, scaled and moved.
pub(super) fn shells(gap: f64, kind: Kind, scale: f64, center: DVec3) -> Description {
    let mut description = empty(1.0);
    for radius in [1.0, 1.0 - gap] {
        let shape = if kind == Kind::Analytic { sphere(DVec3::ZERO, radius) } else { icosphere(radius, 3) };
        add(&mut description, shape, 1.0, 0.0);
    }
    for refractor in description.objects.refractors_mut() {
        refractor.transform =
            Transform { scale: DVec3::splat(scale), rotate: DVec3::new(11.0, 22.0, 33.0), translate: center };
    }
    description
}

/// An object that rays may meet somewhere else, which does not count.
pub(super) const BYSTANDER: &str = "object 2";

/// Of `count` rays through the middle of what lies at `center`, those that do not meet `expected`.
pub(super) fn miscounted(
    scene: &Prepared,
    mode: Mode,
    center: DVec3,
    scale: f64,
    expected: &[(&str, &str)],
    count: usize,
) -> usize {
    let mut numbers = Numbers(29);
    let is_wrong = |_: &usize| {
        let direction = numbers.direction();
        let aim = numbers.direction() * 0.5;
        let ray = Ray::new(center + (aim - direction * 3.0) * scale, direction);
        let path = trace(scene, mode, ray, Follow::Transmit, 0, None);
        let mut met = interfaces(&path);
        met.retain(|(from, to)| *from != BYSTANDER && *to != BYSTANDER);
        path.events.total() > 0 || !path.escaped || met != expected
    };
    (0..count).filter(is_wrong).count()
}

/// [`miscounted`] in every mode.
pub(super) fn miscounts(
    subject: &Subject,
    what: impl std::fmt::Display,
    scene: &Prepared,
    center: DVec3,
    expected: &[(&str, &str)],
    count: usize,
) -> Measured {
    subject.in_modes(|mode| {
        let wrong = miscounted(scene, mode, center, 1.0, expected, count);
        Ok([Measurement::none_of(format!("miscounts{what}"), wrong, "rays")])
    })
}

fn gaps(subject: &Subject) -> Measured {
    let both = |exponent| Kind::BOTH.map(|kind| (exponent, kind));
    of_each((2..=6).flat_map(both), |(exponent, kind)| {
        let scene = ready(shells(10f64.powi(-exponent), kind, 1.0, DVec3::ZERO))?;
        let what = format!(", gap 1e-{exponent}, {}", kind.name());
        miscounts(subject, what, &scene, DVec3::ZERO, &OUT_AND_IN, subject.amount(300, 3000))
    })
}

/// The same surface twice is one, whose inside is that of the object that wins: by priority, then, of equal volumes, the later.
fn coincident(subject: &Subject) -> Measured {
    let winners = [([0, 0], "object 1"), ([1, 0], "object 0"), ([-1, 0], "object 1")];
    let rows = Kind::BOTH.into_iter().flat_map(|kind| winners.map(|row| (kind, row)));
    let mut found = of_each(rows, |(kind, (priorities, winner))| {
        let mut description = shells(0.0, kind, 1.0, DVec3::ZERO);
        description.objects.refractor_roles_mut().zip(priorities).for_each(|(r, p)| r.priority = p);
        let once = [("world", winner), (winner, "world")];
        let what = format!(", {winner} wins, {}", kind.name());
        miscounts(subject, what, &ready(description)?, DVec3::ZERO, &once, subject.amount(300, 3000))
    })?;
    found.extend(planar_faces(subject)?);
    Ok(found)
}

/// Convex bodies that share planes, cut into faces in different ways; overlapping, on each other and side by side.
fn planar_faces(subject: &Subject) -> Measured {
    let cylinder = |x: f64, y: f64, segments: u32| Convex::cylinder(DVec3::new(x, y, 0.1), 0.6, 1.0, segments);
    let cuboid = |min: [f64; 3], max: [f64; 3]| Convex::cuboid(min.into(), max.into());
    let groups = [
        ("cylinder on a box", vec![cuboid([-1.0, -1.0, -1.0], [1.0, 0.0, 1.0]), cylinder(0.1, 0.5, 24)]),
        ("cylinder over the edge of a box", vec![cuboid([-1.0, -1.0, -1.0], [0.2, 0.0, 1.0]), cylinder(0.1, 0.5, 24)]),
        ("cylinders on each other", vec![cylinder(0.0, -0.5, 17), cylinder(0.2, 0.5, 24), cylinder(-0.3, 0.5, 9)]),
        ("cylinder flush with a box", vec![cuboid([-1.0, -2.0, -1.0], [1.0, 0.0, 1.0]), cylinder(0.1, -0.5, 24)]),
        (
            "three boxes on one plane",
            vec![
                cuboid([-1.0, -1.0, -1.0], [1.0, 0.0, 1.0]),
                cuboid([-0.7, 0.0, -0.7], [0.3, 0.8, 0.9]),
                cuboid([-0.2, -0.6, -0.4], [0.5, 0.0, 0.4]),
            ],
        ),
    ];
    let turns = [("", DVec3::ZERO), (", turned", DVec3::new(12.0, -34.0, 56.0))];
    let rows = groups.iter().flat_map(|group| turns.map(|turn| (group, turn)));
    of_each(rows, |((name, bodies), (turned, rotate))| {
        let mut description = empty(1.0);
        for body in bodies {
            add(&mut description, body.shape.clone(), 1.0, 0.0);
        }
        description.objects.refractors_mut().iter_mut().for_each(|r| r.transform.rotate = rotate);
        let to_object = description.objects.refractors()[0].transform.matrix().inverse();
        let scene = ready(description)?;
        let mut numbers = Numbers(31);
        let count: usize = subject.amount(300, 3000);
        let mut ray_and_media = |_| {
            let direction = numbers.direction();
            let aim = numbers.point(DVec3::new(-1.0, -1.0, -1.0), DVec3::ONE);
            let ray = Ray::new(to_object.inverse().transform_point3(aim) - direction * 6.0, direction);
            let local = Ray::new(to_object.transform_point3(ray.origin), to_object.transform_vector3(ray.direction));
            Some((ray, media_along(bodies, &local)?))
        };
        let rays: Vec<(Ray, Vec<String>)> = (0..count).filter_map(&mut ray_and_media).collect();
        let mut found = subject.in_modes(|mode| {
            let is_wrong = |(ray, media): &&(Ray, Vec<String>)| {
                let path = trace(&scene, mode, *ray, Follow::Transmit, 0, None);
                path.events.total() > 0 || media_of(&path) != *media
            };
            let wrong = rays.iter().filter(is_wrong).count();
            Ok([Measurement::none_of(format!("miscounts, {name}{turned}"), wrong, "rays")])
        })?;
        // Rays that pass too close to an edge for a truth in rounded numbers are few.
        let missing = (count / 2).saturating_sub(rays.len());
        found.push(Measurement::none_of(format!("rays checked, {name}{turned}: too few by"), missing, "rays"));
        Ok(found)
    })
}

/// The media of a path, each different from the one before; stretches between surfaces that are one do not count.
fn media_of(path: &TracedPath) -> Vec<String> {
    let mut names = vec![path.camera_medium.clone()];
    let mut last: Option<DVec3> = None;
    for vertex in path.vertices.iter().filter(|v| v.from != v.to) {
        let position = DVec3::from(vertex.position);
        if last.is_some_and(|last| position.distance(last) <= TOGETHER) {
            names.pop();
        }
        let to = vertex.to.clone().unwrap_or_default();
        if names.last() != Some(&to) {
            names.push(to);
        }
        last = Some(position);
    }
    names
}

fn moved(subject: &Subject) -> Measured {
    let both = |center| Kind::BOTH.map(|kind| (center, kind));
    let centers = [DVec3::new(1e5, -1e5, 0.5e5), DVec3::X * 1e5];
    let mut found = of_each(centers.into_iter().flat_map(both), |(center, kind)| {
        let scene = ready(shells(0.1, kind, 1.0, center))?;
        let what = format!(" at {center}, {}", kind.name());
        miscounts(subject, what, &scene, center, &OUT_AND_IN, subject.amount(300, 3000))
    })?;
    found.extend(of_each([-20, 20], |exponent| {
        let what = format!("paths with another bit at scale 2^{exponent}");
        scaled(subject, &what, exponent, subject.amount(100, 1000))
    })?);
    Ok(found)
}

/// Of so many paths, those that differ by a bit when everything is scaled by 2^`exponent`.
pub(super) fn scaled(subject: &Subject, what: &str, exponent: i32, count: usize) -> Measured {
    subject.in_modes(|mode| {
        let (ordinary, scaled) = (scaled_paths(mode, 1.0, count)?, scaled_paths(mode, 2f64.powi(exponent), count)?);
        let differing = ordinary.iter().zip(&scaled).filter(|(a, b)| a != b).count();
        Ok([Measurement::none_of(what, differing, "paths")])
    })
}

/// Paths through boxes and balls that contain, touch and cross each other, at this scale, scaled back.
fn scaled_paths(mode: Mode, scale: f64, count: usize) -> Result<Vec<TracedPath>, SceneError> {
    let mut description = empty(1.0);
    let cuboid = |min: [f64; 3], max: [f64; 3]| Shape::Box { min: min.into(), max: max.into() };
    add(&mut description, cuboid([-1.0, -1.0, -1.0], [1.0, 0.2, 1.0]), 1.333, 0.0);
    add(&mut description, icosphere(0.8, 2), 1.5, 0.0);
    add(&mut description, sphere(DVec3::new(0.3, 0.1, 0.2), 0.5), 1.7, 0.0);
    add(&mut description, cuboid([-0.5, 0.2, -0.5], [0.9, 0.6, 0.4]), 1.2, 0.0);
    for refractor in description.objects.refractors_mut() {
        refractor.transform.scale = DVec3::splat(scale);
    }
    let scene = ready(description)?;
    let mut numbers = Numbers(17);
    let paths = (0..count).map(|k| {
        let direction = numbers.direction();
        let point = numbers.point(DVec3::splat(-0.6), DVec3::splat(0.6));
        // By turns from outside and from within.
        let origin = if k % 2 == 0 { point - direction * 4.0 } else { point };
        let path = trace(&scene, mode, Ray::new(origin * scale, direction), Follow::Sample, k as u64, Some(20));
        path.scaled(scale.recip())
    });
    Ok(paths.collect())
}

/// From within three nested polyhedra, every ray goes out through each once, and a line through a place within all goes in and out.
fn vertices_and_edges(subject: &Subject) -> Measured {
    let mut description = empty(1.0);
    let mut aims = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let mut numbers = Numbers(41);
    for shape in [icosphere(1.0, 2), icosphere(0.7, 1), icosphere(0.4, 0)] {
        let mesh = mesh_of(&shape)?;
        add(&mut description, shape, 1.0, 0.0);
        // As they are stored.
        let corner = |i: u32| mesh.positions[i as usize].as_vec3().as_dvec3();
        for t in &mesh.triangles {
            aims.extend(t.map(corner));
            let share = numbers.next();
            aims.push(corner(t[0]) * share + corner(t[1]) * (1.0 - share));
        }
    }
    let scene = ready(description)?;
    let out = [("object 2", "object 1"), ("object 1", "object 0"), ("object 0", "world")];
    let through: Vec<(&str, &str)> = out.iter().rev().map(|&(a, b)| (b, a)).chain(out).collect();
    subject.in_modes(|mode| {
        Ok([("from within", 0.0, &out[..]), ("from outside", 3.0, &through[..])].map(|(name, start, expected)| {
            let mut wrong = 0;
            for aim in &aims {
                for origin in [DVec3::ZERO, DVec3::new(0.01, -0.02, 0.03)] {
                    let direction = (*aim - origin).normalize();
                    let ray = Ray::new(origin - direction * start, direction);
                    let path = trace(&scene, mode, ray, Follow::Transmit, 0, None);
                    wrong += usize::from(interfaces(&path) != expected || path.events.total() > 0);
                }
            }
            Measurement::none_of(format!("parity errors of {} rays {name}", 2 * aims.len()), wrong, "rays")
        }))
    })
}
