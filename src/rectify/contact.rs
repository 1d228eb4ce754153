//! Where surfaces meet: which faces of refractors and lights other surfaces touch, and how.
//!
//! Every test here is closed and errs towards a contact: a face that is taken to be touched and is not costs a little time, the other
//! way round would cost the right answer. How near surfaces come to be in contact: see [`super::tolerance`].

use std::collections::HashMap;
use std::ops::ControlFlow;

use glam::DVec3;
use rayon::prelude::*;

use super::copies::Copies;
use super::progress::{Cancelled, Progress, Stage};
use super::tolerance::{Margins, Tolerance, largest};
use crate::geometry::sphere::Sphere;
use crate::geometry::{Geometry, ObjectRange, PrimitiveId, SurfacePoint, closest_point};
use crate::scene::{ObjectId, Scene, Surface};

/// Normals of coincident faces differ by less than the angle of this cosine.
const PARALLEL: f64 = 0.9;

/// A face that more others of about its size or larger meet is *crowded*: those are not listed.
const CROWD: u32 = 128;
/// Share of a face's area from which on another one is about as large.
const COMPARABLE: f64 = 0.25;

/// How another primitive meets a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// It may reach into the face's interior; `through` if it certainly goes through it.
    Crosses { through: bool },
    /// It meets the face at the face's own edges and corners only.
    Touches,
    /// It lies in the face's plane (or is the same sphere) and shares a part of it; whether with the same normal.
    Coincides { same: bool },
}

/// Another primitive that meets a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contact {
    pub primitive: PrimitiveId,
    pub relation: Relation,
}

/// The touched faces of all refractors and lights, in ascending order, each with what touches it: nothing is listed for a crowded face, and for one
/// that a coincident face stands for, that face alone.
#[derive(Debug, Clone, Default)]
pub struct Contacts {
    faces: Vec<PrimitiveId>,
    /// End of each face's contacts.
    ends: Vec<u32>,
    contacts: Vec<Contact>,
    /// Subjects and the refractors whose surfaces certainly go through theirs; each pair once.
    pub crossing: Vec<(ObjectId, ObjectId)>,
}

impl Contacts {
    /// The number of touched faces.
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// The touched faces, in ascending order, with their contacts.
    pub fn iter(&self) -> impl Iterator<Item = (PrimitiveId, &[Contact])> {
        self.of_range(0..PrimitiveId::MAX)
    }

    /// The touched faces among `primitives`, with their contacts.
    pub fn of_range(
        &self,
        primitives: std::ops::Range<PrimitiveId>,
    ) -> impl Iterator<Item = (PrimitiveId, &[Contact])> {
        let first = self.faces.partition_point(|&face| face < primitives.start);
        let last = self.faces.partition_point(|&face| face < primitives.end);
        (first..last).map(|index| {
            let start = if index == 0 { 0 } else { self.ends[index - 1] };
            (self.faces[index], &self.contacts[start as usize..self.ends[index] as usize])
        })
    }
}

/// Finds all contacts of the objects `subjects` with objects that are no copies. O(N log N) for surfaces that meet along curves.
///
/// # Errors
/// When `progress` is cancelled.
pub fn find(scene: &Scene, subjects: &[ObjectId], copies: &Copies, progress: &Progress) -> Result<Contacts, Cancelled> {
    /// Faces that one task looks at.
    const CHUNK: u32 = 2048;
    let geometry = &*scene.geometry;
    let mut tasks = Vec::new();
    for &subject in subjects {
        let range = primitives_of(geometry, subject);
        tasks.extend(
            (range.clone()).step_by(CHUNK as usize).map(|first| (subject, first..range.end.min(first + CHUNK))),
        );
    }
    tasks.sort_by_key(|(_, range)| range.start);
    let margins = Margins::new(geometry, scene.objects.len() as u32);
    let margins: HashMap<ObjectId, f64> =
        subjects.par_iter().map(|subject| (*subject, margins.of(geometry, subject.0))).collect();
    progress.enter(Stage::Contacts, tasks.iter().map(|(_, range)| range.len()).sum())?;
    let found: Vec<Contacts> = tasks
        .into_par_iter()
        .map(|(subject, range)| {
            let mut contacts = Contacts::default();
            let seeker = Seeker {
                scene,
                subject,
                copies,
                is_refractor: is_refractor(scene, subject),
                margin: margins[&subject],
            };
            let faces = range.len();
            for face in range {
                progress.go_on()?;
                seeker.look(face, &mut contacts);
            }
            progress.advance(faces);
            Ok(contacts)
        })
        .collect::<Result<_, Cancelled>>()?;
    let mut all = Contacts::default();
    for part in found {
        let offset = all.contacts.len() as u32;
        all.faces.extend(part.faces);
        all.ends.extend(part.ends.iter().map(|end| end + offset));
        all.contacts.extend(part.contacts);
        all.crossing.extend(part.crossing);
    }
    all.crossing.sort_unstable();
    all.crossing.dedup();
    Ok(all)
}

/// The objects whose surroundings are asked for.
pub fn subjects(scene: &Scene) -> impl Iterator<Item = ObjectId> {
    (0..scene.objects.len() as u32).map(ObjectId).filter(|&id| {
        matches!(scene.object(id).surface, Surface::Refractor { .. } | Surface::Light { .. })
            && scene.geometry.face_count(id.0) > 0
    })
}

pub fn is_refractor(scene: &Scene, object: ObjectId) -> bool {
    matches!(scene.object(object).surface, Surface::Refractor { .. })
}

/// The primitives of an object.
pub fn primitives_of(geometry: &Geometry, object: ObjectId) -> std::ops::Range<PrimitiveId> {
    match geometry.range(object.0) {
        ObjectRange::Triangles(range) => range.clone(),
        ObjectRange::Sphere(id) => *id..*id + 1,
    }
}

struct Seeker<'a> {
    scene: &'a Scene,
    subject: ObjectId,
    copies: &'a Copies,
    is_refractor: bool,
    /// How far around a face others are looked for.
    margin: f64,
}

/// What is known of another object beforehand.
struct Other {
    object: ObjectId,
    is_copy: bool,
    is_refractor: bool,
    tolerance: Tolerance,
}

impl Seeker<'_> {
    fn about(&self, object: ObjectId) -> Other {
        Other {
            object,
            is_copy: self.copies.is_copy(object),
            is_refractor: is_refractor(self.scene, object),
            tolerance: Tolerance::between(&self.scene.geometry, self.subject.0, object.0),
        }
    }

    /// Adds `face` and what touches it, if anything does.
    fn look(&self, face: PrimitiveId, to: &mut Contacts) {
        let geometry = &*self.scene.geometry;
        let (min, max) = Face::bounds_of(geometry, face);
        let (min, max) = (min - self.margin, max + self.margin);
        // Worked out for the first other one: most faces have none near.
        let mut this = None;
        let asks_itself = self.scene.object(self.subject).may_contain_itself();
        let except = (!asks_itself).then_some(self.subject.0);
        let before = to.contacts.len();
        let mut comparable = 0;
        // Primitives of one object mostly follow each other.
        let mut last: Option<Other> = None;
        let outcome = geometry.search_near_box(min, max, except, |primitive| {
            let object = ObjectId(geometry.object_of(primitive));
            let is_own = object == self.subject;
            if primitive == face || is_own && !asks_itself {
                return ControlFlow::Continue(());
            }
            let Some(other) = Face::in_box(geometry, primitive, min, max) else { return ControlFlow::Continue(()) };
            let about = match &last {
                Some(about) if about.object == object => about,
                _ => last.insert(self.about(object)),
            };
            if about.is_copy {
                return ControlFlow::Continue(());
            }
            let (this, comparable_area) =
                this.get_or_insert_with(|| (Face::of(geometry, face), COMPARABLE * geometry.primitive_area(face)));
            if this.is_clear_of(&other, self.margin) {
                return ControlFlow::Continue(());
            }
            let tolerance = about.tolerance;
            let Some(relation) = this.relation(&other, tolerance) else { return ControlFlow::Continue(()) };
            if is_own && relation == Relation::Touches && !this.touches_beyond_corners(&other, tolerance) {
                return ControlFlow::Continue(());
            }
            // Opaque surfaces contain nothing: only where they lie on a refractor do they matter.
            let is_coincident = matches!(relation, Relation::Coincides { .. });
            let is_other_refractor = about.is_refractor;
            if !(is_other_refractor || self.is_refractor && is_coincident) {
                return ControlFlow::Continue(());
            }
            let pair = (self.subject, object);
            let goes_through = relation == Relation::Crosses { through: true };
            if self.is_refractor && goes_through && !is_own && to.crossing.last() != Some(&pair) {
                to.crossing.push(pair);
            }
            let contact = Contact { primitive, relation };
            let stands_first = primitive < face || !is_other_refractor;
            if is_coincident && stands_first && other.cover_all(this, tolerance) {
                // All of the face is stood for, and nothing else about it matters.
                to.contacts.truncate(before);
                to.contacts.push(contact);
                return ControlFlow::Break(());
            }
            to.contacts.push(contact);
            comparable += u32::from(geometry.primitive_area(primitive) >= *comparable_area);
            if comparable > CROWD { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if comparable > CROWD && outcome.is_break() {
            to.contacts.truncate(before);
        } else if to.contacts.len() == before {
            return;
        }
        to.contacts[before..].sort_unstable_by_key(|contact| contact.primitive);
        to.faces.push(face);
        to.ends.push(to.contacts.len() as u32);
    }
}

#[inline]
fn bounds_of_triangle([a, b, c]: &[DVec3; 3]) -> (DVec3, DVec3) {
    (a.min(*b).min(*c), a.max(*b).max(*c))
}

#[inline]
fn bounds_of_sphere(sphere: &Sphere) -> (DVec3, DVec3) {
    (sphere.center - sphere.radius, sphere.center + sphere.radius)
}

/// A primitive, ready to be compared with others.
#[derive(Debug, Clone, Copy)]
pub enum Face {
    Triangle {
        corners: [DVec3; 3],
        /// Unit, outward; zero for a triangle without area.
        normal: DVec3,
    },
    Sphere(Sphere),
}

impl Face {
    pub fn of(geometry: &Geometry, primitive: PrimitiveId) -> Self {
        match geometry.sphere(primitive) {
            Some(sphere) => Self::Sphere(*sphere),
            None => Self::with_corners(geometry.corners(primitive)),
        }
    }

    fn with_corners(corners: [DVec3; 3]) -> Self {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        Self::Triangle { corners, normal }
    }

    /// A primitive, if the box around it meets the box from `min` to `max`.
    #[inline]
    fn in_box(geometry: &Geometry, primitive: PrimitiveId, min: DVec3, max: DVec3) -> Option<Self> {
        let is_in = |(low, high): (DVec3, DVec3)| (low.cmple(max) & high.cmpge(min)).all();
        match geometry.sphere(primitive) {
            Some(sphere) => is_in(bounds_of_sphere(sphere)).then_some(Self::Sphere(*sphere)),
            None => {
                let corners = geometry.corners(primitive);
                is_in(bounds_of_triangle(&corners)).then(|| Self::with_corners(corners))
            }
        }
    }

    /// Lowest and highest coordinates of a primitive.
    fn bounds_of(geometry: &Geometry, primitive: PrimitiveId) -> (DVec3, DVec3) {
        match geometry.sphere(primitive) {
            Some(sphere) => bounds_of_sphere(sphere),
            None => bounds_of_triangle(&geometry.corners(primitive)),
        }
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        match self {
            Self::Triangle { corners, .. } => bounds_of_triangle(corners),
            Self::Sphere(sphere) => bounds_of_sphere(sphere),
        }
    }

    /// Whether this and another are spheres farther apart than `margin`, the one in the other or beside it. Quick: most spheres are, of many.
    fn is_clear_of(&self, other: &Self, margin: f64) -> bool {
        let (Self::Sphere(a), Self::Sphere(b)) = (self, other) else { return false };
        let squared = a.center.distance_squared(b.center);
        let (apart, within) = (a.radius + b.radius + margin, (a.radius - b.radius).abs() - margin);
        squared > apart * apart || (within > 0.0 && squared < within * within)
    }

    /// Largest magnitude of each coordinate.
    fn reach(&self) -> DVec3 {
        let (min, max) = self.bounds();
        min.abs().max(max.abs())
    }

    /// Whether two faces of one object that touch do so at more than the corners and the edge that they share.
    fn touches_beyond_corners(&self, other: &Self, tolerance: Tolerance) -> bool {
        let (Self::Triangle { corners: a, normal }, Self::Triangle { corners: b, .. }) = (self, other) else {
            return true;
        };
        let margin = tolerance.along(*normal, self.reach().max(other.reach()));
        let shared = |p: &DVec3| b.iter().position(|q| q == p);
        let joints: [Option<usize>; 3] = std::array::from_fn(|i| shared(&a[i]));
        match joints.iter().flatten().count() {
            0 => true,
            // An edge from the common corner that lies on the other face.
            1 => (0..3).any(|i| {
                let Some(j) = joints[i] else { return false };
                let lies_on = |edges: &[DVec3; 3], k: usize, face: &[DVec3; 3], corner: usize| {
                    [1, 2].into_iter().any(|step| is_along(edges[(k + step) % 3], face, corner, margin))
                };
                lies_on(a, i, b, j) || lies_on(b, j, a, i)
            }),
            _ => false,
        }
    }

    /// How `other` meets this face; `None` where it does not.
    pub fn relation(&self, other: &Self, tolerance: Tolerance) -> Option<Relation> {
        let least = tolerance.least;
        match (self, other) {
            (Self::Triangle { corners: f, normal: nf }, Self::Triangle { corners: t, normal: nt }) => {
                Pair { f, nf: *nf, t, nt: *nt, reach: self.reach().max(other.reach()), tolerance }.relation()
            }
            (Self::Triangle { corners, .. }, Self::Sphere(sphere))
            | (Self::Sphere(sphere), Self::Triangle { corners, .. }) => {
                let near = closest_point(*corners, sphere.center).distance(sphere.center);
                let far = corners.iter().map(|c| c.distance(sphere.center)).fold(0.0, f64::max);
                let through = near < sphere.radius - least && far > sphere.radius + least;
                (near <= sphere.radius + least && far >= sphere.radius - least).then_some(Relation::Crosses { through })
            }
            (Self::Sphere(a), Self::Sphere(b)) => {
                let (distance, difference) = (a.center.distance(b.center), (a.radius - b.radius).abs());
                if distance <= least && difference <= least {
                    return Some(Relation::Coincides { same: true });
                }
                let through = difference + least < distance && distance < a.radius + b.radius - least;
                (difference - least <= distance && distance <= a.radius + b.radius + least)
                    .then_some(Relation::Crosses { through })
            }
        }
    }

    /// Distance from a point to the surface.
    pub fn distance(&self, point: DVec3) -> f64 {
        match self {
            Self::Triangle { corners, .. } => closest_point(*corners, point).distance(point),
            Self::Sphere(s) => (s.center.distance(point) - s.radius).abs(),
        }
    }

    /// Whether this face, which coincides with `other`, covers all of it.
    fn cover_all(&self, other: &Self, tolerance: Tolerance) -> bool {
        match other {
            Self::Triangle { corners, .. } => self.cover(corners, tolerance) == Cover::All,
            Self::Sphere(_) => true,
        }
    }

    /// Whether this face, which coincides with the one that `cell` is a part of, covers that cell. Its edges count as wider by the tolerance.
    pub fn cover(&self, cell: &[DVec3], tolerance: Tolerance) -> Cover {
        let Self::Triangle { corners, normal } = self else { return Cover::All };
        let reach = self.reach();
        let mut covers_all = true;
        for k in 0..3 {
            let inward = normal.cross(corners[(k + 1) % 3] - corners[k]).normalize_or_zero();
            let margin = 2.0 * tolerance.along(inward, reach);
            let depth = |p: &DVec3| inward.dot(*p - corners[k]) + margin;
            if cell.iter().all(|p| depth(p) < 0.0) {
                return Cover::Nothing;
            }
            covers_all &= cell.iter().all(|p| depth(p) >= 0.0);
        }
        if covers_all {
            return Cover::All;
        }
        // Apart along an edge of the cell, for cells that are triangles.
        if let [a, b, c] = *cell {
            let up = (b - a).cross(c - a);
            for (start, end) in [(a, b), (b, c), (c, a)] {
                let inward = up.cross(end - start).normalize_or_zero();
                let margin = 2.0 * tolerance.along(inward, reach);
                if corners.iter().all(|p| inward.dot(*p - start) < -margin) {
                    return Cover::Nothing;
                }
            }
        }
        Cover::Part
    }
}

/// Whether the edge from corner `k` of a face to `end` lies on that face, some way from the corner on.
fn is_along(end: DVec3, face: &[DVec3; 3], k: usize, margin: f64) -> bool {
    let corner = face[k];
    let (p, q) = (face[(k + 1) % 3] - corner, face[(k + 2) % 3] - corner);
    // So far from the corner the third edge has not cut the face off.
    let reach = (end - corner).length().min(p.cross(q).length() / p.distance(q)) / 2.0;
    let point = corner + (end - corner).normalize_or_zero() * reach;
    // What is nearer to the corner than that cannot be told from it.
    reach > 4.0 * margin && closest_point(*face, point).distance(point) <= margin
}

/// How much of a cell a coincident face covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cover {
    Nothing,
    /// Some of it, or it cannot be told.
    Part,
    All,
}

/// Two triangles.
struct Pair<'a> {
    f: &'a [DVec3; 3],
    nf: DVec3,
    t: &'a [DVec3; 3],
    nt: DVec3,
    reach: DVec3,
    tolerance: Tolerance,
}

impl Pair<'_> {
    fn allowance(&self, axis: DVec3) -> f64 {
        self.tolerance.along(axis, self.reach)
    }

    fn relation(&self) -> Option<Relation> {
        let heights = self.t.map(|p| self.nf.dot(p - self.f[0]));
        let tolerance = self.allowance(self.nf);
        if heights.iter().all(|h| *h > tolerance) || heights.iter().all(|h| *h < -tolerance) {
            return None;
        }
        let heights_of_f = self.f.map(|p| self.nt.dot(p - self.t[0]));
        let tolerance_t = self.allowance(self.nt);
        if heights_of_f.iter().all(|h| *h > tolerance_t) || heights_of_f.iter().all(|h| *h < -tolerance_t) {
            return None;
        }
        let edges = |p: &[DVec3; 3]| [p[1] - p[0], p[2] - p[1], p[0] - p[2]];
        let (edges_f, edges_t) = (edges(self.f), edges(self.t));
        for a in edges_f {
            if edges_t.iter().any(|b| self.gap_along(a.cross(*b), a.length() * b.length()) > 0.0) {
                return None;
            }
        }
        // In one plane the axes above are all normal to it; there the edges' own normals tell.
        let is_flat = |heights: &[f64; 3], tolerance: f64| heights.iter().all(|h| h.abs() <= tolerance);
        let larger = |a: &[DVec3; 3], b: &[DVec3; 3]| {
            let size = |p: &[DVec3; 3]| edges(p).iter().map(|e| e.length_squared()).fold(0.0, f64::max);
            size(a) >= size(b)
        };
        let cos = self.nf.dot(self.nt);
        let coplanar =
            if larger(self.f, self.t) { is_flat(&heights, tolerance) } else { is_flat(&heights_of_f, tolerance_t) };
        if coplanar && cos.abs() > PARALLEL {
            let (mut shares_area, mut is_apart) = (true, false);
            for axis in edges_f.map(|e| e.cross(self.nf)).into_iter().chain(edges_t.map(|e| e.cross(self.nt))) {
                let gap = self.gap_along(axis, 1.0);
                is_apart |= gap > 0.0;
                shares_area &= gap < -3.0 * self.allowance(axis.normalize_or_zero());
            }
            return if is_apart {
                None
            } else if shares_area {
                Some(Relation::Coincides { same: cos > 0.0 })
            } else {
                Some(Relation::Touches)
            };
        }
        let is_on_both_sides =
            |h: &[f64; 3], tolerance: f64| h.iter().any(|h| *h > tolerance) && h.iter().any(|h| *h < -tolerance);
        let through = is_on_both_sides(&heights, tolerance) && is_on_both_sides(&heights_of_f, tolerance_t);
        Some(if self.reaches_interior(&heights, tolerance) { Relation::Crosses { through } } else { Relation::Touches })
    }

    /// Distance of the two triangles' shadows on an axis beyond the tolerance: positive where the axis separates them. An axis too short
    /// for its `size` says nothing.
    fn gap_along(&self, axis: DVec3, size: f64) -> f64 {
        let length = axis.length();
        if length <= 1e-9 * size || length == 0.0 {
            return f64::NEG_INFINITY;
        }
        let axis = axis / length;
        let shadow = |p: &[DVec3; 3]| {
            let [a, b, c] = p.map(|p| axis.dot(p - self.f[0]));
            (a.min(b).min(c), a.max(b).max(c))
        };
        let ((f_min, f_max), (t_min, t_max)) = (shadow(self.f), shadow(self.t));
        (t_min - f_max).max(f_min - t_max) - self.allowance(axis)
    }

    /// Whether `t` meets the plane of `f` within `f`, farther than the tolerance from the edges of `f`.
    fn reaches_interior(&self, heights: &[f64; 3], tolerance: f64) -> bool {
        // Where t meets the plane: corners in it, and points where edges go through.
        let mut points: Vec<DVec3> = Vec::with_capacity(4);
        for k in 0..3 {
            let (a, b) = (heights[k], heights[(k + 1) % 3]);
            let (p, q) = (self.t[k], self.t[(k + 1) % 3]);
            if a.abs() <= tolerance {
                points.push(p);
            }
            if (a < -tolerance && b > tolerance) || (a > tolerance && b < -tolerance) {
                points.push(p + (q - p) * (a / (a - b)));
            }
        }
        let inward: [(DVec3, DVec3); 3] = std::array::from_fn(|k| {
            let inward = self.nf.cross(self.f[(k + 1) % 3] - self.f[k]).normalize_or_zero();
            (self.f[k] + inward * (2.0 * self.allowance(inward)), inward)
        });
        let reaches = |p: DVec3, q: DVec3| {
            let (mut from, mut to) = (0.0f64, 1.0f64);
            for (start, inward) in inward {
                let (a, b) = (inward.dot(p - start), inward.dot(q - start));
                if a < 0.0 && b < 0.0 {
                    return false;
                } else if a < 0.0 {
                    from = from.max(a / (a - b));
                } else if b < 0.0 {
                    to = to.min(a / (a - b));
                }
            }
            from <= to
        };
        match points[..] {
            [] => false,
            [p] => reaches(p, p),
            _ => (0..points.len()).any(|i| (i + 1..points.len()).any(|j| reaches(points[i], points[j]))),
        }
    }
}

/// Whether `other` coincides with `face`; if so, whether with the same normal.
pub fn coincides(geometry: &Geometry, face: PrimitiveId, other: PrimitiveId) -> Option<bool> {
    let tolerance = Tolerance::between(geometry, geometry.object_of(face), geometry.object_of(other));
    match Face::of(geometry, face).relation(&Face::of(geometry, other), tolerance) {
        Some(Relation::Coincides { same }) => Some(same),
        _ => None,
    }
}

/// Whether a coincident face stands for the one at `point`: that of something opaque, or the first of the refractors'.
pub fn is_stood_for(scene: &Scene, point: &SurfacePoint) -> bool {
    let geometry = &*scene.geometry;
    let own = ObjectId(geometry.object_of(point.primitive));
    let this = Face::of(geometry, point.primitive);
    let except = (!scene.object(own).may_contain_itself()).then_some(own.0);
    // With room for what reaches farther.
    let margin = 4.0 * largest(geometry, own.0);
    let (min, max) = (point.position - margin, point.position + margin);
    let search = geometry.search_near_box(min, max, except, |primitive| {
        let object = ObjectId(geometry.object_of(primitive));
        let goes_first = primitive < point.primitive || !is_refractor(scene, object);
        if primitive == point.primitive || !goes_first || (except.is_some() && object == own) {
            return ControlFlow::Continue(());
        }
        let Some(other) = Face::in_box(geometry, primitive, min, max) else { return ControlFlow::Continue(()) };
        let tolerance = Tolerance::between(geometry, own.0, object.0);
        let is_stood_for = matches!(this.relation(&other, tolerance), Some(Relation::Coincides { .. }))
            && other.cover(&[point.position], tolerance) == Cover::All;
        if is_stood_for { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    search.is_break()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight roundings of a length of 1.
    const TIGHT: Tolerance = Tolerance { length: 1.0, least: 1e-12 };

    fn face(corners: [[f64; 3]; 3]) -> Face {
        let corners = corners.map(DVec3::from);
        Face::Triangle { corners, normal: (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero() }
    }

    fn flat() -> Face {
        face([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    }

    fn relation(other: [[f64; 3]; 3]) -> Option<Relation> {
        flat().relation(&face(other), TIGHT)
    }

    #[test]
    fn triangles_that_cross_touch_and_miss() {
        let [through, resting] = [true, false].map(|through| Some(Relation::Crosses { through }));
        // Through the middle, wholly inside the outline: a small object pokes through a large face.
        assert_eq!(relation([[0.2, 0.2, -1.0], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]]), through);
        // With a corner, and with an edge, resting on the inside.
        assert_eq!(relation([[0.2, 0.2, 0.0], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]]), resting);
        assert_eq!(relation([[0.2, 0.2, 0.0], [0.3, 0.2, 0.0], [0.2, 0.3, 1.0]]), resting);
        // At a corner, along an edge, across an edge from outside.
        assert_eq!(relation([[0.0, 0.0, 0.0], [-1.0, 0.0, 1.0], [0.0, -1.0, 1.0]]), Some(Relation::Touches));
        assert_eq!(relation([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.0, 1.0]]), Some(Relation::Touches));
        // Beside it and above it.
        assert_eq!(relation([[1.2, 0.2, -1.0], [1.3, 0.2, 1.0], [1.2, 0.3, 1.0]]), None);
        assert_eq!(relation([[0.2, 0.2, 1e-6], [0.3, 0.2, 1.0], [0.2, 0.3, 1.0]]), None);
        assert_eq!(relation([[0.0, 0.0, 1e-6], [1.0, 0.0, 1e-6], [0.0, 1.0, 1e-6]]), None);
    }

    #[test]
    fn triangles_in_one_plane() {
        let same = Some(Relation::Coincides { same: true });
        let opposed = Some(Relation::Coincides { same: false });
        assert_eq!(relation([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), same);
        assert_eq!(relation([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]), opposed);
        assert_eq!(relation([[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [0.0, 5.0, 0.0]]), same);
        assert_eq!(relation([[0.1, 0.1, 0.0], [0.2, 0.1, 0.0], [0.1, 0.2, 0.0]]), same);
        // Neighbours that share an edge or a corner, and one farther away.
        assert_eq!(relation([[0.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]), Some(Relation::Touches));
        assert_eq!(relation([[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), Some(Relation::Touches));
        assert_eq!(relation([[2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0]]), None);
    }

    #[test]
    fn spheres_and_triangles() {
        let ball = |x: f64, z: f64, radius: f64| Face::Sphere(Sphere { center: DVec3::new(x, 0.2, z), radius });
        assert_eq!(flat().relation(&ball(0.2, 0.5, 0.6), TIGHT), Some(Relation::Crosses { through: true }));
        assert_eq!(flat().relation(&ball(0.2, 0.5, 0.4), TIGHT), None);
        assert_eq!(flat().relation(&ball(0.2, 0.0, 5.0), TIGHT), None);
        assert_eq!(ball(0.0, 0.0, 1.0).relation(&ball(0.0, 0.0, 1.0), TIGHT), Some(Relation::Coincides { same: true }));
        assert_eq!(ball(0.0, 0.0, 1.0).relation(&ball(0.0, 0.0, 1.0 + 1e-6), TIGHT), None);
        assert_eq!(
            ball(0.0, 0.0, 1.0).relation(&ball(1.5, 0.0, 1.0), TIGHT),
            Some(Relation::Crosses { through: true })
        );
        assert_eq!(ball(0.0, 0.0, 1.0).relation(&ball(2.5, 0.0, 1.0), TIGHT), None);
    }

    #[test]
    fn how_much_is_covered() {
        let cell = |size: f64, x: f64| {
            [DVec3::new(x, 0.1, 0.0), DVec3::new(x + size, 0.1, 0.0), DVec3::new(x, 0.1 + size, 0.0)]
        };
        assert_eq!(flat().cover(&cell(0.1, 0.1), TIGHT), Cover::All);
        assert_eq!(flat().cover(&cell(3.0, 0.1), TIGHT), Cover::Part);
        assert_eq!(flat().cover(&cell(0.1, 2.0), TIGHT), Cover::Nothing);
        assert_eq!(flat().cover(&[DVec3::new(1.0, 0.0, 0.0)], TIGHT), Cover::All);
    }
}
