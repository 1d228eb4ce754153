//! One object's surface, split into sites and divided faces.
//!
//! Faces that no other surface touches are joined with their neighbours: between them nothing can change. Touched faces are
//! divided into cells, which settles them one by one; those that turn out to be the same all over join their neighbours again.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::cells::{self, Cell, Division};
use super::changes::Changes;
use super::contact::{Contact, Contacts};
use super::containment::containment_beside;
use super::copies::Copies;
use super::nest::Nest;
use super::pretrace;
use super::progress::{Cancelled, Progress};
use super::relation::Relation;
use super::site::{Faces, Site, SiteVotes};
use super::subjects::primitives_of;
use super::surroundings::{Membership, Surroundings};
use crate::geometry::{Enclosure, PrimitiveId, Sets, topology};
use crate::scene::{ObjectId, Scene};

/// The layout of one refractor or light. It follows from the geometry of that object and of those around it.
#[derive(Debug, Clone, PartialEq)]
pub struct SubjectLayout {
    /// In the order of their first faces, with the votes of the first pre-trace.
    pub sites: Vec<(Site, SiteVotes)>,
    pub touched: Touched,
    /// Refractors whose surfaces go through this one's.
    pub crossed_by: Vec<ObjectId>,
}

/// The faces of an object that other surfaces touch.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Touched {
    pub contacts: Contacts,
    /// In the order of the contacts' faces.
    fates: Vec<Fate>,
}

impl Touched {
    /// The faces that are divided.
    pub fn divided(&self) -> impl Iterator<Item = (PrimitiveId, &Division)> {
        (self.contacts.iter().zip(&self.fates)).filter_map(|((face, _), fate)| {
            if let Fate::Divided(division) = fate { Some((face, &**division)) } else { None }
        })
    }

    /// Divided faces whose divisions are those of an earlier state of the object.
    #[cfg(test)]
    pub(super) fn shared_with(&self, earlier: &Self) -> usize {
        let is_shared = |(face, division): &(PrimitiveId, &Division)| matches!(earlier.fate_of(*face), Some(Fate::Divided(before)) if std::ptr::eq(&**before, *division));
        self.divided().filter(is_shared).count()
    }

    fn fate_of(&self, face: PrimitiveId) -> Option<&Fate> {
        self.contacts.index_of(face).map(|index| &self.fates[index])
    }
}

/// The site of an object that need not be split.
pub fn whole_object(
    scene: &Scene,
    subject: ObjectId,
    contacts: &Contacts,
    copies: &Copies,
    nest: &Nest,
) -> Option<SubjectLayout> {
    let range = primitives_of(&scene.geometry, subject);
    if contacts.of_range(range).next().is_some() || scene.object(subject).has_several_components() {
        return None;
    }
    let mut fixed = Surroundings::new(subject);
    copies.complete(&mut fixed);
    let site = Site { subject, faces: Faces::Whole, fixed, settled: copies.of(subject).to_vec() };
    let votes = pretrace::vote(scene, &site, nest, SiteVotes::default());
    let is_one = !depends_on_place(scene, subject, &votes);
    is_one.then(|| SubjectLayout { sites: vec![(site, votes)], touched: Touched::default(), crossed_by: Vec::new() })
}

/// The layout of an object that an earlier one stands for all over.
pub fn stood_for(subject: ObjectId) -> SubjectLayout {
    let fixed = Surroundings { is_masked: true, ..Surroundings::new(subject) };
    let site = Site { subject, faces: Faces::Whole, fixed, settled: Vec::new() };
    SubjectLayout { sites: vec![(site, SiteVotes::default())], touched: Touched::default(), crossed_by: Vec::new() }
}

/// Whether votes about an open refractor disagree: its edge may run between the object's faces.
fn depends_on_place(scene: &Scene, subject: ObjectId, votes: &SiteVotes) -> bool {
    let is_mesh = scene.geometry.sphere_of(subject.0).is_none();
    let is_open = |object| matches!(scene.object(object).enclosure, Enclosure::Sheet | Enclosure::Holed);
    is_mesh && votes.list.iter().any(|vote| is_open(vote.refractor) && vote.share() < 1.0)
}

/// What is known about the surroundings of a face.
#[derive(Debug, Clone, PartialEq)]
enum Fate {
    /// No other surface touches it: the same as those of its untouched neighbours.
    Untouched,
    /// The same all over.
    Known(Arc<Known>),
    Divided(Arc<Division>),
}

/// The surroundings of a face that are the same all over.
#[derive(Debug, PartialEq, Eq)]
struct Known {
    surroundings: Surroundings,
    /// The refractors whose membership coincident faces settle.
    settled: Vec<ObjectId>,
}

impl Fate {
    fn known(surroundings: Surroundings, settled: Vec<ObjectId>) -> Self {
        Self::Known(Arc::new(Known { surroundings, settled }))
    }
}

/// What it takes to split one object's surface.
pub struct Splitter<'a> {
    pub scene: &'a Scene,
    pub subject: ObjectId,
    pub contacts: &'a Contacts,
    pub copies: &'a Copies,
    /// As in [`cells::divide`].
    pub coarseness: f64,
    /// Of the same object before an edit: faces that are far from what has changed are settled as they were.
    pub earlier: Option<(&'a Touched, &'a Changes)>,
    pub progress: &'a Progress,
}

impl Splitter<'_> {
    /// Splits an object into sites and divided faces.
    ///
    /// # Errors
    /// When `progress` is cancelled.
    pub fn split(&self) -> Result<SubjectLayout, Cancelled> {
        let range = primitives_of(&self.scene.geometry, self.subject);
        let mut fates = vec![Fate::Untouched; range.len()];
        let touched: Vec<(PrimitiveId, &[Contact])> = self.contacts.of_range(range.clone()).collect();
        let neighbours = self.neighbours(&range);
        let kept: Vec<Option<Fate>> = touched.par_iter().map(|(face, _)| self.earlier_fate(*face)).collect();
        let containers = self.containers(&range, &neighbours, &touched, &kept);
        let of_touched: Vec<Fate> = (touched.par_iter().zip(&containers).zip(kept))
            .map(|(((face, contacts), containers), kept)| {
                self.progress.go_on()?;
                let fate = kept.unwrap_or_else(|| self.divide(*face, contacts, containers));
                self.progress.advance(1);
                Ok(fate)
            })
            .collect::<Result<_, Cancelled>>()?;
        for ((face, _), fate) in touched.iter().zip(&of_touched) {
            fates[(face - range.start) as usize] = fate.clone();
        }
        let sites = self.classes(&range, &neighbours, &mut fates);
        let touched = Touched { contacts: self.contacts.part(range), fates: of_touched };
        let crossed_by = (self.contacts.crossing.iter())
            .filter(|(subject, _)| *subject == self.subject)
            .map(|(_, other)| *other)
            .collect();
        Ok(SubjectLayout { sites, touched, crossed_by })
    }

    /// How a face was settled before an edit, if that still holds.
    fn earlier_fate(&self, face: PrimitiveId) -> Option<Fate> {
        let (touched, changes) = self.earlier?;
        let is_kept = changes.are_far_from_face(&self.scene.geometry, self.subject, face);
        touched.fate_of(face).filter(|_| is_kept).cloned()
    }

    /// For each face of the object the faces across its edges, by offset in its range.
    fn neighbours(&self, range: &Range<PrimitiveId>) -> Cow<'_, [[u32; 3]]> {
        match &self.scene.object(self.subject).topology {
            Some(topology) => Cow::Borrowed(&topology.neighbours),
            None if self.scene.geometry.sphere_of(self.subject.0).is_some() => Cow::Owned(vec![[u32::MAX; 3]]),
            None => {
                let corners: Vec<_> = range.clone().map(|face| self.scene.geometry.corners(face)).collect();
                Cow::Owned(topology::neighbours(&corners))
            }
        }
    }

    /// For each touched face the refractors that contain it and do not touch it. Neighbours that the same objects touch have the same
    /// containers, so one of them is asked for all; where there are open refractors, every face is asked. Nobody is asked about faces that are `kept`.
    fn containers(
        &self,
        range: &Range<PrimitiveId>,
        neighbours: &[[u32; 3]],
        touched: &[(PrimitiveId, &[Contact])],
        kept: &[Option<Fate>],
    ) -> Vec<Vec<ObjectId>> {
        let touching: Vec<Vec<ObjectId>> = touched.par_iter().map(|(_, contacts)| self.touching(contacts)).collect();
        let mut sets = Sets::new(touched.len());
        if !self.scene.has_sheets && self.scene.holed.is_empty() {
            let number = |face: PrimitiveId| touched.binary_search_by_key(&face, |(face, _)| *face).ok();
            // A face that another one stands for has no other contacts listed.
            let is_complete = |at: usize| !matches!(touched[at].1, [contact] if matches!(contact.relation, Relation::Coincides { .. }));
            for (at, (face, _)) in touched.iter().enumerate().filter(|(at, _)| is_complete(*at)) {
                for &across in neighbours[(face - range.start) as usize].iter().filter(|across| **across != u32::MAX) {
                    if let Some(other) = number(range.start + across)
                        && is_complete(other)
                        && touching[at] == touching[other]
                    {
                        sets.join(at as u32, other as u32);
                    }
                }
            }
        }
        let roots: Vec<usize> = (0..touched.len()).map(|at| sets.find(at as u32) as usize).collect();
        let mut is_needed = vec![false; touched.len()];
        (roots.iter().zip(kept)).filter(|(_, kept)| kept.is_none()).for_each(|(root, _)| is_needed[*root] = true);
        let asked: Vec<Option<Vec<ObjectId>>> = (0..touched.len())
            .into_par_iter()
            .map(|at| is_needed[at].then(|| cells::containers(self.scene, touched[at].0, &touching[at])))
            .collect();
        roots.into_iter().map(|root| asked[root].clone().unwrap_or_default()).collect()
    }

    /// The objects that touch a face, in ascending order.
    fn touching(&self, contacts: &[Contact]) -> Vec<ObjectId> {
        let mut objects = cells::touching(self.scene, contacts);
        self.copies.complete_list(&mut objects);
        objects
    }

    fn divide(&self, face: PrimitiveId, contacts: &[Contact], containers: &[ObjectId]) -> Fate {
        let mut division = cells::divide(self.scene, face, contacts, containers, self.coarseness);
        for cell in &mut division {
            match cell {
                Cell::Halves { .. } => {}
                Cell::Known(surroundings) => self.copies.complete(surroundings),
                Cell::Asked(ask) => {
                    let ask = Arc::make_mut(ask);
                    self.copies.complete(&mut ask.base);
                    for member in &mut ask.members {
                        let copies = self.copies.of(member.refractor);
                        member.copies = (!copies.is_empty()).then(|| copies.into());
                    }
                }
            }
        }
        match &division[..] {
            [Cell::Known(surroundings)] => {
                let settled = (contacts.iter())
                    // A masked face is skipped, whatever masks it.
                    .filter(|_| !surroundings.is_masked)
                    .filter(|contact| matches!(contact.relation, Relation::Coincides { .. }))
                    .map(|contact| ObjectId(self.scene.geometry.object_of(contact.primitive)))
                    // A refractor that coincides only beside this face lies on both of its sides or on neither, and rays tell
                    // which. So may one of several parts, but rays that start on its parts cannot tell.
                    .filter(|object| {
                        let has_several_parts = self.scene.object(*object).may_contain_itself();
                        has_several_parts || surroundings.outer.contains(object) != surroundings.inner.contains(object)
                    });
                let mut settled: Vec<ObjectId> = settled.collect();
                if !surroundings.is_masked {
                    self.copies.complete_list(&mut settled);
                    settled.extend(self.copies.of(self.subject));
                    settled.sort_unstable();
                    settled.dedup();
                }
                Fate::known(surroundings.clone(), settled)
            }
            _ => Fate::Divided(Arc::new(division)),
        }
    }

    /// The sites of all faces that are not divided.
    fn classes(
        &self,
        range: &Range<PrimitiveId>,
        neighbours: &[[u32; 3]],
        fates: &mut [Fate],
    ) -> Vec<(Site, SiteVotes)> {
        let is_untouched: Vec<bool> = fates.iter().map(|fate| matches!(fate, Fate::Untouched)).collect();
        let mut sets = Sets::new(fates.len());
        let each_pair = |visit: &mut dyn FnMut(u32, u32)| {
            for (face, across) in neighbours.iter().enumerate() {
                let later = across.iter().filter(|&&other| other > face as u32 && other != u32::MAX);
                later.for_each(|&other| visit(face as u32, other));
            }
        };
        each_pair(&mut |a, b| {
            if is_untouched[a as usize] && is_untouched[b as usize] {
                sets.join(a, b);
            }
        });

        // The untouched pieces vote; where an open refractor makes their parts differ, each face is asked.
        let pieces = self.pieces(range, &mut sets, |face| is_untouched[face]);
        let voted: Vec<(Site, SiteVotes)> = (pieces.into_par_iter())
            .map(|site| {
                let votes = pretrace::vote(self.scene, &site, &Nest::default(), SiteVotes::default());
                (site, votes)
            })
            .collect();
        let mut votes_of_root: HashMap<u32, SiteVotes> = HashMap::new();
        for (site, votes) in voted {
            let Faces::Some { faces, .. } = &site.faces else { continue };
            if depends_on_place(self.scene, self.subject, &votes) {
                let asked: Vec<Fate> = faces.par_iter().map(|&face| self.ask_face(face)).collect();
                for (face, fate) in faces.iter().zip(asked) {
                    fates[(face - range.start) as usize] = fate;
                }
            } else {
                let known = Fate::known(votes.surroundings(&site), site.settled.clone());
                for &face in faces {
                    fates[(face - range.start) as usize] = known.clone();
                }
                votes_of_root.insert(faces[0] - range.start, votes);
            }
        }

        // Neighbours with equal surroundings are one site, whether rays voted about them or they were divided.
        let mut sets = Sets::new(fates.len());
        each_pair(&mut |a, b| {
            if let (Fate::Known(x), Fate::Known(y)) = (&fates[a as usize], &fates[b as usize])
                && x == y
            {
                sets.join(a, b);
            }
        });
        let sites = self.pieces(range, &mut sets, |face| matches!(fates[face], Fate::Known(..)));
        (sites.into_par_iter())
            .map(|mut site| {
                let Faces::Some { faces, .. } = &site.faces else { unreachable!("pieces list their faces") };
                let first = faces[0] - range.start;
                if let Fate::Known(known) = &fates[first as usize] {
                    let Known { surroundings, settled } = &**known;
                    site.fixed.is_masked = surroundings.is_masked;
                    for &refractor in settled {
                        let contains = |side: &[ObjectId]| side.contains(&refractor);
                        let membership =
                            Membership::of_sides(contains(&surroundings.outer), contains(&surroundings.inner));
                        site.fixed.add(refractor, membership);
                    }
                    site.settled = settled.clone();
                }
                let mut earlier = faces.iter().filter_map(|face| votes_of_root.get(&(face - range.start)));
                let votes = match (earlier.next(), earlier.next()) {
                    // The site is one untouched piece and perhaps a few faces more: its votes are kept.
                    (Some(votes), None) => votes.clone(),
                    _ => pretrace::vote(self.scene, &site, &Nest::default(), SiteVotes::default()),
                };
                (site, votes)
            })
            .collect()
    }

    /// One site for each set of faces that `is_wanted`, in the order of their first faces.
    fn pieces(&self, range: &Range<PrimitiveId>, sets: &mut Sets, is_wanted: impl Fn(usize) -> bool) -> Vec<Site> {
        let mut numbers: HashMap<u32, usize> = HashMap::new();
        let mut lists: Vec<Vec<PrimitiveId>> = Vec::new();
        for face in (0..range.len()).filter(|face| is_wanted(*face)) {
            let root = sets.find(face as u32);
            let number = *numbers.entry(root).or_insert_with(|| {
                lists.push(Vec::new());
                lists.len() - 1
            });
            lists[number].push(range.start + face as u32);
        }
        let geometry = &*self.scene.geometry;
        (lists.into_iter())
            .map(|faces| {
                let mut sum = 0.0;
                let areas = (faces.iter())
                    .map(|&face| {
                        sum += geometry.primitive_area(face);
                        sum
                    })
                    .collect();
                let mut fixed = Surroundings::new(self.subject);
                self.copies.complete(&mut fixed);
                let settled = self.copies.of(self.subject).to_vec();
                Site { subject: self.subject, faces: Faces::Some { faces, areas }, fixed, settled }
            })
            .collect()
    }

    /// Asks about one face by itself.
    fn ask_face(&self, face: PrimitiveId) -> Fate {
        let mut surroundings = Surroundings::new(self.subject);
        match self.scene.geometry.sample_primitive(face, [1.0 / 3.0, 1.0 / 3.0]) {
            Some(point) => {
                for refractor in containment_beside(self.scene, &point, true).refractors {
                    surroundings.add(refractor, Membership::In);
                }
            }
            None => surroundings.is_masked = true,
        }
        self.copies.complete(&mut surroundings);
        Fate::known(surroundings, self.copies.of(self.subject).to_vec())
    }
}
