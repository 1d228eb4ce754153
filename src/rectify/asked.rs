//! Cells of divided faces in which the answer differs from point to point, and every answer that they can give.

use std::sync::Arc;

use super::contact::is_stood_for;
use super::containment::containment_beside;
use super::surroundings::{Answer, Membership, Surroundings};
use crate::geometry::{PrimitiveId, SurfacePoint};
use crate::scene::{ObjectId, Scene};

/// Answers of one cell that are worked out beforehand, at the most.
const MOST_LISTED: usize = 256;

/// A refractor whose membership differs from point to point of a cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AskedMember {
    pub refractor: ObjectId,
    /// Its copies, if there are any, of which the same holds.
    pub copies: Option<Arc<[ObjectId]>>,
    /// Its primitives that coincide with the face hereabouts, and whether they look the same way.
    pub coincident: Vec<(PrimitiveId, bool)>,
}

/// A cell in which each point is asked about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AskedCell {
    /// What holds all over the cell.
    pub base: Surroundings,
    pub members: Vec<AskedMember>,
    /// Opaque primitives that coincide with the face hereabouts: where they cover it, they stand for it.
    pub opaque: Vec<PrimitiveId>,
    /// Whether so many surfaces meet the face that none is listed, and everything is asked about at each hit.
    pub is_crowded: bool,
}

impl AskedCell {
    /// A cell of a face that too many others meet.
    pub fn crowded(subject: ObjectId) -> Self {
        Self { base: Surroundings::new(subject), members: Vec::new(), opaque: Vec::new(), is_crowded: true }
    }

    /// Number of combinations of the members' memberships, each with an answer; `None` where those are too many to be listed, and an
    /// answer is worked out when it is wanted.
    pub fn combinations(&self) -> Option<usize> {
        if self.is_crowded {
            return None;
        }
        (self.members.iter())
            .try_fold(1, |product: usize, member| product.checked_mul(member.radix()))
            .filter(|product| *product <= MOST_LISTED)
    }

    /// Every possible answer, in the order of [`super::flat`]; `None` where there are too many.
    pub fn answers<'a>(&'a self, scene: &'a Scene) -> Option<impl Iterator<Item = Answer> + 'a> {
        let combinations = self.combinations()?;
        Some((0..combinations).map(move |index| {
            let mut rest = index;
            let mut next = |radix: usize| {
                let digit = rest % radix;
                rest /= radix;
                Membership::ALL[digit]
            };
            self.resolve(scene, self.members.iter().map(|member| next(member.radix())))
        }))
    }

    /// The answer for given memberships, one for each member.
    pub fn resolve(&self, scene: &Scene, memberships: impl IntoIterator<Item = Membership>) -> Answer {
        let mut surroundings = self.base.clone();
        for (member, membership) in self.members.iter().zip(memberships) {
            let copies = member.copies.iter().flat_map(|copies| &**copies);
            copies.chain([&member.refractor]).for_each(|&refractor| surroundings.add(refractor, membership));
        }
        surroundings.resolve(scene)
    }

    /// Whether other faces stand for this one at some points, or may.
    pub fn may_be_masked(&self) -> bool {
        let has_coincident = !self.opaque.is_empty() || self.members.iter().any(|member| !member.coincident.is_empty());
        // Among very many surfaces some coincide.
        has_coincident || self.combinations().is_none()
    }
}

impl AskedMember {
    /// How many memberships there are: without coincident faces a refractor lies on both sides or on neither.
    fn radix(&self) -> usize {
        if self.coincident.is_empty() { 2 } else { 4 }
    }
}

/// The answer at a point of a crowded face, of which nothing is known beforehand.
pub fn answer_anew(scene: &Scene, point: &SurfacePoint) -> Answer {
    if is_stood_for(scene, point) {
        return Answer::MASKED;
    }
    let mut surroundings = Surroundings::new(ObjectId(scene.geometry.object_of(point.primitive)));
    for refractor in containment_beside(scene, point, true).refractors {
        surroundings.add(refractor, Membership::OuterOnly);
    }
    for refractor in containment_beside(scene, point, false).refractors {
        surroundings.add(refractor, Membership::InnerOnly);
    }
    surroundings.resolve(scene)
}
