//! Light from afar, such as the sun's.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::point::{in_cone, one_minus_cos};
use super::sample::{DirectSample, EmittedRay, Target};
use crate::geometry::Ray;
use crate::geometry::sphere::Sphere;
use crate::scatter::frame;
use crate::scene::ObjectId;
use crate::spectrum::Spectrum;

/// A disc in the sky, equally bright all over; or, of no extent, one direction, in which nothing is to be seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    pub object: ObjectId,
    /// Unit, towards the light's middle.
    pub to_light: DVec3,
    /// Across the direction, in the world's medium.
    pub irradiance: Spectrum,
    /// 1 − cos of half the angle that it is seen under; 0 where it has no extent.
    one_minus_cos: f64,
    /// Irradiance over ∫ cos across the disc; black where it has no extent.
    radiance: Spectrum,
}

impl DirectionalLight {
    /// `angle` is the full one, in degrees, from 0 to 180.
    pub fn new(object: ObjectId, to_light: DVec3, irradiance: Spectrum, angle: f64) -> Self {
        let one_minus_cos = one_minus_cos(0.5 * angle);
        let projected = PI * one_minus_cos * (2.0 - one_minus_cos);
        let radiance = if projected > 0.0 { irradiance * (1.0 / projected) } else { Spectrum::ZERO };
        Self { object, to_light, irradiance, one_minus_cos, radiance }
    }

    /// Whether it has no extent.
    pub fn is_delta(&self) -> bool {
        self.one_minus_cos == 0.0
    }

    /// 1 − cos of half the angle that it is seen under.
    pub fn one_minus_cos(&self) -> f64 {
        self.one_minus_cos
    }

    /// Of the disc; black where it has no extent.
    pub fn disc_radiance(&self) -> Spectrum {
        self.radiance
    }

    /// What falls into the sphere around the scene, summed over the bands: irradiance · πR² for a light of no extent, and hardly more for a
    /// sun.
    pub fn power(&self, bounds: &Sphere) -> f64 {
        let (radiance, solid_angle) =
            if self.is_delta() { (self.irradiance, 1.0) } else { (self.radiance, TAU * self.one_minus_cos) };
        radiance.sum() * solid_angle * PI * bounds.radius * bounds.radius
    }

    /// Whether a ray that escapes along unit `direction` sees the disc.
    #[inline]
    pub fn is_seen(&self, direction: DVec3) -> bool {
        // Half the square of the difference is 1 − cos, without cancellation.
        0.5 * (direction - self.to_light).length_squared() < self.one_minus_cos
    }

    /// Radiance that arrives from unit `direction`.
    #[inline]
    pub fn radiance(&self, direction: DVec3) -> Spectrum {
        if self.is_seen(direction) { self.radiance } else { Spectrum::ZERO }
    }

    /// A direction towards the disc, for `u` uniform in [0, 1)².
    #[inline]
    pub fn sample_direct(&self, u: [f64; 2]) -> DirectSample {
        let target = Target::Environment;
        if self.is_delta() {
            return DirectSample {
                direction: self.to_light,
                pdf: 1.0,
                radiance: self.irradiance,
                is_delta: true,
                target,
            };
        }
        DirectSample {
            direction: self.sample(u),
            pdf: self.density(),
            radiance: self.radiance,
            is_delta: false,
            target,
        }
    }

    /// Density per steradian of [`Self::sample_direct`]; 0 for a light of no extent.
    #[inline]
    pub fn pdf_direct(&self, direction: DVec3) -> f64 {
        if self.is_seen(direction) { self.density() } else { 0.0 }
    }

    /// A ray that comes in from afar, its start uniform on a disc across it that covers the sphere around the scene.
    pub fn sample_ray(&self, bounds: &Sphere, start: [f64; 2], direction: [f64; 2]) -> EmittedRay {
        let sample = self.sample_direct(direction);
        EmittedRay {
            ray: coming_in(bounds, start, sample.direction),
            radiance: sample.radiance,
            cosine: 1.0,
            pdf_position: 1.0 / (PI * bounds.radius * bounds.radius),
            pdf_direction: sample.pdf,
            start: None,
            is_front: true,
            light: Some(self.object),
        }
    }

    /// Densities of [`Self::sample_ray`] for a ray along `direction`: per area of the disc across it and per steradian, which of a light of no
    /// extent is 0 for every ray that was not sampled from it.
    pub fn pdf_ray(&self, bounds: &Sphere, direction: DVec3) -> [f64; 2] {
        [1.0 / (PI * bounds.radius * bounds.radius), self.pdf_direct(-direction)]
    }

    #[inline]
    fn sample(&self, u: [f64; 2]) -> DVec3 {
        // At the rim, rounding must not lead outside.
        in_cone(self.to_light, u[0] * self.one_minus_cos * (1.0 - 1e-9), u[1])
    }

    #[inline]
    fn density(&self) -> f64 {
        1.0 / (TAU * self.one_minus_cos)
    }
}

/// The ray from unit `to_light` whose start is uniform on a disc across it that covers the sphere.
pub(super) fn coming_in(bounds: &Sphere, start: [f64; 2], to_light: DVec3) -> Ray {
    let (tangent, bitangent) = frame(to_light);
    let (sin, cos) = (TAU * start[1]).sin_cos();
    let across = (tangent * cos + bitangent * sin) * (start[0].sqrt() * bounds.radius);
    Ray::new(bounds.center + to_light * bounds.radius + across, -to_light)
}
