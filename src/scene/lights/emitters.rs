//! All lights but the environment, and the choice among them.

use glam::DVec3;

use super::{AreaLight, DirectSample, DirectionalLight, Light, PointLight, SpotLight};
use crate::geometry::{Geometry, SurfacePoint};
use crate::scene::ObjectId;

/// A light that is an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Emitter {
    Area(AreaLight),
    Point(PointLight),
    Spot(SpotLight),
    Directional(DirectionalLight),
}

impl Emitter {
    #[inline]
    pub fn light(&self) -> Light<'_> {
        match self {
            Self::Area(light) => Light::Area(light),
            Self::Point(light) => Light::Point(light),
            Self::Spot(light) => Light::Spot(light),
            Self::Directional(light) => Light::Directional(light),
        }
    }

    #[inline]
    pub fn object(&self) -> ObjectId {
        match self {
            Self::Area(light) => light.object,
            Self::Point(light) => light.object,
            Self::Spot(light) => light.object,
            Self::Directional(light) => light.object,
        }
    }
}

/// Every light but the environment, chosen in proportion to its power.
#[derive(Debug, Clone, Default)]
pub struct Emitters {
    /// In ascending order of objects.
    list: Vec<Choice>,
    /// Where in the list the directional lights stand that can be seen.
    suns: Vec<u32>,
}

#[derive(Debug, Clone)]
struct Choice {
    emitter: Emitter,
    probability: f64,
    /// Sum of the probabilities up to and including this one.
    cumulative: f64,
}

/// The power of a light, or what stands for it where there is nothing to shine on.
fn weight(emitter: &Emitter, geometry: &Geometry) -> f64 {
    match emitter {
        Emitter::Directional(light) if geometry.bounding_sphere().is_none() => light.irradiance.sum(),
        _ => emitter.light().power(geometry),
    }
}

impl Emitters {
    /// From lights in ascending order of objects; black ones and ones without area are left out.
    pub fn new(geometry: &Geometry, emitters: impl IntoIterator<Item = Emitter>) -> Self {
        let mut list: Vec<Choice> = emitters
            .into_iter()
            .map(|emitter| Choice { emitter, probability: weight(&emitter, geometry), cumulative: 0.0 })
            .filter(|choice| choice.probability > 0.0)
            .collect();
        let total: f64 = list.iter().map(|choice| choice.probability).sum();
        let mut cumulative = 0.0;
        for choice in &mut list {
            choice.probability /= total;
            cumulative += choice.probability;
            choice.cumulative = cumulative;
        }
        let is_sun = |choice: &Choice| matches!(choice.emitter, Emitter::Directional(light) if !light.is_delta());
        let suns = list.iter().zip(0..).filter(|(choice, _)| is_sun(choice)).map(|(_, index)| index).collect();
        Self { list, suns }
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Each light with the probability that it is chosen.
    pub fn iter(&self) -> impl Iterator<Item = (Light<'_>, f64)> {
        self.list.iter().map(|choice| (choice.emitter.light(), choice.probability))
    }

    #[inline]
    pub fn has_suns(&self) -> bool {
        !self.suns.is_empty()
    }

    /// The directional lights that rays see which escape, each with the probability that it is chosen.
    #[inline]
    pub fn suns(&self) -> impl Iterator<Item = (&DirectionalLight, f64)> {
        self.suns.iter().filter_map(|&index| {
            let Choice { emitter, probability, .. } = &self.list[index as usize];
            if let Emitter::Directional(light) = emitter { Some((light, *probability)) } else { None }
        })
    }

    /// The light that `select`, uniform in [0, 1), chooses, its probability, and what is left of `select`, again uniform in [0, 1). `None`
    /// where there is none.
    #[inline]
    pub fn choose(&self, select: f64) -> Option<(Light<'_>, f64, f64)> {
        let index = self.list.partition_point(|c| c.cumulative <= select).min(self.list.len().checked_sub(1)?);
        let Choice { emitter, probability, cumulative } = &self.list[index];
        let before = cumulative - probability;
        let rest = ((select - before) / probability).clamp(0.0, 1.0 - f64::EPSILON);
        Some((emitter.light(), *probability, rest))
    }

    /// The light that this object is, and the probability that it is chosen.
    #[inline]
    pub fn find(&self, object: ObjectId) -> Option<(Light<'_>, f64)> {
        let index = self.list.binary_search_by_key(&object, |choice| choice.emitter.object()).ok()?;
        Some((self.list[index].emitter.light(), self.list[index].probability))
    }

    /// A direction from `from` towards a light. `None` where the chosen light cannot be seen from there.
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
            .map_or(0.0, |(light, probability)| probability * light.pdf_direct(geometry, from, direction, Some(point)))
    }
}
