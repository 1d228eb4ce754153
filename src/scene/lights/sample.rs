//! What sampling a light gives.

use glam::DVec3;

use crate::geometry::{Ray, SurfacePoint};
use crate::scene::ObjectId;
use crate::spectrum::Spectrum;

/// What a shadow ray has to arrive at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// This object, from its outward side: that needs no distance to compare with.
    Object(ObjectId),
    /// Nothing at all: the ray escapes.
    Environment,
}

/// A direction towards light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectSample {
    /// Unit.
    pub direction: DVec3,
    /// Per steradian, > 0.
    pub pdf: f64,
    pub target: Target,
}

/// A ray that leaves a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmittedRay {
    pub ray: Ray,
    /// Along the ray, in the medium around the light.
    pub radiance: Spectrum,
    /// Of the ray to the normal of the surface that starts are sampled on; 1 where that stands across the ray.
    pub cosine: f64,
    /// Of the start, per area of that surface.
    pub pdf_position: f64,
    /// Of the direction, per steradian.
    pub pdf_direction: f64,
    /// Where on an object it starts; `None` from the environment.
    pub start: Option<SurfacePoint>,
}
