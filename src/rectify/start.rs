//! The medium that a path starts in. Near a surface, and exactly on one, each ray is asked: it starts in the medium on the side that it
//! goes to.

use glam::DVec3;

use super::containment::medium_at;
use super::table::InterfaceTable;
use crate::geometry::{PrimitiveId, Ray};
use crate::scene::lights::EmittedRay;
use crate::scene::{MediumId, ObjectId, Scene};

/// A ray starts on a surface where the surface lies this many of its roundings away or less.
const ON_SURFACE: f64 = 4.0;
/// A hit of that surface within this many times the tolerance is the ray's own origin and is ignored. One that is farther along is real: the ray
/// grazes the surface and meets it.
const GRAZING: f64 = 1e4;

/// How a path starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// The ray, beginning past the surfaces that its origin lies on.
    pub ray: Ray,
    pub medium: MediumId,
    /// Whether the voting rays did not agree about the medium.
    pub is_ambiguous: bool,
}

/// The media that rays from a small region, such as a lens, start in.
#[derive(Debug, Clone)]
pub struct StartRegion {
    /// The refractors' primitives that rays may start on.
    near: Vec<PrimitiveId>,
    /// The one answer for the whole region, and whether it is ambiguous; `None` where a refractor's surface reaches into the region.
    whole: Option<(MediumId, bool)>,
}

/// Gives the medium at a point off all surfaces (local coordinates), and whether it is ambiguous.
pub type Ask<'a> = &'a (dyn Fn(DVec3) -> (MediumId, bool) + Sync);

impl StartRegion {
    /// The region within `radius` ≥ 0 of `center` (local coordinates).
    pub fn by_asking(scene: &Scene, center: DVec3, radius: f64, ask: Ask<'_>) -> Self {
        let geometry = &scene.geometry;
        let is_refractor = |primitive| scene.is_refractor(ObjectId(geometry.object_of(primitive)));
        let reach = DVec3::splat(radius + room_around(scene, center, radius));
        let mut near = Vec::new();
        geometry.for_each_near_box(center - reach, center + reach, None, |primitive| {
            let distance = geometry.distance(primitive, center);
            if is_refractor(primitive) && distance <= radius + tolerance(scene, primitive, center) {
                near.push(primitive);
            }
        });
        near.sort_unstable();
        let whole = near.is_empty().then(|| ask(center));
        Self { near, whole }
    }

    /// The one medium that all rays start in, and whether it is ambiguous; `None` where each has to be asked.
    pub fn whole(&self) -> Option<(MediumId, bool)> {
        self.whole
    }

    /// The refractors whose surfaces reach into the region, in ascending order.
    pub fn refractors(&self, scene: &Scene) -> Vec<ObjectId> {
        let mut refractors: Vec<ObjectId> =
            self.near.iter().map(|&primitive| ObjectId(scene.geometry.object_of(primitive))).collect();
        refractors.sort_unstable();
        refractors.dedup();
        refractors
    }

    /// How a ray (local coordinates) starts whose origin lies in the region.
    #[inline]
    pub fn start_by_asking(&self, scene: &Scene, ray: Ray, ask: Ask<'_>) -> Start {
        match self.whole {
            Some((medium, is_ambiguous)) => Start { ray, medium, is_ambiguous },
            None => self.start_near_surface(scene, ray, ask),
        }
    }

    fn start_near_surface(&self, scene: &Scene, mut ray: Ray, ask: Ask<'_>) -> Start {
        let geometry = &scene.geometry;
        let starts_on = |primitive: &PrimitiveId| {
            geometry.distance(*primitive, ray.origin) <= tolerance(scene, *primitive, ray.origin)
        };
        let on: Vec<PrimitiveId> = self.near.iter().copied().filter(starts_on).collect();
        if on.is_empty() {
            let (medium, is_ambiguous) = ask(ray.origin);
            return Start { ray, medium, is_ambiguous };
        }
        let mut next = geometry.closest(&ray);
        while let Some(hit) = next
            && on.contains(&hit.primitive)
            && hit.t <= GRAZING * tolerance(scene, hit.primitive, ray.origin)
        {
            ray = ray.beyond(&hit);
            next = geometry.closest(&ray);
        }
        // Up to the next surface there is one medium. Halfway there it can be asked with room on all sides.
        let length = next.map_or_else(|| geometry.bounding_sphere().map_or(1.0, |s| s.radius), |hit| hit.t - ray.t_min);
        let (medium, is_ambiguous) = ask(ray.at(ray.t_min + 0.5 * length));
        Start { ray, medium, is_ambiguous }
    }
}

/// How near a ray must start to a surface to start on it.
fn tolerance(scene: &Scene, primitive: PrimitiveId, point: DVec3) -> f64 {
    let of_point = 16.0 * f64::EPSILON * point.abs().max_element();
    ON_SURFACE * (scene.geometry.rounding(primitive) + of_point)
}

/// How far beyond `radius` around `center` to search for surfaces that rays may start on: the largest [`tolerance`] of the refractors near it,
/// which grows with their distance from the local origin.
fn room_around(scene: &Scene, center: DVec3, radius: f64) -> f64 {
    let geometry = &scene.geometry;
    let room = |object: u32| {
        let (min, max) = geometry.bounds_of(object);
        let rounded = geometry.reach_of(object) + center.abs().max_element() + geometry.origin.abs().max_element();
        let room = 8.0 * ON_SURFACE * (f64::from(f32::EPSILON) * geometry.reach_of(object) + f64::EPSILON * rounded);
        let reach = radius + room;
        let is_near = (min - reach).cmple(center).all() && center.cmple(max + reach).all();
        if is_near { room } else { 0.0 }
    };
    scene.refractors().map(|(id, _)| room(id.0)).fold(0.0, f64::max)
}

/// How `ray` (local coordinates) starts.
pub fn start(scene: &Scene, ray: Ray) -> Start {
    start_by_asking(scene, ray, &|point| medium_at(scene, point))
}

/// The same, with another way to ask for media.
pub fn start_by_asking(scene: &Scene, ray: Ray, ask: Ask<'_>) -> Start {
    StartRegion::by_asking(scene, ray.origin, 0.0, ask).start_by_asking(scene, ray, ask)
}

/// How a ray that a light emits (local coordinates) starts: in the medium that rectification found around the light there.
pub fn start_from_light(scene: &Scene, table: &InterfaceTable, emitted: &EmittedRay) -> Start {
    let known = match (emitted.start, emitted.light) {
        (Some(point), _) if emitted.is_front => {
            table.patch_of(&scene.geometry, point.primitive).and_then(|patch| patch.outside)
        }
        (Some(_), _) => None,
        (None, Some(light)) => table.place_of(light).and_then(|patch| patch.outside),
        // All objects lie in the sphere that it comes into.
        (None, None) => Some(MediumId::WORLD),
    };
    match known {
        Some(medium) => Start { ray: emitted.ray, medium, is_ambiguous: false },
        // Where the surroundings of the light differ from place to place, and behind a light with two sides.
        None => start(scene, emitted.ray),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lamp in ice starts its light in ice, and the environment in air.
    #[test]
    fn light_starts_in_the_medium_around_its_lamp() {
        let scene = crate::scene::compile::compile(&crate::formats::open("lamp-in-ice").unwrap(), None).unwrap();
        let table = InterfaceTable::new(&scene);
        let (lamp, _) = scene.emitters.iter().next().unwrap();
        for (light, expected) in [(lamp, "ice"), (scene.environment_light(), "world")] {
            for index in 0..50 {
                let at = |step: f64| (f64::from(index) * step + 0.5).fract();
                let (start, direction) = ([at(0.883_2), at(0.796_7), at(0.718_7)], [at(0.648_3), at(0.584_8)]);
                let emitted = light.sample_ray(&scene.geometry, start, direction).unwrap();
                let start = start_from_light(&scene, &table, &emitted);
                assert_eq!(scene.medium(start.medium).name, expected);
                assert_eq!(start.ray.direction, emitted.ray.direction);
            }
        }
    }
}
