//! Where light comes from, ready to be sampled: from a point that it falls on, and as rays that leave it.

mod area;
mod directional;
mod emitters;
mod environment;
mod point;
mod sample;
#[cfg(test)]
mod tests;

use glam::DVec3;

pub use area::AreaLight;
pub use directional::DirectionalLight;
pub use emitters::{Emitter, Emitters};
pub use environment::{EnvironmentLight, ImageLight, ImageTables};
pub use point::{PointLight, SpotLight, spot_extent};
pub use sample::{DirectSample, EmittedRay, Target};

use super::ObjectId;
use crate::geometry::{Geometry, SurfacePoint};
use crate::spectrum::Spectrum;

/// One light.
#[derive(Debug, Clone, Copy)]
pub enum Light<'a> {
    Area(&'a AreaLight),
    Point(&'a PointLight),
    Spot(&'a SpotLight),
    Directional(&'a DirectionalLight),
    Environment(&'a EnvironmentLight),
}

impl Light<'_> {
    /// The object that it is; `None` of the environment.
    pub fn object(&self) -> Option<ObjectId> {
        match self {
            Self::Area(light) => Some(light.object),
            Self::Point(light) => Some(light.object),
            Self::Spot(light) => Some(light.object),
            Self::Directional(light) => Some(light.object),
            Self::Environment(_) => None,
        }
    }

    /// Whether all its light comes from one point: nothing meets it, and `pdf_position` is 1.
    pub fn is_delta_position(&self) -> bool {
        matches!(self, Self::Point(_) | Self::Spot(_))
    }

    /// Whether all its light goes in one direction: nothing sees it, and `pdf_direction` is 1.
    pub fn is_delta_direction(&self) -> bool {
        matches!(self, Self::Directional(light) if light.is_delta())
    }

    /// What it emits, summed over the bands; of the environment and of a directional light what falls into the scene's bounding sphere, which is 0
    /// where there are no objects.
    pub fn power(&self, geometry: &Geometry) -> f64 {
        let bounds = geometry.bounding_sphere();
        match self {
            Self::Area(light) => light.power(),
            Self::Point(light) => light.power(),
            Self::Spot(light) => light.power(),
            Self::Directional(light) => bounds.map_or(0.0, |bounds| light.power(bounds)),
            Self::Environment(light) => bounds.map_or(0.0, |bounds| light.power(bounds)),
        }
    }

    /// A direction from `from` towards this light, for `u` uniform in [0, 1)³; `None` where none can be seen, and where sampling would gain
    /// nothing: an environment that is no image.
    #[inline]
    pub fn sample_direct(&self, geometry: &Geometry, from: DVec3, u: [f64; 3]) -> Option<DirectSample> {
        match self {
            Self::Area(light) => light.sample_direct(geometry, from, u),
            Self::Point(light) => light.sample_direct(from),
            Self::Spot(light) => light.sample_direct(from),
            Self::Directional(light) => Some(light.sample_direct([u[1], u[2]])),
            Self::Environment(light) => light.sample([u[1], u[2]]),
        }
    }

    /// Density per steradian with which [`Self::sample_direct`] gives `direction`, which meets this light at `point` (none of what lies afar). Of
    /// a delta light it is 0: no other way of sampling finds it.
    #[inline]
    pub fn pdf_direct(&self, geometry: &Geometry, from: DVec3, direction: DVec3, point: Option<&SurfacePoint>) -> f64 {
        match (self, point) {
            (Self::Area(light), Some(point)) => light.pdf_direct(geometry, from, direction, point),
            (Self::Area(_), None) | (Self::Point(_) | Self::Spot(_), _) => 0.0,
            (Self::Directional(light), _) => light.pdf_direct(direction),
            (Self::Environment(light), _) => light.pdf(direction),
        }
    }

    /// Radiance that arrives from `direction` where the light is met; black of a delta light.
    #[inline]
    pub fn radiance(&self, direction: DVec3) -> Spectrum {
        match self {
            Self::Area(light) => light.radiance,
            Self::Point(_) | Self::Spot(_) => Spectrum::ZERO,
            Self::Directional(light) => light.radiance(direction),
            Self::Environment(light) => light.radiance(direction),
        }
    }

    /// What an emitted ray along `direction` carries in its `radiance`: of a light at a point the intensity.
    #[inline]
    pub fn emitted(&self, direction: DVec3) -> Spectrum {
        match self {
            Self::Point(light) => light.intensity,
            Self::Spot(light) => light.intensity * light.falloff(direction),
            Self::Directional(light) if light.is_delta() => light.irradiance,
            Self::Area(_) | Self::Directional(_) | Self::Environment(_) => self.radiance(-direction),
        }
    }

    /// A ray that leaves this light, for numbers uniform in [0, 1). `None` where there is none: from afar in a scene without objects, and
    /// from a triangle without area.
    pub fn sample_ray(&self, geometry: &Geometry, start: [f64; 3], direction: [f64; 2]) -> Option<EmittedRay> {
        let on_disc = [start[1], start[2]];
        match self {
            Self::Area(light) => light.sample_ray(geometry, start, direction),
            Self::Point(light) => Some(light.sample_ray(direction)),
            Self::Spot(light) => Some(light.sample_ray(direction)),
            Self::Directional(light) => Some(light.sample_ray(geometry.bounding_sphere()?, on_disc, direction)),
            Self::Environment(light) => light.sample_ray(geometry.bounding_sphere()?, on_disc, direction),
        }
    }

    /// Densities of [`Self::sample_ray`], per area and per steradian, for a ray along `direction` that starts where the light's surface has
    /// that `normal` (of an object). A delta position has 1, as it is told by [`EmittedRay::pdf_position`]; a delta direction has 0, as no
    /// other way of sampling finds it.
    pub fn pdf_ray(&self, geometry: &Geometry, normal: DVec3, direction: DVec3) -> [f64; 2] {
        let bounds = geometry.bounding_sphere();
        match self {
            Self::Area(light) => light.pdf_ray(normal, direction),
            Self::Point(light) => [1.0, light.pdf_ray()],
            Self::Spot(light) => [1.0, light.pdf_ray(direction)],
            Self::Directional(light) => bounds.map_or([0.0; 2], |bounds| light.pdf_ray(bounds, direction)),
            Self::Environment(light) => bounds.map_or([0.0; 2], |bounds| light.pdf_ray(bounds, direction)),
        }
    }
}
