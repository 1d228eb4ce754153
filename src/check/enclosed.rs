//! Refractors and lights that lie inside something opaque: they are never seen, and nothing is lit by them.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;
use rayon::prelude::*;

use super::{Problem, names, samples};
use crate::geometry::{Geometry, Ray};
use crate::scene::lights::Light;
use crate::scene::{ObjectId, Scene, Surface};
use crate::tracking::Prepared;

/// Most refractor surfaces that a ray passes on its way out. Objects that lie deeper in a nest are not reported; the nest's outer parts are.
const MOST_SURFACES: u32 = 16;
/// Rays for each object, and for all together where there are many; an object none of whose rays gets out is enclosed.
const RAYS: std::ops::RangeInclusive<u32> = 64..=1024;
const ALL_RAYS: u32 = 100_000;

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let scene = &*prepared.scene;
    let is_opaque = |object: &crate::scene::Object| !matches!(object.surface, Surface::Refractor { .. });
    if !scene.objects.iter().any(is_opaque) {
        return Vec::new();
    }
    let candidates: Vec<(ObjectId, ObjectId)> = (0..scene.objects.len() as u32)
        .into_par_iter()
        .map(ObjectId)
        .filter(|&id| matches!(scene.object(id).surface, Surface::Refractor { .. } | Surface::Light { .. }))
        .filter_map(|id| Some((id, candidate(scene, id)?)))
        .collect();
    let rays = (ALL_RAYS / (candidates.len() as u32).max(1)).clamp(*RAYS.start(), *RAYS.end());
    // In a room everything is inside the walls, and so is the camera.
    let camera = prepared.description.camera.position - scene.geometry.origin;
    let mut holds_camera: HashMap<ObjectId, bool> = HashMap::new();
    for &(_, solid) in &candidates {
        holds_camera.entry(solid).or_insert_with(|| encloses_point(&scene.geometry, solid, camera));
    }
    let hidden: Vec<(ObjectId, ObjectId)> = (candidates.into_par_iter())
        .filter(|(id, solid)| !holds_camera[solid] && encloses(scene, *solid, *id, rays))
        .collect();
    // One finding for each that hides something, refractors and lights apart.
    let mut hidden_in: BTreeMap<(ObjectId, bool), Vec<ObjectId>> = BTreeMap::new();
    for (id, solid) in hidden {
        hidden_in.entry((solid, !scene.is_refractor(id))).or_default().push(id);
    }
    hidden_in.into_iter().map(|((solid, are_lights), hidden)| problem(scene, solid, are_lights, &hidden)).collect()
}

/// The first opaque object on a way out, if its bounds hold those of `id`: if anything hides it, this does.
fn candidate(scene: &Scene, id: ObjectId) -> Option<ObjectId> {
    let geometry = &*scene.geometry;
    let mut ray = rays_from(scene, id, 1).next()?;
    for _ in 0..MOST_SURFACES {
        let hit = geometry.closest(&ray)?;
        let met = ObjectId(geometry.object_of(hit.primitive));
        if met != id && !scene.is_refractor(met) {
            let ((min, max), (outer_min, outer_max)) = (geometry.bounds_of(id.0), geometry.bounds_of(met.0));
            return (outer_min.cmplt(min).all() && max.cmplt(outer_max).all()).then_some(met);
        }
        ray = ray.beyond(&hit);
    }
    None
}

/// Whether no ray from `inner` gets past `outer`.
fn encloses(scene: &Scene, outer: ObjectId, inner: ObjectId, rays: u32) -> bool {
    rays_from(scene, inner, rays).all(|ray| scene.geometry.closest_of(&ray, outer.0).is_some())
}

/// Rays that leave an object's surface, or the place of a light that has none.
fn rays_from(scene: &Scene, id: ObjectId, count: u32) -> impl Iterator<Item = Ray> {
    let place = match scene.emitters.find(id) {
        Some((Light::Point(light), _)) => Some(light.position),
        Some((Light::Spot(light), _)) => Some(light.position),
        _ => None,
    };
    let from_place = place
        .into_iter()
        .flat_map(move |place| samples::directions(count).map(move |direction| Ray::new(place, direction)));
    let on_surface = samples::of_surface(&scene.geometry, id.0, 0..count)
        .map(|(point, direction)| Ray::leaving(point.position, direction, point.primitive));
    from_place.chain(on_surface)
}

fn encloses_point(geometry: &Geometry, outer: ObjectId, point: DVec3) -> bool {
    samples::directions(*RAYS.end())
        .all(|direction| geometry.closest_of(&Ray::new(point, direction), outer.0).is_some())
}

fn problem(scene: &Scene, outer: ObjectId, are_lights: bool, hidden: &[ObjectId]) -> Problem {
    let name = &scene.object(outer).name;
    let word = if matches!(scene.object(outer).surface, Surface::Light { .. }) { "light" } else { "solid" };
    let (subject, lie, them) = match hidden {
        [_] => ("it".to_owned(), "lies", "it"),
        _ => (names::list_of(scene, hidden), "lie", "them"),
    };
    let harm = match (are_lights, hidden.len()) {
        (false, _) => "cannot be seen",
        (true, 1) => "none of its light gets out",
        (true, _) => "none of their light gets out",
    };
    Problem::warning(
        names::place_of(scene, hidden),
        if are_lights { "light_in_solid" } else { "inside_solid" },
        format!(
            "{subject} {lie} inside the {word} `{name}`, which is opaque: {harm}. Move {them} out, or make `{name}` a refractor or hollow \
             with an opening"
        ),
    )
}
