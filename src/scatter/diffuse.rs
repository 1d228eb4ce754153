//! Lambertian reflection.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::frame;

/// A direction on the side of unit `normal`, for `u` uniform in [0, 1)², and its probability per steradian, cos θ/π.
#[inline]
pub fn sample(normal: DVec3, u: [f64; 2]) -> (DVec3, f64) {
    let (sin_phi, cos_phi) = (TAU * u[1]).sin_cos();
    let r = u[0].sqrt();
    let cos = (1.0 - u[0]).max(0.0).sqrt();
    let (tangent, bitangent) = frame(normal);
    let direction = (tangent * (r * cos_phi) + bitangent * (r * sin_phi) + normal * cos).normalize();
    (direction, pdf(cos))
}

/// Probability per steradian of a direction at `cos` from the normal.
#[inline]
pub fn pdf(cos: f64) -> f64 {
    cos.max(0.0) / PI
}
