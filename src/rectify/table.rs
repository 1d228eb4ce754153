//! The interface table: for every point of a refractor's surface the media on its two sides. What follows from geometry is shared between tables;
//! an edit of media or priorities resolves the answers anew.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use super::asked;
use super::contact::Contact;
use super::containers::Containers;
use super::encounters::{self, Encounter};
use super::flat::{ASKED, BY_FACE, DIVIDED, FlatTable, Lookup};
use super::layout::{Earlier, Layout, lay_out};
use super::nest;
use super::object_table::ObjectTable;
use super::patch::{self, Patch};
use super::placed;
use super::pretrace;
use super::progress::{Cancelled, Progress, RectifySeconds};
use super::site::{Faces, SiteVotes};
use super::subjects::primitives_of;
use super::surroundings::Answer;
use crate::geometry::{Geometry, Mask, PrimitiveId, SurfacePoint};
use crate::scene::{ObjectId, Scene};

/// No one else holds the progress that is made here.
const NOT_CANCELLED: &str = "nobody can cancel it";

/// The answer of rectification, looked up at every crossing.
#[derive(Debug, Clone, Default)]
pub struct InterfaceTable {
    pub(super) layout: Arc<Layout>,
    pub(super) votes: Arc<Vec<SiteVotes>>,
    flat: FlatTable,
    /// Sorted by refractor; within one, patches proper first, then mixed ones.
    pub patches: Vec<Patch>,
    /// The same for lights, whose inner side is not asked; behind those with a surface one without faces for each light that has none: what it stands
    /// in is outside of it.
    pub lights: Vec<Patch>,
    /// How many of `lights` are of lights with a surface.
    with_surface: usize,
    /// Where the patches of sites and of groups of divided faces stand in `patches` or `lights`.
    patch_of_site: Vec<u32>,
    patch_of_group: Vec<u32>,
    /// Primitives that are no interface anywhere: with the same medium on both sides, or stood for by a coincident one.
    mask: Mask,
    /// Whether some place of a divided face is no interface.
    has_passable: bool,
    object_table: Arc<OnceLock<ObjectTable>>,
    containers: Arc<OnceLock<Containers>>,
    pub seconds: RectifySeconds,
}

impl InterfaceTable {
    /// Rectifies `scene` from nothing.
    pub fn new(scene: &Scene) -> Self {
        Self::lay_out(scene, None, &Progress::new()).expect(NOT_CANCELLED)
    }

    /// [`Self::new`], watched.
    ///
    /// # Errors
    /// When `progress` is cancelled.
    pub fn new_watched(scene: &Scene, progress: &Progress) -> Result<Self, Cancelled> {
        Self::lay_out(scene, None, progress)
    }

    /// Rectifies `scene`, of which `before` and this table are an earlier state: what the edit cannot have changed is taken over. Where the
    /// geometry is the same, media and priorities are resolved anew and nothing else; otherwise `changed` are the objects whose shape
    /// or place is another, and those far from them keep what was found.
    pub fn updated(&self, scene: &Scene, before: &Scene, changed: &[ObjectId]) -> Self {
        self.updated_watched(scene, before, changed, &Progress::new()).expect(NOT_CANCELLED)
    }

    /// [`Self::updated`], watched.
    ///
    /// # Errors
    /// When `progress` is cancelled.
    pub fn updated_watched(
        &self,
        scene: &Scene,
        before: &Scene,
        changed: &[ObjectId],
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        if Arc::ptr_eq(&scene.geometry, &before.geometry) {
            let (layout, votes) = (Arc::clone(&self.layout), Arc::clone(&self.votes));
            let seconds = RectifySeconds::default();
            return Ok(Self::resolve(scene, layout, votes, Arc::clone(&self.object_table), seconds));
        }
        Self::lay_out(scene, Some(Earlier { scene: before, layout: &self.layout, changed }), progress)
    }

    fn lay_out(scene: &Scene, earlier: Option<Earlier<'_>>, progress: &Progress) -> Result<Self, Cancelled> {
        // As one task of the thread pool: outside it, each of many small parallel steps would have to be handed over and waited for.
        let (layout, votes, mut seconds) = rayon::scope(|_| lay_out(scene, earlier, progress))?;
        seconds.topology = scene.topology_secs;
        Ok(Self::resolve(scene, Arc::new(layout), Arc::new(votes), Arc::default(), seconds))
    }

    /// The same with another pre-trace, of fresh directions, whose votes are added.
    pub fn repeated(&self, scene: &Scene) -> Self {
        self.repeated_watched(scene, &Progress::new()).expect(NOT_CANCELLED)
    }

    /// [`Self::repeated`], watched.
    ///
    /// # Errors
    /// When `progress` is cancelled.
    pub fn repeated_watched(&self, scene: &Scene, progress: &Progress) -> Result<Self, Cancelled> {
        let start = Instant::now();
        let votes = pretrace::repeat(scene, &self.layout.sites, &self.votes, progress)?;
        let seconds = RectifySeconds { pretrace: start.elapsed().as_secs_f64(), ..self.seconds };
        Ok(Self::resolve(scene, Arc::clone(&self.layout), Arc::new(votes), Arc::clone(&self.object_table), seconds))
    }

    /// Whether two tables say the same everywhere.
    pub fn says_the_same(&self, other: &Self) -> bool {
        self.flat.answers == other.flat.answers
    }

    fn resolve(
        scene: &Scene,
        layout: Arc<Layout>,
        votes: Arc<Vec<SiteVotes>>,
        object_table: Arc<OnceLock<ObjectTable>>,
        seconds: RectifySeconds,
    ) -> Self {
        let start = Instant::now();
        let fillers = nest::fillers(scene, &layout.sites, &votes);
        let mut answers: Vec<Answer> = (layout.sites.iter().zip(&fillers))
            .map(|(site, fillers)| Answer::of(scene, site.fixed.is_masked, *fillers))
            .collect();
        answers.extend(layout.surroundings.iter().map(|surroundings| surroundings.resolve(scene)));
        answers.extend(layout.asked.iter().filter_map(|cell| cell.answers(scene)).flatten());
        let is_passable = |answer: &Answer| answer.is_masked() || answer.outside == answer.inside;
        let may_be_masked = layout.asked.iter().any(|cell| cell.may_be_masked());
        let has_passable = may_be_masked || answers[layout.sites.len()..].iter().any(is_passable);
        let mut mask = Mask::default();
        for (site, answer) in layout.sites.iter().zip(&answers) {
            // The inner side of a light has no answer.
            if !is_passable(answer) || !scene.is_refractor(site.subject) {
                continue;
            }
            match &site.faces {
                Faces::Whole => primitives_of(&scene.geometry, site.subject).for_each(|face| mask.insert(face)),
                Faces::Some { faces, .. } => faces.iter().for_each(|&face| mask.insert(face)),
            }
        }
        let mut patches = patch::list(scene, &layout, &votes, &fillers);
        let with_surface = patches.lights.len();
        patches.lights.extend(placed::list(scene));
        let resolve = start.elapsed().as_secs_f64();
        Self {
            flat: FlatTable { layout: Arc::clone(&layout.flat), answers },
            patches: patches.refractors,
            lights: patches.lights,
            with_surface,
            patch_of_site: patches.of_site,
            patch_of_group: patches.of_group,
            mask,
            has_passable,
            object_table,
            containers: Arc::default(),
            seconds: RectifySeconds { resolve, ..seconds },
            layout,
            votes,
        }
    }

    /// The answer at a point of a refractor's surface; [`Answer::MASKED`] where the crossing is to be passed over.
    #[inline]
    pub fn look(&self, scene: &Scene, refractor: ObjectId, point: &SurfacePoint, barycentric: [f64; 2]) -> Answer {
        match self.flat.look(scene, refractor, point, barycentric) {
            Lookup::Answer(answer) => answer,
            Lookup::Unlisted(cell) => self.answer_unlisted(scene, cell, point),
        }
    }

    /// The answer at a point of a cell whose answers are too many to be listed.
    #[cold]
    fn answer_unlisted(&self, scene: &Scene, number: u32, point: &SurfacePoint) -> Answer {
        let cell = &self.layout.asked[number as usize];
        if cell.is_crowded {
            return asked::answer_anew(scene, point);
        }
        let mut memberships = Vec::with_capacity(cell.members.len());
        let flat = &*self.layout.flat;
        match flat.memberships(scene, &flat.asked[number as usize], point, |_, membership| memberships.push(membership))
        {
            Some(()) => cell.resolve(scene, memberships),
            None => Answer::MASKED,
        }
    }

    /// The arrays that [`Self::look`] reads, as a GPU is given them.
    pub fn flat(&self) -> &FlatTable {
        &self.flat
    }

    /// The media on both sides of a refractor's face: in the middle of a triangle, or at one point of a sphere. `None` where there is no
    /// interface, because a coincident face stands for this one, and for a triangle without area.
    pub fn sides_of(&self, scene: &Scene, primitive: PrimitiveId) -> Option<Answer> {
        const MIDDLE: [f64; 2] = [1.0 / 3.0; 2];
        let point = scene.geometry.sample_primitive(primitive, MIDDLE)?;
        let refractor = ObjectId(scene.geometry.object_of(primitive));
        let answer = self.look(scene, refractor, &point, MIDDLE);
        (!answer.is_masked()).then_some(answer)
    }

    /// Whether the surroundings of that face differ from place to place.
    #[inline]
    pub fn is_mixed(&self, refractor: ObjectId, primitive: PrimitiveId) -> bool {
        self.flat.layout.address(refractor, primitive) & DIVIDED != 0
    }

    /// Primitives that are no interface anywhere, if there are any.
    pub fn mask(&self) -> Option<&Mask> {
        (!self.mask.is_empty()).then_some(&self.mask)
    }

    /// Whether some place of a face that is not in [`Self::mask`] is no interface.
    pub fn has_passable(&self) -> bool {
        self.has_passable
    }

    /// The patch that a primitive of a refractor or light belongs to.
    pub fn patch_of(&self, geometry: &Geometry, primitive: PrimitiveId) -> Option<&Patch> {
        let object = geometry.object_of(primitive);
        let flat = &*self.flat.layout;
        let address = match *flat.address_of_object.get(object as usize)? {
            BY_FACE => *flat.address_of_primitive.get(primitive as usize)?,
            address => address,
        };
        let number = match address {
            BY_FACE => return None,
            _ if address & DIVIDED == 0 => self.patch_of_site[address as usize],
            _ => self.patch_of_group[flat.faces[(address & !DIVIDED) as usize].group as usize],
        };
        // Lights are numbered after the refractors' patches.
        match (number as usize).checked_sub(self.patches.len()) {
            None => self.patches.get(number as usize),
            Some(light) => self.lights.get(light),
        }
    }

    /// What a light without a surface stands in.
    pub fn place_of(&self, light: ObjectId) -> Option<&Patch> {
        let placed = &self.lights[self.with_surface..];
        placed.binary_search_by_key(&light, |patch| patch.refractor).ok().map(|index| &placed[index])
    }

    pub fn patches_of(&self, refractor: ObjectId) -> &[Patch] {
        let first = self.patches.partition_point(|patch| patch.refractor < refractor);
        let last = self.patches.partition_point(|patch| patch.refractor <= refractor);
        &self.patches[first..last]
    }

    /// The largest patch of a refractor that has an answer: where it is to be found, for most of it.
    pub fn main_patch(&self, refractor: ObjectId) -> Option<&Patch> {
        let has_answer = |patch: &&Patch| patch.outside.is_some();
        self.patches_of(refractor).iter().filter(has_answer).max_by(|a, b| a.area.total_cmp(&b.area))
    }

    /// The source's method, one exterior for each object. Worked out when it is first asked for.
    pub fn object_table(&self, scene: &Scene) -> &ObjectTable {
        self.object_table.get_or_init(|| ObjectTable::new(scene))
    }

    /// What each refractor's surface lies in. Worked out when it is first asked for.
    pub fn containers(&self, scene: &Scene) -> &Containers {
        self.containers.get_or_init(|| Containers::new(scene, self))
    }

    /// [`Self::containers`], if somebody has asked for them before.
    pub fn known_containers(&self) -> Option<&Containers> {
        self.containers.get()
    }

    /// The primitives that touch a face of a refractor, and how; none are listed of a crowded face.
    pub fn contacts_of(&self, refractor: ObjectId, face: PrimitiveId) -> &[Contact] {
        self.layout.contacts_of(refractor, face)
    }

    /// The refractors that meet each other, and how.
    pub fn encounters(&self, scene: &Scene) -> Vec<Encounter> {
        encounters::encounters(scene, &self.layout, &self.votes)
    }

    /// The objects some of whose faces are crowded, with the numbers of those faces: see [`asked::AskedCell::is_crowded`].
    pub fn crowded(&self) -> Vec<(ObjectId, u32)> {
        let (layout, flat) = (&*self.layout, &*self.flat.layout);
        let mut found: Vec<(ObjectId, u32)> = Vec::new();
        for face in &flat.faces {
            let root = flat.nodes[face.root as usize];
            if root.kind == ASKED && layout.asked[root.index as usize].is_crowded {
                let subject = layout.groups[face.group as usize].subject;
                match found.last_mut() {
                    Some((last, faces)) if *last == subject => *faces += 1,
                    _ => found.push((subject, 1)),
                }
            }
        }
        found
    }

    /// Rays shot so far.
    pub fn rays(&self) -> u64 {
        self.votes.iter().map(|votes| u64::from(votes.rays)).sum()
    }
}
