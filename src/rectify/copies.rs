//! Refractors with the same surface at the same place. Of bit-equal ones only the first is searched for contacts, however many there are: all
//! have the same contacts.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::face::{Cover, Face};
use super::relation::Relation;
use super::subjects::primitives_of;
use super::surroundings::{Membership, Surroundings};
use super::tolerance::{Tolerance, largest};
use crate::geometry::{Enclosure, Geometry, PrimitiveId};
use crate::scene::{ObjectId, Scene};

/// The closed refractors that are copies of another one, bit by bit.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Copies {
    /// The copies of each refractor that is the first of several, in ascending order.
    of_first: HashMap<ObjectId, Vec<ObjectId>>,
    first_of_copy: HashMap<ObjectId, ObjectId>,
}

impl Copies {
    pub fn find(scene: &Scene) -> Self {
        let geometry = &*scene.geometry;
        let mut alike: HashMap<[u64; 7], Vec<ObjectId>> = HashMap::new();
        for (refractor, _) in scene.refractors() {
            let faces = geometry.face_count(refractor.0);
            if faces > 0 && scene.object(refractor).enclosure == Enclosure::Closed {
                let (min, max) = geometry.bounds_of(refractor.0);
                let [a, b, c] = (min + 0.0).to_array().map(f64::to_bits);
                let [d, e, f] = (max + 0.0).to_array().map(f64::to_bits);
                alike.entry([u64::from(faces), a, b, c, d, e, f]).or_default().push(refractor);
            }
        }
        let groups: Vec<Vec<ObjectId>> = alike.into_values().filter(|group| group.len() > 1).collect();
        // Objects with equal bounds may still be of several sets of copies.
        let sets: Vec<Vec<ObjectId>> = (groups.into_par_iter())
            .flat_map_iter(|group| {
                let mut sets: Vec<Vec<ObjectId>> = Vec::new();
                for refractor in group {
                    match sets.iter_mut().find(|set| is_bit_equal(geometry, set[0], refractor)) {
                        Some(set) => set.push(refractor),
                        None => sets.push(vec![refractor]),
                    }
                }
                sets.into_iter().filter(|set| set.len() > 1)
            })
            .collect();
        let mut copies = Self::default();
        for mut set in sets {
            set.sort_unstable();
            let first = set.remove(0);
            copies.first_of_copy.extend(set.iter().map(|copy| (*copy, first)));
            copies.of_first.insert(first, set);
        }
        copies
    }

    /// Whether an earlier refractor stands for this object.
    pub fn is_copy(&self, object: ObjectId) -> bool {
        self.first_of_copy.contains_key(&object)
    }

    /// Whether there is a copy of this refractor, or it is one.
    pub fn is_copied(&self, refractor: ObjectId) -> bool {
        self.is_copy(refractor) || self.of_first.contains_key(&refractor)
    }

    /// Whether two refractors are copies of each other.
    pub fn are_alike(&self, a: ObjectId, b: ObjectId) -> bool {
        let first = |id: ObjectId| self.first_of_copy.get(&id).copied().unwrap_or(id);
        first(a) == first(b)
    }

    /// The refractors that `first` stands for, besides itself.
    pub fn of(&self, first: ObjectId) -> &[ObjectId] {
        self.of_first.get(&first).map_or(&[], Vec::as_slice)
    }

    /// Adds the copies of everything that is known about a piece of surface. The subject's own are on its inner side.
    pub fn complete(&self, surroundings: &mut Surroundings) {
        if self.of_first.is_empty() || surroundings.is_masked {
            return;
        }
        for &copy in self.of(surroundings.subject) {
            surroundings.add(copy, Membership::InnerOnly);
        }
        let sides =
            [(surroundings.outer.clone(), Membership::OuterOnly), (surroundings.inner.clone(), Membership::InnerOnly)];
        for (side, membership) in sides {
            for &copy in side.iter().flat_map(|first| self.of(*first)) {
                surroundings.add(copy, membership);
            }
        }
    }

    /// Adds the copies of all `objects`, and puts them in ascending order.
    pub fn complete_list(&self, objects: &mut Vec<ObjectId>) {
        let copies: Vec<ObjectId> = objects.iter().flat_map(|first| self.of(*first)).copied().collect();
        objects.extend(copies);
        objects.sort_unstable();
        objects.dedup();
    }
}

/// Whether two objects have equal primitives in the same order.
fn is_bit_equal(geometry: &Geometry, a: ObjectId, b: ObjectId) -> bool {
    let (a, b) = (primitives_of(geometry, a), primitives_of(geometry, b));
    a.len() == b.len()
        && a.zip(b).all(|(a, b)| match (geometry.sphere(a), geometry.sphere(b)) {
            (None, None) => geometry.corners(a) == geometry.corners(b),
            (a, b) => a == b,
        })
}

/// Whether two refractors have the same surface, looking the same way, however it is divided into faces.
pub fn have_same_surface(scene: &Scene, a: ObjectId, b: ObjectId) -> bool {
    /// Areas that differ by less than this, relatively, count as equal.
    const SAME_AREA: f64 = 1e-6;
    let geometry = &*scene.geometry;
    if is_bit_equal(geometry, a, b) {
        return true;
    }
    let (area_a, area_b) = (geometry.area(a.0), geometry.area(b.0));
    if (area_a - area_b).abs() > SAME_AREA * area_a.max(area_b) {
        return false;
    }
    // A surface of equal area that lies on the other everywhere is the same surface.
    primitives_of(geometry, a).into_par_iter().all(|face| lies_on(scene, face, b))
}

/// Whether a face lies on the surface of `other` and looks the same way: asked at its middle and close to its corners.
fn lies_on(scene: &Scene, face: PrimitiveId, other: ObjectId) -> bool {
    const CLOSE: f64 = 1.0 / 64.0;
    let geometry = &*scene.geometry;
    let own = geometry.object_of(face);
    let tolerance = Tolerance::between(geometry, own, other.0);
    let this = Face::of(geometry, face);
    let on = |primitive: PrimitiveId| {
        let that = Face::of(geometry, primitive);
        (this.relation(&that, tolerance) == Some(Relation::Coincides { same: true })).then_some(that)
    };
    if geometry.sphere(face).is_some() {
        return geometry.sphere_of(other.0).is_some() && on(primitives_of(geometry, other).start).is_some();
    }
    let corners = geometry.corners(face);
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let margin = DVec3::splat(largest(geometry, own));
    corners.map(|corner| corner.lerp(middle, CLOSE)).into_iter().chain([middle]).all(|point| {
        let mut is_covered = false;
        geometry.for_each_near_box(point - margin, point + margin, Some(own), |primitive| {
            is_covered |= geometry.object_of(primitive) == other.0
                && on(primitive).is_some_and(|that| that.cover(&[point], tolerance) == Cover::All);
        });
        is_covered
    })
}
