//! Refractors that overlap in part, coincide, or hide each other.

use std::collections::BTreeMap;

use super::rims::Rims;
use super::{Problem, distinct, names, samples};
use crate::rectify::PatchKind;
use crate::rectify::containment::{containment_beside, is_same_volume, medium_of, top};
use crate::rectify::copies::Copies;
use crate::rectify::encounters::{Encounter, Meeting};
use crate::scene::{ObjectId, Scene};
use crate::tracking::Prepared;

/// Ties among objects that overlap each other, directly or by way of others, are said pair by pair up to this number, and together beyond.
const MOST_PAIRS: usize = 4;

/// Points at which it is made sure that one object fills another.
const POINTS: u32 = 32;

pub(super) fn problems(prepared: &Prepared, encounters: &[Encounter], rims: &Rims) -> Vec<Problem> {
    let scene = &*prepared.scene;
    let pairs_of = |meeting| encounters.iter().filter(move |e| e.meeting == meeting).map(|e| (e.a, e.b));
    // Interfaces of one body have no volumes that could overlap.
    let are_joined = |a: ObjectId, b: ObjectId| rims.get(&a).is_some_and(|others| others.contains(&b));
    let ties: Vec<_> =
        pairs_of(Meeting::Overlap).filter(|&(a, b)| is_undecided(scene, a, b) && !are_joined(a, b)).collect();
    let alike = Copies::find(scene);
    let copies: Vec<_> =
        pairs_of(Meeting::Copy).filter(|&(a, b)| alike.are_alike(a, b) || is_filled(scene, a, b)).collect();
    let mut problems = Vec::new();
    for group in groups(&ties) {
        if group.len() <= MOST_PAIRS {
            problems.extend(group.into_iter().map(|(a, b)| tie(scene, a, b)));
        } else {
            problems.push(ties_of_many(scene, &group));
        }
    }
    problems.extend(groups(&copies).iter().map(|group| copy(scene, group)));
    problems.extend(scene.refractors().filter_map(|(refractor, _)| invisible(prepared, refractor)));
    problems
}

/// Pairs put together that are linked by objects in common, in the order of their first objects.
fn groups(pairs: &[(ObjectId, ObjectId)]) -> Vec<Vec<(ObjectId, ObjectId)>> {
    // The object that stands for the group of each, found through others (union and find, with halved paths).
    let mut parents: BTreeMap<ObjectId, ObjectId> = BTreeMap::new();
    fn root(parents: &mut BTreeMap<ObjectId, ObjectId>, mut id: ObjectId) -> ObjectId {
        while let Some(&parent) = parents.get(&id).filter(|parent| **parent != id) {
            let above = parents.get(&parent).copied().unwrap_or(parent);
            parents.insert(id, above);
            id = above;
        }
        id
    }
    for &(a, b) in pairs {
        let (a, b) = (root(&mut parents, a), root(&mut parents, b));
        parents.insert(a.max(b), a.min(b));
        parents.entry(a.min(b)).or_insert(a.min(b));
    }
    let mut found: BTreeMap<ObjectId, Vec<(ObjectId, ObjectId)>> = BTreeMap::new();
    for &(a, b) in pairs {
        found.entry(root(&mut parents, a)).or_default().push((a, b));
    }
    found.into_values().collect()
}

/// The objects of some pairs, each once, in ascending order.
fn members(pairs: &[(ObjectId, ObjectId)]) -> Vec<ObjectId> {
    distinct(pairs.iter().flat_map(|&(a, b)| [a, b]))
}

/// Whether two objects have equal priorities and different media, so that a tie decides what fills their overlap.
fn is_undecided(scene: &Scene, a: ObjectId, b: ObjectId) -> bool {
    let is_seamless = medium_of(scene, Some(a)) == medium_of(scene, Some(b));
    scene.priority(a) == scene.priority(b) && !is_seamless
}

/// What decides a tie.
fn reason(scene: &Scene, objects: &[ObjectId]) -> &'static str {
    let volumes = || objects.iter().map(|id| scene.object(*id).volume);
    if volumes().all(f64::is_infinite) {
        "the later one wins"
    } else if volumes().all(|volume| is_same_volume(volume, scene.object(objects[0]).volume)) {
        "their volumes are equal, so the later one wins"
    } else {
        "the smaller volume wins"
    }
}

fn tie(scene: &Scene, a: ObjectId, b: ObjectId) -> Problem {
    let [first, second] = [a, b].map(|id| &scene.object(id).name);
    let winner = top(scene, [a, b]).map_or("", |id| &scene.object(id).name);
    let reason = reason(scene, &[a, b]);
    let message = format!(
        "{first} and {second} overlap with equal priority: {reason}, here {winner}; set a priority to choose (higher wins)"
    );
    Problem::warning(format!("{first}, {second}"), "overlap_tie", message)
}

fn ties_of_many(scene: &Scene, pairs: &[(ObjectId, ObjectId)]) -> Problem {
    let objects = members(pairs);
    let (count, list, pairs) = (objects.len(), names::list_of(scene, &objects), pairs.len());
    let reason = reason(scene, &objects);
    let message = format!(
        "{count} objects, {list}, overlap each other in {pairs} pairs with equal priority: {reason}; set priorities to choose \
         (higher wins)"
    );
    Problem::warning(names::place_of(scene, &objects), "overlap_tie", message)
}

/// Whether, of two with the same surface, the one that wins does fill the other all along it.
fn is_filled(scene: &Scene, a: ObjectId, b: ObjectId) -> bool {
    let Some(winner) = top(scene, [a, b]) else { return false };
    let other = if winner == a { b } else { a };
    samples::of_surface(&scene.geometry, other.0, 0..POINTS)
        .all(|(point, _)| containment_beside(scene, &point, false).refractors.contains(&winner))
}

fn copy(scene: &Scene, pairs: &[(ObjectId, ObjectId)]) -> Problem {
    let objects = members(pairs);
    let winner = top(scene, objects.iter().copied());
    let others: Vec<ObjectId> = objects.iter().copied().filter(|id| Some(*id) != winner).collect();
    let (winner, list) = (winner.map_or("", |id| &scene.object(id).name), names::list_of(scene, &others));
    let (it, who) = if others.len() == 1 { ("it", "it") } else { ("them", "one of them") };
    Problem::warning(
        names::place_of(scene, &objects),
        "coincident",
        format!(
            "{} have the same surface at the same place: `{winner}` fills all of it, and {list} cannot be seen; remove {it}, or give a \
             higher priority to {who} and remove `{winner}`",
            names::list_of(scene, &objects),
        ),
    )
}

/// A refractor of which nothing is to be seen.
fn invisible(prepared: &Prepared, refractor: ObjectId) -> Option<Problem> {
    let scene = &*prepared.scene;
    let patches = prepared.table.patches_of(refractor);
    if patches.is_empty() || patches.iter().any(|patch| patch.kind != PatchKind::Null) {
        return None;
    }
    let name = &scene.object(refractor).name;
    let fills = distinct(patches.iter().filter_map(|patch| patch.inside_refractor).filter(|id| *id != refractor));
    if fills.is_empty() {
        let container = patches[0].outside_refractor.map_or("the world", |id| &scene.object(id).name);
        return Some(Problem::advice(
            name,
            "same_medium",
            format!("it is of the same medium as `{container}`, which surrounds it, and so cannot be seen"),
        ));
    }
    let highest = fills.iter().map(|id| scene.priority(*id)).max()?;
    let (has, fills) = (if fills.len() == 1 { "has" } else { "have" }, names::list_of(scene, &fills));
    Some(Problem::warning(
        name,
        "hidden",
        format!(
            "it cannot be seen: it lies wholly in {fills}, which {has} the higher priority. Give {name} a priority above {highest} (higher \
             wins)"
        ),
    ))
}
