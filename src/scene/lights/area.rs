//! Objects that emit, from their outward sides and equally bright in all directions.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::sample::{DirectSample, EmittedRay, Target};
use crate::geometry::{Geometry, ObjectRange, Ray, SurfacePoint};
use crate::scatter::{Normals, frame, lambert};
use crate::scene::ObjectId;
use crate::spectrum::Spectrum;

/// An emitting object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaLight {
    pub object: ObjectId,
    pub radiance: Spectrum,
    /// > 0, in scene units squared.
    pub area: f64,
    /// Whether the inward side emits too.
    pub two_sided: bool,
}

impl AreaLight {
    /// π·radiance·area, summed over the bands; twice that of a light with two sides.
    pub fn power(&self) -> f64 {
        PI * self.radiance.sum() * self.area * self.sides()
    }

    fn sides(&self) -> f64 {
        if self.two_sided { 2.0 } else { 1.0 }
    }

    /// A direction from `from` towards a point that emits, and its density per steradian; `None` where none can be seen. A sphere is sampled
    /// by the cone under which it is seen, a mesh by area.
    #[inline]
    pub fn sample_direct(&self, geometry: &Geometry, from: DVec3, u: [f64; 3]) -> Option<DirectSample> {
        let (direction, pdf, primitive) = match geometry.range(self.object.0) {
            ObjectRange::Sphere(id) => {
                let sphere = geometry.sphere(*id)?;
                let to_center = sphere.center - from;
                let one_minus_cos_max = one_minus_cos_of_cone(to_center.length(), sphere.radius)?;
                let one_minus_cos = u[1] * one_minus_cos_max;
                let sin = (one_minus_cos * (2.0 - one_minus_cos)).sqrt();
                let (sin_phi, cos_phi) = (TAU * u[2]).sin_cos();
                let axis = to_center.normalize();
                let (tangent, bitangent) = frame(axis);
                let direction = axis * (1.0 - one_minus_cos) + (tangent * cos_phi + bitangent * sin_phi) * sin;
                (direction.normalize(), 1.0 / (TAU * one_minus_cos_max), *id)
            }
            ObjectRange::Triangles(_) => {
                let point = geometry.sample_surface(self.object.0, u)?;
                let direction = (point.position - from).try_normalize()?;
                (direction, self.triangle_pdf(from, direction, &point)?, point.primitive)
            }
        };
        let target = Target::Surface { object: self.object, primitive };
        Some(DirectSample { direction, pdf, radiance: self.radiance, is_delta: false, target })
    }

    /// Density per steradian with which [`Self::sample_direct`] gives the `direction` from `from` to `point`, which lies on this light.
    #[inline]
    pub fn pdf_direct(&self, geometry: &Geometry, from: DVec3, direction: DVec3, point: &SurfacePoint) -> f64 {
        match geometry.sphere(point.primitive) {
            Some(sphere) => one_minus_cos_of_cone((sphere.center - from).length(), sphere.radius)
                .map_or(0.0, |one_minus_cos| 1.0 / (TAU * one_minus_cos)),
            None => self.triangle_pdf(from, direction, point).unwrap_or(0.0),
        }
    }

    /// A ray that leaves the light: its start uniform by area, its direction by the cosine to the normal there, of a light with two sides on
    /// either. `None` from an object whose sampled triangle has no area.
    pub fn sample_ray(&self, geometry: &Geometry, start: [f64; 3], mut direction: [f64; 2]) -> Option<EmittedRay> {
        let mut point = geometry.sample_surface(self.object.0, start)?;
        let mut is_front = true;
        if self.two_sided {
            // The rest of the number is uniform again.
            let doubled = 2.0 * direction[0];
            direction[0] = doubled.fract();
            is_front = doubled < 1.0;
            point.normal *= if is_front { 1.0 } else { -1.0 };
        }
        let (direction, pdf_direction) = lambert::sample(&Normals::flat(point.normal), direction);
        Some(EmittedRay {
            ray: Ray::leaving(point.position, direction, point.primitive),
            radiance: self.radiance,
            cosine: direction.dot(point.normal),
            pdf_position: 1.0 / self.area,
            pdf_direction: pdf_direction / self.sides(),
            start: Some(point),
            is_front,
            light: Some(self.object),
        })
    }

    /// Densities of [`Self::sample_ray`]: of a start, per area, and of a `direction` at a place of that `normal`, per steradian.
    pub fn pdf_ray(&self, normal: DVec3, direction: DVec3) -> [f64; 2] {
        let normal = if self.two_sided && direction.dot(normal) < 0.0 { -normal } else { normal };
        [1.0 / self.area, lambert::pdf(&Normals::flat(normal), direction) / self.sides()]
    }

    fn triangle_pdf(&self, from: DVec3, direction: DVec3, point: &SurfacePoint) -> Option<f64> {
        let cos = -direction.dot(point.normal);
        let cos = if self.two_sided { cos.abs() } else { cos };
        let squared_distance = (point.position - from).length_squared();
        (cos > 0.0).then(|| squared_distance / (self.area * cos))
    }
}

/// 1 − cos of the half angle under which a sphere is seen, without cancellation; `None` from inside.
fn one_minus_cos_of_cone(distance: f64, radius: f64) -> Option<f64> {
    (distance > radius).then(|| {
        let sin_squared = (radius / distance).powi(2);
        sin_squared / (1.0 + (1.0 - sin_squared).sqrt())
    })
}
