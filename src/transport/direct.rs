//! Next-event estimation: light that is looked for where a path scatters.

use glam::DVec3;

use super::dimension;
use super::interaction::{TrackedScene, Traveller, Vertex};
use super::sampler::Sampler;
use crate::geometry::SurfacePoint;
use crate::scatter::Transport;
use crate::scene::ObjectId;
use crate::scene::lights::{DirectSample, Target};
use crate::spectrum::Spectrum;
use crate::tracking::Tracker;

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
        let Some(arrival) = self.connect_from(vertex, sample.direction, sample.target.into(), traveller, shadow) else {
            return Spectrum::ZERO;
        };
        let weight = match sample.is_delta {
            true => 1.0,
            false => power_heuristic(sample.pdf, scattering.pdf(normals, wo, sample.direction)),
        };
        sample.radiance * arrival.transmittance * scattered * (weight / sample.pdf)
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
