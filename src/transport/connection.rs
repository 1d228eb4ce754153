//! Whether light goes straight from one place of a path to another, and in which medium it arrives.

use glam::DVec3;

use super::interaction::{Interaction, TrackedScene, Traveller, Vertex};
use crate::geometry::{Geometry, Hit, PrimitiveId, Ray, SurfacePoint};
use crate::scene::lights::Target;
use crate::scene::{MediumId, ObjectId};
use crate::spectrum::Spectrum;
use crate::tracking::{Events, Tracker};

/// What a connecting ray has to arrive at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// This primitive.
    Surface(PrimitiveId),
    /// A place in space, at this distance along the ray.
    Point(f64),
    /// Nothing at all: the ray escapes.
    Escape,
}

impl From<Target> for End {
    fn from(target: Target) -> Self {
        match target {
            Target::Surface { primitive, .. } => Self::Surface(primitive),
            Target::Environment => Self::Escape,
            Target::Point { distance } => Self::Point(distance),
        }
    }
}

/// How light arrives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// What is left of it on the way.
    pub transmittance: Spectrum,
    /// The medium that it arrives in.
    pub medium: MediumId,
    /// What has met the end, and where, if it is on a surface.
    hit: Option<(Ray, Hit)>,
}

impl Arrival {
    /// The place on a surface.
    pub fn point(&self, geometry: &Geometry) -> Option<SurfacePoint> {
        self.hit.map(|(ray, hit)| geometry.surface(&ray, &hit))
    }
}

impl<T: Tracker> TrackedScene<'_, T> {
    /// [`Self::connect`] along unit `direction` from `vertex`, which `traveller` has come to.
    #[inline]
    pub fn connect_from(
        &self,
        vertex: &Vertex,
        direction: DVec3,
        end: End,
        traveller: &Traveller<'_, T::State>,
        room: &mut T::State,
    ) -> Option<Arrival> {
        let ray = vertex.leave(direction);
        match &vertex.crossing {
            // Behind a refractor's surface, if its scattering function sends light there.
            Some((crossing, sides)) if direction.dot(vertex.normals.face) < 0.0 => {
                let mut state = traveller.state.clone();
                self.tracker.transmit(&mut state, crossing);
                self.connect(ray, end, &Traveller { state: &state, medium: sides.to, ..*traveller }, room)
            }
            _ => self.connect(ray, end, traveller, room),
        }
    }

    /// Follows `ray` to its `end` through surfaces that do not bend light and those that the mode skips; `None` when something else is in the way.
    /// `traveller` is a path that is about to go along `ray`, and `room` is for its state. No events are counted.
    #[inline]
    pub fn connect(
        &self,
        mut ray: Ray,
        end: End,
        traveller: &Traveller<'_, T::State>,
        room: &mut T::State,
    ) -> Option<Arrival> {
        let scene = self.scene;
        let mut medium = traveller.medium;
        // Whether the ray may pass through a refractor unbent, and so must look at each one it meets.
        let can_pass = self.needs.index_matching || self.tracker.can_skip();
        let arrive = |transmittance: Spectrum, medium, ray: &Ray, t| {
            let transmittance = transmittance * self.transmittance(medium, ray, t);
            Some(Arrival { transmittance, medium, hit: None })
        };
        let reach = match end {
            End::Escape => Some(f64::INFINITY),
            End::Point(distance) => Some(distance),
            End::Surface(_) => None,
        };
        if let Some(reach) = reach
            && !can_pass
        {
            let is_blocked = match self.tracker.mask() {
                Some(mask) => scene.geometry.is_occluded_but(&ray, reach, mask),
                None => scene.geometry.is_occluded(&ray, reach),
            };
            return if is_blocked { None } else { arrive(Spectrum::ONE, medium, &ray, reach) };
        }
        let mut has_state = false;
        let mut transmittance = Spectrum::ONE;
        loop {
            let hit = self.closest(&ray).filter(|hit| reach.is_none_or(|reach| hit.t < reach));
            let Some(hit) = hit else {
                return reach.and_then(|reach| arrive(transmittance, medium, &ray, reach));
            };
            if end == End::Surface(hit.primitive) {
                let arrival = arrive(transmittance, medium, &ray, hit.t);
                return arrival.map(|arrival| Arrival { hit: Some((ray, hit)), ..arrival });
            }
            if !can_pass || !scene.is_refractor(ObjectId(scene.geometry.object_of(hit.primitive))) {
                return None;
            }
            transmittance *= self.transmittance(medium, &ray, hit.t);
            if !has_state {
                room.clone_from(traveller.state);
                has_state = true;
            }
            let here = Traveller { state: &*room, medium, ..*traveller };
            match self.interaction(&ray, Some(&hit), &here, &mut Events::default()) {
                Interaction::Grazes { ray: behind } => ray = behind,
                Interaction::Passes { ray: behind, crossing, sides } => {
                    medium = sides.map_or(medium, |sides| sides.to);
                    self.tracker.transmit(room, &crossing);
                    ray = behind;
                }
                Interaction::Escapes { .. } | Interaction::Emits { .. } | Interaction::Scatters(_) => return None,
            }
        }
    }
}
