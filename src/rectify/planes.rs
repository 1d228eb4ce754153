//! What a GPU is given beside the arrays of [`super::flat`], to find out at a point what an asked cell asks: where coincident faces end.

use super::face::Face;
use super::flat::NOT_LISTED;
use super::table::InterfaceTable;
use super::tolerance::Tolerance;
use crate::geometry::{Enclosure, PrimitiveId};
use crate::scene::{ObjectId, Scene};

/// The planes of the edges of each coincident or opaque primitive, three of (a, b, c, d): it covers a point in its plane where
/// ax + by + cz + d ≥ 0 for all (local coordinates). In the order of `coincident` and `opaque`.
#[derive(Debug, Clone, Default)]
pub struct AskedPlanes {
    pub coincident: Vec<[[f64; 4]; 3]>,
    pub opaque: Vec<[[f64; 4]; 3]>,
}

impl InterfaceTable {
    /// The planes of all asked cells.
    pub fn asked_planes(&self, scene: &Scene) -> AskedPlanes {
        let geometry = &*scene.geometry;
        let flat = &*self.flat().layout;
        let mut planes = AskedPlanes::default();
        for (record, cell) in flat.asked.iter().zip(&self.layout.asked) {
            let of = |primitive: PrimitiveId| {
                let tolerance = Tolerance::between(geometry, cell.base.subject.0, geometry.object_of(primitive));
                Face::of(geometry, primitive).edge_planes(tolerance)
            };
            let range = |first: u32, count: u32| first as usize..(first + count) as usize;
            planes.opaque.extend(flat.opaque[range(record.first_opaque, record.opaque_count)].iter().map(|id| of(*id)));
            for member in &flat.members[range(record.first_member, record.member_count)] {
                let coincident = &flat.coincident[range(member.first_coincident, member.coincident_count)];
                planes.coincident.extend(coincident.iter().map(|twin| of(twin.primitive)));
            }
        }
        planes
    }

    /// A refractor that an asked cell asks about and whose membership takes more to find out than one ray or one distance; `None` if there is
    /// none.
    pub fn asks_more_than_a_ray(&self, scene: &Scene) -> Option<ObjectId> {
        let flat = &*self.flat().layout;
        let listed = flat.asked.iter().filter(|record| record.first_answer != NOT_LISTED);
        let members = listed.flat_map(|record| {
            &flat.members[record.first_member as usize..(record.first_member + record.member_count) as usize]
        });
        let is_simple = |refractor: ObjectId, has_coincident: bool| {
            let object = scene.object(refractor);
            let is_closed = object.enclosure == Enclosure::Closed || scene.geometry.sphere_of(refractor.0).is_some();
            is_closed && !(has_coincident && object.may_contain_itself())
        };
        members
            .map(|member| (ObjectId(member.refractor), member.coincident_count > 0))
            .find(|(refractor, has_coincident)| !is_simple(*refractor, *has_coincident))
            .map(|(refractor, _)| refractor)
    }
}
