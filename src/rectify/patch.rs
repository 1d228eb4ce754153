//! Patches: parts of surfaces with the same surroundings, as users are told of them.

use std::sync::Arc;

use super::containment::Vote;
use super::layout::{Layout, MixedGroup};
use super::site::{Site, SiteVotes};
use super::surroundings::{Answer, Fillers};
use crate::scene::{MediumId, ObjectId, Scene};

named! {
    /// What kind of interface a patch is.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
    #[serde(rename_all = "lowercase")]
    pub enum PatchKind {
        /// One medium outside, another inside.
        Clear = "clear",
        /// The same medium on both sides, by identity and not by value: nothing is to be seen there.
        Null = "null",
        /// Other surfaces cross it: the answer differs from place to place.
        Mixed = "mixed",
        /// It coincides with another surface, which stands for both.
        Masked = "masked",
    }
}

impl PatchKind {
    pub const ALL: [Self; 4] = [Self::Clear, Self::Null, Self::Mixed, Self::Masked];
}

/// A part of a refractor's surface with the same surroundings everywhere, or the faces of it that the same refractors cross.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// The refractor; in [`super::InterfaceTable::lights`] the light.
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
    /// The innermost container, if the others are inherited from it: those have no votes here.
    pub within: Option<ObjectId>,
}

/// All patches.
#[derive(Debug, Clone, Default)]
pub(super) struct Patches {
    /// Sorted by refractor; within one, patches proper first, then mixed ones.
    pub refractors: Vec<Patch>,
    /// The same for lights.
    pub lights: Vec<Patch>,
    /// Number of the patch of each site and of each group of divided faces: refractors' patches first, then lights'.
    pub of_site: Vec<u32>,
    pub of_group: Vec<u32>,
}

/// Lists the patches of all sites and groups.
pub(super) fn list(scene: &Scene, layout: &Layout, votes: &[SiteVotes], fillers: &[Fillers]) -> Patches {
    // (subject, patches proper first, number of the site or group)
    let mut order: Vec<(ObjectId, bool, usize)> = (layout.sites.iter().enumerate())
        .map(|(number, site)| (site.subject, false, number))
        .chain(layout.groups.iter().enumerate().map(|(number, group)| (group.subject, true, number)))
        .collect();
    order.sort_unstable();
    let mut patches =
        Patches { of_site: vec![0; layout.sites.len()], of_group: vec![0; layout.groups.len()], ..Patches::default() };
    for (subject, is_mixed, number) in order {
        // Lights come after all refractors in the order of object ids, so this numbers patches first, then lights.
        let list = if scene.is_refractor(subject) { &mut patches.refractors } else { &mut patches.lights };
        let index = list.last().filter(|last| last.refractor == subject).map_or(0, |last| last.index + 1);
        let patch = if is_mixed {
            of_group(&layout.groups[number], index)
        } else {
            of_site(scene, &layout.sites[number], &votes[number], fillers[number], index)
        };
        list.push(patch);
        let last = (patches.refractors.len() + patches.lights.len() - 1) as u32;
        if is_mixed { patches.of_group[number] = last } else { patches.of_site[number] = last }
    }
    patches
}

/// A mixed patch.
fn of_group(group: &MixedGroup, index: u32) -> Patch {
    Patch {
        refractor: group.subject,
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
}

/// A patch proper, or a masked one.
fn of_site(scene: &Scene, site: &Site, votes: &SiteVotes, fillers: Fillers, index: u32) -> Patch {
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
        inside: (!is_masked && scene.is_refractor(site.subject)).then_some(answer.inside),
        outside_refractor: fillers.outer.filter(|_| !is_masked),
        inside_refractor: fillers.inner.filter(|_| !is_masked && scene.is_refractor(site.subject)),
        crossed_by: Vec::new(),
        rays: votes.rays,
        confidence,
        votes: Arc::clone(&votes.list),
        within: votes.within,
    }
}
