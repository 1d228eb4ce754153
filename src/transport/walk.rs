//! A subpath of bidirectional transport, from the camera or from a light, on its way from vertex to vertex.

use glam::DVec3;

use super::dimension;
use super::interaction::{Interaction, TrackedScene, Traveller, Vertex};
use super::roulette::Roulette;
use super::sampler::Sampler;
use super::weights::{Merges, Weights};
use crate::geometry::{Hit, Ray};
use crate::rectify::start::Start;
use crate::scatter::{Choice, Scattering, Transport};
use crate::scene::{MediumId, ObjectId};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::tracking::{Events, Tracker};

/// A subpath.
#[derive(Debug, Clone)]
pub struct Walk<S> {
    pub ray: Ray,
    pub sampler: Sampler,
    pub medium: MediumId,
    pub state: S,
    /// The number of the segment that `ray` is, from 1.
    pub segment: u32,
    /// Without `radiance_scale`.
    pub throughput: Spectrum,
    /// The product of (n_from/n_to)² at transmissions; 1 on subpaths from lights.
    pub radiance_scale: f64,
    pub weights: Weights,
    /// Where it last scattered by a density that others compete with, which is that density.
    pub last: Option<(DVec3, f64)>,
    transport: Transport,
    roulette: Roulette,
    has_scattered: bool,
}

/// What a subpath comes to.
#[derive(Debug)]
pub enum Met {
    /// It leaves the scene.
    Escapes { radiance: Spectrum },
    /// A light.
    Emits { light: ObjectId, radiance: Spectrum, hit: Hit },
    /// A surface that turns it.
    Scatters(Vertex),
}

impl<S: Clone + Default> Walk<S> {
    /// One that starts as `start` says (local coordinates).
    pub fn new<T: Tracker<State = S>>(tracker: &T, start: &Start, sampler: Sampler, transport: Transport) -> Self {
        let mut state = S::default();
        tracker.start(&mut state);
        Self {
            ray: start.ray,
            sampler,
            medium: start.medium,
            state,
            segment: 1,
            throughput: Spectrum::ONE,
            radiance_scale: 1.0,
            weights: Weights::default(),
            last: None,
            transport,
            roulette: Roulette::default(),
            has_scattered: false,
        }
    }

    pub fn traveller(&self) -> Traveller<'_, S> {
        Traveller { state: &self.state, medium: self.medium, segment: self.segment, wavelengths: Wavelengths::Rgb }
    }

    /// Whether what it has left last was a mirror or an interface.
    pub fn comes_from_delta(&self) -> bool {
        self.segment > 1 && self.last.is_none()
    }

    /// The random dimensions of its segment.
    pub fn dimensions(&self) -> u32 {
        dimension::of_segment(self.segment)
    }

    /// Follows its ray to what turns or ends it. The weights stay as they were when it left.
    pub fn meet<T: Tracker<State = S>>(&mut self, tracked: &TrackedScene<'_, T>, events: &mut Events) -> Met {
        loop {
            let hit = tracked.closest(&self.ray);
            let t = hit.as_ref().map_or(f64::INFINITY, |hit| hit.t);
            self.throughput *= tracked.transmittance(self.medium, &self.ray, t);
            match tracked.interaction(&self.ray, hit.as_ref(), &self.traveller(), events) {
                Interaction::Escapes { radiance } => return Met::Escapes { radiance },
                Interaction::Emits { light, radiance, hit } => return Met::Emits { light, radiance, hit },
                Interaction::Grazes { ray } => self.ray = ray,
                Interaction::Passes { ray, crossing, sides } => {
                    tracked.tracker.transmit(&mut self.state, &crossing);
                    self.medium = sides.map_or(self.medium, |sides| sides.to);
                    self.ray = ray;
                }
                Interaction::Scatters(vertex) => return Met::Scatters(vertex),
            }
        }
    }

    /// Goes on from `vertex`. `false` where it ends.
    pub fn leave<T: Tracker<State = S>>(&mut self, tracker: &T, vertex: &Vertex, merges: Merges) -> bool {
        let dimensions = self.dimensions();
        let Some(survival) = self.roulette.survival(self.throughput, self.segment + 1, &self.sampler, dimensions)
        else {
            return false;
        };
        self.throughput /= survival;
        let Vertex { normals, scattering, .. } = vertex;
        let choice = match vertex.crossing {
            Some(_) => Choice::Sample(self.sampler.get_1d(dimensions + dimension::SCATTER)),
            None => Choice::Reflect,
        };
        let wo = -self.ray.direction;
        let u = || self.sampler.get_2d(dimensions + dimension::DIRECTION);
        let sampled = scattering.sample(normals, wo, choice, u, self.transport);
        if sampled.weight.is_black() {
            return false;
        }
        let [cosine_in, cosine_out] = [wo, sampled.wi].map(|direction| direction.dot(normals.face).abs());
        if scattering.is_delta() {
            let solid_angle_ratio = match scattering {
                // dω_out/dω_in at the reversed path.
                Scattering::Dielectric(dielectric) if sampled.is_transmitted => {
                    dielectric.interface.radiance_factor() * cosine_in / cosine_out
                }
                _ => 1.0,
            };
            self.weights.scatter_delta(cosine_out, solid_angle_ratio);
            self.last = None;
        } else {
            let reverse = scattering.pdf(normals, sampled.wi, wo);
            self.weights.scatter(cosine_out, sampled.pdf, reverse, merges);
            self.last = Some((vertex.point.position, sampled.pdf));
        }
        self.throughput *= sampled.weight;
        self.radiance_scale *= sampled.radiance_scale;
        if sampled.is_transmitted
            && let Some((crossing, sides)) = &vertex.crossing
        {
            tracker.transmit(&mut self.state, crossing);
            self.medium = sides.to;
        }
        if !self.has_scattered && !scattering.is_delta() {
            self.roulette = Roulette::after_first_scatter(self.throughput.max_component());
            self.has_scattered = true;
        }
        self.segment += 1;
        self.ray = vertex.leave(sampled.wi);
        true
    }
}
