//! One path, vertex by vertex, for people to read.

use glam::DVec3;

use super::dimension;
use super::interaction::{Interaction, TrackedScene, Traveller};
use super::sampler::Sampler;
use crate::geometry::{Hit, NO_PRIMITIVE, PrimitiveId, Ray};
use crate::rectify::containment::medium_at;
use crate::rectify::start::{Start, start_by_asking};
use crate::scatter::{Choice, Normals, Transport};
use crate::scene::lights::EmittedRay;
use crate::scene::{MediumId, ObjectId, Scene, SceneMedium, Surface};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::tracking::{Crossing, Events, Mode, Prepared, Sides, Tracker, WithTracker};

/// Segments at the most: a path may be trapped for ever.
pub const MOST_SEGMENTS: u32 = 100_000;

/// Which way to go on at an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Follow {
    /// Chosen at random by Fresnel's reflectance, as the renderer does.
    Sample,
    /// Always through, except where reflection is total.
    Transmit,
    /// Always back.
    Reflect,
}

/// What happened at a vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VertexEvent {
    Transmit,
    Reflect,
    TotalReflection,
    /// A surface that does not bend light, or one that is no interface to the mode: then the vertex has no media.
    Skip,
    /// An opaque surface.
    Scatter,
    /// A light.
    Emit,
}

/// One meeting of the path with a surface. Fields that do not apply are `None`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Vertex {
    /// Scene coordinates.
    pub position: [f64; 3],
    pub refractor: Option<String>,
    pub patch: Option<u32>,
    /// Name of the solid or light.
    pub solid: Option<String>,
    pub from: Option<String>,
    pub to: Option<String>,
    pub ior_from: Option<f64>,
    pub ior_to: Option<f64>,
    /// Unpolarised reflectance.
    pub fresnel: Option<f64>,
    pub event: VertexEvent,
    /// Medium of the segment that ends here: what the path takes itself to be in.
    pub medium: String,
    /// Length of that segment, in scene units.
    pub distance: f64,
    /// Share of the light that the segment lets through: R, G, B.
    pub transmittance: [f64; 3],
    /// Unit, outward: the face's own normal.
    pub normal: [f64; 3],
    /// Degrees between the path and the normal that it is bent about, before this place and behind it.
    pub angle_in: Option<f64>,
    pub angle_out: Option<f64>,
    /// Share of the light of the whole path up to here that goes on: Fresnel's shares, the colours of mirrors and all transmittances,
    /// multiplied. R, G, B.
    pub throughput: [f64; 3],
    #[serde(skip)]
    pub ids: VertexIds,
    /// Whether the medium left is the one that the path was in.
    #[serde(skip)]
    pub is_consistent: bool,
}

/// What a vertex is made of, by number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VertexIds {
    pub object: ObjectId,
    pub primitive: PrimitiveId,
    /// Medium of the segment that ends here.
    pub medium: MediumId,
    /// Of a refractor: how the path meets it, in the scene's local coordinates.
    pub crossing: Option<Crossing>,
    /// What the mode takes for the media on both sides; `None` where it sees no interface.
    pub sides: Option<Sides>,
}

impl Default for VertexIds {
    fn default() -> Self {
        let (object, medium) = (ObjectId(0), MediumId::WORLD);
        Self { object, primitive: NO_PRIMITIVE, medium, crossing: None, sides: None }
    }
}

/// Where a path starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathStart {
    /// With this ray, scene coordinates.
    Ray(Ray),
    /// At this light, chosen at random: where, and in which direction. The path is that of its light.
    Light(ObjectId),
}

impl From<Ray> for PathStart {
    fn from(ray: Ray) -> Self {
        Self::Ray(ray)
    }
}

/// A whole path.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TracedPath {
    pub mode: Mode,
    /// The light that it starts at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<String>,
    /// Where it starts, in scene coordinates.
    pub origin: [f64; 3],
    /// Medium that the path starts in.
    pub camera_medium: String,
    pub vertices: Vec<Vertex>,
    /// Whether it left the scene.
    pub escaped: bool,
    /// Unit direction of the last segment.
    pub final_direction: [f64; 3],
    /// Medium of the last segment.
    pub final_medium: String,
    #[serde(skip)]
    pub final_medium_id: MediumId,
    #[serde(skip)]
    pub events: Events,
}

impl TracedPath {
    /// The same path in a scene that is `factor` times as large.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        let scale = |place: [f64; 3]| place.map(|x| x * factor);
        self.origin = scale(self.origin);
        for vertex in &mut self.vertices {
            vertex.position = scale(vertex.position);
            vertex.distance *= factor;
            if let Some(crossing) = &mut vertex.ids.crossing {
                crossing.point.position *= factor;
            }
        }
        self
    }
}

/// Follows a path until it escapes, meets an opaque surface that does not mirror, or has `max_depth` segments (at most [`MOST_SEGMENTS`]).
/// `seed` decides what is random.
pub fn trace(
    prepared: &Prepared,
    mode: Mode,
    start: impl Into<PathStart>,
    follow: Follow,
    seed: u64,
    max_depth: Option<u32>,
) -> TracedPath {
    let max_depth = max_depth.unwrap_or(MOST_SEGMENTS).min(MOST_SEGMENTS);
    prepared.with_tracker(mode, Inspection { prepared, mode, start: start.into(), follow, seed, max_depth })
}

struct Inspection<'a> {
    prepared: &'a Prepared,
    mode: Mode,
    start: PathStart,
    follow: Follow,
    seed: u64,
    max_depth: u32,
}

impl WithTracker for Inspection<'_> {
    type Output = TracedPath;

    fn run<T: Tracker>(self, tracker: &T) -> TracedPath {
        let scene = &*self.prepared.scene;
        let told = tracker.camera_medium().map(|medium| (medium, false));
        let ask = |point| told.or_else(|| tracker.medium_at(point)).unwrap_or_else(|| medium_at(scene, point));
        let Start { ray, medium, is_ambiguous } = match self.start {
            PathStart::Ray(ray) => {
                let ray = Ray::new(ray.origin - scene.geometry.origin, ray.direction.normalize());
                start_by_asking(scene, ray, &ask)
            }
            PathStart::Light(light) => match self.emitted(light) {
                Some(emitted) => TrackedScene { scene, tracker, needs: scene.needs }.start_from_light(
                    &self.prepared.table,
                    &ask,
                    &emitted,
                ),
                // A light that emits nothing sends no path: from beyond the scene, out of it.
                None => {
                    let reach = scene
                        .geometry
                        .bounding_sphere()
                        .map_or(1.0, |sphere| sphere.center.length() + 2.0 * sphere.radius);
                    start_by_asking(scene, Ray::new(DVec3::Y * reach, DVec3::Y), &ask)
                }
            },
        };
        let light = match self.start {
            PathStart::Ray(_) => None,
            PathStart::Light(light) => Some(scene.object(light).name.clone()),
        };
        let mut path = TracedPath {
            mode: self.mode,
            light,
            origin: (ray.origin + scene.geometry.origin).to_array(),
            camera_medium: scene.medium(medium).name.clone(),
            vertices: Vec::new(),
            escaped: false,
            final_direction: ray.direction.to_array(),
            final_medium: String::new(),
            final_medium_id: medium,
            events: Events { ambiguous: u64::from(is_ambiguous), ..Events::default() },
        };
        path.escaped = self.walk(tracker, ray, &mut path);
        path.final_medium.clone_from(&scene.medium(path.final_medium_id).name);
        path
    }
}

impl Inspection<'_> {
    /// The ray that a path from a light starts with.
    fn emitted(&self, light: ObjectId) -> Option<EmittedRay> {
        let scene = &*self.prepared.scene;
        let (light, _) = scene.emitters.find(light)?;
        let sampler = Sampler::new(self.seed, 0, 0);
        let [u, v] = sampler.get_2d(dimension::LIGHT_START);
        let start = [sampler.get_1d(dimension::LIGHT_CHOICE), u, v];
        light.sample_ray(&scene.geometry, start, sampler.get_2d(dimension::LIGHT_DIRECTION))
    }

    /// What the path carries.
    fn transport(&self) -> Transport {
        match self.start {
            PathStart::Ray(_) => Transport::Radiance,
            PathStart::Light(_) => Transport::Importance,
        }
    }

    /// Follows `ray`, which starts in the path's final medium, and adds what it meets. Returns whether it leaves the scene.
    fn walk<T: Tracker>(&self, tracker: &T, mut ray: Ray, path: &mut TracedPath) -> bool {
        let scene = &*self.prepared.scene;
        let tracked = TrackedScene { scene, tracker, needs: scene.needs };
        let mut state = T::State::default();
        tracker.start(&mut state);
        let sampler = Sampler::new(self.seed, 0, 0);
        let mut medium = path.final_medium_id;
        let mut segment = 1;
        let mut last_position = ray.at(ray.t_min) + scene.geometry.origin;
        let mut transmittance = Spectrum::ONE;
        let mut throughput = Spectrum::ONE;
        // Masked faces are shown too, as skipped.
        while let Some(hit) = scene.geometry.closest(&ray) {
            let traveller = Traveller { state: &state, medium, segment, wavelengths: Wavelengths::Rgb };
            let interaction = tracked.interaction(&ray, Some(&hit), &traveller, &mut path.events);
            transmittance *= tracked.transmittance(medium, &ray, hit.t);
            if let Interaction::Grazes { ray: behind } = interaction {
                ray = behind;
                continue;
            }
            let mut vertex = self.vertex_at(&ray, &hit, medium);
            let position = DVec3::from(vertex.position);
            vertex.distance = position.distance(std::mem::replace(&mut last_position, position));
            vertex.transmittance = transmittance.to_rgb();
            throughput *= std::mem::replace(&mut transmittance, Spectrum::ONE);
            let next = match interaction {
                // Of these three only a light is left here.
                Interaction::Escapes { .. } | Interaction::Grazes { .. } | Interaction::Emits { .. } => {
                    vertex.event = VertexEvent::Emit;
                    None
                }
                Interaction::Passes { ray, crossing, sides } => {
                    vertex.event = VertexEvent::Skip;
                    vertex.fresnel = Some(0.0);
                    vertex.tell_sides(scene, Some(crossing), sides);
                    tracker.transmit(&mut state, &crossing);
                    medium = sides.map_or(medium, |sides| sides.to);
                    Some(ray)
                }
                Interaction::Scatters(at) => {
                    vertex.tell_sides(scene, at.crossing.map(|c| c.0), at.crossing.map(|c| c.1));
                    let choice = match self.follow {
                        Follow::Transmit => Choice::Transmit,
                        Follow::Reflect => Choice::Reflect,
                        Follow::Sample => {
                            Choice::Sample(sampler.get_1d(dimension::of_segment(segment) + dimension::SCATTER))
                        }
                    };
                    let u = || sampler.get_2d(dimension::of_segment(segment) + dimension::DIRECTION);
                    let sampled = at.scattering.sample(&at.normals, -ray.direction, choice, u, self.transport());
                    // A path is told up to where it would spread over all directions.
                    if at.scattering.is_delta() {
                        vertex.fresnel = Some(sampled.reflectance);
                        vertex.tell_angles(&at.normals, ray.direction, sampled.wi);
                        throughput *= sampled.weight * sampled.share();
                        vertex.event = match (sampled.is_transmitted, at.crossing.is_some() && sampled.is_total) {
                            (true, _) => VertexEvent::Transmit,
                            (false, true) => VertexEvent::TotalReflection,
                            (false, false) => VertexEvent::Reflect,
                        };
                        if let Some((crossing, sides)) = at.crossing.filter(|_| sampled.is_transmitted) {
                            tracker.transmit(&mut state, &crossing);
                            medium = sides.to;
                        }
                        Some(at.leave(sampled.wi))
                    } else {
                        None
                    }
                }
            };
            vertex.throughput = throughput.to_rgb();
            let turns = vertex.event != VertexEvent::Skip;
            path.vertices.push(vertex);
            path.final_medium_id = medium;
            let Some(next) = next else { return false };
            if turns {
                if segment >= self.max_depth {
                    return false;
                }
                segment += 1;
            }
            ray = next;
            path.final_direction = ray.direction.to_array();
        }
        true
    }

    /// What is known of a hit, by a path in `medium`, without any tracker.
    fn vertex_at(&self, ray: &Ray, hit: &Hit, medium: MediumId) -> Vertex {
        let scene = &*self.prepared.scene;
        let point = scene.geometry.surface(ray, hit);
        let id = ObjectId(scene.geometry.object_of(hit.primitive));
        let object = scene.object(id);
        let is_refractor = matches!(object.surface, Surface::Refractor { .. });
        let patch = is_refractor.then(|| self.prepared.table.patch_of(&scene.geometry, hit.primitive)).flatten();
        Vertex {
            position: (point.position + scene.geometry.origin).to_array(),
            refractor: is_refractor.then(|| object.name.clone()),
            patch: patch.map(|patch| patch.index),
            solid: (!is_refractor).then(|| object.name.clone()),
            from: None,
            to: None,
            ior_from: None,
            ior_to: None,
            fresnel: None,
            event: VertexEvent::Scatter,
            medium: scene.medium(medium).name.clone(),
            distance: 0.0,
            transmittance: [1.0; 3],
            normal: point.normal.to_array(),
            angle_in: None,
            angle_out: None,
            throughput: [1.0; 3],
            ids: VertexIds { object: id, primitive: hit.primitive, medium, crossing: None, sides: None },
            is_consistent: true,
        }
    }
}

impl Vertex {
    /// Takes up a crossing and the media on both sides of it.
    fn tell_sides(&mut self, scene: &Scene, crossing: Option<Crossing>, sides: Option<Sides>) {
        (self.ids.crossing, self.ids.sides) = (crossing, sides);
        let Some(Sides { from, to }) = sides else { return };
        self.is_consistent = scene.is_consistent(self.ids.medium, from);
        let [from, to]: [&SceneMedium; 2] = [from, to].map(|id| scene.medium(id));
        (self.from, self.to) = (Some(from.name.clone()), Some(to.name.clone()));
        (self.ior_from, self.ior_to) = (Some(from.ior()), Some(to.ior()));
    }

    /// Takes up the angles to the normal that scattering uses, of a path that comes along `direction` and leaves along `wi`.
    fn tell_angles(&mut self, normals: &Normals, direction: DVec3, wi: DVec3) {
        let degrees = |along: DVec3| along.dot(normals.shading).abs().min(1.0).acos().to_degrees();
        (self.angle_in, self.angle_out) = (Some(degrees(direction)), Some(degrees(wi)));
    }
}
