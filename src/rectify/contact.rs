//! Where surfaces meet: which faces of refractors and lights other surfaces touch, and how.
//!
//! Every test is closed and errs towards a contact: a false contact costs a little time, a missed one the right answer. How near surfaces come to
//! be in contact: see [`super::tolerance`].

use std::collections::HashMap;
use std::ops::ControlFlow;

use rayon::prelude::*;

use super::changes::Changes;
use super::copies::Copies;
use super::face::{Cover, Face};
use super::progress::{Cancelled, Progress, Stage};
use super::relation::Relation;
use super::subjects::primitives_of;
use super::tolerance::{Margins, Tolerance, largest};
use crate::geometry::{PrimitiveId, SurfacePoint};
use crate::scene::{ObjectId, Scene};

/// A face is *crowded* if it meets more faces than this that are about as large or larger. Its contacts are not listed.
const CROWD: u32 = 128;
/// A face of at least this share of another's area is about as large.
const COMPARABLE: f64 = 0.25;

/// Another primitive that meets a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contact {
    pub primitive: PrimitiveId,
    pub relation: Relation,
}

/// The touched faces of all refractors and lights, in ascending order, with their contacts. A crowded face has none listed; a face that a
/// coincident one stands for has that one only.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Contacts {
    faces: Vec<PrimitiveId>,
    /// End of each face's contacts.
    ends: Vec<u32>,
    contacts: Vec<Contact>,
    /// Subjects and the refractors whose surfaces certainly go through theirs; each pair once.
    pub crossing: Vec<(ObjectId, ObjectId)>,
}

impl Contacts {
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// The touched faces, in ascending order, with their contacts.
    pub fn iter(&self) -> impl Iterator<Item = (PrimitiveId, &[Contact])> {
        self.of_range(0..PrimitiveId::MAX)
    }

    /// The contacts of one face: `None` where nothing touches it.
    pub fn of_face(&self, face: PrimitiveId) -> Option<&[Contact]> {
        self.index_of(face).map(|index| self.at(index))
    }

    /// Which of the touched faces `face` is; `None` where nothing touches it.
    pub fn index_of(&self, face: PrimitiveId) -> Option<usize> {
        self.faces.binary_search(&face).ok()
    }

    /// Those of the faces among `primitives`.
    pub fn part(&self, primitives: std::ops::Range<PrimitiveId>) -> Self {
        let mut part = Self::default();
        self.of_range(primitives).for_each(|(face, contacts)| part.push(face, contacts));
        part
    }

    fn at(&self, index: usize) -> &[Contact] {
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        &self.contacts[start as usize..self.ends[index] as usize]
    }

    fn push(&mut self, face: PrimitiveId, contacts: &[Contact]) {
        self.contacts.extend_from_slice(contacts);
        self.faces.push(face);
        self.ends.push(self.contacts.len() as u32);
    }

    /// The touched faces among `primitives`, with their contacts.
    pub fn of_range(
        &self,
        primitives: std::ops::Range<PrimitiveId>,
    ) -> impl Iterator<Item = (PrimitiveId, &[Contact])> {
        let first = self.faces.partition_point(|&face| face < primitives.start);
        let last = self.faces.partition_point(|&face| face < primitives.end);
        (first..last).map(|index| (self.faces[index], self.at(index)))
    }
}

/// Contacts that were found before an edit, by subject: they still hold on faces that are far from what has changed.
pub struct EarlierContacts<'a> {
    pub of_subject: HashMap<ObjectId, &'a Contacts>,
    pub changes: &'a Changes,
}

/// Finds all contacts of the objects `subjects` with objects that are no copies. O(N log N) for surfaces that meet along curves.
///
/// # Errors
/// When `progress` is cancelled.
pub fn find(
    scene: &Scene,
    subjects: &[ObjectId],
    copies: &Copies,
    earlier: &EarlierContacts<'_>,
    progress: &Progress,
) -> Result<Contacts, Cancelled> {
    /// Faces that one task looks at.
    const CHUNK: u32 = 2048;
    let geometry = &*scene.geometry;
    let mut tasks = Vec::new();
    for &subject in subjects {
        let range = primitives_of(geometry, subject);
        let task = |first| (subject, first..range.end.min(first + CHUNK));
        tasks.extend(range.clone().step_by(CHUNK as usize).map(task));
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
            let (is_refractor, margin) = (scene.is_refractor(subject), margins[&subject]);
            let seeker = Seeker { scene, subject, copies, is_refractor, margin };
            let faces = range.len();
            let known = earlier.of_subject.get(&subject);
            for face in range {
                progress.go_on()?;
                match known {
                    Some(known) if earlier.changes.are_far_from_face(geometry, subject, face) => {
                        known.of_face(face).into_iter().for_each(|known| contacts.push(face, known));
                    }
                    _ => seeker.look(face, &mut contacts),
                }
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

struct Seeker<'a> {
    scene: &'a Scene,
    subject: ObjectId,
    copies: &'a Copies,
    is_refractor: bool,
    /// How far around a face others are looked for.
    margin: f64,
}

/// An object near the subject, looked up once for all of its primitives.
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
            is_refractor: self.scene.is_refractor(object),
            tolerance: Tolerance::between(&self.scene.geometry, self.subject.0, object.0),
        }
    }

    /// Adds `face` and what touches it, if anything does.
    fn look(&self, face: PrimitiveId, to: &mut Contacts) {
        let geometry = &*self.scene.geometry;
        let (min, max) = Face::bounds_of(geometry, face);
        let (min, max) = (min - self.margin, max + self.margin);
        // Computed when the first other primitive is found: most faces have none near.
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
            // Opaque surfaces contain nothing, so they matter only where they coincide with a refractor.
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
                // The other face stands for all of this one: no other contact matters.
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

/// Whether a coincident face stands for the one at `point`: that of something opaque, or the first of the refractors'.
pub fn is_stood_for(scene: &Scene, point: &SurfacePoint) -> bool {
    let geometry = &*scene.geometry;
    let own = ObjectId(geometry.object_of(point.primitive));
    let this = Face::of(geometry, point.primitive);
    let except = (!scene.object(own).may_contain_itself()).then_some(own.0);
    // Four times the own tolerance: the other object may have a larger one.
    let margin = 4.0 * largest(geometry, own.0);
    let (min, max) = (point.position - margin, point.position + margin);
    let search = geometry.search_near_box(min, max, except, |primitive| {
        let object = ObjectId(geometry.object_of(primitive));
        let goes_first = primitive < point.primitive || !scene.is_refractor(object);
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
