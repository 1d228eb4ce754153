//! Where subpaths from lights begin, and the densities with which other ways find a light.

use glam::DVec3;

use super::aim::{Aims, SHARE};
use super::interaction::TrackedScene;
use crate::geometry::{Ray, SurfacePoint};
use crate::rectify::InterfaceTable;
use crate::rectify::start::{Ask, Start, start_by_asking, start_from_light};
use crate::scene::ObjectId;
use crate::scene::lights::{EmittedRay, Light};
use crate::tracking::Tracker;

/// Probability of the environment where there are emitters too: of an image, which may have a sun in it, and of light that is the same all around,
/// which paths from the camera meet without any help.
const IMAGE_SHARE: f64 = 0.5;
const EVEN_SHARE: f64 = 0.1;

/// A light of a scene, with the probabilities that it is chosen.
#[derive(Debug, Clone, Copy)]
pub struct ChosenLight<'a> {
    pub light: Light<'a>,
    /// For a subpath that begins there.
    pub emission: f64,
    /// For light that is looked for at a vertex of the camera's subpath; 0 if it never is.
    pub direct: f64,
}

impl ChosenLight<'_> {
    /// Whether nothing meets or sees it by chance.
    pub fn is_delta(&self) -> bool {
        self.light.is_delta_position() || self.light.is_delta_direction()
    }
}

impl<T: Tracker> TrackedScene<'_, T> {
    /// The probability that a subpath comes from the environment.
    fn environment_share(&self) -> f64 {
        let scene = self.scene;
        let is_dark = scene.environment.is_black() || scene.geometry.bounding_sphere().is_none();
        match (is_dark, scene.emitters.is_empty()) {
            (true, _) => 0.0,
            (false, true) => 1.0,
            (false, false) if scene.environment.is_image() => IMAGE_SHARE,
            (false, false) => EVEN_SHARE,
        }
    }

    /// The light that `select`, uniform in [0, 1), chooses, and what is left of `select`, again uniform; `None` in a scene without light.
    pub fn choose_light(&self, select: f64) -> Option<(ChosenLight<'_>, f64)> {
        let share = self.environment_share();
        if select < share {
            return Some((self.environment_light(), select / share));
        }
        let (light, probability, rest) = self.scene.emitters.choose((select - share) / (1.0 - share))?;
        Some((self.emitter(light, probability), rest))
    }

    /// The environment.
    pub fn environment_light(&self) -> ChosenLight<'_> {
        let direct = if self.needs.image_environment { 1.0 } else { 0.0 };
        ChosenLight { light: self.scene.environment_light(), emission: self.environment_share(), direct }
    }

    /// The light that this object is; `None` of one that emits nothing.
    pub fn object_light(&self, object: ObjectId) -> Option<ChosenLight<'_>> {
        self.scene.emitters.find(object).map(|(light, probability)| self.emitter(light, probability))
    }

    /// The suns that are seen along `direction` by a ray that escapes.
    pub fn suns_along(&self, direction: DVec3) -> impl Iterator<Item = ChosenLight<'_>> {
        let suns = self.scene.emitters.suns().filter(move |(sun, _)| sun.is_seen(direction));
        suns.map(|(sun, probability)| self.emitter(Light::Directional(sun), probability))
    }

    /// An emitter that is chosen among all with this probability.
    pub fn emitter<'a>(&self, light: Light<'a>, probability: f64) -> ChosenLight<'a> {
        let direct = if self.needs.emitters { probability } else { 0.0 };
        ChosenLight { light, emission: (1.0 - self.environment_share()) * probability, direct }
    }

    /// Density with which `light` is looked for from a place `from` in unit `direction`: per steradian at that place, where the light is met at
    /// `point` (none of what lies afar); of a light at a point per area across the ray, times its squared `distance`; of one in a single
    /// direction a probability.
    pub fn direct_pdf(
        &self,
        light: &ChosenLight<'_>,
        from: DVec3,
        direction: DVec3,
        point: Option<&SurfacePoint>,
        distance: f64,
    ) -> f64 {
        let pdf = match light.light {
            _ if light.direct == 0.0 => 0.0,
            light if light.is_delta_position() => distance * distance,
            light if light.is_delta_direction() => 1.0,
            light => light.pdf_direct(&self.scene.geometry, from, direction, point),
        };
        light.direct * pdf
    }

    /// Density with which subpaths begin at `light` along the line from `place` in unit `direction`, in the units of [`Self::direct_pdf`]. `place` is
    /// where the light stands; of light from afar any point of the line. `normal` is that of the light's surface, if it has one.
    fn emission_density(
        &self,
        light: &ChosenLight<'_>,
        aims: &Aims,
        place: DVec3,
        normal: DVec3,
        direction: DVec3,
    ) -> f64 {
        let [mut of_place, mut of_direction] = light.light.pdf_ray(&self.scene.geometry, normal, direction);
        if light.light.is_delta_direction() {
            of_direction = 1.0;
        }
        if !aims.is_empty() {
            if is_afar(&light.light) {
                of_place = (1.0 - SHARE) * of_place + SHARE * aims.pdf_place(place, direction);
            } else {
                let (aimed, none) = aims.pdf_direction(place, direction);
                of_direction = (1.0 - SHARE + SHARE * none) * of_direction + SHARE * aimed;
            }
        }
        light.emission * of_place * of_direction
    }

    /// [`Self::emission_density`] over the cosine to `normal`; of a light without a surface over 1.
    pub fn emission_pdf(
        &self,
        light: &ChosenLight<'_>,
        aims: &Aims,
        place: DVec3,
        normal: DVec3,
        direction: DVec3,
    ) -> f64 {
        let cosine = if matches!(light.light, Light::Area(_)) { normal.dot(direction).abs() } else { 1.0 };
        if cosine > 0.0 { self.emission_density(light, aims, place, normal, direction) / cosine } else { 0.0 }
    }

    /// How a ray starts that a light emits. A mode that has a way of its own to find media is asked, by `ask`.
    pub fn start_from_light(&self, table: &InterfaceTable, ask: Ask<'_>, emitted: &EmittedRay) -> Start {
        let object = || emitted.start.map(|point| ObjectId(self.scene.geometry.object_of(point.primitive)));
        if let Some(medium) = self.tracker.light_medium(emitted.light.or_else(object)) {
            return Start { ray: emitted.ray, medium, is_ambiguous: false };
        }
        match self.tracker.medium_at(emitted.ray.origin) {
            Some(_) => start_by_asking(self.scene, emitted.ray, ask),
            None => start_from_light(self.scene, table, emitted),
        }
    }

    /// A ray that leaves a light, for numbers uniform in [0, 1), and the density with which it does, per area and steradian.
    pub fn emit(
        &self,
        light: &ChosenLight<'_>,
        aims: &Aims,
        aim: f64,
        start: [f64; 3],
        direction: [f64; 2],
    ) -> Option<(EmittedRay, f64)> {
        let geometry = &self.scene.geometry;
        let mut emitted = light.light.sample_ray(geometry, start, direction)?;
        if aim < SHARE && !aims.is_empty() {
            let select = aim / SHARE;
            if is_afar(&light.light) {
                let along = emitted.ray.direction;
                let place = aims.sample_place(along, select, [start[1], start[2]])?;
                // In the plane from which all such rays start.
                let origin = place - along * (place - emitted.ray.origin).dot(along);
                emitted.ray = Ray { origin, ..emitted.ray };
            } else if let Some(along) = aims.sample_direction(emitted.ray.origin, select, direction) {
                emitted = aimed(light, emitted, along)?;
            }
        }
        let EmittedRay { ray, cosine, .. } = emitted;
        let normal = emitted.start.map_or(ray.direction, |point| point.normal);
        let density = self.emission_density(light, aims, ray.origin, normal, ray.direction);
        (cosine > 0.0 && density > 0.0 && !emitted.radiance.is_black()).then_some((emitted, density))
    }
}

/// Whether light comes from beyond the scene.
fn is_afar(light: &Light<'_>) -> bool {
    matches!(light, Light::Directional(_) | Light::Environment(_))
}

/// The ray that leaves in another direction from where `emitted` does. `None` where the light does not shine there.
fn aimed(light: &ChosenLight<'_>, mut emitted: EmittedRay, direction: DVec3) -> Option<EmittedRay> {
    emitted.ray = Ray { direction, ..emitted.ray };
    emitted.radiance = light.light.emitted(direction);
    if let (Light::Area(area), Some(point)) = (light.light, &mut emitted.start) {
        if point.normal.dot(direction) < 0.0 {
            if !area.two_sided {
                return None;
            }
            point.normal = -point.normal;
            emitted.is_front = !emitted.is_front;
        }
        emitted.cosine = point.normal.dot(direction);
    }
    Some(emitted)
}
