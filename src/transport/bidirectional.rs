//! Bidirectional path tracing (Veach 1997, chapter 10) and, where vertices are merged as well, vertex connection and merging (Georgiev et al.
//! 2012, *Light Transport Simulation with Vertex Connection and Merging*).
//!
//! An iteration first traces subpaths from lights, each in the medium that its light stands in, and connects their vertices with the lens. Then
//! it traces one subpath from the camera through every pixel, whose vertices meet lights, look for lights, are connected with those of
//! one light's subpath, and are merged with those of all that lie near. All ways to make one path are weighted against each other.
//!
//! A mode that carries state starts with an empty one at both ends. Light is power on subpaths from lights, which interfaces do not scale; on those
//! from the camera it is radiance, which they do.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::aim::Aims;
use super::connection::End;
use super::dimension;
use super::emission::ChosenLight;
use super::interaction::{TrackedScene, Traveller, Vertex};
use super::photon_map::{MergeRadius, Photon, PhotonMap};
use super::sampler::{Sampler, Sequence};
use super::walk::{Met, Walk};
use super::weights::{Merges, Weights, power};
use crate::geometry::{Ray, SurfacePoint};
use crate::rectify::InterfaceTable;
use crate::rectify::start::{Ask, Start, StartRegion};
use crate::scatter::{Normals, Scattering, Transport};
use crate::scene::MediumId;
use crate::scene::camera::Camera;
use crate::scene::lights::{DirectSample, EmittedRay, Target};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::tracking::{Events, Tracker};

/// Subpaths from lights have other random numbers than those from the camera.
const LIGHT_SEED: u64 = 0x6C69_6768_7473;
/// Iterations whose subpaths from lights are points of one sequence; those after them have others, as the sequence has no more than 2³² points.
const ITERATIONS_OF_A_SEQUENCE: u32 = 1 << 12;
/// Most subpaths from lights in one iteration. Their vertices take memory.
const MOST_LIGHT_PATHS: u32 = 1 << 18;

/// Subpaths of different faces are merged if their normals have at least this cosine.
const LEAST_COSINE_TO_MERGE: f64 = 0.5;
/// Radius of merging of the first iteration, in pixels.
const FIRST_RADIUS: f64 = 2.5;
/// The radius of iteration i is that of the first times i to the power of this, so that its square, which the bias is proportional to, vanishes,
/// and the photons in it still become infinitely many (Kaplanyan and Dachsbacher 2013, *Adaptive Progressive Photon Mapping*: 2/3 is the
/// exponent of the area that lets the error fall fastest).
const RADIUS_EXPONENT: f64 = -1.0 / 6.0;

/// What all samples of an image share.
#[derive(Clone, Copy)]
pub struct Bidirectional<'a, T> {
    pub tracked: TrackedScene<'a, T>,
    pub table: &'a InterfaceTable,
    /// Local coordinates.
    pub camera: Camera,
    pub lens: &'a StartRegion,
    /// What subpaths from lights are aimed at.
    pub aims: &'a Aims,
    /// How a medium is found at a point; see [`crate::rectify::start`].
    pub ask: Ask<'a>,
    /// Width and height of the image in pixels.
    pub size: [u32; 2],
    /// Cap on segments; `u32::MAX` for none.
    pub max_depth: u32,
    pub seed: u64,
    pub sequence: Sequence,
    pub has_merging: bool,
    /// Subpaths from lights in an iteration; see [`light_paths`].
    pub light_paths: u32,
}

/// How many subpaths from lights an iteration should have for an image of this size: one for each pixel, but [`MOST_LIGHT_PATHS`] at the most.
pub fn light_paths([width, height]: [u32; 2]) -> u32 {
    width.saturating_mul(height).min(MOST_LIGHT_PATHS)
}

/// One sample of every pixel.
#[derive(Debug, Clone, Copy)]
pub struct Iteration {
    pub number: u32,
    /// Within which subpaths are merged, if they are.
    pub radius: Option<MergeRadius>,
}

/// A vertex of a subpath from a light that others can be connected with.
#[derive(Debug, Clone, Copy)]
pub struct LightVertex {
    pub point: SurfacePoint,
    normals: Normals,
    scattering: Scattering,
    /// Unit, to where the light comes from.
    wo: DVec3,
    /// Power that arrives.
    flux: Spectrum,
    weights: Weights,
    medium: MediumId,
    /// Segments up to here.
    segments: u32,
    /// How many such subpaths are expected to be merged with one that comes here; 0 where this one must not be.
    merges: f64,
}

impl LightVertex {
    /// Whether it may be merged with others.
    pub fn can_merge(&self) -> bool {
        self.merges > 0.0
    }

    pub fn photon(&self) -> Photon {
        Photon {
            position: self.point.position,
            wo: self.wo,
            normal: self.normals.face,
            flux: self.flux,
            weights: self.weights,
            segments: self.segments,
        }
    }
}

/// Light that arrives at a pixel that its path was not sampled through.
#[derive(Debug, Clone, Copy)]
pub struct Splat {
    pub pixel: u32,
    pub radiance: Spectrum,
}

/// What subpaths from lights have left, one after the other.
#[derive(Debug, Default)]
pub struct LightPaths {
    pub vertices: Vec<LightVertex>,
    /// For each subpath the end of its vertices.
    pub ends: Vec<u32>,
    pub splats: Vec<Splat>,
    pub events: Events,
}

impl LightPaths {
    /// The vertices of a subpath.
    pub fn of(&self, number: usize) -> &[LightVertex] {
        let first = number.checked_sub(1).map_or(0, |before| self.ends[before] as usize);
        &self.vertices[first..self.ends[number] as usize]
    }
}

impl<'a, T: Tracker> Bidirectional<'a, T> {
    pub fn iteration(&self, number: u32) -> Iteration {
        let radius = self.has_merging.then(|| {
            let pixel = 2.0 * self.camera.tan_half_fov / f64::from(self.size[1]);
            let reach = self.tracked.scene.geometry.bounding_sphere().map_or(1.0, |sphere| sphere.radius);
            let per_distance = FIRST_RADIUS * pixel * (f64::from(number) + 1.0).powf(RADIUS_EXPONENT);
            // Right at the camera a radius of nothing would be no help.
            MergeRadius { center: self.camera.position, per_distance, least: 1e-6 * reach * per_distance }
        });
        Iteration { number, radius }
    }

    /// The number of subpaths from lights that are expected to be merged at `point` if they come there: the area times their number. Only those
    /// are merged that come from a mirror or an interface: others can be connected instead, which has no bias.
    pub(super) fn merges(&self, iteration: &Iteration, point: DVec3) -> f64 {
        iteration.radius.map_or(0.0, |radius| PI * radius.at(point).powi(2) * f64::from(self.light_paths))
    }

    /// Traces a subpath from a light and adds what it leaves to `paths`.
    pub fn trace_light(&self, iteration: &Iteration, number: u32, paths: &mut LightPaths, room: &mut T::State) {
        if let Some(light) = self.begin_light(iteration, number) {
            self.follow_light(iteration, light, paths, room);
        }
        paths.ends.push(paths.vertices.len() as u32);
    }

    fn begin_light(&self, iteration: &Iteration, number: u32) -> Option<LightWalk<'_, T::State>> {
        let tracked = &self.tracked;
        let turn = iteration.number % ITERATIONS_OF_A_SEQUENCE;
        let (pixel, sample) = (iteration.number / ITERATIONS_OF_A_SEQUENCE, turn * self.light_paths + number);
        let sampler = Sampler::of(self.sequence, self.seed ^ LIGHT_SEED, pixel, sample);
        let (light, rest) = tracked.choose_light(sampler.get_1d(dimension::LIGHT_CHOICE))?;
        let [u, v] = sampler.get_2d(dimension::LIGHT_START);
        let (aim, direction) = (sampler.get_1d(dimension::LIGHT_AIM), sampler.get_2d(dimension::LIGHT_DIRECTION));
        let (emitted, density) = tracked.emit(&light, self.aims, aim, [rest, u, v], direction)?;
        let flux = emitted.radiance * (emitted.cosine / density);
        let start = tracked.start_from_light(self.table, self.ask, &emitted);
        let mut walk = Walk::new(tracked.tracker, &start, sampler, Transport::Importance);
        // Only what is met by chance is found in another way.
        walk.weights.earlier = if light.is_delta() { 0.0 } else { power(emitted.cosine / density) };
        Some(LightWalk { walk, light, emitted, density, flux })
    }

    fn follow_light(
        &self,
        iteration: &Iteration,
        light: LightWalk<'_, T::State>,
        paths: &mut LightPaths,
        room: &mut T::State,
    ) {
        let tracked = &self.tracked;
        let LightWalk { mut walk, light, emitted, density, flux } = light;
        loop {
            let Met::Scatters(vertex) = walk.meet(tracked, &mut paths.events) else { return };
            let wo = -walk.ray.direction;
            let cosine = wo.dot(vertex.normals.face).abs();
            let squared_length = (vertex.point.position - walk.ray.origin).length_squared();
            if cosine == 0.0 || squared_length == 0.0 {
                return;
            }
            if walk.segment == 1 && !vertex.scattering.is_delta() {
                // Instead of coming from the light, this vertex could have looked for it.
                let distance = squared_length.sqrt();
                let direct = tracked.direct_pdf(&light, vertex.point.position, wo, emitted.start.as_ref(), distance);
                walk.weights.arrive(0.0, cosine, false);
                walk.weights.connection = power(direct * emitted.cosine / (density * cosine));
            } else {
                walk.weights.arrive(squared_length, cosine, vertex.scattering.is_delta());
            }
            if walk.segment >= self.max_depth {
                return;
            }
            let place = vertex.point.position;
            let merges = if walk.comes_from_delta() { self.merges(iteration, place) } else { 0.0 };
            if !vertex.scattering.is_delta() {
                let light_vertex = LightVertex {
                    point: vertex.point,
                    normals: vertex.normals,
                    scattering: vertex.scattering,
                    wo,
                    flux: flux * walk.throughput,
                    weights: walk.weights,
                    medium: walk.medium,
                    segments: walk.segment,
                    merges,
                };
                paths.vertices.push(light_vertex);
                let splat = self.see(&walk, &vertex, &light_vertex, room, &mut paths.events);
                paths.splats.extend(splat);
            }
            if !walk.leave(tracked.tracker, &vertex, Merges::Here(merges)) {
                return;
            }
        }
    }

    /// What the camera sees of light that has come to `vertex`.
    fn see(
        &self,
        walk: &Walk<T::State>,
        vertex: &Vertex,
        light: &LightVertex,
        room: &mut T::State,
        events: &mut Events,
    ) -> Option<Splat> {
        let tracked = &self.tracked;
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let lens = self.camera.lens_point(|| walk.sampler.get_2d(walk.dimensions() + dimension::EMITTER));
        let sample = self.camera.sample_direct(vertex.point.position, size, lens)?;
        let Vertex { normals, scattering, .. } = vertex;
        let wo = -walk.ray.direction;
        let scattered = scattering.evaluate(normals, wo, sample.direction, Transport::Importance);
        if scattered.is_black() {
            return None;
        }
        // As the first segment of a path from the camera.
        let start = self.lens.start_by_asking(tracked.scene, Ray::new(sample.origin, -sample.direction), self.ask);
        let mut state = T::State::default();
        tracked.tracker.start(&mut state);
        let traveller = Traveller { state: &state, medium: start.medium, segment: 1, wavelengths: Wavelengths::Rgb };
        let arrival = tracked.connect(start.ray, End::Surface(vertex.point.primitive), &traveller, room)?;
        let is_consistent = tracked.scene.is_consistent(walk.medium, arrival.medium);
        events.inconsistent += u64::from(!is_consistent);
        let per_path = size.x * size.y / f64::from(self.light_paths);
        let [_, of_direction] = self.camera.pdf_ray(-sample.direction, size);
        let cosine = sample.direction.dot(normals.face).abs();
        let by_camera = of_direction * per_path * cosine / (sample.distance * sample.distance);
        let reverse = scattering.pdf(normals, sample.direction, wo);
        let others = power(by_camera) * walk.weights.before(reverse, light.merges);
        let pixel = sample.pixel.floor().min(size - 1.0).as_uvec2();
        let radiance = light.flux * scattered * arrival.transmittance * (sample.importance * per_path / sample.pdf);
        Some(Splat { pixel: pixel.y * self.size[0] + pixel.x, radiance: radiance / (1.0 + others) })
    }

    /// The radiance that a path from the camera brings, and its segments.
    pub fn trace_camera(
        &self,
        iteration: &Iteration,
        path: &CameraPath<'_>,
        room: &mut T::State,
        events: &mut Events,
    ) -> (Spectrum, u32) {
        let CameraPath { ref start, sampler, light, photons } = *path;
        events.ambiguous += u64::from(start.is_ambiguous);
        let tracked = &self.tracked;
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let mut walk = Walk::new(tracked.tracker, start, sampler, Transport::Radiance);
        let [_, of_direction] = self.camera.pdf_ray(start.ray.direction, size);
        // The ways of paths from lights that see the lens, to one path for each pixel.
        walk.weights.connection = power(f64::from(self.light_paths) / (size.x * size.y * of_direction));
        let mut radiance = Spectrum::ZERO;
        loop {
            let vertex = match walk.meet(tracked, events) {
                Met::Escapes { radiance: arriving } => {
                    let others = self.other_ways_to_light(&walk, &tracked.environment_light(), None);
                    radiance += walk.throughput * arriving * (walk.radiance_scale / (1.0 + others));
                    for sun in tracked.suns_along(walk.ray.direction) {
                        let others = self.other_ways_to_light(&walk, &sun, None);
                        let arriving = sun.light.radiance(walk.ray.direction);
                        radiance += walk.throughput * arriving * (walk.radiance_scale / (1.0 + others));
                    }
                    return (radiance, walk.segment);
                }
                Met::Emits { light, radiance: arriving, hit } => {
                    if tracked.scene.emits(light, hit.is_front) {
                        let point = tracked.scene.geometry.surface(&walk.ray, &hit);
                        let light = tracked.object_light(light);
                        let others = light.map_or(0.0, |light| self.other_ways_to_light(&walk, &light, Some(&point)));
                        radiance += walk.throughput * arriving * (walk.radiance_scale / (1.0 + others));
                    }
                    return (radiance, walk.segment);
                }
                Met::Scatters(vertex) => vertex,
            };
            let cosine = walk.ray.direction.dot(vertex.normals.face).abs();
            let squared_length = (vertex.point.position - walk.ray.origin).length_squared();
            if cosine == 0.0 || squared_length == 0.0 {
                return (radiance, walk.segment);
            }
            let is_delta = vertex.scattering.is_delta();
            walk.weights.arrive(squared_length, cosine, is_delta);
            let merges = self.merges(iteration, vertex.point.position);
            if !is_delta && let Some(photons) = photons {
                radiance += self.merge(&walk, &vertex, merges, photons);
            }
            if walk.segment >= self.max_depth {
                return (radiance, walk.segment);
            }
            if !is_delta {
                radiance += self.look_for_light(&walk, &vertex, room, events);
                for end in light {
                    radiance += self.connect(&walk, &vertex, end, room, events);
                }
            }
            if !walk.leave(tracked.tracker, &vertex, Merges::IfDeltaFollows(merges)) {
                return (radiance, walk.segment);
            }
        }
    }

    /// All other ways to make a path that ends at a light, over this one.
    fn other_ways_to_light(&self, walk: &Walk<T::State>, light: &ChosenLight<'_>, point: Option<&SurfacePoint>) -> f64 {
        // Nothing else sees a light directly.
        if walk.segment == 1 {
            return 0.0;
        }
        let direction = walk.ray.direction;
        let from = walk.last.map_or(walk.ray.origin, |(position, _)| position);
        // Nobody meets a light at a point, so the distance does not matter.
        let direct = self.tracked.direct_pdf(light, from, direction, point, 0.0);
        let (place, normal) = point.map_or((walk.ray.origin, -direction), |point| (point.position, point.normal));
        let emission = self.tracked.emission_pdf(light, self.aims, place, normal, -direction);
        power(direct) * walk.weights.connection + power(emission) * walk.weights.earlier
    }

    /// Light that is looked for from `vertex`.
    fn look_for_light(
        &self,
        walk: &Walk<T::State>,
        vertex: &Vertex,
        room: &mut T::State,
        events: &mut Events,
    ) -> Spectrum {
        let (tracked, dimensions) = (&self.tracked, walk.dimensions());
        let scene = tracked.scene;
        let mut radiance = Spectrum::ZERO;
        if tracked.needs.image_environment
            && let Some(sample) = scene.environment.sample(walk.sampler.get_2d(dimensions + dimension::ENVIRONMENT))
        {
            radiance += self.look_at(&tracked.environment_light(), &sample, walk, vertex, room, events);
        }
        if tracked.needs.emitters {
            let select = walk.sampler.get_1d(dimensions + dimension::EMITTER_CHOICE);
            let u = walk.sampler.get_2d(dimensions + dimension::EMITTER);
            if let Some((light, probability, rest)) = scene.emitters.choose(select)
                && let Some(sample) = light.sample_direct(&scene.geometry, vertex.point.position, [rest, u[0], u[1]])
                && sample.pdf > 0.0
                && sample.pdf.is_finite()
            {
                let light = tracked.emitter(light, probability);
                let sample = DirectSample { pdf: sample.pdf * probability, ..sample };
                radiance += self.look_at(&light, &sample, walk, vertex, room, events);
            }
        }
        radiance
    }

    fn look_at(
        &self,
        light: &ChosenLight<'_>,
        sample: &DirectSample,
        walk: &Walk<T::State>,
        vertex: &Vertex,
        room: &mut T::State,
        events: &mut Events,
    ) -> Spectrum {
        let tracked = &self.tracked;
        let Vertex { normals, scattering, .. } = vertex;
        let (wo, wi) = (-walk.ray.direction, sample.direction);
        let scattered = scattering.evaluate(normals, wo, wi, Transport::Radiance);
        if scattered.is_black() {
            return Spectrum::ZERO;
        }
        let Some(arrival) = tracked.connect_from(vertex, wi, sample.target.into(), &walk.traveller(), room) else {
            return Spectrum::ZERO;
        };
        let point = arrival.point(&tracked.scene.geometry);
        // The medium that rectification found around the light.
        let patch = match point {
            Some(point) => self.table.patch_of(&tracked.scene.geometry, point.primitive),
            None => light.light.object().and_then(|object| self.table.place_of(object)),
        };
        let around = patch.and_then(|patch| patch.outside);
        events.inconsistent += u64::from(around.is_some_and(|m| !tracked.scene.is_consistent(arrival.medium, m)));
        // Densities of a light at a point are per squared distance: see [`TrackedScene::direct_pdf`].
        let distance = if let Target::Point { distance } = sample.target { distance } else { 1.0 };
        let (place, normal) = match (point, sample.target) {
            (Some(point), _) => (point.position, point.normal),
            (None, Target::Point { .. }) => (vertex.point.position + wi * distance, -wi),
            (None, _) => (vertex.point.position, -wi),
        };
        let emission = tracked.emission_pdf(light, self.aims, place, normal, -wi);
        let cosine = wi.dot(normals.face).abs();
        let by_scattering = if sample.is_delta { 0.0 } else { power(scattering.pdf(normals, wo, wi) / sample.pdf) };
        let direct = sample.pdf * distance * distance;
        let from_light = power(emission * cosine / direct) * walk.weights.before(scattering.pdf(normals, wi, wo), 0.0);
        let weight = 1.0 / (1.0 + by_scattering + from_light);
        let radiance = sample.radiance * arrival.transmittance * scattered;
        walk.throughput * radiance * (walk.radiance_scale * weight / sample.pdf)
    }

    /// Light that `vertex` has from a vertex of a subpath from a light.
    fn connect(
        &self,
        walk: &Walk<T::State>,
        vertex: &Vertex,
        end: &LightVertex,
        room: &mut T::State,
        events: &mut Events,
    ) -> Spectrum {
        if walk.segment.saturating_add(end.segments) >= self.max_depth {
            return Spectrum::ZERO;
        }
        let (tracked, wo) = (&self.tracked, -walk.ray.direction);
        let between = end.point.position - vertex.point.position;
        let squared_distance = between.length_squared();
        let Some(wi) = between.try_normalize() else { return Spectrum::ZERO };
        let here = vertex.scattering.evaluate(&vertex.normals, wo, wi, Transport::Radiance);
        let there = end.scattering.evaluate(&end.normals, end.wo, -wi, Transport::Importance);
        if here.is_black() || there.is_black() {
            return Spectrum::ZERO;
        }
        let surface = End::Surface(end.point.primitive);
        let Some(arrival) = tracked.connect_from(vertex, wi, surface, &walk.traveller(), room) else {
            return Spectrum::ZERO;
        };
        let is_consistent = tracked.scene.is_consistent(arrival.medium, end.medium);
        events.inconsistent += u64::from(!is_consistent);
        let [cosine_here, cosine_there] =
            [&vertex.normals, &end.normals].map(|normals| wi.dot(normals.face).abs() / squared_distance);
        let from_camera = power(vertex.scattering.pdf(&vertex.normals, wo, wi) * cosine_there)
            * end.weights.before(end.scattering.pdf(&end.normals, -wi, end.wo), end.merges);
        let from_light = power(end.scattering.pdf(&end.normals, end.wo, -wi) * cosine_here)
            * walk.weights.before(vertex.scattering.pdf(&vertex.normals, wi, wo), 0.0);
        let weight = 1.0 / (1.0 + from_camera + from_light);
        let flux = end.flux * arrival.transmittance * here * there;
        walk.throughput * flux * (walk.radiance_scale * weight / squared_distance)
    }

    /// Light that `vertex` has from all subpaths from lights that have come to places near it.
    fn merge(&self, walk: &Walk<T::State>, vertex: &Vertex, merges: f64, photons: &PhotonMap) -> Spectrum {
        let Vertex { normals, scattering, point, .. } = vertex;
        let wo = -walk.ray.direction;
        let mut sum = Spectrum::ZERO;
        photons.for_each_near(point.position, |photon| {
            let cosine = photon.wo.dot(photon.normal);
            if photon.normal.dot(normals.face) < LEAST_COSINE_TO_MERGE
                || walk.segment.saturating_add(photon.segments) > self.max_depth
            {
                return;
            }
            let scattered = scattering.evaluate(normals, wo, photon.wo, Transport::Radiance);
            let per_merges = 1.0 / power(merges);
            let from_camera = photon.weights.before(scattering.pdf(normals, wo, photon.wo), 0.0) * per_merges;
            let from_light = walk.weights.before(scattering.pdf(normals, photon.wo, wo), 0.0) * per_merges;
            sum += photon.flux * scattered / (cosine * (1.0 + from_camera + from_light));
        });
        walk.throughput * sum * (walk.radiance_scale / merges)
    }
}

/// A path from the camera that is to be traced.
#[derive(Debug, Clone, Copy)]
pub struct CameraPath<'a> {
    pub start: Start,
    pub sampler: Sampler,
    /// The vertices of the subpath from a light that it is connected with.
    pub light: &'a [LightVertex],
    /// What it is merged with.
    pub photons: Option<&'a PhotonMap>,
}

/// A subpath that has just left a light.
struct LightWalk<'a, S> {
    walk: Walk<S>,
    light: ChosenLight<'a>,
    emitted: EmittedRay,
    /// With which it began there, per area and steradian.
    density: f64,
    /// Power.
    flux: Spectrum,
}
