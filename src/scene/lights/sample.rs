//! What sampling a light gives.

use glam::DVec3;

use crate::geometry::{PrimitiveId, Ray, SurfacePoint};
use crate::scene::ObjectId;
use crate::spectrum::Spectrum;

/// What a shadow ray has to arrive at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// This part of an object's surface, from a side that emits: that needs no distance to compare with. Another part of the same object is in the
    /// way.
    Surface { object: ObjectId, primitive: PrimitiveId },
    /// Nothing at all: the ray escapes.
    Environment,
    /// Nothing up to that distance.
    Point { distance: f64 },
}

/// A direction towards light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectSample {
    /// Unit.
    pub direction: DVec3,
    /// Per steradian, > 0; of a delta light the probability, which is 1 unless the light itself was chosen at random.
    pub pdf: f64,
    /// What arrives along it if nothing is in the way: radiance, or the irradiance across it of a delta light.
    pub radiance: Spectrum,
    /// Whether this is the only direction that the light can be sampled in and no other way of sampling finds it, so that its weight is 1.
    pub is_delta: bool,
    pub target: Target,
}

/// A ray that leaves a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmittedRay {
    pub ray: Ray,
    /// Along the ray, in the medium around the light: radiance; of a light at a point its intensity there, and of a directional light without
    /// extent its irradiance. Whatever the light, the ray carries radiance · cosine / (pdf_position · pdf_direction).
    pub radiance: Spectrum,
    /// Of the ray to the normal of the surface that starts are sampled on; 1 where that stands across the ray.
    pub cosine: f64,
    /// Of the start, per area of that surface; 1 of a light at a point.
    pub pdf_position: f64,
    /// Of the direction, per steradian; 1 of a directional light without extent.
    pub pdf_direction: f64,
    /// Where on an object it starts, its normal on the side that it leaves; `None` from afar and from a point.
    pub start: Option<SurfacePoint>,
    /// Whether it leaves the outward side; only a light with two sides has another.
    pub is_front: bool,
    /// The light; `None` is the environment.
    pub light: Option<ObjectId>,
}
