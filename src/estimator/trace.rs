//! One path, vertex by vertex, for people to read.

use glam::DVec3;

use crate::geometry::Ray;
use crate::render::{Events, Prepared};
use crate::tracking::Mode;

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
    /// A surface that does not bend light, or that the mode ignores.
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

/// Follows `ray` (scene coordinates) until it escapes, meets a light, or has `max_depth` segments (at most 100,000).
pub fn trace(
    prepared: &Prepared,
    mode: Mode,
    ray: Ray,
    follow: Follow,
    seed: u64,
    max_depth: Option<u32>,
) -> TracedPath {
    let _ = (prepared, mode, ray, follow, seed, max_depth, DVec3::ZERO);
    todo!("core")
}
