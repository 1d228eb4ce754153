//! Surfaces that lie exactly on each other, and the mode `priority`: it meets them one after the other, in an order that rounding decides, or
//! misses the second where the first one bends the path; so it may leave one volume before it enters the next, or lose one.

use glam::DVec3;
use rayon::prelude::*;

use super::{Problem, distinct, names, samples};
use crate::geometry::{Ray, SurfacePoint};
use crate::rectify::containment::medium_of;
use crate::rectify::encounters::{Encounter, Meeting};
use crate::rectify::face::coincides;
use crate::rectify::tolerance;
use crate::scene::{MediumId, ObjectId, Scene};
use crate::tracking::priority::Priority;
use crate::tracking::rectified::Rectified;
use crate::tracking::{Crossing, Sides, Tracker};
use crate::tracking::{Events, Prepared};

/// Pairs of objects that are looked at, and points of each.
const MOST_PAIRS: usize = 500;
const POINTS: u32 = 32;

/// One finding for the whole scene.
pub(super) fn problems(prepared: &Prepared, encounters: &[Encounter]) -> Option<Problem> {
    let scene = &*prepared.scene;
    let touching: Vec<(ObjectId, ObjectId)> = (encounters.iter())
        .filter(|encounter| encounter.meeting == Meeting::Touch)
        .map(|encounter| (encounter.a, encounter.b))
        .take(MOST_PAIRS)
        .collect();
    let wrong: Vec<(ObjectId, ObjectId)> =
        touching.into_par_iter().filter(|&(a, b)| is_wrong_between(prepared, a, b)).collect();
    let &(a, b) = wrong.first()?;
    let objects = distinct(wrong.iter().flat_map(|&(a, b)| [a, b]));
    let [a, b] = [a, b].map(|id| &scene.object(id).name);
    let more = match wrong.len() {
        1 => String::new(),
        count => format!(" (and {} more pairs)", count - 1),
    };
    Some(Problem::advice(
        names::place_of(scene, &objects),
        "flush_in_priority",
        format!(
            "`{a}` and `{b}`{more} have faces that lie exactly on each other. `rectified` is right there, but the mode `priority` may meet the \
             two in the wrong order or miss one, and take one medium for another from there on. For `priority`, and for renderers that work \
             like it, let the volumes overlap a little and give one the higher priority"
        ),
    ))
}

/// Whether `priority` goes wrong somewhere where the surfaces of two refractors coincide.
fn is_wrong_between(prepared: &Prepared, a: ObjectId, b: ObjectId) -> bool {
    let scene = &*prepared.scene;
    let geometry = &*scene.geometry;
    // Points of the smaller one: more of it lies on the other.
    let (subject, other) = if geometry.area(a.0) <= geometry.area(b.0) { (a, b) } else { (b, a) };
    let priority = Priority { scene };
    let rectified = Rectified { scene, table: &prepared.table };
    samples::of_surface(geometry, subject.0, 0..POINTS).filter(|(point, _)| is_on(prepared, point, other)).any(
        |(point, slant)| {
            // Not along the normal, which might run in other surfaces.
            let direction = (point.normal + 0.2 * slant).normalize_or(point.normal);
            [direction, -direction].into_iter().any(|direction| {
                let [seen, right] =
                    [walk(scene, &priority, &point, direction), walk(scene, &rectified, &point, direction)];
                // What goes wrong earlier has another reason, such as a tie.
                seen.before == right.before && (seen.after != right.after || seen.interfaces > right.interfaces)
            })
        },
    )
}

/// Whether the surface of `other` lies at a point of another one.
fn is_on(prepared: &Prepared, point: &SurfacePoint, other: ObjectId) -> bool {
    let geometry = &*prepared.scene.geometry;
    let mut is_on = false;
    let reach = DVec3::splat(tolerance::largest(geometry, geometry.object_of(point.primitive)));
    geometry.for_each_near_box(point.position - reach, point.position + reach, None, |primitive| {
        is_on |= geometry.object_of(primitive) == other.0
            && coincides(geometry, point.primitive, primitive).is_some()
            && geometry.distance(primitive, point.position) <= reach.x;
    });
    is_on
}

/// What a mode sees on a straight line.
#[derive(Debug, PartialEq)]
struct Walk {
    /// The media before and after the point.
    before: MediumId,
    after: MediumId,
    /// Interfaces at the point itself.
    interfaces: u32,
}

/// Goes straight through `point` from outside of everything, and otherwise as paths go: from an interface a new ray sets out. Opaque objects
/// are no obstacle.
fn walk<T: Tracker>(scene: &Scene, tracker: &T, point: &SurfacePoint, direction: DVec3) -> Walk {
    let geometry = &*scene.geometry;
    let reach = tolerance::largest(geometry, geometry.object_of(point.primitive));
    let back = geometry.bounding_sphere().map_or(0.0, |s| 2.0 * s.radius) + 1.0;
    let start = point.position - direction * back;
    let mut ray = Ray::new(start, direction);
    let (mut state, mut events) = (T::State::default(), Events::default());
    tracker.start(&mut state);
    let mut walk = Walk { before: MediumId::WORLD, after: MediumId::WORLD, interfaces: 0 };
    while let Some(hit) = geometry.closest(&ray) {
        let refractor = ObjectId(geometry.object_of(hit.primitive));
        let place = geometry.surface(&ray, &hit);
        let distance = (place.position - start).dot(direction) - back;
        if distance > reach {
            break;
        }
        let beyond = ray.beyond(&hit);
        if !scene.is_refractor(refractor) {
            ray = beyond;
            continue;
        }
        let interior = medium_of(scene, Some(refractor));
        let crossing =
            Crossing { refractor, interior, is_entering: hit.is_front, point: place, barycentric: hit.barycentric };
        let sides = tracker.sides(&state, &crossing, &mut events).filter(|sides| sides.from != sides.to);
        tracker.transmit(&mut state, &crossing);
        ray = match sides {
            Some(Sides { to, .. }) => {
                walk.after = to;
                if distance < -reach {
                    walk.before = to;
                } else {
                    walk.interfaces += 1;
                }
                Ray::leaving(place.position, direction, hit.primitive)
            }
            None => beyond,
        };
    }
    walk
}
