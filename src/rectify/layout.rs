//! How the surfaces of a scene fall into patches: what follows from geometry alone, and stays through every edit of media and priorities.
//! Each object is laid out by itself, so that an edit of the geometry redoes the objects it touches; then all are put into arrays.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;

use super::asked::AskedCell;
use super::cells::{Cell, Division};
use super::changes::Changes;
use super::coarseness::coarseness;
use super::contact::{self, Contact, EarlierContacts};
use super::copies::Copies;
use super::flat::{ASKED, BY_FACE, DIVIDED, FaceRecord, FlatLayout, KNOWN, NodeRecord};
use super::nest::Nest;
use super::progress::{Cancelled, Progress, RectifySeconds, Stage};
use super::site::{Faces, Site, SiteVotes};
use super::split::{Splitter, SubjectLayout, stood_for, whole_object};
use super::subjects::{primitives_of, subjects};
use super::surroundings::Surroundings;
use crate::geometry::{Geometry, PrimitiveId};
use crate::scene::{ObjectId, Scene};

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

/// The layout. Answers are numbered: sites first, then the surroundings of cells, then the answers of asked cells.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    subjects: Vec<(ObjectId, Arc<SubjectLayout>)>,
    /// What is looked up at a crossing.
    pub(super) flat: Arc<FlatLayout>,
    /// Sorted by subject, then by first face.
    pub sites: Vec<Site>,
    /// Of cells that have one answer, each once.
    pub(super) surroundings: Vec<Surroundings>,
    /// In the order of [`FlatLayout::asked`].
    pub(super) asked: Vec<Arc<AskedCell>>,
    pub groups: Vec<MixedGroup>,
    /// Refractors whose surfaces go through each other, the earlier first.
    pub(super) crossing: Vec<(ObjectId, ObjectId)>,
    copies: Copies,
    coarseness: f64,
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
    let copies = Copies::find(scene);
    let Unaffected { kept, partly, changes } =
        earlier.map(|earlier| unaffected(scene, earlier, &copies)).unwrap_or_default();
    let (of_copies, anew): (Vec<ObjectId>, Vec<ObjectId>) =
        subjects(scene).filter(|subject| !kept.contains_key(subject)).partition(|subject| copies.is_copy(*subject));
    let of_subject = partly.iter().map(|(subject, found)| (*subject, &found.touched.contacts)).collect();
    let mut contacts =
        contact::find(scene, &anew, &copies, &EarlierContacts { of_subject, changes: &changes }, progress)?;
    for (subject, found) in &partly {
        let still =
            found.crossed_by.iter().filter(|other| !earlier.is_some_and(|earlier| earlier.changed.contains(other)));
        contacts.crossing.extend(still.map(|other| (*subject, *other)));
    }
    contacts.crossing.sort_unstable();
    contacts.crossing.dedup();
    let coarseness = coarseness(scene, &contacts);
    let is_as_fine = earlier.is_some_and(|earlier| earlier.layout.coarseness == coarseness);
    seconds.patches = start.elapsed().as_secs_f64();
    progress.enter(Stage::Votes, anew.len())?;
    let is_untouched = |refractor| match kept.get(&refractor) {
        Some(found) => matches!(found.sites[..], [(Site { faces: Faces::Whole, .. }, _)]),
        None => contacts.of_range(primitives_of(&scene.geometry, refractor)).next().is_none(),
    };
    let nest = Nest::new(scene, |refractor| !copies.is_copied(refractor) && is_untouched(refractor));
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
            None => {
                let earlier = partly.get(&subject).filter(|_| is_as_fine).map(|found| (&found.touched, &changes));
                Splitter { scene, subject, contacts: &contacts, copies: &copies, coarseness, earlier, progress }
                    .split()?
            }
        };
        subjects.push((subject, Arc::new(found)));
    }
    subjects.sort_unstable_by_key(|(subject, _)| *subject);
    let (layout, votes) = assemble(scene, subjects);
    let layout = Layout { copies, coarseness, ..layout };
    seconds.patches = start.elapsed().as_secs_f64() - seconds.pretrace;
    Ok((layout, votes, seconds))
}

/// What an edit leaves as it was.
#[derive(Default)]
struct Unaffected {
    /// Objects that are far from all that has changed: their layouts stay.
    kept: HashMap<ObjectId, Arc<SubjectLayout>>,
    /// Others that have not changed themselves: of their layouts, what is known of faces that are far from the changes.
    partly: HashMap<ObjectId, Arc<SubjectLayout>>,
    changes: Changes,
}

fn unaffected(scene: &Scene, earlier: Earlier<'_>, copies: &Copies) -> Unaffected {
    /// With more changed objects than these, looking for faces that are far from all of them would not pay.
    const FEW: usize = 16;
    let (now, before) = (&*scene.geometry, &*earlier.scene.geometry);
    let objects = 0..scene.objects.len() as u32;
    let is_comparable = now.origin == before.origin
        && scene.objects.len() == earlier.scene.objects.len()
        && objects.clone().all(|object| now.range(object) == before.range(object));
    // Votes about a sheet depend on every opaque object, wherever it is.
    if !is_comparable || scene.has_sheets || earlier.scene.has_sheets {
        return Unaffected::default();
    }
    let changes = Changes::new(now, before, earlier.changed);
    let unchanged = || earlier.layout.subjects.iter().filter(|(subject, _)| !earlier.changed.contains(subject));
    let shared = |(subject, found): &(ObjectId, Arc<SubjectLayout>)| (*subject, Arc::clone(found));
    let kept = unchanged().filter(|(subject, _)| changes.are_far_from(now, *subject)).map(shared).collect();
    let kept = without_orphans(kept);
    let is_partly_known = earlier.changed.len() <= FEW && *copies == earlier.layout.copies;
    let partly =
        unchanged().filter(|(subject, _)| is_partly_known && !kept.contains_key(subject)).map(shared).collect();
    Unaffected { kept, partly, changes }
}

/// Those that do not inherit from a container that is not among them.
fn without_orphans(mut kept: HashMap<ObjectId, Arc<SubjectLayout>>) -> HashMap<ObjectId, Arc<SubjectLayout>> {
    // An object that inherits from a container is redone whenever the container is.
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

/// Puts the layouts of all objects into tables.
fn assemble(scene: &Scene, subjects: Vec<(ObjectId, Arc<SubjectLayout>)>) -> (Layout, Vec<SiteVotes>) {
    let geometry = &*scene.geometry;
    let mut layout = Layout::default();
    let mut flat = FlatLayout { address_of_object: vec![BY_FACE; scene.objects.len()], ..FlatLayout::default() };
    let mut votes = Vec::new();
    for (subject, found) in &subjects {
        for (site, site_votes) in &found.sites {
            let address = layout.sites.len() as u32;
            match &site.faces {
                Faces::Whole => flat.address_of_object[subject.0 as usize] = address,
                Faces::Some { faces, .. } => {
                    let addresses = addresses_of_primitives(&mut flat, geometry);
                    faces.iter().for_each(|&face| addresses[face as usize] = address);
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
        for (face, division) in found.touched.divided() {
            layout.store(&mut flat, geometry, *subject, face, division, &mut interner);
        }
    }
    layout.surroundings = interner.list;
    let counts = layout.asked.iter().map(|cell| cell.combinations());
    flat.number_answers(layout.sites.len() + layout.surroundings.len(), counts);
    layout.flat = Arc::new(flat);
    layout.subjects = subjects;
    (layout, votes)
}

/// Those of all primitives, which are made when the first is needed.
fn addresses_of_primitives<'a>(flat: &'a mut FlatLayout, geometry: &Geometry) -> &'a mut [u32] {
    if flat.address_of_primitive.is_empty() {
        flat.address_of_primitive = vec![BY_FACE; geometry.triangle_count() + geometry.sphere_count()];
    }
    &mut flat.address_of_primitive
}

impl Layout {
    /// What touches a face of a subject.
    pub fn contacts_of(&self, subject: ObjectId, face: PrimitiveId) -> &[Contact] {
        let found = self.subjects.binary_search_by_key(&subject, |(subject, _)| *subject).ok();
        found.and_then(|index| self.subjects[index].1.touched.contacts.of_face(face)).unwrap_or_default()
    }

    #[cfg(test)]
    pub(super) fn shared_subjects(&self, earlier: &Self) -> usize {
        let is_shared = |found: &Arc<SubjectLayout>| earlier.subjects.iter().any(|(_, e)| Arc::ptr_eq(e, found));
        self.subjects.iter().filter(|(_, found)| is_shared(found)).count()
    }

    /// Divided faces of objects that were laid out anew, whose divisions were kept all the same.
    #[cfg(test)]
    fn shared_divisions(&self, earlier: &Self) -> usize {
        let anew = self.subjects.iter().zip(&earlier.subjects).filter(|(now, before)| !Arc::ptr_eq(&now.1, &before.1));
        anew.map(|(now, before)| now.1.touched.shared_with(&before.1.touched)).sum()
    }

    /// Adds a divided face.
    fn store(
        &mut self,
        flat: &mut FlatLayout,
        geometry: &Geometry,
        subject: ObjectId,
        face: PrimitiveId,
        division: &Division,
        interner: &mut Interner,
    ) {
        let root = flat.nodes.len() as u32;
        let mut members: Vec<ObjectId> = Vec::new();
        for cell in division {
            let (kind, index) = match cell {
                Cell::Halves { edge, first } => (u32::from(*edge), first + root),
                Cell::Known(surroundings) => (KNOWN, interner.number(surroundings)),
                Cell::Asked(asked) => {
                    members.extend(asked.members.iter().map(|member| member.refractor));
                    self.asked.push(Arc::clone(asked));
                    (ASKED, flat.push_asked(asked))
                }
            };
            flat.nodes.push(NodeRecord { kind, index });
        }
        members.sort_unstable();
        members.dedup();
        let group = *interner.groups.entry((subject, members)).or_insert_with_key(|(_, members)| {
            self.groups.push(MixedGroup { subject, faces: 0, area: 0.0, members: members.clone() });
            self.groups.len() - 1
        });
        self.groups[group].faces += 1;
        self.groups[group].area += geometry.primitive_area(face);
        addresses_of_primitives(flat, geometry)[face as usize] = DIVIDED | flat.faces.len() as u32;
        flat.faces.push(FaceRecord { root, group: group as u32 });
    }
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

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::formats;
    use crate::rectify::InterfaceTable;
    use crate::scene::compile::{changed_objects, compile};

    /// Each refractor of each scene is moved in turn: what is taken over and what is found anew together say what a layout from nothing says.
    #[test]
    fn an_edit_redoes_what_it_touches_and_no_more() {
        let mut kept_divisions = 0;
        for name in ["iced-water", "half-submerged", "siblings"] {
            let mut description = formats::open(name).expect("a built-in scene");
            let mut scene = compile(&description, None).expect("it is fine");
            let mut table = InterfaceTable::new(&scene);
            let mut kept = 0;
            for index in 0..description.objects.refractors().len() {
                for step in [0.13, -0.4, 0.05, 0.003] {
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
                    kept += after.layout.shared_subjects(&table.layout);
                    kept_divisions += after.layout.shared_divisions(&table.layout);
                    (scene, table) = (moved, after);
                }
            }
            assert!(kept > 0, "{name}: nothing was taken over");
        }
        assert!(kept_divisions > 0, "no face of an object beside the moved one was taken over");
    }
}
