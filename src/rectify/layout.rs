//! How the surfaces of a scene fall into patches: what follows from geometry alone, and stays through every edit of media and priorities.
//!
//! Faces that no other surface touches are joined with their neighbours: between them nothing can change. Touched faces are
//! divided into cells, which settles them one by one; those that turn out to be the same all over join their neighbours again.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::time::Instant;

use rayon::prelude::*;

use super::adjacency::{Sets, neighbours};
use super::cells::{self, Ask, Division, Node};
use super::contact::{self, Contacts, primitives_of};
use super::containment::containment_beside;
use super::pretrace::{self, SiteVotes};
use super::surroundings::{State, Surroundings};
use super::table::RectifySeconds;
use crate::geometry::{Enclosure, Geometry, PrimitiveId, SurfacePoint};
use crate::scene::World;
use crate::scene::world::ObjectId;

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

/// The layout. Answers are numbered: sites first, then the surroundings of cells.
#[derive(Debug, Clone, Default)]
pub struct Layout {
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
    /// Refractors whose surfaces go through each other.
    pub(super) crossing: Vec<(ObjectId, ObjectId)>,
}

/// Lays out `world`; also gives the votes of each site, and the time that this took.
pub fn lay_out(world: &World) -> (Layout, Vec<SiteVotes>, RectifySeconds) {
    let start = Instant::now();
    let mut seconds = RectifySeconds::default();
    let contacts = contact::find(world);
    seconds.patches = start.elapsed().as_secs_f64();
    let mut layout = Layout { place_of_object: vec![BY_FACE; world.objects.len()], ..Layout::default() };
    let mut votes = Vec::new();
    let mut interner = Interner::default();
    let subjects: Vec<ObjectId> = contact::subjects(world).collect();
    let whole: Vec<Option<(Site, SiteVotes)>> =
        subjects.par_iter().map(|&subject| whole_object(world, subject, &contacts)).collect();
    seconds.pretrace = start.elapsed().as_secs_f64() - seconds.patches;
    for (subject, whole) in subjects.into_iter().zip(whole) {
        match whole {
            Some((site, site_votes)) => {
                layout.place_of_object[subject.0 as usize] = layout.sites.len() as u32;
                layout.sites.push(site);
                votes.push(site_votes);
            }
            None => Splitter { world, subject, contacts: &contacts }.split(&mut layout, &mut votes, &mut interner),
        }
    }
    layout.crossing.clone_from(&contacts.crossing);
    layout.surroundings = interner.list;
    // Cells' surroundings are numbered after the sites.
    let sites = layout.sites.len() as u32;
    for node in &mut layout.nodes {
        if let Node::Known(index) = node {
            *index += sites;
        }
    }
    seconds.patches = start.elapsed().as_secs_f64() - seconds.pretrace;
    (layout, votes, seconds)
}

/// The site of an object that need not be split, with its votes.
fn whole_object(world: &World, subject: ObjectId, contacts: &Contacts) -> Option<(Site, SiteVotes)> {
    let range = primitives_of(&world.geometry, subject);
    if contacts.of_range(range).next().is_some() || world.object(subject).has_several_components() {
        return None;
    }
    let fixed = Surroundings::new(subject);
    let site = Site { subject, faces: Faces::Whole, fixed, settled: Vec::new() };
    let votes = pretrace::vote(world, &site, SiteVotes::default());
    (!depends_on_place(world, subject, &votes)).then_some((site, votes))
}

/// Whether the votes about an open refractor differ, which its edge may be the reason of.
fn depends_on_place(world: &World, subject: ObjectId, votes: &SiteVotes) -> bool {
    let is_mesh = world.geometry.sphere_of(subject.0).is_none();
    let is_open = |object| matches!(world.object(object).enclosure, Enclosure::Sheet | Enclosure::Holed);
    is_mesh && votes.list.iter().any(|vote| is_open(vote.refractor) && vote.share() < 1.0)
}

/// Numbers equal surroundings once.
#[derive(Default)]
struct Interner {
    list: Vec<Surroundings>,
    numbers: HashMap<Surroundings, u32>,
}

impl Interner {
    fn number(&mut self, surroundings: Surroundings) -> u32 {
        *self.numbers.entry(surroundings).or_insert_with_key(|key| {
            self.list.push(key.clone());
            self.list.len() as u32 - 1
        })
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
    world: &'a World,
    subject: ObjectId,
    contacts: &'a Contacts,
}

impl Splitter<'_> {
    /// Splits an object into sites and divided faces.
    fn split(&self, layout: &mut Layout, votes: &mut Vec<SiteVotes>, interner: &mut Interner) {
        let geometry = &*self.world.geometry;
        if layout.place_of_primitive.is_empty() {
            layout.place_of_primitive = vec![BY_FACE; geometry.triangle_count() + geometry.sphere_count()];
        }
        let range = primitives_of(geometry, self.subject);
        let mut fates = vec![Fate::Untouched; range.len()];
        let touched: Vec<(PrimitiveId, &[contact::Contact])> = self.contacts.of_range(range.clone()).collect();
        let divisions: Vec<Fate> = touched.par_iter().map(|(face, contacts)| self.divide(*face, contacts)).collect();
        for ((face, _), fate) in touched.iter().zip(divisions) {
            fates[(face - range.start) as usize] = fate;
        }
        for (class, site_votes) in self.classes(&range, &mut fates) {
            let place = layout.sites.len() as u32;
            let Faces::Some { faces, .. } = &class.faces else { continue };
            faces.iter().for_each(|&face| layout.place_of_primitive[face as usize] = place);
            layout.sites.push(class);
            votes.push(site_votes);
        }
        for (face, fate) in range.zip(fates) {
            if let Fate::Divided(division) = fate {
                self.store(face, division, layout, interner);
            }
        }
    }

    fn divide(&self, face: PrimitiveId, contacts: &[contact::Contact]) -> Fate {
        let division = cells::divide(self.world, face, contacts);
        match &division[..] {
            [Node::Known(surroundings)] => {
                let settled = (contacts.iter())
                    .filter(|contact| matches!(contact.relation, contact::Relation::Coincides { .. }))
                    .map(|contact| ObjectId(self.world.geometry.object_of(contact.primitive)))
                    // Those that coincide next to it and do not reach it lie on both sides or on neither.
                    .filter(|object| surroundings.outer.contains(object) != surroundings.inner.contains(object));
                let mut settled: Vec<ObjectId> = settled.collect();
                settled.sort_unstable();
                settled.dedup();
                Fate::Known(surroundings.clone(), settled)
            }
            _ => Fate::Divided(division),
        }
    }

    /// The sites of all faces that are not divided.
    fn classes(&self, range: &Range<PrimitiveId>, fates: &mut [Fate]) -> Vec<(Site, SiteVotes)> {
        let geometry = &*self.world.geometry;
        let neighbours: Cow<'_, [[u32; 3]]> = match &self.world.object(self.subject).topology {
            Some(topology) => Cow::Borrowed(&topology.neighbours),
            None if geometry.sphere_of(self.subject.0).is_some() => Cow::Owned(vec![[u32::MAX; 3]]),
            None => Cow::Owned(neighbours(geometry, range)),
        };
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
                let votes = pretrace::vote(self.world, &site, SiteVotes::default());
                (site, votes)
            })
            .collect();
        let mut votes_of_root: HashMap<u32, SiteVotes> = HashMap::new();
        for (site, votes) in voted {
            let Faces::Some { faces, .. } = &site.faces else { continue };
            if depends_on_place(self.world, self.subject, &votes) {
                let asked: Vec<Fate> = faces.par_iter().map(|&face| self.ask_face(face)).collect();
                for (face, fate) in faces.iter().zip(asked) {
                    fates[(face - range.start) as usize] = fate;
                }
            } else {
                let known = votes.surroundings(&site);
                for &face in faces {
                    fates[(face - range.start) as usize] = Fate::Known(known.clone(), Vec::new());
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
                        let same = surroundings.inner.contains(&refractor);
                        site.fixed.add(refractor, State::of_coincident(same));
                    }
                    site.settled = settled.clone();
                }
                let mut earlier = faces.iter().filter_map(|face| votes_of_root.get(&(face - range.start)));
                let votes = match (earlier.next(), earlier.next()) {
                    // The votes of the piece that it consists of, but for a few faces.
                    (Some(votes), None) => votes.clone(),
                    _ => pretrace::vote(self.world, &site, SiteVotes::default()),
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
        let geometry = &*self.world.geometry;
        (lists.into_iter())
            .map(|faces| {
                let mut sum = 0.0;
                let areas = (faces.iter())
                    .map(|&face| {
                        sum += geometry.primitive_area(face);
                        sum
                    })
                    .collect();
                let fixed = Surroundings::new(self.subject);
                Site { subject: self.subject, faces: Faces::Some { faces, areas }, fixed, settled: Vec::new() }
            })
            .collect()
    }

    /// Asks about one face by itself.
    fn ask_face(&self, face: PrimitiveId) -> Fate {
        let mut surroundings = Surroundings::new(self.subject);
        match self.world.geometry.sample_primitive(face, [1.0 / 3.0, 1.0 / 3.0]) {
            Some(point) => {
                for refractor in containment_beside(self.world, &point, true).refractors {
                    surroundings.add(refractor, State::In);
                }
            }
            None => surroundings.is_masked = true,
        }
        Fate::Known(surroundings, Vec::new())
    }

    /// Puts a divided face into the layout.
    fn store(&self, face: PrimitiveId, division: Division, layout: &mut Layout, interner: &mut Interner) {
        let geometry = &*self.world.geometry;
        let root = layout.nodes.len() as u32;
        let mut members: Vec<ObjectId> = Vec::new();
        for node in division {
            layout.nodes.push(match node {
                Node::Halves { edge, first } => Node::Halves { edge, first: first + root },
                Node::Known(surroundings) => Node::Known(interner.number(surroundings)),
                Node::Asked(ask) => {
                    members.extend(ask.members.iter().map(|member| member.refractor));
                    layout.asks.push(ask);
                    Node::Asked(layout.asks.len() as u32 - 1)
                }
            });
        }
        members.sort_unstable();
        members.dedup();
        let area = geometry.primitive_area(face);
        let known = layout.groups.iter().rposition(|g| g.subject == self.subject && g.members == members);
        let group = known.unwrap_or_else(|| {
            layout.groups.push(MixedGroup { subject: self.subject, faces: 0, area: 0.0, members });
            layout.groups.len() - 1
        });
        layout.groups[group].faces += 1;
        layout.groups[group].area += area;
        layout.place_of_primitive[face as usize] = DIVIDED | layout.divided.len() as u32;
        layout.divided.push(Divided { root, group: group as u32 });
    }
}
