//! Next-event estimation: light that is looked for at diffuse vertices.

use glam::DVec3;

use super::path::{PathTracer, dimension};
use super::sampler::Sampler;
use crate::geometry::{Ray, SurfacePoint};
use crate::scatter::diffuse;
use crate::scatter::normals::Normals;
use crate::scene::environment::DirectionSample;
use crate::scene::{MediumId, ObjectId, Surface};
use crate::tracking::Events;
use crate::tracking::Tracker;

/// A diffuse point that light is looked for at.
pub(super) struct Receiver<'a, S> {
    pub point: &'a SurfacePoint,
    /// On the side that the path came from.
    pub normals: Normals,
    /// What the path is in, and its tracker's state.
    pub medium: MediumId,
    pub state: &'a S,
}

impl<T: Tracker> PathTracer<'_, T> {
    /// Light that reaches a diffuse point directly, times 1/π and cosine: the albedo is the caller's.
    #[inline]
    pub(super) fn direct(
        &self,
        receiver: &Receiver<'_, T::State>,
        dimensions: u32,
        sampler: &Sampler,
        shadow: &mut T::State,
    ) -> DVec3 {
        let scene = self.scene;
        let mut radiance = DVec3::ZERO;
        // The environment and the emitters are each asked: a choice between them would waste half of the samples where only one is seen.
        if self.needs.image_environment {
            let u = sampler.get_2d(dimensions + dimension::ENVIRONMENT);
            if let Some(sample) = scene.environment.sample(u) {
                radiance += self.direct_from(None, &sample, receiver, shadow);
            }
        }
        if self.needs.emitters {
            let select = sampler.get_1d(dimensions + dimension::EMITTER_CHOICE);
            let u = sampler.get_2d(dimensions + dimension::EMITTER);
            if let Some((object, sample)) = scene.emitters.sample(&scene.geometry, receiver.point.position, select, u) {
                radiance += self.direct_from(Some(object), &sample, receiver, shadow);
            }
        }
        radiance
    }

    /// Light that reaches a diffuse point from the sampled direction of the emitter `target` (`None`: the environment).
    #[inline]
    fn direct_from(
        &self,
        target: Option<ObjectId>,
        sample: &DirectionSample,
        receiver: &Receiver<'_, T::State>,
        shadow: &mut T::State,
    ) -> DVec3 {
        let Receiver { point, normals, .. } = receiver;
        let scattered = diffuse::pdf(normals, sample.direction);
        if scattered <= 0.0 {
            return DVec3::ZERO;
        }
        let ray = Ray::leaving(point.position, sample.direction, point.primitive);
        let Some(transmittance) = self.visibility(ray, target, receiver, shadow) else { return DVec3::ZERO };
        let radiance = match target.map(|object| &self.scene.object(object).surface) {
            Some(Surface::Light { radiance }) => *radiance,
            _ => self.scene.environment.radiance(sample.direction),
        };
        let weight = power_heuristic(sample.pdf, scattered);
        radiance * transmittance * (scattered * weight / sample.pdf)
    }

    /// Transmittance from the ray's start to the light `target` (`None`: the environment), through surfaces that do not bend light
    /// and those that the mode skips; `None` when something else is in the way. Arriving at the very object needs no distance to compare with.
    #[inline]
    fn visibility(
        &self,
        mut ray: Ray,
        target: Option<ObjectId>,
        receiver: &Receiver<'_, T::State>,
        shadow: &mut T::State,
    ) -> Option<DVec3> {
        let mut medium = receiver.medium;
        let scene = self.scene;
        // Whether the ray may pass through a refractor unbent, and so must look at each one it meets.
        let can_pass = self.needs.index_matching || self.tracker.can_skip();
        if target.is_none() && !can_pass {
            let is_open = match self.tracker.mask() {
                Some(mask) => !scene.geometry.is_occluded_but(&ray, f64::INFINITY, mask),
                None => !scene.geometry.is_occluded(&ray, f64::INFINITY),
            };
            return is_open.then(|| self.transmittance(medium, &ray, f64::INFINITY));
        }
        let mut transmittance = DVec3::ONE;
        let mut has_state = false;
        loop {
            let Some(hit) = self.closest(&ray) else {
                return target.is_none().then(|| transmittance * self.transmittance(medium, &ray, f64::INFINITY));
            };
            transmittance *= self.transmittance(medium, &ray, hit.t);
            let object = ObjectId(scene.geometry.object_of(hit.primitive));
            if Some(object) == target {
                return hit.is_front.then_some(transmittance);
            }
            if !can_pass || !matches!(scene.object(object).surface, Surface::Refractor { .. }) {
                return None;
            }
            if !has_state {
                shadow.clone_from(receiver.state);
                has_state = true;
            }
            // Events are counted along camera paths only.
            let met = match self.meet(&ray, &hit, shadow, medium, &mut Events::default()) {
                Ok(met) => met,
                Err(behind) => {
                    ray = behind;
                    continue;
                }
            };
            if let Some((sides, interface)) = met.interface {
                if !interface.is_matched() {
                    return None;
                }
                medium = sides.to;
            }
            self.tracker.transmit(shadow, &met.crossing);
            ray = ray.beyond(&hit);
        }
    }

    #[inline]
    pub(super) fn environment_pdf(&self, direction: DVec3) -> f64 {
        if self.needs.image_environment { self.scene.environment.pdf(direction) } else { 0.0 }
    }

    #[inline]
    pub(super) fn emitter_pdf(&self, from: DVec3, direction: DVec3, object: ObjectId, point: &SurfacePoint) -> f64 {
        if !self.needs.emitters {
            return 0.0;
        }
        self.scene.emitters.pdf(&self.scene.geometry, from, direction, object, point)
    }
}

/// Weight of a sample of density `pdf` against another way of density `other`.
#[inline]
pub(super) fn power_heuristic(pdf: f64, other: f64) -> f64 {
    pdf * pdf / (pdf * pdf + other * other)
}
