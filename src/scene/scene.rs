//! The compiled scene: what tracing needs, and nothing else.

use std::sync::Arc;

use glam::DVec3;

use super::declared::Declared;
pub use super::ids::{MediumId, ObjectId};
use super::lights::{Emitters, EnvironmentLight, Light};
use super::needs::SceneNeeds;
use super::texture::SurfaceTexture;
use crate::geometry::{Enclosure, Geometry, Hit, SurfacePoint, Topology, WindingTree};
use crate::optics::{Interface, Ior};
use crate::spectrum::{Spectrum, Wavelengths};

/// A medium with its numbers worked out for transport in RGB.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneMedium {
    /// As in the scene; the global medium is `"world"`, the reserved one `"vacuum"`.
    pub name: String,
    /// At every wavelength.
    pub model: Ior,
    /// n − 1 at the d line, which keeps the digits of an IOR near 1.
    pub ior_minus_one: f64,
    /// σ per scene unit.
    pub absorption: Spectrum,
}

impl SceneMedium {
    pub fn ior(&self) -> f64 {
        1.0 + self.ior_minus_one
    }
}

/// The interface between each ordered pair of media, as RGB meets it.
#[derive(Debug, Clone, Default)]
pub struct Interfaces {
    media: usize,
    /// By `from * media + to`; empty where there are too many to be kept.
    pairs: Vec<Interface>,
}

impl Interfaces {
    /// Media up to which all pairs are kept.
    const MOST: usize = 64;

    pub fn new(media: &[SceneMedium]) -> Self {
        if media.len() > Self::MOST {
            return Self::default();
        }
        let between = |from: &SceneMedium, to: &SceneMedium| Interface::new(from.ior_minus_one, to.ior_minus_one);
        let pairs = media.iter().flat_map(|from| media.iter().map(move |to| between(from, to))).collect();
        Self { media: media.len(), pairs }
    }

    #[inline]
    fn between(&self, media: &[SceneMedium], from: MediumId, to: MediumId, wavelengths: Wavelengths) -> Interface {
        let (from, to) = (from.0 as usize, to.0 as usize);
        match wavelengths {
            Wavelengths::Rgb => match self.pairs.get(from * self.media + to) {
                Some(interface) => *interface,
                None => Interface::new(media[from].ior_minus_one, media[to].ior_minus_one),
            },
            Wavelengths::Single { um } => {
                Interface::new(media[from].model.ior_minus_one(um), media[to].model.ior_minus_one(um))
            }
        }
    }
}

/// What an object's surface does.
#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    Refractor {
        medium: MediumId,
        priority: i32,
        smooth: bool,
    },
    Diffuse {
        albedo: Albedo,
        smooth: bool,
    },
    Mirror {
        albedo: Albedo,
        smooth: bool,
    },
    /// Black where the light has no surface.
    Light {
        radiance: Spectrum,
        two_sided: bool,
    },
}

/// Albedo by place.
#[derive(Debug, Clone, PartialEq)]
pub enum Albedo {
    Color(Spectrum),
    /// Squares over object-space coordinates (u, v) = (dot(p − origin, u_axis), dot(p − origin, v_axis)) / size.
    Checker {
        a: Spectrum,
        b: Spectrum,
        origin: DVec3,
        u_axis: DVec3,
        v_axis: DVec3,
    },
    Texture(Arc<SurfaceTexture>),
}

impl Albedo {
    /// At a hit, whose place on the surface is `point`.
    #[inline]
    pub fn at(&self, hit: &Hit, point: &SurfacePoint) -> Spectrum {
        match self {
            Self::Color(color) => *color,
            Self::Checker { a, b, origin, u_axis, v_axis } => {
                let p = point.position - *origin;
                // Half of an even number is whole.
                let half = 0.5 * (p.dot(*u_axis).floor() + p.dot(*v_axis).floor());
                if half.floor() == half { *a } else { *b }
            }
            Self::Texture(texture) => texture.at(hit, point.normal),
        }
    }

    /// The image on the surface, if there is one.
    pub fn texture(&self) -> Option<&Arc<SurfaceTexture>> {
        if let Self::Texture(texture) = self { Some(texture) } else { None }
    }
}

/// One object of the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    pub name: String,
    pub surface: Surface,
    /// Enclosed volume, ≥ 0; infinite for a surface that encloses none, such as a quad.
    pub volume: f64,
    /// How membership is asked. Of refractors only: nothing asks what is in a solid or a light, and theirs is [`Enclosure::Closed`].
    pub enclosure: Enclosure,
    /// Analysis of a refractor's mesh, in object space; its faces are the object's primitives, in their order. `None` for an analytic
    /// sphere, a solid or a light.
    pub topology: Option<Arc<Topology>>,
    /// Of a refractor with holes, to be asked at local coordinates.
    pub winding: Option<Arc<WindingTree>>,
}

impl Object {
    /// Generalised winding number of a surface with holes around a point (local coordinates); 0 for others.
    pub fn winding_at(&self, point: DVec3) -> f64 {
        self.winding.as_ref().map_or(0.0, |tree| tree.winding(point))
    }

    /// Whether there is an image on the surface.
    pub fn has_texture(&self) -> bool {
        matches!(
            self.surface,
            Surface::Diffuse { albedo: Albedo::Texture(_), .. } | Surface::Mirror { albedo: Albedo::Texture(_), .. }
        )
    }

    /// Whether a part of the surface may lie inside another part.
    pub fn may_contain_itself(&self) -> bool {
        match self.enclosure {
            Enclosure::Union => true,
            Enclosure::Holed => self.has_several_components(),
            Enclosure::Closed | Enclosure::Sheet => false,
        }
    }

    /// Whether the surface falls into components.
    pub fn has_several_components(&self) -> bool {
        self.topology.as_ref().is_some_and(|topology| topology.components > 1)
    }
}

/// A compiled scene. Coordinates inside are relative to [`Geometry::origin`].
#[derive(Debug, Clone)]
pub struct Scene {
    pub geometry: Arc<Geometry>,
    pub objects: Vec<Object>,
    pub media: Vec<SceneMedium>,
    pub interfaces: Interfaces,
    pub emitters: Emitters,
    pub environment: EnvironmentLight,
    pub needs: SceneNeeds,
    /// The refractors whose enclosure has holes.
    pub holed: Vec<ObjectId>,
    /// Whether some refractor is an open sheet.
    pub has_sheets: bool,
    /// Whether the global medium is indistinguishable from the reserved vacuum.
    pub world_is_vacuum: bool,
    /// What the scene declares around its surfaces and its camera.
    pub declared: Declared,
    /// Time that analysing meshes took in this compile, in seconds; 0 where all was known.
    pub topology_secs: f64,
}

impl Scene {
    pub fn object(&self, id: ObjectId) -> &Object {
        &self.objects[id.0 as usize]
    }

    pub fn medium(&self, id: MediumId) -> &SceneMedium {
        &self.media[id.0 as usize]
    }

    /// The interface between two media, as light of these wavelengths meets it.
    #[inline]
    pub fn interface(&self, from: MediumId, to: MediumId, wavelengths: Wavelengths) -> Interface {
        self.interfaces.between(&self.media, from, to, wavelengths)
    }

    /// What lies all around.
    #[inline]
    pub fn environment_light(&self) -> Light<'_> {
        Light::Environment(&self.environment)
    }

    /// Whether leaving the medium `left` is what a path in the medium `current` must do. Media are compared by identity; the reserved
    /// vacuum stands for a global medium of the same optics.
    #[inline]
    pub fn is_consistent(&self, current: MediumId, left: MediumId) -> bool {
        current == left || (self.world_is_vacuum && current.0 <= MediumId::VACUUM.0 && left.0 <= MediumId::VACUUM.0)
    }

    #[inline]
    pub fn is_refractor(&self, id: ObjectId) -> bool {
        matches!(self.object(id).surface, Surface::Refractor { .. })
    }

    /// Whether a light emits from the side that `is_front` tells; other objects do not.
    #[inline]
    pub fn emits(&self, id: ObjectId, is_front: bool) -> bool {
        matches!(self.object(id).surface, Surface::Light { two_sided, .. } if two_sided || is_front)
    }

    /// The albedo of a solid.
    pub fn albedo(&self, id: ObjectId) -> Option<&Albedo> {
        match &self.objects.get(id.0 as usize)?.surface {
            Surface::Diffuse { albedo, .. } | Surface::Mirror { albedo, .. } => Some(albedo),
            Surface::Refractor { .. } | Surface::Light { .. } => None,
        }
    }

    /// The priority of a refractor; the lowest of all for other objects.
    pub fn priority(&self, id: ObjectId) -> i32 {
        if let Surface::Refractor { priority, .. } = self.object(id).surface { priority } else { i32::MIN }
    }

    /// Ids and interior media of the refractors.
    pub fn refractors(&self) -> impl Iterator<Item = (ObjectId, MediumId)> {
        self.objects.iter().enumerate().filter_map(|(index, object)| match object.surface {
            Surface::Refractor { medium, .. } => Some((ObjectId(index as u32), medium)),
            _ => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Refraction, catalog};

    fn medium(name: &str, model: Ior) -> SceneMedium {
        let ior_minus_one = model.ior_minus_one(crate::spectrum::WAVELENGTH_D_UM);
        SceneMedium { name: name.into(), model, ior_minus_one, absorption: Spectrum::ZERO }
    }

    /// At normal incidence the reflectance tells the index: ((n − 1)/(n + 1))².
    #[test]
    fn interfaces_are_those_of_the_wavelength() {
        let flint = Ior::Catalog(catalog::find("sf11").unwrap());
        let mut media = vec![medium("world", Ior::Constant(1.0)), medium("sf11", flint.clone())];
        // Of 100 media the pairs are not kept.
        for count in [2, 100] {
            media.resize(count, medium("more", Ior::Constant(1.5)));
            let interfaces = Interfaces::new(&media);
            let reflectance =
                |wavelengths| match interfaces.between(&media, MediumId(0), MediumId(1), wavelengths).refraction(1.0) {
                    Refraction::TotalReflection => 1.0,
                    Refraction::Partial { reflectance, .. } => reflectance,
                };
            let expected = |um: f64| {
                let n_minus_one = flint.ior_minus_one(um);
                (n_minus_one / (n_minus_one + 2.0)).powi(2)
            };
            for um in [0.4358, 0.5876, 0.6563] {
                let got = reflectance(Wavelengths::Single { um });
                assert!((got / expected(um) - 1.0).abs() < 1e-14, "{um}: {got}");
            }
            let rgb = reflectance(Wavelengths::Rgb);
            assert!((rgb / expected(crate::spectrum::WAVELENGTH_D_UM) - 1.0).abs() < 1e-14);
            assert!(reflectance(Wavelengths::Single { um: 0.4358 }) > 1.05 * rgb);
        }
    }
}
