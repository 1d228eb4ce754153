//! Surfaces that lie exactly on each other, and the mode `priority`: it meets them one after the other, in the order of their numbers, and
//! may so leave one volume before it enters the next, through a film of what is around that is not there.

use rayon::prelude::*;

use super::{Problem, names, samples};
use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::rectify::contact::{self, is_refractor};
use crate::rectify::containment::medium_of;
use crate::rectify::encounters::Meeting;
use crate::render::{Events, Prepared};
use crate::scene::world::{MediumId, ObjectId};
use crate::tracking::priority::Priority;
use crate::tracking::rectified::Rectified;
use crate::tracking::{Crossing, Sides, Tracker};

/// Pairs of objects that are looked at, and points of each.
const MOST_PAIRS: usize = 500;
const POINTS: u32 = 32;

/// One finding for the whole scene.
pub(super) fn problems(prepared: &Prepared) -> Option<Problem> {
    let world = &*prepared.world;
    let touching: Vec<(ObjectId, ObjectId)> = (prepared.table.encounters(world).into_iter())
        .filter(|encounter| encounter.meeting == Meeting::Touch)
        .map(|encounter| (encounter.a, encounter.b))
        .take(MOST_PAIRS)
        .collect();
    let wrong: Vec<(ObjectId, ObjectId, MediumId)> =
        touching.into_par_iter().filter_map(|(a, b)| Some((a, b, film_between(prepared, a, b)?))).collect();
    let &(a, b, medium) = wrong.first()?;
    let mut objects: Vec<ObjectId> = wrong.iter().flat_map(|&(a, b, _)| [a, b]).collect();
    objects.sort_unstable();
    objects.dedup();
    let [a, b] = [a, b].map(|id| &world.object(id).name);
    let more = match wrong.len() {
        1 => String::new(),
        count => format!(" (and {} more pairs)", count - 1),
    };
    Some(Problem::advice(
        names::place_of(world, &objects),
        "flush_in_priority",
        format!(
            "`{a}` and `{b}`{more} have faces that lie exactly on each other: `rectified` is right there, but the mode `priority` may meet the \
             two in the wrong order and show a film of `{}` that is not there. For `priority`, and for renderers that work like it, let the \
             volumes overlap a little and give one the higher priority",
            world.medium(medium).name
        ),
    ))
}

/// The medium of a film that `priority` sees between the surfaces of two refractors where they coincide, and `rectified` does not.
fn film_between(prepared: &Prepared, a: ObjectId, b: ObjectId) -> Option<MediumId> {
    let geometry = &*prepared.world.geometry;
    // Points of the smaller one: more of it lies on the other.
    let (subject, other) = if geometry.area(a.0) <= geometry.area(b.0) { (a, b) } else { (b, a) };
    samples::of_surface(geometry, subject.0, 0..POINTS).filter(|(point, _)| is_on(prepared, point, other)).find_map(
        |(point, slant)| {
            // Not along the normal, which might run in other surfaces.
            let direction = (point.normal + 0.2 * slant).normalize_or(point.normal);
            film_along(prepared, &point, direction).or_else(|| film_along(prepared, &point, -direction))
        },
    )
}

/// Whether the surface of `other` lies at a point of another one.
fn is_on(prepared: &Prepared, point: &SurfacePoint, other: ObjectId) -> bool {
    let geometry = &*prepared.world.geometry;
    let mut is_on = false;
    let reach = glam::DVec3::splat(contact::margin(geometry));
    geometry.for_each_near_box(point.position - reach, point.position + reach, None, |primitive| {
        is_on |= geometry.object_of(primitive) == other.0
            && contact::coincides(geometry, point.primitive, primitive).is_some()
            && geometry.distance(primitive, point.position) <= reach.x;
    });
    is_on
}

/// The same on the straight line through `point`, which comes from outside of everything.
fn film_along(prepared: &Prepared, point: &SurfacePoint, direction: glam::DVec3) -> Option<MediumId> {
    let world = &*prepared.world;
    let geometry = &*world.geometry;
    let bounds = geometry.bounding_sphere()?;
    let back = 2.0 * bounds.radius + 1.0;
    let ray = Ray::new(point.position - direction * back, direction);
    let hits = geometry.all_hits(&ray);
    // What is opaque does not end this line: no path but the line itself is meant.
    let priority = Priority { world };
    let rectified = Rectified { world, table: &prepared.table };
    let reach = contact::margin(geometry);
    let (mut list, mut events) = (Vec::new(), Events::default());
    let (mut seen, mut right): (Vec<Sides>, Vec<Sides>) = (Vec::new(), Vec::new());
    for hit in hits {
        let id = ObjectId(geometry.object_of(hit.primitive));
        if hit.t > back + reach || !is_refractor(world, id) {
            continue;
        }
        let crossing = crossing(prepared, &ray, &hit, id);
        if (hit.t - back).abs() <= reach {
            seen.extend(priority.sides(&list, &crossing, &mut events));
            right.extend(rectified.sides(&(), &crossing, &mut events).filter(|sides| sides.from != sides.to));
        }
        priority.transmit(&mut list, &crossing);
    }
    // A line that is off for another reason, such as a tie, says nothing about this place.
    let (first, last) = (seen.first()?, seen.last()?);
    let is_same_in_the_end = match right[..] {
        [] => first.from == last.to,
        [only] => (first.from, last.to) == (only.from, only.to),
        _ => false,
    };
    (is_same_in_the_end && seen.len() > right.len()).then_some(first.to)
}

fn crossing(prepared: &Prepared, ray: &Ray, hit: &Hit, refractor: ObjectId) -> Crossing {
    let world = &*prepared.world;
    let point = world.geometry.surface(ray, hit);
    let interior = medium_of(world, Some(refractor));
    Crossing { refractor, interior, is_entering: hit.is_front, point, barycentric: hit.barycentric }
}
