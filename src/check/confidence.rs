//! Objects about whose surroundings the pre-trace's rays disagree. One finding for each object, however many of its patches are concerned.

use std::collections::BTreeMap;

use super::{Problem, Spot, distinct, names};
use crate::geometry::Enclosure;
use crate::rectify::Patch;
use crate::rectify::subjects::primitives_of;
use crate::scene::ObjectId;
use crate::tracking::Prepared;

/// Votes below this share of the rays are reported: the answer is doubtful, or the object has more than one surrounding.
const LEAST_CONFIDENCE: f64 = 0.9;

/// What is doubtful about one object.
pub(super) struct Doubt {
    /// What, how much of it, and how doubtful: one sentence.
    pub sentence: String,
    /// The refractors that rays disagree about, in ascending order.
    pub about: Vec<ObjectId>,
    /// The most doubtful patch; `None` where that is the whole object.
    pub spot: Option<Spot>,
}

/// By the object concerned.
pub(super) type Doubts = BTreeMap<ObjectId, Doubt>;

pub(super) fn doubts(prepared: &Prepared) -> Doubts {
    let is_doubtful = |patch: &&Patch| patch.confidence < LEAST_CONFIDENCE;
    (prepared.table.patches.chunk_by(|a, b| a.refractor == b.refractor))
        .filter_map(|patches| {
            let doubtful: Vec<&Patch> = patches.iter().filter(is_doubtful).collect();
            (!doubtful.is_empty()).then(|| (patches[0].refractor, doubt(prepared, patches.len(), &doubtful)))
        })
        .collect()
}

/// `doubtful`, at least one, of an object's `all` patches.
fn doubt(prepared: &Prepared, all: usize, doubtful: &[&Patch]) -> Doubt {
    let scene = &*prepared.scene;
    let worst = doubtful.iter().fold(doubtful[0], |a, b| if b.confidence < a.confidence { b } else { a });
    let spot = (all > 1).then(|| spot(prepared, worst));
    let votes: Vec<String> = (worst.votes.iter().filter(|vote| vote.share() < 1.0))
        .map(|vote| {
            let share = 100.0 * f64::from(vote.inside) / f64::from(vote.asked);
            format!("{share:.0} % of the rays find it in `{}`", scene.object(vote.refractor).name)
        })
        .collect();
    let all_votes = doubtful.iter().flat_map(|patch| patch.votes.iter());
    let about = distinct(all_votes.filter(|vote| vote.share() < 1.0).map(|vote| vote.refractor));
    let votes = votes.join(", ");
    let sentence = match (doubtful.len(), spot) {
        (_, None) => format!("what lies outside of it is doubtful: {votes}"),
        (1, Some(spot)) => {
            format!("what lies outside one of its {all} patches, {}, is doubtful: {votes}", names::near(spot.center))
        }
        (count, Some(spot)) => format!(
            "what lies outside {} of its {all} patches is doubtful, most so {}, where {votes}",
            if count == all { "all".to_owned() } else { count.to_string() },
            names::near(spot.center)
        ),
    };
    Doubt { sentence, about, spot }
}

/// Around the faces of a patch.
pub(super) fn spot(prepared: &Prepared, patch: &Patch) -> Spot {
    let geometry = &*prepared.scene.geometry;
    let is_of_patch = |face: &u32| {
        let found = prepared.table.patch_of(geometry, *face);
        found.is_some_and(|found| (found.refractor, found.index) == (patch.refractor, patch.index))
    };
    let corners = |face: u32| match geometry.sphere(face) {
        Some(sphere) => [sphere.center - sphere.radius, sphere.center + sphere.radius, sphere.center],
        None => geometry.corners(face),
    };
    let faces = primitives_of(geometry, patch.refractor).filter(is_of_patch);
    Spot::around(faces.flat_map(corners), geometry.origin)
}

/// One finding for each object in `doubts`.
pub(super) fn problems(prepared: &Prepared, doubts: &Doubts) -> Vec<Problem> {
    let scene = &*prepared.scene;
    (doubts.iter())
        .map(|(&object, doubt)| {
            let is_open = |id: &ObjectId| matches!(scene.object(*id).enclosure, Enclosure::Sheet | Enclosure::Holed);
            let open: Vec<ObjectId> = doubt.about.iter().copied().filter(is_open).collect();
            let advice = if open.is_empty() {
                "The surfaces lie closer together than can be told apart: let the volumes overlap, or move them apart"
                    .to_owned()
            } else {
                let (is, them) = if open.len() == 1 { ("is", "it") } else { ("are", "them") };
                format!("{} {is} not closed: close {them}", names::list_of(scene, &open))
            };
            let problem =
                Problem::warning(&scene.object(object).name, "low_confidence", format!("{}. {advice}", doubt.sentence));
            Problem { spot: doubt.spot, ..problem }
        })
        .collect()
}
