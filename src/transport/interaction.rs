//! What a ray meets in a scene in which some tracker knows the media: worked out here, once, for every kind of path.

use glam::DVec3;

use crate::geometry::ray::NO_PRIMITIVE;
use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::rectify::containment::medium_of;
use crate::scatter::{Dielectric, Lambert, Mirror, Normals, Scattering};
use crate::scene::{MediumId, ObjectId, Scene, SceneNeeds, Surface};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::tracking::{Crossing, Events, Sides, Tracker};

/// Roundings of f64, of the numbers that a hit is computed from, that two hits of one place differ by at the most.
const ROUNDINGS: f64 = 64.0;

/// A scene with a tracker at work in it, and what is to be looked at.
#[derive(Debug)]
pub struct TrackedScene<'a, T> {
    pub scene: &'a Scene,
    pub tracker: &'a T,
    pub needs: SceneNeeds,
}

impl<T> Clone for TrackedScene<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for TrackedScene<'_, T> {}

/// Where a path is: what decides, beside the ray, what it meets.
#[derive(Debug, Clone, Copy)]
pub struct Traveller<'a, S> {
    /// The tracker's state.
    pub state: &'a S,
    /// What the path is in.
    pub medium: MediumId,
    /// Number of the segment that the ray is, from 1.
    pub segment: u32,
    pub wavelengths: Wavelengths,
}

/// What a ray meets first.
#[derive(Debug)]
pub enum Interaction {
    /// Nothing, and the ray leaves the scene: light of the environment, to which that of [`TrackedScene::suns`] comes.
    Escapes { radiance: Spectrum },
    /// A light, whose outward side is met if `hit` is in front; there the path ends. See [`Scene::emits`].
    Emits { light: ObjectId, radiance: Spectrum, hit: Hit },
    /// A refractor's surface that does not bend light, or that the tracker skips. `ray` goes on behind it.
    Passes { ray: Ray, crossing: Crossing, sides: Option<Sides> },
    /// An edge at which rounding shows hits that are no crossings. `ray` goes on behind them, and the tracker must not hear of them.
    Grazes { ray: Ray },
    /// A surface that turns the path.
    Scatters(Vertex),
}

/// A place at which a path turns.
#[derive(Debug)]
pub struct Vertex {
    pub object: ObjectId,
    pub point: SurfacePoint,
    /// On the side that the path comes from.
    pub normals: Normals,
    pub scattering: Scattering,
    /// Of a refractor: what the path has to cross to get through, and the media on both sides.
    pub crossing: Option<(Crossing, Sides)>,
}

impl<T: Tracker> TrackedScene<'_, T> {
    /// Works out what `ray` meets, given what it hits first, and counts in `events` a crossing that leaves another medium than the path's.
    // Not inlined, a vertex of 300 bytes would go through memory: 4 % of the time of a scene without shadow rays.
    #[inline(always)]
    pub fn interaction(
        &self,
        ray: &Ray,
        hit: Option<&Hit>,
        traveller: &Traveller<'_, T::State>,
        events: &mut Events,
    ) -> Interaction {
        let scene = self.scene;
        let Some(hit) = hit else {
            return Interaction::Escapes { radiance: scene.environment.radiance(ray.direction) };
        };
        let object = ObjectId(scene.geometry.object_of(hit.primitive));
        let (scattering, point, smooth, crossing) = match scene.object(object).surface {
            Surface::Light { radiance, .. } => {
                return Interaction::Emits { light: object, radiance, hit: *hit };
            }
            Surface::Refractor { smooth, .. } => {
                events.crossings += 1;
                let (crossing, sides) = self.ask(ray, hit, traveller.state, events);
                if let Some(sides) = sides
                    && !scene.is_consistent(traveller.medium, sides.from)
                {
                    if let Some(ray) = self.behind_edge(ray, hit, traveller, sides) {
                        return Interaction::Grazes { ray };
                    }
                    events.inconsistent += 1;
                }
                let bent = sides
                    .map(|sides| (sides, scene.interface(sides.from, sides.to, traveller.wavelengths)))
                    .filter(|(_, interface)| !interface.is_matched());
                let Some((sides, interface)) = bent else {
                    return Interaction::Passes { ray: ray.beyond(hit), crossing, sides };
                };
                let dielectric = Dielectric { interface, segment: traveller.segment };
                (Scattering::Dielectric(dielectric), crossing.point, smooth, Some((crossing, sides)))
            }
            Surface::Diffuse { ref albedo, smooth } => {
                let point = scene.geometry.surface(ray, hit);
                let albedo = albedo.at(hit, &point);
                (Scattering::Lambert(Lambert { albedo }), point, smooth, None)
            }
            Surface::Mirror { ref albedo, smooth } => {
                let point = scene.geometry.surface(ray, hit);
                let albedo = albedo.at(hit, &point);
                (Scattering::Mirror(Mirror { albedo }), point, smooth, None)
            }
        };
        let normals = self.normals(hit, &point, smooth);
        Interaction::Scatters(Vertex { object, point, normals, scattering, crossing })
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

    /// At an edge or a corner a ray may meet several faces in one place, and rounding can report the exit before the entry. Such a hit, which
    /// does not leave the medium that the path is in, is skipped in two cases: the path has just met the same surface in the same place, or
    /// the next hit in that place leaves that medium and cancels this one. Then gives the ray behind what is skipped.
    #[cold]
    fn behind_edge(&self, ray: &Ray, hit: &Hit, traveller: &Traveller<'_, T::State>, sides: Sides) -> Option<Ray> {
        let (geometry, medium) = (&self.scene.geometry, traveller.medium);
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
        if !self.scene.is_refractor(ObjectId(geometry.object_of(next.primitive))) {
            return None;
        }
        let (_, next_sides) = self.ask(ray, &next, traveller.state, &mut Events::default());
        let undone = Sides { from: medium, to: sides.from };
        (next_sides == Some(undone)).then(|| ray.beyond(&next))
    }

    /// The first surface that a ray meets and that may matter to the tracker.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        match self.tracker.mask() {
            Some(mask) => self.scene.geometry.closest_but(ray, mask),
            None => self.scene.geometry.closest(ray),
        }
    }

    /// The same for each ray.
    #[inline]
    pub fn closest_many(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        hits.resize(rays.len(), None);
        match self.tracker.mask() {
            Some(mask) => self.scene.geometry.closest_many_but(rays, mask, hits),
            None => self.scene.geometry.closest_many(rays, hits),
        }
    }

    /// What is left of light after the part of `ray` from its start to `t`.
    #[inline]
    pub fn transmittance(&self, medium: MediumId, ray: &Ray, t: f64) -> Spectrum {
        if !self.needs.absorption {
            return Spectrum::ONE;
        }
        let absorption = self.scene.medium(medium).absorption;
        if absorption.is_black() {
            return Spectrum::ONE;
        }
        let length = match self.scene.geometry.bounding_sphere() {
            // The global medium fills the bounding sphere and no more, or nothing would be left of the environment.
            Some(sphere) if medium == MediumId::WORLD => {
                let whole_line = Ray { t_min: 0.0, ..*ray };
                match sphere.intersect(&whole_line, false) {
                    [Some(enter), Some(leave)] => (t.min(leave) - ray.t_min.max(enter)).max(0.0),
                    _ => 0.0,
                }
            }
            _ => t - ray.t_min,
        };
        if length.is_finite() { absorption.transmittance(length) } else { Spectrum::ZERO }
    }

    /// The normals at a hit that scattering uses, on the side that the ray comes from.
    #[inline]
    fn normals(&self, hit: &Hit, point: &SurfacePoint, smooth: bool) -> Normals {
        let outward = if hit.is_front { 1.0 } else { -1.0 };
        let face = point.normal * outward;
        if smooth && self.needs.smooth_normals {
            Normals { face, shading: self.scene.geometry.shading_normal(hit, point.normal) * outward }
        } else {
            Normals::flat(face)
        }
    }
}

impl Vertex {
    /// The ray that leaves this place along unit `direction`.
    #[inline]
    pub fn leave(&self, direction: DVec3) -> Ray {
        Ray::leaving(self.point.position, direction, self.point.primitive)
    }
}
