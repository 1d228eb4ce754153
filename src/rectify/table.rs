//! What rectification stores: for every place on a refractor's surface, the media on its two sides.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use super::cells::{self, Node};
use super::containment::Vote;
use super::encounters::{self, Encounter};
use super::layout::{BY_FACE, DIVIDED, Earlier, Faces, Layout, Place, Site, lay_out};
use super::nest::{self, Fillers};
use super::object::ObjectTable;
use super::pretrace::{self, SiteVotes};
use super::progress::{Cancelled, Progress};
use super::surroundings::Answer;
use crate::geometry::{Geometry, Mask, PrimitiveId, SurfacePoint};
use crate::rectify::contact::{is_refractor, primitives_of};
use crate::scene::{MediumId, ObjectId, Scene};

/// Instead of a block of answers: there would be too many, and each is worked out when it is wanted.
const NOT_LISTED: u32 = u32::MAX;

/// Why work that nobody else can see the progress of has a result.
const NOT_CANCELLED: &str = "nobody can cancel it";

/// What kind of interface a patch is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PatchKind {
    /// One medium outside, another inside.
    Clear,
    /// The same medium on both sides, by identity and not by value: nothing is to be seen there.
    Null,
    /// Other surfaces cross it: the answer differs from place to place.
    Mixed,
    /// It coincides with another surface, which stands for both.
    Masked,
}

impl PatchKind {
    pub const ALL: [Self; 4] = [Self::Clear, Self::Null, Self::Mixed, Self::Masked];

    /// The word used in JSON, tables and legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Null => "null",
            Self::Mixed => "mixed",
            Self::Masked => "masked",
        }
    }
}

/// A part of a refractor's surface with the same surroundings everywhere, or the faces of it that the same refractors cross.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// The refractor; in [`InterfaceTable::lights`] the light.
    pub refractor: ObjectId,
    /// Index among the refractor's patches.
    pub index: u32,
    pub kind: PatchKind,
    /// Number of primitives.
    pub faces: u32,
    /// Scene units squared.
    pub area: f64,
    /// `None` where it differs from place to place, or is not asked: mixed and masked patches.
    pub outside: Option<MediumId>,
    pub inside: Option<MediumId>,
    /// The refractor that fills the outer side; `None` is the global medium, or a mixed or masked patch.
    pub outside_refractor: Option<ObjectId>,
    /// The refractor that fills the inner side: itself, unless another has precedence there.
    pub inside_refractor: Option<ObjectId>,
    /// The refractors that cross a mixed patch.
    pub crossed_by: Vec<ObjectId>,
    /// Rays shot so far, over all pre-traces of this geometry.
    pub rays: u32,
    /// Least share of the votes, in [0.5, 1], among those members whose containment could change the answer.
    pub confidence: f64,
    /// Votes about every refractor that some ray found to contain the patch.
    pub votes: Arc<Vec<Vote>>,
    /// The innermost container, where that was enough to know: what contains it contains the patch too, and has no votes here.
    pub within: Option<ObjectId>,
}

/// Time spent on each part, in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct RectifySeconds {
    /// Analysis of the meshes.
    pub topology: f64,
    /// Contacts, cells, patches.
    pub patches: f64,
    /// Rays and their votes.
    pub pretrace: f64,
    /// From votes to media.
    pub resolve: f64,
}

impl RectifySeconds {
    pub fn total(&self) -> f64 {
        self.topology + self.patches + self.pretrace + self.resolve
    }
}

/// The answer of rectification, looked up at every crossing.
#[derive(Debug, Clone, Default)]
pub struct InterfaceTable {
    layout: Arc<Layout>,
    votes: Arc<Vec<SiteVotes>>,
    /// Of sites, then of the surroundings of cells, then of cells that are asked: those in blocks, one answer for each combination.
    answers: Vec<Answer>,
    /// The block of each cell that is asked, by its first answer, or [`NOT_LISTED`].
    blocks: Vec<u32>,
    /// Sorted by refractor; within one, patches proper first, then mixed ones.
    pub patches: Vec<Patch>,
    /// The same for lights, whose inner side is not asked.
    pub lights: Vec<Patch>,
    /// Where the patches of sites and of groups of divided faces stand in `patches` or `lights`.
    patch_of_site: Vec<u32>,
    patch_of_group: Vec<u32>,
    /// Primitives that are no interface anywhere: with the same medium on both sides, or stood for by a coincident one.
    mask: Mask,
    /// Whether some place of a divided face is no interface.
    has_passable: bool,
    per_object: Arc<OnceLock<ObjectTable>>,
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
            return Ok(Self::resolve(scene, layout, votes, Arc::clone(&self.per_object), seconds));
        }
        Self::lay_out(scene, Some(Earlier { scene: before, layout: &self.layout, changed }), progress)
    }

    fn lay_out(scene: &Scene, earlier: Option<Earlier<'_>>, progress: &Progress) -> Result<Self, Cancelled> {
        // In one go on the pool's threads: each of many small parallel steps would be handed over and waited for.
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
        let votes = pretrace::repeat(scene, &self.layout, &self.votes, progress)?;
        let seconds = RectifySeconds { pretrace: start.elapsed().as_secs_f64(), ..self.seconds };
        Ok(Self::resolve(scene, Arc::clone(&self.layout), Arc::new(votes), Arc::clone(&self.per_object), seconds))
    }

    /// Whether two tables say the same everywhere.
    pub fn says_the_same(&self, other: &Self) -> bool {
        self.answers == other.answers
    }

    #[cfg(test)]
    pub(super) fn parts(&self) -> (&Layout, &[SiteVotes]) {
        (&self.layout, &self.votes)
    }

    /// How many objects of an earlier table's were taken over.
    #[cfg(test)]
    pub(super) fn shared_subjects(&self, earlier: &Self) -> usize {
        self.layout.shared_subjects(&earlier.layout)
    }

    fn resolve(
        scene: &Scene,
        layout: Arc<Layout>,
        votes: Arc<Vec<SiteVotes>>,
        per_object: Arc<OnceLock<ObjectTable>>,
        seconds: RectifySeconds,
    ) -> Self {
        let start = Instant::now();
        let fillers = nest::fillers(scene, &layout, &votes);
        let mut answers: Vec<Answer> = (layout.sites.iter().zip(&fillers))
            .map(|(site, fillers)| Answer::of(scene, site.fixed.is_masked, *fillers))
            .collect();
        answers.extend(layout.surroundings.iter().map(|surroundings| surroundings.resolve(scene)));
        let mut has_coincident = false;
        let mut blocks = Vec::with_capacity(layout.asks.len());
        for ask in &layout.asks {
            match ask.answers(scene) {
                Some(listed) => {
                    blocks.push(answers.len() as u32);
                    answers.extend(listed);
                }
                None => {
                    blocks.push(NOT_LISTED);
                    // Of so many some are sure to be.
                    has_coincident = true;
                }
            }
            has_coincident |= !ask.opaque.is_empty() || ask.members.iter().any(|member| !member.coincident.is_empty());
        }
        let is_passable = |answer: &Answer| answer.is_masked() || answer.outside == answer.inside;
        let has_passable = has_coincident || answers[layout.sites.len()..].iter().any(is_passable);
        let mut mask = Mask::default();
        for (site, answer) in layout.sites.iter().zip(&answers) {
            // What is behind the surface of a light is not asked.
            if !is_passable(answer) || !is_refractor(scene, site.subject) {
                continue;
            }
            match &site.faces {
                Faces::Whole => primitives_of(&scene.geometry, site.subject).for_each(|face| mask.insert(face)),
                Faces::Some { faces, .. } => faces.iter().for_each(|&face| mask.insert(face)),
            }
        }
        let mut table = Self {
            answers,
            blocks,
            mask,
            has_passable,
            patches: Vec::new(),
            lights: Vec::new(),
            patch_of_site: Vec::new(),
            patch_of_group: Vec::new(),
            per_object,
            seconds,
            layout,
            votes,
        };
        table.list_patches(scene, &fillers);
        table.seconds.resolve = start.elapsed().as_secs_f64();
        table
    }

    /// The answer at a point of a refractor's surface; [`Answer::MASKED`] where the crossing is to be passed over.
    #[inline]
    pub fn look(&self, scene: &Scene, refractor: ObjectId, point: &SurfacePoint, barycentric: [f64; 2]) -> Answer {
        let place = self.place(refractor, point.primitive);
        if place & DIVIDED == 0 {
            self.answers[place as usize]
        } else {
            self.look_closely(scene, place, point, barycentric)
        }
    }

    /// In a divided face.
    #[inline(never)]
    fn look_closely(&self, scene: &Scene, place: Place, point: &SurfacePoint, barycentric: [f64; 2]) -> Answer {
        let layout = &*self.layout;
        let divided = layout.divided[(place & !DIVIDED) as usize];
        let (offset, weights) = cells::locate(scene, point, barycentric);
        match *cells::descend(&layout.nodes, divided.root + offset, weights) {
            Node::Known(answer) => self.answers[answer as usize],
            Node::Asked(number) => {
                let ask = &layout.asks[number as usize];
                match self.blocks[number as usize] {
                    NOT_LISTED => ask.answer(scene, point),
                    first => ask.look(scene, point).map_or(Answer::MASKED, |at| self.answers[first as usize + at]),
                }
            }
            // Leaves only.
            Node::Halves { .. } => Answer::MASKED,
        }
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
        self.place(refractor, primitive) & DIVIDED != 0
    }

    #[inline]
    fn place(&self, object: ObjectId, primitive: PrimitiveId) -> Place {
        match self.layout.place_of_object[object.0 as usize] {
            BY_FACE => self.layout.place_of_primitive[primitive as usize],
            place => place,
        }
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
        let place = match *self.layout.place_of_object.get(object as usize)? {
            BY_FACE => *self.layout.place_of_primitive.get(primitive as usize)?,
            place => place,
        };
        if place == BY_FACE {
            return None;
        }
        let number = if place & DIVIDED == 0 {
            self.patch_of_site[place as usize]
        } else {
            self.patch_of_group[self.layout.divided[(place & !DIVIDED) as usize].group as usize]
        };
        // Lights are numbered after the refractors' patches.
        match (number as usize).checked_sub(self.patches.len()) {
            None => self.patches.get(number as usize),
            Some(light) => self.lights.get(light),
        }
    }

    /// The patches of one refractor.
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
    pub fn per_object(&self, scene: &Scene) -> &ObjectTable {
        self.per_object.get_or_init(|| ObjectTable::new(scene))
    }

    /// The refractors that meet each other, and how.
    pub fn encounters(&self, scene: &Scene) -> Vec<Encounter> {
        encounters::encounters(scene, &self.layout, &self.votes)
    }

    /// The objects some of whose faces are crowded, with the numbers of those faces: see [`cells::Ask::is_crowded`].
    pub fn crowded(&self) -> Vec<(ObjectId, u32)> {
        let layout = &*self.layout;
        let mut found: Vec<(ObjectId, u32)> = Vec::new();
        for divided in &layout.divided {
            if let Node::Asked(ask) = layout.nodes[divided.root as usize]
                && layout.asks[ask as usize].is_crowded
            {
                let subject = layout.groups[divided.group as usize].subject;
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

    fn list_patches(&mut self, scene: &Scene, fillers: &[Fillers]) {
        let layout = Arc::clone(&self.layout);
        let votes = Arc::clone(&self.votes);
        // (subject, patches proper first, number of the site or group)
        let mut order: Vec<(ObjectId, bool, usize)> = (layout.sites.iter().enumerate())
            .map(|(number, site)| (site.subject, false, number))
            .chain(layout.groups.iter().enumerate().map(|(number, group)| (group.subject, true, number)))
            .collect();
        order.sort_unstable();
        self.patch_of_site = vec![0; layout.sites.len()];
        self.patch_of_group = vec![0; layout.groups.len()];
        let (mut patches, mut lights): (Vec<Patch>, Vec<Patch>) = (Vec::new(), Vec::new());
        for (subject, is_mixed, number) in order {
            // Lights come after all refractors in the order of object ids, so this numbers patches first, then lights.
            let list = if is_refractor(scene, subject) { &mut patches } else { &mut lights };
            let index = list.last().filter(|last| last.refractor == subject).map_or(0, |last| last.index + 1);
            let patch = if is_mixed {
                let group = &layout.groups[number];
                Patch {
                    refractor: subject,
                    index,
                    kind: PatchKind::Mixed,
                    faces: group.faces,
                    area: group.area,
                    outside: None,
                    inside: None,
                    outside_refractor: None,
                    inside_refractor: None,
                    crossed_by: group.members.clone(),
                    rays: 0,
                    confidence: 1.0,
                    votes: Arc::default(),
                    within: None,
                }
            } else {
                patch_of_site(scene, &layout.sites[number], &votes[number], fillers[number], index)
            };
            list.push(patch);
            let place = (patches.len() + lights.len() - 1) as u32;
            if is_mixed { self.patch_of_group[number] = place } else { self.patch_of_site[number] = place }
        }
        (self.patches, self.lights) = (patches, lights);
    }
}

fn patch_of_site(scene: &Scene, site: &Site, votes: &SiteVotes, fillers: Fillers, index: u32) -> Patch {
    let answer = Answer::of(scene, site.fixed.is_masked, fillers);
    let kind = match answer {
        Answer::MASKED => PatchKind::Masked,
        Answer { outside, inside } if outside == inside => PatchKind::Null,
        _ => PatchKind::Clear,
    };
    let is_masked = kind == PatchKind::Masked;
    let matters = |vote: &&Vote| {
        vote.share() < 1.0 && votes.surroundings_but_for(site, Some(vote.refractor)).resolve(scene) != answer
    };
    let confidence = votes.list.iter().filter(matters).map(Vote::share).fold(1.0, f64::min);
    Patch {
        refractor: site.subject,
        index,
        kind,
        faces: site.face_count(&scene.geometry),
        area: site.area(&scene.geometry),
        outside: (!is_masked).then_some(answer.outside),
        inside: (!is_masked && is_refractor(scene, site.subject)).then_some(answer.inside),
        outside_refractor: fillers.outer.filter(|_| !is_masked),
        inside_refractor: fillers.inner.filter(|_| !is_masked && is_refractor(scene, site.subject)),
        crossed_by: Vec::new(),
        rays: votes.rays,
        confidence,
        votes: Arc::clone(&votes.list),
        within: votes.within,
    }
}
