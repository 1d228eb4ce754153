//! The objects that rectification is about, and their primitives.

use std::ops::Range;

use crate::geometry::{Geometry, ObjectRange, PrimitiveId};
use crate::scene::{ObjectId, Scene, Surface};

/// The objects whose surroundings are asked for.
pub fn subjects(scene: &Scene) -> impl Iterator<Item = ObjectId> {
    (0..scene.objects.len() as u32).map(ObjectId).filter(|&id| {
        matches!(scene.object(id).surface, Surface::Refractor { .. } | Surface::Light { .. })
            && scene.geometry.face_count(id.0) > 0
    })
}

/// The primitives of an object.
pub fn primitives_of(geometry: &Geometry, object: ObjectId) -> Range<PrimitiveId> {
    match geometry.range(object.0) {
        ObjectRange::Triangles(range) => range.clone(),
        ObjectRange::Sphere(id) => *id..*id + 1,
    }
}
