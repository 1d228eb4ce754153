//! One path, vertex by vertex, for people to read. It asks the same questions in the same order as the path tracer.

use super::crossing::Met;
use super::path::{PathTracer, dimension};
use super::sampler::Sampler;
use crate::geometry::Ray;
use crate::rectify::containment::medium_at;
use crate::rectify::start::{Start, start_by_asking};
use crate::scatter::dielectric::{self, Choice};
use crate::scatter::mirror;
use crate::scene::{ObjectId, Surface};
use crate::tracking::naive::Naive;
use crate::tracking::priority::Priority;
use crate::tracking::rectified::{Rectified, RectifiedObject};
use crate::tracking::stack::Stack;
use crate::tracking::{Events, Prepared};
use crate::tracking::{Mode, Tracker};

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
    let tracing =
        Tracing { prepared, mode, follow, seed, max_depth: max_depth.unwrap_or(MOST_SEGMENTS).min(MOST_SEGMENTS) };
    match mode {
        Mode::Naive => tracing.run(&Naive, ray),
        Mode::Stack => tracing.run(&Stack, ray),
        Mode::Priority => tracing.run(&Priority { scene: &prepared.scene }, ray),
        Mode::RectifiedObject => tracing.run(&RectifiedObject::new(&prepared.scene, &prepared.table), ray),
        Mode::Rectified => tracing.run(&Rectified { scene: &prepared.scene, table: &prepared.table }, ray),
        Mode::Reference => tracing.run(&prepared.reference(), ray),
    }
}

struct Tracing<'a> {
    prepared: &'a Prepared,
    mode: Mode,
    follow: Follow,
    seed: u64,
    max_depth: u32,
}

impl Tracing<'_> {
    fn run<T: Tracker>(&self, tracker: &T, ray: Ray) -> TracedPath {
        let scene = &*self.prepared.scene;
        let tracer = PathTracer { scene, tracker, needs: scene.needs, max_depth: self.max_depth, splits: 0 };
        let ray = Ray::new(ray.origin - scene.geometry.origin, ray.direction.normalize());
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
        while let Some(hit) = scene.geometry.closest(&ray) {
            let point = scene.geometry.surface(&ray, &hit);
            let object = ObjectId(scene.geometry.object_of(hit.primitive));
            let name = &scene.object(object).name;
            let mut vertex = Vertex {
                position: (point.position + scene.geometry.origin).to_array(),
                refractor: None,
                patch: None,
                solid: None,
                from: None,
                to: None,
                ior_from: None,
                ior_to: None,
                fresnel: None,
                event: VertexEvent::Scatter,
                is_consistent: true,
            };
            let next = match scene.object(object).surface {
                Surface::Light { .. } => {
                    vertex.event = VertexEvent::Emit;
                    vertex.solid = Some(name.clone());
                    None
                }
                Surface::Diffuse { .. } => {
                    vertex.solid = Some(name.clone());
                    None
                }
                Surface::Mirror { smooth, .. } => {
                    vertex.solid = Some(name.clone());
                    vertex.event = VertexEvent::Reflect;
                    vertex.fresnel = Some(1.0);
                    let direction = mirror::reflect(ray.direction, &tracer.normals(&hit, &point, smooth));
                    Some(Ray::leaving(point.position, direction, hit.primitive))
                }
                Surface::Refractor { smooth, .. } => {
                    let Met { crossing, interface } = match tracer.meet(&ray, &hit, &state, medium, &mut path.events) {
                        Ok(met) => met,
                        Err(behind) => {
                            ray = behind;
                            continue;
                        }
                    };
                    vertex.refractor = Some(name.clone());
                    vertex.patch =
                        self.prepared.table.patch_of(&scene.geometry, hit.primitive).map(|patch| patch.index);
                    if let Some((sides, _)) = interface {
                        vertex.is_consistent = scene.is_consistent(medium, sides.from);
                        let (from, to) = (scene.medium(sides.from), scene.medium(sides.to));
                        vertex.from = Some(from.name.clone());
                        vertex.to = Some(to.name.clone());
                        vertex.ior_from = Some(from.ior());
                        vertex.ior_to = Some(to.ior());
                    }
                    if let Some((sides, interface)) = interface.filter(|(_, interface)| !interface.is_matched()) {
                        let normals = tracer.normals(&hit, &point, smooth);
                        let choice = match self.follow {
                            Follow::Transmit => Choice::Transmit,
                            Follow::Reflect => Choice::Reflect,
                            Follow::Sample => Choice::Sample(sampler.get_1d(
                                dimension::FIRST_SEGMENT + (segment - 1) * dimension::PER_SEGMENT + dimension::SCATTER,
                            )),
                        };
                        let scattered = dielectric::scatter(&interface, ray.direction, &normals, segment, choice);
                        vertex.fresnel = Some(scattered.reflectance);
                        vertex.event = match (scattered.is_transmitted, scattered.is_total) {
                            (true, _) => VertexEvent::Transmit,
                            (false, true) => VertexEvent::TotalReflection,
                            (false, false) => VertexEvent::Reflect,
                        };
                        if scattered.is_transmitted {
                            tracker.transmit(&mut state, &crossing);
                            medium = sides.to;
                        }
                        Some(Ray::leaving(point.position, scattered.direction, hit.primitive))
                    } else {
                        vertex.event = VertexEvent::Skip;
                        vertex.fresnel = Some(0.0);
                        tracker.transmit(&mut state, &crossing);
                        medium = interface.map_or(medium, |(sides, _)| sides.to);
                        Some(ray.beyond(&hit))
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
