//! All refractors of a scene as bodies that can be asked what they contain, each read from its own shape.

use std::collections::HashMap;

use glam::DVec3;

use super::boxes::{Bounds, Tree};
use super::reading::Reading;
use super::sheet;
use super::winding::{Allowed, PointInPlane, Winding};
use crate::geometry::{Geometry, ObjectRange, PrimitiveId, SurfacePoint};
use crate::scene::Scene;
use crate::scene::description::{Description, Shape};
use crate::scene::shapes::tessellate;
use crate::scene::{MediumId, ObjectId, Surface};

/// Winding numbers nearer to ½ than this leave doubt, where there are holes.
const DOUBTFUL: f64 = 0.1;
/// A surface has holes if closing it takes more than this share of its own area; less is slits without area.
const LEAST_GAP: f64 = 1e-9;
/// Share of a ball's size, and of the distance to it, that rounding to f64 may take.
const ROUNDING_OF_BALLS: f64 = 1e-12;
/// Volumes that differ by less than this, relatively, are equal.
const SAME_VOLUME: f64 = 1e-6;
/// How far from a face's edges it is asked at least, as a share of the largest coordinate: below half a rounding to f32, far above those
/// to f64.
const LEAST_DISTANCE: f64 = 1.0 / (1u64 << 28) as f64;
/// The primitive is none that the mesh as read has.
const NO_PART: u32 = u32::MAX;

/// What the refractors' shapes enclose, in local coordinates.
#[derive(Debug)]
pub struct Bodies {
    bodies: Vec<Body>,
    /// Bodies by object; `None` where one is not visible, or no refractor.
    of_object: Vec<Option<u32>>,
    /// Over all bodies but sheets.
    tree: Tree,
    tree_bodies: Vec<u32>,
    sheets: Vec<u32>,
    /// By triangle of the geometry, as far as refractors have them: the part of its body that it is a face of.
    part_of_primitive: Vec<u32>,
}

#[derive(Debug)]
struct Body {
    object: ObjectId,
    volume: f64,
    /// Of a ball around it.
    radius: f64,
    form: Form,
}

#[derive(Debug)]
enum Form {
    Ball { center: DVec3, radius: f64 },
    Solid { winding: Winding, is_simple: Vec<bool>, has_holes: bool },
    Sheet { winding: Winding, is_simple: Vec<bool> },
}

/// Whether a body contains what lies on either side of a place.
#[derive(Debug, Clone, Copy, Default)]
struct Inside {
    front: bool,
    back: bool,
    is_doubtful: bool,
}

/// What fills the two sides of a place on a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Beside {
    /// On the side that the normal points to.
    pub front: MediumId,
    pub back: MediumId,
    pub is_doubtful: bool,
}

impl Bodies {
    /// Of the description that `scene` was compiled from.
    pub fn new(description: &Description, scene: &Scene) -> Self {
        let geometry = &*scene.geometry;
        let mut bodies = Vec::new();
        let mut of_object = vec![None; scene.objects.len()];
        let mut part_of_primitive = Vec::new();
        for (index, refractor) in description.objects.refractors().iter().enumerate().filter(|(_, r)| r.visible) {
            let object = ObjectId(index as u32);
            let matrix = refractor.transform.matrix();
            if let Shape::Sphere { center, radius } = refractor.shape {
                let center = matrix.transform_point3(center) - geometry.origin;
                let radius = radius * refractor.transform.scale.x.abs();
                let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
                of_object[index] = Some(bodies.len() as u32);
                bodies.push(Body { object, volume, radius, form: Form::Ball { center, radius } });
                continue;
            }
            let reading = match &refractor.shape {
                Shape::Mesh { mesh, .. } => Reading::new(mesh, &matrix, geometry.origin),
                // What has been compiled can be tessellated.
                shape => match tessellate(shape) {
                    Ok(Some(mesh)) => Reading::new(&mesh, &matrix, geometry.origin),
                    _ => continue,
                },
            };
            name_parts(geometry, object, &reading, &mut part_of_primitive);
            of_object[index] = Some(bodies.len() as u32);
            bodies.push(Body::of_mesh(object, reading));
        }
        let is_sheet = |body: &Body| matches!(body.form, Form::Sheet { .. });
        let (sheets, tree_bodies): (Vec<u32>, Vec<u32>) =
            (0..bodies.len() as u32).partition(|&body| is_sheet(&bodies[body as usize]));
        let boxes: Vec<Bounds> = tree_bodies.iter().map(|&body| bodies[body as usize].bounds()).collect();
        Self { tree: Tree::build(&boxes), bodies, of_object, tree_bodies, sheets, part_of_primitive }
    }

    fn body(&self, object: ObjectId) -> Option<&Body> {
        self.of_object[object.0 as usize].map(|body| &self.bodies[body as usize])
    }

    fn part_of(&self, primitive: PrimitiveId) -> u32 {
        self.part_of_primitive.get(primitive as usize).copied().unwrap_or(NO_PART)
    }

    /// The place of a surface point.
    pub(super) fn place(&self, geometry: &Geometry, point: &SurfacePoint) -> PointInPlane {
        if geometry.sphere(point.primitive).is_some() {
            return PointInPlane::new(point.position, point.normal, DVec3::ZERO);
        }
        let corners = geometry.corners(point.primitive);
        let reach = corners.into_iter().fold(DVec3::ZERO, |reach, p| reach.max(p.abs()));
        PointInPlane::new(off_the_edges(point.position, &corners), point.normal, reach)
    }

    /// How near faces of a part of `body` must come to those of the primitive to lie in one plane with it.
    fn allowed(&self, body: &Body, part: u32, primitive: PrimitiveId, own: &Body) -> Allowed {
        let is_own = body.object == own.object && part == self.part_of(primitive);
        Allowed { length: body.radius.min(own.radius), is_of_one_surface: is_own && body.is_simple(part) }
    }

    /// The media on both sides of a point on a refractor's surface.
    pub(super) fn beside(&self, scene: &Scene, place: &PointInPlane, primitive: PrimitiveId) -> Beside {
        let mut found = Beside { front: MediumId::WORLD, back: MediumId::WORLD, is_doubtful: false };
        let Some(own) = self.body(ObjectId(scene.geometry.object_of(primitive))) else { return found };
        let mut top: [Option<&Body>; 2] = [None, None];
        let margin = place.allowance(own.radius, place.point.abs());
        self.for_each_near(place.point, margin, |body| {
            let inside = self.inside(scene, body, place, primitive, own);
            found.is_doubtful |= inside.is_doubtful;
            for (top, is_inside) in top.iter_mut().zip([inside.front, inside.back]) {
                if is_inside && top.is_none_or(|top| body.is_above(top, scene)) {
                    *top = Some(body);
                }
            }
        });
        [found.front, found.back] = top.map(|top| medium_of(scene, top));
        found
    }

    /// The refractors that contain the side that the normal points to, and the other side; on each the one that fills it comes first. And
    /// whether there is doubt.
    pub(super) fn containers_beside(
        &self,
        scene: &Scene,
        place: &PointInPlane,
        primitive: PrimitiveId,
    ) -> ([Vec<ObjectId>; 2], bool) {
        let Some(own) = self.body(ObjectId(scene.geometry.object_of(primitive))) else { return Default::default() };
        let mut found: [Vec<&Body>; 2] = Default::default();
        let mut is_doubtful = false;
        let margin = place.allowance(own.radius, place.point.abs());
        self.for_each_near(place.point, margin, |body| {
            let inside = self.inside(scene, body, place, primitive, own);
            is_doubtful |= inside.is_doubtful;
            for (list, is_inside) in found.iter_mut().zip([inside.front, inside.back]) {
                if is_inside {
                    let rank = list.iter().position(|other| body.is_above(other, scene)).unwrap_or(list.len());
                    list.insert(rank, body);
                }
            }
        });
        (found.map(|list| list.into_iter().map(|body| body.object).collect()), is_doubtful)
    }

    /// Every body that may contain what lies that near to a point.
    fn for_each_near<'a>(&'a self, point: DVec3, margin: f64, mut visit: impl FnMut(&'a Body)) {
        self.tree.walk(
            |bounds| bounds.contains(point, margin),
            |item| visit(&self.bodies[self.tree_bodies[self.tree.order[item] as usize] as usize]),
        );
        self.sheets.iter().for_each(|&sheet| visit(&self.bodies[sheet as usize]));
    }

    fn inside(&self, scene: &Scene, body: &Body, place: &PointInPlane, primitive: PrimitiveId, own: &Body) -> Inside {
        let allowed = |part: u32| self.allowed(body, part, primitive, own);
        match &body.form {
            Form::Ball { center, radius } => {
                let from_center = place.point - *center;
                let height = from_center.length() - radius;
                if height.abs() > ROUNDING_OF_BALLS * (radius + place.point.abs().max_element()) {
                    return Inside { front: height < 0.0, back: height < 0.0, is_doubtful: false };
                }
                let looks_along = from_center.dot(place.normal) > 0.0;
                Inside { front: !looks_along, back: looks_along, is_doubtful: false }
            }
            Form::Solid { winding, has_holes, .. } => {
                let sides = winding.beside(place, allowed);
                let is_doubtful = |number: f64| *has_holes && (number - 0.5).abs() < DOUBTFUL;
                let (front, back) = (sides.front > 0.5, sides.back > 0.5);
                Inside { front, back, is_doubtful: is_doubtful(sides.front) || is_doubtful(sides.back) }
            }
            Form::Sheet { winding, .. } => {
                let sides = winding.beside(place, allowed);
                if sides.front != sides.back {
                    let (front, back) = (sides.front > sides.back, sides.back > sides.front);
                    return Inside { front, back, is_doubtful: false };
                }
                let (is_inside, is_doubtful) = sheet::contains(scene, winding, place.point);
                Inside { front: is_inside, back: is_inside, is_doubtful }
            }
        }
    }

    /// The medium at a point off all surfaces, and whether there is doubt.
    pub(super) fn medium_at(&self, scene: &Scene, point: DVec3) -> (MediumId, bool) {
        let mut is_doubtful = false;
        let mut top: Option<&Body> = None;
        self.for_each_near(point, 0.0, |body| {
            let (is_inside, doubt) = body.contains(scene, point);
            is_doubtful |= doubt;
            if is_inside && top.is_none_or(|top| body.is_above(top, scene)) {
                top = Some(body);
            }
        });
        (medium_of(scene, top), is_doubtful)
    }

    /// Whether another face at the same place, in the same plane, stands for that of `primitive`: one of something opaque, or the first of
    /// the refractors'. Of surfaces that are one, a path must cross just one.
    pub(super) fn is_stood_for(&self, scene: &Scene, place: &PointInPlane, primitive: PrimitiveId) -> bool {
        let geometry = &*scene.geometry;
        let own_object = ObjectId(geometry.object_of(primitive));
        let Some(own) = self.body(own_object) else { return false };
        let margin = DVec3::splat(place.allowance(own.radius, place.point.abs()));
        let mut is_stood_for = false;
        geometry.for_each_near_box(place.point - margin, place.point + margin, None, |other| {
            let object = ObjectId(geometry.object_of(other));
            let is_opaque = !scene.is_refractor(object);
            if is_stood_for || other == primitive || !(is_opaque || other < primitive) {
                return;
            }
            is_stood_for = match geometry.sphere(other) {
                Some(sphere) => {
                    let from_center = place.point - sphere.center;
                    let near = ROUNDING_OF_BALLS * (sphere.radius + place.point.abs().max_element());
                    (from_center.length() - sphere.radius).abs() <= near
                        && from_center.normalize_or_zero().dot(place.normal).abs() > 0.9
                }
                None => {
                    let allowed = match self.body(object) {
                        Some(body) => self.allowed(body, self.part_of(other), primitive, own),
                        None => {
                            let length = own.radius.min(radius_of(geometry, object));
                            Allowed { length, is_of_one_surface: false }
                        }
                    };
                    place.is_covered_by(&geometry.corners(other), allowed).is_some()
                }
            };
        });
        is_stood_for
    }
}

/// A point of a triangle moved away from the edges, where it is as near to one as roundings of f64: there it would be chance which of the
/// faces that meet lies at the point, and from where the others are seen. The way is shorter than what rounding to f32 leaves of corners.
fn off_the_edges(point: DVec3, corners: &[DVec3; 3]) -> DVec3 {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(c - a);
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    // By corner: its share of the point, and the share that a point has at the least distance from the edge opposite to it.
    let [shares, least] = {
        let share = |p: DVec3, q: DVec3| (q - p).cross(point - p).dot(normal) / normal.length_squared();
        let least = |p: DVec3, q: DVec3| LEAST_DISTANCE * largest * (q - p).length() / normal.length();
        [[share(b, c), share(c, a), share(a, b)], [least(b, c), least(c, a), least(a, b)]]
    };
    if (0..3).all(|k| shares[k] >= least[k]) || !normal.length_squared().is_normal() {
        return point;
    }
    let moved: [f64; 3] = std::array::from_fn(|k| shares[k].max(least[k].min(0.25)));
    (a * moved[0] + b * moved[1] + c * moved[2]) / moved.iter().sum::<f64>()
}

/// Of a ball around an object.
fn radius_of(geometry: &Geometry, object: ObjectId) -> f64 {
    let (min, max) = geometry.bounds_of(object.0);
    (max - min).length() / 2.0
}

fn medium_of(scene: &Scene, body: Option<&Body>) -> MediumId {
    match body.map(|body| &scene.object(body.object).surface) {
        Some(Surface::Refractor { medium, .. }) => *medium,
        _ => MediumId::WORLD,
    }
}

impl Body {
    fn of_mesh(object: ObjectId, reading: Reading) -> Self {
        let winding = Winding::build(&reading.triangles, &reading.parts);
        let bounds = winding.bounds();
        let radius = ((bounds.max - bounds.min).length() / 2.0).max(0.0);
        let (volume, is_sheet, has_holes) = (reading.volume, reading.is_sheet(), reading.gap > LEAST_GAP);
        let is_simple = reading.is_simple;
        let form =
            if is_sheet { Form::Sheet { winding, is_simple } } else { Form::Solid { winding, is_simple, has_holes } };
        Self { object, volume, radius, form }
    }

    fn bounds(&self) -> Bounds {
        match &self.form {
            Form::Ball { center, radius } => Bounds { min: *center - *radius, max: *center + *radius },
            Form::Solid { winding, .. } | Form::Sheet { winding, .. } => winding.bounds(),
        }
    }

    fn is_simple(&self, part: u32) -> bool {
        match &self.form {
            Form::Ball { .. } => true,
            Form::Solid { is_simple, .. } | Form::Sheet { is_simple, .. } => {
                is_simple.get(part as usize).copied().unwrap_or_default()
            }
        }
    }

    /// Whether it contains a point off its surface, and whether there is doubt.
    fn contains(&self, scene: &Scene, point: DVec3) -> (bool, bool) {
        match &self.form {
            Form::Ball { center, radius } => (point.distance(*center) < *radius, false),
            Form::Solid { winding, has_holes, .. } => {
                let number = winding.around(point);
                (number > 0.5, *has_holes && (number - 0.5).abs() < DOUBTFUL)
            }
            Form::Sheet { winding, .. } => sheet::contains(scene, winding, point),
        }
    }

    /// Whether it, not `other`, fills what both contain: by priority, then the smaller volume, then the later.
    fn is_above(&self, other: &Self, scene: &Scene) -> bool {
        let (own, others) = (scene.priority(self.object), scene.priority(other.object));
        if own != others {
            return own > others;
        }
        let is_smaller = |a: f64, b: f64| a * (1.0 + SAME_VOLUME) < b;
        if is_smaller(self.volume, other.volume) || is_smaller(other.volume, self.volume) {
            return self.volume < other.volume;
        }
        self.object > other.object
    }
}

/// Finds the geometry's triangles of an object among those that were read, by their corners, and notes their parts.
fn name_parts(geometry: &Geometry, object: ObjectId, reading: &Reading, part_of_primitive: &mut Vec<u32>) {
    let ObjectRange::Triangles(range) = geometry.range(object.0) else { return };
    let key = |corners: [DVec3; 3]| {
        // −0 is 0.
        let mut corners = corners.map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
        corners.sort_unstable();
        corners
    };
    // The last first, so that they are taken in their order.
    let mut parts: HashMap<[[u64; 3]; 3], Vec<u32>> = HashMap::with_capacity(reading.as_written.len());
    for (corners, part) in reading.as_written.iter().zip(&reading.parts).rev() {
        parts.entry(key(*corners)).or_default().push(*part);
    }
    part_of_primitive.resize(range.end as usize, NO_PART);
    for primitive in range.clone() {
        if let Some(part) = parts.get_mut(&key(geometry.corners(primitive))).and_then(Vec::pop) {
            part_of_primitive[primitive as usize] = part;
        }
    }
}
