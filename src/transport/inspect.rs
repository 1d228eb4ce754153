//! One path, vertex by vertex, for people to read.

use super::dimension;
use super::interaction::{Interaction, TrackedScene, Traveller};
use super::sampler::Sampler;
use crate::geometry::{Hit, Ray};
use crate::rectify::containment::medium_at;
use crate::rectify::start::{Start, start_by_asking};
use crate::scatter::{Choice, Transport};
use crate::scene::{MediumId, ObjectId, Scene, SceneMedium, Surface};
use crate::spectrum::Wavelengths;
use crate::tracking::{Events, Mode, Prepared, Sides, Tracker, WithTracker};

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
    /// Whether the medium left is the one that the path was in.
    #[serde(skip)]
    pub is_consistent: bool,
}

/// A whole path.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct TracedPath {
    pub mode: Mode,
    /// Medium that the path starts in.
    pub camera_medium: String,
    pub vertices: Vec<Vertex>,
    /// Whether it left the scene.
    pub escaped: bool,
    /// Unit direction of the last segment.
    pub final_direction: [f64; 3],
    #[serde(skip)]
    pub events: Events,
}

/// Follows `ray` (scene coordinates) until it escapes, meets an opaque surface that does not mirror, or has `max_depth` segments (at
/// most [`MOST_SEGMENTS`]).
pub fn trace(
    prepared: &Prepared,
    mode: Mode,
    ray: Ray,
    follow: Follow,
    seed: u64,
    max_depth: Option<u32>,
) -> TracedPath {
    let max_depth = max_depth.unwrap_or(MOST_SEGMENTS).min(MOST_SEGMENTS);
    prepared.with_tracker(mode, Inspection { prepared, mode, ray, follow, seed, max_depth })
}

struct Inspection<'a> {
    prepared: &'a Prepared,
    mode: Mode,
    ray: Ray,
    follow: Follow,
    seed: u64,
    max_depth: u32,
}

impl WithTracker for Inspection<'_> {
    type Output = TracedPath;

    fn run<T: Tracker>(self, tracker: &T) -> TracedPath {
        let scene = &*self.prepared.scene;
        let tracked = TrackedScene { scene, tracker, needs: scene.needs };
        let ray = Ray::new(self.ray.origin - scene.geometry.origin, self.ray.direction.normalize());
        let mut state = T::State::default();
        tracker.start(&mut state);
        let ask = |point| tracker.medium_at(point).unwrap_or_else(|| medium_at(scene, point));
        let Start { mut ray, mut medium, is_ambiguous } = start_by_asking(scene, ray, &ask);
        let mut path = TracedPath {
            mode: self.mode,
            camera_medium: scene.medium(medium).name.clone(),
            vertices: Vec::new(),
            escaped: false,
            final_direction: ray.direction.to_array(),
            events: Events { ambiguous: u64::from(is_ambiguous), ..Events::default() },
        };
        let sampler = Sampler::new(self.seed, 0, 0);
        let mut segment = 1;
        // Masked faces are shown too, as skipped.
        while let Some(hit) = scene.geometry.closest(&ray) {
            let traveller = Traveller { state: &state, medium, segment, wavelengths: Wavelengths::Rgb };
            let interaction = tracked.interaction(&ray, Some(&hit), &traveller, &mut path.events);
            if let Interaction::Grazes { ray: behind } = interaction {
                ray = behind;
                continue;
            }
            let mut vertex = self.vertex_at(&ray, &hit);
            let next = match interaction {
                // Of these three only a light is left here.
                Interaction::Escapes { .. } | Interaction::Grazes { .. } | Interaction::Emits { .. } => {
                    vertex.event = VertexEvent::Emit;
                    None
                }
                Interaction::Passes { ray, crossing, sides } => {
                    vertex.event = VertexEvent::Skip;
                    vertex.fresnel = Some(0.0);
                    vertex.tell_sides(scene, sides, medium);
                    tracker.transmit(&mut state, &crossing);
                    medium = sides.map_or(medium, |sides| sides.to);
                    Some(ray)
                }
                Interaction::Scatters(at) => {
                    vertex.tell_sides(scene, at.crossing.map(|(_, sides)| sides), medium);
                    let choice = match self.follow {
                        Follow::Transmit => Choice::Transmit,
                        Follow::Reflect => Choice::Reflect,
                        Follow::Sample => {
                            Choice::Sample(sampler.get_1d(dimension::of_segment(segment) + dimension::SCATTER))
                        }
                    };
                    let u = || sampler.get_2d(dimension::of_segment(segment) + dimension::DIRECTION);
                    let sampled = at.scattering.sample(&at.normals, -ray.direction, choice, u, Transport::Radiance);
                    // A path is told up to where it would spread over all directions.
                    if at.scattering.is_delta() {
                        vertex.fresnel = Some(sampled.reflectance);
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
            let turns = vertex.event != VertexEvent::Skip;
            path.vertices.push(vertex);
            let Some(next) = next else { return path };
            if turns {
                if segment >= self.max_depth {
                    return path;
                }
                segment += 1;
            }
            ray = next;
            path.final_direction = ray.direction.to_array();
        }
        path.escaped = true;
        path
    }
}

impl Inspection<'_> {
    /// What is known of a hit without any tracker.
    fn vertex_at(&self, ray: &Ray, hit: &Hit) -> Vertex {
        let scene = &*self.prepared.scene;
        let point = scene.geometry.surface(ray, hit);
        let object = scene.object(ObjectId(scene.geometry.object_of(hit.primitive)));
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
            is_consistent: true,
        }
    }
}

impl Vertex {
    /// Takes up the media on both sides of a crossing, met by a path in `medium`.
    fn tell_sides(&mut self, scene: &Scene, sides: Option<Sides>, medium: MediumId) {
        let Some(Sides { from, to }) = sides else { return };
        self.is_consistent = scene.is_consistent(medium, from);
        let [from, to]: [&SceneMedium; 2] = [from, to].map(|id| scene.medium(id));
        (self.from, self.to) = (Some(from.name.clone()), Some(to.name.clone()));
        (self.ior_from, self.ior_to) = (Some(from.ior()), Some(to.ior()));
    }
}
