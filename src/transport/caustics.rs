//! How noisy light that lamps throw through interfaces and off mirrors would be for paths from the camera alone, which meet the lamp by chance.
//!
//! Of one sample of such a path, the second moment is the integral of f²/p, where f is what the path brings and p its density. Subpaths
//! from lights find the same paths, and know the density with which the camera's would find them ([`super::weights`]): so a few of them
//! tell what those that have not been found yet would do to the image.

use glam::DVec2;
use rayon::prelude::*;

use super::bidirectional::{Bidirectional, Iteration, LightPaths, LightVertex};
use super::photon_map::{Photon, PhotonMap};
use super::sampler::Sampler;
use super::walk::{Met, Walk};
use super::weights::{Merges, Weights};
use crate::geometry::Ray;
use crate::scatter::Transport;
use crate::tracking::{Events, Tracker};

/// Interfaces on the way from the camera to what it sees, at the most.
const MOST_SEGMENTS: u32 = 64;
/// Added to squared radiance where an error is taken relative to it, as in relMSE.
const DARK: f64 = 0.01;

/// What paths from the camera would make of caustics.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CausticNoise {
    /// Variance of a sample relative to the radiance of its pixel, mean over the image, that caustics alone bring.
    pub variance: f64,
    /// Share of the image's light that they can never find, as its light is too small to be met.
    pub missed: f64,
}

impl<T: Tracker> Bidirectional<'_, T> {
    /// Estimates it. `radiance` is that of the image's pixels, mean over the bands, as paths from the camera see it. Runs on rayon's current pool.
    pub fn caustic_noise(&self, radiance: &[f64]) -> CausticNoise {
        let iteration = self.iteration(0);
        let Some(radius) = iteration.radius.filter(|_| self.light_paths > 0) else { return CausticNoise::default() };
        let lit: Vec<LightVertex> = (0..self.light_paths)
            .into_par_iter()
            .map_init(T::State::default, |room, number| {
                let mut paths = LightPaths::default();
                self.trace_light(&iteration, number, &mut paths, room);
                paths.vertices.first().copied().filter(LightVertex::can_merge)
            })
            .flatten()
            .collect();
        let photons: Vec<Photon> = lit.iter().map(LightVertex::photon).collect();
        let map = PhotonMap::new(radius, &photons);
        let [width, _] = self.size;
        let sums = (radiance.par_iter().enumerate())
            .map(|(pixel, radiance)| {
                let (column, row) = (pixel as u32 % width, pixel as u32 / width);
                let (moment, missed) = self.caustics_at(&iteration, [column, row], &map);
                [moment / (radiance * radiance + DARK), missed, *radiance]
            })
            .reduce(|| [0.0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
        let [variance, missed, all] = sums;
        let missed = if missed > 0.0 { missed / (missed + all) } else { 0.0 };
        CausticNoise { variance: variance / radiance.len().max(1) as f64, missed }
    }

    /// The second moment of what a sample of a pixel may find, and the mean of what it cannot.
    fn caustics_at(&self, iteration: &Iteration, [column, row]: [u32; 2], map: &PhotonMap) -> (f64, f64) {
        let nothing = (0.0, 0.0);
        let [width, height] = self.size.map(f64::from);
        let at = [f64::from(column) + 0.5, f64::from(row) + 0.5].into();
        let ray: Ray = self.camera.ray(at, [width, height].into(), DVec2::ZERO);
        let start = self.lens.start_by_asking(self.tracked.scene, ray, self.ask);
        let sampler = Sampler::of(self.sequence, self.seed, row * self.size[0] + column, 0);
        let mut walk = Walk::new(self.tracked.tracker, &start, sampler, Transport::Radiance);
        loop {
            let Met::Scatters(vertex) = walk.meet(&self.tracked, &mut Events::default()) else { return nothing };
            if !vertex.scattering.is_delta() {
                let wo = -walk.ray.direction;
                let scale = walk.throughput.sum() / 3.0 * walk.radiance_scale;
                let per_area = self.merges(iteration, vertex.point.position);
                let (mut moment, mut missed) = nothing;
                map.for_each_near(vertex.point.position, |photon| {
                    let cosine = photon.wo.dot(vertex.normals.face);
                    if cosine <= 0.0 {
                        return;
                    }
                    let scattered = vertex.scattering.evaluate(&vertex.normals, wo, photon.wo, Transport::Radiance);
                    let brought = scale * (photon.flux * scattered).sum() / (3.0 * cosine);
                    let density =
                        vertex.scattering.pdf(&vertex.normals, wo, photon.wo) * density_ratio(&photon.weights);
                    if density > 0.0 {
                        moment += brought * brought / (density * per_area);
                    } else {
                        missed += brought / per_area;
                    }
                });
                return (moment, missed);
            }
            if walk.segment >= MOST_SEGMENTS || !walk.leave(self.tracked.tracker, &vertex, Merges::Here(0.0)) {
                return nothing;
            }
        }
    }
}

/// The density with which a path from the camera, that goes on in the direction that the light came from, meets the light, over that of the
/// subpath from the light; without the density of that direction.
fn density_ratio(weights: &Weights) -> f64 {
    weights.earlier.sqrt()
}
