//! The path tracer: samples of pixels, with any tracker.
//!
//! Paths advance in batches, a segment at a time: the rays of a batch are traced together, which hides the time that memory takes, and paths
//! that leave from the same pixel stay together for some segments.
//!
//! Light is gathered where a path meets it and, at diffuse vertices, by next-event estimation, both weighted by multiple importance
//! sampling (Veach 1997, chapter 9, power heuristic). Radiance is scaled by (n_from/n_to)² at every transmission (chapter 5), apart
//! from the throughput that Russian roulette looks at.

use glam::DVec3;

use super::dimension;
use super::direct::power_heuristic;
use super::interaction::{Interaction, TrackedScene, Traveller, Vertex};
use super::roulette::Roulette;
use super::sampler::Sampler;
use crate::geometry::{Hit, Ray};
use crate::rectify::start::Start;
use crate::scatter::{Choice, ScatterSample, Transport};
use crate::scene::MediumId;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::tracking::{Events, Tracker};

/// Least share of a path's light that is worth a path of its own: a branch of less is followed now and then, by chance.
const SPLIT_SHARE: f64 = 0.03;

/// What all samples of an image share.
#[derive(Debug, Clone, Copy)]
pub struct PathTracer<'a, T> {
    pub tracked: TrackedScene<'a, T>,
    /// Cap on segments; `u32::MAX` for none.
    pub max_depth: u32,
    /// How many interfaces from the camera on a path may split at, into one that is reflected and one that goes through.
    pub splits: u32,
}

/// Where the path last scattered by a density that light sampling competes with.
#[derive(Clone, Copy)]
struct LastScatter {
    position: DVec3,
    pdf: f64,
}

/// A path on its way, apart from its ray.
#[derive(Clone)]
struct Path<S> {
    sampler: Sampler,
    /// The path that this one is a branch of; its own number if it is none.
    root: u32,
    /// How many times it may still split.
    splits: u32,
    medium: MediumId,
    wavelengths: Wavelengths,
    /// Segments so far, the camera's first being one.
    segment: u32,
    /// Throughput, without the product of (n_from/n_to)², which is `radiance_scale`.
    beta: Spectrum,
    radiance_scale: f64,
    last: Option<LastScatter>,
    /// A branch's share counts as throughput: a small one is not followed for long.
    roulette: Roulette,
    has_scattered: bool,
    /// Product of the shares that it took where it split, in (0, 1].
    share: f64,
    radiance: Spectrum,
    state: S,
}

/// Paths that advance together. One worker reuses it from batch to batch.
pub struct Batch<S> {
    /// In the order in which they were added, then the branches that they split off. Those behind `used` are room for later ones.
    paths: Vec<Path<S>>,
    /// Paths that were added.
    count: usize,
    /// These and their branches.
    used: usize,
    /// The paths that have not ended, in order, and their rays.
    alive: Vec<u32>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// State of shadow rays.
    shadow: S,
    pub events: Events,
}

impl<S: Default> Default for Batch<S> {
    fn default() -> Self {
        Self {
            paths: Vec::new(),
            count: 0,
            used: 0,
            alive: Vec::new(),
            rays: Vec::new(),
            hits: Vec::new(),
            shadow: S::default(),
            events: Events::default(),
        }
    }
}

impl<S: Default> Batch<S> {
    /// Paths in a batch: enough for beams to form and to hide the time that memory takes; more bring little.
    pub const SIZE: usize = 256;

    pub fn is_full(&self) -> bool {
        self.count >= Self::SIZE
    }

    /// Adds a path that starts as `start` says (local coordinates).
    #[inline]
    pub fn add<T: Tracker<State = S>>(&mut self, start: &Start, sampler: Sampler, tracer: &PathTracer<'_, T>) {
        self.events.ambiguous += u64::from(start.is_ambiguous);
        let number = self.count as u32;
        self.alive.push(number);
        self.rays.push(start.ray);
        if self.count == self.paths.len() {
            self.paths.push(Path::new(number, sampler, start.medium));
        }
        let path = &mut self.paths[self.count];
        let state = std::mem::take(&mut path.state);
        *path = Path { state, splits: tracer.splits, ..Path::new(number, sampler, start.medium) };
        tracer.tracked.tracker.start(&mut path.state);
        self.count += 1;
        self.used = self.count;
    }

    /// Empties the batch; gives the radiance and the segments of each path that was added, its branches' included, in the order in which they were
    /// added.
    pub fn drain(&mut self) -> impl Iterator<Item = (Spectrum, u32)> + '_ {
        let count = std::mem::take(&mut self.count);
        let (roots, branches) = self.paths[..std::mem::take(&mut self.used)].split_at_mut(count);
        for branch in branches {
            let root = &mut roots[branch.root as usize];
            root.radiance += branch.radiance;
            root.segment += branch.segment;
        }
        self.alive.clear();
        self.rays.clear();
        roots.iter().map(|path| (path.radiance, path.segment))
    }
}

impl<S: Default> Path<S> {
    fn new(root: u32, sampler: Sampler, medium: MediumId) -> Self {
        Self {
            sampler,
            root,
            splits: 0,
            medium,
            wavelengths: Wavelengths::Rgb,
            segment: 1,
            beta: Spectrum::ONE,
            radiance_scale: 1.0,
            last: None,
            roulette: Roulette::default(),
            has_scattered: false,
            share: 1.0,
            radiance: Spectrum::ZERO,
            state: S::default(),
        }
    }
}

impl<T: Tracker> PathTracer<'_, T> {
    /// Follows the paths of `batch` to their ends.
    pub fn trace(&self, batch: &mut Batch<T::State>) {
        let Batch { paths, used, alive, rays, hits, shadow, events, .. } = batch;
        while !alive.is_empty() {
            self.tracked.closest_many(rays, hits);
            let mut kept = 0;
            let last = alive.len();
            for index in 0..last {
                let number = alive[index];
                let path = &mut paths[number as usize];
                let (ray, hit) = (rays[index], hits[index].as_ref());
                let mut branch = None;
                if let Some(next) = self.advance(path, &ray, hit, shadow, events, &mut branch) {
                    rays[kept] = next;
                    alive[kept] = number;
                    kept += 1;
                }
                if let Some((branch, ray)) = branch {
                    alive.push(*used as u32);
                    rays.push(ray);
                    if *used == paths.len() {
                        paths.push(branch);
                    } else {
                        paths[*used] = branch;
                    }
                    *used += 1;
                }
            }
            alive.drain(kept..last);
            rays.drain(kept..last);
        }
    }

    /// Takes a path to what its ray meets. Returns the ray that it goes on with; `None` where it ends.
    #[inline]
    fn advance(
        &self,
        path: &mut Path<T::State>,
        ray: &Ray,
        hit: Option<&Hit>,
        shadow: &mut T::State,
        events: &mut Events,
        branch: &mut Option<(Path<T::State>, Ray)>,
    ) -> Option<Ray> {
        let tracked = &self.tracked;
        path.beta *= tracked.transmittance(path.medium, ray, hit.map_or(f64::INFINITY, |hit| hit.t));
        let vertex = match tracked.interaction(ray, hit, &path.traveller(), events) {
            Interaction::Escapes { radiance } => {
                let weight = path.last.map_or(1.0, |l| power_heuristic(l.pdf, tracked.environment_pdf(ray.direction)));
                path.radiance += path.beta * radiance * (path.radiance_scale * weight);
                if tracked.scene.emitters.has_suns() {
                    let suns = tracked.suns(ray.direction, path.last.map(|l| l.pdf));
                    path.radiance += path.beta * suns * path.radiance_scale;
                }
                return None;
            }
            Interaction::Emits { light, radiance, hit } => {
                if tracked.scene.emits(light, hit.is_front) {
                    let weight = path.last.map_or(1.0, |l| {
                        let point = tracked.scene.geometry.surface(ray, &hit);
                        power_heuristic(l.pdf, tracked.emitter_pdf(l.position, ray.direction, light, &point))
                    });
                    path.radiance += path.beta * radiance * (path.radiance_scale * weight);
                }
                return None;
            }
            Interaction::Grazes { ray } => return Some(ray),
            // The same ray goes on; neither depth nor random numbers are used up.
            Interaction::Passes { ray, crossing, sides } => {
                tracked.tracker.transmit(&mut path.state, &crossing);
                path.medium = sides.map_or(path.medium, |sides| sides.to);
                return Some(ray);
            }
            Interaction::Scatters(vertex) => vertex,
        };
        if path.segment >= self.max_depth {
            return None;
        }
        let dimensions = dimension::of_segment(path.segment);
        path.segment += 1;
        if !path.survives(dimensions) {
            return None;
        }
        let sampler = path.sampler;
        let wo = -ray.direction;
        let sample = |choice: Choice| {
            let u = || sampler.get_2d(dimensions + dimension::DIRECTION);
            vertex.scattering.sample(&vertex.normals, wo, choice, u, Transport::Radiance)
        };
        let sampled = if vertex.crossing.is_none() {
            sample(Choice::Reflect)
        } else if let Some([through, back]) = vertex.scattering.is_delta().then(|| path.split(sample)).flatten() {
            let mut reflected = Path { radiance: Spectrum::ZERO, last: None, ..path.clone() };
            reflected.take_share(back.share());
            path.take_share(through.share());
            *branch = Some((reflected, vertex.leave(back.wi)));
            through
        } else {
            sample(Choice::Sample(sampler.get_1d(dimensions + dimension::SCATTER)))
        };
        if vertex.scattering.is_delta() {
            path.last = None;
        } else {
            if sampled.weight.is_black() {
                return None;
            }
            let traveller = Traveller { segment: path.segment - 1, ..path.traveller() };
            let direct = tracked.direct(&vertex, wo, &traveller, dimensions, &sampler, shadow);
            path.radiance += path.beta * direct * path.radiance_scale;
            path.last = Some(LastScatter { position: vertex.point.position, pdf: sampled.pdf });
        }
        path.scatter(tracked.tracker, &vertex, &sampled);
        Some(vertex.leave(sampled.wi))
    }
}

impl<S: Clone> Path<S> {
    #[inline]
    fn traveller(&self) -> Traveller<'_, S> {
        Traveller { state: &self.state, medium: self.medium, segment: self.segment, wavelengths: self.wavelengths }
    }

    /// Both ways on from an interface, through and back, where the path is to split: where both bring enough to be worth a path of their own.
    #[inline]
    fn split(&mut self, sample: impl Fn(Choice) -> ScatterSample) -> Option<[ScatterSample; 2]> {
        if self.splits == 0 || self.has_scattered {
            return None;
        }
        let through = sample(Choice::Transmit);
        if !through.is_transmitted || through.reflectance.min(1.0 - through.reflectance) * self.share <= SPLIT_SHARE {
            return None;
        }
        self.splits -= 1;
        Some([through, sample(Choice::Reflect)])
    }

    /// Goes on as was sampled at `vertex`.
    #[inline]
    fn scatter<T: Tracker<State = S>>(&mut self, tracker: &T, vertex: &Vertex, sampled: &ScatterSample) {
        self.beta *= sampled.weight;
        self.radiance_scale *= sampled.radiance_scale;
        if sampled.is_transmitted
            && let Some((crossing, sides)) = &vertex.crossing
        {
            tracker.transmit(&mut self.state, crossing);
            self.medium = sides.to;
        }
        if !self.has_scattered && !vertex.scattering.is_delta() {
            self.roulette = Roulette::after_first_scatter(self.beta.max_component() / self.share);
            self.has_scattered = true;
        }
    }

    /// Leaves the rest of its light to another branch.
    #[inline]
    fn take_share(&mut self, share: f64) {
        self.beta *= share;
        self.share *= share;
    }

    /// Russian roulette, with the random numbers of the segment that begins at `dimensions`.
    #[inline]
    fn survives(&mut self, dimensions: u32) -> bool {
        match self.roulette.survival(self.beta, self.segment, &self.sampler, dimensions) {
            Some(survival) => {
                self.beta /= survival;
                true
            }
            None => false,
        }
    }
}
