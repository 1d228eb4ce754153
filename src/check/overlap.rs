//! Refractors whose surfaces cross: volumes that overlap in part.
//!
//! Two spheres are compared exactly. Other pairs are asked by points of one surface: some inside the other object and some not means
//! that the surfaces cross. A very small overlap can be missed.

use glam::DVec3;

use super::Problem;
use crate::geometry::{Geometry, ObjectRange};
use crate::rectify::containment::{containment, top};
use crate::render::Prepared;
use crate::scene::World;
use crate::scene::world::{ObjectId, Surface};

/// Points on each surface that are asked what contains them.
const POINTS: u32 = 64;

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let world = &*prepared.world;
    let ids: Vec<ObjectId> = world.refractors().map(|(id, _)| id).collect();
    let bounds: Vec<_> = ids.iter().map(|id| world.geometry.bounds_of(id.0)).collect();
    let meets = |a: usize, b: usize| bounds[a].0.cmple(bounds[b].1).all() && bounds[b].0.cmple(bounds[a].1).all();
    let mut problems = Vec::new();
    // Worked out for those refractors only that might cross another.
    let mut shares: Vec<Option<Vec<u32>>> = vec![None; ids.len()];
    for a in 0..ids.len() {
        for b in a + 1..ids.len() {
            if !meets(a, b) {
                continue;
            }
            if is_copy(prepared, ids[a], ids[b]) {
                problems.push(coincident(world, ids[a], ids[b]));
                continue;
            }
            let crosses = spheres_cross(&world.geometry, ids[a], ids[b]).unwrap_or_else(|| {
                [(a, b), (b, a)].into_iter().any(|(x, y)| {
                    let inside = shares[x].get_or_insert_with(|| points_inside(world, ids[x]))[ids[y].0 as usize];
                    inside > 0 && inside < POINTS
                })
            });
            if crosses {
                problems.push(overlap(world, ids[a], ids[b]));
            }
        }
    }
    problems
}

/// Whether two objects are of one shape at one place.
fn is_copy(prepared: &Prepared, a: ObjectId, b: ObjectId) -> bool {
    let refractors = &prepared.description.refractors;
    let (a, b) = (&refractors[a.0 as usize], &refractors[b.0 as usize]);
    a.shape == b.shape && a.transform == b.transform
}

/// Whether the surfaces of two analytic spheres cross; `None` if they are not both such.
fn spheres_cross(geometry: &Geometry, a: ObjectId, b: ObjectId) -> Option<bool> {
    let sphere = |id: ObjectId| match geometry.range(id.0) {
        ObjectRange::Sphere(primitive) => geometry.sphere(*primitive),
        ObjectRange::Triangles(_) => None,
    };
    let (a, b) = (sphere(a)?, sphere(b)?);
    let distance = a.center.distance(b.center);
    Some((a.radius - b.radius).abs() < distance && distance < a.radius + b.radius)
}

/// For each object, how many of [`POINTS`] points on a refractor's surface lie inside it.
fn points_inside(world: &World, refractor: ObjectId) -> Vec<u32> {
    let mut inside = vec![0; world.objects.len()];
    for i in 0..POINTS {
        if let Some(point) = world.geometry.sample_surface(refractor.0, spread(i)) {
            for container in containment(world, point.position, Some(refractor)).refractors {
                inside[container.0 as usize] += 1;
            }
        }
    }
    inside
}

/// Evenly spread points of the unit cube (the R₃ sequence of Roberts 2018).
fn spread(i: u32) -> [f64; 3] {
    /// The real root of x⁴ = x + 1.
    const ROOT: f64 = 1.220_744_084_605_759_5;
    let steps = DVec3::new(1.0 / ROOT, 1.0 / (ROOT * ROOT), 1.0 / (ROOT * ROOT * ROOT));
    (DVec3::splat(0.5) + steps * f64::from(i)).fract().to_array()
}

fn overlap(world: &World, a: ObjectId, b: ObjectId) -> Problem {
    const LIMIT: &str = "One exterior per object, as `rectified` keeps in this version, cannot be right where objects overlap in part; \
                         `reference` can";
    let names = [a, b].map(|id| world.object(id).name.as_str());
    let place = names.join(", ");
    let [priority_a, priority_b] = [a, b].map(|id| match world.object(id).surface {
        Surface::Refractor { priority, .. } => priority,
        _ => 0,
    });
    let winner = top(world, [a, b]).map_or("", |id| &world.object(id).name);
    let [a, b] = names;
    if priority_a == priority_b {
        let message = format!(
            "{a} and {b} overlap with equal priority: the smaller volume wins, here {winner}; set a priority to choose (higher wins). \
             {LIMIT}"
        );
        Problem::warning(place, "overlap_tie", message)
    } else {
        let message = format!("{a} and {b} overlap; {winner} has the higher priority and wins. {LIMIT}");
        Problem::warning(place, "overlap", message)
    }
}

fn coincident(world: &World, a: ObjectId, b: ObjectId) -> Problem {
    let [a, b] = [a, b].map(|id| world.object(id).name.as_str());
    Problem::warning(
        format!("{a}, {b}"),
        "coincident",
        format!(
            "{a} and {b} have the same shape at the same place: which surface is met first is a matter of rounding; remove one"
        ),
    )
}
