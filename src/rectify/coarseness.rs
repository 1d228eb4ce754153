//! How fine cells are where very many surfaces meet: so that dividing faces costs a bounded time and memory.

use rayon::prelude::*;

use super::cells;
use super::contact::Contacts;
use crate::geometry::PrimitiveId;
use crate::scene::Scene;

/// How coarse cells may be, as in [`cells::divide`]. Cells are as fine as possible for up to a few thousand contacts of large faces; with more
/// contacts, or where the cells would not fit into memory, they are coarser.
pub fn coarseness(scene: &Scene, contacts: &Contacts) -> f64 {
    /// Contacts of large faces up to which cells are as fine as possible.
    const AMPLE: f64 = 4000.0;
    /// A triangle is large from this share of its object's size on; smaller ones are cells themselves.
    const LARGE: f64 = 1.0 / 16.0;
    if contacts.face_count() == 0 {
        return 1.0;
    }
    let geometry = &*scene.geometry;
    let is_large = |face: PrimitiveId| {
        let (min, max) = geometry.bounds_of(geometry.object_of(face));
        geometry.sphere(face).is_some() || geometry.primitive_area(face) > (LARGE * (max - min).length()).powi(2)
    };
    let meetings = contacts.iter().filter(|(face, _)| is_large(*face)).map(|(_, others)| others.len());
    let by_meetings = (meetings.sum::<usize>() as f64 / AMPLE).max(1.0);
    // For each face: the number of refractors that it is divided for, and the number of the finest cells along its side.
    let faces: Vec<(f64, f64)> = (contacts.iter().collect::<Vec<_>>().par_iter())
        .filter_map(|(face, others)| {
            let finest = cells::finest(scene, *face, others)?;
            Some((cells::touching(scene, others).len() as f64, geometry.primitive_area(*face).sqrt() / finest))
        })
        .collect();
    let mut coarseness = by_meetings;
    while predicted_entries(&faces, coarseness) > MOST_ENTRIES && faces.iter().any(|(_, side)| *side > coarseness) {
        coarseness *= 2.0;
    }
    coarseness
}

/// Most cells and refractors named in them, all together. Each costs one containment question and about a hundred bytes.
const MOST_ENTRIES: f64 = 5e5;

/// About how many entries there will be: cells lie along the curves where others meet a face, until they fill it.
fn predicted_entries(faces: &[(f64, f64)], coarseness: f64) -> f64 {
    let of_face = |&(refractors, side): &(f64, f64)| {
        let side = (side / coarseness).max(1.0);
        (4.0 + refractors) * (2.0 * refractors * side).min(2.0 * side * side).max(1.0)
    };
    faces.iter().map(of_face).sum()
}
