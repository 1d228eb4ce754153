//! Where light comes from, ready to be sampled: from a point that it falls on, and as rays that leave it.

mod area;
mod environment;
mod sample;
#[cfg(test)]
mod tests;

use glam::DVec3;

pub use area::AreaLight;
pub use environment::{EnvironmentLight, ImageLight, ImageTables};
pub use sample::{DirectSample, EmittedRay, Target};

use super::ObjectId;
use crate::geometry::{Geometry, SurfacePoint};
use crate::spectrum::Spectrum;

/// One light.
#[derive(Debug, Clone, Copy)]
pub enum Light<'a> {
    Area(&'a AreaLight),
    Environment(&'a EnvironmentLight),
}

impl Light<'_> {
    /// A direction from `from` towards this light, for `u` uniform in [0, 1)³; `None` where none can be seen, and where sampling would gain
    /// nothing: an environment that is no image.
    #[inline]
    pub fn sample_direct(&self, geometry: &Geometry, from: DVec3, u: [f64; 3]) -> Option<DirectSample> {
        match self {
            Self::Area(light) => light.sample_direct(geometry, from, u),
            Self::Environment(light) => light.sample([u[1], u[2]]),
        }
    }

    /// Density per steradian with which [`Self::sample_direct`] gives `direction`, which meets this light at `point` (none of the environment).
    #[inline]
    pub fn pdf_direct(&self, geometry: &Geometry, from: DVec3, direction: DVec3, point: Option<&SurfacePoint>) -> f64 {
        match (self, point) {
            (Self::Area(light), Some(point)) => light.pdf_direct(geometry, from, direction, point),
            (Self::Area(_), None) => 0.0,
            (Self::Environment(light), _) => light.pdf(direction),
        }
    }

    /// Radiance that arrives from `direction` where the light is met.
    #[inline]
    pub fn radiance(&self, direction: DVec3) -> Spectrum {
        match self {
            Self::Area(light) => light.radiance,
            Self::Environment(light) => light.radiance(direction),
        }
    }

    /// A ray that leaves this light, for numbers uniform in [0, 1). `None` where there is none: from the environment of a scene without
    /// objects, and from a triangle without area.
    pub fn sample_ray(&self, geometry: &Geometry, start: [f64; 3], direction: [f64; 2]) -> Option<EmittedRay> {
        match self {
            Self::Area(light) => light.sample_ray(geometry, start, direction),
            Self::Environment(light) => light.sample_ray(geometry.bounding_sphere()?, [start[1], start[2]], direction),
        }
    }

    /// Densities of [`Self::sample_ray`], per area and per steradian, for a ray along `direction` that starts where the light's surface has
    /// that `normal` (of an object).
    pub fn pdf_ray(&self, geometry: &Geometry, normal: DVec3, direction: DVec3) -> [f64; 2] {
        match self {
            Self::Area(light) => light.pdf_ray(normal, direction),
            Self::Environment(light) => {
                geometry.bounding_sphere().map_or([0.0; 2], |bounds| light.pdf_ray(bounds, direction))
            }
        }
    }
}

/// Every object that emits, chosen in proportion to its power.
#[derive(Debug, Clone, Default)]
pub struct Emitters {
    /// In ascending order of objects.
    list: Vec<Emitter>,
}

#[derive(Debug, Clone)]
struct Emitter {
    light: AreaLight,
    probability: f64,
    /// Sum of the probabilities up to and including this one.
    cumulative: f64,
}

impl Emitters {
    /// From objects, in ascending order, and their radiances; black ones and ones without area are left out.
    pub fn new(geometry: &Geometry, lights: impl IntoIterator<Item = (ObjectId, Spectrum)>) -> Self {
        let mut list: Vec<Emitter> = lights
            .into_iter()
            .map(|(object, radiance)| AreaLight { object, radiance, area: geometry.area(object.0) })
            .map(|light| Emitter { light, probability: light.area * light.radiance.sum(), cumulative: 0.0 })
            .filter(|emitter| emitter.probability > 0.0)
            .collect();
        let total: f64 = list.iter().map(|emitter| emitter.probability).sum();
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

    /// Each light with the probability that it is chosen.
    pub fn iter(&self) -> impl Iterator<Item = (&AreaLight, f64)> {
        self.list.iter().map(|emitter| (&emitter.light, emitter.probability))
    }

    /// The light that `select`, uniform in [0, 1), chooses, its probability, and what is left of `select`, again uniform in [0, 1). `None`
    /// where there is none.
    #[inline]
    pub fn choose(&self, select: f64) -> Option<(&AreaLight, f64, f64)> {
        let index = self.list.partition_point(|e| e.cumulative <= select).min(self.list.len().checked_sub(1)?);
        let Emitter { light, probability, cumulative } = &self.list[index];
        let before = cumulative - probability;
        let rest = ((select - before) / probability).clamp(0.0, 1.0 - f64::EPSILON);
        Some((light, *probability, rest))
    }

    /// The light that this object is, and the probability that it is chosen.
    #[inline]
    pub fn find(&self, object: ObjectId) -> Option<(&AreaLight, f64)> {
        let index = self.list.binary_search_by_key(&object, |emitter| emitter.light.object).ok()?;
        Some((&self.list[index].light, self.list[index].probability))
    }

    /// A direction from `from` towards a point that emits. `None` where the chosen light cannot be seen from there.
    #[inline]
    pub fn sample_direct(&self, geometry: &Geometry, from: DVec3, select: f64, u: [f64; 2]) -> Option<DirectSample> {
        let (light, probability, rest) = self.choose(select)?;
        let sample = light.sample_direct(geometry, from, [rest, u[0], u[1]])?;
        let pdf = sample.pdf * probability;
        (pdf > 0.0 && pdf.is_finite()).then_some(DirectSample { pdf, ..sample })
    }

    /// Density per steradian with which [`Self::sample_direct`] gives the `direction` from `from` to `point` of `object`.
    #[inline]
    pub fn pdf_direct(
        &self,
        geometry: &Geometry,
        from: DVec3,
        direction: DVec3,
        object: ObjectId,
        point: &SurfacePoint,
    ) -> f64 {
        self.find(object)
            .map_or(0.0, |(light, probability)| probability * light.pdf_direct(geometry, from, direction, point))
    }
}
