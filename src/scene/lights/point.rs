//! Lights at a point, which nothing meets: equal in all directions, or in a cone.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::sample::{DirectSample, EmittedRay, Target};
use crate::geometry::{Ray, uniform_direction};
use crate::scatter::frame;
use crate::scene::ObjectId;
use crate::spectrum::Spectrum;

/// A light that shines equally in all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLight {
    pub object: ObjectId,
    /// Local coordinates.
    pub position: DVec3,
    /// Per steradian.
    pub intensity: Spectrum,
}

impl PointLight {
    /// 4π·intensity, summed over the bands.
    pub fn power(&self) -> f64 {
        4.0 * PI * self.intensity.sum()
    }

    /// The one direction from `from` towards it.
    #[inline]
    pub fn sample_direct(&self, from: DVec3) -> Option<DirectSample> {
        towards(from, self.position, |_| self.intensity)
    }

    /// A ray in a uniform direction.
    pub fn sample_ray(&self, direction: [f64; 2]) -> EmittedRay {
        let direction = uniform_direction(direction);
        leaving(self.object, self.position, direction, self.intensity, 1.0 / (4.0 * PI))
    }

    /// Density per steradian of [`Self::sample_ray`].
    pub fn pdf_ray(&self) -> f64 {
        1.0 / (4.0 * PI)
    }
}

/// A light that shines in a cone. With c the cosine of the angle to the cone's axis, its intensity is that along the axis times
/// clamp((c − cos outer)/(cos inner − cos outer), 0, 1)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotLight {
    pub object: ObjectId,
    /// Local coordinates.
    pub position: DVec3,
    /// Unit.
    pub axis: DVec3,
    /// Per steradian, along the axis.
    pub intensity: Spectrum,
    /// 1 − cos of the half angle within which it is brightest.
    inner: f64,
    /// 1 − cos of the half angle beyond which it is dark.
    outer: f64,
}

impl SpotLight {
    /// Half angles in degrees, 0 ≤ inner ≤ outer ≤ 180, outer > 0.
    pub fn new(object: ObjectId, position: DVec3, axis: DVec3, intensity: Spectrum, angles: [f64; 2]) -> Self {
        let [inner, outer] = angles.map(one_minus_cos);
        Self { object, position, axis, intensity, inner, outer }
    }

    /// Steradians that a light as bright in all of them as this one is along its axis would have to fill to emit as much: its power is this times its
    /// intensity.
    pub fn extent(&self) -> f64 {
        extent(self.inner, self.outer)
    }

    /// Intensity · [`Self::extent`], summed over the bands.
    pub fn power(&self) -> f64 {
        self.extent() * self.intensity.sum()
    }

    /// Share of the intensity along the axis that goes along unit `direction`.
    #[inline]
    pub fn falloff(&self, direction: DVec3) -> f64 {
        // Half the square of the difference is 1 − cos, without cancellation.
        let one_minus_cos = 0.5 * (direction - self.axis).length_squared();
        if one_minus_cos <= self.inner {
            1.0
        } else if one_minus_cos >= self.outer {
            0.0
        } else {
            ((self.outer - one_minus_cos) / (self.outer - self.inner)).powi(2)
        }
    }

    /// 1 − cos of the half angles, inner and outer.
    pub fn edges(&self) -> [f64; 2] {
        [self.inner, self.outer]
    }

    /// The one direction from `from` towards it; `None` where it is dark.
    #[inline]
    pub fn sample_direct(&self, from: DVec3) -> Option<DirectSample> {
        towards(from, self.position, |direction| self.intensity * self.falloff(direction))
    }

    /// A ray in a direction of a density in proportion to the intensity.
    pub fn sample_ray(&self, direction: [f64; 2]) -> EmittedRay {
        let edge = (self.outer - self.inner) / 3.0;
        let at = direction[0] * (self.inner + edge);
        let one_minus_cos = if at < self.inner {
            at
        } else {
            // The cumulative share of the edge, from outside, is the cube of the place in it.
            let rest = ((at - self.inner) / edge).clamp(0.0, 1.0);
            self.outer - (self.outer - self.inner) * (1.0 - rest).cbrt()
        };
        let direction = in_cone(self.axis, one_minus_cos, direction[1]);
        let falloff = self.falloff(direction);
        leaving(self.object, self.position, direction, self.intensity * falloff, falloff / self.extent())
    }

    /// Density per steradian of [`Self::sample_ray`].
    pub fn pdf_ray(&self, direction: DVec3) -> f64 {
        self.falloff(direction) / self.extent()
    }
}

/// [`SpotLight::extent`] by half angles in degrees.
pub fn spot_extent(inner_angle: f64, outer_angle: f64) -> f64 {
    extent(one_minus_cos(inner_angle), one_minus_cos(outer_angle))
}

fn extent(inner: f64, outer: f64) -> f64 {
    TAU * (inner + (outer - inner) / 3.0)
}

/// 1 − cos of an angle in degrees, without cancellation.
pub(super) fn one_minus_cos(degrees: f64) -> f64 {
    2.0 * (0.5 * degrees.to_radians()).sin().powi(2)
}

/// The unit direction at an angle of that 1 − cos to unit `axis`, and `turn` ∈ [0, 1) of the way around it.
#[inline]
pub(super) fn in_cone(axis: DVec3, one_minus_cos: f64, turn: f64) -> DVec3 {
    let sin = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = (TAU * turn).sin_cos();
    let (tangent, bitangent) = frame(axis);
    (axis * (1.0 - one_minus_cos) + (tangent * cos_phi + bitangent * sin_phi) * sin).normalize()
}

/// `intensity` is asked for the direction that the light goes.
#[inline]
fn towards(from: DVec3, position: DVec3, intensity: impl Fn(DVec3) -> Spectrum) -> Option<DirectSample> {
    let to_light = position - from;
    let distance = to_light.length();
    let direction = to_light.try_normalize()?;
    // Twice, since the square of a small distance may be 0.
    let radiance = intensity(-direction) * (1.0 / distance) * (1.0 / distance);
    let target = Target::Point { distance };
    (!radiance.is_black()).then_some(DirectSample { direction, pdf: 1.0, radiance, is_delta: true, target })
}

fn leaving(light: ObjectId, position: DVec3, direction: DVec3, intensity: Spectrum, pdf_direction: f64) -> EmittedRay {
    EmittedRay {
        ray: Ray::new(position, direction),
        radiance: intensity,
        cosine: 1.0,
        pdf_position: 1.0,
        pdf_direction,
        start: None,
        is_front: true,
        light: Some(light),
    }
}
