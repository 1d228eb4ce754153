//! Lights whose light goes nowhere. A light emits from its outward side: that of a quad is edge_u × edge_v, a mesh's faces are
//! counter-clockwise seen from there.

use glam::DVec3;

use super::{Problem, names, samples};
use crate::geometry::{Geometry, Ray};
use crate::rectify::subjects::primitives_of;
use crate::rectify::tolerance;
use crate::scene::description::{Object, Shape};
use crate::scene::{ObjectId, Surface};
use crate::tracking::Prepared;

/// Rays from each light.
const RAYS: u32 = 48;
/// Share of the rays that end at a solid at once, for light that goes into it.
const MOST: f64 = 0.9;
/// At once: within this share of the light's size.
const NEAR: f64 = 0.01;
/// Pairs of lights and other objects that are looked at in all.
const MOST_PAIRS: usize = 10_000_000;

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let scene = &*prepared.scene;
    let mut pairs_left = MOST_PAIRS;
    (prepared.description.objects.iter().enumerate())
        .filter(|(_, object)| object.visible && object.light().is_some_and(|light| !light.is_black()))
        .filter_map(|(index, light)| {
            let lamp = Lamp { prepared, light, id: ObjectId(index as u32) };
            (scene.geometry.face_count(lamp.id.0) > 0).then_some(())?;
            lamp.faces_away(&mut pairs_left).or_else(|| lamp.shines_into_solid())
        })
        .collect()
}

struct Lamp<'a> {
    prepared: &'a Prepared,
    light: &'a Object,
    id: ObjectId,
}

impl Lamp<'_> {
    fn geometry(&self) -> &Geometry {
        &self.prepared.scene.geometry
    }

    fn camera(&self) -> DVec3 {
        self.prepared.description.camera.position - self.geometry().origin
    }

    /// How to turn it over.
    fn turn(&self) -> &'static str {
        match self.light.shape {
            Shape::Quad { .. } => "exchange its edge_u and edge_v to turn it over",
            _ => "turn its faces over",
        }
    }

    /// Unit normal and a point of the plane that all of the light lies in, if there is one.
    fn plane(&self) -> Option<(DVec3, DVec3)> {
        let geometry = self.geometry();
        let mut plane: Option<(DVec3, DVec3)> = None;
        let tolerance = tolerance::largest(geometry, self.id.0);
        for face in primitives_of(geometry, self.id) {
            if geometry.sphere(face).is_some() {
                return None;
            }
            let [a, b, c] = geometry.corners(face);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            match plane {
                None if normal != DVec3::ZERO => plane = Some((normal, a)),
                None => {}
                Some((first, point)) => {
                    let is_in_plane = [a, b, c].iter().all(|p| first.dot(*p - point).abs() <= tolerance);
                    if !is_in_plane || first.dot(normal) < 0.0 {
                        return None;
                    }
                }
            }
        }
        plane
    }

    /// Everything lies behind it, or inside of a closed one whose faces look inward there is nothing.
    fn faces_away(&self, pairs_left: &mut usize) -> Option<Problem> {
        let geometry = self.geometry();
        let Some((normal, point)) = self.plane() else { return self.faces_itself(pairs_left) };
        let margin = tolerance::largest(geometry, self.id.0);
        let is_in_front = |(min, max): (DVec3, DVec3)| {
            let farthest = DVec3::select(normal.cmpgt(DVec3::ZERO), max, min);
            normal.dot(farthest - point) > margin
        };
        let camera = self.camera();
        if is_in_front((camera, camera)) || !self.others(pairs_left)?.any(|id| geometry.face_count(id) > 0) {
            return None;
        }
        if self.others(pairs_left)?.any(|id| geometry.face_count(id) > 0 && is_in_front(geometry.bounds_of(id))) {
            return None;
        }
        let [x, y, z] = normal.to_array().map(|x| names::brief(x, 3));
        let side = match self.light.shape {
            Shape::Quad { .. } => format!("which of a quad is the way of edge_u × edge_v, here [{x}, {y}, {z}]"),
            _ => format!("here the way of [{x}, {y}, {z}]"),
        };
        Some(Problem::warning(
            &self.light.name,
            "light_faces_away",
            format!(
                "it shines away from everything: a light emits from its outward side only, {side}. If something is to be lit, {}",
                self.turn()
            ),
        ))
    }

    /// The other objects that can be lit, if there is time left to look at them.
    fn others(&self, pairs_left: &mut usize) -> Option<impl Iterator<Item = u32>> {
        let objects = &self.prepared.scene.objects;
        *pairs_left = pairs_left.checked_sub(objects.len())?;
        let is_lit = |object: &crate::scene::Object| !matches!(object.surface, Surface::Light { .. });
        Some((0..objects.len() as u32).filter(move |&id| is_lit(&objects[id as usize])))
    }

    fn faces_itself(&self, pairs_left: &mut usize) -> Option<Problem> {
        let geometry = self.geometry();
        let (min, max) = geometry.bounds_of(self.id.0);
        let reaches_in =
            |(other_min, other_max): (DVec3, DVec3)| other_min.cmple(max).all() && min.cmple(other_max).all();
        let meets_itself = |(ray, _): (Ray, DVec3)| {
            geometry.closest(&ray).is_some_and(|hit| geometry.object_of(hit.primitive) == self.id.0)
        };
        let camera = self.camera();
        if geometry.sphere_of(self.id.0).is_some()
            || !self.rays().all(meets_itself)
            || reaches_in((camera, camera))
            || self.others(pairs_left)?.any(|id| reaches_in(geometry.bounds_of(id)))
        {
            return None;
        }
        Some(Problem::warning(
            &self.light.name,
            "light_faces_away",
            "it shines into itself: a light emits from its outward side only, and its faces look inward. Turn its faces over",
        ))
    }

    /// Rays along which it emits, each with the normal of the place where it begins.
    fn rays(&self) -> impl Iterator<Item = (Ray, DVec3)> {
        samples::of_surface(self.geometry(), self.id.0, 0..RAYS).map(|(point, direction)| {
            // Uniform on a sphere that touches the surface: as much by each angle as a light emits.
            let direction = (point.normal + direction).normalize_or(point.normal);
            (Ray::leaving(point.position, direction, point.primitive), point.normal)
        })
    }

    fn shines_into_solid(&self) -> Option<Problem> {
        let geometry = self.geometry();
        let (min, max) = geometry.bounds_of(self.id.0);
        let near = NEAR * (max - min).length();
        // The solid next to a ray's start, and how far it is.
        let solid_along = |ray: &Ray, normal: DVec3| {
            let hit = geometry.closest(ray)?;
            let id = ObjectId(geometry.object_of(hit.primitive));
            let distance = hit.t * ray.direction.dot(normal).abs();
            let surface = &self.prepared.scene.object(id).surface;
            let is_solid = matches!(surface, Surface::Diffuse { .. } | Surface::Mirror { .. });
            (is_solid && distance <= near).then_some((id, distance))
        };
        let met: Vec<_> = self.rays().filter_map(|(ray, normal)| solid_along(&ray, normal)).collect();
        if (met.len() as f64) < MOST * f64::from(RAYS) {
            return None;
        }
        let (solid, _) = met[0];
        let distance = met.iter().map(|(_, distance)| *distance).fold(0.0, f64::max);
        let name = &self.prepared.scene.object(solid).name;
        let behind = self
            .rays()
            .filter(|(ray, normal)| solid_along(&Ray { direction: -ray.direction, ..*ray }, *normal).is_some());
        let advice = if (behind.count() as f64) < (1.0 - MOST) * f64::from(RAYS) {
            format!("{}, or move it away from `{name}`", self.turn())
        } else {
            format!("move it away from `{name}`")
        };
        let away =
            if distance > 0.0 { format!("{} away", names::brief(distance, 2)) } else { "at no distance".to_owned() };
        Some(Problem::warning(
            &self.light.name,
            "light_into_solid",
            format!(
                "it shines into the solid `{name}`, {away}: a light emits from its outward side only. Its light goes nowhere else: {advice}"
            ),
        ))
    }
}
