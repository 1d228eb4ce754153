//! Where an edit has moved surfaces: all that lies far from there is as it was.

use glam::DVec3;

use super::face::Face;
use super::tolerance;
use crate::geometry::{Geometry, PrimitiveId};
use crate::scene::ObjectId;

/// The places where changed objects were and are, grown by their tolerances (local coordinates).
#[derive(Debug, Clone, Default)]
pub struct Changes {
    boxes: Vec<(DVec3, DVec3)>,
}

impl Changes {
    /// Of objects that were elsewhere, or other ones, `before`.
    pub fn new(now: &Geometry, before: &Geometry, changed: &[ObjectId]) -> Self {
        let both = changed.iter().flat_map(|&object| [(now, object), (before, object)]);
        Self { boxes: both.map(|(geometry, object)| grown(geometry, object, geometry.bounds_of(object.0))).collect() }
    }

    /// Whether an object that has not changed itself cannot have come into contact with one that has, nor out of it, nor into it or out of it.
    pub fn are_far_from(&self, geometry: &Geometry, object: ObjectId) -> bool {
        self.are_outside(grown(geometry, object, geometry.bounds_of(object.0)))
    }

    /// The same of one of its faces.
    pub fn are_far_from_face(&self, geometry: &Geometry, object: ObjectId, face: PrimitiveId) -> bool {
        self.are_outside(grown(geometry, object, Face::bounds_of(geometry, face)))
    }

    fn are_outside(&self, (min, max): (DVec3, DVec3)) -> bool {
        let overlaps = |(low, high): &(DVec3, DVec3)| min.cmple(*high).all() && low.cmple(max).all();
        !self.boxes.iter().any(overlaps)
    }
}

fn grown(geometry: &Geometry, object: ObjectId, (min, max): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let margin = tolerance::largest(geometry, object.0);
    (min - margin, max + margin)
}
