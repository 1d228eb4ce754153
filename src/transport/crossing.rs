//! Refractors' surfaces in a path's way: what the tracker says of them, and whether it fits the medium that the path is in.

use super::path::PathTracer;
use crate::geometry::ray::NO_PRIMITIVE;
use crate::geometry::{Hit, Ray};
use crate::optics::Interface;
use crate::rectify::containment::medium_of;
use crate::scene::{MediumId, ObjectId, Surface};
use crate::tracking::Events;
use crate::tracking::{Crossing, Sides, Tracker};

/// Roundings of f64, of the numbers that a hit is computed from, that two hits of one place differ by at the most.
const ROUNDINGS: f64 = 64.0;

/// A crossing with all that is known of it.
pub(super) struct Met {
    pub crossing: Crossing,
    /// `None`: the tracker skips it.
    pub interface: Option<(Sides, Interface)>,
}

impl<T: Tracker> PathTracer<'_, T> {
    /// Asks the tracker about a hit of a refractor by a path in `medium`, and counts a crossing that leaves another one. An error is the ray
    /// with which the path goes straight on: what it met is no crossing, and the tracker must not hear of it.
    #[inline]
    pub(super) fn meet(
        &self,
        ray: &Ray,
        hit: &Hit,
        state: &T::State,
        medium: MediumId,
        events: &mut Events,
    ) -> Result<Met, Ray> {
        events.crossings += 1;
        let (crossing, sides) = self.ask(ray, hit, state, events);
        if let Some(sides) = sides
            && !self.scene.is_consistent(medium, sides.from)
        {
            if let Some(behind) = self.behind_edge(ray, hit, medium, sides, state) {
                return Err(behind);
            }
            events.inconsistent += 1;
        }
        let interface = sides.map(|s| (s, self.scene.interface(s.from, s.to)));
        Ok(Met { crossing, interface })
    }

    /// What the tracker says about a hit of a refractor.
    #[inline]
    fn ask(&self, ray: &Ray, hit: &Hit, state: &T::State, events: &mut Events) -> (Crossing, Option<Sides>) {
        let scene = self.scene;
        let refractor = ObjectId(scene.geometry.object_of(hit.primitive));
        let interior = medium_of(scene, Some(refractor));
        let point = scene.geometry.surface(ray, hit);
        let crossing = Crossing { refractor, interior, is_entering: hit.is_front, point, barycentric: hit.barycentric };
        let sides = self.tracker.sides(state, &crossing, events);
        (crossing, sides)
    }

    /// At an edge or a corner a ray may meet several faces in one place. A crossing there that does not leave the `medium` that the path is in
    /// is none if the path has just come from that surface in that place, or if the next one does leave that medium, in the same place,
    /// and the two undo each other: the ray grazes the edge, and rounding shows the leaving first. Then gives the ray behind them.
    #[cold]
    fn behind_edge(&self, ray: &Ray, hit: &Hit, medium: MediumId, sides: Sides, state: &T::State) -> Option<Ray> {
        let geometry = &self.scene.geometry;
        let object = geometry.object_of(hit.primitive);
        let scale = ray.origin.abs().max_element() + hit.t + geometry.reach_of(object);
        let is_same_place = |from: f64, to: f64| to - from <= ROUNDINGS * f64::EPSILON * scale;
        let last = if ray.after == NO_PRIMITIVE { ray.from } else { ray.after };
        if last != NO_PRIMITIVE && geometry.object_of(last) == object && is_same_place(ray.t_min, hit.t) {
            return Some(ray.beyond(hit));
        }
        // Modes that are wrong come here often, and a search this short costs them little.
        let reach = hit.t + 2.0 * ROUNDINGS * f64::EPSILON * scale;
        if sides.to != medium || !geometry.is_occluded(&ray.beyond(hit), reach) {
            return None;
        }
        let next = self.closest(&ray.beyond(hit)).filter(|next| is_same_place(hit.t, next.t))?;
        let object = ObjectId(geometry.object_of(next.primitive));
        if !matches!(self.scene.object(object).surface, Surface::Refractor { .. }) {
            return None;
        }
        let (_, next_sides) = self.ask(ray, &next, state, &mut Events::default());
        let undone = Sides { from: medium, to: sides.from };
        (next_sides == Some(undone)).then(|| ray.beyond(&next))
    }
}
