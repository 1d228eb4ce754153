//! Cases 35 to 38: where a ray must meet two surfaces that are next to each other, or a surface at a place that is easily missed. Straight
//! rays, all indices 1, so that the order of the media along each ray is known; a ray with another order is a miscount.

use glam::DVec3;

use super::convex::Convex;
use super::definition::{CaseDefinition, Measured, Subject, Unmeasured};
use super::outcome::Measurement;
use super::scenes::{Numbers, add, empty, icosphere, interfaces, mesh_of, ready, sphere};
use crate::geometry::Ray;
use crate::scene::SceneError;
use crate::scene::description::{Description, Shape, Transform};
use crate::tracking::Mode;
use crate::tracking::Prepared;
use crate::transport::inspect::{Follow, TracedPath, trace};

const STRAIGHT: &str = "straight rays: the order of the media is known";

pub(super) const CASES: &[CaseDefinition] = &[
    CaseDefinition::new(35, "Gaps between shells, 1e-2 to 1e-6", STRAIGHT, gaps),
    CaseDefinition::new(36, "No gap; coincident planar faces of another tessellation", STRAIGHT, coincident),
    CaseDefinition::new(
        37,
        "Offset 1e5 with a gap of 0.1; scales 2^±20",
        "rigid motion and scaling change nothing",
        moved,
    ),
    CaseDefinition::new(38, "Rays at vertices, edges and along axes", STRAIGHT, vertices_and_edges),
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

    pub(super) fn ball(self, radius: f64, subdivisions: u32) -> Shape {
        match self {
            Self::Analytic => sphere(DVec3::ZERO, radius),
            Self::Triangles => icosphere(radius, subdivisions),
        }
    }
}

/// Two shells a gap apart, turned, scaled and moved.
pub(super) fn shells(gap: f64, kind: Kind, scale: f64, center: DVec3) -> Description {
    let mut description = empty(1.0);
    for radius in [1.0, 1.0 - gap] {
        add(&mut description, kind.ball(radius, 3), 1.0, 0.0);
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

fn gaps(subject: &Subject) -> Measured {
    let mut measurements = Vec::new();
    for exponent in 2..=6 {
        for kind in Kind::BOTH {
            let scene = ready(shells(10f64.powi(-exponent), kind, 1.0, DVec3::ZERO))?;
            for &mode in subject.modes {
                subject.go_on()?;
                let count = miscounted(&scene, mode, DVec3::ZERO, 1.0, &OUT_AND_IN, subject.amount(300, 3000));
                let what = format!("miscounts, gap 1e-{exponent}, {}, {mode}", kind.name());
                measurements.push(Measurement::none_of(what, count, "rays"));
            }
        }
    }
    Ok(measurements)
}

/// The same surface twice is one, whose inside is that of the object that wins: by priority, then, of equal volumes, the later.
fn coincident(subject: &Subject) -> Measured {
    let mut measurements = Vec::new();
    for kind in Kind::BOTH {
        for (priorities, winner) in [([0, 0], "object 1"), ([1, 0], "object 0"), ([-1, 0], "object 1")] {
            let mut description = shells(0.0, kind, 1.0, DVec3::ZERO);
            description.objects.refractor_roles_mut().zip(priorities).for_each(|(r, p)| r.priority = p);
            let scene = ready(description)?;
            let once = [("world", winner), (winner, "world")];
            for &mode in subject.modes {
                subject.go_on()?;
                let count = miscounted(&scene, mode, DVec3::ZERO, 1.0, &once, subject.amount(300, 3000));
                let what = format!("miscounts, {winner} wins, {}, {mode}", kind.name());
                measurements.push(Measurement::none_of(what, count, "rays"));
            }
        }
    }
    planar_faces(subject, &mut measurements)?;
    Ok(measurements)
}

/// Convex bodies that share planes, cut into faces in different ways; overlapping, on each other and side by side.
fn planar_faces(subject: &Subject, measurements: &mut Vec<Measurement>) -> Result<(), Unmeasured> {
    let cylinder = |x: f64, y: f64, segments: u32| Convex::cylinder(DVec3::new(x, y, 0.1), 0.6, 1.0, segments);
    let cuboid = |min: [f64; 3], max: [f64; 3]| Convex::cuboid(min.into(), max.into());
    for (name, bodies) in [
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
    ] {
        for rotate in [DVec3::ZERO, DVec3::new(12.0, -34.0, 56.0)] {
            let mut description = empty(1.0);
            for body in &bodies {
                add(&mut description, body.shape.clone(), 1.0, 0.0);
            }
            description.objects.refractors_mut().iter_mut().for_each(|r| r.transform.rotate = rotate);
            let to_object = description.objects.refractors()[0].transform.matrix().inverse();
            let scene = ready(description)?;
            let mut numbers = Numbers(31);
            let mut wrong = vec![0; subject.modes.len()];
            let mut checked = 0;
            for _ in 0..subject.amount(300, 3000) {
                let direction = numbers.direction();
                let aim = numbers.point(DVec3::new(-1.0, -1.0, -1.0), DVec3::ONE);
                let ray = Ray::new(to_object.inverse().transform_point3(aim) - direction * 6.0, direction);
                let local =
                    Ray::new(to_object.transform_point3(ray.origin), to_object.transform_vector3(ray.direction));
                let Some(media) = super::convex::media_along(&bodies, &local) else { continue };
                checked += 1;
                for (wrong, &mode) in wrong.iter_mut().zip(subject.modes) {
                    let path = trace(&scene, mode, ray, Follow::Transmit, 0, None);
                    *wrong += usize::from(path.events.total() > 0 || media_of(&path) != media);
                }
            }
            subject.go_on()?;
            let turned = if rotate == DVec3::ZERO { "" } else { ", turned" };
            for (wrong, mode) in wrong.into_iter().zip(subject.modes) {
                let what = format!("miscounts, {name}{turned}, {mode}");
                measurements.push(Measurement::none_of(what, wrong, "rays"));
            }
            // Rays that pass too close to an edge for a truth in rounded numbers are few.
            let least = subject.amount(300, 3000) / 2;
            let what = format!("rays checked, {name}{turned}");
            let missing = least.max(checked) - checked;
            measurements.push(Measurement::none_of(what + ": too few by", missing, "rays"));
        }
    }
    Ok(())
}

/// The media of a path, each different from the one before; stretches between surfaces that are one do not count.
fn media_of(path: &TracedPath) -> Vec<String> {
    let mut names = vec![path.camera_medium.clone()];
    let mut last: Option<DVec3> = None;
    for vertex in path.vertices.iter().filter(|v| v.from != v.to) {
        let position = DVec3::from(vertex.position);
        if last.is_some_and(|last| position.distance(last) <= super::convex::TOGETHER) {
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
    let mut measurements = Vec::new();
    for center in [DVec3::new(1e5, -1e5, 0.5e5), DVec3::X * 1e5] {
        for kind in Kind::BOTH {
            let scene = ready(shells(0.1, kind, 1.0, center))?;
            for &mode in subject.modes {
                subject.go_on()?;
                let count = miscounted(&scene, mode, center, 1.0, &OUT_AND_IN, subject.amount(300, 3000));
                let what = format!("miscounts at {center}, {}, {mode}", kind.name());
                measurements.push(Measurement::none_of(what, count, "rays"));
            }
        }
    }
    let count = subject.amount(100, 1000);
    for &mode in subject.modes {
        let ordinary = scaled_paths(mode, 1.0, count)?;
        for exponent in [-20, 20] {
            subject.go_on()?;
            let scaled = scaled_paths(mode, 2f64.powi(exponent), count)?;
            let differing = ordinary.iter().zip(&scaled).filter(|(a, b)| a != b).count();
            let what = format!("paths with another bit at scale 2^{exponent}, {mode}");
            measurements.push(Measurement::none_of(what, differing, "paths"));
        }
    }
    Ok(measurements)
}

/// Paths through boxes and balls that contain, touch and cross each other, at this scale, scaled back.
pub(super) fn scaled_paths(mode: Mode, scale: f64, count: usize) -> Result<Vec<TracedPath>, SceneError> {
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
        let mut path = trace(&scene, mode, Ray::new(origin * scale, direction), Follow::Sample, k as u64, Some(20));
        path.vertices.iter_mut().for_each(|v| v.position = v.position.map(|x| x / scale));
        path
    });
    Ok(paths.collect())
}

/// From within three nested polyhedra, every ray goes out through each once, and a line through a place within all goes in and out.
fn vertices_and_edges(subject: &Subject) -> Measured {
    let mut description = empty(1.0);
    let shapes = [icosphere(1.0, 2), icosphere(0.7, 1), icosphere(0.4, 0)];
    let mut aims = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let mut numbers = Numbers(41);
    for shape in &shapes {
        add(&mut description, shape.clone(), 1.0, 0.0);
        let mesh = mesh_of(shape)?;
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
    let mut measurements = Vec::new();
    for &mode in subject.modes {
        for (name, start, expected) in [("from within", 0.0, &out[..]), ("from outside", 3.0, &through[..])] {
            subject.go_on()?;
            let mut wrong = 0;
            for aim in &aims {
                for origin in [DVec3::ZERO, DVec3::new(0.01, -0.02, 0.03)] {
                    let direction = (*aim - origin).normalize();
                    let ray = Ray::new(origin - direction * start, direction);
                    let path = trace(&scene, mode, ray, Follow::Transmit, 0, None);
                    wrong += usize::from(interfaces(&path) != expected || path.events.total() > 0);
                }
            }
            let what = format!("parity errors of {} rays {name}, {mode}", 2 * aims.len());
            measurements.push(Measurement::none_of(what, wrong, "rays"));
        }
    }
    Ok(measurements)
}
