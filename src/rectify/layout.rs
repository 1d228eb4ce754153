//! How the surfaces of a scene fall into patches: what follows from geometry alone, and stays through every edit of media and priorities.
//!
//! Faces that no other surface touches are joined with their neighbours: between them nothing can change. Touched faces are
//! divided into cells, which settles them one by one; those that turn out to be the same all over join their neighbours again.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::adjacency::{Sets, neighbours};
use super::cells::{self, Ask, Division, Node};
use super::contact::{self, Contacts, primitives_of};
use super::containment::containment_beside;
use super::copies::Copies;
use super::nest::Nest;
use super::pretrace::{self, SiteVotes};
use super::progress::{Cancelled, Progress, Stage};
use super::surroundings::{State, Surroundings};
use super::table::RectifySeconds;
use super::tolerance;
use crate::geometry::{Enclosure, Geometry, PrimitiveId, SurfacePoint};
use crate::scene::{ObjectId, Scene};

/// Where the answer for a piece of surface stands: an index of an answer, or with the highest bit one of a divided face.
pub(super) type Place = u32;

/// The highest bit of a [`Place`]: the face is divided.
pub(super) const DIVIDED: Place = 1 << 31;
/// Instead of an object's place: its faces have places of their own.
pub(super) const BY_FACE: Place = u32::MAX;

/// The faces of a site.
#[derive(Debug, Clone, PartialEq)]
pub enum Faces {
    /// All of the object's.
    Whole,
    /// Some triangles, in ascending order, with the running sums of their areas.
    Some { faces: Vec<PrimitiveId>, areas: Vec<f64> },
}

/// A connected piece of an object's surface with the same surroundings all over: a patch.
#[derive(Debug, Clone, PartialEq)]
pub struct Site {
    pub subject: ObjectId,
    pub faces: Faces,
    /// The surroundings as far as they do not need votes: refractors that coincide with the site, and whether it is masked.
    pub fixed: Surroundings,
    /// The refractors that `fixed` says all about.
    pub settled: Vec<ObjectId>,
}

impl Site {
    pub fn face_count(&self, geometry: &Geometry) -> u32 {
        match &self.faces {
            Faces::Whole => geometry.face_count(self.subject.0),
            Faces::Some { faces, .. } => faces.len() as u32,
        }
    }

    /// In scene units squared.
    pub fn area(&self, geometry: &Geometry) -> f64 {
        match &self.faces {
            Faces::Whole => geometry.area(self.subject.0),
            Faces::Some { areas, .. } => areas.last().copied().unwrap_or(0.0),
        }
    }

    /// A point of the site, uniform by area, for `u` uniform in [0, 1)³. `None` when it has no area.
    pub fn sample(&self, geometry: &Geometry, u: [f64; 3]) -> Option<SurfacePoint> {
        match &self.faces {
            Faces::Whole => geometry.sample_surface(self.subject.0, u),
            Faces::Some { faces, areas } => {
                let at = areas.partition_point(|&sum| sum <= u[0] * areas[areas.len() - 1]).min(areas.len() - 1);
                geometry.sample_primitive(faces[at], [u[1], u[2]])
            }
        }
    }
}

/// The divided faces of one object that the same refractors cross or lie on.
#[derive(Debug, Clone, PartialEq)]
pub struct MixedGroup {
    pub subject: ObjectId,
    pub faces: u32,
    /// In scene units squared.
    pub area: f64,
    /// The refractors that differ from place to place, in ascending order.
    pub members: Vec<ObjectId>,
}

/// A face that is divided into cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Divided {
    /// Node of its (first) root.
    pub root: u32,
    /// Index into [`Layout::groups`].
    pub group: u32,
}

/// What has been found out about one refractor or light. It follows from the geometry of that object and of those around it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SubjectLayout {
    /// In the order of their first faces, with the votes of the first pre-trace.
    sites: Vec<(Site, SiteVotes)>,
    divided: Vec<(PrimitiveId, Division)>,
    /// Refractors whose surfaces go through this one's.
    crossed_by: Vec<ObjectId>,
}

/// The layout. Answers are numbered: sites first, then the surroundings of cells.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    subjects: Vec<(ObjectId, Arc<SubjectLayout>)>,
    pub(super) place_of_object: Vec<Place>,
    /// Of every primitive; empty where no object needs it.
    pub(super) place_of_primitive: Vec<Place>,
    /// Sorted by subject, then by first face.
    pub sites: Vec<Site>,
    pub(super) surroundings: Vec<Surroundings>,
    pub(super) nodes: Vec<Node<u32, u32>>,
    pub(super) asks: Vec<Ask>,
    pub(super) divided: Vec<Divided>,
    pub groups: Vec<MixedGroup>,
    /// Refractors whose surfaces go through each other, the earlier first.
    pub(super) crossing: Vec<(ObjectId, ObjectId)>,
}

/// An earlier scene, to take over what an edit cannot have changed.
#[derive(Clone, Copy)]
pub struct Earlier<'a> {
    pub scene: &'a Scene,
    pub layout: &'a Layout,
    /// The objects whose shapes or transforms are not the same any more.
    pub changed: &'a [ObjectId],
}

/// Lays out `scene`; also gives the votes of each site, and the time that this took.
///
/// # Errors
/// When `progress` is cancelled.
pub fn lay_out(
    scene: &Scene,
    earlier: Option<Earlier<'_>>,
    progress: &Progress,
) -> Result<(Layout, Vec<SiteVotes>, RectifySeconds), Cancelled> {
    let start = Instant::now();
    let mut seconds = RectifySeconds::default();
    let kept = earlier.map(|earlier| unaffected(scene, earlier)).unwrap_or_default();
    let copies = Copies::find(scene);
    let (of_copies, anew): (Vec<ObjectId>, Vec<ObjectId>) = contact::subjects(scene)
        .filter(|subject| !kept.contains_key(subject))
        .partition(|subject| copies.is_copy(*subject));
    let contacts = contact::find(scene, &anew, &copies, progress)?;
    let coarseness = coarseness(scene, &contacts);
    seconds.patches = start.elapsed().as_secs_f64();
    progress.enter(Stage::Votes, anew.len())?;
    let nest = Nest::new(scene, |refractor| match kept.get(&refractor) {
        Some(found) => {
            matches!(found.sites[..], [(Site { faces: Faces::Whole, .. }, _)]) && !copies.is_copied(refractor)
        }
        None => {
            contacts.of_range(primitives_of(&scene.geometry, refractor)).next().is_none()
                && !copies.is_copied(refractor)
        }
    });
    let whole: Vec<Option<SubjectLayout>> = (anew.par_iter())
        .map(|&subject| {
            progress.go_on()?;
            let whole = whole_object(scene, subject, &contacts, &copies, &nest);
            progress.advance(1);
            Ok(whole)
        })
        .collect::<Result<_, Cancelled>>()?;
    seconds.pretrace = start.elapsed().as_secs_f64() - seconds.patches;
    progress.enter(Stage::Cells, contacts.face_count())?;
    let mut subjects: Vec<(ObjectId, Arc<SubjectLayout>)> = kept.into_iter().collect();
    subjects.extend(of_copies.into_iter().map(|copy| (copy, Arc::new(stood_for(copy)))));
    for (subject, whole) in anew.into_iter().zip(whole) {
        let found = match whole {
            Some(whole) => whole,
            None => Splitter { scene, subject, contacts: &contacts, copies: &copies, coarseness, progress }.split()?,
        };
        subjects.push((subject, Arc::new(found)));
    }
    subjects.sort_unstable_by_key(|(subject, _)| *subject);
    let (layout, votes) = assemble(scene, subjects);
    seconds.patches = start.elapsed().as_secs_f64() - seconds.pretrace;
    Ok((layout, votes, seconds))
}

/// How coarse cells may be, as in [`cells::divide`]: time and memory for cells are spent on some thousands of meetings with large faces, and
/// not on more; and never on more cells than a computer has room for.
fn coarseness(scene: &Scene, contacts: &Contacts) -> f64 {
    /// Meetings for which cells are as fine as can be.
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
    // Of each face: how many refractors it is divided for, and how many cells lie side by side along it when they are as fine as can be.
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

/// Cells and the refractors that they name, all together, at the most: each costs a question when it is made, and a hundred bytes.
const MOST_ENTRIES: f64 = 5e5;

/// About how many entries there will be: cells lie along the curves where others meet a face, until they fill it.
fn predicted_entries(faces: &[(f64, f64)], coarseness: f64) -> f64 {
    let of_face = |&(refractors, side): &(f64, f64)| {
        let side = (side / coarseness).max(1.0);
        (4.0 + refractors) * (2.0 * refractors * side).min(2.0 * side * side).max(1.0)
    };
    faces.iter().map(of_face).sum()
}

/// What has been found out about objects that the edit cannot have affected: those that are far from everything that has changed, before and after.
fn unaffected(scene: &Scene, earlier: Earlier<'_>) -> HashMap<ObjectId, Arc<SubjectLayout>> {
    let (now, before) = (&*scene.geometry, &*earlier.scene.geometry);
    let objects = 0..scene.objects.len() as u32;
    let is_comparable = now.origin == before.origin
        && scene.objects.len() == earlier.scene.objects.len()
        && objects.clone().all(|object| now.range(object) == before.range(object));
    // Where a sheet's rays end at something opaque, everything depends on everything.
    if !is_comparable || scene.has_sheets || earlier.scene.has_sheets {
        return HashMap::new();
    }
    let grown = |geometry: &Geometry, object: ObjectId| {
        let ((min, max), margin) = (geometry.bounds_of(object.0), tolerance::largest(geometry, object.0));
        (min - margin, max + margin)
    };
    let boxes: Vec<(DVec3, DVec3)> =
        earlier.changed.iter().flat_map(|&changed| [grown(now, changed), grown(before, changed)]).collect();
    let is_far = |subject: ObjectId| {
        let (min, max) = grown(now, subject);
        !boxes.iter().any(|(other_min, other_max)| min.cmple(*other_max).all() && other_min.cmple(max).all())
    };
    let mut kept: HashMap<ObjectId, Arc<SubjectLayout>> = (earlier.layout.subjects.iter())
        .filter(|(subject, _)| !earlier.changed.contains(subject) && is_far(*subject))
        .map(|(subject, found)| (*subject, Arc::clone(found)))
        .collect();
    // What inherits its containers is found anew with the one that it has them from.
    loop {
        let is_orphan = |found: &SubjectLayout| {
            let within = found.sites.iter().find_map(|(_, votes)| votes.within);
            within.is_some_and(|container| !kept.contains_key(&container))
        };
        let orphans: Vec<ObjectId> =
            kept.iter().filter(|(_, found)| is_orphan(found)).map(|(subject, _)| *subject).collect();
        if orphans.is_empty() {
            return kept;
        }
        orphans.iter().for_each(|orphan| _ = kept.remove(orphan));
    }
}

/// Puts what has been found out about all objects into tables.
fn assemble(scene: &Scene, subjects: Vec<(ObjectId, Arc<SubjectLayout>)>) -> (Layout, Vec<SiteVotes>) {
    let geometry = &*scene.geometry;
    let mut layout = Layout { place_of_object: vec![BY_FACE; scene.objects.len()], ..Layout::default() };
    let mut votes = Vec::new();
    for (subject, found) in &subjects {
        for (site, site_votes) in &found.sites {
            let place = layout.sites.len() as Place;
            match &site.faces {
                Faces::Whole => layout.place_of_object[subject.0 as usize] = place,
                Faces::Some { faces, .. } => {
                    let places = layout.places_of_primitives(geometry);
                    faces.iter().for_each(|&face| places[face as usize] = place);
                }
            }
            layout.sites.push(site.clone());
            votes.push(site_votes.clone());
        }
        layout.crossing.extend(found.crossed_by.iter().map(|other| (*subject.min(other), *subject.max(other))));
    }
    layout.crossing.sort_unstable();
    layout.crossing.dedup();
    let mut interner = Interner { first: layout.sites.len() as u32, ..Interner::default() };
    for (subject, found) in &subjects {
        for (face, division) in &found.divided {
            layout.store(geometry, *subject, *face, division, &mut interner);
        }
    }
    layout.surroundings = interner.list;
    layout.subjects = subjects;
    (layout, votes)
}

impl Layout {
    fn places_of_primitives(&mut self, geometry: &Geometry) -> &mut [Place] {
        if self.place_of_primitive.is_empty() {
            self.place_of_primitive = vec![BY_FACE; geometry.triangle_count() + geometry.sphere_count()];
        }
        &mut self.place_of_primitive
    }

    #[cfg(test)]
    pub(super) fn shared_subjects(&self, earlier: &Self) -> usize {
        let is_shared = |found: &Arc<SubjectLayout>| earlier.subjects.iter().any(|(_, e)| Arc::ptr_eq(e, found));
        self.subjects.iter().filter(|(_, found)| is_shared(found)).count()
    }

    /// Adds a divided face.
    fn store(
        &mut self,
        geometry: &Geometry,
        subject: ObjectId,
        face: PrimitiveId,
        division: &Division,
        interner: &mut Interner,
    ) {
        let root = self.nodes.len() as u32;
        let mut members: Vec<ObjectId> = Vec::new();
        for node in division {
            self.nodes.push(match node {
                Node::Halves { edge, first } => Node::Halves { edge: *edge, first: first + root },
                Node::Known(surroundings) => Node::Known(interner.number(surroundings)),
                Node::Asked(ask) => {
                    members.extend(ask.members.iter().map(|member| member.refractor));
                    self.asks.push(ask.clone());
                    Node::Asked(self.asks.len() as u32 - 1)
                }
            });
        }
        members.sort_unstable();
        members.dedup();
        let group = *interner.groups.entry((subject, members)).or_insert_with_key(|(_, members)| {
            self.groups.push(MixedGroup { subject, faces: 0, area: 0.0, members: members.clone() });
            self.groups.len() - 1
        });
        self.groups[group].faces += 1;
        self.groups[group].area += geometry.primitive_area(face);
        self.places_of_primitives(geometry)[face as usize] = DIVIDED | self.divided.len() as Place;
        self.divided.push(Divided { root, group: group as u32 });
    }
}

/// The site of an object that need not be split.
fn whole_object(
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
    is_one.then(|| SubjectLayout { sites: vec![(site, votes)], divided: Vec::new(), crossed_by: Vec::new() })
}

/// The layout of an object that an earlier one stands for all over.
fn stood_for(subject: ObjectId) -> SubjectLayout {
    let fixed = Surroundings { is_masked: true, ..Surroundings::new(subject) };
    let site = Site { subject, faces: Faces::Whole, fixed, settled: Vec::new() };
    SubjectLayout { sites: vec![(site, SiteVotes::default())], divided: Vec::new(), crossed_by: Vec::new() }
}

/// Whether the votes about an open refractor differ, which its edge may be the reason of.
fn depends_on_place(scene: &Scene, subject: ObjectId, votes: &SiteVotes) -> bool {
    let is_mesh = scene.geometry.sphere_of(subject.0).is_none();
    let is_open = |object| matches!(scene.object(object).enclosure, Enclosure::Sheet | Enclosure::Holed);
    is_mesh && votes.list.iter().any(|vote| is_open(vote.refractor) && vote.share() < 1.0)
}

/// Numbers equal surroundings once, from `first` on, and equal groups.
#[derive(Default)]
struct Interner {
    groups: HashMap<(ObjectId, Vec<ObjectId>), usize>,
    first: u32,
    list: Vec<Surroundings>,
    numbers: HashMap<Surroundings, u32>,
}

impl Interner {
    fn number(&mut self, surroundings: &Surroundings) -> u32 {
        if let Some(number) = self.numbers.get(surroundings) {
            return *number;
        }
        let number = self.first + self.list.len() as u32;
        self.list.push(surroundings.clone());
        self.numbers.insert(surroundings.clone(), number);
        number
    }
}

/// What has been found out about a face.
#[derive(Clone)]
enum Fate {
    /// As its neighbours.
    Untouched,
    /// The same all over; with the refractors that coincidence settles.
    Known(Surroundings, Vec<ObjectId>),
    Divided(Division),
}

struct Splitter<'a> {
    scene: &'a Scene,
    subject: ObjectId,
    contacts: &'a Contacts,
    copies: &'a Copies,
    /// As in [`cells::divide`].
    coarseness: f64,
    progress: &'a Progress,
}

impl Splitter<'_> {
    /// Splits an object into sites and divided faces.
    fn split(&self) -> Result<SubjectLayout, Cancelled> {
        let range = primitives_of(&self.scene.geometry, self.subject);
        let mut fates = vec![Fate::Untouched; range.len()];
        let touched: Vec<(PrimitiveId, &[contact::Contact])> = self.contacts.of_range(range.clone()).collect();
        let neighbours = self.neighbours(&range);
        let containers = self.containers(&range, &neighbours, &touched);
        let divisions: Vec<Fate> = (touched.par_iter().zip(&containers))
            .map(|((face, contacts), containers)| {
                self.progress.go_on()?;
                let fate = self.divide(*face, contacts, containers);
                self.progress.advance(1);
                Ok(fate)
            })
            .collect::<Result<_, Cancelled>>()?;
        for ((face, _), fate) in touched.iter().zip(divisions) {
            fates[(face - range.start) as usize] = fate;
        }
        let sites = self.classes(&range, &neighbours, &mut fates);
        let divided = (range.zip(fates))
            .filter_map(|(face, fate)| if let Fate::Divided(division) = fate { Some((face, division)) } else { None })
            .collect();
        let crossed_by = (self.contacts.crossing.iter())
            .filter(|(subject, _)| *subject == self.subject)
            .map(|(_, other)| *other)
            .collect();
        Ok(SubjectLayout { sites, divided, crossed_by })
    }

    /// For each face of the object the faces across its edges, by offset in its range.
    fn neighbours(&self, range: &Range<PrimitiveId>) -> Cow<'_, [[u32; 3]]> {
        match &self.scene.object(self.subject).topology {
            Some(topology) => Cow::Borrowed(&topology.neighbours),
            None if self.scene.geometry.sphere_of(self.subject.0).is_some() => Cow::Owned(vec![[u32::MAX; 3]]),
            None => Cow::Owned(neighbours(&self.scene.geometry, range)),
        }
    }

    /// For each touched face the refractors that contain it and do not touch it. Neighbours that the same objects touch have the same ones, and
    /// only one of them is asked, unless open refractors make every face a case of its own.
    fn containers(
        &self,
        range: &Range<PrimitiveId>,
        neighbours: &[[u32; 3]],
        touched: &[(PrimitiveId, &[contact::Contact])],
    ) -> Vec<Vec<ObjectId>> {
        let touching: Vec<Vec<ObjectId>> = touched.par_iter().map(|(_, contacts)| self.touching(contacts)).collect();
        let mut sets = Sets::new(touched.len());
        if !self.scene.has_sheets && self.scene.holed.is_empty() {
            let number = |face: PrimitiveId| touched.binary_search_by_key(&face, |(face, _)| *face).ok();
            // Where one face stands for all of another, that face's other contacts are not listed.
            let is_complete = |at: usize| !matches!(touched[at].1, [contact] if matches!(contact.relation, contact::Relation::Coincides { .. }));
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
        let asked: Vec<Option<Vec<ObjectId>>> = (0..touched.len())
            .into_par_iter()
            .map(|at| (roots[at] == at).then(|| cells::containers(self.scene, touched[at].0, &touching[at])))
            .collect();
        roots.into_iter().map(|root| asked[root].clone().unwrap_or_default()).collect()
    }

    /// The objects that touch a face, in ascending order.
    fn touching(&self, contacts: &[contact::Contact]) -> Vec<ObjectId> {
        let mut objects = cells::touching(self.scene, contacts);
        self.copies.complete_list(&mut objects);
        objects
    }

    fn divide(&self, face: PrimitiveId, contacts: &[contact::Contact], containers: &[ObjectId]) -> Fate {
        let mut division = cells::divide(self.scene, face, contacts, containers, self.coarseness);
        for node in &mut division {
            match node {
                Node::Halves { .. } => {}
                Node::Known(surroundings) => self.copies.complete(surroundings),
                Node::Asked(ask) => {
                    self.copies.complete(&mut ask.base);
                    for member in &mut ask.members {
                        let copies = self.copies.of(member.refractor);
                        member.copies = (!copies.is_empty()).then(|| copies.into());
                    }
                }
            }
        }
        match &division[..] {
            [Node::Known(surroundings)] => {
                let settled = (contacts.iter())
                    // Of what stands for all of a face it does not matter whose it is.
                    .filter(|_| !surroundings.is_masked)
                    .filter(|contact| matches!(contact.relation, contact::Relation::Coincides { .. }))
                    .map(|contact| ObjectId(self.scene.geometry.object_of(contact.primitive)))
                    // Those that coincide next to it and do not reach it lie on both sides or on neither. So may parts of one object on either side
                    // of it, which rays that start on it cannot tell.
                    .filter(|object| {
                        let has_several_parts = self.scene.object(*object).may_contain_itself();
                        has_several_parts || surroundings.outer.contains(object) != surroundings.inner.contains(object)
                    });
                let mut settled: Vec<ObjectId> = settled.collect();
                settled.sort_unstable();
                settled.dedup();
                if !surroundings.is_masked {
                    self.copies.complete_list(&mut settled);
                    settled.extend(self.copies.of(self.subject));
                    settled.sort_unstable();
                    settled.dedup();
                }
                Fate::Known(surroundings.clone(), settled)
            }
            _ => Fate::Divided(division),
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
                across
                    .iter()
                    .filter(|&&other| other > face as u32 && other != u32::MAX)
                    .for_each(|&other| visit(face as u32, other));
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
                let known = votes.surroundings(&site);
                for &face in faces {
                    fates[(face - range.start) as usize] = Fate::Known(known.clone(), site.settled.clone());
                }
                votes_of_root.insert(faces[0] - range.start, votes);
            }
        }

        // Neighbours of the same surroundings are one site, whichever way each was found.
        let mut sets = Sets::new(fates.len());
        each_pair(&mut |a, b| {
            if let (Fate::Known(x, x_settled), Fate::Known(y, y_settled)) = (&fates[a as usize], &fates[b as usize])
                && x == y
                && x_settled == y_settled
            {
                sets.join(a, b);
            }
        });
        let sites = self.pieces(range, &mut sets, |face| matches!(fates[face], Fate::Known(..)));
        (sites.into_par_iter())
            .map(|mut site| {
                let Faces::Some { faces, .. } = &site.faces else { unreachable!("pieces list their faces") };
                let first = faces[0] - range.start;
                if let Fate::Known(surroundings, settled) = &fates[first as usize] {
                    site.fixed.is_masked = surroundings.is_masked;
                    for &refractor in settled {
                        let contains = |side: &[ObjectId]| side.contains(&refractor);
                        let state = State::of_sides(contains(&surroundings.outer), contains(&surroundings.inner));
                        site.fixed.add(refractor, state);
                    }
                    site.settled = settled.clone();
                }
                let mut earlier = faces.iter().filter_map(|face| votes_of_root.get(&(face - range.start)));
                let votes = match (earlier.next(), earlier.next()) {
                    // The votes of the piece that it consists of, but for a few faces.
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
                    surroundings.add(refractor, State::In);
                }
            }
            None => surroundings.is_masked = true,
        }
        self.copies.complete(&mut surroundings);
        Fate::Known(surroundings, self.copies.of(self.subject).to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats;
    use crate::rectify::InterfaceTable;
    use crate::scene::compile::{changed_objects, compile};

    /// Each refractor of each scene is moved in turn: what is taken over and what is found anew together say what a layout from nothing says.
    #[test]
    fn an_edit_redoes_what_it_touches_and_no_more() {
        for name in ["iced-water", "half-submerged", "siblings"] {
            let mut description = formats::open(name).expect("a built-in scene");
            let mut scene = compile(&description, None).expect("it is fine");
            let mut table = InterfaceTable::new(&scene);
            let mut kept = 0;
            for index in 0..description.objects.refractors().len() {
                for step in [0.13, -0.4, 0.05] {
                    let before = description.clone();
                    let transform = &mut description.objects.refractors_mut()[index].transform;
                    transform.translate += DVec3::new(0.4 * step, step, 0.0);
                    transform.rotate.y += 100.0 * step;
                    let moved = compile(&description, Some((&before, &scene))).expect("it is fine");
                    let changed = changed_objects(&before, &description).expect("the objects are the same");
                    assert_eq!(changed, [ObjectId(index as u32)]);
                    let after = table.updated(&moved, &scene, &changed);
                    let fresh = InterfaceTable::new(&moved);
                    assert!(after.says_the_same(&fresh), "{name}, refractor {index} by {step}");
                    let known = |table: &InterfaceTable| {
                        let patches = table.patches.iter();
                        patches.map(|p| (p.refractor, p.kind, p.faces, p.outside, p.inside)).collect::<Vec<_>>()
                    };
                    assert_eq!(known(&after), known(&fresh), "{name}, refractor {index} by {step}");
                    kept += after.shared_subjects(&table);
                    (scene, table) = (moved, after);
                }
            }
            assert!(kept > 0, "{name}: nothing was taken over");
        }
    }
}
