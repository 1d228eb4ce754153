//! Next-event estimation: light that is looked for where a path scatters.

use glam::DVec3;

use super::dimension;
use super::interaction::{Interaction, TrackedScene, Traveller, Vertex};
use super::sampler::Sampler;
use crate::geometry::SurfacePoint;
use crate::scatter::Transport;
use crate::scene::ObjectId;
use crate::scene::lights::{DirectSample, Target};
use crate::spectrum::Spectrum;
use crate::tracking::{Events, Tracker};

impl<T: Tracker> TrackedScene<'_, T> {
    /// Light that reaches `vertex` directly and leaves it along `wo`, by sampling lights. `traveller` is the path before the vertex, and `shadow`
    /// room for the state of shadow rays. Random numbers are those of the segment that begins at `dimensions`.
    #[inline]
    pub(super) fn direct(
        &self,
        vertex: &Vertex,
        wo: DVec3,
        traveller: &Traveller<'_, T::State>,
        dimensions: u32,
        sampler: &Sampler,
        shadow: &mut T::State,
    ) -> Spectrum {
        let scene = self.scene;
        let mut radiance = Spectrum::ZERO;
        // The environment and the emitters are each asked: a choice between them would waste half of the samples where only one is seen.
        if self.needs.image_environment {
            let u = sampler.get_2d(dimensions + dimension::ENVIRONMENT);
            if let Some((direction, pdf)) = scene.environment.sample_direction(u) {
                // What is not seen is not looked up.
                let (target, is_delta) = (Target::Environment, false);
                let sample = DirectSample { direction, pdf, radiance: Spectrum::ONE, is_delta, target };
                let share = self.direct_from(&sample, vertex, wo, traveller, shadow);
                if !share.is_black() {
                    radiance += scene.environment.radiance(direction) * share;
                }
            }
        }
        if self.needs.emitters {
            let select = sampler.get_1d(dimensions + dimension::EMITTER_CHOICE);
            let u = sampler.get_2d(dimensions + dimension::EMITTER);
            if let Some(sample) = scene.emitters.sample_direct(&scene.geometry, vertex.point.position, select, u) {
                radiance += self.direct_from(&sample, vertex, wo, traveller, shadow);
            }
        }
        radiance
    }

    /// The share of one sampled direction.
    #[inline]
    fn direct_from(
        &self,
        sample: &DirectSample,
        vertex: &Vertex,
        wo: DVec3,
        traveller: &Traveller<'_, T::State>,
        shadow: &mut T::State,
    ) -> Spectrum {
        let Vertex { normals, scattering, .. } = vertex;
        let scattered = scattering.evaluate(normals, wo, sample.direction, Transport::Radiance);
        if scattered.is_black() {
            return Spectrum::ZERO;
        }
        let Some(transmittance) = self.visibility(vertex, sample, traveller, shadow) else { return Spectrum::ZERO };
        let weight = match sample.is_delta {
            true => 1.0,
            false => power_heuristic(sample.pdf, scattering.pdf(normals, wo, sample.direction)),
        };
        sample.radiance * transmittance * scattered * (weight / sample.pdf)
    }

    /// Transmittance from `vertex` to the light that was sampled, through surfaces that do not bend light and those that the mode skips; `None`
    /// when something else is in the way.
    #[inline]
    fn visibility(
        &self,
        vertex: &Vertex,
        sample: &DirectSample,
        traveller: &Traveller<'_, T::State>,
        shadow: &mut T::State,
    ) -> Option<Spectrum> {
        let scene = self.scene;
        let mut ray = vertex.leave(sample.direction);
        let mut medium = traveller.medium;
        let mut has_state = false;
        // Behind a refractor's surface, if its scattering function sends light there.
        if let Some((crossing, sides)) = &vertex.crossing
            && sample.direction.dot(vertex.normals.face) < 0.0
        {
            shadow.clone_from(traveller.state);
            self.tracker.transmit(shadow, crossing);
            (has_state, medium) = (true, sides.to);
        }
        // Whether the ray may pass through a refractor unbent, and so must look at each one it meets.
        let can_pass = self.needs.index_matching || self.tracker.can_skip();
        // How far nothing may be in the way; `None` to a surface, which is met itself.
        let open_to = match sample.target {
            Target::Environment => Some(f64::INFINITY),
            Target::Point { distance } => Some(distance),
            Target::Surface { .. } => None,
        };
        if let Some(distance) = open_to
            && !can_pass
        {
            let is_open = match self.tracker.mask() {
                Some(mask) => !scene.geometry.is_occluded_but(&ray, distance, mask),
                None => !scene.geometry.is_occluded(&ray, distance),
            };
            return is_open.then(|| self.transmittance(medium, &ray, distance));
        }
        let mut transmittance = Spectrum::ONE;
        loop {
            let hit = self.closest(&ray);
            if let Some(distance) = open_to
                && hit.is_none_or(|hit| hit.t >= distance)
            {
                return Some(transmittance * self.transmittance(medium, &ray, distance));
            }
            let hit = hit?;
            transmittance *= self.transmittance(medium, &ray, hit.t);
            let object = ObjectId(scene.geometry.object_of(hit.primitive));
            if let Target::Surface { object: target, primitive } = sample.target
                && target == object
            {
                return (hit.primitive == primitive && scene.emits(object, hit.is_front)).then_some(transmittance);
            }
            if !can_pass || !scene.is_refractor(object) {
                return None;
            }
            if !has_state {
                shadow.clone_from(traveller.state);
                has_state = true;
            }
            // Events are counted along camera paths only.
            let here = Traveller { state: &*shadow, medium, ..*traveller };
            match self.interaction(&ray, Some(&hit), &here, &mut Events::default()) {
                Interaction::Grazes { ray: behind } => ray = behind,
                Interaction::Passes { ray: behind, crossing, sides } => {
                    medium = sides.map_or(medium, |sides| sides.to);
                    self.tracker.transmit(shadow, &crossing);
                    ray = behind;
                }
                Interaction::Escapes { .. } | Interaction::Emits { .. } | Interaction::Scatters(_) => return None,
            }
        }
    }

    /// Density per steradian with which the environment is sampled.
    #[inline]
    pub(super) fn environment_pdf(&self, direction: DVec3) -> f64 {
        if self.needs.image_environment { self.scene.environment.pdf(direction) } else { 0.0 }
    }

    /// Radiance of the suns, which a ray sees that escapes along `direction`. `scattered` is the density with which the path was scattered there, if
    /// light sampling competes with that.
    pub(super) fn suns(&self, direction: DVec3, scattered: Option<f64>) -> Spectrum {
        let mut radiance = Spectrum::ZERO;
        for (sun, probability) in self.scene.emitters.suns().filter(|(sun, _)| sun.is_seen(direction)) {
            let sampled = if self.needs.emitters { probability * sun.pdf_direct(direction) } else { 0.0 };
            radiance += sun.disc_radiance() * scattered.map_or(1.0, |pdf| power_heuristic(pdf, sampled));
        }
        radiance
    }

    /// Density per steradian with which emitters are sampled in the `direction` from `from` to `point` of `object`.
    #[inline]
    pub(super) fn emitter_pdf(&self, from: DVec3, direction: DVec3, object: ObjectId, point: &SurfacePoint) -> f64 {
        if !self.needs.emitters {
            return 0.0;
        }
        self.scene.emitters.pdf_direct(&self.scene.geometry, from, direction, object, point)
    }
}

/// Weight of a sample of density `pdf` against another way of density `other` (Veach 1997, section 9.2).
#[inline]
pub(super) fn power_heuristic(pdf: f64, other: f64) -> f64 {
    pdf * pdf / (pdf * pdf + other * other)
}
