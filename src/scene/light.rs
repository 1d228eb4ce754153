//! Emitting objects, ready to be sampled.

use std::f64::consts::TAU;

use glam::DVec3;

use super::environment::DirectionSample;
use super::ids::ObjectId;
use crate::geometry::{Geometry, ObjectRange, SurfacePoint};
use crate::scatter::frame;

/// Every light of the scene, chosen in proportion to its power.
#[derive(Debug, Clone, Default)]
pub struct Emitters {
    /// In ascending order of objects.
    list: Vec<Emitter>,
}

#[derive(Debug, Clone)]
struct Emitter {
    object: ObjectId,
    probability: f64,
    /// Sum of the probabilities up to and including this one.
    cumulative: f64,
}

impl Emitters {
    /// From objects, in ascending order, and their radiances; black ones and ones without area are left out.
    pub fn new(geometry: &Geometry, lights: impl IntoIterator<Item = (ObjectId, DVec3)>) -> Self {
        let mut list: Vec<Emitter> = lights
            .into_iter()
            .map(|(object, radiance)| {
                let power = geometry.area(object.0) * radiance.element_sum();
                Emitter { object, probability: power, cumulative: 0.0 }
            })
            .filter(|e| e.probability > 0.0)
            .collect();
        let total: f64 = list.iter().map(|e| e.probability).sum();
        let mut cumulative = 0.0;
        for emitter in &mut list {
            emitter.probability /= total;
            cumulative += emitter.probability;
            emitter.cumulative = cumulative;
        }
        Self { list }
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// A direction from `from` towards a point that emits, and the object it lies on. `None` where the chosen light cannot be seen
    /// from there.
    #[inline]
    pub fn sample(
        &self,
        geometry: &Geometry,
        from: DVec3,
        select: f64,
        u: [f64; 2],
    ) -> Option<(ObjectId, DirectionSample)> {
        let index = self.list.partition_point(|e| e.cumulative <= select).min(self.list.len().checked_sub(1)?);
        let emitter = &self.list[index];
        let sample = match geometry.range(emitter.object.0) {
            ObjectRange::Sphere(id) => {
                let sphere = geometry.sphere(*id)?;
                let to_center = sphere.center - from;
                let one_minus_cos_max = one_minus_cos_of_cone(to_center.length(), sphere.radius)?;
                let one_minus_cos = u[0] * one_minus_cos_max;
                let sin = (one_minus_cos * (2.0 - one_minus_cos)).sqrt();
                let (sin_phi, cos_phi) = (TAU * u[1]).sin_cos();
                let axis = to_center.normalize();
                let (tangent, bitangent) = frame(axis);
                let direction = axis * (1.0 - one_minus_cos) + (tangent * cos_phi + bitangent * sin_phi) * sin;
                let pdf = emitter.probability / (TAU * one_minus_cos_max);
                DirectionSample { direction: direction.normalize(), pdf }
            }
            ObjectRange::Triangles(_) => {
                // What is left of `select` chooses the triangle.
                let before = emitter.cumulative - emitter.probability;
                let rest = ((select - before) / emitter.probability).clamp(0.0, 1.0 - f64::EPSILON);
                let point = geometry.sample_surface(emitter.object.0, [rest, u[0], u[1]])?;
                let direction = (point.position - from).try_normalize()?;
                let pdf = self.triangle_pdf(emitter, geometry, from, direction, &point)?;
                DirectionSample { direction, pdf }
            }
        };
        (sample.pdf > 0.0 && sample.pdf.is_finite()).then_some((emitter.object, sample))
    }

    /// Probability per steradian with which [`Self::sample`] gives the direction from `from` to `point` of `object`.
    pub fn pdf(
        &self,
        geometry: &Geometry,
        from: DVec3,
        direction: DVec3,
        object: ObjectId,
        point: &SurfacePoint,
    ) -> f64 {
        let Ok(index) = self.list.binary_search_by_key(&object, |e| e.object) else { return 0.0 };
        let emitter = &self.list[index];
        match geometry.sphere(point.primitive) {
            Some(sphere) => one_minus_cos_of_cone((sphere.center - from).length(), sphere.radius)
                .map_or(0.0, |one_minus_cos| emitter.probability / (TAU * one_minus_cos)),
            None => self.triangle_pdf(emitter, geometry, from, direction, point).unwrap_or(0.0),
        }
    }

    fn triangle_pdf(
        &self,
        emitter: &Emitter,
        geometry: &Geometry,
        from: DVec3,
        direction: DVec3,
        point: &SurfacePoint,
    ) -> Option<f64> {
        let cos = -direction.dot(point.normal);
        let squared_distance = (point.position - from).length_squared();
        (cos > 0.0).then(|| emitter.probability * squared_distance / (geometry.area(emitter.object.0) * cos))
    }
}

/// 1 − cos of the half angle under which a sphere is seen, without cancellation; `None` from inside.
fn one_minus_cos_of_cone(distance: f64, radius: f64) -> Option<f64> {
    (distance > radius).then(|| {
        let sin_squared = (radius / distance).powi(2);
        sin_squared / (1.0 + (1.0 - sin_squared).sqrt())
    })
}
