//! The table that is looked up at every crossing, as arrays of plain data: a GPU is given the same arrays, and reads them as [`FlatTable::look`]
//! does. Every record consists of `u32` words only, without padding. Unless said otherwise a word is an index into the array named.
//!
//! | array | record | words | indexed by |
//! |---|---|---|---|
//! | `address_of_object` | address | 1 | object id |
//! | `address_of_primitive` | address | 1 | primitive id; empty if no object needs it |
//! | `faces` | [`FaceRecord`] | `root`, `group` | address without its highest bit |
//! | `nodes` | [`NodeRecord`] | `kind`, `index` | `root`, `index` |
//! | `asked` | [`AskedRecord`] | `first_answer`, `first_member`, `member_count`, `first_opaque`, `opaque_count` | `index` of a node |
//! | `members` | [`MemberRecord`] | `refractor`, `first_coincident`, `coincident_count` | `first_member` and on |
//! | `coincident` | [`CoincidentRecord`] | `primitive`, `is_same` | `first_coincident` and on |
//! | `opaque` | primitive id | 1 | `first_opaque` and on |
//! | `answers` | [`Answer`] | `outside`, `inside`: medium ids, both `u32::MAX` where the crossing is skipped | address, node or asked cell |
//!
//! **Address.** Take `address_of_object`; if it is [`BY_FACE`], take `address_of_primitive` instead. Without [`DIVIDED`] it is an index into `answers`,
//! and the answer is found. With it the rest is an index into `faces`: the face is divided into cells. What is no refractor and no light has
//! no answer: both are [`BY_FACE`].
//!
//! **Descent.** Begin with three weights and a node. In a triangle: the barycentric weights of its corners, at `root`. On a sphere: the
//! magnitudes of the unit outward normal's x, y, z, at `root` + octant, where bit 0, 1, 2 of the octant is set if x, y, z is negative.
//! A node of `kind` 0, 1 or 2 is cut in the middle of the edge from corner a = `kind` to corner b = (a + 1) mod 3. If wa ≥ wb go to node `index` with
//! (wa, wb) ← (wa − wb, 2 wb), otherwise to node `index` + 1 with (2 wa, wb − wa). [`KNOWN`]: `index` is that of the answer.
//! [`ASKED`]: `index` is that of an asked cell, in which the answer differs from point to point.
//!
//! **Asked cell.** If a primitive of `opaque` covers the point, the crossing is skipped. Each member in turn then has a membership m: 0 on neither side, 1 on
//! both, 2 on the inner side only, 3 on the outer only. If one of its `coincident` primitives covers the point, take the first that does: if its id is
//! smaller than that of the face hit, the crossing is skipped; otherwise m is 2 if `is_same` (it looks the same way), else 3. If none does, m is 1
//! if the refractor contains the point, else 0. (If one does and the refractor has several parts that may contain each other, m or a skip is
//! what [`membership_of_parts`] says instead of 2 or 3.) With a radix of 4 for members
//! with coincident primitives and 2 for others, the memberships are digits, the first member's the lowest: their number plus `first_answer` is
//! the index of the answer. "Covers" is [`Face::cover`], "contains" is [`is_inside`].
//!
//! **Not listed.** If `first_answer` is [`NOT_LISTED`], there are too many combinations to list, or too many members to name. The CPU resolves such a
//! point with data that are not in these arrays; a GPU cannot: see [`FlatLayout::unlisted`].

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::asked::AskedCell;
use super::containment::is_inside;
use super::face::{Cover, Face};
use super::surroundings::{Answer, Membership, membership_of_parts};
use super::tolerance::Tolerance;
use crate::geometry::{PrimitiveId, SurfacePoint};
use crate::scene::{ObjectId, Scene};

/// The highest bit of an address: the face is divided.
pub const DIVIDED: u32 = 1 << 31;
/// Instead of an object's address: its faces have addresses of their own.
pub const BY_FACE: u32 = u32::MAX;
/// Kind of a node: one answer holds all over the cell. Smaller kinds are edges.
pub const KNOWN: u32 = 3;
/// Kind of a node: the answer depends on the point.
pub const ASKED: u32 = 4;
/// Instead of an asked cell's first answer: its answers are not in the table.
pub const NOT_LISTED: u32 = u32::MAX;

/// A face that is divided into cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct FaceRecord {
    /// Its root; of a sphere the first of eight that follow each other.
    pub root: u32,
    /// Index into [`super::layout::Layout::groups`]; not read by `look`.
    pub group: u32,
}

/// A cell of a divided face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct NodeRecord {
    /// 0, 1, 2: the edge that is cut, by its first corner; [`KNOWN`]; [`ASKED`].
    pub kind: u32,
    /// Of the first half, the second being the next; of the answer; of the asked cell.
    pub index: u32,
}

/// A cell in which the answer depends on the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct AskedRecord {
    /// Where its answers begin, one for each combination of memberships; or [`NOT_LISTED`].
    pub first_answer: u32,
    pub first_member: u32,
    pub member_count: u32,
    pub first_opaque: u32,
    pub opaque_count: u32,
}

/// A refractor whose membership is asked at the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct MemberRecord {
    /// Object id.
    pub refractor: u32,
    pub first_coincident: u32,
    pub coincident_count: u32,
}

/// A primitive of a member that coincides with the face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct CoincidentRecord {
    /// Primitive id.
    pub primitive: u32,
    /// 1 if it looks the same way as the face, 0 if the other way.
    pub is_same: u32,
}

/// The arrays that follow from geometry alone.
#[derive(Debug, Clone, Default)]
pub struct FlatLayout {
    pub address_of_object: Vec<u32>,
    pub address_of_primitive: Vec<u32>,
    pub faces: Vec<FaceRecord>,
    pub nodes: Vec<NodeRecord>,
    pub asked: Vec<AskedRecord>,
    pub members: Vec<MemberRecord>,
    pub coincident: Vec<CoincidentRecord>,
    pub opaque: Vec<PrimitiveId>,
    /// Number of asked cells whose answers are not listed. If it is not 0, the arrays alone do not answer every crossing.
    pub unlisted: u32,
}

/// All arrays. An edit of media or priorities replaces the answers and shares the rest.
#[derive(Debug, Clone, Default)]
pub struct FlatTable {
    pub layout: Arc<FlatLayout>,
    pub answers: Vec<Answer>,
}

/// What the arrays say about a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lookup {
    Answer(Answer),
    /// The answer is not listed; the number of the asked cell.
    Unlisted(u32),
}

impl FlatTable {
    /// The answer at a point of the surface of a refractor or light: the one description of how the arrays are read.
    #[inline]
    pub fn look(&self, scene: &Scene, object: ObjectId, point: &SurfacePoint, barycentric: [f64; 2]) -> Lookup {
        let address = self.layout.address(object, point.primitive);
        if address & DIVIDED == 0 {
            Lookup::Answer(self.answers[address as usize])
        } else {
            self.look_closely(scene, address & !DIVIDED, point, barycentric)
        }
    }

    /// In a divided face.
    #[inline(never)]
    fn look_closely(&self, scene: &Scene, face: u32, point: &SurfacePoint, barycentric: [f64; 2]) -> Lookup {
        let layout = &*self.layout;
        let (octant, weights) = begin(scene, point, barycentric);
        let leaf = layout.descend(layout.faces[face as usize].root + octant, weights);
        if leaf.kind == KNOWN {
            return Lookup::Answer(self.answers[leaf.index as usize]);
        }
        let asked = &layout.asked[leaf.index as usize];
        if asked.first_answer == NOT_LISTED {
            return Lookup::Unlisted(leaf.index);
        }
        let (mut answer, mut stride) = (asked.first_answer, 1);
        let outcome = layout.memberships(scene, asked, point, |member, membership| {
            answer += membership as u32 * stride;
            stride *= if layout.members[member].coincident_count == 0 { 2 } else { 4 };
        });
        Lookup::Answer(outcome.map_or(Answer::MASKED, |()| self.answers[answer as usize]))
    }
}

impl FlatLayout {
    /// Where the answer for a primitive stands.
    #[inline]
    pub fn address(&self, object: ObjectId, primitive: PrimitiveId) -> u32 {
        match self.address_of_object[object.0 as usize] {
            BY_FACE => self.address_of_primitive[primitive as usize],
            address => address,
        }
    }

    /// Goes from a node down to the leaf that holds the point of those weights.
    #[inline]
    fn descend(&self, node: u32, mut weights: [f64; 3]) -> NodeRecord {
        let mut node = self.nodes[node as usize];
        while node.kind < KNOWN {
            let (a, b) = (node.kind as usize, (node.kind as usize + 1) % 3);
            let (wa, wb) = (weights[a], weights[b]);
            // The middle of the edge replaces the end of it that is farther away.
            if wa >= wb {
                (weights[a], weights[b]) = (wa - wb, 2.0 * wb);
                node = self.nodes[node.index as usize];
            } else {
                (weights[a], weights[b]) = (2.0 * wa, wb - wa);
                node = self.nodes[node.index as usize + 1];
            }
        }
        node
    }

    /// Tells the membership of each member of a cell at a point, by index into `members`. `None` where a coincident face stands for this one.
    #[inline]
    pub(super) fn memberships(
        &self,
        scene: &Scene,
        asked: &AskedRecord,
        point: &SurfacePoint,
        mut tell: impl FnMut(usize, Membership),
    ) -> Option<()> {
        let geometry = &*scene.geometry;
        let subject = geometry.object_of(point.primitive);
        let covers = |primitive: PrimitiveId| {
            let tolerance = Tolerance::between(geometry, subject, geometry.object_of(primitive));
            Face::of(geometry, primitive).cover(&[point.position], tolerance) == Cover::All
        };
        if self.opaque[span(asked.first_opaque, asked.opaque_count)].iter().any(|&primitive| covers(primitive)) {
            return None;
        }
        for index in span(asked.first_member, asked.member_count) {
            let MemberRecord { refractor, first_coincident, coincident_count } = self.members[index];
            let coincident = &self.coincident[span(first_coincident, coincident_count)];
            let refractor = ObjectId(refractor);
            let membership = match coincident.iter().find(|coincident| covers(coincident.primitive)) {
                // Of twins, the first one stands for both.
                Some(twin) if twin.primitive < point.primitive => return None,
                Some(_) if scene.object(refractor).may_contain_itself() => {
                    membership_of_parts(scene, refractor, ObjectId(subject), point)?
                }
                Some(twin) => Membership::of_coincident(twin.is_same == 1),
                None if is_inside(scene, refractor, point) => Membership::In,
                None => Membership::Out,
            };
            tell(index, membership);
        }
        Some(())
    }

    /// Adds a cell with its members; gives its number. Its answers follow later: see [`Self::number_answers`].
    pub(super) fn push_asked(&mut self, cell: &AskedCell) -> u32 {
        self.asked.push(AskedRecord {
            first_answer: NOT_LISTED,
            first_member: self.members.len() as u32,
            member_count: cell.members.len() as u32,
            first_opaque: self.opaque.len() as u32,
            opaque_count: cell.opaque.len() as u32,
        });
        self.opaque.extend(&cell.opaque);
        for member in &cell.members {
            self.members.push(MemberRecord {
                refractor: member.refractor.0,
                first_coincident: self.coincident.len() as u32,
                coincident_count: member.coincident.len() as u32,
            });
            let record = |&(primitive, is_same)| CoincidentRecord { primitive, is_same: u32::from(is_same) };
            self.coincident.extend(member.coincident.iter().map(record));
        }
        self.asked.len() as u32 - 1
    }

    /// Numbers the answers of asked cells, which follow each other from `first` on. `counts`: how many each has; `None` if they are not listed.
    pub(super) fn number_answers(&mut self, first: usize, counts: impl Iterator<Item = Option<usize>>) {
        let mut next = first as u32;
        for (asked, count) in self.asked.iter_mut().zip(counts) {
            match count {
                Some(count) => {
                    asked.first_answer = next;
                    next += count as u32;
                }
                None => self.unlisted += 1,
            }
        }
    }
}

/// Where the descent begins: the root's offset, and the point's weights at its corners, up to a common factor.
#[inline]
fn begin(scene: &Scene, point: &SurfacePoint, barycentric: [f64; 2]) -> (u32, [f64; 3]) {
    match scene.geometry.sphere(point.primitive) {
        Some(_) => {
            let n = point.normal;
            let octant = u32::from(n.x < 0.0) | u32::from(n.y < 0.0) << 1 | u32::from(n.z < 0.0) << 2;
            (octant, n.abs().to_array())
        }
        None => (0, [1.0 - barycentric[0] - barycentric[1], barycentric[0], barycentric[1]]),
    }
}

fn span(first: u32, count: u32) -> std::ops::Range<usize> {
    first as usize..(first + count) as usize
}

#[cfg(test)]
mod tests;
