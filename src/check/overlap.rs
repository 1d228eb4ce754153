//! Refractors that overlap in part, coincide, or hide each other.

use super::Problem;
use crate::rectify::PatchKind;
use crate::rectify::containment::{medium_of, priority, top};
use crate::rectify::encounters::{Encounter, Meeting};
use crate::render::Prepared;
use crate::scene::World;
use crate::scene::world::ObjectId;

pub(super) fn problems(prepared: &Prepared) -> Vec<Problem> {
    let world = &*prepared.world;
    let mut problems: Vec<Problem> = (prepared.table.encounters(world).into_iter())
        .filter_map(|encounter| match encounter.meeting {
            Meeting::Overlap => tie(world, encounter),
            Meeting::Copy => Some(copy(world, encounter)),
            Meeting::Touch => None,
        })
        .collect();
    problems.extend(world.refractors().filter_map(|(refractor, _)| invisible(prepared, refractor)));
    problems
}

fn names(world: &World, Encounter { a, b, .. }: Encounter) -> [&str; 2] {
    [a, b].map(|id| world.object(id).name.as_str())
}

/// An overlap in part that nobody has decided.
fn tie(world: &World, encounter: Encounter) -> Option<Problem> {
    let Encounter { a, b, .. } = encounter;
    let is_seamless = medium_of(world, Some(a)) == medium_of(world, Some(b));
    if priority(world, a) != priority(world, b) || is_seamless {
        return None;
    }
    let [first, second] = names(world, encounter);
    let winner = top(world, [a, b]).map_or("", |id| &world.object(id).name);
    let reason = if world.object(a).volume.is_infinite() && world.object(b).volume.is_infinite() {
        "the later one wins"
    } else {
        "the smaller volume wins"
    };
    Some(Problem::warning(
        format!("{first}, {second}"),
        "overlap_tie",
        format!(
            "{first} and {second} overlap with equal priority: {reason}, here {winner}; set a priority to choose (higher wins)"
        ),
    ))
}

fn copy(world: &World, encounter: Encounter) -> Problem {
    let [first, second] = names(world, encounter);
    let winner = top(world, [encounter.a, encounter.b]).map_or("", |id| &world.object(id).name);
    Problem::warning(
        format!("{first}, {second}"),
        "coincident",
        format!(
            "{first} and {second} have the same surface at the same place: {winner} fills both, and the other cannot be seen; remove \
             one, or set a priority to choose (higher wins)"
        ),
    )
}

/// A refractor of which nothing is to be seen.
fn invisible(prepared: &Prepared, refractor: ObjectId) -> Option<Problem> {
    let world = &*prepared.world;
    let patches = prepared.table.patches_of(refractor);
    if patches.is_empty() || patches.iter().any(|patch| patch.kind != PatchKind::Null) {
        return None;
    }
    let name = &world.object(refractor).name;
    let fills = patches[0].inside_refractor?;
    if fills == refractor {
        let container = patches[0].outside_refractor.map_or("the world", |id| &world.object(id).name);
        return Some(Problem::advice(
            name,
            "same_medium",
            format!("it is of the same medium as `{container}`, which surrounds it, and so cannot be seen"),
        ));
    }
    let other = &world.object(fills).name;
    Some(Problem::warning(
        name,
        "hidden",
        format!(
            "it cannot be seen: it lies wholly in {other}, which has the higher priority and fills it. Give {name} a priority above {} \
             (higher wins)",
            priority(world, fills)
        ),
    ))
}
